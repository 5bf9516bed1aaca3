//! The closed form of polynomial spectra in f32: what `analytic` reads at every sample.
//!
//!   F(a)/F(0) = Σ_ends ± Σ_n cₙ λ^(n+1)/F(0) E_{n+2}(a c/λ)  +  lines
//!
//! with its slope, by E_{n+1}, and its integral over all depths from there on, by E_{n+3}.
//!
//! In f32 where the powers of a wide passband keep their digits; those of a narrow one cancel and need f64.

use spectra::rule::Analytic;

/// F/F(0) of one light in one band.
#[derive(Debug)]
pub enum ClosedForm {
    /// A closed form that single precision serves.
    Single {
        /// The form at the upper end of the passband, and at the lower one with the other sign.
        ends: Vec<End>,
        /// The (k, mass/F(0)) of each line.
        lines: Vec<(f32, f32)>,
        /// The extinctions of the passband.
        extent: Extent,
    },
    /// A closed form that needs double precision.
    Double,
    /// A light that sends nothing through the band.
    Dark,
}

/// The range of extinctions in a passband.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Half the difference between the largest k and the smallest \[1\].
    pub spread: f32,
    /// The extinction k in the middle of its wavelengths \[1\].
    pub middle: f32,
}

impl Extent {
    /// Half a segment's depth times the spread of k up to which it is grey: what is left out is no more than single
    /// precision loses of exponential integrals.
    pub const GREY: f32 = 5e-3;
    /// Half a segment's depth times k up to which it is thin, and two points of Gauss serve the logarithm of its light
    /// as well.
    pub const THIN: f32 = 0.25;
}

/// The closed form at one end of a passband.
#[derive(Debug)]
pub struct End {
    /// The argument c/λ of the exponential integrals for a depth of one.
    pub x_per_depth: f32,
    /// ± cₙ λ^(n+1)/F(0) of E_{n+2}, ± c cₙ λⁿ/F(0) of E_{n+1}, and ± cₙ λ^(n+2)/(c F(0)) of E_{n+3}.
    pub factors: Vec<[f32; 3]>,
}

/// The rounding error of one term in f32.
const ROUNDING: f64 = 1e-6;
/// The part of the accuracy that rounding may cost.
const SHARE: f64 = 0.1;

impl ClosedForm {
    /// The closed form of light number `light` through `band`.
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
                [below * lambda, below * band.c_um, below * lambda * lambda / band.c_um].map(|v| v as f32)
            };
            End { x_per_depth: (band.c_um / lambda) as f32, factors: polynomial.coefficients.iter().enumerate().map(factor).collect() }
        };
        // Nothing is left of e^(−g/λ) at λ = 0.
        let mut ends = vec![end(high, 1.0)];
        if low > 0.0 {
            ends.push(end(low, -1.0));
        }
        let extent = Extent { spread: source.spread(band.c_um) as f32, middle: (2.0 * band.c_um / (low + high)) as f32 };
        ClosedForm::Single { ends, lines: source.lines.iter().map(|(k, mass)| (*k as f32, (mass / source.total) as f32)).collect(), extent }
    }
}
