//! Atomic data of the balance at a temperature, exact or between the rows of a table.

use std::sync::OnceLock;

use crate::atoms::{Atoms, BOLTZMANN_EV, ELEMENTS, ERG_PER_EV, Element, Exchange, HYDROGEN_EV, STAGES};
use crate::lanes::{LANES, Lanes};
use crate::light::ion;

/// Rates of a transition between two charges of a metal: recombination by electrons, giving an electron to H⁺, taking one from
/// H⁰ \[cm³ s⁻¹\].
const RATES: usize = 3;
/// Transitions of a metal at most.
const TRANSITIONS: usize = STAGES - 1;
const METALS: usize = ELEMENTS - 2;

/// The places of coefficients of hydrogen and helium behind those of metals.
#[derive(Debug, Clone, Copy)]
#[repr(usize)]
#[non_exhaustive]
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
    /// He²⁺ to the ground \[cm³ s⁻¹\].
    StrippedGround,
    /// \[erg cm³ s⁻¹\]
    StrippedGroundCooling,
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
    /// Number of coefficients.
    Count,
}

const HYDROGEN: usize = METALS * TRANSITIONS * RATES;
const LINES: usize = HYDROGEN + Of::Count as usize;
/// Electron densities of cooling \[cm⁻³\].
const DENSITIES: [f64; 7] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6];
/// Ions that have lines at most.
const COOLANTS: usize = 28;
const COUNT: usize = LINES + COOLANTS * DENSITIES.len();

/// Rows of the table, and the temperatures between which they stand \[K\].
const ROWS: usize = 640;
const COLDEST: f64 = 300.0;
const HOTTEST: f64 = 80_000.0;

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

/// Those of the fits themselves, at a temperature in K.
fn exact(temperature: f64) -> [f64; COUNT] {
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
    for (sort, value) in [
        (Of::CaseB, hydrogen.case_b(temperature, 1.0)),
        (Of::CaseBCooling, hydrogen.case_b_cooling(temperature, 1.0)),
        (Of::Ground, hydrogen.to_ground(temperature, 1.0)),
        (Of::GroundCooling, hydrogen.to_ground_cooling(temperature, 1.0)),
        (Of::StrippedCaseB, hydrogen.case_b(temperature, 2.0)),
        (Of::StrippedCaseBCooling, hydrogen.case_b_cooling(temperature, 2.0)),
        (Of::StrippedGround, hydrogen.to_ground(temperature, 2.0)),
        (Of::StrippedGroundCooling, hydrogen.to_ground_cooling(temperature, 2.0)),
        (Of::FreeFree, hydrogen.free_free(temperature, 1.0)),
        (Of::StrippedFreeFree, hydrogen.free_free(temperature, 2.0)),
        (Of::Collisions, hydrogen.excitation(temperature) + HYDROGEN_EV * ERG_PER_EV * ionisation),
        (Of::Ionisation, ionisation),
        (Of::HeliumGround, helium.to_ground(temperature)),
        (Of::HeliumTriplets, triplets),
        (Of::HeliumSinglets, singlets),
    ] {
        values[HYDROGEN + sort as usize] = value;
    }
    for (row, electrons) in DENSITIES.into_iter().enumerate() {
        let at = atoms.collisional.conditions(temperature, electrons);
        for line in atoms.collisional.lines.iter().filter(|line| line.charge < STAGES) {
            if let Ok(ion) = coolants().binary_search(&(line.element, line.charge)) {
                values[LINES + row * COOLANTS + ion] += atoms.collisional.emissivity(line, &at);
            }
        }
    }
    values
}

/// The rows of the table.
fn table() -> &'static [[f64; COUNT]] {
    static TABLE: OnceLock<Vec<[f64; COUNT]>> = OnceLock::new();
    TABLE.get_or_init(|| (0..ROWS).map(|row| exact(COLDEST * (row as f64 * step()).exp())).collect())
}

/// Between two rows, in ln T.
fn step() -> f64 {
    (HOTTEST / COLDEST).ln() / (ROWS - 1) as f64
}

/// Coefficients of gas in several beams, and of lines those at the densities around that of the electrons.
#[derive(Debug, Clone)]
pub struct Coefficients {
    /// The temperature of electrons \[K\].
    pub temperature: Lanes,
    /// The row of the denser of the two [`DENSITIES`].
    row: [usize; LANES],
    values: [Lanes; LINES + 2 * COOLANTS],
    coolants: Vec<usize>,
}

