//! What beams leave in voxels: sums in whole units, which are the same in whatever order they come.

use std::sync::atomic::{AtomicU64, Ordering};

use multiversion::multiversion;
use rayon::prelude::*;

use crate::balance::{Gas, State};
use crate::light::{ByNode, IonisingLight, NODES};

/// Units of a sum for the most that it may be in a voxel: a thousand times as much is still counted.
const UNITS: f64 = (1u64 << 54) as f64;

/// What is asked for of the gas in each voxel.
pub struct Quantity<'a> {
    /// The most that it can be: what is more counts as that.
    pub most: f64,
    /// What it is.
    pub value: &'a (dyn Fn(&Gas, &State) -> f64 + Sync),
}

impl Quantity<'_> {
    /// What it is of a gas, in parts of the most.
    pub(crate) fn part(&self, gas: &Gas, state: &State) -> f64 {
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
    pub kept: Kept,
}

/// What a beam has seen of a voxel: a part of its volume, and sums by quantity in parts of their most.
pub struct Seen {
    part: f64,
    values: Vec<f64>,
}

/// The part of a star's photons that stays in a cloud.
#[derive(Default)]
pub struct Kept(AtomicU64);

impl Kept {
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
    /// Nothing yet, in so many voxels of a volume in cm³.
    pub fn new(cells: usize, voxel_volume: f64, quantities: &'a [Quantity<'a>]) -> Self {
        Self {
            quantities,
            volume: zeros(cells),
            sums: quantities.iter().map(|_| zeros(cells)).collect(),
            voxel_volume,
            steps: AtomicU64::new(0),
            unsettled: AtomicU64::new(0),
            kept: Kept::default(),
        }
    }

    /// Nothing yet of a beam in a voxel.
    pub fn seen(&self) -> Seen {
        Seen { part: 0.0, values: vec![0.0; self.sums.len()] }
    }

    /// Has a beam see gas in a volume \[cm³\].
    pub fn see(&self, seen: &mut Seen, volume: f64, gas: &Gas, state: &State) {
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
        let of = |(quantity, sums): (&Quantity, &Vec<AtomicU64>)| {
            let voxels = sums.par_iter().zip(&self.volume);
            voxels.map(|(sum, volume)| mean(sum, quantity.most, volume.load(Ordering::Relaxed) as f64)).collect()
        };
        self.quantities.iter().zip(&self.sums).map(of).collect()
    }
}

/// What stands behind the flux by node, each times the flux in all of them: the distance that it has come \[cm\], the voxel's
/// cross section and the relative variance of ways through it ([`met`](crate::rays::Rays::met)).
pub const BEHIND: usize = 3;

/// Photons by node in whole units of a voxel's most, given what makes parts of it of them and how large one may be; and the sum
/// of those parts.
#[multiversion(targets = "simd")]
fn in_units(photons: &ByNode, factor: f64, most: f64) -> ([u64; NODES], f64) {
    let (mut units, mut all) = ([0; NODES], [0.0; NODES]);
    for node in 0..NODES {
        let part = photons[node] * factor;
        all[node] = if part < most { part } else { most };
        units[node] = (all[node] * UNITS) as i64 as u64;
    }
    (units, all.iter().sum())
}

/// The light of one star in voxels, as it comes in: sums of its flux by node times the area of beams, and what stands behind it.
pub struct Lit {
    /// The most that the flux is taken to be \[s⁻¹ cm⁻²\].
    most: f64,
    /// What makes parts of the most of what stands behind it.
    scales: [f64; BEHIND],
    area: Vec<AtomicU64>,
    sums: Vec<AtomicU64>,
    nodes: usize,
}

impl Lit {
    /// None yet, in so many voxels, given how near to the star gas is and how far away at most \[cm\].
    pub fn new(cells: usize, (nearest_cm, farthest_cm): (f64, f64), light: &IonisingLight) -> Self {
        let nodes = light.energies_ev.len();
        let most = 10.0 * light.photons.iter().sum::<f64>() / (nearest_cm * nearest_cm);
        let scales = [farthest_cm, 1.0, 1.0];
        Self { most, scales, area: zeros(cells), sums: zeros(cells * (nodes + BEHIND)), nodes }
    }

    /// Has a beam enter a voxel, whose cross section it is a part of, with photons by node \[s⁻¹\] that are a flux by a factor
    /// \[cm⁻²\], and what stands behind it.
    pub fn meet(&self, voxel: usize, part: f64, (photons, per_area): (&ByNode, f64), behind: [f64; BEHIND]) {
        self.area[voxel].fetch_add(unit(part), Ordering::Relaxed);
        let sums = &self.sums[voxel * (self.nodes + BEHIND)..][..self.nodes + BEHIND];
        let (units, all) = in_units(photons, part * per_area / self.most, part);
        for (sum, value) in sums.iter().zip(&units[..self.nodes]).filter(|(_, value)| **value > 0) {
            sum.fetch_add(*value, Ordering::Relaxed);
        }
        for ((sum, scale), value) in sums[self.nodes..].iter().zip(self.scales).zip(behind) {
            sum.fetch_add(unit(all * value / scale), Ordering::Relaxed);
        }
    }

    /// Has a beam enter a voxel that brings nothing.
    pub fn meet_dark(&self, voxel: usize, part: f64) {
        self.area[voxel].fetch_add(unit(part), Ordering::Relaxed);
    }

    /// Adds the mean in each voxel of the flux, node by node \[s⁻¹ cm⁻²\], and what stands behind it; gives the sum over nodes
    /// of flux and what `weights` has for each.
    pub fn add_to(&self, flux: &mut [f32], weights: &ByNode) -> Vec<f32> {
        let sums = self.sums.par_chunks_exact(self.nodes + BEHIND);
        let of = |((flux, sums), area): ((&mut [f32], &[AtomicU64]), &AtomicU64)| {
            let area = area.load(Ordering::Relaxed) as f64;
            let (by_node, behind) = flux.split_at_mut(self.nodes);
            for ((to, sum), scale) in behind.iter_mut().zip(&sums[self.nodes..]).zip(self.scales) {
                *to += mean(sum, self.most * scale, area);
            }
            let mut weighted = 0.0;
            for ((to, sum), weight) in by_node.iter_mut().zip(sums).zip(weights) {
                let value = mean(sum, self.most, area);
                *to += value;
                weighted += f64::from(value) * weight;
            }
            weighted as f32
        };
        flux.par_chunks_exact_mut(self.nodes + BEHIND).zip(sums).zip(&self.area).map(of).collect()
    }
}
