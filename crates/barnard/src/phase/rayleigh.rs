//! Rayleigh scattering, unpolarised: p = (3/16π)(1 + cos²θ).

use std::sync::Arc;

use spectra::constants::SPHERE;

use super::{Phase, PhaseKind};

pub(super) const KIND: PhaseKind =
    PhaseKind { name: "rayleigh", summary: "3/16pi (1 + cos2): small grains", keys: &[], build: |_, _, _| Ok(Arc::new(Rayleigh)) };

#[derive(Debug)]
pub(super) struct Rayleigh;

impl Phase for Rayleigh {
    fn at(&self, cosine: f64, _: f64) -> f64 {
        0.75 * (1.0 + cosine * cosine) / SPHERE
    }
    fn is_spectral(&self) -> bool {
        false
    }
}
