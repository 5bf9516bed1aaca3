//! Pointing of a picture on the sky, and its unit in FITS files.
//!
//! The middle of the camera's whole image is a place of the sky, and its up a direction there: position angles go from north through
//! east, which is left where north is up. Nothing that is rendered depends on it.

mod sky;
mod unit;

pub use sky::{SkyFrame, SkyPlace};
pub use unit::{InUnit, RadianceUnit};

use glam::DVec3;

/// Pointing of a picture on the sky.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Observation {
    /// The place of the sky in the middle of the camera's whole image.
    pub target: SkyPlace,
    /// The direction of the picture's up, from north through east \[rad\].
    pub position_angle: f64,
    /// Distance to the centre of an orthographic image, from which its lengths become angles \[pc\].
    pub distance_pc: Option<f64>,
    /// The unit of FITS files.
    pub unit: RadianceUnit,
}

impl Observation {
    /// The directions of the sky that lie ahead in the middle of the picture, to its right and upwards, each of length one, ICRS.
    pub fn axes(&self) -> [DVec3; 3] {
        let [ahead, east, north] = self.target.axes();
        let (sin, cos) = self.position_angle.sin_cos();
        [ahead, sin * north - cos * east, cos * north + sin * east]
    }
}
