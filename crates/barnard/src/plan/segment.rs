//! Closed forms on one segment of a ray.
//!
//! In a segment τ and τ_ℓ are linear, so with a = τ + τ_ℓ at its ends a₀, a₁, mean ā and half difference y = (a₁ − a₀)/2
//!
//!   ∫ e^(−k a) ds/Δs = e^(−k ā) sinh(k y)/(k y)
//!
//! which is (e^(−k a₀) − e^(−k a₁))/(k (a₁ − a₀)) without its cancellation. A star at distance b from the ray, its foot at t = 0, gives
//!
//!   ∫ dt/(b² + t²)/Δt = atan2(b Δt, b² + t₀ t₁)/(b Δt)
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | a₀, a₁ | `from`, `to` | 1 |
//! | b, t₀, t₁ | `distance`, `from`, `to` | pc |

/// Mean of e^(−a) over a linear a [1]; never larger than its larger end.
pub fn mean_transmittance(from: f64, to: f64) -> f64 {
    let y = 0.5 * (to - from);
    if y.abs() < 0.5 {
        let y2 = y * y;
        return (-0.5 * (from + to)).exp() * (1.0 + y2 / 6.0 * (1.0 + y2 / 20.0 * (1.0 + y2 / 42.0 * (1.0 + y2 / 72.0))));
    }
    ((-from).exp() - (-to).exp()) / (to - from)
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
    fn transmittance_is_its_integral() {
        for (from, to) in [(0.0, 0.0), (0.1, 0.1 + 1e-9), (0.0, 0.9), (2.0, 1.3), (0.0, 40.0), (30.0, 0.0)] {
            let truth = integrate(|u| (-(from + u * (to - from))).exp(), 0.0, 1.0, 1e-13);
            assert!((mean_transmittance(from, to) / truth - 1.0).abs() < 1e-9, "{from} {to}");
        }
    }

    #[test]
    fn inverse_square_is_its_integral() {
        for (b, from, to) in [(1.0, -3.0, 2.0), (0.01, -0.5, 0.5), (2.0, 100.0, 101.0), (1e-3, 0.2, 0.3), (5.0, 1.0, 1.0 + 1e-7)] {
            let truth = integrate(|t| 1.0 / (b * b + t * t), from, to, 1e-12) / (to - from);
            assert!((mean_inverse_square(b, from, to) / truth - 1.0).abs() < 1e-6, "{b} {from} {to}");
        }
    }

    /// No step size makes light from nothing.
    #[test]
    fn never_more_than_the_brighter_end() {
        for i in 0..200 {
            for j in 0..200 {
                let (a, b) = (0.3 * i as f64, 0.37 * j as f64);
                assert!(mean_transmittance(a, b) <= (-a.min(b)).exp() * (1.0 + 1e-12));
            }
        }
    }
}
