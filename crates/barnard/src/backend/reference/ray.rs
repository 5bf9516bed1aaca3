//! The radiance that grows along a ray: cells are bisected until the (G3, K7) pair agrees.
//!
//! Source: Kronrod 1965; Piessens et al. 1983 (QUADPACK) for the form of the pair and its estimate of the error.

use super::{RayConstants, ReferenceWave};

/// The growing radiance of one ray.
pub(super) struct RayRadiance<'a> {
    truth: &'a RayConstants<'a>,
    /// The radiance so far, band by band [W m⁻² sr⁻¹].
    pub bands: Vec<f64>,
}

/// (G3, K7) on [−1, 1]: abscissa, Kronrod weight, Gauss weight.
const PAIR: [(f64, f64, f64); 7] = [
    (-0.960_491_268_708_020_3, 0.104_656_226_026_467_27, 0.0),
    (-0.774_596_669_241_483_4, 0.268_488_089_868_333_44, 5.0 / 9.0),
    (-0.434_243_749_346_802_56, 0.401_397_414_775_962_2, 0.0),
    (0.0, 0.450_916_538_658_474_14, 8.0 / 9.0),
    (0.434_243_749_346_802_56, 0.401_397_414_775_962_2, 0.0),
    (0.774_596_669_241_483_4, 0.268_488_089_868_333_44, 5.0 / 9.0),
    (0.960_491_268_708_020_3, 0.104_656_226_026_467_27, 0.0),
];

const MAX_LEVEL: usize = 20;
/// The part of a pixel's allowed error that one cell may have: cells are some hundreds, their errors of either sign.
const CELL_SHARE: f64 = 0.1;

impl<'a> RayRadiance<'a> {
    pub fn new(truth: &'a RayConstants<'a>) -> Self {
        Self { truth, bands: vec![0.0; truth.scene.bands.len()] }
    }

    /// Adds to each wavelength what `value` gives for it.
    pub fn add(&mut self, value: impl Fn(&ReferenceWave) -> f64) {
        for wave in &self.truth.waves {
            self.bands[wave.band] += value(wave);
        }
    }

    /// Adds ∫ f(t, λ) over all cells.
    pub fn adapt(&mut self, cells: impl Iterator<Item = (f64, f64)>, f: impl Fn(f64, &ReferenceWave) -> f64) {
        self.adapt_sampled(cells, |t| t, |t, wave| f(*t, wave));
    }

    /// Adds ∫ f(sample(x), λ) over all cells, bisecting each until its two rules agree in every band.
    pub fn adapt_sampled<S>(
        &mut self,
        cells: impl Iterator<Item = (f64, f64)>,
        sample: impl Fn(f64) -> S,
        f: impl Fn(&S, &ReferenceWave) -> f64,
    ) {
        for (a, b) in cells {
            let mut pending = vec![(a, b, 0)];
            while let Some((a, b, level)) = pending.pop() {
                if self.truth.control.interrupted() {
                    return;
                }
                let (kronrod, gauss) = self.rules(a, b, &sample, &f);
                if level < MAX_LEVEL && !self.agree(&kronrod, &gauss) {
                    let middle = 0.5 * (a + b);
                    pending.extend([(middle, b, level + 1), (a, middle, level + 1)]);
                } else {
                    self.bands.iter_mut().zip(kronrod).for_each(|(s, v)| *s += v);
                }
            }
        }
    }

    /// Evaluates both rules of the pair on one cell, band by band.
    fn rules<S>(&self, a: f64, b: f64, sample: &impl Fn(f64) -> S, f: &impl Fn(&S, &ReferenceWave) -> f64) -> (Vec<f64>, Vec<f64>) {
        let (centre, half) = (0.5 * (a + b), 0.5 * (b - a));
        let (mut kronrod, mut gauss) = (vec![0.0; self.bands.len()], vec![0.0; self.bands.len()]);
        for (x, wk, wg) in PAIR {
            let s = sample(centre + half * x);
            for wave in &self.truth.waves {
                let value = half * f(&s, wave);
                kronrod[wave.band] += wk * value;
                gauss[wave.band] += wg * value;
            }
        }
        (kronrod, gauss)
    }

    /// True if the Kronrod sum is exact enough, by QUADPACK's estimate (200 |K − G|/K)^1.5.
    fn agree(&self, kronrod: &[f64], gauss: &[f64]) -> bool {
        kronrod.iter().zip(gauss).zip(&self.bands).all(|((k, g), so_far)| {
            let ratio = (200.0 * (k - g).abs() / k.abs().max(f64::MIN_POSITIVE)).min(1.0);
            ratio.powf(1.5) * k.abs() <= CELL_SHARE * self.truth.accuracy * so_far.max(k.abs())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// K7 is exact to degree 11, G3 to degree 5.
    #[test]
    fn the_pair_is_exact_for_polynomials() {
        for degree in 0..=11 {
            let truth = if degree % 2 == 0 { 2.0 / (degree + 1) as f64 } else { 0.0 };
            let sum = |pick: fn(&(f64, f64, f64)) -> f64| PAIR.iter().map(|p| pick(p) * p.0.powi(degree)).sum::<f64>();
            assert!((sum(|p| p.1) - truth).abs() < 1e-14, "{degree}");
            assert!(degree > 5 || (sum(|p| p.2) - truth).abs() < 1e-14, "{degree}");
        }
    }
}
