//! A uniform box: 1 inside, 0 outside.

use std::sync::Arc;

use glam::DVec3;

use spectra::fingerprint::Digest;

use super::Field;
use crate::error::Result;
use crate::geometry::{Bounds, Ray};
use crate::properties::{Key, Kind, Position, Required};

const LOW: Key<Position, Required> = Key::position("low", "lowest corner").required().example("\"-1 -1 -1 pc\"");
const HIGH: Key<Position, Required> = Key::position("high", "highest corner").required().example("\"1 1 1 pc\"");

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "box",
    summary: "1 inside an axis-aligned box",
    keys: &[LOW.row, HIGH.row],
    build: |section, _| {
        let bounds = section.bounds(&LOW, &HIGH)?;
        Ok(Arc::new(section.wrap(&HIGH, Cuboid::new(bounds))?))
    },
};

/// A uniform box of density 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Cuboid {
    bounds: Bounds,
}

impl Cuboid {
    /// A cuboid that fills `bounds`.
    ///
    /// # Errors
    /// If `bounds` is no box of finite size.
    pub fn new(bounds: Bounds) -> Result<Self> {
        Ok(Self { bounds: bounds.checked()? })
    }
}

impl Field for Cuboid {
    fn content(&self, digest: &mut Digest) {
        digest.plain(self);
    }
    fn at(&self, p: DVec3) -> f64 {
        f64::from(self.bounds.contains(p))
    }
    fn bounds(&self) -> Bounds {
        self.bounds
    }
    fn has_edges(&self) -> bool {
        true
    }
    fn crossings(&self, ray: &Ray, out: &mut Vec<f64>) {
        out.extend(self.bounds.clip(ray).into_iter().flat_map(|(a, b)| [a, b]));
    }
}
