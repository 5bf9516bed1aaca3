//! Gas in balance with light: as many ionisations as recombinations of every ion, as much heat as is radiated.
//!
//! Light of recombinations is absorbed where it is made (on the spot), or goes outward with the star's: then the gas
//! recombines to its ground level as well, and says how many photons it makes.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | Γ | rate of ionisations by light, of an ion | s⁻¹ |
//! | n_e | electrons | cm⁻³ |
//! | T | temperature of electrons | K |

use crate::atoms::{Atoms, BOLTZMANN_EV, ELEMENTS, ERG_PER_EV, Element, LYMAN_ALPHA_EV, STAGES, TRIPLET_EV, TWO_PHOTON_EV};
use crate::light::IonisingLight;

/// Temperatures between which the balance is sought \[K\]; at the lower one gas stays that has no light.
const COLDEST: f64 = 500.0;
const HOTTEST: f64 = 60_000.0;
/// Where ionisation is taken to have settled, and the most passes towards it.
const SETTLED: f64 = 1e-9;
const PASSES: usize = 400;
/// Thresholds \[eV\].
const HELIUM_EV: f64 = 24.59;
const HYDROGEN_EV: f64 = 13.6;

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
    pub fn new(hydrogen: f64, abundances: [f64; ELEMENTS]) -> Self {
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
}

/// What light does to each ion, by element and charge.
#[derive(Debug, Clone, Copy, Default)]
pub struct Photo {
    /// Ionisations \[s⁻¹\].
    pub rates: [[f64; STAGES]; ELEMENTS],
    /// Energy that electrons get \[eV s⁻¹\].
    pub heat: [[f64; STAGES]; ELEMENTS],
    /// Ionisations that give what an electron had before it recombined \[s⁻¹\].
    pub thermal: [[f64; STAGES]; ELEMENTS],
}

