//! Henyey–Greenstein.
//!
//! p = (1/4π) (1 − g²) / (1 + g² − 2 g cos θ)^(3/2)
//!
//! Source: Henyey & Greenstein 1941, ApJ 93, 70.

use std::sync::Arc;

use spectra::constants::SPHERE;
use spectra::fingerprint::Digest;

use super::{G_FILE, MeanCosine, Phase, PhaseKind, mean_cosine};
use crate::curve::{COLUMN, UNIT};
use crate::error::Result;
use crate::properties::{Key, Number};
use crate::random::Counter;

const G: Key<Number> = mean_cosine("mean cosine");

pub(super) const KIND: PhaseKind = PhaseKind {
    name: "henyey_greenstein",
    summary: "Henyey & Greenstein 1941 with mean cosine g(lambda)",
    keys: &[G.row, G_FILE.row, UNIT.row, COLUMN.row],
    build: |section, inputs, extinction| {
        let g = MeanCosine::read(section, inputs, extinction)?;
        Ok(Arc::new(section.wrap(&G, HenyeyGreenstein::new(g))?))
    },
};

/// Henyey & Greenstein's phase function.
#[derive(Debug, Clone)]
pub struct HenyeyGreenstein {
    g: MeanCosine,
}

impl HenyeyGreenstein {
    /// A phase function of mean cosine `g`, a number or a table over λ.
    ///
    /// # Errors
    /// If |g| is above 0.999.
    pub fn new(g: impl Into<MeanCosine>) -> Result<Self> {
        Ok(Self { g: g.into().checked()? })
    }
}

/// (1 − g²) / (1 + g² − 2 g cos θ)^(3/2)
pub(super) fn henyey_greenstein(cosine: f64, g: f64) -> f64 {
    (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine).max(1e-12).powf(1.5)
}

/// Below this |g| the inverse is its first order in g: what is left out is g².
const NEARLY_FLAT: f64 = 1e-4;

/// A cos θ drawn by inverting the distribution.
pub(super) fn draw(g: f64, random: &mut Counter) -> f64 {
    let even = 2.0 * random.uniform() - 1.0;
    if g.abs() < NEARLY_FLAT {
        return even + 1.5 * g * (1.0 - even * even);
    }
    let s = (1.0 - g * g) / (1.0 + g * even);
    ((1.0 + g * g - s * s) / (2.0 * g)).clamp(-1.0, 1.0)
}

impl Phase for HenyeyGreenstein {
    fn content(&self, digest: &mut Digest) {
        self.g.add_to(digest.text("henyey_greenstein"));
    }
    fn at(&self, cosine: f64, lambda_um: f64) -> f64 {
        henyey_greenstein(cosine, self.g.at(lambda_um)) / SPHERE
    }
    fn sample(&self, lambda_um: f64, random: &mut Counter) -> f64 {
        draw(self.g.at(lambda_um), random)
    }
    fn is_spectral(&self) -> bool {
        matches!(self.g, MeanCosine::Table(_))
    }
}
