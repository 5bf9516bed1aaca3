//! What the balance takes from atomic data at a temperature, exact or between the rows of a table.

use std::sync::OnceLock;

use multiversion::multiversion;

use crate::atoms::{Atoms, BOLTZMANN_EV, ELEMENTS, ERG_PER_EV, Element, Exchange, HYDROGEN_EV, STAGES};

/// Rates of a transition between two charges of a metal: recombination by electrons, giving an electron to H⁺, taking one from
/// H⁰ \[cm³ s⁻¹\].
const RATES: usize = 3;
/// Transitions of a metal at most.
const TRANSITIONS: usize = STAGES - 1;
const METALS: usize = ELEMENTS - 2;

/// The places of coefficients of hydrogen and helium behind those of metals.
#[derive(Debug, Clone, Copy)]
#[repr(usize)]
pub enum Of {
    /// H⁺ to all levels but the ground \[cm³ s⁻¹\], and the kinetic energy that it takes \[erg cm³ s⁻¹\].
    CaseB,
    /// \[erg cm³ s⁻¹\]
    CaseBCooling,
    /// H⁺ to the ground \[cm³ s⁻¹\].
    Ground,
    /// \[erg cm³ s⁻¹\]
    GroundCooling,
    /// He²⁺ to all levels but the ground \[cm³ s⁻¹\].
    StrippedCaseB,
    /// \[erg cm³ s⁻¹\]
    StrippedCaseBCooling,
    /// Bremsstrahlung beside ions of one charge \[erg cm³ s⁻¹\].
    FreeFree,
    /// Beside ions of two.
    StrippedFreeFree,
    /// Electrons that lift or free the one of H⁰ \[erg cm³ s⁻¹\].
    Collisions,
    /// Electrons that free it \[cm³ s⁻¹\].
    Ionisation,
    /// He⁺ to the ground \[cm³ s⁻¹\].
    HeliumGround,
    /// To triplets.
    HeliumTriplets,
    /// To excited singlets.
    HeliumSinglets,
    /// How many there are.
    Count,
}

const HYDROGEN: usize = METALS * TRANSITIONS * RATES;
const LINES: usize = HYDROGEN + Of::Count as usize;
/// Electron densities of cooling \[cm⁻³\].
const DENSITIES: [f64; 7] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6];
/// Ions that have lines at most.
const COOLANTS: usize = 24;
const COUNT: usize = LINES + COOLANTS * DENSITIES.len();

/// Rows of the table, and the temperatures between which they stand \[K\].
const ROWS: usize = 640;
const COLDEST: f64 = 300.0;
const HOTTEST: f64 = 80_000.0;

/// Coefficients at one temperature.
#[derive(Debug, Clone)]
pub struct Coefficients {
    /// The temperature of electrons \[K\].
    pub temperature: f64,
    values: [f64; COUNT],
}

/// The ions that have lines, in the order of their coefficients.
pub fn coolants() -> &'static [(Element, usize)] {
    static IONS: OnceLock<Vec<(Element, usize)>> = OnceLock::new();
    IONS.get_or_init(|| {
        let mut ions: Vec<(Element, usize)> =
            Atoms::get().collisional.lines.iter().map(|line| (line.element, line.charge)).filter(|ion| ion.1 < STAGES).collect();
        ions.sort_unstable();
        ions.dedup();
        assert!(ions.len() <= COOLANTS, "{} ions have lines", ions.len());
        ions
    })
}

#[multiversion(targets = "simd")]
fn between(a: &[f64; COUNT], b: &[f64; COUNT], part: f64, own: &mut [f64; COUNT]) {
    for i in 0..COUNT {
        own[i] = a[i] + part * (b[i] - a[i]);
    }
}

