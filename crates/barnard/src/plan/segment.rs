//! The light of a star on one segment of a ray, in closed form.
//!
//! A star at distance b from the ray, its foot at t = 0, gives in a segment from t₀ to t₁
//!
//!   ∫ dt/(b² + t²)/Δt = atan2(b Δt, b² + t₀ t₁)/(b Δt)                   eq. (6) of docs/method.md
//!
//! (what light falls by in a segment is `spectra::rule::mean_transmittance`).
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | b, t₀, t₁ | `distance`, `from`, `to` | pc |

use spectra::rule::DepthSpan;

/// A segment of a ray, and the optical depth at V along it.
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    /// Distance at which it begins \[pc\].
    pub from: f64,
    /// Distance at which it ends \[pc\].
    pub to: f64,
    /// Optical depth before it \[1\].
    pub tau: f64,
    /// The growth of that depth within it \[1\].
    pub growth: f64,
}

impl Segment {
    /// The length of the segment \[pc\].
    pub fn length(&self) -> f64 {
        self.to - self.from
    }

    /// Depths at its ends \[1\].
    pub fn depths(&self) -> DepthSpan {
        DepthSpan { from: self.tau, to: self.tau + self.growth }
    }
}

/// Mean of 1/(b² + t²) over [`from`, `to`] [pc⁻²].
pub fn mean_inverse_square(distance: f64, from: f64, to: f64) -> f64 {
    let length = to - from;
    let product = distance * distance + from * to;
    let x = distance * length;
    if product > 0.0 && x < 1e-4 * product {
        // atan x/x with x = bΔt/(b² + t₀t₁) → 1
        return (1.0 - (x / product).powi(2) / 3.0) / product;
    }
    x.atan2(product) / x
}

#[cfg(test)]
mod tests {
    use spectra::quadrature::integrate;

    use super::*;

    #[test]
    fn inverse_square_is_its_integral() {
        for (b, from, to) in [(1.0, -3.0, 2.0), (0.01, -0.5, 0.5), (2.0, 100.0, 101.0), (1e-3, 0.2, 0.3), (5.0, 1.0, 1.0 + 1e-7)] {
            let truth = integrate(|t| 1.0 / (b * b + t * t), from, to, 1e-12) / (to - from);
            assert!((mean_inverse_square(b, from, to) / truth - 1.0).abs() < 1e-6, "{b} {from} {to}");
        }
    }
}
