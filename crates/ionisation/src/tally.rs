//! Beam contributions to voxels and blocks: sums in whole units, which are the same in whatever order they come.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::balance::{Gas, GasState};
use crate::cloud::{Cloud, PARSEC_CM, place_of};
use crate::quantity::Quantity;

/// Cells along the edge of a page.
const PAGE: usize = 8;
/// Factor of density between the two evaluations that give an exponent \[1\].
const DENSER: f64 = 1.25;
/// Range of exponents.
const EXPONENTS: [f64; 2] = [-2.0, 6.0];
/// Units of a sum for the most that it may be in a voxel: a thousand times as much is still counted.
const UNITS: f64 = (1u64 << 54) as f64;

/// Sums of quantities over voxels and over blocks of voxels.
pub struct Tally<'a> {
    quantities: &'a [Quantity<'a>],
    /// By level, from voxels to the largest blocks.
    levels: Vec<Sums>,
    /// Steps, and those that did not settle.
    steps: AtomicU64,
    unsettled: AtomicU64,
    /// The part of the star's photons that stayed in the cloud.
    pub cache: AbsorbedShare,
}

/// Sums over cells of one size.
struct Sums {
    dims: [usize; 3],
    /// Volume of a cell \[cm³\].
    cell_volume: f64,
    /// Count of numbers per cell: volume, sums of the quantities and, in blocks, sums of their exponents.
    each: usize,
    /// Cubes of [`PAGE`] cells along each edge that a beam has met.
    pages: Vec<OnceLock<Box<[AtomicU64]>>>,
}

/// Contribution of a beam to a cell: a fraction of its volume, sums of quantities relative to their maxima, and sums of their exponents in
/// blocks.
pub struct Seen {
    part: f64,
    values: Vec<f64>,
}

/// Means of a cell.
pub struct CellMeans<'a> {
    /// Fraction of the cell's volume that beams have crossed \[1\].
    pub volume: f64,
    sums: &'a [AtomicU64],
}

impl CellMeans<'_> {
    /// Mean of a quantity relative to its maximum \[1\].
    pub fn mean(&self, quantity: usize) -> f64 {
        self.sum(quantity) / self.volume
    }

    /// Mean exponent of the density with which a quantity varies within a block.
    pub fn exponent(&self, quantity: usize) -> f64 {
        let (sum, exponents) = (self.sum(quantity), self.sum(self.sums.len() / 2 + quantity));
        if sum > 0.0 { EXPONENTS[0] + (EXPONENTS[1] - EXPONENTS[0]) * exponents / sum } else { 0.0 }
    }

    fn sum(&self, place: usize) -> f64 {
        self.sums[place].load(Ordering::Relaxed) as f64 / UNITS
    }
}

impl Sums {
    fn new(cloud: &Cloud, each: usize) -> Self {
        let pages = cloud.dims.map(|n| n.div_ceil(PAGE)).iter().product();
        let cell_volume = (cloud.voxel * PARSEC_CM).element_product();
        Self { dims: cloud.dims, cell_volume, each, pages: (0..pages).map(|_| OnceLock::new()).collect() }
    }

    /// The page of a cell, and where the cell begins in it.
    fn place(&self, [x, y, z]: [usize; 3]) -> (usize, usize) {
        let [nx, ny, _] = self.dims.map(|n| n.div_ceil(PAGE));
        let page = (z / PAGE * ny + y / PAGE) * nx + x / PAGE;
        (page, ((z % PAGE * PAGE + y % PAGE) * PAGE + x % PAGE) * self.each)
    }

    fn add(&self, cell: usize, seen: &mut Seen) {
        let (page, first) = self.place(place_of(self.dims, cell));
        let page = self.pages[page].get_or_init(|| (0..PAGE * PAGE * PAGE * self.each).map(|_| AtomicU64::new(0)).collect());
        let add = |place: usize, value: &mut f64| {
            let value = std::mem::take(value);
            if value > 0.0 {
                page[first + place].fetch_add(unit(value), Ordering::Relaxed);
            }
        };
        add(0, &mut seen.part);
        seen.values.iter_mut().take(self.each - 1).enumerate().for_each(|(place, value)| add(1 + place, value));
    }

