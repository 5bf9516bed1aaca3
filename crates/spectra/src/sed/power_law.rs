//! Power laws: (λ/λ₀)^α.

use crate::spectrum::Shape;
use crate::units::Wavelength;

/// (λ/λ₀)^α, one at λ₀.
#[derive(Debug, Clone, Copy)]
pub struct PowerLaw {
    /// λ₀.
    pub reference: Wavelength,
    /// α \[1\].
    pub exponent: f64,
}

impl Shape for PowerLaw {
    fn at(&self, lambda_um: f64) -> f64 {
        (lambda_um / self.reference.0).powf(self.exponent)
    }
}
