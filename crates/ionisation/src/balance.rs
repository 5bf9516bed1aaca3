//! Gas in balance with light: as many ionisations as recombinations of every ion, as much heat as is radiated.
//!
//! Equations (G5) and (G6) of docs/gas.md. Light of recombinations is absorbed where it is made (on the spot), or goes
//! outward with the star's: then the gas recombines to its ground level as well, and says how many photons it makes.
//!
//! Left out: collisions out of helium's 2 ³S, heat by dust, and what is not in balance. Lines
//! are tabulated from 1000 to 30 000 K and stay as they are beyond.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | Γ | rate of ionisations by light, of an ion | s⁻¹ |
//! | n_e | electrons | cm⁻³ |
//! | T | temperature of electrons | K |

use crate::atoms::{
    Atoms, ELEMENTS, ERG_PER_EV, Element, HELIUM_EV, HYDROGEN_EV, LYMAN_ALPHA_EV, STAGES, STRIPPED, STRIPPED_EV, TRIPLET_EV, TWO_PHOTON_EV,
    photons_of_helium,
};
use crate::coefficients::{Coefficients, Of};
use crate::lanes::Lanes;
use crate::light::{ABSORBERS, IONS, IonisingLight, NODES, OWN_NODES, ion};
pub use crate::state::{COLDEST, Gas, GasState, HOTTEST, States};
pub use crate::thermostat::{SLOPE, Thermostat};

/// Photoionisation rates of each ion, in the order of [`ion`].
#[derive(Debug, Clone)]
pub struct Photo {
    /// Ionisations \[s⁻¹\]. As weights between nodes may be negative, where next to no light is left so may this: it counts
    /// as none then.
    pub rates: [Lanes; IONS],
    /// The energy that electrons get of it \[eV s⁻¹\].
    pub heat: [Lanes; IONS],
    /// Ionisations of [`ABSORBERS`] that give what an electron had before it recombined \[s⁻¹\].
    pub thermal: [Lanes; ABSORBERS.len()],
}

impl Photo {
    /// Rates per photon flux at each node \[s⁻¹ cm⁻²\].
    #[inline(always)]
    pub fn new(light: &IonisingLight, flux: &[Lanes; NODES]) -> Self {
        let mut photo = Self { rates: [Lanes::ZERO; IONS], heat: [Lanes::ZERO; IONS], thermal: [Lanes::ZERO; ABSORBERS.len()] };
        for (ion, absorptions) in &light.ions {
            let (mut rate, mut heat) = (Lanes::ZERO, Lanes::ZERO);
            for absorption in absorptions {
                rate += flux[absorption.node] * absorption.sigma;
                heat += flux[absorption.node] * absorption.heat;
            }
            (photo.rates[*ion], photo.heat[*ion]) = (rate, heat);
        }
        for (number, (element, charge)) in ABSORBERS.into_iter().enumerate() {
            let (mut rate, mut heat) = (Lanes::ZERO, Lanes::ZERO);
            for (node, flux) in flux.iter().enumerate().take(light.energies_ev.len()) {
                rate += *flux * light.weakening[number][node];
                heat += *flux * light.warming[number][node];
            }
            (photo.rates[ion(element, charge)], photo.heat[ion(element, charge)]) = (rate, heat);
            for (flux, sigma) in flux.iter().zip(&light.thermal[number]) {
                photo.thermal[number] += *flux * *sigma;
            }
        }
        photo
    }
}

/// Treatment of diffuse light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Diffuse {
    /// Absorbed in place.
    OnTheSpot,
    /// Farther from the star, along its rays.
    #[default]
    Outward,
}

/// How exactly a balance is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// True if rates are those of the fits themselves, or between rows of a table.
    pub is_exact: bool,
    /// The relative change at which ionisation and light are taken to have settled, twice that of the temperature \[1\].
    pub settled: f64,
    /// The largest depth of a step along a ray at a node that still has light \[1\].
    pub depth: f64,
    /// The longest step in parts of the way from the star \[1\].
    pub thickness: f64,
    /// Light of a node that counts for that, in parts of all of it \[1\].
    pub counts: f64,
    /// Fraction of the light below which a beam ends \[1\].
    pub used_up: f64,
}

impl Accuracy {
    /// Accuracy of the reference.
    pub const REFERENCE: Self = Self { is_exact: true, settled: 1e-7, depth: 0.1, thickness: 0.01, counts: 1e-6, used_up: 1e-5 };
    /// Accuracy of a first look.
    pub const COARSE: Self = Self { is_exact: false, settled: 3e-2, depth: 1.0, thickness: 0.15, counts: 3e-3, used_up: 1e-4 };
    /// Accuracy for clouds in three dimensions.
    pub const FAST: Self = Self { is_exact: false, settled: 1e-2, depth: 0.3, thickness: 0.12, counts: 1e-3, used_up: 1e-4 };
}

