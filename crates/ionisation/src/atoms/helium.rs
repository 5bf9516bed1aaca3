//! Recombination of He⁺, and what its photons do to hydrogen.
//!
//! Sources: Benjamin, Skillman & Smits 1999, ApJ 514, 307 (fits to the rates); Osterbrock & Ferland 2006, §2.4 (the
//! fates of photons); Wood, Mathis & Ercolano 2004, MNRAS 348, 1337 (584 Å).

use crate::lanes::Lanes;

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

    /// To triplets, and to excited singlets.
    pub fn to_excited(self, temperature: f64) -> [f64; 2] {
        let t = 1e-4 * temperature;
        [2.10e-13 * t.powf(-0.778), 6.23e-14 * t.powf(-0.827)]
    }

    /// To all levels but the ground.
    pub fn case_b(self, temperature: f64) -> f64 {
        self.to_excited(temperature).iter().sum()
    }
}

/// Photons that ionise hydrogen, of recombinations to triplets and to excited singlets: of 19.8 eV, of two-photon decays,
/// and of 584 Å.
///
/// `neutral` is the part of hydrogen that is neutral for that of helium: photons of 584 Å wander between atoms of helium
/// until hydrogen takes one of them, or they become two.
#[inline(always)]
pub fn photons_of_helium([triplets, singlets]: [Lanes; 2], temperature: Lanes, neutral: Lanes) -> [Lanes; 3] {
    let taken = Lanes::ONE / (Lanes::splat(77.0) / (temperature.sqrt() * neutral.at_least(f64::MIN_POSITIVE)) + 1.0);
    [triplets, singlets * TWO_PHOTON * (Lanes::ONE - taken * TO_2P), singlets * taken * TO_2P]
}
