//! Power laws: (λ/λ₀)^α.

use crate::fingerprint::Digest;
use crate::spectrum::Shape;
use crate::units::Wavelength;

/// A power law (λ/λ₀)^α, one at λ₀.
#[derive(Debug, Clone, Copy)]
pub struct PowerLaw {
    /// The wavelength λ₀ at which it is one.
    pub reference: Wavelength,
    /// The exponent α \[1\].
    pub exponent: f64,
}

impl Shape for PowerLaw {
    fn content(&self, digest: &mut Digest) {
        digest.plain(self);
    }
    fn at(&self, lambda_um: f64) -> f64 {
        (lambda_um / self.reference.0).powf(self.exponent)
    }
}
