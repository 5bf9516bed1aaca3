//! Diffraction: Airy's pattern, with what stands in the way of the light.

use std::sync::Arc;

use spectra::units::Angle;

use super::{PointSpread, View};
use crate::error::Result;
use crate::image::convolution::Kernel;
use crate::image::optics::{self, OpticsRow, Pattern, Pupil};
use crate::properties::{Key, Kind};

pub(super) const KIND: Kind<Arc<dyn PointSpread>> = Kind {
    name: "airy",
    summary: "diffraction at the aperture, its obstruction and vanes",
    keys: &[
        Key::optional("optics", "text", "none", "telescope with a known pupil, instead of obstruction and vanes").of("optics"),
        Key::optional("vanes", "integer", "0", "number of vanes of the secondary mirror, up to 12"),
        Key::optional("vane_width", "number", "0.01", "width of a vane relative to the aperture"),
        Key::optional("rotation", "angle", "0 deg", "rotation of the optics, counterclockwise"),
    ],
    build: |section, _| {
        let plain = Airy::default();
        let optics = section.text("optics")?.map(|name| section.wrap("optics", optics::named(name))).transpose()?;
        if optics.is_some() {
            section.refuse(&["vanes", "vane_width"], "an aperture without \"optics\"")?;
        }
        Ok(Arc::new(Airy {
            optics,
            vanes: section.integer("vanes", 0..=12)?.map_or(plain.vanes, |n| n as usize),
            vane_width: section.number("vane_width", 1e-4..=0.2)?.unwrap_or(plain.vane_width),
            rotation: section.quantity::<Angle>("rotation")?.map_or(0.0, |angle| angle.0),
        }))
    },
};

/// Diffraction at an aperture.
#[derive(Debug, Clone, PartialEq)]
pub struct Airy {
    /// A telescope whose pupil is known.
    pub optics: Option<&'static OpticsRow>,
    /// The number of vanes, evenly around.
    pub vanes: usize,
    /// The width of a vane, as a part of the aperture.
    pub vane_width: f64,
    /// Rotation of the optics, counterclockwise \[rad\].
    pub rotation: f64,
}

impl Default for Airy {
    /// An aperture without vanes.
    fn default() -> Self {
        Self { optics: None, vanes: 0, vane_width: 0.01, rotation: 0.0 }
    }
}

impl PointSpread for Airy {
    fn kernel(&self, view: &View) -> Result<Option<Kernel>> {
        let pattern = match self.optics {
            Some(row) => (row.pattern)(),
            None => Pattern::Pupil(Pupil::round(view.instrument.obstruction as f32, self.vanes, self.vane_width as f32, 0.0)),
        };
        // λ/D at 550 nm, in pixels.
        let size = 0.55e-6 / view.instrument.aperture_m / view.pixel_rad;
        let mut kernel = Kernel::of_optics(&pattern, self.rotation, view.band, view.reach, size);
        kernel.fade();
        Ok(Some(kernel))
    }

    fn said(&self) -> String {
        let pupil = match self.optics {
            Some(row) => format!("of {}", row.name),
            None => format!("with {} vanes of {}", self.vanes, self.vane_width),
        };
        format!("diffraction {pupil}, turned by {}", Angle(self.rotation))
    }
}
