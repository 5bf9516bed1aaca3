//! Recombination of He⁺, and what its photons do to hydrogen.
//!
//! Sources: Benjamin, Skillman & Smits 1999, ApJ 514, 307 (fits to the rates); Osterbrock & Ferland 2006, §2.4 (the
//! fates of photons); Wood, Mathis & Ercolano 2004, MNRAS 348, 1337 (584 Å).

use super::BOLTZMANN_EV;

/// Rates of He⁺; temperatures are in K, rates in cm³ s⁻¹.
#[derive(Debug, Clone, Copy)]
pub struct Helium;

/// The photon with which triplets reach the ground level \[eV\].
pub const TRIPLET_EV: f64 = 19.82;
/// That of 584 Å, from 2 ¹P \[eV\].
pub const LYMAN_ALPHA_EV: f64 = 21.22;
/// The mean of those photons above 13.6 eV into which 2 ¹S decays: between 13.6 and 20.6 eV, more of them below \[eV\].
pub const TWO_PHOTON_EV: f64 = 16.0;
/// Photons above 13.6 eV of such a decay. Source: Osterbrock & Ferland 2006, §2.4.
const TWO_PHOTON: f64 = 0.56;
/// The part of recombinations to excited singlets that end in 2 ¹P; the others end in 2 ¹S. Source: Wood et al. 2004.
const TO_2P: f64 = 4.17 / 6.23;

impl Helium {
    /// To the ground level.
    pub fn to_ground(self, temperature: f64) -> f64 {
        1.54e-13 * (1e-4 * temperature).powf(-0.486)
    }

    /// To all levels but the ground.
    pub fn case_b(self, temperature: f64) -> f64 {
        self.to_triplets(temperature) + self.to_singlets(temperature)
    }

    fn to_triplets(self, temperature: f64) -> f64 {
        2.10e-13 * (1e-4 * temperature).powf(-0.778)
    }

    fn to_singlets(self, temperature: f64) -> f64 {
        6.23e-14 * (1e-4 * temperature).powf(-0.827)
    }

    /// Photons that ionise hydrogen, of recombinations to excited levels, per electron and ion: of 19.8 eV, of two-photon
    /// decays, and of 584 Å.
    ///
    /// `neutral` is n(H⁰)/n(He⁰): photons of 584 Å wander between atoms of helium until hydrogen takes one of them, or
    /// they become two.
    pub fn photons(self, temperature: f64, neutral: f64) -> [f64; 3] {
        let taken = 1.0 / (1.0 + 77.0 / (temperature.sqrt() * neutral.max(f64::MIN_POSITIVE)));
        let singlets = self.to_singlets(temperature);
        [self.to_triplets(temperature), TWO_PHOTON * singlets * (1.0 - TO_2P * taken), TO_2P * singlets * taken]
    }

    /// The kinetic energy that recombination to excited levels takes \[eV cm³ s⁻¹\]: as much of k T as for hydrogen.
    pub fn case_b_cooling(self, temperature: f64, of_hydrogen: f64) -> f64 {
        self.case_b(temperature) * of_hydrogen * BOLTZMANN_EV * temperature
    }
}
