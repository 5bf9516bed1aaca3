//! Polynomial spectra in closed form: F(a) = Σ cₙ [λ^(n+1) E_{n+2}(a c/λ)] at every segment, grey with the local mean extinction within it.
//!
//! In f32 where the powers of a wide passband keep their digits, in f64 where those of a narrow one cancel.

use spectra::polynomial::MAX_DEGREE;
use spectra::rule::{Analytic, Form};

use super::Course;
use crate::packet::{LANES, Lane, exp, lanes, mean_transmittance, scaled_exp_integrals};
use crate::plan::Plan;

/// One closed form for each light and band.
#[derive(Debug)]
pub struct AnalyticTerms {
    /// The bands in f64.
    bands: Vec<Analytic>,
    /// Light × band.
    sources: Vec<Vec<Source>>,
}

#[derive(Debug)]
enum Source {
    /// In f32.
    Single {
        /// At the upper end of the passband, and at the lower one with the other sign.
        ends: Vec<End>,
        /// (k, mass/F(0)) of lines.
        lines: Vec<(f32, f32)>,
    },
    /// In f64, by `bands`.
    Double,
    /// Nothing.
    Dark,
}

/// One end of a passband.
#[derive(Debug)]
struct End {
    /// c/λ.
    x_per_depth: f32,
    /// ± cₙ λ^(n+1)/F(0) of E_{n+2}, and ± c cₙ λⁿ/F(0) of E_{n+1}.
    factors: Vec<(f32, f32)>,
}

/// The rounding error of one term in f32.
const ROUNDING: f64 = 1e-6;
/// The part of the accuracy that rounding may cost.
const SHARE: f64 = 0.1;

impl AnalyticTerms {
    pub(super) fn new(plan: &Plan) -> Self {
        let of_band = |form: &Form| match form {
            Form::Analytic(analytic) => Some(analytic.clone()),
            _ => None,
        };
        let bands: Vec<Analytic> = plan.spectral.bands.iter().filter_map(|b| of_band(&b.rule.form)).collect();
        let accuracy = plan.spectral.accuracy;
        let of_light = |light: usize| bands.iter().map(|band| source(band, light, accuracy)).collect();
        let sources = (0..plan.lights.len()).map(of_light).collect();
        Self { bands, sources }
    }

    #[inline(always)]
    pub(super) fn gather(&self, light: usize, Course { middle, half }: &Course, base: impl Fn(usize) -> Option<Lane>, sum: &mut [Lane]) {
        for (term, (source, sum)) in self.sources[light].iter().zip(sum).enumerate() {
            let Some(base) = base(term) else { continue };
            let (value, slope) = self.values(source, light, term, middle);
            for lane in 0..LANES {
                let grey = if value[lane] > 0.0 { mean_transmittance(0.0, slope[lane] / value[lane] * half[lane]) } else { 1.0 };
                sum[lane] += base[lane] * value[lane] * grey;
            }
        }
    }

    pub(super) fn at(&self, light: usize, term: usize, depth: f32) -> f32 {
        self.values(&self.sources[light][term], light, term, &[depth; LANES]).0[0]
    }

    /// F/F(0) and −dF/da/F(0).
    #[inline(always)]
    fn values(&self, source: &Source, light: usize, term: usize, depth: &Lane) -> (Lane, Lane) {
        let (mut value, mut slope) = ([0.0; LANES], [0.0; LANES]);
        match source {
            Source::Single { ends, lines } => {
                for end in ends {
                    end.add(depth, &mut value, &mut slope);
                }
                for (k, mass) in lines {
                    for lane in 0..LANES {
                        let line = mass * exp(-k * depth[lane]);
                        value[lane] += line;
                        slope[lane] += k * line;
                    }
                }
            }
            Source::Double => {
                let band = &self.bands[term];
                let source = &band.sources[light];
                for lane in 0..LANES {
                    let (v, s) = source.at(band.c_um, f64::from(depth[lane]));
                    (value[lane], slope[lane]) = ((v / source.total) as f32, (s / source.total) as f32);
                }
            }
            Source::Dark => {}
        }
        (value, slope)
    }
}

impl End {
    #[inline(always)]
    fn add(&self, depth: &Lane, value: &mut Lane, slope: &mut Lane) {
        // E₁ is infinite at no depth at all.
        let x = lanes(|lane| {
            let x = depth[lane] * self.x_per_depth;
            if x > 1e-6 { x } else { 1e-6 }
        });
        let mut e = [[0.0; LANES]; MAX_DEGREE + 2];
        scaled_exp_integrals(&x, &mut e[..self.factors.len() + 1]);
        let (mut v, mut s) = ([0.0; LANES], [0.0; LANES]);
        for (n, (of_value, of_slope)) in self.factors.iter().enumerate() {
            for lane in 0..LANES {
                v[lane] += of_value * e[n + 1][lane];
                s[lane] += of_slope * e[n][lane];
            }
        }
        for lane in 0..LANES {
            let fall = exp(-x[lane]);
            value[lane] += fall * v[lane];
            slope[lane] += fall * s[lane];
        }
    }
}

fn source(band: &Analytic, light: usize, accuracy: f64) -> Source {
    let source = &band.sources[light];
    if source.total == 0.0 {
        return Source::Dark;
    }
    let polynomial = &source.fit.polynomial;
    if polynomial.cancellation() * ROUNDING > SHARE * accuracy {
        return Source::Double;
    }
    let (low, high) = polynomial.interval_um;
    let end = |lambda: f64, sign: f64| {
        let factor = |(n, c): (usize, &f64)| {
            let below = sign * c * lambda.powi(n as i32) / source.total;
            ((below * lambda) as f32, (below * band.c_um) as f32)
        };
        End { x_per_depth: (band.c_um / lambda) as f32, factors: polynomial.coefficients.iter().enumerate().map(factor).collect() }
    };
    // Nothing is left of e^(−g/λ) at λ = 0.
    let mut ends = vec![end(high, 1.0)];
    if low > 0.0 {
        ends.push(end(low, -1.0));
    }
    Source::Single { ends, lines: source.lines.iter().map(|(k, mass)| (*k as f32, (mass / source.total) as f32)).collect() }
}
