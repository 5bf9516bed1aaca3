//! Beams of the only star of a cloud on their way, which part as they go outward.
//!
//! Each beam solves the gas on its way, from the star outward, so that one pass is the solution, and shadows have sharp edges.
//! What it finds it leaves in the voxels, weighted by the volume of its steps: where a front runs through a voxel, the
//! voxel has of both sides what there is of them. Thin gas is crossed in blocks of voxels, by beams as wide as these.

use glam::DVec3;
use spectra::constants::SPHERE;

use crate::balance::{Gas, GasState};
use crate::beam::{Beam, shell};
use crate::blocks::Blocks;
use crate::cloud::{PARSEC_CM, Settings};
use crate::lanes::LANES;
use crate::light::IonisingLight;
use crate::packet::Packet;
use crate::patch::Patch;
use crate::rays::{BEYOND, Rays};
use crate::tally::{Seen, Tally};

/// Passes of a packet after which it is asked whether to go on.
const LOOK: u32 = 256;
/// Distance from its face up to which a beam counts as entering a block there \[voxels\].
const AT_FACE: f64 = 0.1;

/// Beams of a star on their way.
pub struct Follow<'a> {
    /// Geometry of the beams, with the cloud that they cross: its voxels, and [`blocks`](Self::blocks) of them.
    pub levels: &'a [Rays<'a>],
    /// Blocks of increasing size.
    pub blocks: &'a [Blocks],
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
    /// Position, entry into the cloud, and exit from it \[pc\].
    at: f64,
    near: f64,
    far: f64,
    /// Distance up to which all of it is in the cloud \[pc\].
    within: f64,
    /// End of its light \[pc\].
    dark: Option<f64>,
    cell: Cell,
    /// Statistics of the cell so far.
    seen: Seen,
}

/// A voxel, or a block of them, that a beam is in.
struct Cell {
    level: usize,
    number: usize,
    /// Distance from the star at which the beam leaves it \[pc\].
    exit: f64,
    gas: Gas,
    /// Its largest density relative to that of the gas \[1\].
    contrast: f64,
}

