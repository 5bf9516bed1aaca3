//! Transmission at many extinctions in a few numbers: the principal components of exponentials, eq. (27) of
//! docs/method.md.
//!
//!   G(k_j)/G(k_0) ≈ m_j + Σ_t c_t v_tj,    G(k) = ∫ e^(−a k) dμ(a)
//!
//! G is the light behind any mixture μ of depths a, at extinctions k_0 < k_1 < …, of which the first has the most light left. The
//! parts G(k_j)/G(k_0) of single depths lie on a curve; m and the vectors v_t are the mean and the principal axes of its
//! points. Those of a mixture are a mean of such points: they lie in the hull of the curve, so that its errors and its
//! coordinates c_t are bounded by those of single depths. The errors of the axes fall faster than any power of their number.

use nalgebra::{DMatrix, SymmetricEigen};

/// Mean, axes and coordinates of what depths leave of light.
#[derive(Debug, Clone, PartialEq)]
pub struct Components {
    /// The mean m of the parts at each extinction \[1\].
    pub mean: Vec<f64>,
    /// The principal axes v, of length one, component × extinction.
    pub axes: Vec<Vec<f64>>,
    /// The least and the largest coordinate of each \[1\].
    pub ranges: Vec<[f64; 2]>,
    /// The largest error of a part at any extinction \[1\].
    pub error: f64,
}

/// Depths at least, and for each that the extinctions part by e.
const SAMPLES: usize = 256;
const FINER: f64 = 16.0;
const MOST: usize = 2048;
/// Rounding error of a coordinate, relative to its range.
const ROOM: f64 = 1e-4;

impl Components {
    /// The components of light behind depths up to `depth`, at ascending extinctions `k`, to an error of `accuracy` of the light at
    /// the first. `factors` are what light may be multiplied by at each extinction, such as a phase function under one angle;
    /// none where nothing is.
    pub fn of_exponentials(k: &[f64], depth: f64, factors: &[Vec<f64>], accuracy: f64) -> Self {
        let count = k.len();
        let samples = (SAMPLES + (FINER * depth * (k[count - 1] - k[0])) as usize).min(MOST);
        let plain = [vec![1.0; count]];
        let factors = if factors.is_empty() { &plain } else { factors };
        let parts: Vec<Vec<f64>> = factors
            .iter()
            .flat_map(|factor| (0..=samples).map(move |i| (factor, depth * i as f64 / samples as f64)))
            .map(|(factor, a)| k.iter().zip(factor).map(|(k_j, f)| f / factor[0] * (-a * (k_j - k[0])).exp()).collect())
            .collect();
        Self::of(&parts, accuracy)
    }

    /// The components of light whose parts G(k_j)/G(k_0) are those of some `parts`, one or more, to an error of `accuracy` of the light at
    /// the first extinction.
    pub fn of(parts: &[Vec<f64>], accuracy: f64) -> Self {
        let count = parts[0].len();
        let mean: Vec<f64> = (0..count).map(|j| parts.iter().map(|part| part[j]).sum::<f64>() / parts.len() as f64).collect();
        let mut rest = DMatrix::from_fn(parts.len(), count, |i, j| parts[i][j] - mean[j]);
        let eigen = SymmetricEigen::new(rest.transpose() * &rest);
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let mut components = Self { mean, axes: Vec::new(), ranges: Vec::new(), error: rest.amax() };
        for column in order {
            if components.error <= accuracy {
                break;
            }
            let axis = eigen.eigenvectors.column(column).into_owned();
            let coordinates = &rest * &axis;
            rest -= &coordinates * axis.transpose();
            let (low, high) = (coordinates.min(), coordinates.max());
            let room = ROOM * (high - low);
            components.axes.push(axis.iter().copied().collect());
            components.ranges.push([low - room, high + room]);
            components.error = rest.amax();
        }
        components
    }

    /// The coordinate of the mean, which those of a part are measured from.
    pub fn origin(&self, component: usize) -> f64 {
        self.axes[component].iter().zip(&self.mean).map(|(v, m)| v * m).sum()
    }

    /// What light whose weights at the extinctions are `weights` takes of G(k_0): that of the mean, and that of each coordinate.
    pub fn shares(&self, weights: &[f64]) -> (f64, Vec<f64>) {
        let dot = |row: &[f64]| weights.iter().zip(row).map(|(w, v)| w * v).sum::<f64>();
        (dot(&self.mean), self.axes.iter().map(|axis| dot(axis)).collect())
    }

