//! Cameras from scratch.

use glam::DVec3;

use super::{Camera, FIELD_OF_VIEW_DEG, Projection, SIZE, Stereo};
use crate::error::{Error, Result};
use crate::image::ImagePart;

impl Camera {
    /// A camera at `position` that looks towards `target` \[pc\], with y upwards, 512 × 512 pixels and a horizontal
    /// field of view of 30°.
    /// Rendering a camera that stands on its target, or looks along its own `up`, is an error.
    pub fn look_at(position: DVec3, target: DVec3) -> Self {
        let nowhere = DVec3::NAN;
        Self {
            position,
            forward: (target - position).try_normalize().unwrap_or(nowhere),
            right: nowhere,
            up: nowhere,
            projection: Projection::Perspective { half_width: 1.0 },
            width: SIZE,
            height: SIZE,
            supersampling: 1,
            offset: (0.0, 0.0),
            stereo: None,
            eye: None,
            part: None,
        }
        .with_up(DVec3::Y)
        .with_field_of_view_deg(FIELD_OF_VIEW_DEG)
    }

    /// Copy of the camera turned so that `up` is up in the image.
    #[must_use]
    pub fn with_up(self, up: DVec3) -> Self {
        let right = self.forward.cross(up).try_normalize().unwrap_or(DVec3::NAN);
        Self { right, up: right.cross(self.forward), ..self }
    }

    /// Copy of the camera with all rays from one point and this horizontal field of view \[deg\], below 180.
    #[must_use]
    pub fn with_field_of_view_deg(self, field_of_view: f64) -> Self {
        Self { projection: Projection::Perspective { half_width: (0.5 * field_of_view.to_radians()).tan() }, ..self }
    }

    /// Copy of the camera with parallel rays and an image of this width \[pc\].
    #[must_use]
    pub fn with_orthographic_pc(self, width: f64) -> Self {
        Self { projection: Projection::Orthographic { half_width_pc: 0.5 * width }, ..self }
    }

    /// Copy of the camera as a dome master of an aperture \[deg\], up to 360, whose middle leans by a tilt \[deg\] from up towards what
    /// the camera looks at: that is at the bottom, or in the middle at a tilt of 90.
    #[must_use]
    pub fn with_fisheye_deg(self, aperture: f64, tilt: f64) -> Self {
        Self { projection: Projection::dome(aperture.to_radians(), tilt.to_radians()), ..self }
    }

    /// Copy of the camera with an equirectangular image of the whole sphere, `width` pixels wide and half as high.
    #[must_use]
    pub fn with_equirectangular(self, width: usize) -> Self {
        Self { projection: Projection::SPHERE, part: None, ..self.with_size(width, width.div_ceil(2)) }
    }

    /// Copy of the camera with six faces of a cube, each `edge` pixels wide.
    #[must_use]
    pub fn with_cubemap(self, edge: usize) -> Self {
        Self { projection: Projection::CUBE, part: None, ..self.with_size(edge, 6 * edge) }
    }

    /// Copy of the camera with another image size \[pixels\]; another size removes a crop.
    #[must_use]
    pub fn with_size(self, width: usize, height: usize) -> Self {
        let part = self.part.filter(|_| (self.width, self.height) == (width, height));
        Self { width, height, part, ..self }
    }

    /// Camera of a part of the image: `width` × `height` pixels from `column` and `row`, with the rays of the whole image.
    ///
    /// # Errors
    /// If there are no pixels in it, or it goes beyond the image.
    pub fn crop(self, column: usize, row: usize, width: usize, height: usize) -> Result<Self> {
        let inside = |first: usize, count: usize, all: usize| count > 0 && first.checked_add(count).is_some_and(|end| end <= all);
        if !inside(column, width, self.width) || !inside(row, height, self.height) {
            let allowed = format!("one pixel or more within {} x {}", self.width, self.height);
            return Err(Error::out_of_range("crop", format!("{width} x {height} at column {column}, row {row}"), allowed));
        }
        let (part, half) = (width as f64 / self.width as f64, 0.5 * self.width as f64);
        let projection = self.projection.part(part);
        let right = (column as f64 + 0.5 * width as f64 - half) / half;
        let up = (0.5 * self.height as f64 - row as f64 - 0.5 * height as f64) / half;
        let offset = ((self.offset.0 + right) / part, (self.offset.1 + up) / part);
        let present = self.part.unwrap_or(ImagePart { column: 0, row: 0, whole: (self.width, self.height) });
        let part = Some(ImagePart { column: present.column + column, row: present.row + row, ..present });
        Ok(Self { projection, width, height, offset, part, ..self })
    }

    /// Copy of the camera with `rays` × `rays` rays per pixel.
    #[must_use]
    pub fn with_supersampling(self, rays: usize) -> Self {
        Self { supersampling: rays, ..self }
    }

    /// Copy of the camera with two eyes.
    #[must_use]
    pub fn with_stereo(self, stereo: Stereo) -> Self {
        Self { stereo: Some(stereo), ..self }
    }
}
