//! A spherical shell with soft walls.
//!
//! ρ(r) = exp(−½ ((r − R)/w)²), zero beyond 5 w from the wall.

use std::sync::Arc;

use glam::DVec3;
use spectra::units::Length;

use super::Field;
use super::sphere::sphere_crossings;
use crate::geometry::{Bounds, Ray};
use crate::scene::{Key, Kind};

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "shell",
    summary: "a spherical shell with a Gaussian wall",
    keys: &[
        Key::optional("centre", "position", "0 0 0 pc", "its middle"),
        Key::required("radius", "length", "radius of the wall"),
        Key::required("thickness", "length", "standard deviation of the wall"),
    ],
    build: |section, _| {
        let centre = section.position("centre")?.unwrap_or(DVec3::ZERO);
        let radius = section.need_positive::<Length>("radius")?.0;
        let thickness = section.need_positive::<Length>("thickness")?.0;
        if thickness < THINNEST * radius {
            let message = format!(
                "a wall thinner than {THINNEST:e} of its radius cannot be resolved; a {} of radius asks for {} at least",
                Length(radius),
                Length(THINNEST * radius)
            );
            return Err(section.error("thickness", message));
        }
        Ok(Arc::new(Shell { centre, radius, thickness }))
    },
};

/// The thinnest wall, in parts of its radius.
const THINNEST: f64 = 1e-4;

#[derive(Debug)]
struct Shell {
    centre: DVec3,
    radius: f64,
    thickness: f64,
}

/// Where the wall is cut, in standard deviations: 4e-6 of its height.
const CUT: f64 = 5.0;

impl Field for Shell {
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
