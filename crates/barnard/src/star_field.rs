//! The classes of the stars of a star field: black bodies of a few temperatures.

use std::sync::Arc;

use spectra::passband::Passband;
use spectra::sed::{BlackBody, MagnitudeSystem, zero_point};
use spectra::spectrum::Spectrum;
use spectra::units::Temperature;

use crate::error::Result;

/// A class of field stars: black bodies of one temperature, V = 0 (Vega).
pub struct FieldClass {
    /// The name in certificates.
    pub name: String,
    /// Irradiance of magnitude zero [W m⁻² µm⁻¹].
    pub spectrum: Spectrum,
}

/// Temperature \[K\] and part of the stars.
pub const CLASSES: [(f64, f64); 6] = [(3600.0, 0.22), (4500.0, 0.28), (5600.0, 0.25), (6800.0, 0.14), (9500.0, 0.08), (18000.0, 0.03)];

/// The classes, in order.
///
/// # Errors
/// Where Vega's flux is not known through V, which a test rules out.
pub fn field_classes() -> Result<Vec<FieldClass>> {
    let v = Passband::named("johnson-V")?;
    let flux = zero_point(&v, MagnitudeSystem::Vega)?;
    CLASSES
        .iter()
        .map(|(t, _)| {
            let shape = BlackBody(Temperature(*t));
            let scale = flux / v.integrate(|l| spectra::spectrum::Shape::at(&shape, l));
            Ok(FieldClass { name: format!("field stars of {t} K"), spectrum: Spectrum::continuous(scale, Arc::new(shape)) })
        })
        .collect()
}
