//! Polynomial spectra in closed form: F(a) = Σ cₙ [λ^(n+1) E_{n+2}(a c/λ)] at every segment, grey with the local mean extinction within it.
//!
//! In f32 where `plan::ClosedForm` keeps its digits, in f64 elsewhere.

use spectra::polynomial::MAX_DEGREE;
use spectra::rule::{Analytic, Form};

use super::Course;
use crate::packet::{LANES, Lane, exp, lanes, mean_transmittance, scaled_exp_integrals};
use crate::plan::{ClosedForm, End, Plan};

/// One closed form for each light and band.
#[derive(Debug)]
pub struct AnalyticTerms {
    /// The bands in f64.
    bands: Vec<Analytic>,
    /// Light × band.
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
    fn values(&self, source: &ClosedForm, light: usize, term: usize, depth: &Lane) -> (Lane, Lane) {
        let (mut value, mut slope) = ([0.0; LANES], [0.0; LANES]);
        match source {
            ClosedForm::Single { ends, lines } => {
                for end in ends {
                    add(end, depth, &mut value, &mut slope);
                }
                for (k, mass) in lines {
                    for lane in 0..LANES {
                        let line = mass * exp(-k * depth[lane]);
                        value[lane] += line;
                        slope[lane] += k * line;
                    }
                }
            }
            ClosedForm::Double => {
                let band = &self.bands[term];
                let source = &band.sources[light];
                for lane in 0..LANES {
                    let (v, s) = source.at(band.c_um, f64::from(depth[lane]));
                    (value[lane], slope[lane]) = ((v / source.total) as f32, (s / source.total) as f32);
                }
            }
            ClosedForm::Dark => {}
        }
        (value, slope)
    }
}

/// Adds what one end of a passband gives.
#[inline(always)]
fn add(end: &End, depth: &Lane, value: &mut Lane, slope: &mut Lane) {
    // E₁ is infinite at no depth at all.
    let x = lanes(|lane| {
        let x = depth[lane] * end.x_per_depth;
        if x > 1e-6 { x } else { 1e-6 }
    });
    let mut e = [[0.0; LANES]; MAX_DEGREE + 2];
    scaled_exp_integrals(&x, &mut e[..end.factors.len() + 1]);
    let (mut v, mut s) = ([0.0; LANES], [0.0; LANES]);
    for (n, (of_value, of_slope)) in end.factors.iter().enumerate() {
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
