//! A cloud in three dimensions around stars: beams that part as they go outward.
//!
//! Each beam solves the gas on its way, from the star outward, so that of one star one pass is the solution, and shadows
//! have sharp edges. Of several, a beam has the light of the others as it was in the pass before, and answers for that part
//! of the gas which it ionises itself. What it finds it leaves in the voxels, weighted by the volume of its steps: where a
//! front runs through a voxel, the voxel has of both sides what there is of them.

use glam::DVec3;
use rayon::prelude::*;
use spectra::constants::{PARSEC, SPHERE};

use crate::atoms::{ELEMENTS, Element};
use crate::balance::{Accuracy, Diffuse, Gas, State};
use crate::beam::{Beam, Step};
use crate::error::IonisationError;
use crate::light::{ByNode, IonisingLight, NODES};
use crate::patch::Patch;
pub use crate::tally::Quantity;
use crate::tally::{Lit, Tally};

/// Centimetres in a parsec.
const PARSEC_CM: f64 = 100.0 * PARSEC;
/// The level of patches with which beams begin.
const FIRST: u32 = 3;
/// The largest area of a beam in parts of a voxel's face \[1\].
const WIDEST: f64 = 1.0;
/// How far a beam goes on when its light is used up, so that voxels know how much of them is dark \[voxels\].
const BEYOND: f64 = 3.0;
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
        Self { diffuse: Diffuse::default(), accuracy: Accuracy::FAST, change: 1e-3, passes: 30, memory_limit: 4 << 30 }
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

impl Cloud<'_> {
    /// What stars make of the cloud.
    ///
    /// Of one star beams are the solution. Of several each star's beams find the gas under their own light and what the
    /// others had in the pass before, until nothing changes any more.
    ///
    /// # Errors
    /// Where the cloud or the stars are none that there can be, or take more memory than is allowed.
    pub fn ionised(&self, stars: &[Star], settings: &Settings, quantities: &[Quantity]) -> Result<Ionised, IonisationError> {
        self.check(stars, settings, quantities.len())?;
        let cells = self.hydrogen.len();
        let mut light: Vec<Vec<f32>> = vec![Vec::new(); stars.len()];
        let mut ions: Vec<f32> = Vec::new();
        let mut ionised = Ionised {
            quantities: quantities.iter().map(|_| vec![0.0; cells]).collect(),
            passes: 0,
            change: 0.0,
            escaped: vec![1.0; stars.len()],
            steps: 0,
            unsettled: 0,
        };
        if stars.is_empty() {
            return Ok(ionised);
        }
        let most = settings.passes.max(1);
        for pass in 1..=most {
            let mut tally = Tally::new(self.hydrogen, (self.voxel * PARSEC_CM).element_product(), quantities);
            for number in 0..stars.len() {
                let lit = (stars.len() > 1).then(|| Lit::new(cells, self.voxel.min_element() * PARSEC_CM, stars[number].light));
                let others: Vec<&[f32]> =
                    light.iter().enumerate().filter(|(i, light)| *i != number && !light.is_empty()).map(|(_, light)| &light[..]).collect();
                let follow =
                    Follow { cloud: self, star: stars[number], settings, tally: &tally, lit: lit.as_ref(), others, stars: stars.len() };
                Patch::all(FIRST).collect::<Vec<_>>().into_par_iter().for_each(|patch| follow.begin(patch));
                if let Some(lit) = lit {
                    light[number] = lit.flux();
                }
                ionised.escaped[number] = tally.next_star();
            }
            let now = tally.ions();
            // Of one star the first pass is the solution.
            let moved = now.iter().zip(ions.iter().chain(std::iter::repeat(&0.0))).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>();
            let all = now.iter().map(|n| f64::from(*n)).sum::<f64>();
            (ionised.passes, ionised.change, ions) = (pass, if all > 0.0 && stars.len() > 1 { moved / all } else { 0.0 }, now);
            if ionised.change <= settings.change || pass == most {
                ionised.quantities = tally.quantities();
                [ionised.steps, ionised.unsettled] = tally.steps();
                break;
            }
        }
        Ok(ionised)
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

impl Follow<'_> {
    /// Sends a beam from the star, or its parts where it is too wide where it meets the cloud.
    fn begin(&self, patch: Patch) {
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
            return patch.parts().into_iter().for_each(|part| self.begin(part));
        }
        let Settings { diffuse, accuracy, .. } = self.settings;
        if let Some((enter, _)) = self.clipped(patch.direction()) {
            let beam = Beam::new(self.star.light, *diffuse, accuracy, patch.solid_angle(), enter * PARSEC_CM);
            self.follow(patch, beam);
        }
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
                break;
            }
            let background = self.background(voxel);
            if dark.is_none() && gas.hydrogen > 0.0 {
                while beam.radius_cm < exit * PARSEC_CM * (1.0 - 1e-12) && !beam.is_used_up() {
                    let step = beam.step(&gas, &background, exit * PARSEC_CM - beam.radius_cm);
                    let volume = step.volume(beam.solid_angle);
                    self.tally.add(voxel, (volume, step.share), &gas, &step.state);
                    self.tally.count(step.moved <= self.settings.accuracy.settled);
                    self.lit.iter().for_each(|lit| lit.add(voxel, volume / self.tally.voxel_volume, &step.light));
                }
            }
            // The rest of the way is dark, or empty: dark for all stars where no other shines.
            let thickness_cm = exit * PARSEC_CM - beam.radius_cm;
            if thickness_cm > 0.0 {
                let light = [0.0; NODES];
                let step = Step { inner_cm: beam.radius_cm, thickness_cm, state: State::neutral(&gas), light, share: 0.0, moved: 0.0 };
                let is_lit = gas.hydrogen <= 0.0 || self.star.light.ionising_of(&background) > 0.0;
                let volume = step.volume(beam.solid_angle);
                self.tally.add(voxel, (volume, if is_lit { 0.0 } else { 1.0 / self.stars as f64 }), &gas, &step.state);
                if gas.hydrogen > 0.0 {
                    self.lit.iter().for_each(|lit| lit.add(voxel, volume / self.tally.voxel_volume, &light));
                }
                beam.radius_cm = exit * PARSEC_CM;
            }
            at = exit;
        }
        let part = beam.solid_angle / SPHERE;
        self.tally.keep(part * (1.0 - beam.left()).clamp(0.0, 1.0));
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
