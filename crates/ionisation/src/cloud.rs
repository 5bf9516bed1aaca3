//! A cloud in three dimensions around one star: beams that part as they go outward.
//!
//! Each beam solves the gas on its way, from the star outward, so that one pass is the solution, and shadows have sharp
//! edges. What it finds it leaves in the voxels, weighted by the volume of its steps: where a front runs through a voxel,
//! the voxel has of both sides what there is of them.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use spectra::constants::PARSEC;

use crate::atoms::ELEMENTS;
use crate::balance::{Accuracy, Diffuse, Gas, State};
use crate::beam::{Beam, Step};
use crate::light::IonisingLight;
use crate::patch::Patch;

/// Centimetres in a parsec.
const PARSEC_CM: f64 = 100.0 * PARSEC;
/// The level of patches with which beams begin.
const FIRST: u32 = 3;
/// The largest area of a beam in parts of a voxel's face \[1\].
const WIDEST: f64 = 1.0;
/// How far a beam goes on when its light is used up, so that voxels know how much of them is dark \[voxels\].
const BEYOND: f64 = 3.0;
/// Units of a sum for the most that it may be in a voxel.
const UNITS: f64 = (1u64 << 56) as f64;

/// A density on a grid of voxels.
#[derive(Debug, Clone)]
pub struct Cloud<'a> {
    /// Voxels along x, y and z.
    pub dims: [usize; 3],
    /// The lowest corner \[pc\].
    pub low: DVec3,
    /// The edges of a voxel \[pc\].
    pub voxel: DVec3,
    /// Nuclei of hydrogen, x fastest \[cm⁻³\].
    pub hydrogen: &'a [f32],
    /// Nuclei of each element for one of hydrogen.
    pub abundances: [f64; ELEMENTS],
    /// What dust absorbs of ionising light, for one nucleus of hydrogen \[cm²\].
    pub dust_cm2: f64,
}

/// What is asked for of the gas in each voxel.
pub struct Quantity<'a> {
    /// The most that it can be: what is more counts as that.
    pub most: f64,
    /// What it is.
    pub value: &'a (dyn Fn(&Gas, &State) -> f64 + Sync),
}

/// Sums in voxels, in whole units: in whatever order they come, they are the same.
struct Tally<'a> {
    quantities: &'a [Quantity<'a>],
    /// The volume that beams have seen of each voxel, and by quantity its sum.
    volume: Vec<AtomicU64>,
    sums: Vec<Vec<AtomicU64>>,
    /// \[cm³\]
    voxel_volume: f64,
}

impl Tally<'_> {
    fn add(&self, voxel: usize, volume: f64, gas: &Gas, state: Option<&State>) {
        let part = volume / self.voxel_volume;
        let unit = |part: f64| (part * UNITS / 4.0) as u64;
        self.volume[voxel].fetch_add(unit(part), Ordering::Relaxed);
        let Some(state) = state else { return };
        for (quantity, sums) in self.quantities.iter().zip(&self.sums) {
            sums[voxel].fetch_add(unit(part * ((quantity.value)(gas, state) / quantity.most).clamp(0.0, 1.0)), Ordering::Relaxed);
        }
    }
}

impl Cloud<'_> {
    /// What one star at a place \[pc\] makes of the cloud: by quantity its mean in each voxel.
    pub fn ionised(
        &self,
        (star, light): (DVec3, &IonisingLight),
        (diffuse, accuracy): (Diffuse, &Accuracy),
        quantities: &[Quantity],
    ) -> Vec<Vec<f32>> {
        let cells: usize = self.dims.iter().product();
        let zeros = || (0..cells).map(|_| AtomicU64::new(0)).collect::<Vec<_>>();
        let tally = Tally {
            quantities,
            volume: zeros(),
            sums: quantities.iter().map(|_| zeros()).collect(),
            voxel_volume: (self.voxel * PARSEC_CM).element_product(),
        };
        let follow = Follow { cloud: self, star, light, settings: (diffuse, accuracy), tally: &tally };
        Patch::all(FIRST).collect::<Vec<_>>().into_par_iter().for_each(|patch| follow.begin(patch));
        let mean = |(sum, volume): (&AtomicU64, &AtomicU64), most: f64| {
            let (sum, volume) = (sum.load(Ordering::Relaxed) as f64, volume.load(Ordering::Relaxed) as f64);
            if volume > 0.0 { (most * sum / volume) as f32 } else { 0.0 }
        };
        let of = |(quantity, sums): (&Quantity, &Vec<AtomicU64>)| {
            sums.par_iter().zip(&tally.volume).map(|pair| mean(pair, quantity.most)).collect()
        };
        quantities.iter().zip(&tally.sums).map(of).collect()
    }

    fn high(&self) -> DVec3 {
        self.low + self.voxel * DVec3::from(self.dims.map(|n| n as f64))
    }
}

/// Beams on their way.
struct Follow<'a> {
    cloud: &'a Cloud<'a>,
    star: DVec3,
    light: &'a IonisingLight,
    settings: (Diffuse, &'a Accuracy),
    tally: &'a Tally<'a>,
}

