//! The closed form of polynomial spectra in f32: what `analytic` reads at every sample.
//!
//!   F(a)/F(0) = Σ_ends ± Σ_n cₙ λ^(n+1)/F(0) E_{n+2}(a c/λ)  +  lines
//!
//! In f32 where the powers of a wide passband keep their digits; those of a narrow one cancel and need f64.

use spectra::rule::Analytic;

/// F/F(0) of one light in one band.
#[derive(Debug)]
pub enum ClosedForm {
    /// In f32.
    Single {
        /// At the upper end of the passband, and at the lower one with the other sign.
        ends: Vec<End>,
        /// (k, mass/F(0)) of lines.
        lines: Vec<(f32, f32)>,
    },
    /// Only in f64.
    Double,
    /// Nothing.
    Dark,
}

/// One end of a passband.
#[derive(Debug)]
pub struct End {
    /// c/λ.
    pub x_per_depth: f32,
    /// ± cₙ λ^(n+1)/F(0) of E_{n+2}, and ± c cₙ λⁿ/F(0) of E_{n+1}.
    pub factors: Vec<(f32, f32)>,
}

/// The rounding error of one term in f32.
const ROUNDING: f64 = 1e-6;
/// The part of the accuracy that rounding may cost.
const SHARE: f64 = 0.1;

impl ClosedForm {
    /// Of light `light` in `band`.
    pub fn new(band: &Analytic, light: usize, accuracy: f64) -> Self {
        let source = &band.sources[light];
        if source.total == 0.0 {
            return ClosedForm::Dark;
        }
        let polynomial = &source.fit.polynomial;
        if polynomial.cancellation() * ROUNDING > SHARE * accuracy {
            return ClosedForm::Double;
        }
        let (low, high) = polynomial.interval_um;
        let end = |lambda: f64, sign: f64| {
            let factor = |(n, c): (usize, &f64)| {
                let below = sign * c * lambda.powi(n as i32) / source.total;
                ((below * lambda) as f32, (below * band.c_um) as f32)
            };
            End { x_per_depth: (band.c_um / lambda) as f32, factors: polynomial.coefficients.iter().enumerate().map(factor).collect() }
        };
        // Nothing is left of e^(−g/λ) at λ = 0.
        let mut ends = vec![end(high, 1.0)];
        if low > 0.0 {
            ends.push(end(low, -1.0));
        }
        ClosedForm::Single { ends, lines: source.lines.iter().map(|(k, mass)| (*k as f32, (mass / source.total) as f32)).collect() }
    }
}
