//! A uniform sphere: 1 inside, 0 outside.

use std::sync::Arc;

use glam::DVec3;
use spectra::fingerprint::Digest;
use spectra::units::Length;

use super::{Field, above_zero, place};
use crate::error::Result;
use crate::geometry::{Bounds, Ray};
use crate::properties::{Key, Kind, OrDefault, Position, Required};

const CENTRE: Key<Position, OrDefault> = Key::position("centre", "centre of the sphere").default("0 0 0 pc");
const RADIUS: Key<Length, Required> = Key::quantity::<Length>("radius", "radius of the sphere").positive().required();

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "sphere",
    summary: "1 inside of a sphere",
    keys: &[CENTRE.row, RADIUS.row],
    build: |section, _| {
        let centre = section.read(&CENTRE)?;
        let radius = section.read(&RADIUS)?.0;
        Ok(Arc::new(section.wrap(&RADIUS, Sphere::new(centre, radius))?))
    },
};

/// A uniform sphere of density 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Sphere {
    centre: DVec3,
    radius: f64,
}

impl Sphere {
    /// A sphere around `centre` \[pc\] of radius `radius_pc`.
    ///
    /// # Errors
    /// If the radius is not above zero.
    pub fn new(centre: DVec3, radius_pc: f64) -> Result<Self> {
        Ok(Self { centre: place("centre", centre)?, radius: above_zero("radius", radius_pc)? })
    }
}

/// Distances at which a ray meets a sphere.
pub(super) fn sphere_crossings(ray: &Ray, centre: DVec3, radius: f64) -> Option<[f64; 2]> {
    let along = (centre - ray.origin).dot(ray.direction);
    let beside = (ray.at(along) - centre).length_squared();
    let half = (radius * radius - beside).max(0.0).sqrt();
    (half > 0.0).then_some([along - half, along + half])
}

impl Field for Sphere {
    fn content(&self, digest: &mut Digest) {
        digest.plain(self);
    }
    fn at(&self, p: DVec3) -> f64 {
        f64::from((p - self.centre).length_squared() < self.radius * self.radius)
    }
    fn bounds(&self) -> Bounds {
        Bounds::cube(self.centre, self.radius)
    }
    fn has_edges(&self) -> bool {
        true
    }
    fn crossings(&self, ray: &Ray, out: &mut Vec<f64>) {
        out.extend(sphere_crossings(ray, self.centre, self.radius).into_iter().flatten());
    }
}