/// Gas of several beams under light.
pub struct Balance<'a> {
    /// Nuclei of hydrogen \[cm⁻³\].
    pub hydrogen: Lanes,
    /// Nuclei of each element for one of hydrogen.
    pub abundances: &'a [f64; ELEMENTS],
    /// Photoionisation rates.
    pub photo: &'a Photo,
    /// Treatment of its diffuse light.
    pub diffuse: Diffuse,
    /// Rates at the temperature of the state.
    pub coefficients: &'a Coefficients,
    /// Cross sections of H⁰ and He⁰ for photons that are absorbed where they are made.
    pub near: &'a Near,
}

/// Cross sections of H⁰ and He⁰ \[cm²\].
#[derive(Debug, Clone, Copy)]
pub struct Near {
    /// For photons of 24.6 eV.
    helium: [f64; 2],
    /// For the hard ones of [`STRIPPED`].
    hard: [f64; 2],
}

impl Default for Near {
    fn default() -> Self {
        let at = |energy: f64| {
            [Element::Hydrogen, Element::Helium]
                .map(|element| Atoms::get().transition(element, 0).light.as_ref().map_or(0.0, |fit| fit.at(energy)))
        };
        Self { helium: at(HELIUM_EV), hard: at(STRIPPED_EV) }
    }
}

/// Effects of hard photons from recombining He²⁺.
struct Hard {
    /// Ionisations of H⁰ and of He⁰ \[s⁻¹\].
    rates: [Lanes; 2],
    /// Heat \[eV cm⁻³ s⁻¹\].
    heat: Lanes,
}

