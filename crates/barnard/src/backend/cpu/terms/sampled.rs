//! Random wavelengths: every ray has its own k and its own weight W/p for each term.

use spectra::rule::{Form, Sampled};

use super::{Bases, DepthSpan};
use crate::packet::{LANES, Lane, exp, mean_transmittance};
use crate::plan::Plan;
use crate::random::Counter;

/// The distributions of all bands.
#[derive(Debug)]
pub struct SampledTerms {
    bands: Vec<Sampled>,
    lights: usize,
}

/// The wavelengths that the rays of a packet drew.
#[derive(Debug, Default)]
pub struct Drawn {
    /// The extinction relative to V of each term on each lane [1].
    k: Vec<Lane>,
    /// W/p relative to F(0), light × term.
    ratio: Vec<Vec<Lane>>,
}

/// The seed of all draws: the same picture every time.
const SEED: u64 = 1;

impl SampledTerms {
    pub(super) fn new(plan: &Plan) -> Self {
        let of_band = |form: &Form| match form {
            Form::Sampled(sampled) => Some(sampled.clone()),
            _ => None,
        };
        let bands = plan.spectral.bands.iter().filter_map(|b| of_band(&b.rule.form)).collect();
        Self { bands, lights: plan.lights.len() }
    }

    pub(super) fn draw(&self, numbers: &[u64; LANES]) -> Drawn {
        let terms: usize = self.bands.iter().map(|b| b.count).sum();
        let mut drawn = Drawn { k: vec![[0.0; LANES]; terms], ratio: vec![vec![[0.0; LANES]; terms]; self.lights] };
        for (lane, number) in numbers.iter().enumerate() {
            let mut random = Counter::new(SEED, *number);
            let samples = self.bands.iter().flat_map(|band| (0..band.count).map(move |j| (band, j)));
            for (term, (band, j)) in samples.enumerate() {
                let i = band.draw(j, random.uniform());
                drawn.k[term][lane] = band.k.get(i).map_or(0.0, |k| *k as f32);
                for (light, ratio) in drawn.ratio.iter_mut().enumerate() {
                    ratio[term][lane] = band.ratio[light].get(i).map_or(0.0, |r| *r as f32);
                }
            }
        }
        drawn
    }
}

impl Drawn {
    #[inline(always)]
    pub(super) fn accumulate(&self, light: usize, DepthSpan { middle, half }: &DepthSpan, bases: Bases, sum: &mut [Lane]) {
        for (term, ((k, ratio), sum)) in self.k.iter().zip(&self.ratio[light]).zip(sum).enumerate() {
            let Some(base) = bases.of(term) else { continue };
            for lane in 0..LANES {
                sum[lane] += base[lane] * ratio[lane] * mean_transmittance(k[lane] * middle[lane], k[lane] * half[lane]);
            }
        }
    }

    pub(super) fn at(&self, light: usize, lane: usize, term: usize, depth: f32) -> f32 {
        self.ratio[light][term][lane] * exp(-self.k[term][lane] * depth)
    }
}
