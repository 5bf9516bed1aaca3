//! Gas in balance with light: as many ionisations as recombinations of every ion, as much heat as is radiated.
//!
//! Equations (G5) and (G6) of docs/gas.md. Light of recombinations is absorbed where it is made (on the spot), or goes
//! outward with the star's: then the gas recombines to its ground level as well, and says how many photons it makes.
//!
//! Left out: light of recombining He²⁺, collisions out of helium's 2 ³S, heat by dust, and what is not in balance. Lines
//! are tabulated from 1000 to 30 000 K and stay as they are beyond.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | Γ | rate of ionisations by light, of an ion | s⁻¹ |
//! | n_e | electrons | cm⁻³ |
//! | T | temperature of electrons | K |

use multiversion::multiversion;

use crate::atoms::{
    Atoms, ELEMENTS, ERG_PER_EV, Element, EmissionLine, HELIUM_EV, HYDROGEN_EV, LYMAN_ALPHA_EV, LineTable, STAGES, TRIPLET_EV,
    TWO_PHOTON_EV, photons_of_helium,
};
use crate::coefficients::{Coefficients, Of};
use crate::light::{ABSORBERS, Absorption, ByNode, IONS, IonisingLight, OWN_NODES, ion};

/// Temperatures between which the balance is sought \[K\]; at the lower one gas stays that has no light.
const COLDEST: f64 = 500.0;
const HOTTEST: f64 = 60_000.0;

/// Gas: how dense, and what it is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gas {
    /// Nuclei of hydrogen \[cm⁻³\].
    pub hydrogen: f64,
    /// Nuclei of each element for one of hydrogen.
    pub abundances: [f64; ELEMENTS],
    /// What dust absorbs of ionising light, for one nucleus of hydrogen \[cm²\].
    pub dust_cm2: f64,
    /// A temperature that is held \[K\], in place of the one at which heating and cooling are in balance.
    pub isothermal: Option<f64>,
}

impl Gas {
    /// Gas without dust.
    pub const fn new(hydrogen: f64, abundances: [f64; ELEMENTS]) -> Self {
        Self { hydrogen, abundances, dust_cm2: 0.0, isothermal: None }
    }
}

/// Gas that is in balance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// The temperature of electrons \[K\].
    pub temperature: f64,
    /// Their density \[cm⁻³\].
    pub electrons: f64,
    /// The part of each element's nuclei that has each charge.
    pub fractions: [[f64; STAGES]; ELEMENTS],
}

impl State {
    /// Gas without light.
    pub fn neutral(gas: &Gas) -> Self {
        let mut fractions = [[0.0; STAGES]; ELEMENTS];
        fractions.iter_mut().for_each(|of_element| of_element[0] = 1.0);
        Self { temperature: COLDEST, electrons: 1e-6 * gas.hydrogen, fractions }
    }

    /// The density of an ion \[cm⁻³\].
    pub fn density(&self, gas: &Gas, element: Element, charge: usize) -> f64 {
        gas.hydrogen * gas.abundances[element as usize] * self.fractions[element as usize][charge]
    }

    /// What a line of a table sends out \[erg cm⁻³ s⁻¹\].
    pub fn emission(&self, gas: &Gas, table: &LineTable, line: &EmissionLine) -> f64 {
        let at = table.conditions(self.temperature, self.electrons);
        self.electrons * self.density(gas, line.element, line.charge) * table.emissivity(line, &at)
    }
}

/// What light does to each ion, in the order of [`ion`].
#[derive(Debug, Clone, Copy)]
pub struct Photo {
    /// Ionisations \[s⁻¹\].
    pub rates: [f64; IONS],
    /// The energy that electrons get of it \[eV s⁻¹\].
    pub heat: [f64; IONS],
    /// Ionisations of [`ABSORBERS`] that give what an electron had before it recombined \[s⁻¹\].
    pub thermal: [f64; ABSORBERS.len()],
}

impl Photo {
    /// What a flux of photons at each node does \[s⁻¹ cm⁻²\].
    pub fn new(light: &IonisingLight, flux: &ByNode) -> Self {
        let mut photo = Self { rates: [0.0; IONS], heat: [0.0; IONS], thermal: [0.0; ABSORBERS.len()] };
        sums(&mut photo, &light.absorptions, flux);
        photo.renew(light, flux);
        // Weights between nodes may be negative, rates are not, and where there is none there is no heat.
        photo.rates.iter_mut().zip(&mut photo.heat).filter(|(rate, _)| **rate <= 0.0).for_each(|(rate, heat)| (*rate, *heat) = (0.0, 0.0));
        photo
    }

