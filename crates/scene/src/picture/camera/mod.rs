//! Cameras: from pixels to rays.
//!
//! Pixel (row i, column j) looks along d + x r + y u with x = (2(j + ½)/W − 1) h, y = (1 − 2(i + ½)/H) h H/W, h =
//! tan(fov/2) (perspective), or starts from position + x r + y u with h = width/2 (orthographic); d towards the target,
//! r = d × up, u = r × d. A part of an image is an image whose middle lies off the axis of view. Images of all around have
//! angles in place of tangents (`panorama`).

mod builders;
mod kinds;
pub mod panorama;
mod stereo;
mod view;

use std::f64::consts::PI;

use glam::DVec3;

pub(crate) use kinds::{COMMON, POSITION, TARGET};
pub use kinds::{KINDS, bookmark, build};
pub(crate) use stereo::KEYS as STEREO;
pub use stereo::{Arrangement, Eye, Stereo};

use self::panorama::{Axes, PanoramaLayout};
use crate::error::{Error, Result};
use crate::geometry::Ray;
use crate::image::{ImagePart, PixelScale};

/// How rays leave the image plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// All rays start at one point.
    Perspective {
        /// The tangent of half the horizontal field of view \[1\].
        half_width: f64,
    },
    /// All rays are parallel.
    Orthographic {
        /// Half the width of the image \[pc\].
        half_width_pc: f64,
    },
    /// All rays start at one point, in directions that angles tell.
    Panorama {
        /// Mapping between image positions and directions.
        layout: PanoramaLayout,
        /// Half the width of the image \[rad; on a cube, halves of a face's edge\].
        half_width: f64,
    },
}

impl Projection {
    /// # Errors
    /// If an angle or a width is out of range.
    fn check(&self) -> Result<()> {
        let (what, half) = match *self {
            Self::Perspective { half_width } => ("field of view", half_width),
            Self::Orthographic { half_width_pc } => ("width of the camera", half_width_pc),
            Self::Panorama { layout, half_width } => {
                let is_dome = |half: f64, tilt: f64| half > 0.0 && half <= PI * (1.0 + 1e-9) && (0.0..=PI * (1.0 + 1e-9)).contains(&tilt);
                if let PanoramaLayout::Dome { half_aperture, tilt } = layout
                    && !is_dome(half_aperture, tilt)
                {
                    let found = format!("{:.4} and {:.4} deg", (2.0 * half_aperture).to_degrees(), tilt.to_degrees());
                    return Err(Error::out_of_range("aperture and tilt of the camera", found, "0 to 360 deg, and 0 to 180 deg"));
                }
                ("width of the camera", half_width)
            }
        };
        if !(half > 0.0 && half < WIDEST) {
            return Err(Error::out_of_range(what, half, "above zero, and a field of view below 180 deg"));
        }
        Ok(())
    }

    /// What the half width is measured in grows with the width alone.
    fn part(self, part: f64) -> Self {
        match self {
            Self::Perspective { half_width } => Self::Perspective { half_width: part * half_width },
            Self::Orthographic { half_width_pc } => Self::Orthographic { half_width_pc: part * half_width_pc },
            Self::Panorama { layout, half_width } => Self::Panorama { layout, half_width: part * half_width },
        }
    }

    /// The dome of an aperture \[rad\], whose axis leans from up towards the target by a tilt \[rad\]; the circle touches the
    /// image's sides.
    fn dome(aperture: f64, tilt: f64) -> Self {
        let half_aperture = 0.5 * aperture;
        Self::Panorama { layout: PanoramaLayout::Dome { half_aperture, tilt }, half_width: half_aperture }
    }

    /// All around, longitude by latitude.
    const SPHERE: Self = Self::Panorama { layout: PanoramaLayout::Sphere, half_width: PI };
    /// All around, six faces of a cube.
    const CUBE: Self = Self::Panorama { layout: PanoramaLayout::Cube, half_width: 1.0 };
}

/// Position of the observer and the field of view.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// The eye, or the middle of the image plane \[pc\].
    pub position: DVec3,
    /// Viewing direction, of length one.
    pub forward: DVec3,
    /// The direction to the right in the image, of length one.
    pub right: DVec3,
    /// The direction upwards in the image, of length one.
    pub up: DVec3,
    /// How rays leave the image plane.
    pub projection: Projection,
    /// The number of pixels along a row.
    pub width: usize,
    /// The number of rows.
    pub height: usize,
    /// Rays along each side of a pixel.
    pub supersampling: usize,
    /// Offset of the image centre from the optical axis, to the right and upwards, in halves of its width \[1\]:
    /// zero but for a part of a larger image.
    pub offset: (f64, f64),
    /// The two eyes that look in place of one, each of which has a [camera](Camera::eyes) of its own; none: one eye looks.
    pub stereo: Option<Stereo>,
    /// Which of two eyes looks, in an image of all around; none: one looks from the camera's own place.
    pub eye: Option<Eye>,
    /// The place of this image in a larger one of which it is a part.
    pub part: Option<ImagePart>,
}

