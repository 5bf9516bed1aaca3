//! Passes of all stars' beams through a cloud, until nothing changes any more.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use crate::balance::Accuracy;
use crate::blocks::Blocks;
use crate::cloud::{Cloud, Ionised, Quantity, Settings, Star, Watch, block_means, block_of};
use crate::error::IonisationError;
use crate::follow::Follow;
use crate::known::{Known, dark};
use crate::lit::{BEHIND, Lit};
use crate::processor::{Processor, Tracers};
use crate::rays::Rays;
use crate::spread::spread;
use crate::tally::Tally;
use crate::tracer::{Light, RayTracer, Task};
use crate::voxel::Voxel;

/// Voxels along the edges of blocks in which one star's beams cross thin gas.
const BLOCKS: [usize; 2] = [2, 4];
/// Clouds of several stars are not solved on fewer voxels than this along their shortest edge, before they are on more.
const COARSEST: usize = 12;
/// Changes, in parts of the one that is asked for, from which on the gas is solved as exactly as it is asked for: passes bring it
/// down to less than half of it.
const NEAR: f64 = 2.2;
/// The change with which what they have first has settled, in parts of the one that is asked for.
const FAR: f64 = 5.0;
/// Passes that several stars take as a rule.
const EXPECTED: usize = 4;

/// Work that is watched; its units are voxels that one star's beams have gone through.
struct StarPasses<'a> {
    watch: Watch<'a>,
    tracer: Option<&'a dyn RayTracer>,
    done: AtomicU64,
    all: u64,
    is_stopped: AtomicBool,
}

impl StarPasses<'_> {
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

/// State before a pass: light, and the ions of hydrogen \[cm⁻³\].
struct Before {
    light: Light,
    ions: Vec<f32>,
}