    fn means(&self, place: [usize; 3]) -> Option<CellMeans<'_>> {
        let (page, first) = self.place(place);
        let (volume, sums) = self.pages[page].get()?[first..first + self.each].split_first()?;
        let volume = volume.load(Ordering::Relaxed) as f64 / UNITS;
        (volume > 0.0).then_some(CellMeans { volume, sums })
    }
}

/// The part of a star's photons that stays in a cloud.
#[derive(Default)]
pub struct AbsorbedShare(AtomicU64);

impl AbsorbedShare {
    /// Adds a part of them.
    pub fn add(&self, part: f64) {
        self.0.fetch_add(unit(part), Ordering::Relaxed);
    }

    /// The part that leaves.
    pub fn escaped(&self) -> f64 {
        (1.0 - self.0.load(Ordering::Relaxed) as f64 / UNITS).clamp(0.0, 1.0)
    }
}

/// Whole units of a part of a voxel's most.
fn unit(part: f64) -> u64 {
    (part * UNITS) as u64
}

impl<'a> Tally<'a> {
    /// Nothing yet, in the cells of each level: voxels, and blocks of them.
    pub fn new(levels: &[Cloud], quantities: &'a [Quantity<'a>]) -> Self {
        let each = |level: usize| 1 + quantities.len() * if level > 0 { 2 } else { 1 };
        Self {
            quantities,
            levels: levels.iter().enumerate().map(|(level, cloud)| Sums::new(cloud, each(level))).collect(),
            steps: AtomicU64::new(0),
            unsettled: AtomicU64::new(0),
            cache: AbsorbedShare::default(),
        }
    }

    /// Nothing yet of a beam in a cell.
    pub fn seen(&self) -> Seen {
        Seen { part: 0.0, values: vec![0.0; 2 * self.quantities.len()] }
    }

    /// Has a beam see gas in a volume \[cm³\] of a cell of some level.
    pub fn see(&self, (level, seen): (usize, &mut Seen), volume: f64, gas: &Gas, state: &GasState) {
        let part = volume / self.levels[level].cell_volume;
        seen.part += part;
        let (sums, exponents) = seen.values.split_at_mut(self.quantities.len());
        if level == 0 {
            return self.quantities.iter().zip(sums).for_each(|(quantity, sum)| *sum += part * quantity.part(gas, state));
        }
        let (denser_gas, denser_state) = (Gas { hydrogen: gas.hydrogen * DENSER, ..*gas }, state.denser(DENSER));
        for ((quantity, sum), exponents) in self.quantities.iter().zip(sums).zip(exponents) {
            let value = quantity.part(gas, state);
            *sum += part * value;
            if value > 0.0 {
                let exponent = (quantity.part(&denser_gas, &denser_state) / value).ln() / DENSER.ln();
                *exponents += part * value * ((exponent - EXPONENTS[0]) / (EXPONENTS[1] - EXPONENTS[0])).clamp(0.0, 1.0);
            }
        }
    }

    /// Adds what a beam has seen of a cell of some level, and has it begin anew.
    pub fn add(&self, (level, cell): (usize, usize), seen: &mut Seen) {
        if seen.part > 0.0 {
            self.levels[level].add(cell, seen);
        }
    }

    /// Counts a step, and whether its gas has settled.
    pub fn count(&self, has_settled: bool) {
        self.steps.fetch_add(1, Ordering::Relaxed);
        self.unsettled.fetch_add(u64::from(!has_settled), Ordering::Relaxed);
    }

    /// The steps so far, and those in which the gas did not settle.
    pub fn steps(&self) -> [u64; 2] {
        [&self.steps, &self.unsettled].map(|count| count.load(Ordering::Relaxed))
    }

    /// The means of a cell of some level that a beam has met.
    pub fn means(&self, level: usize, place: [usize; 3]) -> Option<CellMeans<'_>> {
        self.levels[level].means(place)
    }

    /// Requested quantities.
    pub fn quantities(&self) -> &'a [Quantity<'a>] {
        self.quantities
    }
}