/// Most pixels along an edge: what the formats can hold and a mistake cannot reach.
pub const MAX_EDGE: usize = 65_536;

/// All around [rad].
const TURN: f64 = 2.0 * PI;
/// Numbers of rays along each side of a pixel.
const MAX_SUPERSAMPLING: usize = 16;
/// Half widths beyond this leave no digits for a direction.
const WIDEST: f64 = 1e9;
/// Tolerance of axes for unit length and right angles.
const SKEW: f64 = 1e-3;
/// Pixels of an image that says nothing else.
const SIZE: usize = 512;
/// The default of the horizontal field of view [deg].
const FIELD_OF_VIEW_DEG: f64 = 30.0;

/// Pixel width along its rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// Growth per pc \[1\].
    pub per_pc: f64,
    /// Width at the camera \[pc\].
    pub least_pc: f64,
}

impl Footprint {
    /// Pixel width at a distance from the camera \[pc\].
    pub fn at(&self, distance_pc: f64) -> f64 {
        self.least_pc + self.per_pc * distance_pc
    }
}

impl Camera {
    /// The cameras of the left and the right eye; none where one eye looks.
    pub fn eyes(&self) -> Option<[Self; 2]> {
        let Stereo { distance_pc, convergence_pc, merge, .. } = self.stereo?;
        Some([-0.5, 0.5].map(|part| {
            let aside_pc = part * distance_pc;
            let one = Self { stereo: None, ..self.clone() };
            match self.projection {
                Projection::Panorama { .. } => Self { eye: Some(Eye { aside_pc, convergence_pc, merge }), ..one },
                Projection::Perspective { half_width } => {
                    let shift = aside_pc / (convergence_pc * half_width);
                    Self { position: self.position + aside_pc * self.right, offset: (self.offset.0 - shift, self.offset.1), ..one }
                }
                Projection::Orthographic { .. } => one,
            }
        }))
    }

    /// Refuses what no picture can be taken by.
    ///
    /// # Errors
    /// If position, target, up, field of view or the number of pixels are wrong.
    pub fn check(&self) -> Result<()> {
        if !self.position.is_finite() {
            return Err(Error::out_of_range("position of the camera", self.position, "finite"));
        }
        if !self.forward.is_finite() {
            return Err(Error::conflict("camera and target are at the same position", "move one of them"));
        }
        if !(self.right.is_finite() && self.up.is_finite()) {
            return Err(Error::conflict("up of the camera is its viewing direction", "choose another direction"));
        }
        let axes = [self.right, self.up, self.forward];
        let square = |i: usize| axes[i].dot(axes[(i + 1) % 3]).abs() < SKEW && (axes[i].length() - 1.0).abs() < SKEW;
        if !(0..3).all(square) {
            let problem = format!("right, up and forward of the camera, {axes:.3?}, are not orthonormal");
            return Err(Error::conflict(problem, "make them with `look_at`"));
        }
        self.projection.check()?;
        if !(self.offset.0.is_finite() && self.offset.1.is_finite()) {
            return Err(Error::out_of_range("offset of the camera", format!("{:?}", self.offset), "two finite numbers"));
        }
        self.check_stereo()?;
        let (width, height) = (self.width, self.height);
        if !((1..=MAX_EDGE).contains(&width) && (1..=MAX_EDGE).contains(&height)) {
            let allowed = format!("two whole numbers from 1 to {MAX_EDGE}");
            return Err(Error::out_of_range("size of the image", format!("{width} x {height} pixels"), allowed));
        }
        if !(1..=MAX_SUPERSAMPLING).contains(&self.supersampling) {
            return Err(Error::out_of_range("supersampling", self.supersampling, "between 1 and 16 rays per pixel edge"));
        }
        Ok(())
    }

    fn check_stereo(&self) -> Result<()> {
        let Some(stereo) = &self.stereo else { return Ok(()) };
        stereo.check()?;
        let edge = if stereo.arrangement == Arrangement::OverUnder { self.height } else { self.width };
        if 2 * edge > MAX_EDGE {
            let allowed = format!("at most {MAX_EDGE} for both together; render each eye separately");
            return Err(Error::out_of_range("edge of a stereo image", 2 * edge, allowed));
        }
        if matches!(self.projection, Projection::Orthographic { .. }) {
            return Err(Error::unsupported("stereo", "an orthographic camera", "use another kind of camera"));
        }
        Ok(())
    }

