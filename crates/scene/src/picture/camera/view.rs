//! Camera matrices: what OpenEXR and programs that lay pictures over each other ask for.

use super::{Camera, Projection};
use crate::image::View;

impl Camera {
    /// World coordinates of its picture; `None` if it is not a flat picture of one eye.
    pub fn view(&self) -> Option<View> {
        let axes = [self.right, self.up, self.forward];
        // The number that divides: the depth, or one.
        let (half_width, is_perspective) = match self.projection {
            Projection::Perspective { half_width } => (half_width, true),
            Projection::Orthographic { half_width_pc } => (half_width_pc, false),
            Projection::Panorama { .. } => return None,
        };
        if self.stereo.is_some() {
            return None;
        }
        let row = |world: usize| -> [f64; 3] { axes.map(|axis| axis[world]) };
        let origin = axes.map(|axis| -self.position.dot(axis));
        let vec4 = |v: [f64; 3], last: f64| [v[0], v[1], v[2], last];
        let world_to_camera = [vec4(row(0), 0.0), vec4(row(1), 0.0), vec4(row(2), 0.0), vec4(origin, 1.0)];
        let (width, height) = (self.width as f64, self.height as f64);
        let (column, line, whole) = match self.part {
            Some(part) => (part.column as f64, part.row as f64, (part.whole.0 as f64, part.whole.1 as f64)),
            None => (0.0, 0.0, (width, height)),
        };
        let middle =
            [(column + 0.5 * width * (1.0 - self.offset.0)) / whole.0, (line + 0.5 * height + 0.5 * width * self.offset.1) / whole.1];
        let scale = [0.5 * width / (whole.0 * half_width), -0.5 * width / (whole.1 * half_width)];
        let world_to_screen = world_to_camera.map(|[x, y, z, one]| {
            let divisor = if is_perspective { z } else { one };
            let depth = if is_perspective { one } else { z };
            [scale[0] * x + middle[0] * divisor, scale[1] * y + middle[1] * divisor, depth, divisor]
        });
        Some(View { world_to_camera, world_to_screen })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn times(p: DVec3, matrix: &[[f64; 4]; 4]) -> [f64; 4] {
        let p = [p.x, p.y, p.z, 1.0];
        std::array::from_fn(|j| (0..4).map(|i| p[i] * matrix[i][j]).sum())
    }

    /// Places come where the camera has them, in whole pictures and in parts of one.
    #[test]
    fn places_come_where_they_are_seen() {
        let base =
            Camera::look_at(DVec3::new(3.0, -1.0, 7.0), DVec3::new(0.2, 0.4, -0.3)).with_up(DVec3::new(0.3, 1.0, 0.1)).with_size(120, 80);
        let flat = base.clone().with_field_of_view_deg(37.0);
        let parallel = base.with_orthographic_pc(4.0);
        for camera in [flat.clone(), parallel.clone(), flat.crop(17, 31, 40, 23).unwrap(), parallel.crop(3, 5, 60, 70).unwrap()] {
            let view = camera.view().unwrap();
            for p in [DVec3::new(0.3, 0.7, 0.1), DVec3::new(-1.0, 0.5, 0.6), DVec3::new(0.8, -0.9, -2.0)] {
                let (column, row) = camera.project(p).unwrap();
                let part = camera.part.unwrap_or(crate::image::ImagePart { column: 0, row: 0, whole: (120, 80) });
                let seen = times(p, &view.world_to_screen);
                assert!((seen[0] / seen[3] * 120.0 - (column + part.column as f64)).abs() < 1e-9);
                assert!((seen[1] / seen[3] * 80.0 - (row + part.row as f64)).abs() < 1e-9);
                let p_camera = times(p, &view.world_to_camera);
                let away = p - camera.position;
                assert!((DVec3::new(p_camera[0], p_camera[1], p_camera[2]).length() - away.length()).abs() < 1e-12);
                assert!((p_camera[2] - away.dot(camera.forward)).abs() < 1e-12 && p_camera[3] == 1.0);
            }
        }
        assert_eq!(Camera::look_at(DVec3::Z, DVec3::ZERO).with_cubemap(16).view(), None);
    }
}
