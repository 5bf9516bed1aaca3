//! Black bodies.
//!
//! B_λ(T) = (2hc²/λ⁵) / (exp(hc/(λ k_B T)) − 1)
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | λ | `lambda_um` | µm |
//! | T | `temperature` | K |
//!
//! `exp_m1` replaces exp − 1, for long waves. Source: Planck 1901; constants CODATA 2018.

use crate::constants::{BOLTZMANN, PLANCK, SPEED_OF_LIGHT};
use crate::fingerprint::Digest;
use crate::spectrum::Shape;
use crate::units::Temperature;

/// Planck radiance B_λ(T) [W m⁻² sr⁻¹ µm⁻¹].
pub fn planck(lambda_um: f64, temperature: Temperature) -> f64 {
    let lambda = lambda_um * 1e-6;
    let x = PLANCK * SPEED_OF_LIGHT / (lambda * BOLTZMANN * temperature.0);
    if !(0.0..700.0).contains(&x) {
        return 0.0;
    }
    2.0 * PLANCK * SPEED_OF_LIGHT.powi(2) / lambda.powi(5) / x.exp_m1() * 1e-6
}

/// The Planck function as a shape [W m⁻² sr⁻¹ µm⁻¹].
#[derive(Debug, Clone, Copy)]
pub struct BlackBody(pub Temperature);

impl Shape for BlackBody {
    fn content(&self, digest: &mut Digest) {
        digest.plain(self);
    }
    fn at(&self, lambda_um: f64) -> f64 {
        planck(lambda_um, self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::STEFAN_BOLTZMANN;
    use crate::quadrature::integrate;

    /// The integral π ∫ B_λ dλ is σ T⁴, and Wien's law λ_max T = 2897.772 µm K holds (CODATA 2018).
    #[test]
    fn stefan_boltzmann_and_wien() {
        for t in [300.0, 5772.0, 40000.0] {
            let temperature = Temperature(t);
            let sum = integrate(|u: f64| planck(u.exp(), temperature) * u.exp(), (1.0 / t).ln(), (1e7 / t).ln(), 1e-12);
            assert!((std::f64::consts::PI * sum / (STEFAN_BOLTZMANN * t.powi(4)) - 1.0).abs() < 1e-7, "{t}");
            let peak = 2897.771955 / t;
            assert!(planck(peak, temperature) > planck(peak * 1.001, temperature));
            assert!(planck(peak, temperature) > planck(peak * 0.999, temperature));
        }
    }
}
