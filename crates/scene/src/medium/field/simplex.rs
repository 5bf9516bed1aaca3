//! Simplex noise in three dimensions.
//!
//! n(p) = 32 Σ_corners max(0, 0.6 − r²)⁴ (g · r), g one of the 12 edge directions of a cube picked by a hash of the
//! corner and the seed
//!
//! Integer hashing (no tables) gives the same noise on every platform. Range within [−1, 1].
//! Source: Perlin 2001; Gustavson 2005, "Simplex noise demystified"; the hash is Wellons' lowbias32 finaliser.

use glam::DVec3;

/// Simplex noise with a seed.
#[derive(Debug, Clone, Copy)]
pub struct Simplex {
    seed: u32,
}

/// Gradients: the first eight have a component of ±1 along x, the last eight of the others.
const GRADIENTS: u32 = 12;
/// 1.5 · 2⁵²: adding it rounds to an integer, which then stands in the low bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;

impl Simplex {
    /// The noise of a seed.
    pub fn new(seed: u32) -> Self {
        Self { seed }
    }

    /// The seed of this noise.
    pub fn seed(&self) -> u32 {
        self.seed
    }

    /// n(p) \[1\], within [−1, 1]; p in units of the noise's own scale.
    pub fn at(&self, p: DVec3) -> f64 {
        self.noise(p.to_array())
    }

    /// n(x, y, z) without a branch, so that a loop over places becomes as many lanes as the machine has.
    #[inline(always)]
    pub(super) fn noise(&self, [x, y, z]: [f64; 3]) -> f64 {
        // Skew to find the simplex, unskew to measure distances.
        let skew = (x + y + z) / 3.0;
        let cell = [(x + skew).floor(), (y + skew).floor(), (z + skew).floor()];
        let unskew = (cell[0] + cell[1] + cell[2]) / 6.0;
        let first = [x - (cell[0] - unskew), y - (cell[1] - unskew), z - (cell[2] - unskew)];
        let [second, third] = middle_corners(first);
        let term = |steps, unskew| self.corner(cell, first, steps, unskew);
        32.0 * (term([false; 3], 0.0) + term(second, 1.0 / 6.0) + term(third, 1.0 / 3.0) + term([true; 3], 0.5))
    }

    /// The contribution of the corner at these steps from the first, which lies at distance `first`.
    #[inline(always)]
    fn corner(&self, cell: [f64; 3], first: [f64; 3], steps: [bool; 3], unskew: f64) -> f64 {
        let at = |axis: usize| first[axis] - if steps[axis] { 1.0 } else { 0.0 } + unskew;
        let [x, y, z] = [at(0), at(1), at(2)];
        let corner = |axis: usize| ((cell[axis] + WHOLE).to_bits() as u32).wrapping_add(u32::from(steps[axis]));
        let falloff = 0.6 - (x * x + y * y + z * z);
        let falloff = if falloff > 0.0 { falloff } else { 0.0 };
        // The gradient lies along two of the axes.
        let gradient = hash([corner(0), corner(1), corner(2)], self.seed) % GRADIENTS;
        let a = if gradient < 8 { x } else { y };
        let b = if gradient < 4 { y } else { z };
        let a = if gradient & 1 == 0 { a } else { -a };
        let b = if gradient & 2 == 0 { b } else { -b };
        (falloff * falloff) * (falloff * falloff) * (a + b)
    }
}

/// The second and third corner of the simplex that holds offset `d`: steps along the largest, then the second largest
/// coordinate.
#[inline(always)]
fn middle_corners([x, y, z]: [f64; 3]) -> [[bool; 3]; 2] {
    let (xy, yz, xz) = (x >= y, y >= z, x >= z);
    [[xy & xz, !xy & yz, !xz & !yz], [xy | xz, !xy | yz, !xz | !yz]]
}

#[inline(always)]
fn hash([x, y, z]: [u32; 3], seed: u32) -> u32 {
    let mix = |h: u32| {
        let h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
        let h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
        h ^ (h >> 16)
    };
    mix(x ^ mix(y ^ mix(z ^ mix(seed))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounded_and_centred() {
        let noise = Simplex::new(7);
        let values: Vec<f64> = (0..40_000).map(|i| noise.at(DVec3::new(i as f64 * 0.137, i as f64 * 0.071, i as f64 * 0.0313))).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!(values.iter().all(|v| v.abs() <= 1.0) && mean.abs() < 0.03, "{mean}");
        assert!(values.iter().any(|v| *v > 0.6) && values.iter().any(|v| *v < -0.6));
    }

    /// The noise is continuous across the borders of its simplices.
    #[test]
    fn continuous() {
        let noise = Simplex::new(1);
        let step = 1e-5;
        for i in 0..100_000 {
            let p = DVec3::new(i as f64 * step * 3.0, 0.4 + i as f64 * step, 0.1);
            assert!((noise.at(p) - noise.at(p + DVec3::splat(step))).abs() < 20.0 * step);
        }
    }

    /// At a lattice corner every contribution vanishes (g · 0), whatever the seed.
    #[test]
    fn seeds_differ() {
        let p = DVec3::new(1.3, -2.7, 0.4);
        assert_ne!(Simplex::new(1).at(p), Simplex::new(2).at(p));
        assert_eq!(Simplex::new(3).at(DVec3::ZERO), 0.0);
    }
}
