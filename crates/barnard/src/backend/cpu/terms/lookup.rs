//! Tables of ln F: in a segment the medium is grey with the local mean extinction.

use spectra::rule::Form;

use super::Course;
use crate::packet::{LANES, Lane, exp, mean_transmittance};
use crate::plan::Plan;

/// A table for each light and band.
#[derive(Debug)]
pub struct LookupTerms {
    tables: Vec<Vec<LogTable>>,
}

/// ln (F(a)/F(0)) at equal steps.
#[derive(Debug, Clone)]
struct LogTable {
    /// Entries per unit of depth.
    per_depth: f32,
    /// The logarithms.
    log: Vec<f32>,
}

impl LookupTerms {
    pub(super) fn new(plan: &Plan) -> Self {
        let table = |light: usize, form: &Form| match form {
            Form::Lookup(lookup) => {
                let t = &lookup.tables[light];
                LogTable { per_depth: (1.0 / t.step) as f32, log: t.log.iter().map(|v| *v as f32).collect() }
            }
            _ => LogTable { per_depth: 1.0, log: vec![0.0; 2] },
        };
        let of_light = |light: usize| plan.spectral.bands.iter().map(|b| table(light, &b.rule.form)).collect();
        Self { tables: (0..plan.lights.len()).map(of_light).collect() }
    }

    #[inline(always)]
    pub(super) fn gather(&self, light: usize, Course { middle, half }: &Course, base: impl Fn(usize) -> Option<Lane>, sum: &mut [Lane]) {
        for (term, (table, sum)) in self.tables[light].iter().zip(sum).enumerate() {
            let Some(base) = base(term) else { continue };
            for lane in 0..LANES {
                let (log, slope) = table.at(middle[lane]);
                sum[lane] += base[lane] * mean_transmittance(0.0, slope * half[lane]) * exp(log);
            }
        }
    }

    #[inline(always)]
    pub(super) fn at(&self, light: usize, term: usize, depth: f32) -> f32 {
        exp(self.tables[light][term].at(depth).0)
    }
}

impl LogTable {
    /// ln F and its slope −d ln F/da at depth `a`.
    #[inline(always)]
    fn at(&self, a: f32) -> (f32, f32) {
        let x = a * self.per_depth;
        let i = (x as usize).min(self.log.len() - 2);
        let rise = self.log[i + 1] - self.log[i];
        (self.log[i] + (x - i as f32) * rise, -rise * self.per_depth)
    }
}