    /// The coordinates of light with `parts` G(k_j)/G(k_0) at each extinction.
    pub fn coordinates(&self, parts: &[f64]) -> Vec<f64> {
        let from_mean = |axis: &Vec<f64>| axis.iter().zip(parts.iter().zip(&self.mean)).map(|(v, (part, m))| v * (part - m)).sum();
        self.axes.iter().map(from_mean).collect()
    }

    /// The largest error that coordinates make of the parts of light at any extinction \[1\].
    pub fn error_of(&self, parts: &[f64], coordinates: &[f64]) -> f64 {
        let value_of = |j: usize| self.mean[j] + self.axes.iter().zip(coordinates).map(|(axis, c)| axis[j] * c).sum::<f64>();
        parts.iter().enumerate().map(|(j, part)| (value_of(j) - part).abs()).fold(0.0, f64::max)
    }

    /// Widens the ranges so that they hold some coordinates.
    pub fn include(&mut self, coordinates: &[f64]) {
        for ([low, high], c) in self.ranges.iter_mut().zip(coordinates) {
            (*low, *high) = (low.min(*c), high.max(*c));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn k(count: usize) -> Vec<f64> {
        (0..count).map(|j| 0.45 + 1.35 * j as f64 / (count - 1) as f64).collect()
    }

    fn parts(k: &[f64], depths: &[(f64, f64)]) -> Vec<f64> {
        let light = |k: f64| depths.iter().map(|(a, mass)| mass * (-a * k).exp()).sum::<f64>();
        k.iter().map(|k_j| light(*k_j) / light(k[0])).collect()
    }

    /// Mixtures of depths that no sample has are as exact as is stated and lie within the ranges; components come one by one
    /// where more is asked, and one fewer is not enough.
    #[test]
    fn mixtures_are_within_the_error() {
        let k = k(40);
        let mixtures =
            [vec![(3.337, 1.0)], vec![(0.0, 1.0), (11.93, 5.0)], vec![(0.013, 1e-3), (7.77, 1.0), (2.1, 0.3)], vec![(12.0, 1.0)]];
        let mut counts = Vec::new();
        for accuracy in [1e-2, 1e-4, 1e-6] {
            let components = Components::of_exponentials(&k, 12.0, &[], accuracy);
            assert!(components.error <= accuracy);
            let mut worst = 0.0f64;
            for depths in &mixtures {
                let parts = parts(&k, depths);
                let coordinates = components.coordinates(&parts);
                for (c, [low, high]) in coordinates.iter().zip(&components.ranges) {
                    assert!(low <= c && c <= high);
                }
                for (j, part) in parts.iter().enumerate() {
                    let unit: Vec<f64> = (0..k.len()).map(|i| f64::from(u8::from(i == j))).collect();
                    let (of_mean, shares) = components.shares(&unit);
                    let value = of_mean + shares.iter().zip(&coordinates).map(|(s, c)| s * c).sum::<f64>();
                    worst = worst.max((value - part).abs());
                }
            }
            assert!(worst <= 1.05 * components.error + 1e-12 && worst > 1e-3 * components.error, "{worst:e} {:e}", components.error);
            counts.push(components.axes.len());
        }
        assert!(counts.windows(2).all(|pair| pair[0] < pair[1]) && counts[2] < 11, "{counts:?}");
    }

    /// Factors that differ with k need components that know them.
    #[test]
    fn factors_count() {
        let k = k(24);
        let grey = Components::of_exponentials(&k, 5.0, &[], 1e-4);
        let factors: Vec<Vec<f64>> = [2.0, 5.0, 8.0].iter().map(|g| k.iter().map(|k| 1.5 + (g * k).sin()).collect()).collect();
        let coloured = Components::of_exponentials(&k, 5.0, &factors, 1e-4);
        let parts: Vec<f64> = parts(&k, &[(1.3, 1.0)]).iter().zip(&factors[2]).map(|(part, f)| part * f / factors[2][0]).collect();
        let error = |components: &Components| {
            let coordinates = components.coordinates(&parts);
            let value = |j: usize| components.mean[j] + components.axes.iter().zip(&coordinates).map(|(axis, c)| axis[j] * c).sum::<f64>();
            (0..k.len()).map(|j| (value(j) - parts[j]).abs()).fold(0.0, f64::max)
        };
        assert!(error(&coloured) < 1.05e-4 && error(&grey) > 1e-3, "{:e} {:e}", error(&coloured), error(&grey));
    }

    /// Dust that takes the same of all light has one number.
    #[test]
    fn grey_light_needs_nothing() {
        let components = Components::of_exponentials(&[1.0; 8], 20.0, &[], 1e-6);
        assert!(components.axes.is_empty() && components.mean.iter().all(|m| (m - 1.0).abs() < 1e-12));
    }
}
