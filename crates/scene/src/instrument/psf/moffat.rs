//! Seeing: what the air makes of a point in a long exposure.
//!
//!   M ∝ (1 + r²/a²)^−β,   a = w/(2 √(2^(1/β) − 1)),   w = w₀ (λ/λ₀)^q
//!
//! (Moffat 1969, A&A 3, 455; β = 4.765 of turbulence: Trujillo et al. 2001, MNRAS 328, 977; q = −0.2 of Kolmogorov's). Validity: λ the
//! passband's pivot.

use std::sync::Arc;

use spectra::units::{Angle, Wavelength};

use super::{OpticsView, PointSpread, round};
use crate::error::Result;
use crate::image::convolution::Kernel;
use crate::properties::{Key, Kind, Number, OrDefault, Required};

const FWHM: Key<Angle, Required> = Key::quantity::<Angle>("fwhm", "full width at half maximum at `wavelength`").positive().required();
const BETA: Key<Number, OrDefault> = Key::number("beta", "exponent of the wings").range(1.01..=100.0).default(4.765);
const WAVELENGTH: Key<Wavelength, OrDefault> = Key::quantity::<Wavelength>("wavelength", "where `fwhm` holds").positive().default("500 nm");
const EXPONENT: Key<Number, OrDefault> = Key::number("exponent", "exponent of the width in wavelength").range(-2.0..=2.0).default(-0.2);

pub(super) const KIND: Kind<Arc<dyn PointSpread>> = Kind {
    name: "moffat",
    summary: "seeing: a core with wings, narrower in red light (Moffat 1969)",
    keys: &[FWHM.row, BETA.row, WAVELENGTH.row, EXPONENT.row],
    build: |section, _| {
        Ok(Arc::new(Moffat {
            fwhm_rad: section.read(&FWHM)?.0,
            beta: section.read(&BETA)?,
            wavelength_um: section.read(&WAVELENGTH)?.0,
            exponent: section.read(&EXPONENT)?,
        }))
    },
};

/// Moffat's profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moffat {
    /// The full width at half maximum w₀ \[rad\].
    pub fwhm_rad: f64,
    /// β.
    pub beta: f64,
    /// λ₀ \[µm\].
    pub wavelength_um: f64,
    /// q.
    pub exponent: f64,
}

impl Default for Moffat {
    /// An arcsecond of turbulence.
    fn default() -> Self {
        Self { fwhm_rad: std::f64::consts::PI / 648_000.0, beta: 4.765, wavelength_um: 0.5, exponent: -0.2 }
    }
}

impl PointSpread for Moffat {
    fn kernel(&self, view: &OpticsView) -> Result<Option<Kernel>> {
        let wavelength = view.band.pivot_um.unwrap_or(self.wavelength_um);
        let fwhm = self.fwhm_rad * (wavelength / self.wavelength_um).powf(self.exponent);
        // In widths, r²/a² is 4 (2^(1/β) − 1) r².
        let steep = 4.0 * (2f64.powf(1.0 / self.beta) - 1.0);
        let mut kernel = round(view, fwhm, |square| (1.0 + steep * square).powf(-self.beta));
        if let Some(kernel) = &mut kernel {
            kernel.fade();
        }
        Ok(kernel)
    }

    fn description(&self) -> String {
        let Self { fwhm_rad, beta, wavelength_um, exponent } = self;
        format!("Moffat of {} at {}, beta {beta}, exponent {exponent}", Angle(*fwhm_rad), Wavelength(*wavelength_um))
    }
}
