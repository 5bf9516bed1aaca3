//! Extinction of Fitzpatrick 1999 with R_V.
//!
//! λ < 0.27 µm: k = 1 + FM90(x)/R_V with c₂ = −0.824 + 4.717/R_V, c₁ = 2.030 − 3.007 c₂, c₃ = 3.23, c₄ = 0.41;
//! else a natural cubic spline in x = 1/λ through the anchors of table 4.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | x | `x` | µm⁻¹ |
//! | R_V | `r_v` | 1 |
//!
//! Valid for 0.3 ≤ x ≤ 10 µm⁻¹ and 2 ≤ R_V ≤ 6. Source: PASP 111, 63, 10.1086/316293. The sign of the last optical
//! anchor (1.208) follows the author's later code: the printed −1.208 does not reproduce his own table 3.

use super::fitzpatrick_massa90::FitzpatrickMassa;
use super::{ExtinctionLaw, LawEntry, Maker};
use crate::fingerprint::Digest;

pub(super) const ENTRY: LawEntry = LawEntry {
    name: "fitzpatrick99",
    summary: "Fitzpatrick 1999 with R_V 2 to 6; 0.1 to 3.33 um",
    maker: Maker::RatioOfV { low: 2.0, high: 6.0, make: |r_v| Box::new(Fitzpatrick99::new(r_v)) },
};

/// The wavenumber at which the ultraviolet form takes over [µm⁻¹].
const ULTRAVIOLET_X: f64 = 1.0 / 0.27;

#[derive(Debug)]
struct Fitzpatrick99 {
    r_v: f64,
    ultraviolet: FitzpatrickMassa,
    spline: NaturalSpline,
}

impl Fitzpatrick99 {
    fn new(r_v: f64) -> Self {
        let c2 = -0.824 + 4.717 / r_v;
        let ultraviolet = FitzpatrickMassa { c: [2.030 - 3.007 * c2, c2, 3.23, 0.41], centre: 4.596, width: 0.99 };
        let x = [0.0, 1.0 / 2.65, 1.0 / 1.22, 1.0 / 0.6, 1.0 / 0.547, 1.0 / 0.467, 1.0 / 0.411, ULTRAVIOLET_X, 1.0 / 0.26];
        let y = [
            0.0,
            0.265 / 3.1,
            0.829 / 3.1,
            -0.426 / r_v + 1.0044,
            -0.050 / r_v + 1.0016,
            0.701 / r_v + 1.0016,
            1.208 / r_v + 1.0032 - 0.00033 * r_v,
            1.0 + ultraviolet.at(x[7]) / r_v,
            1.0 + ultraviolet.at(x[8]) / r_v,
        ];
        Self { r_v, ultraviolet, spline: NaturalSpline::through(&x, &y) }
    }
}

impl ExtinctionLaw for Fitzpatrick99 {
    fn content(&self, digest: &mut Digest) {
        digest.text("fitzpatrick99").number(self.r_v);
    }
    fn k(&self, lambda_um: f64) -> f64 {
        let x = 1.0 / lambda_um;
        if x >= ULTRAVIOLET_X { 1.0 + self.ultraviolet.at(x) / self.r_v } else { self.spline.at(x) }
    }
    fn range_um(&self) -> (f64, f64) {
        (0.1, 1.0 / 0.3)
    }
    fn breakpoints_um(&self) -> Vec<f64> {
        vec![1.0 / 5.9, 0.27]
    }
}

/// A cubic spline with zero second derivative at both ends.
#[derive(Debug)]
struct NaturalSpline {
    x: Vec<f64>,
    y: Vec<f64>,
    curvature: Vec<f64>,
}

impl NaturalSpline {
    fn through(x: &[f64], y: &[f64]) -> Self {
        let n = x.len();
        let matrix = nalgebra::DMatrix::from_fn(n, n, |i, j| {
            let inner = i > 0 && i + 1 < n;
            match (inner, i.abs_diff(j)) {
                (false, 0) => 1.0,
                (true, 0) => (x[i + 1] - x[i - 1]) / 3.0,
                (true, 1) => (x[i.max(j)] - x[i.min(j)]) / 6.0,
                _ => 0.0,
            }
        });
        let slope = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
        let right = nalgebra::DVector::from_fn(n, |i, _| if i > 0 && i + 1 < n { slope(i) - slope(i - 1) } else { 0.0 });
        // The matrix is diagonally dominant, so the solution exists.
        let curvature = matrix.lu().solve(&right).map(|v| v.iter().copied().collect()).unwrap_or_else(|| vec![0.0; n]);
        Self { x: x.to_vec(), y: y.to_vec(), curvature }
    }

    fn at(&self, x: f64) -> f64 {
        let i = self.x.partition_point(|v| *v <= x).clamp(1, self.x.len() - 1);
        let h = self.x[i] - self.x[i - 1];
        let (a, b) = ((self.x[i] - x) / h, (x - self.x[i - 1]) / h);
        let bend = (a.powi(3) - a) * self.curvature[i - 1] + (b.powi(3) - b) * self.curvature[i];
        a * self.y[i - 1] + b * self.y[i] + bend * h * h / 6.0
    }
}

#[cfg(test)]
mod tests {
    use crate::extinction::Extinction;

    /// Table 3 of the paper for R_V = 3.1: A(λ)/E(B−V) = 0.265, 0.829, 2.688, 3.055, 3.806, 4.315 at the anchors.
    #[test]
    fn printed_table() {
        let law = Extinction::with_r_v("fitzpatrick99", Some(3.1)).unwrap();
        for (lambda_um, printed) in
            [(2.65, 0.265), (1.22, 0.829), (0.6, 2.688), (0.547, 3.055), (0.467, 3.806), (0.411, 4.315), (0.27, 6.265), (0.26, 6.591)]
        {
            assert!((law.k(lambda_um) * 3.1 - printed).abs() < 1.1e-3, "{lambda_um}: {}", law.k(lambda_um) * 3.1);
        }
    }
}
