//! A spherical shell with soft walls.
//!
//! ρ(r) = exp(−½ ((r − R)/w)²), zero beyond 5 w from the wall.

use std::sync::Arc;

use glam::DVec3;
use spectra::fingerprint::Digest;
use spectra::units::Length;

use super::sphere::sphere_crossings;
use super::{Field, above_zero, place};
use crate::error::{Error, Result};
use crate::geometry::{Bounds, Ray};
use crate::properties::{Key, Kind, OrDefault, Position, Required};

const CENTRE: Key<Position, OrDefault> = Key::position("centre", "centre of the shell").default("0 0 0 pc");
const RADIUS: Key<Length, Required> = Key::quantity::<Length>(
    "radius",
    "radius of the wall, whose density is 1; a growing shell keeps its mass if `scale` decreases with radius² thickness",
)
.positive()
.required();
const THICKNESS: Key<Length, Required> = Key::quantity::<Length>("thickness", "standard deviation of the wall").positive().required();

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "shell",
    summary: "a spherical shell with a Gaussian wall",
    keys: &[CENTRE.row, RADIUS.row, THICKNESS.row],
    build: |section, _| {
        let centre = section.read(&CENTRE)?;
        let radius = section.read(&RADIUS)?.0;
        let thickness = section.read(&THICKNESS)?.0;
        Ok(Arc::new(section.wrap(&THICKNESS, Shell::new(centre, radius, thickness))?))
    },
};

/// The thinnest wall, in parts of its radius.
const THINNEST: f64 = 1e-4;

/// A spherical shell, one at the middle of its wall.
#[derive(Debug, Clone, PartialEq)]
pub struct Shell {
    centre: DVec3,
    radius: f64,
    thickness: f64,
}

impl Shell {
    /// A shell around `centre` \[pc\] whose wall stands at `radius_pc` and has the standard deviation `thickness_pc`.
    ///
    /// # Errors
    /// If either is not above zero, or the wall is too thin to be resolved.
    pub fn new(centre: DVec3, radius_pc: f64, thickness_pc: f64) -> Result<Self> {
        let (radius, thickness) = (above_zero("radius", radius_pc)?, above_zero("thickness", thickness_pc)?);
        if thickness < THINNEST * radius {
            let allowed = format!("at least {}, {THINNEST:e} of the radius, to be resolved", Length(THINNEST * radius));
            return Err(Error::out_of_range("thickness", Length(thickness), allowed));
        }
        Ok(Self { centre: place("centre", centre)?, radius, thickness })
    }
}

/// Cut-off of the wall, in standard deviations: 4e-6 of its height.
const CUT: f64 = 5.0;

impl Field for Shell {
    fn content(&self, digest: &mut Digest) {
        digest.plain(self);
    }
    fn at(&self, p: DVec3) -> f64 {
        let u = ((p - self.centre).length() - self.radius) / self.thickness;
        if u.abs() > CUT { 0.0 } else { (-0.5 * u * u).exp() }
    }
    fn bounds(&self) -> Bounds {
        Bounds::cube(self.centre, self.radius + CUT * self.thickness)
    }
    fn feature_pc(&self) -> f64 {
        0.5 * self.thickness
    }
    fn crossings(&self, ray: &Ray, out: &mut Vec<f64>) {
        for u in [-CUT, 0.0, CUT] {
            let radius = self.radius + u * self.thickness;
            if radius > 0.0 {
                out.extend(sphere_crossings(ray, self.centre, radius).into_iter().flatten());
            }
        }
    }
}
