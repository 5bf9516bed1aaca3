//! Barrès & Neyret's law: extinction proportional to 1/λ.
//!
//! k(λ) = 0.55 µm / λ
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | λ | `lambda_um` | µm |
//!
//! Valid for all λ > 0. Source: Barrès & Neyret 2023 (INRIA); a fair fit of Milky Way dust between 0.3 and 1 µm.

use super::{ExtinctionLaw, LawEntry, Maker};
use crate::constants::V_WAVELENGTH_UM;
use crate::fingerprint::Digest;

pub(super) const ENTRY: LawEntry = LawEntry {
    name: "inverse_wavelength",
    summary: "k = 0.55 um / lambda, the assumption of Barres & Neyret 2023; all wavelengths",
    maker: Maker::Fixed(|| Ok(Box::new(InverseWavelength))),
};

#[derive(Debug)]
struct InverseWavelength;

impl ExtinctionLaw for InverseWavelength {
    fn content(&self, digest: &mut Digest) {
        digest.text("inverse_wavelength");
    }
    fn k(&self, lambda_um: f64) -> f64 {
        V_WAVELENGTH_UM / lambda_um
    }
    fn range_um(&self) -> (f64, f64) {
        (0.0, f64::INFINITY)
    }
}
