//! Simplex noise in three dimensions.
//!
//! n(p) = 32 Σ_corners max(0, 0.6 − r²)⁴ (g · r), g one of the 12 edge directions of a cube picked by a hash of the
//! corner and the seed
//!
//! Integer hashing (no tables) gives the same noise on every platform. Range within [−1, 1].
//! Source: Perlin 2001; Gustavson 2005, "Simplex noise demystified"; the hash is Wellons' lowbias32 finaliser.

use glam::{DVec3, IVec3};

/// Simplex noise with a seed.
#[derive(Debug, Clone, Copy)]
pub struct Simplex {
    seed: u32,
}

const GRADIENTS: [[f64; 3]; 12] = [
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [-1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [-1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [-1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, -1.0, 1.0],
    [0.0, 1.0, -1.0],
    [0.0, -1.0, -1.0],
];

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
        // Skew to find the simplex, unskew to measure distances.
        let cell = (p + p.element_sum() / 3.0).floor();
        let first = p - (cell - cell.element_sum() / 6.0);
        let corner = cell.as_ivec3();
        let (second, third) = middle_corners(first);
        let term = |offset: IVec3, unskew: f64| self.corner(corner + offset, first - offset.as_dvec3() + unskew);
        32.0 * (term(IVec3::ZERO, 0.0) + term(second, 1.0 / 6.0) + term(third, 1.0 / 3.0) + term(IVec3::ONE, 0.5))
    }

    /// The contribution of one corner at distance `r`.
    fn corner(&self, corner: IVec3, r: DVec3) -> f64 {
        let falloff = 0.6 - r.length_squared();
        if falloff <= 0.0 {
            return 0.0;
        }
        let gradient = GRADIENTS[hash(corner, self.seed) as usize % GRADIENTS.len()];
        falloff.powi(2).powi(2) * DVec3::from(gradient).dot(r)
    }
}

/// The second and third corner of the simplex that holds offset `d`: steps along the largest, then the second largest
/// coordinate.
fn middle_corners(d: DVec3) -> (IVec3, IVec3) {
    let xy = d.x >= d.y;
    let yz = d.y >= d.z;
    let xz = d.x >= d.z;
    let second = IVec3::new((xy && xz) as i32, (!xy && yz) as i32, (!xz && !yz) as i32);
    let third = IVec3::new((xy || xz) as i32, (!xy || yz) as i32, (!xz || !yz) as i32);
    (second, third)
}

fn hash(p: IVec3, seed: u32) -> u32 {
    let mix = |h: u32| {
        let h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
        let h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
        h ^ (h >> 16)
    };
    mix(p.x as u32 ^ mix(p.y as u32 ^ mix(p.z as u32 ^ mix(seed))))
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