impl Photo {
    /// What a flux of photons at each node does \[s⁻¹ cm⁻²\].
    pub fn add(&mut self, light: &IonisingLight, flux: &[f64]) {
        let sum = |values: &[f64]| flux.iter().zip(values).map(|(f, v)| f * v).sum::<f64>().max(0.0);
        for absorption in &light.absorptions {
            let (element, charge) = (absorption.element as usize, absorption.charge);
            self.rates[element][charge] += sum(&absorption.sigma);
            self.heat[element][charge] += sum(&absorption.heat);
            self.thermal[element][charge] += sum(&absorption.thermal);
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

/// Gas under light.
pub struct Balance<'a> {
    /// The gas.
    pub gas: &'a Gas,
    /// What light does to it.
    pub photo: &'a Photo,
    /// Where its own light is absorbed.
    pub diffuse: Diffuse,
}

impl Balance<'_> {
    /// The state in which heat and ionisation are in balance, from one that is near.
    pub fn state(&self, near: &State) -> State {
        if let Some(temperature) = self.gas.isothermal {
            return self.ionised(temperature, near);
        }
        let net = |temperature: f64, near: &State| {
            let state = self.ionised(temperature, near);
            (self.heating(&state) - self.cooling(&state), state)
        };
        let begin = near.temperature.clamp(COLDEST, HOTTEST);
        let (at, mut state) = net(begin, near);
        let mut last = (begin, at);
        // Heating falls with temperature, cooling rises: steps of a tenth lead to where they cross.
        let step = if at > 0.0 { 1.1 } else { 1.0 / 1.1 };
        loop {
            let next = last.0 * step;
            if !(COLDEST..=HOTTEST).contains(&next) {
                return self.ionised(next.clamp(COLDEST, HOTTEST), &state);
            }
            let (at, found) = net(next, &state);
            state = found;
            if (at > 0.0) != (last.1 > 0.0) {
                return self.narrowed(last, (next, at), state, net);
            }
            last = (next, at);
        }
    }

    /// The root between two temperatures, by the rule of Illinois.
    fn narrowed(&self, mut low: (f64, f64), mut high: (f64, f64), mut state: State, net: impl Fn(f64, &State) -> (f64, State)) -> State {
        for _ in 0..60 {
            let middle = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            let (at, found) = net(middle, &state);
            state = found;
            if (high.0 - low.0).abs() < 1e-7 * middle || at == 0.0 {
                break;
            }
            if (at > 0.0) == (high.1 > 0.0) {
                high = (middle, at);
                low.1 *= 0.5;
            } else {
                (low, high) = (high, (middle, at));
            }
        }
        state
    }

    /// The state in which ionisation alone is in balance, at a temperature in K.
    pub fn ionised(&self, temperature: f64, near: &State) -> State {
        let ladders = Element::METALS.map(|element| Ladder::new(element, temperature));
        let mut state = State { temperature, ..*near };
        for _ in 0..PASSES {
            let before = state;
            self.hydrogen_and_helium(&mut state);
            for ladder in &ladders {
                let density = |charge: usize| state.density(self.gas, Element::Hydrogen, charge);
                let (neutral, proton, electrons) = (density(0), density(1), state.electrons);
                state.fractions[ladder.element as usize] =
                    ladder.fractions(&self.photo.rates[ladder.element as usize], [electrons, neutral, proton]);
            }
            let of_element = |element: Element| {
                let fractions = state.fractions[element as usize].iter().enumerate();
                self.gas.abundances[element as usize] * fractions.map(|(charge, part)| charge as f64 * part).sum::<f64>()
            };
            let electrons = (self.gas.hydrogen * Element::ALL.into_iter().map(of_element).sum::<f64>()).max(1e-9 * self.gas.hydrogen);
            // Between both, since more electrons are fewer ions.
            state.electrons = (electrons * before.electrons).sqrt();
            let neutral = |state: &State, element: usize| state.fractions[element][0];
            let moved = (0..2).map(|element| (neutral(&state, element) / neutral(&before, element) - 1.0).abs()).fold(0.0, f64::max);
            if moved < SETTLED && (state.electrons / before.electrons - 1.0).abs() < SETTLED {
                break;
            }
        }
        state
    }

    /// Hydrogen and helium, given the electrons and what both were before.
    fn hydrogen_and_helium(&self, state: &mut State) {
        let (atoms, temperature, electrons) = (Atoms::get(), state.temperature, state.electrons);
        let [hydrogen, helium] = [Element::Hydrogen, Element::Helium].map(|element| element as usize);
        let caught = electrons * (atoms.helium.case_b(temperature) + self.lost_of_helium(state) * atoms.helium.to_ground(temperature));
        let stripped = electrons * atoms.hydrogen.case_b(temperature, 2.0);
        let to_first = self.photo.rates[helium][0] / caught;
        let to_second = self.photo.rates[helium][1] / stripped;
        let all = 1.0 + to_first * (1.0 + to_second);
        state.fractions[helium] = [1.0 / all, to_first / all, to_first * to_second / all, 0.0, 0.0, 0.0];
        let given = self.of_helium(state)[0] / self.gas.hydrogen;
        let rate = self.photo.rates[hydrogen][0] + electrons * atoms.hydrogen.collisional(temperature);
        let to_ground = if self.diffuse == Diffuse::Outward { atoms.hydrogen.to_ground(temperature) } else { 0.0 };
        let caught = electrons * (atoms.hydrogen.case_b(temperature, 1.0) + to_ground);
        let ionised = ((rate + given) / (rate + caught)).min(1.0 - 1e-12);
        // What is left is not what rounding leaves of one.
        let neutral = ((caught - given) / (rate + caught)).max(1e-12);
        state.fractions[hydrogen] = [neutral, ionised, 0.0, 0.0, 0.0, 0.0];
    }

    /// The part of recombinations to helium's ground level whose photon helium does not take at once.
    fn lost_of_helium(&self, state: &State) -> f64 {
        if self.diffuse == Diffuse::Outward { 1.0 } else { self.to_hydrogen(state) }
    }

    /// The part of photons of 24.6 eV that hydrogen absorbs.
    fn to_hydrogen(&self, state: &State) -> f64 {
        let opacity = |element: Element| {
            let fit = Atoms::get().step(element, 0).light.as_ref();
            state.density(self.gas, element, 0) * fit.map_or(0.0, |fit| fit.at(HELIUM_EV))
        };
        let (hydrogen, helium) = (opacity(Element::Hydrogen), opacity(Element::Helium));
        if helium > 0.0 { hydrogen / (hydrogen + helium) } else { 1.0 }
    }

    /// What recombinations of helium do to hydrogen on the spot: ionisations \[cm⁻³ s⁻¹\], and heat \[eV cm⁻³ s⁻¹\].
    fn of_helium(&self, state: &State) -> [f64; 2] {
        let atoms = Atoms::get();
        let pairs = state.electrons * state.density(self.gas, Element::Helium, 1);
        let [triplets, two, resonance] = atoms.helium.photons(state.temperature, self.neutrals(state));
        let ground = self.to_hydrogen(state) * atoms.helium.to_ground(state.temperature);
        let all = [(ground, HELIUM_EV), (triplets, TRIPLET_EV), (two, TWO_PHOTON_EV), (resonance, LYMAN_ALPHA_EV)];
        // Photons of 584 Å do not get far.
        let here = if self.diffuse == Diffuse::Outward { &all[3..] } else { &all };
        let heat: f64 = here.iter().map(|(rate, energy)| rate * (energy - HYDROGEN_EV)).sum();
        [pairs * here.iter().map(|(rate, _)| rate).sum::<f64>(), pairs * heat]
    }

    /// Photons that leave the place where they are made, by the nodes of [`IonisingLight::own`] \[cm⁻³ s⁻¹\].
    pub fn own_light(&self, state: &State) -> [f64; 4] {
        if self.diffuse == Diffuse::OnTheSpot {
            return [0.0; 4];
        }
        let atoms = Atoms::get();
        let pairs = |element: Element| state.electrons * state.density(self.gas, element, 1);
        let (hydrogen, helium) = (pairs(Element::Hydrogen), pairs(Element::Helium));
        let [triplets, two, _] = atoms.helium.photons(state.temperature, self.neutrals(state));
        let (to_hydrogen, to_helium) = (atoms.hydrogen.to_ground(state.temperature), atoms.helium.to_ground(state.temperature));
        [hydrogen * to_hydrogen, helium * to_helium, helium * triplets, helium * two]
    }

    /// n(H⁰)/n(He⁰).
    fn neutrals(&self, state: &State) -> f64 {
        let density = |element| state.density(self.gas, element, 0);
        density(Element::Hydrogen) / density(Element::Helium).max(f64::MIN_POSITIVE)
    }

    /// Energy that electrons get \[erg cm⁻³ s⁻¹\].
    pub fn heating(&self, state: &State) -> f64 {
        let hydrogen = &Atoms::get().hydrogen;
        // What the electrons lost that recombined, at the temperature of here.
        let kinetic = hydrogen.to_ground_cooling(state.temperature) / (ERG_PER_EV * hydrogen.to_ground(state.temperature));
        let of_light = Element::ALL.into_iter().flat_map(|element| (0..STAGES).map(move |charge| (element, charge)));
        let by_light: f64 = of_light
            .map(|(element, charge)| {
                let photo = self.photo;
                let heat = photo.heat[element as usize][charge] + photo.thermal[element as usize][charge] * kinetic;
                state.density(self.gas, element, charge) * heat
            })
            .sum();
        ERG_PER_EV * (by_light + self.of_helium(state)[1])
    }

    /// Energy that electrons lose \[erg cm⁻³ s⁻¹\].
    pub fn cooling(&self, state: &State) -> f64 {
        let (atoms, t) = (Atoms::get(), state.temperature);
        let hydrogen = &atoms.hydrogen;
        let density = |element, charge| state.density(self.gas, element, charge);
        let [neutral, proton] = [0, 1].map(|charge| density(Element::Hydrogen, charge));
        let [once, twice] = [1, 2].map(|charge| density(Element::Helium, charge));
        let of_case_b = hydrogen.case_b_cooling(t, 1.0);
        let in_parts = of_case_b / (hydrogen.case_b(t, 1.0) * BOLTZMANN_EV * ERG_PER_EV * t);
        let (to_ground, of_helium) = match self.diffuse {
            Diffuse::Outward => (hydrogen.to_ground_cooling(t), atoms.helium.to_ground(t) * BOLTZMANN_EV * ERG_PER_EV * t),
            Diffuse::OnTheSpot => (0.0, 0.0),
        };
        let recombination = proton * (of_case_b + to_ground)
            + once * of_helium
            + once * ERG_PER_EV * atoms.helium.case_b_cooling(t, in_parts)
            + twice * hydrogen.case_b_cooling(t, 2.0);
        let free_free = (proton + once) * hydrogen.free_free(t, 1.0) + twice * hydrogen.free_free(t, 2.0);
        let collisions = neutral * (hydrogen.excitation(t) + HYDROGEN_EV * ERG_PER_EV * hydrogen.collisional(t));
        let conditions = atoms.collisional.conditions(t, state.electrons);
        let lines: f64 = atoms
            .collisional
            .lines
            .iter()
            .map(|line| (line, density(line.element, line.charge)))
            .filter(|(_, density)| *density > 0.0)
            .map(|(line, density)| density * atoms.collisional.emissivity(line, &conditions))
            .sum();
        state.electrons * (recombination + free_free + collisions + lines)
    }
}

/// The rates of a metal's ions at a temperature.
struct Ladder {
    element: Element,
    /// By step: recombination with electrons, giving an electron to a proton, taking one from H⁰ \[cm³ s⁻¹\].
    rates: [[f64; 3]; STAGES],
}

impl Ladder {
    fn new(element: Element, temperature: f64) -> Self {
        let of = |charge: usize| {
            let step = Atoms::get().step(element, charge);
            let exchange = |rate: &Option<crate::atoms::Exchange>| rate.as_ref().map_or(0.0, |rate| rate.at(temperature));
            [step.recombination(temperature), exchange(&step.to_proton), exchange(&step.from_hydrogen)]
        };
        Self { element, rates: std::array::from_fn(of) }
    }

    /// The parts of all charges under rates of ionisation by light \[s⁻¹\], with n_e, n(H⁰), n(H⁺) \[cm⁻³\].
    fn fractions(&self, light: &[f64; STAGES], [electrons, neutral, proton]: [f64; 3]) -> [f64; STAGES] {
        let mut parts = [0.0; STAGES];
        parts[0] = 1.0;
        for charge in 0..self.element.charges() {
            let [caught, given, taken] = self.rates[charge];
            let (up, down) = (light[charge] + given * proton, caught * electrons + taken * neutral);
            parts[charge + 1] = if down > 0.0 { parts[charge] * up / down } else { 0.0 };
            // Ratios of many powers of ten are kept in range.
            let largest = parts.iter().fold(0.0f64, |most, part| most.max(*part));
            parts.iter_mut().for_each(|part| *part /= largest);
        }
        let all: f64 = parts.iter().sum();
        parts.map(|part| part / all)
    }
}
