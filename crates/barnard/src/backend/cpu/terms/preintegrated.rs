//! Intervals of wavelength: ⟨D⟩ = e^(−k_j a₀) T_j(Δ), a₀ in front of the segment, Δ its own depth.

use spectra::rule::Form;

use super::{Bases, DepthSpan};
use crate::packet::{LANES, Lane, exp, lanes};
use crate::plan::Plan;

/// One extinction for each term, one table for each light and term.
#[derive(Debug)]
pub struct PreintegratedTerms {
    k: Vec<f32>,
    tables: Vec<Vec<PreintegratedTable>>,
}

#[derive(Debug)]
struct PreintegratedTable {
    /// Entries per unit of the root of a depth.
    per_root: f32,
    mean: Vec<f32>,
}

impl PreintegratedTerms {
    pub(super) fn new(plan: &Plan) -> Self {
        let forms = || {
            plan.spectral.bands.iter().filter_map(|b| match &b.rule.form {
                Form::Preintegrated(p) => Some(p),
                _ => None,
            })
        };
        let table = |t: &spectra::rule::SegmentTable| PreintegratedTable {
            per_root: (1.0 / t.step) as f32,
            mean: t.mean.iter().map(|v| *v as f32).collect(),
        };
        let of_light = |light: usize| forms().flat_map(|p| p.tables[light].iter().map(table)).collect();
        Self { k: forms().flat_map(|p| p.k.iter().map(|k| *k as f32)).collect(), tables: (0..plan.lights.len()).map(of_light).collect() }
    }

    #[inline(always)]
    pub(super) fn accumulate(&self, light: usize, DepthSpan { middle, half }: &DepthSpan, bases: Bases, sum: &mut [Lane]) {
        let front = lanes!(|lane| middle[lane] - half[lane].abs());
        let root = lanes!(|lane| (2.0 * half[lane].abs()).sqrt());
        for (term, ((k, table), sum)) in self.k.iter().zip(&self.tables[light]).zip(sum).enumerate() {
            let Some(base) = bases.of(term) else { continue };
            for lane in 0..LANES {
                sum[lane] += base[lane] * exp(-k * front[lane]) * table.at(root[lane]);
            }
        }
    }

    pub(super) fn at(&self, term: usize, depth: f32) -> f32 {
        exp(-self.k[term] * depth)
    }
}

impl PreintegratedTable {
    #[inline(always)]
    fn at(&self, root: f32) -> f32 {
        let x = root * self.per_root;
        let i = (x as usize).min(self.mean.len() - 2);
        let f = (x - i as f32).min(1.0);
        self.mean[i] + f * (self.mean[i + 1] - self.mean[i])
    }
}
