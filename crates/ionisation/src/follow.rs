//! Beams of a star on their way through a cloud, which part as they go outward.
//!
//! Each beam solves the gas on its way, from the star outward, so that of one star one pass is the solution, and shadows
//! have sharp edges. Of several, a beam has the last that is known of the others' light, and answers for that part of the gas
//! which it ionises itself. What it finds it leaves in the voxels, weighted by the volume of its steps: where a
//! front runs through a voxel, the voxel has of both sides what there is of them.

use glam::DVec3;
use spectra::constants::SPHERE;

use crate::balance::{Gas, State};
use crate::beam::{Beam, Step};
use crate::cloud::{Cloud, PARSEC_CM, Settings, Star};
use crate::lanes::LANES;
use crate::light::{ByNode, NODES};
use crate::packet::Packet;
use crate::patch::Patch;
use crate::tally::{Lit, Seen, Shone, Tally};

/// The level of patches with which beams begin.
const FIRST: u32 = 3;
/// The largest area of a beam in parts of a voxel's face \[1\].
const WIDEST: f64 = 1.0;
/// How far a beam goes on when its light is used up, so that voxels know how much of them is dark \[voxels\].
const BEYOND: f64 = 3.0;
/// Passes of a packet after which it is asked whether to go on.
const LOOK: u32 = 256;
/// Beams of a star on their way.
pub struct Follow<'a> {
    /// What they go through.
    pub cloud: &'a Cloud<'a>,
    /// Where they come from.
    pub star: Star<'a>,
    /// How exact they are.
    pub settings: &'a Settings,
    /// What they find is summed up in.
    pub tally: &'a Tally<'a>,
    /// What the star's light in each voxel is summed up in, and that of the other stars.
    pub lit: Option<&'a Lit>,
    /// By star its flux by voxel and node \[s⁻¹ cm⁻²\].
    pub others: Vec<&'a [f32]>,
    /// Stars in all.
    pub stars: usize,
}

/// A beam on its way.
struct Walk<'a> {
    patch: Patch,
    direction: DVec3,
    beam: Beam<'a>,
    /// Where it is, and where it leaves the cloud \[pc\].
    at: f64,
    far: f64,
    /// Where its light was used up \[pc\].
    dark: Option<f64>,
    /// The voxel that it is in, where it leaves it \[pc\], and the gas there.
    voxel: usize,
    exit: f64,
    gas: Gas,
    /// The light of other stars there, by node \[s⁻¹ cm⁻²\].
    background: ByNode,
    /// What it has seen and lit of the voxel so far.
    seen: Seen,
    shone: Shone,
}

impl<'a> Follow<'a> {
    /// The patches of all beams that the star sends to the cloud.
    pub fn sent_out(&self) -> Vec<Patch> {
        let mut patches = Vec::new();
        Patch::all(FIRST).for_each(|patch| self.begin(patch, &mut patches));
        patches
    }

    /// Follows all beams of some patches, unless it is not to go on; false then.
    pub fn patches(&self, patches: &[Patch], goes_on: &dyn Fn() -> bool) -> bool {
        let Settings { diffuse, accuracy, .. } = self.settings;
        let mut packet = Packet::new(self.star.light, *diffuse, accuracy, self.gas(0));
        let mut waiting: Vec<(Patch, Beam)> = Vec::new();
        let mut patches = patches.iter();
        let mut walks: [Option<Walk>; LANES] = [const { None }; LANES];
        for pass in 1u32.. {
            if pass.is_multiple_of(LOOK) && !goes_on() {
                return false;
            }
            for (lane, place) in walks.iter_mut().enumerate() {
                if let Some(walk) = place
                    && packet.has_settled(lane)
                    && let Some(step) = walk.beam.end((&mut packet, lane))
                {
                    self.see(walk, &step, step.share);
                    self.tally.count(step.moved <= self.settings.accuracy.settled);
                    if !self.advance(walk, (&mut packet, lane), &mut waiting) {
                        *place = None;
                    }
                }
                while place.is_none() {
                    let next = waiting.pop().or_else(|| patches.next().and_then(|patch| self.sent(*patch)));
                    let Some((patch, beam)) = next else { break };
                    packet.forget(lane);
                    *place = self.enter(patch, beam);
                    if place.as_mut().is_some_and(|walk| !self.advance(walk, (&mut packet, lane), &mut waiting)) {
                        *place = None;
                    }
                }
            }
            if walks.iter().all(Option::is_none) {
                break;
            }
            packet.pass();
        }
        true
    }

