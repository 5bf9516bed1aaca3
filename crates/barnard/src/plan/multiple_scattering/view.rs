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

    /// True if it differs from another by at most an angle \[rad\], as seen from a place.
    pub fn is_near(self, other: Self, place: DVec3, angle: f64) -> bool {
        match (self, other) {
            (Self::From(eye), Self::From(before)) => (eye - before).length() <= angle * (before - place).length(),
            (Self::Along(forward), Self::Along(before)) => (forward - before).length() <= angle,
            _ => false,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eyes_are_near_within_an_angle() {
        let eye = |angle: f64, distance: f64| Viewpoint::From(DVec3::X + distance * DVec3::new(0.0, angle.sin(), angle.cos()));
        let is_near = |a, b| Viewpoint::is_near(a, b, DVec3::X, 0.1);
        assert!(is_near(eye(0.09, 5.0), eye(0.0, 5.0)) && !is_near(eye(0.11, 5.0), eye(0.0, 5.0)));
        assert!(is_near(eye(0.0, 5.4), eye(0.0, 5.0)) && !is_near(eye(0.0, 5.6), eye(0.0, 5.0)));
        let along = |angle: f64| Viewpoint::Along(DVec3::new(0.0, angle.sin(), angle.cos()));
        assert!(is_near(along(0.09), along(0.0)) && !is_near(along(0.11), along(0.0)) && !is_near(along(0.0), eye(0.0, 5.0)));
        assert!(!Viewpoint::is_near(eye(1e-9, 5.0), eye(0.0, 5.0), DVec3::X, 0.0));
    }
}
