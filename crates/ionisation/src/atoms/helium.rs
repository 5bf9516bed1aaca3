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
/// Energy of the 584 Å line, from 2 ¹P \[eV\].
pub const LYMAN_ALPHA_EV: f64 = 21.22;
/// The mean of those photons above 13.6 eV into which 2 ¹S decays: between 13.6 and 20.6 eV, more of them below \[eV\].
pub const TWO_PHOTON_EV: f64 = 16.0;
/// Photons above 13.6 eV of such a decay. Source: Osterbrock & Ferland 2006, §2.4.
const TWO_PHOTON: f64 = 0.56;
/// The part of recombinations to excited singlets that end in 2 ¹P; the others end in 2 ¹S. Source: Wood et al. 2004.
const TO_2P: f64 = 4.17 / 6.23;

/// Photons of recombining He²⁺, for one that is caught into an excited level.
///
/// Three of ten cascades end in 2 ²S, as hydrogen's do at a quarter of the temperature, all others in 2 ²P: those give a
/// photon of 40.8 eV. Of two photons 0.69 have from 13.6 to 24.6 eV, 19.1 on average, and 0.74 more, 31.1 on average.
///
/// Sources: Osterbrock & Ferland 2006, §2.4 and table 4.11 (cascades); Nussbaumer & Schmutz 1984, A&A 138, 495 (two photons);
/// Seaton 1959, MNRAS 119, 81 (captures into n = 2, at 15 000 K).
pub const STRIPPED: Stripped = Stripped { hard: 0.7 + 0.3 * 0.736, soft: 0.3 * 0.689, captures: 0.26 };
/// The mean energy of the hard ones \[eV\].
pub const STRIPPED_EV: f64 = (0.7 * 40.81 + 0.3 * 0.736 * 31.1) / (0.7 + 0.3 * 0.736);

/// See [`STRIPPED`].
#[derive(Debug, Clone, Copy)]
pub struct Stripped {
    /// Photons that ionise helium as well: Lyman α, and the harder ones of two photons.
    pub hard: f64,
    /// The softer ones of two photons, of about as much as those of triplets of helium.
    pub soft: f64,
    /// Captures into n = 2: photons above hydrogen's threshold, which give what the electron had.
    pub captures: f64,
}

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