    /// The patches of beams that the star sends to the cloud: a patch, or its parts where it is too wide where it meets the cloud.
    fn begin(&self, patch: Patch, patches: &mut Vec<Patch>) {
        let (low, high) = (self.cloud.low - self.star.place, self.cloud.high() - self.star.place);
        let nearest = DVec3::ZERO.clamp(low, high).length();
        let middle = 0.5 * (low + high);
        // What lies beside the sphere around the cloud does not meet it.
        let size = (0.5 * (high - low)).length();
        let beside = if middle.length() > size { (size / middle.length()).asin() } else { std::f64::consts::PI };
        if middle.length() > 0.0 && middle.normalize().dot(patch.direction()).clamp(-1.0, 1.0).acos() > beside + patch.reach() {
            return;
        }
        if nearest > self.widest(patch.solid_angle()) {
            return patch.parts().into_iter().for_each(|part| self.begin(part, patches));
        }
        if self.clipped(patch.direction()).is_some() {
            patches.push(patch);
        }
    }

    /// The beam of a patch where it enters the cloud.
    fn sent(&self, patch: Patch) -> Option<(Patch, Beam<'a>)> {
        let (enter, _) = self.clipped(patch.direction())?;
        Some((patch, Beam::new(self.star.light, &self.settings.accuracy, patch.solid_angle(), enter * PARSEC_CM)))
    }

    /// The distance from the star at which a beam is wider than a voxel \[pc\].
    fn widest(&self, solid_angle: f64) -> f64 {
        self.cloud.voxel.min_element() * (WIDEST / solid_angle).sqrt()
    }

    /// Where a ray from the star enters the cloud and leaves it \[pc\].
    fn clipped(&self, direction: DVec3) -> Option<(f64, f64)> {
        let (a, b) = ((self.cloud.low - self.star.place) / direction, (self.cloud.high() - self.star.place) / direction);
        let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
        (far > near).then_some((near, far))
    }

    /// The gas of a voxel.
    fn gas(&self, voxel: usize) -> Gas {
        Gas { dust_cm2: self.cloud.dust_cm2, ..Gas::new(f64::from(self.cloud.hydrogen[voxel]), self.cloud.abundances) }
    }

