//! A slab: 1 between two planes, within a box.

use std::sync::Arc;

use glam::DVec3;
use spectra::units::Length;

use super::Field;
use crate::geometry::{Bounds, Ray};
use crate::scene::{Key, Kind};

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "slab",
    summary: "1 between two planes of any orientation, within a cube",
    keys: &[
        Key::optional("centre", "position", "0 0 0 pc", "a point on its middle plane, and middle of the cube"),
        Key::optional("normal", "direction", "[0, 0, 1]", "its normal"),
        Key::required("thickness", "length", "distance of the planes"),
        Key::required("extent", "length", "half side of the cube that ends it"),
    ],
    build: |section, _| {
        let slab = Slab {
            centre: section.position("centre")?.unwrap_or(DVec3::ZERO),
            normal: section.direction("normal")?.unwrap_or(DVec3::Z),
            half: 0.5 * section.need_positive::<Length>("thickness")?.0,
            extent: section.need_positive::<Length>("extent")?.0,
        };
        Ok(Arc::new(slab))
    },
};

#[derive(Debug)]
struct Slab {
    centre: DVec3,
    normal: DVec3,
    half: f64,
    extent: f64,
}

impl Field for Slab {
    fn at(&self, p: DVec3) -> f64 {
        f64::from(self.bounds().contains(p) && (p - self.centre).dot(self.normal).abs() <= self.half)
    }
    fn bounds(&self) -> Bounds {
        Bounds::cube(self.centre, self.extent)
    }
    fn has_edges(&self) -> bool {
        true
    }
    fn crossings(&self, ray: &Ray, out: &mut Vec<f64>) {
        out.extend(self.bounds().clip(ray).into_iter().flat_map(|(a, b)| [a, b]));
        let (start, slope) = ((ray.origin - self.centre).dot(self.normal), ray.direction.dot(self.normal));
        if slope != 0.0 {
            out.extend([(-self.half - start) / slope, (self.half - start) / slope]);
        }
    }
}
