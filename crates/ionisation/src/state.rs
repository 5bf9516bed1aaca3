//! Gas, and its state.

use crate::atoms::{ELEMENTS, Element, EmissionLine, LineTable, STAGES};
use crate::lanes::{LANES, Lanes};
use crate::light::{IONS, ion};

/// Temperatures between which the balance is sought \[K\]; at the lower one gas stays that has no light.
pub const COLDEST: f64 = 500.0;
/// See [`COLDEST`].
pub const HOTTEST: f64 = 60_000.0;

/// Gas: how dense, and what it is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gas {
    /// Nuclei of hydrogen \[cm⁻³\].
    pub hydrogen: f64,
    /// Nuclei of each element for one of hydrogen.
    pub abundances: [f64; ELEMENTS],
    /// Dust absorption cross-section of ionising light per hydrogen nucleus \[cm²\].
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
pub struct GasState {
    /// The temperature of electrons \[K\].
    pub temperature: f64,
    /// Their density \[cm⁻³\].
    pub electrons: f64,
    /// The part of each element's nuclei that has each charge.
    pub fractions: [[f64; STAGES]; ELEMENTS],
}

impl GasState {
    /// Gas without light.
    pub fn neutral(gas: &Gas) -> Self {
        let mut fractions = [[0.0; STAGES]; ELEMENTS];
        fractions.iter_mut().for_each(|of_element| of_element[0] = 1.0);
        Self { temperature: COLDEST, electrons: 1e-6 * gas.hydrogen, fractions }
    }

    /// The gas at a density `denser` times as high under the same light, if its temperature stays: recombinations are as many times
    /// more frequent, so that each charge becomes rarer relative to the one below.
    #[must_use]
    pub fn denser(&self, denser: f64) -> Self {
        let mut state = Self { electrons: self.electrons * denser, ..*self };
        for fractions in &mut state.fractions {
            let mut factor = 1.0;
            for part in fractions.iter_mut() {
                *part *= factor;
                factor /= denser;
            }
            let all: f64 = fractions.iter().sum();
            fractions.iter_mut().for_each(|part| *part /= all);
        }
        state
    }

    /// The density of an ion \[cm⁻³\].
    pub fn density(&self, gas: &Gas, element: Element, charge: usize) -> f64 {
        gas.hydrogen * gas.abundances[element as usize] * self.fractions[element as usize][charge]
    }

    /// Fraction of hydrogen that is ionised \[1\].
    pub fn ionised(&self) -> f64 {
        self.fractions[Element::Hydrogen as usize][1]
    }

    /// n_p n_e \[cm⁻⁶\].
    pub fn pairs(&self, gas: &Gas) -> f64 {
        self.electrons * self.density(gas, Element::Hydrogen, 1)
    }

    /// Emissivity of a tabulated line \[erg cm⁻³ s⁻¹\].
    pub fn emission(&self, gas: &Gas, table: &LineTable, line: &EmissionLine) -> f64 {
        let at = table.conditions(self.temperature, self.electrons);
        self.electrons * self.density(gas, line.element, line.charge) * table.emissivity(line, &at)
    }
}

/// Gas of several beams.
#[derive(Debug, Clone)]
pub struct States {
    /// The temperature of electrons \[K\].
    pub temperature: Lanes,
    /// Their density \[cm⁻³\].
    pub electrons: Lanes,
    /// The part of each element's nuclei that has each charge, in the order of [`ion`].
    pub fractions: [Lanes; IONS],
}

impl Default for States {
    fn default() -> Self {
        let mut states = Self { temperature: Lanes::splat(COLDEST), electrons: Lanes::ONE, fractions: [Lanes::ZERO; IONS] };
        (0..LANES).for_each(|lane| states.put(lane, &GasState::neutral(&Gas::new(1.0, [1.0; ELEMENTS]))));
        states
    }
}

impl States {
    /// The gas of one beam.
    pub fn get(&self, lane: usize) -> GasState {
        let fraction = |element: usize, charge: usize| self.fractions[element * STAGES + charge][lane];
        GasState {
            temperature: self.temperature[lane],
            electrons: self.electrons[lane],
            fractions: std::array::from_fn(|element| std::array::from_fn(|charge| fraction(element, charge))),
        }
    }

    /// Gives a beam its gas.
    pub fn put(&mut self, lane: usize, state: &GasState) {
        (self.temperature[lane], self.electrons[lane]) = (state.temperature, state.electrons);
        self.fractions.iter_mut().zip(state.fractions.iter().flatten()).for_each(|(fraction, part)| fraction[lane] = *part);
    }

    /// The part of an element's nuclei that has a charge.
    #[inline(always)]
    pub fn part(&self, element: Element, charge: usize) -> Lanes {
        self.fractions[ion(element, charge)]
    }
}