impl Coefficients {
    /// Those of the fits themselves.
    pub fn exact(temperature: f64) -> Self {
        let (atoms, mut values) = (Atoms::get(), [0.0; COUNT]);
        for (metal, element) in Element::METALS.into_iter().enumerate() {
            for charge in 0..element.charges() {
                let transition = atoms.transition(element, charge);
                let exchange = |rate: &Option<Exchange>| rate.as_ref().map_or(0.0, |rate| rate.at(temperature));
                let first = (metal * TRANSITIONS + charge) * RATES;
                let rates = [transition.recombination(temperature), exchange(&transition.to_proton), exchange(&transition.from_hydrogen)];
                values[first..first + RATES].copy_from_slice(&rates);
            }
        }
        let (hydrogen, helium) = (&atoms.hydrogen, atoms.helium);
        let ionisation = hydrogen.collisional(temperature);
        let [triplets, singlets] = helium.to_excited(temperature);
        for (of, value) in [
            (Of::CaseB, hydrogen.case_b(temperature, 1.0)),
            (Of::CaseBCooling, hydrogen.case_b_cooling(temperature, 1.0)),
            (Of::Ground, hydrogen.to_ground(temperature)),
            (Of::GroundCooling, hydrogen.to_ground_cooling(temperature)),
            (Of::StrippedCaseB, hydrogen.case_b(temperature, 2.0)),
            (Of::StrippedCaseBCooling, hydrogen.case_b_cooling(temperature, 2.0)),
            (Of::FreeFree, hydrogen.free_free(temperature, 1.0)),
            (Of::StrippedFreeFree, hydrogen.free_free(temperature, 2.0)),
            (Of::Collisions, hydrogen.excitation(temperature) + HYDROGEN_EV * ERG_PER_EV * ionisation),
            (Of::Ionisation, ionisation),
            (Of::HeliumGround, helium.to_ground(temperature)),
            (Of::HeliumTriplets, triplets),
            (Of::HeliumSinglets, singlets),
        ] {
            values[HYDROGEN + of as usize] = value;
        }
        for (row, electrons) in DENSITIES.into_iter().enumerate() {
            let at = atoms.collisional.conditions(temperature, electrons);
            for line in atoms.collisional.lines.iter().filter(|line| line.charge < STAGES) {
                if let Ok(ion) = coolants().binary_search(&(line.element, line.charge)) {
                    values[LINES + row * COOLANTS + ion] += atoms.collisional.emissivity(line, &at);
                }
            }
        }
        Self { temperature, values }
    }

    /// Those between the two nearest rows of the table, linear in ln T.
    pub fn tabulated(temperature: f64) -> Self {
        let mut own = Self { temperature: 0.0, values: [0.0; COUNT] };
        own.tabulate(temperature);
        own
    }

    /// Becomes those at another temperature.
    pub fn tabulate(&mut self, temperature: f64) {
        static TABLE: OnceLock<Vec<[f64; COUNT]>> = OnceLock::new();
        let step = (HOTTEST / COLDEST).ln() / (ROWS - 1) as f64;
        let table = TABLE.get_or_init(|| (0..ROWS).map(|row| Self::exact(COLDEST * (row as f64 * step).exp()).values).collect());
        let place = ((temperature / COLDEST).ln() / step).clamp(0.0, (ROWS - 1) as f64);
        let row = (place as usize).min(ROWS - 2);
        between(&table[row], &table[row + 1], place - row as f64, &mut self.values);
        self.temperature = temperature;
    }

    /// One of hydrogen's or helium's.
    pub fn of(&self, of: Of) -> f64 {
        self.values[HYDROGEN + of as usize]
    }

    /// The rates between a charge of a metal and the next.
    pub fn transition(&self, metal: usize, charge: usize) -> &[f64; RATES] {
        let first = (metal * TRANSITIONS + charge) * RATES;
        self.values[first..].first_chunk().unwrap_or(&[0.0; RATES])
    }

    /// k T \[erg\].
    pub fn kt_erg(&self) -> f64 {
        BOLTZMANN_EV * ERG_PER_EV * self.temperature
    }

    /// Σ over ions that have lines of their density, and the energy of their lines per electron \[erg s⁻¹\], by how many
    /// electrons there are: between two densities the inverse is linear, as for two levels.
    pub fn lines(&self, electrons: f64, density: impl Fn(Element, usize) -> f64) -> f64 {
        let last = DENSITIES.len() - 1;
        let electrons = electrons.clamp(DENSITIES[0], DENSITIES[last]);
        let row = DENSITIES.partition_point(|n| *n < electrons).clamp(1, last);
        let part = (electrons - DENSITIES[row - 1]) / (DENSITIES[row] - DENSITIES[row - 1]);
        let (a, b) = (&self.values[LINES + (row - 1) * COOLANTS..], &self.values[LINES + row * COOLANTS..]);
        let of = |(i, (element, charge)): (usize, &(Element, usize))| {
            let density = density(*element, *charge);
            if density > 0.0 { density * a[i] * b[i] / ((1.0 - part) * b[i] + part * a[i]) } else { 0.0 }
        };
        coolants().iter().enumerate().map(of).sum()
    }
}
