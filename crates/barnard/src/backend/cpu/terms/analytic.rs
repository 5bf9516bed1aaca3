//! Polynomial spectra in closed form: F(a) = Σ cₙ [λ^(n+1) E_{n+2}(a c/λ)] at every segment. Within a thin one, or one
//! in whose passband k hardly differs, light falls as in a grey medium; in a thick one the closed form is that of its
//! integral.
//!
//! In f32 where `plan::ClosedForm` keeps its digits, in f64 elsewhere.

use spectra::polynomial::MAX_DEGREE;
use spectra::rule::{self, Analytic, Form};

use super::{Bases, DepthSpan};
use crate::packet::{LANES, Lane, exp, lanes, largest, ln, mean_transmittance, scaled_exp_integrals, sinhc};
use crate::plan::{ClosedForm, End, Extent, Plan};

/// 1/√3: where the two points of Gauss lie.
const GAUSS: f32 = 0.577_350_26;

/// One closed form for each light and band.
#[derive(Debug)]
pub struct AnalyticTerms {
    /// The bands as `spectra` solved them, for sources that need double precision.
    bands: Vec<Analytic>,
    /// The closed form of each source \[light\]\[band\].
    sources: Vec<Vec<ClosedForm>>,
}

impl AnalyticTerms {
    pub(super) fn new(plan: &Plan) -> Self {
        let of_band = |form: &Form| match form {
            Form::Analytic(analytic) => Some(analytic.clone()),
            _ => None,
        };
        let bands: Vec<Analytic> = plan.spectral.bands.iter().filter_map(|b| of_band(&b.rule.form)).collect();
        let accuracy = plan.spectral.accuracy;
        let of_light = |light: usize| bands.iter().map(|band| ClosedForm::new(band, light, accuracy)).collect();
        let sources = (0..plan.lights.len()).map(of_light).collect();
        Self { bands, sources }
    }

    #[inline(always)]
    pub(super) fn accumulate(&self, light: usize, span: &DepthSpan, bases: Bases, sum: &mut [Lane]) {
        for (term, (source, sum)) in self.sources[light].iter().zip(sum).enumerate() {
            let Some(base) = bases.of(term) else { continue };
            let mean = self.mean(source, light, term, span);
            for lane in 0..LANES {
                sum[lane] += base[lane] * mean[lane];
            }
        }
    }

    /// F/F(0) of one term at one depth. It is asked once a ray: where it was inlined, the march compiled for many
    /// minutes.
    #[inline(never)]
    pub(super) fn at(&self, light: usize, term: usize, depth: f32) -> f32 {
        self.mean(&self.sources[light][term], light, term, &DepthSpan { middle: [depth; LANES], half: [0.0; LANES] })[0]
    }

    /// The mean of F/F(0) over a span of depths.
    #[inline(always)]
    fn mean(&self, source: &ClosedForm, light: usize, term: usize, span: &DepthSpan) -> Lane {
        match source {
            ClosedForm::Single { ends, lines, extent } => mean(ends, lines, extent, span),
            ClosedForm::Double => {
                let Analytic { c_um, sources, .. } = &self.bands[term];
                let (source, depth) = (&sources[light], |v: f32| f64::from(v));
                let ends = |lane: usize| rule::DepthSpan {
                    from: depth(span.middle[lane] - span.half[lane]),
                    to: depth(span.middle[lane] + span.half[lane]),
                };
                lanes!(|lane| (source.mean(*c_um, ends(lane)) / source.total) as f32)
            }
            ClosedForm::Dark => [0.0; LANES],
        }
    }
}

/// ⟨F/F(0)⟩ of a light that single precision serves: grey, by two points, or by what is left behind both ends.
#[inline(always)]
fn mean(ends: &[End], lines: &[(f32, f32)], extent: &Extent, DepthSpan { middle, half }: &DepthSpan) -> Lane {
    let half = lanes!(|lane| half[lane].abs());
    let most = largest(&half);
    let grey = most * extent.spread <= Extent::GREY;
    let thin = most * extent.middle <= Extent::THIN;
    // Where the closed form is asked, from the middle in halves: there alone, at the points of Gauss, and at both ends.
    let (places, asked) = if grey { ([0.0; 4], 1) } else { ([-GAUSS, GAUSS, -1.0, 1.0], if thin { 2 } else { 4 }) };
    let mut at = [AttenuationRow { value: [0.0; LANES], slope: [0.0; LANES], left: [0.0; LANES] }; 4];
    for (at, place) in at.iter_mut().zip(places).take(asked) {
        *at = attenuated(ends, lines, &lanes!(|lane| middle[lane] + place * half[lane]));
    }
    let of_lane = |lane: usize| {
        if grey {
            let (value, slope) = (at[0].value[lane], at[0].slope[lane]);
            let y = if value > 0.0 { slope / value * half[lane] } else { 0.0 };
            return value * mean_transmittance(0.0, y);
        }
        if half[lane] * extent.middle > Extent::THIN {
            return (at[2].left[lane] - at[3].left[lane]) / (2.0 * half[lane]);
        }
        let (front, back) = (at[0].value[lane], at[1].value[lane]);
        if front <= 0.0 || back <= 0.0 {
            return 0.5 * (front + back);
        }
        let y = 0.5 / GAUSS * ln(front / back);
        (front * back).sqrt() * sinhc(y * y)
    };
    lanes!(|lane| of_lane(lane))
}

/// F/F(0), −dF/da/F(0) and ∫ F/F(0) da from there on.
#[derive(Debug, Clone, Copy)]
struct AttenuationRow {
    value: Lane,
    slope: Lane,
    left: Lane,
}

#[inline(always)]
fn attenuated(ends: &[End], lines: &[(f32, f32)], depth: &Lane) -> AttenuationRow {
    let mut sum = AttenuationRow { value: [0.0; LANES], slope: [0.0; LANES], left: [0.0; LANES] };
    for end in ends {
        add(end, depth, &mut sum);
    }
    for (k, mass) in lines {
        for lane in 0..LANES {
            let line = mass * exp(-k * depth[lane]);
            sum.value[lane] += line;
            sum.slope[lane] += k * line;
            sum.left[lane] += line / k;
        }
    }
    sum
}

/// Adds what one end of a passband gives.
#[inline(always)]
fn add(end: &End, depth: &Lane, sum: &mut AttenuationRow) {
    // E₁ is infinite at no depth at all.
    let x = lanes!(|lane| {
        let x = depth[lane] * end.x_per_depth;
        if x > 1e-6 { x } else { 1e-6 }
    });
    let mut e = [[0.0; LANES]; MAX_DEGREE + 3];
    scaled_exp_integrals(&x, &mut e[..end.factors.len() + 2]);
    let fall = lanes!(|lane| exp(-x[lane]));
    for (n, [of_value, of_slope, of_left]) in end.factors.iter().enumerate() {
        for lane in 0..LANES {
            sum.value[lane] += fall[lane] * of_value * e[n + 1][lane];
            sum.slope[lane] += fall[lane] * of_slope * e[n][lane];
            sum.left[lane] += fall[lane] * of_left * e[n + 2][lane];
        }
    }
}
