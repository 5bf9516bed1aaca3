//! Ionising photons by chance: hydrogen of one temperature, whose own light goes in all directions. Knows nothing of beams.

use glam::DVec3;
use ionisation::atoms::{Atoms, BOLTZMANN_EV, Element, HYDROGEN_EV};
use ionisation::cloud::{Cloud, PARSEC_CM};
use rayon::prelude::*;

/// Photons that one chain of random numbers follows.
const CHUNK: u64 = 2000;
/// Rounds that the mean does not count.
const FIRST: u64 = 10;
/// Energies in which the star's photons are \[eV\], and steps between.
const ENERGIES: (f64, f64, usize) = (HYDROGEN_EV, 120.0, 4000);

/// Numbers between zero and one by a counter that is mixed (Steele, Lea & Flood 2014, SplitMix64).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn direction(&mut self) -> DVec3 {
        let (z, angle) = (2.0 * self.next() - 1.0, std::f64::consts::TAU * self.next());
        let ring = (1.0 - z * z).sqrt();
        DVec3::new(ring * angle.cos(), ring * angle.sin(), z)
    }

    /// A depth, or an energy in units of its mean.
    fn exponential(&mut self) -> f64 {
        -(1.0 - self.next()).ln()
    }
}

/// A star: its place \[pc\], its temperature as a black body \[K\], and its ionising photons \[s⁻¹\].
pub struct Source {
    pub place: DVec3,
    pub temperature: f64,
    pub photons: f64,
}

/// How photons are followed.
pub struct Follow {
    /// The temperature of the gas \[K\].
    pub temperature: f64,
    /// True if recombinations to the ground level send out photons; else those are absorbed on the spot.
    pub is_diffuse: bool,
    /// Photons of a round, and rounds.
    pub photons: u64,
    pub rounds: u64,
}

/// The part of hydrogen that is neutral by voxel, after rounds that begin with what is told. Of few photons gas is more
/// neutral than of many (⟨1/Γ⟩ > 1/⟨Γ⟩), so that later rounds have the mean of what all after the first few have found.
pub fn neutral(cloud: &Cloud, source: &Source, follow: &Follow, first: Vec<f64>) -> Vec<f64> {
    let hydrogen = &Atoms::get().hydrogen;
    let (ground, rest) = (hydrogen.to_ground(follow.temperature, 1.0), hydrogen.case_b(follow.temperature, 1.0));
    let caught = if follow.is_diffuse { ground + rest } else { rest };
    let energies = energies(source.temperature);
    let volume = (cloud.voxel * PARSEC_CM).element_product();
    let (mut neutral, mut means) = (first, vec![0.0; cloud.hydrogen.len()]);
    for round in 0..follow.rounds {
        let photons = follow.photons;
        let walk = Walk {
            cloud,
            neutral: &neutral,
            again: if follow.is_diffuse { ground / caught } else { 0.0 },
            temperature: follow.temperature,
        };
        let sums = (0..photons.div_ceil(CHUNK))
            .into_par_iter()
            .fold(
                || vec![0.0; neutral.len()],
                |mut sums, chunk| {
                    let mut chance = Chance(round << 48 | chunk << 20);
                    for _ in 0..CHUNK {
                        let energy = energies[(chance.next() * energies.len() as f64) as usize];
                        walk.follow(source.place, energy, &mut chance, &mut sums);
                    }
                    sums
                },
            )
            .reduce(|| vec![0.0; neutral.len()], |a, b| a.iter().zip(&b).map(|(a, b)| a + b).collect());
        let per_photon = source.photons / (photons.div_ceil(CHUNK) * CHUNK) as f64 / volume;
        let new = 1.0 / (round + 1).saturating_sub(FIRST).max(1) as f64;
        means.iter_mut().zip(&sums).for_each(|(mean, sum)| *mean += new * (sum - *mean));
        // n (1 − x)² α = x Γ; where photons end within a voxel x goes to and fro, so that it goes half of the way in ln x.
        let balance = |sum: f64, n: f64| {
            let ratio = sum * per_photon / (n * caught);
            1.0 / (1.0 + 0.5 * ratio + (ratio + 0.25 * ratio * ratio).sqrt())
        };
        let voxels = means.iter().zip(cloud.hydrogen).zip(&neutral);
        neutral = voxels.map(|((sum, n), before)| (balance(*sum, f64::from(*n)) * before).sqrt()).collect();
    }
    neutral
}

