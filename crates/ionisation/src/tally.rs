//! Beam contributions to voxels: sums in whole units, which are the same in whatever order they come.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::balance::{Gas, GasState};

/// Units of a sum for the most that it may be in a voxel: a thousand times as much is still counted.
const UNITS: f64 = (1u64 << 54) as f64;

/// Requested quantities of the gas in each voxel.
pub struct Quantity<'a> {
    /// The most that it can be: what is more counts as that.
    pub most: f64,
    /// Value for a gas and its state.
    pub value: &'a (dyn Fn(&Gas, &GasState) -> f64 + Sync),
}

impl Quantity<'_> {
    /// Quantity of a gas, relative to its maximum.
    pub(crate) fn part(&self, gas: &Gas, state: &GasState) -> f64 {
        ((self.value)(gas, state) / self.most).clamp(0.0, 1.0)
    }
}

/// Sums of what is asked for.
pub struct Tally<'a> {
    quantities: &'a [Quantity<'a>],
    /// The volume that beams have seen of each voxel, in parts of it.
    volume: Vec<AtomicU64>,
    /// By quantity its sum.
    sums: Vec<Vec<AtomicU64>>,
    /// \[cm³\]
    voxel_volume: f64,
    /// Steps, and those that did not settle.
    steps: AtomicU64,
    unsettled: AtomicU64,
    /// The part of the star's photons that stayed in the cloud.
    pub cache: AbsorbedShare,
}

/// Statistics of a voxel along a beam: a part of its volume, and sums by quantity in parts of their most.
pub struct Seen {
    part: f64,
    values: Vec<f64>,
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

fn zeros(count: usize) -> Vec<AtomicU64> {
    (0..count).map(|_| AtomicU64::new(0)).collect()
}

/// The mean of a sum whose most is given, over a volume in whole units; nothing where there is no volume.
fn mean(sum: &AtomicU64, most: f64, volume: f64) -> f32 {
    if volume > 0.0 { (most * sum.load(Ordering::Relaxed) as f64 / volume) as f32 } else { 0.0 }
}

impl<'a> Tally<'a> {
    /// Nothing yet, in a given number of voxels of a volume in cm³.
    pub fn new(cells: usize, voxel_volume: f64, quantities: &'a [Quantity<'a>]) -> Self {
        Self {
            quantities,
            volume: zeros(cells),
            sums: quantities.iter().map(|_| zeros(cells)).collect(),
            voxel_volume,
            steps: AtomicU64::new(0),
            unsettled: AtomicU64::new(0),
            cache: AbsorbedShare::default(),
        }
    }

    /// Nothing yet of a beam in a voxel.
    pub fn seen(&self) -> Seen {
        Seen { part: 0.0, values: vec![0.0; self.sums.len()] }
    }

    /// Has a beam see gas in a volume \[cm³\].
    pub fn see(&self, seen: &mut Seen, volume: f64, gas: &Gas, state: &GasState) {
        let part = volume / self.voxel_volume;
        seen.part += part;
        for (quantity, sum) in self.quantities.iter().zip(&mut seen.values) {
            *sum += part * quantity.part(gas, state);
        }
    }

    /// Adds what a beam has seen of a voxel, and has it begin anew.
    pub fn add(&self, voxel: usize, seen: &mut Seen) {
        if seen.part > 0.0 {
            self.volume[voxel].fetch_add(unit(std::mem::take(&mut seen.part)), Ordering::Relaxed);
            for (sums, value) in self.sums.iter().zip(&mut seen.values) {
                let value = std::mem::take(value);
                if value > 0.0 {
                    sums[voxel].fetch_add(unit(value), Ordering::Relaxed);
                }
            }
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

    /// The means of what is asked for.
    pub fn quantities(&self) -> Vec<Vec<f32>> {
        let sum = |(quantity, sums): (&Quantity, &Vec<AtomicU64>)| {
            let voxels = sums.par_iter().zip(&self.volume);
            voxels.map(|(sum, volume)| mean(sum, quantity.most, volume.load(Ordering::Relaxed) as f64)).collect()
        };
        self.quantities.iter().zip(&self.sums).map(sum).collect()
    }
}
