//! A slab: 1 between two planes, within a box.

use std::sync::Arc;

use glam::DVec3;
use spectra::fingerprint::Digest;
use spectra::units::Length;

use super::{Field, above_zero, place, unit};
use crate::error::Result;
use crate::geometry::{Bounds, Ray};
use crate::properties::{Direction, Key, Kind, OrDefault, Position, Required};

const CENTRE: Key<Position, OrDefault> = Key::position("centre", "centre of the cube, on the middle plane").default("0 0 0 pc");
const NORMAL: Key<Direction, OrDefault> = Key::direction("normal", "normal of the planes").default(&[0.0, 0.0, 1.0]);
const THICKNESS: Key<Length, Required> = Key::quantity::<Length>("thickness", "distance of the planes").positive().required();
const EXTENT: Key<Length, Required> = Key::quantity::<Length>("extent", "half edge of the bounding cube").positive().required();

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "slab",
    summary: "1 between two planes of any orientation, within a cube",
    keys: &[CENTRE.row, NORMAL.row, THICKNESS.row, EXTENT.row],
    build: |section, _| {
        let centre = section.read(&CENTRE)?;
        let normal = section.read(&NORMAL)?;
        let (thickness, extent) = (section.read(&THICKNESS)?.0, section.read(&EXTENT)?.0);
        Ok(Arc::new(section.wrap(&EXTENT, Slab::new(centre, normal, thickness, extent))?))
    },
};

/// A slab of density 1 that a box ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Slab {
    centre: DVec3,
    normal: DVec3,
    half: f64,
    extent: f64,
}

impl Slab {
    /// A slab `thickness_pc` thick across `normal` around `centre` \[pc\], within a cube of half side `extent_pc`.
    ///
    /// # Errors
    /// If a length is not above zero, or `normal` is no direction.
    pub fn new(centre: DVec3, normal: DVec3, thickness_pc: f64, extent_pc: f64) -> Result<Self> {
        let half = 0.5 * above_zero("thickness", thickness_pc)?;
        Ok(Self { centre: place("centre", centre)?, normal: unit("normal", normal)?, half, extent: above_zero("extent", extent_pc)? })
    }
}

impl Field for Slab {
    fn content(&self, digest: &mut Digest) {
        digest.plain(self);
    }
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
