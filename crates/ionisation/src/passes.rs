//! Passes of all stars' beams through a cloud, until nothing changes any more.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use crate::balance::Accuracy;
use crate::cloud::{Cloud, Ionised, PARSEC_CM, Quantity, Settings, Star, Watch, block_means, block_of};
use crate::error::IonisationError;
use crate::follow::Follow;
use crate::lanes::LANES;
use crate::tally::{Lit, Tally};

/// Clouds of several stars are not solved on fewer voxels than this along their shortest edge, before they are on more.
const COARSEST: usize = 12;
/// Changes, in parts of the one that is asked for, from which on quantities are asked for: passes bring it down by more.
const NEAR: f64 = 3.0;
/// Passes that several stars take as a rule.
const EXPECTED: usize = 5;
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
                let patches = follow.sent_out();
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
}

/// Half as many voxels along each edge, where there are enough.
fn halved(dims: [usize; 3]) -> Option<[usize; 3]> {
    let dims = dims.map(|n| n.div_ceil(2));
    dims.iter().all(|n| *n >= COARSEST).then_some(dims)
}

/// The work that so many voxels and stars are as a rule.
fn level(dims: [usize; 3], stars: usize) -> u64 {
    (dims.iter().product::<usize>() * stars * if stars > 1 { EXPECTED } else { 1 }) as u64
}
