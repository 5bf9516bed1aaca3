//! Draine's phase function, between Rayleigh and Henyey–Greenstein.
//!
//! p = (1/4π) (1 − g²)/(1 + α(1 + 2g²)/3) · (1 + α cos²θ)/(1 + g² − 2 g cos θ)^(3/2)
//!
//! α = 0: Henyey–Greenstein; g = 0, α = 1: Rayleigh. Source: Draine 2003, ApJ 598, 1017, eq. 4. Here g is its shape
//! parameter; with α ≠ 0 the mean cosine is larger (his eq. 5).

use std::sync::Arc;

use spectra::constants::SPHERE;
use spectra::fingerprint::Digest;

use super::henyey_greenstein::{draw, henyey_greenstein};
use super::{G_FILE, MeanCosine, Phase, PhaseKind, mean_cosine};
use crate::curve::{COLUMN, UNIT};
use crate::error::Result;
use crate::properties::{Key, Number, OrDefault};
use crate::random::Counter;

const G: Key<Number> = mean_cosine("shape parameter");
const ALPHA: Key<Number, OrDefault> =
    Key::number("alpha", "0 is Henyey-Greenstein, 1 with g = 0 is Rayleigh").range(0.0..=1e3).default(1.0);

pub(super) const KIND: PhaseKind = PhaseKind {
    name: "draine",
    summary: "Draine 2003 with g(lambda) and alpha: between Rayleigh and Henyey-Greenstein",
    keys: &[G.row, G_FILE.row, UNIT.row, COLUMN.row, ALPHA.row],
    build: |section, inputs, extinction| {
        let g = MeanCosine::read(section, inputs, extinction)?;
        Ok(Arc::new(section.wrap(&G, Draine::new(g, section.read(&ALPHA)?))?))
    },
};

/// Draine's phase function, between Rayleigh's and Henyey and Greenstein's.
#[derive(Debug, Clone)]
pub struct Draine {
    g: MeanCosine,
    alpha: f64,
}

impl Draine {
    /// A phase function of shape parameter `g`, a number or a table over λ, and of `alpha`.
    ///
    /// # Errors
    /// If |g| is above 0.999, or α outside of 0 to 1000.
    pub fn new(g: impl Into<MeanCosine>, alpha: f64) -> Result<Self> {
        ALPHA.check(alpha)?;
        Ok(Self { g: g.into().checked()?, alpha })
    }
}

impl Phase for Draine {
    fn content(&self, digest: &mut Digest) {
        self.g.add_to(digest.text("draine").number(self.alpha));
    }
    fn at(&self, cosine: f64, lambda_um: f64) -> f64 {
        let g = self.g.at(lambda_um);
        let norm = 1.0 + self.alpha * (1.0 + 2.0 * g * g) / 3.0;
        henyey_greenstein(cosine, g) * (1.0 + self.alpha * cosine * cosine) / (norm * SPHERE)
    }
    fn sample(&self, lambda_um: f64, random: &mut Counter) -> f64 {
        // One of Henyey & Greenstein's is kept with the chance (1 + α cos²θ)/(1 + α): every third at least.
        loop {
            let cosine = draw(self.g.at(lambda_um), random);
            if random.uniform() * (1.0 + self.alpha) < 1.0 + self.alpha * cosine * cosine {
                return cosine;
            }
        }
    }
    fn is_spectral(&self) -> bool {
        matches!(self.g, MeanCosine::Table(_))
    }
}
