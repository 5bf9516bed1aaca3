//! Extinction of Cardelli, Clayton & Mathis 1989 with R_V.
//!
//! k(λ) = a(x) + b(x)/R_V,  x = 1/λ  (their eq. 1)
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | x | `x` | µm⁻¹ |
//! | R_V | `r_v` | 1 |
//!
//! Valid for 0.3 ≤ x ≤ 10 µm⁻¹ and 2 ≤ R_V ≤ 6. Source: ApJ 345, 245, eqs. 2a–5b, 10.1086/167900.

use super::{ExtinctionLaw, LawEntry, Maker, polynomial};
use crate::fingerprint::Digest;

pub(super) const ENTRY: LawEntry = LawEntry {
    name: "ccm89",
    summary: "Cardelli, Clayton & Mathis 1989 with R_V 2 to 6; 0.1 to 3.33 um",
    maker: Maker::RatioOfV { low: 2.0, high: 6.0, make: |r_v| Box::new(Ccm89 { r_v, optical: OPTICAL }) },
};

/// Coefficients of a(y) and b(y), y = x − 1.82, highest power first (eq. 3).
pub(super) type Optical = (&'static [f64], &'static [f64]);

const OPTICAL: Optical = (
    &[0.32999, -0.77530, 0.01979, 0.72085, -0.02427, -0.50447, 0.17699, 1.0],
    &[-2.09002, 5.30260, -0.62251, -5.38434, 1.07233, 2.28305, 1.41338, 0.0],
);

/// The CCM89 form with its optical polynomials, which O'Donnell replaced.
#[derive(Debug)]
pub(super) struct Ccm89 {
    pub r_v: f64,
    pub optical: Optical,
}

impl ExtinctionLaw for Ccm89 {
    fn content(&self, digest: &mut Digest) {
        digest.text("ccm89").number(self.r_v);
    }
    fn k(&self, lambda_um: f64) -> f64 {
        let x = 1.0 / lambda_um;
        let (a, b) = match x {
            x if x < 1.1 => (0.574 * x.powf(1.61), -0.527 * x.powf(1.61)),
            x if x < 3.3 => (polynomial(self.optical.0, x - 1.82), polynomial(self.optical.1, x - 1.82)),
            x if x <= 8.0 => ultraviolet(x),
            x => (polynomial(&[-0.070, 0.137, -0.628, -1.073], x - 8.0), polynomial(&[0.374, -0.420, 4.257, 13.670], x - 8.0)),
        };
        a + b / self.r_v
    }
    fn range_um(&self) -> (f64, f64) {
        (0.1, 1.0 / 0.3)
    }
    fn breakpoints_um(&self) -> Vec<f64> {
        [8.0, 5.9, 3.3, 1.1].map(|x| 1.0 / x).to_vec()
    }
}

/// The coefficients a(x), b(x) with the bump at 4.6 µm⁻¹ (eq. 4).
fn ultraviolet(x: f64) -> (f64, f64) {
    let y = (x - 5.9).max(0.0);
    let f_a = -0.04473 * y.powi(2) - 0.009779 * y.powi(3);
    let f_b = 0.2130 * y.powi(2) + 0.1207 * y.powi(3);
    let a = 1.752 - 0.316 * x - 0.104 / ((x - 4.67).powi(2) + 0.341) + f_a;
    let b = -3.090 + 1.825 * x + 1.206 / ((x - 4.62).powi(2) + 0.263) + f_b;
    (a, b)
}

#[cfg(test)]
mod tests {
    use crate::extinction::Extinction;

    /// Table 3 of the paper, R_V = 3.1 (A(λ)/A(V), two to three printed digits).
    #[test]
    fn printed_table() {
        let law = Extinction::with_r_v("ccm89", Some(3.1)).unwrap();
        for (lambda_um, printed) in
            [(0.36, 1.569), (0.44, 1.337), (0.55, 1.0), (0.70, 0.751), (0.90, 0.479), (1.25, 0.282), (1.60, 0.190), (2.20, 0.114)]
        {
            assert!((law.k(lambda_um) - printed).abs() < 0.022, "{lambda_um}: {} {printed}", law.k(lambda_um));
        }
    }
}