    /// The ray through (`column`, `row`) in pixels from the upper left corner, pixel centres at halves.
    pub fn ray(&self, column: f64, row: f64) -> Ray {
        let (x, y) = self.image_place(column, row);
        match self.projection {
            Projection::Perspective { half_width } => {
                let direction = self.forward + half_width * (x * self.right + y * self.up);
                Ray { origin: self.position, direction: direction.normalize() }
            }
            Projection::Orthographic { half_width_pc } => {
                Ray { origin: self.position + half_width_pc * (x * self.right + y * self.up), direction: self.forward }
            }
            Projection::Panorama { layout, half_width } => {
                let direction = layout.direction((half_width * x, half_width * y), &self.axes());
                let (aside, direction) = self.eye.map_or((DVec3::ZERO, direction), |eye| eye.ray(direction, self.up));
                Ray { origin: self.position + aside, direction }
            }
        }
    }

    /// Whether there is a ray through (`column`, `row`): beside the circle of a dome there is none, and the picture is black.
    pub fn sees(&self, column: f64, row: f64) -> bool {
        let Projection::Panorama { layout, half_width } = self.projection else { return true };
        let (x, y) = self.image_place(column, row);
        layout.sees((half_width * x, half_width * y))
    }

    /// A place of the image in halves of its width from the axis of view, to the right and upwards.
    fn image_place(&self, column: f64, row: f64) -> (f64, f64) {
        let (w, h) = (self.width as f64, self.height as f64);
        let per_pixel = 2.0 / w;
        (per_pixel * (column - 0.5 * w) + self.offset.0, per_pixel * (0.5 * h - row) + self.offset.1)
    }

    /// The directions of the image's own middle, to the right and upwards there, of the whole image where this is a part of one.
    pub fn image_axes(&self) -> Axes {
        match self.projection {
            Projection::Panorama { layout, .. } => layout.axes(&self.axes()),
            Projection::Perspective { .. } | Projection::Orthographic { .. } => self.axes(),
        }
    }

    fn axes(&self) -> Axes {
        [self.forward, self.right, self.up]
    }

    /// The (column, row) at which the place `p` appears, in pixels; none behind the observer, or where the image has none.
    pub fn project(&self, p: DVec3) -> Option<(f64, f64)> {
        let (w, h) = (self.width as f64, self.height as f64);
        let v = p - self.position;
        let depth = v.dot(self.forward);
        let beside = |scale: f64| (depth > 0.0).then(|| (v.dot(self.right) / scale, v.dot(self.up) / scale));
        let (x, y) = match self.projection {
            Projection::Perspective { half_width } => beside(depth * half_width)?,
            Projection::Orthographic { half_width_pc } => beside(half_width_pc)?,
            Projection::Panorama { layout, half_width } => {
                let direction = match self.eye {
                    Some(eye) => eye.towards(v, self.up)?,
                    None => v.try_normalize()?,
                };
                let (s, t) = layout.place(direction, &self.axes())?;
                (s / half_width, t / half_width)
            }
        };
        let (x, y) = (x - self.offset.0, y - self.offset.1);
        Some((0.5 * w * (x + 1.0), 0.5 * h * (1.0 - y * w / h)))
    }

    /// Solid angle of the pixel around (`column`, `row`) \[sr\]; under an orthographic camera, its area \[pc²\].
    pub fn pixel_measure(&self, column: f64, row: f64) -> f64 {
        let w = self.width as f64;
        match self.projection {
            Projection::Perspective { half_width } => {
                // Ω = p² cos³θ, with p a pixel's edge at distance one and tan θ the distance from the axis there.
                let pixel = 2.0 * half_width / w;
                let right = pixel * (column - 0.5 * w) + half_width * self.offset.0;
                let up = pixel * (0.5 * self.height as f64 - row) + half_width * self.offset.1;
                let secant = (1.0 + right * right + up * up).sqrt();
                pixel * pixel / (secant * secant * secant)
            }
            Projection::Orthographic { half_width_pc } => (2.0 * half_width_pc / w).powi(2),
            Projection::Panorama { layout, half_width } => {
                let (x, y) = self.image_place(column, row);
                (2.0 * half_width / w).powi(2) * layout.measure((half_width * x, half_width * y))
            }
        }
    }

    /// Width of the central pixel at a distance.
    pub fn footprint(&self) -> Footprint {
        let per_pixel = 2.0 / self.width as f64;
        match self.projection {
            Projection::Perspective { half_width } | Projection::Panorama { half_width, .. } => {
                Footprint { per_pc: per_pixel * half_width, least_pc: 0.0 }
            }
            Projection::Orthographic { half_width_pc } => Footprint { per_pc: 0.0, least_pc: per_pixel * half_width_pc },
        }
    }

    /// Position of the optical axis in the image, from its middle to the right and upwards \[pixels\].
    pub fn axis(&self) -> (f64, f64) {
        let half = 0.5 * self.width as f64;
        (-half * self.offset.0, -half * self.offset.1)
    }