impl Cloud<'_> {
    /// Ionised state of the cloud.
    ///
    /// Of one star beams are the solution. Of several, light goes through what is known of the gas, and gas is solved under the light
    /// of all stars, in turn, until nothing changes any more; what they have first is what they have in a cloud of half
    /// as many voxels along each edge.
    ///
    /// # Errors
    /// If the cloud or the stars are none that there can be, or take more memory than is allowed, or `watch` has had enough.
    pub fn ionised(&self, stars: &[Star], settings: &Settings, quantities: &[Quantity], watch: Watch) -> Result<Ionised, IonisationError> {
        self.ionised_by(None, stars, settings, quantities, watch)
    }

    /// Variant in which a device may have the light of several stars go through the gas.
    ///
    /// # Errors
    /// Errors of [`ionised`](Self::ionised).
    pub fn ionised_by(
        &self,
        tracer: Option<&dyn RayTracer>,
        stars: &[Star],
        settings: &Settings,
        quantities: &[Quantity],
        watch: Watch,
    ) -> Result<Ionised, IonisationError> {
        self.check(stars, settings, quantities.len())?;
        let levels = std::iter::successors(Some(self.dims), |dims| halved(*dims).filter(|_| stars.len() > 1));
        let all = levels.map(|dims| level(dims, stars.len())).sum();
        let work = StarPasses { watch, tracer, done: AtomicU64::new(0), all, is_stopped: AtomicBool::new(false) };
        let ionised = match stars {
            [] => {
                let quantities = quantities.iter().map(|_| vec![0.0; self.hydrogen.len()]).collect();
                return Ok(Ionised { quantities, by: Processor.name(), ..Ionised::default() });
            }
            [star] => self.of_one(star, settings, quantities, &work)?,
            _ => self.of_several(stars, settings, quantities, &work)?.0,
        };
        (work.watch)(all, all);
        Ok(ionised)
    }

    /// The bytes that a given number of voxels, stars, nodes and quantities take at most: sums by quantity of voxels and blocks; for several stars what is known of each
    /// voxel before a pass and behind it, the light of one star as sums, that of all, and Γ by that of each.
    pub fn bytes(cells: usize, stars: usize, nodes: usize, quantities: usize) -> u64 {
        let of_several = 2 * size_of::<Voxel>() + Lit::bytes(nodes) + 4 * (nodes + BEHIND + stars + 3) + 8 * quantities;
        let bytes = if stars > 1 { of_several } else { 16 * (quantities + 1) };
        (cells as u64).saturating_mul(bytes as u64)
    }

    /// Result with one star.
    fn of_one(&self, star: &Star, settings: &Settings, quantities: &[Quantity], work: &StarPasses) -> Result<Ionised, IonisationError> {
        let blocks = BLOCKS.map(|edge| Blocks::new(self, edge));
        let levels: Vec<Cloud> = std::iter::once(self.clone()).chain(blocks.iter().map(|blocks| blocks.cloud(self))).collect();
        let rays: Vec<Rays> = levels.iter().map(|cloud| Rays { cloud, place: star.place }).collect();
        let tally = Tally::new(&levels, quantities);
        let follow = Follow { levels: &rays, blocks: &blocks, light: star.light, settings, tally: &tally };
        let listener = |done: u64| work.add(done, work.all);
        let patches = rays[0].sent_out_in_blocks(blocks.last().map_or(1, |blocks| blocks.edge));
        if !rays[0].in_parts(&patches, &listener, |patches| follow.patches(patches, &|| listener(0))) {
            return Err(IonisationError::Stopped);
        }
        let [steps, unsettled] = tally.steps();
        let escaped = vec![tally.cache.escaped()];
        let quantities = spread(self, &blocks, &tally);
        Ok(Ionised { quantities, passes: 1, change: 0.0, escaped, steps, unsettled, by: Processor.name() })
    }

    /// Result with several stars, and their light.
    fn of_several(
        &self,
        stars: &[Star],
        settings: &Settings,
        quantities: &[Quantity],
        work: &StarPasses,
    ) -> Result<(Ionised, Before), IonisationError> {
        let kind = stars[0].light;
        let task = Task { cloud: self, stars, used_up: settings.accuracy.used_up, dark: dark(self, settings, kind) };
        let before = self.before(stars, settings, work)?;
        let end = work.done.load(Ordering::Relaxed) + level(self.dims, stars.len());
        let goes_on = || work.add(0, end);
        // While much is still to change, gas needs not be solved as exactly.
        let far = Settings { accuracy: Accuracy::COARSE, ..*settings };
        let mut known = before.as_ref().map(|before| Known::new((self, &far), kind, &before.light.flux, &[], &goes_on));
        let nothing = || Before { light: Light::none(&task), ions: vec![0.0; self.hydrogen.len()] };
        let Before { mut light, mut ions } = before.unwrap_or_else(nothing);
        let mut tracers = Tracers::new(work.tracer, task);
        let (most, mut change) = (settings.passes.max(2), f64::INFINITY);
        for pass in 1.. {
            let is_near = change <= NEAR * settings.change || pass == most;
            let voxels = known.as_ref().map(|known| &known.voxels[..]);
            let escaped = tracers.next(voxels, &mut light, &|done| work.add(done, end)).map_err(|_| IonisationError::Stopped)?;
            let (asked, exact) = if is_near { (quantities, settings) } else { (&[][..], &far) };
            let mut next = Known::new((self, exact), kind, &light.flux, asked, &goes_on);
            if !work.goes_on() {
                return Err(IonisationError::Stopped);
            }
            let moved = next.ions.iter().zip(ions.iter()).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>();
            let all = next.ions.iter().map(|n| f64::from(*n)).sum::<f64>();
            change = if all == 0.0 { 0.0 } else { moved / all };
            if change.is_nan() {
                change = f64::INFINITY;
            }
            ions = std::mem::take(&mut next.ions);
            if is_near && change <= settings.change || pass == most {
                work.done.store(end, Ordering::Relaxed);
                let [steps, unsettled] = next.steps;
                let ionised = Ionised { quantities: next.quantities, passes: pass, change, escaped, steps, unsettled, by: tracers.by };
                return Ok((ionised, Before { light, ions }));
            }
            next.quantities = Vec::new();
            known = Some(next);
        }
        unreachable!("passes end")
    }

    /// State before the first pass: what the stars have made of a cloud of half as many voxels along each edge, where
    /// there are enough.
    fn before(&self, stars: &[Star], settings: &Settings, work: &StarPasses) -> Result<Option<Before>, IonisationError> {
        let Some(dims) = halved(self.dims) else { return Ok(None) };
        let (_, hydrogen) = block_means(self.dims, self.hydrogen, 2);
        let coarse = Cloud { dims, voxel: 2.0 * self.voxel, hydrogen: &hydrogen, ..self.clone() };
        let settings = Settings { accuracy: Accuracy::COARSE, change: FAR * settings.change, ..*settings };
        let (_, before) = coarse.of_several(stars, &settings, &[], work)?;
        let finer = |coarse: &Vec<f32>, values: usize| -> Vec<f32> {
            let above = |i: usize| block_of(self.dims, dims, 2, i) * values;
            (0..self.hydrogen.len()).into_par_iter().flat_map_iter(|i| coarse[above(i)..][..values].iter().copied()).collect()
        };
        let flux = finer(&before.light.flux, stars[0].light.energies_ev.len() + BEHIND);
        let rates = before.light.rates.iter().map(|rates| finer(rates, 1)).collect();
        Ok(Some(Before { light: Light { flux, rates }, ions: finer(&before.ions, 1) }))
    }
}

/// Half as many voxels along each edge, where there are enough.
fn halved(dims: [usize; 3]) -> Option<[usize; 3]> {
    let dims = dims.map(|n| n.div_ceil(2));
    dims.iter().all(|n| *n >= COARSEST).then_some(dims)
}

/// Usual work for a number of voxels and stars.
fn level(dims: [usize; 3], stars: usize) -> u64 {
    (dims.iter().product::<usize>() * stars * if stars > 1 { EXPECTED } else { 1 }) as u64
}
