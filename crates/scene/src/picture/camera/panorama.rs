//! Images of all around: domes, spheres and cubes, from one eye.
//!
//! A place of the image is (s, t), to the right and upwards from its middle:
//!
//! - on a dome, angles from its axis: the direction at (s, t) is that which lies √(s² + t²) from the axis, towards (s, t)
//!   (equidistant, FITS ARC);
//! - on a sphere, longitude and latitude (equirectangular, plate carrée, FITS CAR);
//! - on a cube, halves of a face's edge, six faces from top to bottom in the order and with the turns of OpenEXR's environment
//!   maps, whose x, y and z lie to the left, upwards and ahead.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

/// Faces of a cube.
const FACES: f64 = 6.0;

/// How all around is laid out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PanoramaLayout {
    /// The hemisphere of a dome, or more or less of the sphere, around an axis; outside of the circle is nothing.
    Dome {
        /// The angle from the axis to the circle \[rad\].
        half_aperture: f64,
        /// The angle from up to the axis, towards the target \[rad\].
        tilt: f64,
    },
    /// Longitude and latitude.
    Sphere,
    /// Six faces, one above the other.
    Cube,
}

/// The directions ahead, to the right and upwards.
pub type Axes = [DVec3; 3];

/// By face of a cube what is ahead on it, to the right and upwards, each as a sign and a number of [`Axes`].
pub const CUBE: [[(f64, usize); 3]; 6] = [
    [(-1.0, 1), (1.0, 0), (1.0, 2)],
    [(1.0, 1), (-1.0, 0), (1.0, 2)],
    [(1.0, 2), (-1.0, 1), (1.0, 0)],
    [(-1.0, 2), (-1.0, 1), (-1.0, 0)],
    [(1.0, 0), (1.0, 1), (1.0, 2)],
    [(-1.0, 0), (-1.0, 1), (1.0, 2)],
];

/// sin x / x.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

/// The axes of a face of a cube.
fn of_face(axes: &Axes, face: usize) -> Axes {
    CUBE[face].map(|(sign, axis)| sign * axes[axis])
}

/// The face of a cube at a height, and where on it, upwards from its middle.
fn face_at(t: f64) -> (usize, f64) {
    let below = FACES - t;
    let face = (0.5 * below).floor().clamp(0.0, FACES - 1.0);
    (face as usize, 2.0 * face + 1.0 - below)
}

impl PanoramaLayout {
    /// The axes of the image, of those of the view.
    pub fn axes(&self, [ahead, right, up]: &Axes) -> Axes {
        let Self::Dome { tilt, .. } = self else { return [*ahead, *right, *up] };
        let (sin, cos) = tilt.sin_cos();
        // The audience looks at what is ahead, which is below in the image.
        [cos * *up + sin * *ahead, *right, sin * *up - cos * *ahead]
    }

    /// True if there is a direction at a place.
    pub fn sees(&self, (s, t): (f64, f64)) -> bool {
        match self {
            Self::Dome { half_aperture, .. } => s.hypot(t) <= *half_aperture,
            Self::Sphere => s.abs() <= PI && t.abs() <= FRAC_PI_2,
            Self::Cube => s.abs() <= 1.0 && t.abs() <= FACES,
        }
    }

    /// The direction at a place.
    pub fn direction(&self, (s, t): (f64, f64), view: &Axes) -> DVec3 {
        let axes = self.axes(view);
        let [ahead, right, up] = axes;
        match self {
            Self::Dome { .. } => {
                let angle = s.hypot(t);
                (angle.cos() * ahead + sinc(angle) * (s * right + t * up)).normalize()
            }
            Self::Sphere => {
                let ((sin_s, cos_s), (sin_t, cos_t)) = (s.sin_cos(), t.sin_cos());
                cos_t * (cos_s * ahead + sin_s * right) + sin_t * up
            }
            Self::Cube => {
                let (face, t) = face_at(t);
                let [ahead, right, up] = of_face(&axes, face);
                (ahead + s * right + t * up).normalize()
            }
        }
    }

    /// The place of a direction; none where the image has none.
    pub fn place(&self, direction: DVec3, view: &Axes) -> Option<(f64, f64)> {
        let axes = self.axes(view);
        let [ahead, right, up] = axes.map(|axis| direction.dot(axis));
        let place = match self {
            Self::Dome { .. } => {
                let aside = right.hypot(up);
                let angle = aside.atan2(ahead);
                // Behind the axis all directions of the image are one.
                if aside > 0.0 { (angle / aside * right, angle / aside * up) } else { (angle, 0.0) }
            }
            Self::Sphere => (right.atan2(ahead), up.atan2(ahead.hypot(right))),
            Self::Cube => {
                let along = |face: usize| direction.dot(of_face(&axes, face)[0]);
                let face = (0..CUBE.len()).max_by(|a, b| along(*a).total_cmp(&along(*b)))?;
                let [ahead, right, up] = of_face(&axes, face).map(|axis| direction.dot(axis));
                (right / ahead, up / ahead + FACES - 2.0 * face as f64 - 1.0)
            }
        };
        self.sees(place).then_some(place)
    }

