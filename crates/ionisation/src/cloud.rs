//! A cloud in three dimensions around stars: beams that part as they go outward.
//!
//! Each beam solves the gas on its way, from the star outward, so that of one star one pass is the solution, and shadows
//! have sharp edges. Of several, a beam has the last that is known of the others' light, and answers for that part of the gas
//! which it ionises itself. What it finds it leaves in the voxels, weighted by the volume of its steps: where a
//! front runs through a voxel, the voxel has of both sides what there is of them.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use spectra::constants::{PARSEC, SPHERE};

use crate::atoms::{ELEMENTS, Element};
use crate::balance::{Accuracy, Diffuse, Gas, State};
use crate::beam::{Beam, Step};
use crate::error::IonisationError;
use crate::lanes::LANES;
use crate::light::{ByNode, IonisingLight, NODES};
use crate::packet::Packet;
use crate::patch::Patch;
pub use crate::tally::Quantity;
use crate::tally::{Lit, Seen, Shone, Tally};

/// Centimetres in a parsec.
pub const PARSEC_CM: f64 = 100.0 * PARSEC;
/// The level of patches with which beams begin.
const FIRST: u32 = 3;
/// The largest area of a beam in parts of a voxel's face \[1\].
const WIDEST: f64 = 1.0;
/// How far a beam goes on when its light is used up, so that voxels know how much of them is dark \[voxels\].
const BEYOND: f64 = 3.0;
/// Clouds of several stars are not solved on fewer voxels than this along their shortest edge, before they are on more.
const COARSEST: usize = 12;
/// Changes, in parts of the one that is asked for, from which on quantities are asked for: passes bring it down by more.
const NEAR: f64 = 3.0;
/// Passes of a packet after which it is asked whether to go on.
const LOOK: u32 = 256;
/// Passes that several stars take as a rule.
const EXPECTED: usize = 5;
/// The densest gas that is taken as such \[cm⁻³\].
const DENSEST: f32 = 1e12;

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

/// A star: its place \[pc\], and its light in nodes that all stars have in common ([`IonisingLight::several`]).
#[derive(Debug, Clone, Copy)]
pub struct Star<'a> {
    /// Where it is \[pc\].
    pub place: DVec3,
    /// What ionises of its light.
    pub light: &'a IonisingLight,
}

/// How a cloud is solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Where light of recombinations is absorbed.
    pub diffuse: Diffuse,
    /// How exact beams are.
    pub accuracy: Accuracy,
    /// Where several stars have settled: the part of all ions of hydrogen that a pass moves \[1\].
    pub change: f64,
    /// Passes at most.
    pub passes: usize,
    /// Bytes that may be taken.
    pub memory_limit: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { diffuse: Diffuse::default(), accuracy: Accuracy::FAST, change: 2e-3, passes: 30, memory_limit: 4 << 30 }
    }
}

/// What stars make of a cloud.
#[derive(Debug, Clone)]
pub struct Ionised {
    /// By quantity its mean in each voxel.
    pub quantities: Vec<Vec<f32>>,
    /// The passes that were made.
    pub passes: usize,
    /// What the last of them changed, in parts of all ions of hydrogen \[1\].
    pub change: f64,
    /// By star, the part of its ionising photons that leaves the cloud; one for a star that has none \[1\].
    pub escaped: Vec<f64>,
    /// The steps that beams made in the last pass.
    pub steps: u64,
    /// Of those, in how many the gas did not settle.
    pub unsettled: u64,
}

/// Hears how much of how much work is done, and says whether it is to go on.
pub type Watch<'a> = &'a (dyn Fn(u64, u64) -> bool + Sync);

/// Work that is watched; its units are voxels that one star's beams have gone through.
struct Work<'a> {
    watch: Watch<'a>,
    done: AtomicU64,
    all: u64,
    is_stopped: AtomicBool,
}

impl Work<'_> {
    /// Adds what is done, which is no more than some limit, and says whether the work is to go on.
    fn add(&self, done: u64, limit: u64) -> bool {
        let done = (self.done.fetch_add(done, Ordering::Relaxed) + done).min(limit);
        if !(self.watch)(done, self.all) {
            self.is_stopped.store(true, Ordering::Relaxed);
        }
        self.goes_on()
    }

    fn goes_on(&self) -> bool {
        !self.is_stopped.load(Ordering::Relaxed)
    }
}

/// What passes begin with: the light of each star by voxel and node, nothing where none is known, and the ions of hydrogen.
struct Before {
    light: Vec<Vec<f32>>,
    ions: Vec<f32>,
}

