//! What beams leave in voxels: sums in whole units, which are the same in whatever order they come.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::balance::{Gas, State};
use crate::light::{ByNode, IonisingLight};

/// Units of a sum for the most that it may be in a voxel: a thousand times as much is still counted.
const UNITS: f64 = (1u64 << 54) as f64;

/// What is asked for of the gas in each voxel; where gas is dark, of several stars each answers for a part, whether it
/// comes there or not.
pub struct Quantity<'a> {
    /// The most that it can be: what is more counts as that.
    pub most: f64,
    /// What it is.
    pub value: &'a (dyn Fn(&Gas, &State) -> f64 + Sync),
}

/// Sums of what is asked for.
pub struct Tally<'a> {
    quantities: &'a [Quantity<'a>],
    /// The volume that a star's beams have seen of each voxel; the same of all stars so far, and how many saw any.
    volume: Vec<AtomicU64>,
    seen: Vec<(u64, u64)>,
    /// By quantity its sum; that of ions of hydrogen is the last.
    sums: Vec<Vec<AtomicU64>>,
    /// The densest gas \[cm⁻³\].
    densest: f64,
    /// \[cm³\]
    pub voxel_volume: f64,
    /// Steps, those that did not settle, and the part of a star's photons that stayed in the cloud.
    steps: AtomicU64,
    unsettled: AtomicU64,
    kept: AtomicU64,
}

/// What a beam has seen of a voxel: a part of its volume, and sums by quantity in parts of their most.
pub struct Seen {
    part: f64,
    values: Vec<f64>,
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
    /// Nothing yet, in voxels of these densities and a volume in cm³.
    pub fn new(hydrogen: &[f32], voxel_volume: f64, quantities: &'a [Quantity<'a>]) -> Self {
        let cells = hydrogen.len();
        Self {
            quantities,
            volume: zeros(cells),
            seen: vec![(0, 0); cells],
            sums: (0..=quantities.len()).map(|_| zeros(cells)).collect(),
            densest: hydrogen.iter().fold(0.0f32, |most, n| most.max(*n)).into(),
            voxel_volume,
            steps: AtomicU64::new(0),
            unsettled: AtomicU64::new(0),
            kept: AtomicU64::new(0),
        }
    }

    /// Nothing yet of a beam in a voxel.
    pub fn seen(&self) -> Seen {
        Seen { part: 0.0, values: vec![0.0; self.sums.len()] }
    }

    /// Has a beam see gas in a volume \[cm³\], of which it is to answer for a share.
    pub fn see(&self, seen: &mut Seen, (volume, share): (f64, f64), gas: &Gas, state: &State) {
        let part = volume / self.voxel_volume;
        seen.part += part;
        if share <= 0.0 {
            return;
        }
        let last = self.quantities.len();
        for (quantity, sum) in self.quantities.iter().zip(&mut seen.values) {
            *sum += part * share * ((quantity.value)(gas, state) / quantity.most).clamp(0.0, 1.0);
        }
        seen.values[last] += part * share * (gas.hydrogen * state.fractions[0][1] / self.densest).clamp(0.0, 1.0);
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
    pub fn steps(&mut self) -> [u64; 2] {
        [*self.steps.get_mut(), *self.unsettled.get_mut()]
    }

    /// Adds a part of a star's photons that stayed in the cloud.
    pub fn keep(&self, part: f64) {
        self.kept.fetch_add(unit(part), Ordering::Relaxed);
    }

    /// Ends a star's beams; gives the part of its photons that left the cloud.
    pub fn next_star(&mut self) -> f64 {
        for ((all, stars), volume) in self.seen.iter_mut().zip(&mut self.volume) {
            let volume = std::mem::take(volume.get_mut());
            (*all, *stars) = (*all + volume, *stars + u64::from(volume > 0));
        }
        let kept = std::mem::take(self.kept.get_mut()) as f64 / UNITS;
        (1.0 - kept).clamp(0.0, 1.0)
    }

    /// The means of the ions of hydrogen \[cm⁻³\].
    pub fn ions(&self) -> Vec<f32> {
        self.means(self.quantities.len(), self.densest)
    }

    /// The means of what is asked for.
    pub fn quantities(&self) -> Vec<Vec<f32>> {
        self.quantities.iter().enumerate().map(|(sum, quantity)| self.means(sum, quantity.most)).collect()
    }

    /// The means of a sum, whose most is given.
    fn means(&self, sum: usize, most: f64) -> Vec<f32> {
        // Each of the stars saw it once.
        let volume = |(all, stars): &(u64, u64)| *all as f64 / (*stars).max(1) as f64;
        self.sums[sum].par_iter().zip(&self.seen).map(|(sum, seen)| mean(sum, most, volume(seen))).collect()
    }
}

/// What a beam has lit of a voxel: a part of its volume, and sums of flux by node in parts of the most.
#[derive(Default)]
pub struct Shone {
    part: f64,
    sums: ByNode,
}

/// The light of one star in voxels: sums of its flux by node, times volume.
pub struct Lit {
    /// The most that the flux is taken to be \[s⁻¹ cm⁻²\].
    most: f64,
    volume: Vec<AtomicU64>,
    sums: Vec<AtomicU64>,
    nodes: usize,
}

impl Lit {
    /// None yet, in so many voxels whose shortest edge is given \[cm\].
    pub fn new(cells: usize, edge_cm: f64, light: &IonisingLight) -> Self {
        let nodes = light.energies_ev.len();
        let most = 10.0 * light.photons.iter().sum::<f64>() / (edge_cm * edge_cm);
        Self { most, volume: zeros(cells), sums: zeros(cells * nodes), nodes }
    }

    /// Has a beam light a part of a voxel.
    pub fn light(&self, shone: &mut Shone, part: f64, flux: &ByNode) {
        shone.part += part;
        for (sum, flux) in shone.sums.iter_mut().zip(flux).filter(|(_, flux)| **flux > 0.0) {
            *sum += part * (flux / self.most).min(1.0);
        }
    }

    /// Adds what a beam has lit of a voxel, and has it begin anew.
    pub fn add(&self, voxel: usize, shone: &mut Shone) {
        if shone.part > 0.0 {
            self.volume[voxel].fetch_add(unit(shone.part), Ordering::Relaxed);
            for (sum, own) in self.sums[voxel * self.nodes..].iter().zip(&shone.sums[..self.nodes]).filter(|(_, own)| **own > 0.0) {
                sum.fetch_add(unit(*own), Ordering::Relaxed);
            }
            *shone = Shone::default();
        }
    }

    /// Writes the mean flux in each voxel, node by node \[s⁻¹ cm⁻²\].
    pub fn flux(&self, flux: &mut [f32]) {
        let sums = self.sums.par_chunks_exact(self.nodes);
        flux.par_chunks_exact_mut(self.nodes).zip(sums).zip(&self.volume).for_each(|((flux, sums), volume)| {
            let volume = volume.load(Ordering::Relaxed) as f64;
            flux.iter_mut().zip(sums).for_each(|(flux, sum)| *flux = mean(sum, self.most, volume));
        });
    }
}
