//! A Gaussian: jitter of the guiding, diffusion of charge, or a first guess.
//!
//!   G ∝ 2^(−4 r²/w²),   w = w₀ (λ/λ₀)^q

use std::sync::Arc;

use spectra::units::{Angle, Wavelength};

use super::{OpticsView, PointSpread, round};
use crate::error::Result;
use crate::image::convolution::Kernel;
use crate::properties::{Key, Kind, Number, OrDefault, Required};

const FWHM: Key<Angle, Required> = Key::quantity::<Angle>("fwhm", "full width at half maximum at `wavelength`").positive().required();
const WAVELENGTH: Key<Wavelength, OrDefault> = Key::quantity::<Wavelength>("wavelength", "where `fwhm` holds").positive().default("550 nm");
const EXPONENT: Key<Number, OrDefault> = Key::number("exponent", "exponent of the width in wavelength").range(-2.0..=2.0).default(0.0);

pub(super) const KIND: Kind<Arc<dyn PointSpread>> = Kind {
    name: "gaussian",
    summary: "a Gaussian, for guiding jitter, charge diffusion, or a first estimate",
    keys: &[FWHM.row, WAVELENGTH.row, EXPONENT.row],
    build: |section, _| {
        Ok(Arc::new(Gaussian {
            fwhm_rad: section.read(&FWHM)?.0,
            wavelength_um: section.read(&WAVELENGTH)?.0,
            exponent: section.read(&EXPONENT)?,
        }))
    },
};

/// A Gaussian profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian {
    /// The full width at half maximum w₀ \[rad\].
    pub fwhm_rad: f64,
    /// λ₀ \[µm\].
    pub wavelength_um: f64,
    /// q.
    pub exponent: f64,
}

impl Default for Gaussian {
    /// An arcsecond at all wavelengths.
    fn default() -> Self {
        Self { fwhm_rad: std::f64::consts::PI / 648_000.0, wavelength_um: 0.55, exponent: 0.0 }
    }
}

impl PointSpread for Gaussian {
    fn kernel(&self, view: &OpticsView) -> Result<Option<Kernel>> {
        let wavelength = view.band.pivot_um.unwrap_or(self.wavelength_um);
        let fwhm = self.fwhm_rad * (wavelength / self.wavelength_um).powf(self.exponent);
        Ok(round(view, fwhm, |square| (-4.0 * square).exp2()))
    }

    fn description(&self) -> String {
        let Self { fwhm_rad, wavelength_um, exponent } = self;
        format!("Gaussian of {} at {}, exponent {exponent}", Angle(*fwhm_rad), Wavelength(*wavelength_um))
    }
}
