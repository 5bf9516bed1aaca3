//! Beams of the only star of a cloud on their way, which part as they go outward.
//!
//! Each beam solves the gas on its way, from the star outward, so that one pass is the solution, and shadows have sharp edges.
//! What it finds it leaves in the voxels, weighted by the volume of its steps: where a front runs through a voxel, the
//! voxel has of both sides what there is of them.

use glam::DVec3;
use spectra::constants::SPHERE;

use crate::balance::{Gas, GasState};
use crate::beam::{Beam, BeamStep, shell};
use crate::cloud::{PARSEC_CM, Settings};
use crate::lanes::LANES;
use crate::light::IonisingLight;
use crate::packet::Packet;
use crate::patch::Patch;
use crate::rays::{BEYOND, Rays};
use crate::tally::{Seen, Tally};

/// Passes of a packet after which it is asked whether to go on.
const LOOK: u32 = 256;

/// Beams of a star on their way.
pub struct Follow<'a> {
    /// Geometry of the beams, with the cloud that they cross.
    pub rays: Rays<'a>,
    /// The light that they bring.
    pub light: &'a IonisingLight,
    /// How exact they are.
    pub settings: &'a Settings,
    /// Accumulator of their results.
    pub tally: &'a Tally<'a>,
}

/// A beam on its way.
struct Walk<'a> {
    patch: Patch,
    direction: DVec3,
    beam: Beam<'a>,
    /// Position, and exit from the cloud \[pc\].
    at: f64,
    far: f64,
    /// End of its light \[pc\].
    dark: Option<f64>,
    /// The voxel that it is in, where it leaves it \[pc\], and the gas there.
    voxel: usize,
    exit: f64,
    gas: Gas,
    /// Statistics of the voxel so far.
    seen: Seen,
}

impl<'a> Follow<'a> {
    /// Follows all beams of some patches, unless it is not to go on; false then.
    pub fn patches(&self, patches: &[Patch], goes_on: &dyn Fn() -> bool) -> bool {
        let Settings { diffuse, accuracy, .. } = self.settings;
        let mut packet = Packet::new(self.light, *diffuse, accuracy, self.rays.cloud.gas(0, self.settings));
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
                    self.see(walk, &step);
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

    /// The beam of a patch where it enters the cloud.
    fn sent(&self, patch: Patch) -> Option<(Patch, Beam<'a>)> {
        let (enter, _) = self.rays.clipped(patch.direction())?;
        Some((patch, Beam::new(self.light, &self.settings.accuracy, patch.solid_angle(), enter * PARSEC_CM)))
    }

    /// A beam where it enters the cloud, which a part of one may do later than the whole did.
    fn enter(&self, patch: Patch, mut beam: Beam<'a>) -> Option<Walk<'a>> {
        let direction = patch.direction();
        let (near, far) = self.rays.clipped(direction)?;
        let at = (beam.radius_cm / PARSEC_CM).max(near);
        beam.radius_cm = at * PARSEC_CM;
        let seen = self.tally.seen();
        Some(Walk { patch, direction, beam, at, far, dark: None, voxel: 0, exit: at, gas: self.rays.cloud.gas(0, self.settings), seen })
    }

    /// Keeps what a step found in its voxel.
    fn see(&self, walk: &mut Walk, step: &BeamStep) {
        self.tally.see(&mut walk.seen, step.volume(walk.beam.solid_angle), &walk.gas, &step.state);
    }

    /// Has a beam begin its next step; false where it has ended: it leaves the cloud, its light is used up, or it is so wide
    /// that its parts go on.
    fn advance(&self, walk: &mut Walk<'a>, (packet, lane): (&mut Packet, usize), waiting: &mut Vec<(Patch, Beam<'a>)>) -> bool {
        let (widest, longest) = (self.rays.widest(walk.beam.solid_angle), self.rays.cloud.voxel.length());
        loop {
            let end_cm = walk.exit * PARSEC_CM;
            if walk.beam.radius_cm < end_cm * (1.0 - 1e-12) {
                if walk.dark.is_none() && walk.gas.hydrogen > 0.0 && !walk.beam.is_used_up() {
                    walk.beam.begin((packet, lane), walk.gas.hydrogen, end_cm - walk.beam.radius_cm);
                    return true;
                }
                self.cross_dark(walk, end_cm);
            }
            self.tally.add(walk.voxel, &mut walk.seen);
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
            let (voxel, exit) = self.rays.voxel(walk.direction, walk.at);
            (walk.voxel, walk.exit, walk.gas) = (voxel, exit.min(walk.far), self.rays.cloud.gas(voxel, self.settings));
        }
        let part = walk.beam.solid_angle / SPHERE;
        self.tally.cache.add(part * (1.0 - walk.beam.left()).clamp(0.0, 1.0));
        false
    }

    /// The rest of the way through a voxel is dark, or empty.
    fn cross_dark(&self, walk: &mut Walk, end_cm: f64) {
        let (inner_cm, thickness_cm) = (walk.beam.radius_cm, end_cm - walk.beam.radius_cm);
        let volume = shell(walk.beam.solid_angle, inner_cm, thickness_cm);
        self.tally.see(&mut walk.seen, volume, &walk.gas, &GasState::neutral(&walk.gas));
        walk.beam.radius_cm = end_cm;
    }
}