impl Balance<'_> {
    /// Moves states towards balance of ionisation at their temperature; gives heating less cooling there, in parts of their
    /// mean.
    #[inline(always)]
    pub fn pass(&self, states: &mut States) -> Lanes {
        self.hydrogen_and_helium(states);
        self.metals(states);
        let mut electrons = Lanes::ZERO;
        let mut densities = [Lanes::ZERO; IONS];
        for element in Element::ALL {
            let nuclei = self.hydrogen * self.abundances[element as usize];
            for charge in 0..=element.charges() {
                let density = nuclei * states.part(element, charge);
                densities[ion(element, charge)] = density;
                electrons += density * charge as f64;
            }
        }
        states.electrons = electrons.or_more(self.hydrogen * 1e-9);
        let heating = self.heating(states, &densities).at_least(f64::MIN_POSITIVE);
        let cooling = self.cooling(states, &densities).at_least(f64::MIN_POSITIVE);
        (heating - cooling) / (heating + cooling) * 2.0
    }

    /// Nuclei of hydrogen or helium with a charge \[cm⁻³\].
    #[inline(always)]
    fn density(&self, states: &States, element: Element, charge: usize) -> Lanes {
        self.hydrogen * self.abundances[element as usize] * states.part(element, charge)
    }

    /// Rate coefficient of recombination to excited levels, plus that to the ground level unless its photons are absorbed on the spot.
    #[inline(always)]
    fn caught(&self, excited: Of, ground: Of) -> Lanes {
        let excited = self.coefficients.of(excited);
        if self.diffuse == Diffuse::Outward { excited + self.coefficients.of(ground) } else { excited }
    }

    /// Hydrogen and helium, given the electrons and what both were before.
    #[inline(always)]
    fn hydrogen_and_helium(&self, states: &mut States) {
        let (coefficients, electrons) = (self.coefficients, states.electrons);
        let excited = coefficients.of(Of::HeliumTriplets) + coefficients.of(Of::HeliumSinglets);
        let caught = electrons * (excited + self.lost_of_helium(states) * coefficients.of(Of::HeliumGround));
        let stripped = electrons * self.caught(Of::StrippedCaseB, Of::StrippedGround);
        let hard = self.hard(states).rates;
        let to_first = (self.photo.rates[ion(Element::Helium, 0)] + hard[1]) / caught;
        let to_second = self.photo.rates[ion(Element::Helium, 1)] / stripped;
        let rest = Lanes::ONE / (to_first * (to_second + 1.0) + 1.0);
        states.fractions[ion(Element::Helium, 0)] = rest;
        states.fractions[ion(Element::Helium, 1)] = rest * to_first;
        states.fractions[ion(Element::Helium, 2)] = rest * to_first * to_second;
        let given = self.of_helium(states)[0] / self.hydrogen;
        let rate = self.photo.rates[ion(Element::Hydrogen, 0)] + hard[0] + electrons * coefficients.of(Of::Ionisation);
        // Electrons of hydrogen itself, and of all others: both sides of the balance have hydrogen's, so it is quadratic.
        let rest = (electrons - self.hydrogen * states.part(Element::Hydrogen, 1)).at_least(0.0);
        let caught = self.caught(Of::CaseB, Of::Ground);
        let (square, linear) = (caught * self.hydrogen, caught * rest + rate);
        let gained = rate + given;
        let ionised = gained * 2.0 / (linear + (linear * linear + square * gained * 4.0).sqrt());
        let ionised = ionised.at_least(1e-12).at_most(1.0 - 1e-12);
        // What is left is not what rounding leaves of one.
        let caught = ionised * caught * (self.hydrogen * ionised + rest);
        let little = Lanes::ONE - ionised;
        let neutral = rate.above(0.0, ((caught - given) / rate).at_least(1e-12).at_most(1.0), little);
        states.fractions[ion(Element::Hydrogen, 0)] = neutral;
        states.fractions[ion(Element::Hydrogen, 1)] = Lanes::ONE - neutral;
    }

    /// The parts of all charges of the metals.
    #[inline(always)]
    fn metals(&self, states: &mut States) {
        /// A ratio of two charges that is as good as none of the lower.
        const ALL: f64 = 1e60;
        let [neutral, proton] = [0, 1].map(|charge| self.density(states, Element::Hydrogen, charge));
        for (metal, element) in Element::METALS.into_iter().enumerate() {
            let mut parts = [Lanes::ZERO; STAGES];
            parts[0] = Lanes::ONE;
            let mut all = Lanes::ONE;
            for charge in 0..element.charges() {
                let [caught, given, taken] = self.coefficients.transition(metal, charge);
                let up = self.photo.rates[ion(element, charge)].at_least(0.0) + given * proton;
                let down = caught * states.electrons + taken * neutral;
                let ratio = down.above(0.0, up / down, Lanes::ZERO).at_most(ALL);
                parts[charge + 1] = parts[charge] * ratio;
                all += parts[charge + 1];
            }
            let whole = Lanes::ONE / all;
            for (charge, part) in parts.into_iter().enumerate() {
                states.fractions[ion(element, charge)] = part * whole;
            }
        }
    }

    /// The part of recombinations to helium's ground level whose photon helium does not take at once.
    #[inline(always)]
    fn lost_of_helium(&self, states: &States) -> Lanes {
        if self.diffuse == Diffuse::Outward { Lanes::ONE } else { self.to_hydrogen(states) }
    }

    /// The part of photons of 24.6 eV that hydrogen absorbs.
    #[inline(always)]
    fn to_hydrogen(&self, states: &States) -> Lanes {
        let hydrogen = self.density(states, Element::Hydrogen, 0) * self.near.helium[0];
        let helium = self.density(states, Element::Helium, 0) * self.near.helium[1];
        helium.above(0.0, hydrogen / (hydrogen + helium), Lanes::ONE)
    }

    /// Recombinations of He²⁺ to excited levels \[cm⁻³ s⁻¹\].
    #[inline(always)]
    fn of_stripped(&self, states: &States) -> Lanes {
        states.electrons * self.density(states, Element::Helium, 2) * self.coefficients.of(Of::StrippedCaseB)
    }

    /// On-the-spot effect of its hard photons on hydrogen and helium.
    #[inline(always)]
    fn hard(&self, states: &States) -> Hard {
        if self.diffuse == Diffuse::Outward {
            return Hard { rates: [Lanes::ZERO; 2], heat: Lanes::ZERO };
        }
        let [hydrogen, helium] = [Element::Hydrogen, Element::Helium].map(|element| self.density(states, element, 0));
        let [of_hydrogen, of_helium] = self.near.hard;
        let opacity = (hydrogen * of_hydrogen + helium * of_helium).at_least(f64::MIN_POSITIVE);
        let flux = self.of_stripped(states) * STRIPPED.hard / opacity;
        let heat = hydrogen * (of_hydrogen * (STRIPPED_EV - HYDROGEN_EV)) + helium * (of_helium * (STRIPPED_EV - HELIUM_EV));
        Hard { rates: [flux * of_hydrogen, flux * of_helium], heat: flux * heat }
    }

    /// On-the-spot effect of helium recombination on hydrogen: ionisations \[cm⁻³ s⁻¹\], and heat \[eV cm⁻³ s⁻¹\].
    #[inline(always)]
    fn of_helium(&self, states: &States) -> [Lanes; 2] {
        let pairs = states.electrons * self.density(states, Element::Helium, 1);
        let [triplets, two, resonance] = self.photons_of_helium(states);
        // Photons of 584 Å do not get far.
        let (mut rate, mut heat) = (resonance, resonance * (LYMAN_ALPHA_EV - HYDROGEN_EV));
        if self.diffuse == Diffuse::OnTheSpot {
            let ground = self.to_hydrogen(states) * self.coefficients.of(Of::HeliumGround);
            for (photons, energy) in [(ground, HELIUM_EV), (triplets, TRIPLET_EV), (two, TWO_PHOTON_EV)] {
                rate += photons;
                heat += photons * (energy - HYDROGEN_EV);
            }
            let made = self.of_stripped(states);
            let kinetic = self.coefficients.kt_erg() / ERG_PER_EV;
            let of_stripped = made * ((TRIPLET_EV - HYDROGEN_EV) * STRIPPED.soft) + made * kinetic * STRIPPED.captures;
            return [pairs * rate + made * (STRIPPED.soft + STRIPPED.captures), pairs * heat + of_stripped];
        }
        [pairs * rate, pairs * heat]
    }

    #[inline(always)]
    fn photons_of_helium(&self, states: &States) -> [Lanes; 3] {
        let coefficients = self.coefficients;
        let neutral = states.part(Element::Hydrogen, 0) / states.part(Element::Helium, 0).at_least(f64::MIN_POSITIVE);
        photons_of_helium([Of::HeliumTriplets, Of::HeliumSinglets].map(|sort| coefficients.of(sort)), coefficients.temperature, neutral)
    }

    /// Photons that leave the place where they are made, by the first nodes of [`IonisingLight`] \[cm⁻³ s⁻¹\].
    #[inline(always)]
    pub fn own_light(&self, states: &States) -> [Lanes; OWN_NODES] {
        if self.diffuse == Diffuse::OnTheSpot {
            return [Lanes::ZERO; OWN_NODES];
        }
        let pairs = |element: Element| states.electrons * self.density(states, element, 1);
        let (hydrogen, helium) = (pairs(Element::Hydrogen), pairs(Element::Helium));
        let [triplets, two, _] = self.photons_of_helium(states);
        let rate = |sort: Of| self.coefficients.of(sort);
        let made = self.of_stripped(states);
        let [captures, soft, hard] = [STRIPPED.captures, STRIPPED.soft, STRIPPED.hard].map(|photons| made * photons);
        let ground = states.electrons * self.density(states, Element::Helium, 2) * rate(Of::StrippedGround);
        [hydrogen * rate(Of::Ground) + captures, helium * rate(Of::HeliumGround), helium * triplets + soft, helium * two, hard, ground]
    }

    /// Energy that electrons get \[erg cm⁻³ s⁻¹\], given the densities of ions.
    #[inline(always)]
    fn heating(&self, states: &States, densities: &[Lanes; IONS]) -> Lanes {
        // What the electrons lost that recombined, at the temperature of here.
        let kinetic = self.coefficients.of(Of::GroundCooling) / (self.coefficients.of(Of::Ground) * ERG_PER_EV);
        let mut again = Lanes::ZERO;
        for ((element, charge), rate) in ABSORBERS.into_iter().zip(self.photo.thermal) {
            again += densities[ion(element, charge)] * rate;
        }
        let mut by_light = self.of_helium(states)[1] + self.hard(states).heat + kinetic * again;
        for ((density, heat), rate) in densities.iter().zip(&self.photo.heat).zip(&self.photo.rates) {
            by_light += *density * rate.above(0.0, *heat, Lanes::ZERO);
        }
        by_light * ERG_PER_EV
    }

    /// Energy that electrons lose \[erg cm⁻³ s⁻¹\], given the densities of ions.
    #[inline(always)]
    fn cooling(&self, states: &States, densities: &[Lanes; IONS]) -> Lanes {
        let [neutral, proton] = [0, 1].map(|charge| densities[ion(Element::Hydrogen, charge)]);
        let [once, twice] = [1, 2].map(|charge| densities[ion(Element::Helium, charge)]);
        let (coefficients, rate) = (self.coefficients, |sort: Of| self.coefficients.of(sort));
        // Of what recombination to excited levels takes, helium's is as much of k T as hydrogen's.
        let excited = (rate(Of::HeliumTriplets) + rate(Of::HeliumSinglets)) * rate(Of::CaseBCooling) / rate(Of::CaseB);
        let mut recombination = proton * self.caught(Of::CaseBCooling, Of::GroundCooling)
            + once * excited
            + twice * self.caught(Of::StrippedCaseBCooling, Of::StrippedGroundCooling);
        if self.diffuse == Diffuse::Outward {
            recombination += once * rate(Of::HeliumGround) * coefficients.kt_erg();
        }
        let free_free = (proton + once) * rate(Of::FreeFree) + twice * rate(Of::StrippedFreeFree);
        let lines = coefficients.lines(states.electrons, densities);
        states.electrons * (recombination + free_free + neutral * rate(Of::Collisions) + lines)
    }
}