    /// Radius of a dome's circle around the axis of view \[pixels\]; none for other images.
    pub fn circle(&self) -> Option<f64> {
        match self.projection {
            Projection::Panorama { layout: PanoramaLayout::Dome { half_aperture, .. }, half_width } => {
                Some(0.5 * self.width as f64 * half_aperture / half_width)
            }
            _ => None,
        }
    }

    /// Size of a pixel in the middle of the image.
    pub fn pixel_scale(&self) -> PixelScale {
        let w = self.width as f64;
        match self.projection {
            Projection::Perspective { half_width } => PixelScale::Angle((2.0 * half_width / w).to_degrees()),
            Projection::Orthographic { half_width_pc } => PixelScale::Length(2.0 * half_width_pc / w),
            Projection::Panorama { layout, half_width } => {
                let pixel = (2.0 * half_width / w).to_degrees();
                match layout {
                    PanoramaLayout::Dome { .. } => PixelScale::Equidistant(pixel),
                    PanoramaLayout::Sphere => PixelScale::PlateCarree(pixel),
                    PanoramaLayout::Cube => PixelScale::OnCube(pixel),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection) -> Camera {
        Camera {
            position: DVec3::new(0.0, 0.0, 4.0),
            forward: -DVec3::Z,
            right: DVec3::X,
            up: DVec3::Y,
            projection,
            width: 8,
            height: 4,
            ..Camera::look_at(DVec3::Z, DVec3::ZERO)
        }
    }

    #[test]
    fn rays_and_projection_are_inverse() {
        for projection in [Projection::Perspective { half_width: 0.3 }, Projection::Orthographic { half_width_pc: 2.0 }] {
            let camera = camera(projection);
            let ray = camera.ray(1.5, 3.5);
            let (column, row) = camera.project(ray.at(3.0)).unwrap();
            assert!((column - 1.5).abs() < 1e-12 && (row - 3.5).abs() < 1e-12);
            assert_eq!(camera.project(DVec3::new(0.0, 0.0, 9.0)), None);
        }
    }

    /// A part of an image has the rays, pixels and places of the whole, and so has a part of that part.
    #[test]
    fn parts_see_as_the_whole() {
        for projection in [Projection::Perspective { half_width: 0.7 }, Projection::Orthographic { half_width_pc: 2.0 }] {
            let whole = camera(projection).with_size(80, 60);
            let part = whole.clone().crop(10, 20, 40, 25).unwrap().crop(5, 1, 30, 20).unwrap();
            for (column, row) in [(0.5, 0.5), (29.5, 19.5), (11.25, 3.0)] {
                let (part_ray, all) = (part.ray(column, row), whole.ray(column + 15.0, row + 21.0));
                assert!(part_ray.direction.distance(all.direction) < 1e-15 && part_ray.origin.distance(all.origin) < 1e-15);
                assert!((part.pixel_measure(column, row) / whole.pixel_measure(column + 15.0, row + 21.0) - 1.0).abs() < 1e-14);
                let (x, y) = part.project(part_ray.at(3.0)).unwrap();
                assert!((x - column).abs() < 1e-12 && (y - row).abs() < 1e-12);
            }
            assert_eq!((part.width, part.height), (30, 20));
            assert_eq!(part.clone().with_size(30, 20).part, part.part);
            assert!(part.part.is_some() && part.with_size(20, 20).part.is_none());
            for (column, row, width, height) in [(0, 0, 0, 5), (70, 0, 11, 5), (0, 59, 80, 2), (usize::MAX, 0, 1, 1)] {
                assert!(whole.clone().crop(column, row, width, height).is_err());
            }
        }
    }

    /// The first pixel looks up and to the left.
    #[test]
    fn orientation() {
        let direction = camera(Projection::Perspective { half_width: 0.3 }).ray(0.5, 0.5).direction;
        assert!(direction.x < 0.0 && direction.y > 0.0 && direction.z < 0.0);
    }

    /// Solid angles of all pixels add up to that of the image's pyramid: 4 asin(sin α sin β), tan α and tan β half
    /// width and height.
    #[test]
    fn solid_angles_add_up() {
        let mut wide = camera(Projection::Perspective { half_width: 0.5 });
        (wide.width, wide.height) = (200, 100);
        let sum: f64 =
            (0..100).flat_map(|i| (0..200).map(move |j| (i, j))).map(|(i, j)| wide.pixel_measure(j as f64 + 0.5, i as f64 + 0.5)).sum();
        let expected = 4.0 * (0.5f64.atan().sin() * 0.25f64.atan().sin()).asin();
        assert!((sum / expected - 1.0).abs() < 1e-4, "{sum} {expected}");
    }
}
