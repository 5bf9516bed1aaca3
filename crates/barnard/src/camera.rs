//! Cameras: from pixels to rays.
//!
//! Pixel (row i, column j) looks along d + x r + y u with x = (2(j + ½)/W − 1) h, y = (1 − 2(i + ½)/H) h H/W, h = tan(fov/2) (perspective), or starts
//! from position + x r + y u with h = width/2 (orthographic); d towards the target, r = d × up, u = r × d.

use glam::DVec3;
use spectra::units::{Angle, Length};

use crate::error::Result;
use crate::geometry::Ray;
use crate::image::PixelScale;
use crate::scene::{Key, Kind, Loader, Section, build_kind_with};

/// How rays leave the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// All rays from one point; tan of half the horizontal field of view.
    Perspective {
        /// tan(fov/2) [1].
        half_width: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the width of the image [pc].
        half_width_pc: f64,
    },
}

/// Where the observer is and what they see.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// The eye, or the middle of the image plane [pc].
    pub position: DVec3,
    /// Viewing direction, of length one.
    pub forward: DVec3,
    /// To the right in the image.
    pub right: DVec3,
    /// Up in the image.
    pub up: DVec3,
    /// How rays leave.
    pub projection: Projection,
    /// Pixels along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Rays along each side of a pixel.
    pub supersampling: usize,
}

/// Keys of every camera.
pub(crate) const COMMON: &[Key] = &[
    Key::required("position", "position", "where the observer is"),
    Key::optional("target", "position", "0 0 0 pc", "what they look at"),
    Key::optional("up", "direction", "[0, 1, 0]", "what is up in the image"),
    Key::optional("size", "[width, height]", "[512, 512]", "pixels of the image"),
    Key::optional("supersampling", "integer", "1", "rays along each side of a pixel, 1 to 16"),
];

/// All kinds of camera.
pub const KINDS: &[Kind<Projection>] = &[
    Kind {
        name: "perspective",
        summary: "all rays from one point",
        keys: &[Key::required("field_of_view", "angle", "horizontal field of view, below 180 deg")],
        build: |section, _| {
            let fov = section.need_positive::<Angle>("field_of_view")?;
            if fov.0 >= std::f64::consts::PI {
                return Err(section.error("field_of_view", format!("{fov} is too wide; it must be below 180 deg")));
            }
            Ok(Projection::Perspective { half_width: (0.5 * fov.0).tan() })
        },
    },
    Kind {
        name: "orthographic",
        summary: "parallel rays, starting on the image plane",
        keys: &[Key::required("width", "length", "width of the image")],
        build: |section, _| Ok(Projection::Orthographic { half_width_pc: 0.5 * section.need_positive::<Length>("width")?.0 }),
    },
];

/// Most pixels along an edge: what the formats can hold and a mistake cannot reach.
pub const MAX_EDGE: usize = 65_536;

/// Reads a `[bookmark.NAME]` table: a camera, with the pixels of the scene's own where it does not say others.
pub fn bookmark(section: &Section, loader: &Loader, own: &Camera) -> Result<Camera> {
    let mut camera = build(section, loader)?;
    if !section.has("size") {
        (camera.width, camera.height) = (own.width, own.height);
    }
    if !section.has("supersampling") {
        camera.supersampling = own.supersampling;
    }
    Ok(camera)
}

/// Reads the `[camera]` table.
pub fn build(section: &Section, loader: &Loader) -> Result<Camera> {
    let projection = build_kind_with("camera", KINDS, COMMON, section, loader)?;
    let position = section.need_position("position")?;
    let target = section.position("target")?.unwrap_or(DVec3::ZERO);
    let up = section.direction("up")?.unwrap_or(DVec3::Y);
    let forward = (target - position).try_normalize();
    let forward = forward.ok_or_else(|| section.error("target", "the camera stands on its target; move one of them"))?;
    let right = forward.cross(up).try_normalize();
    let right = right.ok_or_else(|| section.error("up", "up is parallel to the viewing direction; choose another"))?;
    let size = section.numbers("size")?.unwrap_or_else(|| vec![512.0, 512.0]);
    let whole = |v: f64| v.fract() == 0.0 && (1.0..=MAX_EDGE as f64).contains(&v);
    let &[width, height] = &size[..] else { return Err(section.error("size", "size is [width, height]")) };
    if !whole(width) || !whole(height) {
        return Err(section
            .error("size", format!("an image of {width} x {height} pixels cannot be made; both are whole numbers from 1 to {MAX_EDGE}")));
    }
    Ok(Camera {
        position,
        forward,
        right,
        up: right.cross(forward),
        projection,
        width: width as usize,
        height: height as usize,
        supersampling: section.integer("supersampling", 1..=16)?.unwrap_or(1) as usize,
    })
}

impl Camera {
    /// The ray through (`column`, `row`) in pixels from the upper left corner, pixel centres at halves.
    pub fn ray(&self, column: f64, row: f64) -> Ray {
        let (w, h) = (self.width as f64, self.height as f64);
        let per_pixel = 2.0 / w;
        let (x, y) = (per_pixel * (column - 0.5 * w), per_pixel * (0.5 * h - row));
        match self.projection {
            Projection::Perspective { half_width } => {
                let direction = self.forward + half_width * (x * self.right + y * self.up);
                Ray { origin: self.position, direction: direction.normalize() }
            }
            Projection::Orthographic { half_width_pc } => {
                Ray { origin: self.position + half_width_pc * (x * self.right + y * self.up), direction: self.forward }
            }
        }
    }

    /// Where the direction or place `p` appears: (column, row) in pixels; nothing behind the observer.
    pub fn project(&self, p: DVec3) -> Option<(f64, f64)> {
        let (w, h) = (self.width as f64, self.height as f64);
        let v = p - self.position;
        let depth = v.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        let scale = match self.projection {
            Projection::Perspective { half_width } => depth * half_width,
            Projection::Orthographic { half_width_pc } => half_width_pc,
        };
        let (x, y) = (v.dot(self.right) / scale, v.dot(self.up) / scale);
        Some((0.5 * w * (x + 1.0), 0.5 * h * (1.0 - y * w / h)))
    }

    /// Solid angle of the pixel around (`column`, `row`) [sr]; under an orthographic camera, its area [pc²].
    pub fn pixel_measure(&self, column: f64, row: f64) -> f64 {
        let w = self.width as f64;
        match self.projection {
            Projection::Perspective { half_width } => {
                let cosine = self.ray(column, row).direction.dot(self.forward);
                (2.0 * half_width / w).powi(2) * cosine.powi(3)
            }
            Projection::Orthographic { half_width_pc } => (2.0 * half_width_pc / w).powi(2),
        }
    }

    /// Size of a pixel in the middle of the image.
    pub fn pixel_scale(&self) -> PixelScale {
        let w = self.width as f64;
        match self.projection {
            Projection::Perspective { half_width } => PixelScale::Angle((2.0 * half_width / w).to_degrees()),
            Projection::Orthographic { half_width_pc } => PixelScale::Length(2.0 * half_width_pc / w),
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
            supersampling: 1,
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

    /// The first pixel looks up and to the left.
    #[test]
    fn orientation() {
        let direction = camera(Projection::Perspective { half_width: 0.3 }).ray(0.5, 0.5).direction;
        assert!(direction.x < 0.0 && direction.y > 0.0 && direction.z < 0.0);
    }

    /// Solid angles of all pixels add up to that of the image's pyramid: 4 asin(sin α sin β), tan α and tan β half width and height.
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
