//! A Plummer sphere, cut at a radius.
//!
//! ρ(r) = (1 + r²/a²)^(−5/2), zero beyond the cut; one in the middle.
//!
//! Source: Plummer 1911, MNRAS 71, 460.

use std::sync::Arc;

use glam::DVec3;
use spectra::fingerprint::Digest;
use spectra::units::Length;

use super::sphere::sphere_crossings;
use super::{Field, above_zero, place};
use crate::error::Result;
use crate::geometry::{Bounds, Ray};
use crate::properties::{Key, Kind, OrDefault, Position, Required};

const CENTRE: Key<Position, OrDefault> = Key::position("centre", "centre of the cluster").default("0 0 0 pc");
const CORE: Key<Length, Required> = Key::quantity::<Length>("core", "the Plummer radius a").positive().required();
const CUT: Key<Length> = Key::quantity::<Length>("cut", "radius beyond which it is zero").positive().otherwise("5 core");

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "plummer",
    summary: "(1 + r2/a2)^(-5/2), cut at a radius",
    keys: &[CENTRE.row, CORE.row, CUT.row],
    build: |section, _| {
        let core = section.read(&CORE)?.0;
        let plummer = section.wrap(&CORE, Plummer::new(section.read(&CENTRE)?, core))?;
        Ok(Arc::new(match section.read(&CUT)? {
            Some(cut) => section.wrap(&CUT, plummer.with_cut(cut.0))?,
            None => plummer,
        }))
    },
};

/// A Plummer sphere, one in the middle.
#[derive(Debug, Clone, PartialEq)]
pub struct Plummer {
    centre: DVec3,
    core: f64,
    cut: f64,
}

/// Default cut-off, in Plummer radii.
const CUT_IN_CORES: f64 = 5.0;

impl Plummer {
    /// A sphere around `centre` \[pc\] of Plummer radius `core_pc`, cut at five of them.
    ///
    /// # Errors
    /// If the radius is not above zero.
    pub fn new(centre: DVec3, core_pc: f64) -> Result<Self> {
        let core = above_zero("core", core_pc)?;
        Ok(Self { centre: place("centre", centre)?, core, cut: CUT_IN_CORES * core })
    }

    /// Zero beyond `cut_pc` from the middle.
    ///
    /// # Errors
    /// If that is not above zero.
    pub fn with_cut(self, cut_pc: f64) -> Result<Self> {
        Ok(Self { cut: above_zero("cut", cut_pc)?, ..self })
    }
}

impl Field for Plummer {
    fn content(&self, digest: &mut Digest) {
        digest.plain(self);
    }
    fn at(&self, p: DVec3) -> f64 {
        let r2 = (p - self.centre).length_squared();
        if r2 > self.cut * self.cut { 0.0 } else { (1.0 + r2 / (self.core * self.core)).powf(-2.5) }
    }
    fn bounds(&self) -> Bounds {
        Bounds::cube(self.centre, self.cut)
    }
    /// Where the cut takes away what can be seen: a five-hundredth is left at the default.
    fn has_edges(&self) -> bool {
        (1.0 + (self.cut / self.core).powi(2)).powf(-2.5) > 2e-3
    }
    fn feature_pc(&self) -> f64 {
        0.25 * self.core
    }
    fn crossings(&self, ray: &Ray, out: &mut Vec<f64>) {
        out.extend(sphere_crossings(ray, self.centre, self.cut).into_iter().flatten());
    }
}