impl Cloud<'_> {
    /// What stars make of the cloud.
    ///
    /// Of one star beams are the solution. Of several each star's beams find the gas under their own light and the last that is
    /// known of the others', until nothing changes any more; what they have first is what they have in a cloud of
    /// half as many voxels along each edge.
    ///
    /// # Errors
    /// Where the cloud or the stars are none that there can be, or take more memory than is allowed, or `watch` has had enough.
    pub fn ionised(&self, stars: &[Star], settings: &Settings, quantities: &[Quantity], watch: Watch) -> Result<Ionised, IonisationError> {
        self.check(stars, settings, quantities.len())?;
        if stars.is_empty() {
            let quantities = quantities.iter().map(|_| vec![0.0; self.hydrogen.len()]).collect();
            return Ok(Ionised { quantities, passes: 0, change: 0.0, escaped: Vec::new(), steps: 0, unsettled: 0 });
        }
        let levels = std::iter::successors(Some(self.dims), |dims| halved(*dims).filter(|_| stars.len() > 1));
        let all = levels.map(|dims| level(dims, stars.len())).sum();
        let work = Work { watch, done: AtomicU64::new(0), all, is_stopped: AtomicBool::new(false) };
        let (ionised, _) = self.solved(stars, settings, quantities, &work)?;
        (work.watch)(all, all);
        Ok(ionised)
    }

    /// That, and what it has come from.
    fn solved(
        &self,
        stars: &[Star],
        settings: &Settings,
        quantities: &[Quantity],
        work: &Work,
    ) -> Result<(Ionised, Before), IonisationError> {
        let cells = self.hydrogen.len();
        let Before { mut light, mut ions } = self.before(stars, settings, work)?;
        let (most, mut change) = (settings.passes.max(1), f64::INFINITY);
        let end = work.done.load(Ordering::Relaxed) + level(self.dims, stars.len());
        let mut pass = 0;
        loop {
            pass += 1;
            // Of one star the first pass is the solution. Of several, quantities are asked for once the passes near their end.
            let is_near = stars.len() == 1 || change <= NEAR * settings.change || pass == most;
            let asked = if is_near { quantities } else { &[] };
            let mut tally = Tally::new(self.hydrogen, (self.voxel * PARSEC_CM).element_product(), asked);
            let mut escaped = vec![1.0; stars.len()];
            for number in 0..stars.len() {
                let lit = (stars.len() > 1).then(|| Lit::new(cells, self.voxel.min_element() * PARSEC_CM, stars[number].light));
                let others: Vec<&[f32]> =
                    light.iter().enumerate().filter(|(i, light)| *i != number && !light.is_empty()).map(|(_, light)| &light[..]).collect();
                let follow =
                    Follow { cloud: self, star: stars[number], settings, tally: &tally, lit: lit.as_ref(), others, stars: stars.len() };
                let mut patches = Vec::new();
                Patch::all(FIRST).for_each(|patch| follow.begin(patch, &mut patches));
                let chunks = patches.len().div_ceil(LANES).max(1);
                patches.par_chunks(LANES).for_each(|patches| {
                    if work.goes_on() && follow.patches(patches, &|| work.add(0, end)) {
                        work.add((cells / chunks) as u64, end);
                    }
                });
                if !work.goes_on() {
                    return Err(IonisationError::Stopped);
                }
                if let Some(lit) = lit {
                    light[number].resize(cells * stars[number].light.energies_ev.len(), 0.0);
                    lit.flux(&mut light[number]);
                }
                escaped[number] = tally.next_star();
            }
            let now = tally.ions();
            let moved = now.iter().zip(ions.iter().chain(std::iter::repeat(&0.0))).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>();
            let all = now.iter().map(|n| f64::from(*n)).sum::<f64>();
            change = if all > 0.0 && stars.len() > 1 { moved / all } else { 0.0 };
            ions = now;
            if is_near && change <= settings.change || pass == most {
                work.done.store(end, Ordering::Relaxed);
                let [steps, unsettled] = tally.steps();
                let ionised = Ionised { quantities: tally.quantities(), passes: pass, change, escaped, steps, unsettled };
                return Ok((ionised, Before { light, ions }));
            }
        }
    }

    /// What is known before the first pass: nothing of one star, of several what they have made of a cloud of half as many
    /// voxels along each edge.
    fn before(&self, stars: &[Star], settings: &Settings, work: &Work) -> Result<Before, IonisationError> {
        let Some(dims) = halved(self.dims).filter(|_| stars.len() > 1) else {
            return Ok(Before { light: vec![Vec::new(); stars.len()], ions: Vec::new() });
        };
        let (_, hydrogen) = block_means(self.dims, self.hydrogen, 2);
        let coarse = Cloud { dims, voxel: 2.0 * self.voxel, hydrogen: &hydrogen, ..self.clone() };
        let settings = Settings { accuracy: Accuracy::COARSE, change: NEAR * settings.change, ..*settings };
        let (_, before) = coarse.solved(stars, &settings, &[], work)?;
        let nodes = stars[0].light.energies_ev.len();
        let finer = |coarse: &Vec<f32>, values: usize| -> Vec<f32> {
            let above = |i: usize| block_of(self.dims, dims, 2, i) * values;
            (0..self.hydrogen.len()).into_par_iter().flat_map_iter(|i| coarse[above(i)..][..values].iter().copied()).collect()
        };
        Ok(Before { light: before.light.iter().map(|light| finer(light, nodes)).collect(), ions: finer(&before.ions, 1) })
    }

    /// Refuses what cannot be solved.
    fn check(&self, stars: &[Star], settings: &Settings, quantities: usize) -> Result<(), IonisationError> {
        let cells = self.dims.iter().try_fold(1usize, |cells, edge| cells.checked_mul(*edge));
        if cells != Some(self.hydrogen.len()) || self.hydrogen.is_empty() {
            return Err(IonisationError::Length { found: self.hydrogen.len(), dims: self.dims });
        }
        if !(self.voxel.is_finite() && self.voxel.min_element() > 0.0 && self.low.is_finite()) {
            return Err(IonisationError::Voxel(self.voxel));
        }
        let [nx, ny, _] = self.dims;
        if let Some(i) = self.hydrogen.iter().position(|n| !(0.0..=DENSEST).contains(n)) {
            return Err(IonisationError::Density { voxel: [i % nx, i / nx % ny, i / (nx * ny)], value: self.hydrogen[i] });
        }
        for (element, value) in Element::ALL.into_iter().zip(self.abundances) {
            let allowed = match element {
                Element::Hydrogen => 1.0..=1.0,
                Element::Helium => 0.0..=10.0,
                _ => 0.0..=0.1,
            };
            if !allowed.contains(&value) {
                return Err(IonisationError::Abundance { element: element.symbol(), value });
            }
        }
        if !(0.0..f64::INFINITY).contains(&self.dust_cm2) {
            return Err(IonisationError::Dust(self.dust_cm2));
        }
        for (number, star) in stars.iter().enumerate() {
            if !star.place.is_finite() {
                return Err(IonisationError::Place { star: number, place: star.place });
            }
            if star.light.energies_ev != stars[0].light.energies_ev {
                return Err(IonisationError::Nodes(number));
            }
        }
        let nodes = stars.first().map_or(0, |star| star.light.energies_ev.len());
        let (cells, bytes) = (self.hydrogen.len(), Self::bytes(self.hydrogen.len(), stars.len(), nodes, quantities));
        if bytes > settings.memory_limit {
            return Err(IonisationError::Memory { stars: stars.len(), cells, bytes, limit: settings.memory_limit });
        }
        Ok(())
    }

    /// The bytes that so many voxels, stars, nodes and quantities take: sums by quantity, and for several stars the light of
    /// each by node and that of one as sums.
    pub fn bytes(cells: usize, stars: usize, nodes: usize, quantities: usize) -> u64 {
        let of_light = if stars > 1 { 4 * stars * nodes + 8 * (nodes + 1) } else { 0 };
        (cells as u64).saturating_mul((32 + 12 * (quantities + 1) + of_light) as u64)
    }

    fn high(&self) -> DVec3 {
        self.low + self.voxel * DVec3::from(self.dims.map(|n| n as f64))
    }
}

