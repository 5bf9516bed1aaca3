//! Rayleigh scattering, unpolarised: p = (3/16π)(1 + cos²θ).

use std::sync::Arc;

use spectra::constants::SPHERE;
use spectra::fingerprint::Digest;

use super::{Phase, PhaseKind};
use crate::random::Counter;

pub(super) const KIND: PhaseKind =
    PhaseKind { name: "rayleigh", summary: "3/16pi (1 + cos2): small grains", keys: &[], build: |_, _, _| Ok(Arc::new(Rayleigh)) };

/// Scattering by grains far smaller than the wavelength.
#[derive(Debug, Clone, Copy)]
pub struct Rayleigh;

impl Phase for Rayleigh {
    fn content(&self, digest: &mut Digest) {
        digest.text("rayleigh");
    }
    fn at(&self, cosine: f64, _: f64) -> f64 {
        0.75 * (1.0 + cosine * cosine) / SPHERE
    }
    fn sample(&self, _: f64, random: &mut Counter) -> f64 {
        // The root of μ³ + 3μ + 4 = 8u.
        let half = 4.0 * random.uniform() - 2.0;
        let root = half.hypot(1.0);
        ((half + root).cbrt() + (half - root).cbrt()).clamp(-1.0, 1.0)
    }
    fn is_spectral(&self) -> bool {
        false
    }
}