    /// A beam where it enters the cloud, which a part of one may do later than the whole did.
    fn enter(&self, patch: Patch, mut beam: Beam<'a>) -> Option<Walk<'a>> {
        let direction = patch.direction();
        let (near, far) = self.clipped(direction)?;
        let at = (beam.radius_cm / PARSEC_CM).max(near);
        beam.radius_cm = at * PARSEC_CM;
        let (seen, shone) = (self.tally.seen(), Shone::default());
        let background = [0.0; NODES];
        Some(Walk { patch, direction, beam, at, far, dark: None, voxel: 0, exit: at, gas: self.gas(0), background, seen, shone })
    }

    /// Keeps what a step found in its voxel, of which the beam is to answer for a share.
    fn see(&self, walk: &mut Walk, step: &Step, share: f64) {
        let volume = step.volume(walk.beam.solid_angle);
        self.tally.see(&mut walk.seen, (volume, share), &walk.gas, &step.state);
        if let Some(lit) = self.lit.filter(|_| walk.gas.hydrogen > 0.0) {
            lit.light(&mut walk.shone, volume / self.tally.voxel_volume, &step.light);
        }
    }

    /// Has a beam begin its next step; false where it has ended: it leaves the cloud, its light is used up, or it is so wide
    /// that its parts go on.
    fn advance(&self, walk: &mut Walk<'a>, (packet, lane): (&mut Packet, usize), waiting: &mut Vec<(Patch, Beam<'a>)>) -> bool {
        let (widest, longest) = (self.widest(walk.beam.solid_angle), self.cloud.voxel.length());
        loop {
            let end_cm = walk.exit * PARSEC_CM;
            if walk.beam.radius_cm < end_cm * (1.0 - 1e-12) {
                if walk.dark.is_none() && walk.gas.hydrogen > 0.0 && !walk.beam.is_used_up() {
                    let background = self.star.light.ionising_of(&walk.background);
                    walk.beam.begin((packet, lane), walk.gas.hydrogen, background, end_cm - walk.beam.radius_cm);
                    return true;
                }
                self.cross_dark(walk, end_cm);
            }
            self.tally.add(walk.voxel, &mut walk.seen);
            self.lit.iter().for_each(|lit| lit.add(walk.voxel, &mut walk.shone));
            walk.at = walk.exit;
            if walk.at >= walk.far * (1.0 - 1e-12) {
                break;
            }
            if walk.at > widest && walk.dark.is_none() {
                let whole = walk.patch.solid_angle();
                waiting.extend(walk.patch.parts().map(|part| (part, walk.beam.part(part.solid_angle() / whole))));
                return false;
            }
            if walk.dark.is_none() && walk.beam.is_used_up() {
                walk.dark = Some(walk.at);
            }
            if walk.dark.is_some_and(|since| walk.at - since > BEYOND * longest) {
                break;
            }
            let (voxel, exit) = self.voxel(walk.direction, walk.at);
            (walk.voxel, walk.exit, walk.gas) = (voxel, exit.min(walk.far), self.gas(voxel));
            if !self.others.is_empty() {
                walk.background = self.background(voxel);
                packet.set_background(lane, &walk.background);
            }
        }
        let part = walk.beam.solid_angle / SPHERE;
        self.tally.keep(part * (1.0 - walk.beam.left()).clamp(0.0, 1.0));
        false
    }

    /// The rest of the way through a voxel is dark, or empty: dark for all stars where no other shines.
    fn cross_dark(&self, walk: &mut Walk, end_cm: f64) {
        let (light, inner_cm) = ([0.0; NODES], walk.beam.radius_cm);
        let state = State::neutral(&walk.gas);
        let step = Step { inner_cm, thickness_cm: end_cm - inner_cm, state, light, share: 0.0, moved: 0.0 };
        let is_lit = walk.gas.hydrogen <= 0.0 || self.star.light.ionising_of(&walk.background) > 0.0;
        self.see(walk, &step, if is_lit { 0.0 } else { 1.0 / self.stars as f64 });
        walk.beam.radius_cm = end_cm;
    }

    /// The light of the other stars in a voxel, by node \[s⁻¹ cm⁻²\].
    fn background(&self, voxel: usize) -> ByNode {
        let (mut sum, nodes) = ([0.0; NODES], self.star.light.energies_ev.len());
        for light in &self.others {
            sum.iter_mut().zip(&light[voxel * nodes..][..nodes]).for_each(|(sum, flux)| *sum += f64::from(*flux));
        }
        sum
    }

    /// The voxel at a distance along a ray, and where the ray leaves it \[pc\].
    fn voxel(&self, direction: DVec3, at: f64) -> (usize, f64) {
        let Cloud { dims, low, voxel, .. } = self.cloud;
        // A little farther on, so that a place on a face is behind it; far away from the star that is what rounding leaves.
        let little = (1e-9 * voxel.min_element()).max(4.0 * f64::EPSILON * at);
        let place = (self.star.place + (at + little) * direction - *low) / *voxel;
        let [x, y, z] = std::array::from_fn(|axis| (place[axis].max(0.0) as usize).min(dims[axis] - 1));
        let sides = [x, y, z].map(|i| i as f64);
        let exit = (0..3).map(|axis| {
            let side = sides[axis] + f64::from(u8::from(direction[axis] > 0.0));
            let plane = low[axis] + side * voxel[axis] - self.star.place[axis];
            if direction[axis] == 0.0 { f64::INFINITY } else { plane / direction[axis] }
        });
        let exit = exit.fold(f64::INFINITY, f64::min).max(at + little);
        ((z * dims[1] + y) * dims[0] + x, exit)
    }
}
