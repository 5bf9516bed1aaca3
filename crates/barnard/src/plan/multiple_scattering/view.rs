//! Camera geometry that determines the direction of outgoing light.

use glam::DVec3;

use crate::camera::{Camera, Projection};

/// The place of an eye, or the direction in which it looks.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Viewpoint {
    From(DVec3),
    Along(DVec3),
}

impl Viewpoint {
    pub fn of(camera: &Camera) -> Self {
        match camera.projection {
            Projection::Perspective { .. } | Projection::Panorama { .. } => Self::From(camera.position),
            Projection::Orthographic { .. } => Self::Along(camera.forward),
        }
    }

    /// The direction from a place towards the eye, of length one.
    pub fn towards(self, place: DVec3) -> DVec3 {
        match self {
            Self::From(eye) => (eye - place).normalize_or(DVec3::Z),
            Self::Along(forward) => -forward,
        }
    }
}
