//! Exponentials: ⟨D⟩ = e^(−k ā) sinh(k y)/(k y).

use spectra::rule::Form;

use super::{Bases, DepthSpan};
use crate::packet::{LANES, Lane, SERIES_LIMIT, exp, fma, lanes, largest, mean_transmittance, sinhc};
use crate::plan::Plan;

/// One extinction for each term, shared by all lights.
#[derive(Debug)]
pub struct NodeTerms {
    /// The extinction relative to V of each term [1].
    pub k: Vec<f32>,
    /// The smallest and the largest extinction of any term [1].
    pub range: (f32, f32),
}

impl NodeTerms {
    pub(super) fn new(plan: &Plan) -> Self {
        let of_band = |form: &Form| match form {
            Form::Nodes(nodes) => nodes.nodes.iter().map(|n| n.k as f32).collect(),
            _ => Vec::new(),
        };
        Self::of(plan.spectral.bands.iter().flat_map(|b| of_band(&b.rule.form)).collect())
    }

    /// Terms, each of a given extinction.
    pub(super) fn of(k: Vec<f32>) -> Self {
        let range = k.iter().fold((f32::MAX, f32::MIN_POSITIVE), |(low, high), k| (low.min(*k), high.max(*k)));
        Self { k, range }
    }

    #[inline(always)]
    pub(super) fn accumulate(&self, DepthSpan { middle, half }: &DepthSpan, bases: Bases, sum: &mut [Lane]) {
        let gentle = largest(&lanes!(|lane| half[lane].abs())) * self.range.1 <= SERIES_LIMIT;
        for (term, (k, sum)) in self.k.iter().zip(sum).enumerate() {
            let Some(base) = bases.of(term) else { continue };
            if gentle {
                for lane in 0..LANES {
                    let y = k * half[lane];
                    sum[lane] = fma(base[lane] * sinhc(y * y), exp(-k * middle[lane]), sum[lane]);
                }
            } else {
                for lane in 0..LANES {
                    sum[lane] += base[lane] * mean_transmittance(k * middle[lane], k * half[lane]);
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn at(&self, term: usize, depth: f32) -> f32 {
        exp(-self.k[term] * depth)
    }
}
