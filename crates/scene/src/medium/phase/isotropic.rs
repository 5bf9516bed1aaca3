//! Isotropic scattering: p = 1/4π.

use std::sync::Arc;

use spectra::constants::SPHERE;
use spectra::fingerprint::Digest;

use super::{Phase, PhaseKind};
use crate::random::Counter;

pub(super) const KIND: PhaseKind =
    PhaseKind { name: "isotropic", summary: "the same in all directions", keys: &[], build: |_, _, _| Ok(Arc::new(Isotropic)) };

/// Scattering that is the same in all directions.
#[derive(Debug, Clone, Copy)]
pub struct Isotropic;

impl Phase for Isotropic {
    fn content(&self, digest: &mut Digest) {
        digest.text("isotropic");
    }
    fn at(&self, _: f64, _: f64) -> f64 {
        1.0 / SPHERE
    }
    fn sample(&self, _: f64, random: &mut Counter) -> f64 {
        2.0 * random.uniform() - 1.0
    }
    fn is_isotropic(&self) -> bool {
        true
    }
    fn is_spectral(&self) -> bool {
        false
    }
}