    /// Makes those of [`ABSORBERS`] anew, and leaves those of metals as they are.
    pub fn renew(&mut self, light: &IonisingLight, flux: &ByNode) {
        for (number, (element, charge)) in ABSORBERS.into_iter().enumerate() {
            let sum = |values: &ByNode| flux.iter().zip(values).map(|(flux, value)| flux * value).sum::<f64>();
            self.rates[ion(element, charge)] = sum(&light.weakening[number]);
            self.heat[ion(element, charge)] = sum(&light.warming[number]);
            self.thermal[number] = flux[..OWN_NODES].iter().zip(&light.thermal[number]).map(|(flux, sigma)| flux * sigma).sum();
        }
    }
}

#[multiversion(targets = "simd")]
fn sums(photo: &mut Photo, absorptions: &[Absorption], flux: &ByNode) {
    for (absorption, flux) in absorptions.iter().zip(flux).filter(|(_, flux)| **flux > 0.0) {
        for i in 0..IONS {
            photo.rates[i] += flux * absorption.sigma[i];
            photo.heat[i] += flux * absorption.heat[i];
        }
    }
}

/// Where the light of recombinations is absorbed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Diffuse {
    /// Where it is made.
    OnTheSpot,
    /// Farther from the star, along its rays.
    #[default]
    Outward,
}

/// How exactly a balance is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Whether rates are those of the fits themselves, or between rows of a table.
    pub is_exact: bool,
    /// The relative change at which temperature, ionisation and light are taken to have settled \[1\].
    pub settled: f64,
    /// The largest depth of a step along a ray at a node that still has light \[1\].
    pub depth: f64,
    /// The longest step in parts of the way from the star \[1\].
    pub thickness: f64,
    /// Light of a node that counts for that, in parts of all of it \[1\].
    pub counts: f64,
    /// Where light is taken to be used up, in parts of all of it \[1\].
    pub used_up: f64,
}

impl Accuracy {
    /// That of the reference.
    pub const REFERENCE: Self = Self { is_exact: true, settled: 1e-7, depth: 0.1, thickness: 0.01, counts: 1e-6, used_up: 1e-5 };
    /// That of clouds in three dimensions.
    pub const FAST: Self = Self { is_exact: false, settled: 1e-2, depth: 0.5, thickness: 0.15, counts: 1e-4, used_up: 1e-5 };

    /// The coefficients at a temperature in K.
    pub fn coefficients(&self, temperature: f64) -> Coefficients {
        if self.is_exact { Coefficients::exact(temperature) } else { Coefficients::tabulated(temperature) }
    }

    /// Makes coefficients those at a temperature, where it is another.
    pub fn renew(&self, coefficients: &mut Coefficients, temperature: f64) {
        if self.is_exact {
            *coefficients = Coefficients::exact(temperature);
        } else if (temperature / coefficients.temperature - 1.0).abs() > 0.1 * self.settled {
            coefficients.tabulate(temperature);
        }
    }
}

/// A temperature that moves to where heating is as much as cooling.
#[derive(Debug, Clone, Copy, Default)]
pub struct Thermostat {
    /// ln T and ln (heating/cooling) before.
    last: Option<(f64, f64)>,
    /// How steeply the second fell with the first when both were last asked.
    slope: Option<f64>,
}

impl Thermostat {
    /// The same for other gas that is near.
    #[must_use]
    pub fn elsewhere(self) -> Self {
        Self { last: None, ..self }
    }

    /// The next temperature to try, given ln (heating/cooling) at the one before \[K\].
    pub fn next(&mut self, temperature: f64, excess: f64) -> f64 {
        let at = temperature.ln();
        // Cooling rises with some power of T beside heating; what the last two tell of it is held within reason.
        let slope = match self.last {
            Some((before, was)) if (at - before).abs() > 1e-12 => (-(excess - was) / (at - before)).clamp(1.5, 15.0),
            _ => self.slope.unwrap_or(5.0),
        };
        (self.last, self.slope) = (Some((at, excess)), Some(slope));
        (temperature * (excess / slope).clamp(-0.3, 0.3).exp()).clamp(COLDEST, HOTTEST)
    }
}

/// Gas under light.
pub struct Balance<'a> {
    /// The gas.
    pub gas: &'a Gas,
    /// What light does to it.
    pub photo: &'a Photo,
    /// Where its own light is absorbed.
    pub diffuse: Diffuse,
    /// Rates at the temperature of the state.
    pub coefficients: &'a Coefficients,
}

