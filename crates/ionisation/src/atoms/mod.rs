//! Atoms: cross sections, rates and line emissivities from published fits, in the units of the field (cm, s, eV, K).

mod charge_exchange;
mod element;
mod helium;
mod hydrogen;
mod lines;
mod photoionisation;
mod recombination;

pub use charge_exchange::{Exchange, Partner};
pub use element::{ELEMENTS, Element, STAGES};
pub use helium::{Helium, LYMAN_ALPHA_EV, STRIPPED, STRIPPED_EV, Stripped, TRIPLET_EV, TWO_PHOTON_EV, photons_of_helium};
pub use hydrogen::Hydrogen;
pub use lines::{Conditions, EmissionLine, LineTable};
pub use photoionisation::CrossSection;
pub use recombination::{Dielectronic, Radiative};

use std::sync::OnceLock;

use spectra::constants::{BOLTZMANN, ELECTRONVOLT};

/// Boltzmann's constant \[eV K⁻¹\].
pub const BOLTZMANN_EV: f64 = BOLTZMANN / ELECTRONVOLT;
/// Ionisation energy of hydrogen \[eV\].
pub const HYDROGEN_EV: f64 = 13.6;
/// Ionisation energy of helium \[eV\].
pub const HELIUM_EV: f64 = 24.59;
/// The electronvolt \[erg\].
pub const ERG_PER_EV: f64 = 1e7 * ELECTRONVOLT;

/// Rates between charges q and q + 1.
#[derive(Debug, Clone, Default)]
pub struct Transition {
    /// Light that takes an electron away.
    pub light: Option<CrossSection>,
    /// The higher ion catches an electron and shines.
    pub radiative: Option<Radiative>,
    /// It catches one and lifts another.
    pub dielectronic: Option<Dielectronic>,
    /// The lower ion gives an electron to H⁺.
    pub to_proton: Option<Exchange>,
    /// The higher ion takes one from H⁰.
    pub from_hydrogen: Option<Exchange>,
}

impl Transition {
    /// Recombination to all levels, by electrons alone \[cm³ s⁻¹\].
    pub fn recombination(&self, temperature: f64) -> f64 {
        let radiative = self.radiative.as_ref().map_or(0.0, |fit| fit.at(temperature));
        radiative + self.dielectronic.as_ref().map_or(0.0, |fit| fit.at(temperature))
    }
}

/// All atomic data.
#[derive(Debug)]
pub struct Atoms {
    /// By element and charge of the lower ion.
    transitions: [[Transition; STAGES]; ELEMENTS],
    /// Hydrogen.
    pub hydrogen: Hydrogen,
    /// Recombination of He⁺.
    pub helium: Helium,
    /// Lines that electrons excite: they cool.
    pub collisional: LineTable,
    /// Lines that recombination feeds.
    pub recombination: LineTable,
}

impl Atoms {
    /// The data that come with the crate.
    ///
    /// # Panics
    /// Where an embedded table is broken; a test reads all of them.
    pub fn get() -> &'static Self {
        static ATOMS: OnceLock<Atoms> = OnceLock::new();
        ATOMS.get_or_init(Self::read)
    }

    /// Ionisation rate of an element from `charge` to the next charge.
    pub fn transition(&self, element: Element, charge: usize) -> &Transition {
        &self.transitions[element as usize][charge]
    }

    fn read() -> Self {
        let mut transitions: [[Transition; STAGES]; ELEMENTS] = Default::default();
        let mut at = |element: Element, charge: usize, put: &mut dyn FnMut(&mut Transition)| {
            if let Some(transition) = transitions[element as usize].get_mut(charge).filter(|_| charge < element.charges()) {
                put(transition);
            }
        };
        photoionisation::read(|element, charge, fit| at(element, charge, &mut |transition| transition.light = Some(fit.clone())));
        recombination::radiative(|element, charge, fit| {
            at(element, charge - 1, &mut |transition| transition.radiative = Some(fit.clone()))
        });
        recombination::dielectronic(|element, charge, fit| {
            at(element, charge - 1, &mut |transition| transition.dielectronic = Some(fit.clone()))
        });
        charge_exchange::read(|element, charge, partner, fit| match partner {
            Partner::Proton => at(element, charge, &mut |transition| transition.to_proton = Some(fit.clone())),
            Partner::Hydrogen => at(element, charge - 1, &mut |transition| transition.from_hydrogen = Some(fit.clone())),
        });
        Self {
            transitions,
            hydrogen: Hydrogen::read(),
            helium: Helium,
            collisional: LineTable::read("cooling lines", include_str!("../../data/cooling_lines.csv"), 0),
            recombination: LineTable::read("recombination lines", include_str!("../../data/recombination_lines.csv"), 1),
        }
    }
}
