//! Emitting gas: its density, its spectrum and its velocity.

use std::sync::Arc;

use spectra::fingerprint::{Digest, Fingerprint};
use spectra::spectrum::Spectrum;
use spectra::units::Velocity;

use crate::error::{Error, Result};
use crate::field::{Field, IntoField, fingerprint};

/// A species of emitting gas.
#[derive(Debug, Clone)]
pub struct Emission {
    /// Name in certificates.
    pub name: String,
    /// Density, in any unit.
    pub density: Arc<dyn Field>,
    /// Emission coefficient of density 1 [W m⁻³ sr⁻¹ µm⁻¹, lines W m⁻³ sr⁻¹].
    pub spectrum: Spectrum,
    /// Velocity, which shifts the lines; `None` for gas at rest.
    pub motion: Option<Motion>,
}

impl Emission {
    /// Gas of a `density` in any unit, with the emission coefficient `spectrum` of density 1 [W m⁻³ sr⁻¹ µm⁻¹, lines
    /// W m⁻³ sr⁻¹].
    pub fn new(density: impl IntoField, spectrum: Spectrum) -> Self {
        Self { name: "emission".into(), density: density.into_field(), spectrum, motion: None }
    }

    /// Copy of the species under another name.
    #[must_use]
    pub fn with_name(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Copy of the species in motion.
    #[must_use]
    pub fn with_motion(self, motion: Motion) -> Self {
        Self { motion: Some(motion), ..self }
    }

    /// Fingerprint of density, spectrum and motion.
    pub(super) fn fingerprint(&self) -> Fingerprint {
        let Self { name, density, spectrum, motion } = self;
        let mut digest = Digest::new("emission");
        digest.text(name).part(fingerprint(&**density)).part(spectrum.fingerprint());
        Motion::content(motion.as_ref(), &mut digest);
        digest.finish()
    }

    /// Refuses spectra that no gas has.
    pub(super) fn check(&self) -> Result<()> {
        if let Some(lambda) = self.spectrum.first_negative_um() {
            return Err(Error::out_of_range("spectrum", format!("negative at {:.2} nm", lambda * 1e3), "at least zero"));
        }
        if !self.spectrum.is_light() {
            return Err(Error::out_of_range("spectrum", format!("not finite for {}", self.name), "finite"));
        }
        Ok(())
    }
}

/// Velocity of gas.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Components along x, y and z \[km s⁻¹\], of either sign.
    pub components: [Arc<dyn Field>; 3],
    /// Resolution of velocities \[km s⁻¹\].
    pub step: f64,
}

impl Motion {
    /// Motion with velocity components in km/s, resolved in steps.
    pub fn new(components: [impl IntoField; 3], step: Velocity) -> Self {
        Self { components: components.map(IntoField::into_field), step: step.0 }
    }

    /// Adds the content of a motion to a fingerprint.
    pub(super) fn content(motion: Option<&Self>, digest: &mut Digest) {
        if let Some(Self { components, step }) = motion {
            components.iter().fold(digest.number(*step), |digest, component| digest.part(fingerprint(&**component)));
        }
    }
}