impl<'a> Follow<'a> {
    /// Follows all beams of some patches, unless it is not to go on; false then.
    pub fn patches(&self, patches: &[Patch], goes_on: &dyn Fn() -> bool) -> bool {
        let Settings { diffuse, accuracy, .. } = self.settings;
        let mut packet = Packet::new(self.light, *diffuse, accuracy, self.levels[0].cloud.gas(0, self.settings));
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
                    && self.ends_step(walk, (&mut packet, lane))
                    && !self.advance(walk, (&mut packet, lane), &mut waiting)
                {
                    *place = None;
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
        let (enter, _) = self.levels[0].clipped(patch.direction())?;
        Some((patch, Beam::new(self.light, &self.settings.accuracy, patch.solid_angle(), enter * PARSEC_CM)))
    }

    /// A beam where it enters the cloud, which a part of one may do later than the whole did.
    fn enter(&self, patch: Patch, mut beam: Beam<'a>) -> Option<Walk<'a>> {
        let direction = patch.direction();
        let (near, far) = self.levels[0].clipped(direction)?;
        // Where the whole has met no gas yet, its part may meet it earlier.
        let at = if beam.is_fresh() { near } else { (beam.radius_cm / PARSEC_CM).max(near) };
        beam.radius_cm = at * PARSEC_CM;
        let (seen, within) = (self.tally.seen(), self.levels[0].leaves_first(patch));
        let cell = Cell { level: 0, number: 0, exit: at, gas: self.levels[0].cloud.gas(0, self.settings), contrast: 1.0 };
        Some(Walk { patch, direction, beam, at, near, far, within, dark: None, cell, seen })
    }

    /// Ends a step that has settled and keeps what it found; false where the beam has begun it anew, shorter.
    fn ends_step(&self, walk: &mut Walk, (packet, lane): (&mut Packet, usize)) -> bool {
        let Cell { level, gas, contrast, .. } = &walk.cell;
        if *level > 0 && walk.beam.withdraws((packet, lane), *contrast, self.levels[*level].cloud.voxel.length() * PARSEC_CM) {
            // The rest of the block is crossed in smaller ones.
            walk.cell.exit = walk.beam.radius_cm / PARSEC_CM;
            return true;
        }
        let Some(step) = walk.beam.end((packet, lane)) else { return false };
        self.tally.see((*level, &mut walk.seen), step.volume(walk.beam.solid_angle), gas, &step.state);
        self.tally.count(step.moved <= self.settings.accuracy.settled);
        true
    }

    /// The cell at a beam's position: the largest block whose gas is expected to be thin, or a voxel.
    fn cell(&self, walk: &Walk) -> Cell {
        let is_lit = walk.dark.is_none() && !walk.beam.is_used_up();
        for level in (1..self.levels.len()).rev().filter(|_| is_lit) {
            let (rays, blocks) = (&self.levels[level], &self.blocks[level - 1]);
            let way = rays.way(walk.direction, walk.at);
            let is_whole = walk.at - way.entry().max(walk.near) <= AT_FACE * self.levels[0].cloud.voxel.min_element();
            let (number, exit) = (way.voxel(), way.exit());
            let Some(contrast) = blocks.contrast(number) else { continue };
            let densest = contrast * f64::from(blocks.hydrogen[number]);
            let exit = exit.min(walk.far);
            let longest = rays.cloud.voxel.length();
            if exit < walk.within && walk.beam.expects_thin(densest, longest * PARSEC_CM, is_whole) {
                return Cell { level, number, exit, gas: blocks.gas(rays.cloud, number, self.settings), contrast };
            }
        }
        let (number, exit) = self.levels[0].voxel(walk.direction, walk.at);
        Cell { level: 0, number, exit: exit.min(walk.far), gas: self.levels[0].cloud.gas(number, self.settings), contrast: 1.0 }
    }

    /// Has a beam begin its next step; false where it has ended: it leaves the cloud, its light is used up, or it is so wide
    /// that its parts go on.
    fn advance(&self, walk: &mut Walk<'a>, (packet, lane): (&mut Packet, usize), waiting: &mut Vec<(Patch, Beam<'a>)>) -> bool {
        loop {
            let end_cm = walk.cell.exit * PARSEC_CM;
            if walk.beam.radius_cm < end_cm * (1.0 - 1e-12) {
                if walk.dark.is_none() && walk.cell.gas.hydrogen > 0.0 && !walk.beam.is_used_up() {
                    walk.beam.begin((packet, lane), &walk.cell.gas, end_cm - walk.beam.radius_cm);
                    return true;
                }
                self.cross_dark(walk, end_cm);
            }
            self.tally.add((walk.cell.level, walk.cell.number), &mut walk.seen);
            walk.at = walk.cell.exit;
            if walk.at >= walk.far * (1.0 - 1e-12) {
                break;
            }
            walk.cell = self.cell(walk);
            if walk.dark.is_none() && walk.at > self.levels[walk.cell.level].widest(walk.beam.solid_angle) {
                let whole = walk.patch.solid_angle();
                waiting.extend(walk.patch.parts().map(|part| (part, walk.beam.part(part.solid_angle() / whole))));
                return false;
            }
            if walk.dark.is_none() && walk.beam.is_used_up() {
                walk.dark = Some(walk.at);
            }
            if walk.dark.is_some_and(|since| walk.at - since > BEYOND * self.levels[0].cloud.voxel.length()) {
                break;
            }
        }
        let part = walk.beam.solid_angle / SPHERE;
        self.tally.cache.add(part * (1.0 - walk.beam.left()).clamp(0.0, 1.0));
        false
    }

    /// The rest of the way through a voxel is dark, or empty.
    fn cross_dark(&self, walk: &mut Walk, end_cm: f64) {
        let (inner_cm, thickness_cm) = (walk.beam.radius_cm, end_cm - walk.beam.radius_cm);
        let volume = shell(walk.beam.solid_angle, inner_cm, thickness_cm);
        let Cell { level, gas, .. } = &walk.cell;
        self.tally.see((*level, &mut walk.seen), volume, gas, &GasState::neutral(gas));
        walk.beam.radius_cm = end_cm;
    }
}