impl Default for Coefficients {
    fn default() -> Self {
        let coolants = coolants().iter().map(|(element, charge)| ion(*element, *charge)).collect();
        Self { temperature: Lanes::ZERO, row: [1; LANES], values: [Lanes::ONE; LINES + 2 * COOLANTS], coolants }
    }
}

impl Coefficients {
    /// Makes those of a lane be at a temperature \[K\] and electron density \[cm⁻³\]: those of the fits themselves, or between
    /// the two nearest rows of the table, linear in ln T.
    pub fn renew(&mut self, lane: usize, (temperature, electrons): (f64, f64), is_exact: bool) {
        let last = DENSITIES.len() - 1;
        let row = DENSITIES.partition_point(|n| *n < electrons).clamp(1, last);
        let first = LINES + (row - 1) * COOLANTS;
        if is_exact {
            let values = exact(temperature);
            let values = values[..LINES].iter().chain(&values[first..first + 2 * COOLANTS]);
            self.values.iter_mut().zip(values).for_each(|(to, value)| to[lane] = *value);
        } else {
            let place = ((temperature / COLDEST).ln() / step()).clamp(0.0, (ROWS - 1) as f64);
            let below = (place as usize).min(ROWS - 2);
            let (a, b, part) = (&table()[below], &table()[below + 1], place - below as f64);
            let (near, far) = self.values.split_at_mut(LINES);
            for (to, (a, b)) in near.iter_mut().zip(a.iter().zip(b)) {
                to[lane] = a + part * (b - a);
            }
            for (to, (a, b)) in far.iter_mut().zip(a[first..].iter().zip(&b[first..])) {
                to[lane] = a + part * (b - a);
            }
        }
        (self.temperature[lane], self.row[lane]) = (temperature, row);
    }

    /// Makes those of a lane anew where its gas has gone on: at all where they are to be exact, else by a tenth of what counts
    /// as a change of temperature, or to other densities.
    pub fn keep_up(&mut self, lane: usize, (temperature, electrons): (f64, f64), is_exact: bool, change: f64) {
        let is_near = if is_exact {
            temperature == self.temperature[lane]
        } else {
            (temperature / self.temperature[lane] - 1.0).abs() <= 0.1 * change
        };
        if !is_near || !self.is_around(lane, electrons) {
            self.renew(lane, (temperature, electrons), is_exact);
        }
    }

    /// True if the coefficients of a lane are tabulated at densities around the given one \[cm⁻³\].
    fn is_around(&self, lane: usize, electrons: f64) -> bool {
        let row = self.row[lane];
        (row == 1 || electrons >= DENSITIES[row - 1]) && (row == DENSITIES.len() - 1 || electrons <= DENSITIES[row])
    }

    /// One of hydrogen's or helium's.
    #[inline(always)]
    pub fn of(&self, sort: Of) -> Lanes {
        self.values[HYDROGEN + sort as usize]
    }

    /// The rates between a charge of a metal and the next.
    #[inline(always)]
    pub fn transition(&self, metal: usize, charge: usize) -> [Lanes; RATES] {
        let first = (metal * TRANSITIONS + charge) * RATES;
        [self.values[first], self.values[first + 1], self.values[first + 2]]
    }

    /// k T \[erg\].
    #[inline(always)]
    pub fn kt_erg(&self) -> Lanes {
        self.temperature * (BOLTZMANN_EV * ERG_PER_EV)
    }

    /// Σ over ions that have lines of their density ([`ion`]), and the energy of their lines per electron \[erg s⁻¹\], by how
    /// many electrons there are: between two densities the inverse is linear, as for two levels.
    #[inline(always)]
    pub fn lines(&self, electrons: Lanes, densities: &[Lanes]) -> Lanes {
        let (low, high) = (Lanes::each(|lane| DENSITIES[self.row[lane] - 1]), Lanes::each(|lane| DENSITIES[self.row[lane]]));
        let part = ((electrons - low) / (high - low)).at_least(0.0).at_most(1.0);
        let rest = Lanes::ONE - part;
        let (thin, dense) = self.values[LINES..].split_at(COOLANTS);
        let mut sum = Lanes::ZERO;
        for ((a, b), ion) in thin.iter().zip(dense).zip(&self.coolants) {
            sum += densities[*ion] * *a * *b / (rest * *b + part * *a).at_least(f64::MIN_POSITIVE);
        }
        sum
    }
}
