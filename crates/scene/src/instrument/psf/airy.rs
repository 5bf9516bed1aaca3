//! Diffraction: Airy's pattern, with what stands in the way of the light.

use std::sync::Arc;

use spectra::units::Angle;

use super::{OpticsView, PointSpread};
use crate::error::Result;
use crate::image::convolution::Kernel;
use crate::image::optics::{self, OpticsRow, Pattern, Pupil};
use crate::properties::{Integer, Key, Kind, Number, OrDefault, Text};

const OPTICS: Key<Text> = Key::text("optics", "telescope with a known pupil, instead of obstruction and vanes").of("optics");
const VANES: Key<Integer<usize>, OrDefault> =
    Key::integer("vanes", "number of vanes of the secondary mirror").range(0..=12).default(0).excludes("optics");
const VANE_WIDTH: Key<Number, OrDefault> =
    Key::number("vane_width", "width of a vane relative to the aperture").range(1e-4..=0.2).default(0.01).excludes("optics");
const ROTATION: Key<Angle, OrDefault> = Key::quantity::<Angle>("rotation", "rotation of the optics, counterclockwise").default("0 deg");

pub(super) const KIND: Kind<Arc<dyn PointSpread>> = Kind {
    name: "airy",
    summary: "diffraction at the aperture, its obstruction and vanes",
    keys: &[OPTICS.row, VANES.row, VANE_WIDTH.row, ROTATION.row],
    build: |section, _| {
        let optics = section.read(&OPTICS)?.map(|name| section.wrap(&OPTICS, optics::by_name(name))).transpose()?;
        Ok(Arc::new(Airy {
            optics,
            vanes: section.read(&VANES)?,
            vane_width: section.read(&VANE_WIDTH)?,
            rotation: section.read(&ROTATION)?.0,
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
    fn kernel(&self, view: &OpticsView) -> Result<Option<Kernel>> {
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

    fn description(&self) -> String {
        let pupil = match self.optics {
            Some(row) => format!("of {}", row.name),
            None => format!("with {} vanes of {}", self.vanes, self.vane_width),
        };
        format!("diffraction {pupil}, turned by {}", Angle(self.rotation))
    }
}