/// Energies of a black body's ionising photons \[eV\], each as probable as another.
fn energies(temperature: f64) -> Vec<f64> {
    let (low, high, count) = ENERGIES;
    let at = |i: usize| low + (high - low) * (i as f64 + 0.5) / count as f64;
    let mut sums = vec![0.0; count];
    let mut sum = 0.0;
    for (i, to) in sums.iter_mut().enumerate() {
        sum += at(i) * at(i) / (at(i) / (BOLTZMANN_EV * temperature)).exp_m1();
        *to = sum;
    }
    (0..count).map(|i| at(sums.partition_point(|s| *s < sum * (i as f64 + 0.5) / count as f64))).collect()
}

struct Walk<'a> {
    cloud: &'a Cloud<'a>,
    neutral: &'a [f64],
    /// The part of recombinations that send out a photon that ionises.
    again: f64,
    temperature: f64,
}

impl Walk<'_> {
    /// Follows a photon until it is gone; adds σ ℓ to the sums of voxels \[cm³\].
    fn follow(&self, mut place: DVec3, mut energy: f64, chance: &mut Chance, sums: &mut [f64]) {
        let fit = Atoms::get().transition(Element::Hydrogen, 0).light.as_ref().expect("hydrogen is ionised by light");
        loop {
            let (direction, sigma) = (chance.direction(), fit.at(energy));
            let Some(absorbed) = self.fly(place, direction, sigma, chance.exponential(), sums) else { return };
            if chance.next() >= self.again {
                return;
            }
            place = absorbed;
            energy = HYDROGEN_EV + BOLTZMANN_EV * self.temperature * chance.exponential();
        }
    }

    /// Absorption point of a photon after an optical depth; nowhere where it leaves the cloud.
    fn fly(&self, start: DVec3, direction: DVec3, sigma: f64, mut depth: f64, sums: &mut [f64]) -> Option<DVec3> {
        let Cloud { dims, low, voxel, .. } = self.cloud;
        let within = (start - *low) / *voxel;
        let mut at: [i64; 3] = std::array::from_fn(|axis| within[axis].floor() as i64);
        let step = direction.to_array().map(|d| if d > 0.0 { 1i64 } else { -1 });
        let mut next: [f64; 3] = std::array::from_fn(|axis| {
            let side = at[axis] as f64 + if step[axis] > 0 { 1.0 } else { 0.0 };
            (side - within[axis]) * voxel[axis] / direction[axis]
        });
        let mut gone = 0.0;
        loop {
            if (0..3).any(|axis| at[axis] < 0 || at[axis] >= dims[axis] as i64) {
                return None;
            }
            let place = (at[2] as usize * dims[1] + at[1] as usize) * dims[0] + at[0] as usize;
            let axis = (0..3).fold(0, |least, axis| if next[axis] < next[least] { axis } else { least });
            let way_cm = (next[axis] - gone) * PARSEC_CM;
            let opacity = f64::from(self.cloud.hydrogen[place]) * self.neutral[place] * sigma;
            if opacity * way_cm >= depth {
                let last_cm = depth / opacity;
                sums[place] += sigma * last_cm;
                return Some(start + (gone + last_cm / PARSEC_CM) * direction);
            }
            sums[place] += sigma * way_cm;
            depth -= opacity * way_cm;
            gone = next[axis];
            at[axis] += step[axis];
            next[axis] += voxel[axis] / direction[axis].abs();
        }
    }
}