impl Balance<'_> {
    /// Moves a state towards balance of ionisation at its temperature; gives ln (heating/cooling) there.
    pub fn pass(&self, state: &mut State) -> f64 {
        self.hydrogen_and_helium(state);
        self.metals(state);
        let of_element = |element: Element| {
            let fractions = state.fractions[element as usize].iter().enumerate();
            self.gas.abundances[element as usize] * fractions.map(|(charge, part)| charge as f64 * part).sum::<f64>()
        };
        state.electrons = (self.gas.hydrogen * Element::ALL.into_iter().map(of_element).sum::<f64>()).max(1e-9 * self.gas.hydrogen);
        if self.gas.isothermal.is_some() {
            return 0.0;
        }
        (self.heating(state).max(f64::MIN_POSITIVE) / self.cooling(state).max(f64::MIN_POSITIVE)).ln()
    }

    /// Hydrogen and helium, given the electrons and what both were before.
    fn hydrogen_and_helium(&self, state: &mut State) {
        let (coefficients, electrons) = (self.coefficients, state.electrons);
        let [hydrogen, helium] = [Element::Hydrogen, Element::Helium].map(|element| element as usize);
        let excited = coefficients.of(Of::HeliumTriplets) + coefficients.of(Of::HeliumSinglets);
        let caught = electrons * (excited + self.lost_of_helium(state) * coefficients.of(Of::HeliumGround));
        let stripped = electrons * coefficients.of(Of::StrippedCaseB);
        let to_first = self.photo.rates[ion(Element::Helium, 0)] / caught;
        let to_second = self.photo.rates[ion(Element::Helium, 1)] / stripped;
        let all = 1.0 + to_first * (1.0 + to_second);
        state.fractions[helium] = [1.0 / all, to_first / all, to_first * to_second / all, 0.0, 0.0, 0.0];
        let given = self.of_helium(state)[0] / self.gas.hydrogen;
        let rate = self.photo.rates[ion(Element::Hydrogen, 0)] + electrons * coefficients.of(Of::Ionisation);
        // Electrons of hydrogen itself, and of all others: both sides of the balance have hydrogen's, so it is quadratic.
        let rest = electrons - self.gas.hydrogen * state.fractions[hydrogen][1];
        let to_ground = if self.diffuse == Diffuse::Outward { coefficients.of(Of::Ground) } else { 0.0 };
        let caught = coefficients.of(Of::CaseB) + to_ground;
        let (square, linear) = (caught * self.gas.hydrogen, caught * rest.max(0.0) + rate);
        let ionised = 2.0 * (rate + given) / (linear + (linear * linear + 4.0 * square * (rate + given)).sqrt());
        let ionised = ionised.clamp(1e-12, 1.0 - 1e-12);
        // What is left is not what rounding leaves of one.
        let caught = ionised * caught * (self.gas.hydrogen * ionised + rest.max(0.0));
        let neutral = if rate > 0.0 { ((caught - given) / rate).clamp(1e-12, 1.0) } else { 1.0 - ionised };
        state.fractions[hydrogen] = [neutral, 1.0 - neutral, 0.0, 0.0, 0.0, 0.0];
    }

    /// The parts of all charges of the metals.
    fn metals(&self, state: &mut State) {
        let density = |charge: usize| state.density(self.gas, Element::Hydrogen, charge);
        let (neutral, proton, electrons) = (density(0), density(1), state.electrons);
        for (metal, element) in Element::METALS.into_iter().enumerate() {
            let light = &self.photo.rates[ion(element, 0)..];
            let mut parts = [0.0; STAGES];
            parts[0] = 1.0;
            let mut all = 1.0;
            for charge in 0..element.charges() {
                let [caught, given, taken] = *self.coefficients.transition(metal, charge);
                let (up, down) = (light[charge] + given * proton, caught * electrons + taken * neutral);
                parts[charge + 1] = if down > 0.0 { parts[charge] * up / down } else { 0.0 };
                all += parts[charge + 1];
                // Ratios of many powers of ten are kept in range.
                if all > 1e100 {
                    parts.iter_mut().for_each(|part| *part /= all);
                    all = 1.0;
                }
            }
            state.fractions[element as usize] = parts.map(|part| part / all);
        }
    }

    /// The part of recombinations to helium's ground level whose photon helium does not take at once.
    fn lost_of_helium(&self, state: &State) -> f64 {
        if self.diffuse == Diffuse::Outward { 1.0 } else { self.to_hydrogen(state) }
    }

    /// The part of photons of 24.6 eV that hydrogen absorbs.
    fn to_hydrogen(&self, state: &State) -> f64 {
        let opacity = |element: Element| {
            let fit = Atoms::get().transition(element, 0).light.as_ref();
            state.density(self.gas, element, 0) * fit.map_or(0.0, |fit| fit.at(HELIUM_EV))
        };
        let (hydrogen, helium) = (opacity(Element::Hydrogen), opacity(Element::Helium));
        if helium > 0.0 { hydrogen / (hydrogen + helium) } else { 1.0 }
    }

    /// What recombinations of helium do to hydrogen on the spot: ionisations \[cm⁻³ s⁻¹\], and heat \[eV cm⁻³ s⁻¹\].
    fn of_helium(&self, state: &State) -> [f64; 2] {
        let pairs = state.electrons * state.density(self.gas, Element::Helium, 1);
        let [triplets, two, resonance] = self.photons_of_helium(state);
        // Photons of 584 Å do not get far.
        let near = (resonance, LYMAN_ALPHA_EV);
        let sums = |all: &[(f64, f64)]| {
            let heat: f64 = all.iter().map(|(rate, energy)| rate * (energy - HYDROGEN_EV)).sum();
            [pairs * all.iter().map(|(rate, _)| rate).sum::<f64>(), pairs * heat]
        };
        match self.diffuse {
            Diffuse::Outward => sums(&[near]),
            Diffuse::OnTheSpot => {
                let ground = self.to_hydrogen(state) * self.coefficients.of(Of::HeliumGround);
                sums(&[(ground, HELIUM_EV), (triplets, TRIPLET_EV), (two, TWO_PHOTON_EV), near])
            }
        }
    }

    fn photons_of_helium(&self, state: &State) -> [f64; 3] {
        let coefficients = self.coefficients;
        let part = |element: Element| state.fractions[element as usize][0];
        let neutral = part(Element::Hydrogen) / part(Element::Helium).max(f64::MIN_POSITIVE);
        photons_of_helium([Of::HeliumTriplets, Of::HeliumSinglets].map(|of| coefficients.of(of)), coefficients.temperature, neutral)
    }

    /// Photons that leave the place where they are made, by the first nodes of [`IonisingLight`] \[cm⁻³ s⁻¹\].
    pub fn own_light(&self, state: &State) -> [f64; OWN_NODES] {
        if self.diffuse == Diffuse::OnTheSpot {
            return [0.0; OWN_NODES];
        }
        let coefficients = self.coefficients;
        let pairs = |element: Element| state.electrons * state.density(self.gas, element, 1);
        let (hydrogen, helium) = (pairs(Element::Hydrogen), pairs(Element::Helium));
        let [triplets, two, _] = self.photons_of_helium(state);
        [hydrogen * coefficients.of(Of::Ground), helium * coefficients.of(Of::HeliumGround), helium * triplets, helium * two]
    }

    /// Energy that electrons get \[erg cm⁻³ s⁻¹\].
    fn heating(&self, state: &State) -> f64 {
        // What the electrons lost that recombined, at the temperature of here.
        let kinetic = self.coefficients.of(Of::GroundCooling) / (ERG_PER_EV * self.coefficients.of(Of::Ground));
        let again: f64 = ABSORBERS
            .into_iter()
            .zip(self.photo.thermal)
            .map(|((element, charge), rate)| state.density(self.gas, element, charge) * rate)
            .sum();
        let of_element = |element: Element| {
            let parts = &state.fractions[element as usize];
            let heat = parts.iter().zip(&self.photo.heat[ion(element, 0)..]).map(|(part, heat)| part * heat);
            self.gas.abundances[element as usize] * heat.sum::<f64>()
        };
        let by_light = self.gas.hydrogen * Element::ALL.into_iter().map(of_element).sum::<f64>();
        ERG_PER_EV * (by_light + kinetic * again + self.of_helium(state)[1])
    }

    /// Energy that electrons lose \[erg cm⁻³ s⁻¹\].
    fn cooling(&self, state: &State) -> f64 {
        let density = |element, charge| state.density(self.gas, element, charge);
        let [neutral, proton] = [0, 1].map(|charge| density(Element::Hydrogen, charge));
        let [once, twice] = [1, 2].map(|charge| density(Element::Helium, charge));
        let (coefficients, of) = (self.coefficients, |of: Of| self.coefficients.of(of));
        // Of what recombination to excited levels takes, helium's is as much of k T as hydrogen's.
        let excited = (of(Of::HeliumTriplets) + of(Of::HeliumSinglets)) * of(Of::CaseBCooling) / of(Of::CaseB);
        let (to_ground, of_helium) = match self.diffuse {
            Diffuse::Outward => (of(Of::GroundCooling), of(Of::HeliumGround) * coefficients.kt_erg()),
            Diffuse::OnTheSpot => (0.0, 0.0),
        };
        let recombination =
            proton * (of(Of::CaseBCooling) + to_ground) + once * (excited + of_helium) + twice * of(Of::StrippedCaseBCooling);
        let free_free = (proton + once) * of(Of::FreeFree) + twice * of(Of::StrippedFreeFree);
        let lines = coefficients.lines(state.electrons, density);
        state.electrons * (recombination + free_free + neutral * of(Of::Collisions) + lines)
    }
}