    /// The solid angle around a place for a part of the image, in squares of the unit of places \[sr\].
    pub fn measure(&self, (s, t): (f64, f64)) -> f64 {
        match self {
            Self::Dome { .. } => sinc(s.hypot(t)).abs(),
            Self::Sphere => t.cos().max(0.0),
            Self::Cube => {
                let (_, t) = face_at(t);
                (1.0 + s * s + t * t).powf(-1.5)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: Axes = [DVec3::NEG_Z, DVec3::X, DVec3::Y];
    const LAYOUTS: [PanoramaLayout; 4] = [
        PanoramaLayout::Dome { half_aperture: FRAC_PI_2, tilt: 0.3 },
        PanoramaLayout::Dome { half_aperture: 3.0, tilt: FRAC_PI_2 },
        PanoramaLayout::Sphere,
        PanoramaLayout::Cube,
    ];

    /// Places and directions are inverse, whatever the layout, and solid angles are those between neighbours.
    #[test]
    fn places_and_directions() {
        for layout in LAYOUTS {
            for (i, j) in (0..40).flat_map(|i| (0..40).map(move |j| (i, j))) {
                let place = (0.17 * f64::from(i) - 3.3, 0.31 * f64::from(j) - 6.1);
                if !layout.sees(place) {
                    continue;
                }
                let direction = layout.direction(place, &VIEW);
                let back = layout.place(direction, &VIEW).unwrap();
                assert!((direction.length() - 1.0).abs() < 1e-12);
                assert!((back.0 - place.0).hypot(back.1 - place.1) < 1e-9, "{layout:?} {place:?} {back:?}");
                let step = 1e-5;
                let [a, b] = [(step, 0.0), (0.0, step)].map(|(s, t)| {
                    let along = |sign: f64| layout.direction((place.0 + sign * s, place.1 + sign * t), &VIEW);
                    (along(1.0) - along(-1.0)) / (2.0 * step)
                });
                assert!((a.cross(b).length() - layout.measure(place)).abs() < 1e-6, "{layout:?} {place:?}");
                // The image is no mirror's.
                assert!(a.cross(b).dot(direction) < 0.0);
            }
        }
    }

    /// View directions ahead, above, behind and to the sides: below on a dome, in the middle of a sphere; on a cube as OpenEXR has it.
    #[test]
    fn where_things_are() {
        let [ahead, right, up] = VIEW;
        let at = |layout: &PanoramaLayout, direction: DVec3| layout.place(direction.normalize(), &VIEW);
        let close = |a: Option<(f64, f64)>, b: (f64, f64)| a.is_some_and(|a| (a.0 - b.0).hypot(a.1 - b.1) < 1e-9);
        let dome = PanoramaLayout::Dome { half_aperture: FRAC_PI_2, tilt: 0.0 };
        assert!(close(at(&dome, up), (0.0, 0.0)) && close(at(&dome, ahead + 1e-12 * up), (0.0, -FRAC_PI_2)));
        assert!(close(at(&dome, right + up), (0.25 * PI, 0.0)) && at(&dome, -up).is_none());
        let tilted = PanoramaLayout::Dome { half_aperture: FRAC_PI_2, tilt: 0.25 };
        assert!(close(at(&tilted, up), (0.0, 0.25)));
        assert!(close(at(&PanoramaLayout::Sphere, ahead), (0.0, 0.0)) && close(at(&PanoramaLayout::Sphere, right), (FRAC_PI_2, 0.0)));
        assert!(
            close(at(&PanoramaLayout::Sphere, up - ahead), (PI, 0.25 * PI))
                || close(at(&PanoramaLayout::Sphere, up - ahead), (-PI, 0.25 * PI))
        );
        // +X, −X, +Y, −Y, +Z, −Z: to the left, to the right, above, below, ahead, behind.
        for (face, direction) in [-right, right, up, -up, ahead, -ahead].into_iter().enumerate() {
            assert!(close(at(&PanoramaLayout::Cube, direction), (0.0, 5.0 - 2.0 * face as f64)));
        }
        let beside = [(-right + 0.5 * ahead, 5.0), (right - 0.5 * ahead, 3.0), (up - 0.5 * right, 1.0), (-up - 0.5 * right, -1.0)];
        for (direction, t) in beside {
            assert!(close(at(&PanoramaLayout::Cube, direction), (0.5, t)));
        }
        assert!(
            close(at(&PanoramaLayout::Cube, up + 0.5 * ahead), (0.0, 1.5))
                && close(at(&PanoramaLayout::Cube, -up - 0.5 * ahead), (0.0, -0.5))
        );
    }
}