impl Follow<'_> {
    /// Sends a beam from the star, or its parts where it is too wide where it meets the cloud.
    fn begin(&self, patch: Patch) {
        let (low, high) = (self.cloud.low - self.star, self.cloud.high() - self.star);
        let nearest = DVec3::ZERO.clamp(low, high).length();
        let middle = 0.5 * (low + high);
        // What lies beside the sphere around the cloud does not meet it.
        let size = (0.5 * (high - low)).length();
        let beside = if middle.length() > size { (size / middle.length()).asin() } else { std::f64::consts::PI };
        if middle.length() > 0.0 && middle.normalize().dot(patch.direction()).clamp(-1.0, 1.0).acos() > beside + patch.reach() {
            return;
        }
        if nearest > self.widest(patch.solid_angle()) {
            return patch.parts().into_iter().for_each(|part| self.begin(part));
        }
        let (diffuse, accuracy) = self.settings;
        if let Some((enter, _)) = self.clipped(patch.direction()) {
            let beam = Beam::new(self.light, diffuse, accuracy, patch.solid_angle(), enter * PARSEC_CM);
            self.follow(patch, beam);
        }
    }

    /// The distance from the star at which a beam is wider than a voxel \[pc\].
    fn widest(&self, solid_angle: f64) -> f64 {
        self.cloud.voxel.min_element() * (WIDEST / solid_angle).sqrt()
    }

    /// Where a ray from the star enters the cloud and leaves it \[pc\].
    fn clipped(&self, direction: DVec3) -> Option<(f64, f64)> {
        let (a, b) = ((self.cloud.low - self.star) / direction, (self.cloud.high() - self.star) / direction);
        let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
        (far > near).then_some((near, far))
    }

    /// Follows a beam until it leaves the cloud, its light is used up, or it is so wide that its parts go on.
    fn follow(&self, patch: Patch, mut beam: Beam) {
        let direction = patch.direction();
        // A part of a beam may enter later than the whole did.
        let Some((near, far)) = self.clipped(direction) else { return };
        let mut at = (beam.radius_cm / PARSEC_CM).max(near);
        beam.radius_cm = at * PARSEC_CM;
        let (widest, longest) = (self.widest(beam.solid_angle), self.cloud.voxel.length());
        let mut dark = None;
        while at < far * (1.0 - 1e-12) {
            if at > widest && dark.is_none() {
                let whole = patch.solid_angle();
                return patch.parts().into_iter().for_each(|part| self.follow(part, beam.part(part.solid_angle() / whole)));
            }
            let (voxel, exit) = self.voxel(direction, at);
            let exit = exit.min(far);
            let gas = Gas { dust_cm2: self.cloud.dust_cm2, ..Gas::new(f64::from(self.cloud.hydrogen[voxel]), self.cloud.abundances) };
            if dark.is_none() && beam.is_used_up() {
                dark = Some(at);
            }
            if dark.is_some_and(|since| at - since > BEYOND * longest) {
                return;
            }
            if dark.is_none() && gas.hydrogen > 0.0 {
                while beam.radius_cm < exit * PARSEC_CM * (1.0 - 1e-12) && !beam.is_used_up() {
                    let step = beam.step(&gas, exit * PARSEC_CM - beam.radius_cm);
                    self.tally.add(voxel, step.volume(beam.solid_angle), &gas, Some(&step.state));
                }
            }
            // The rest of the way is dark, or empty.
            let thickness_cm = exit * PARSEC_CM - beam.radius_cm;
            if thickness_cm > 0.0 {
                let step = Step { inner_cm: beam.radius_cm, thickness_cm, state: State::neutral(&gas) };
                self.tally.add(voxel, step.volume(beam.solid_angle), &gas, (gas.hydrogen > 0.0).then_some(&step.state));
                beam.radius_cm = exit * PARSEC_CM;
            }
            at = exit;
        }
    }

    /// The voxel at a distance along a ray, and where the ray leaves it \[pc\].
    fn voxel(&self, direction: DVec3, at: f64) -> (usize, f64) {
        let Cloud { dims, low, voxel, .. } = self.cloud;
        // A little farther on, so that a place on a face is behind it; far away from the star that is what rounding leaves.
        let little = (1e-9 * voxel.min_element()).max(4.0 * f64::EPSILON * at);
        let place = (self.star + (at + little) * direction - *low) / *voxel;
        let [x, y, z] = std::array::from_fn(|axis| (place[axis].max(0.0) as usize).min(dims[axis] - 1));
        let sides = [x, y, z].map(|i| i as f64);
        let exit = (0..3).map(|axis| {
            let side = sides[axis] + f64::from(u8::from(direction[axis] > 0.0));
            let plane = low[axis] + side * voxel[axis] - self.star[axis];
            if direction[axis] == 0.0 { f64::INFINITY } else { plane / direction[axis] }
        });
        let exit = exit.fold(f64::INFINITY, f64::min).max(at + little);
        ((z * dims[1] + y) * dims[0] + x, exit)
    }
}