/// Half as many voxels along each edge, where there are enough.
fn halved(dims: [usize; 3]) -> Option<[usize; 3]> {
    let dims = dims.map(|n| n.div_ceil(2));
    dims.iter().all(|n| *n >= COARSEST).then_some(dims)
}

/// Means over blocks of so many voxels along each edge, and how many blocks there are; beyond the last voxel of an edge there
/// is nothing.
pub fn block_means(dims: [usize; 3], values: &[f32], block: usize) -> ([usize; 3], Vec<f32>) {
    let blocks = dims.map(|n| n.div_ceil(block));
    let (mut means, part) = (vec![0.0; blocks.iter().product()], 1.0 / block.pow(3) as f32);
    values.iter().enumerate().for_each(|(i, value)| means[block_of(dims, blocks, block, i)] += part * value);
    (blocks, means)
}

/// The block that a voxel is in.
fn block_of([nx, ny, _]: [usize; 3], blocks: [usize; 3], block: usize, voxel: usize) -> usize {
    let [x, y, z] = [voxel % nx, voxel / nx % ny, voxel / (nx * ny)].map(|place| place / block);
    (z * blocks[1] + y) * blocks[0] + x
}

/// The work that so many voxels and stars are as a rule.
fn level(dims: [usize; 3], stars: usize) -> u64 {
    (dims.iter().product::<usize>() * stars * if stars > 1 { EXPECTED } else { 1 }) as u64
}

/// Beams of a star on their way.
struct Follow<'a> {
    cloud: &'a Cloud<'a>,
    star: Star<'a>,
    settings: &'a Settings,
    tally: &'a Tally<'a>,
    /// What its light in each voxel is summed up in, and that of the other stars.
    lit: Option<&'a Lit>,
    others: Vec<&'a [f32]>,
    /// Stars in all.
    stars: usize,
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
    /// Follows all beams of some patches, unless it is not to go on; false then.
    fn patches(&self, patches: &[Patch], goes_on: &dyn Fn() -> bool) -> bool {
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
