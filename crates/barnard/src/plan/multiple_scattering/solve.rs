//! Solver of multiple scattering: eight terms at a time, one order of scattering after the other.

use std::sync::Arc;

use rayon::prelude::*;

use super::cells::{DirectSource, SweepCells};
use super::direct_sources::DirectSources;
use super::directions::{Face, faces};
use super::far_field::FarField;
use super::field::{EightTerms, Field};
use super::fineness::Fineness;
use super::harmonics::count;
use super::lanes::{EightLanes, WIDTH};
use super::level::Level;
use super::moments::Moments;
use super::neumann_series::NeumannSeries;
use super::problem::Problem;
use super::processor::Sweepers;
use super::reduction::Reduction;
use super::solved::{FieldOrigin, Solved};
use super::sweeper::{Failure, Sweeper, Transfer};
use super::term::{Term, scattering};
use super::{FarFieldReport, MultipleScattering, ScatteringReport};
use crate::cache::{Cache, Record};
use crate::control::{Control, Stage};
use crate::error::Result;
use crate::field::Grid;
use crate::plan::SpatialPlan;
use crate::plan::many_lights::near_field_kernel::NearFieldKernel;

/// Kind of stored fields.
const KIND: &str = "multiple_scattering";
/// The largest number of sweeps.
const MAX_SWEEPS: usize = 400;

/// Cells along an edge of fields that are solved side by side and are not stored: those of previews and of first looks.
const SMALL: usize = Fineness::PREVIEW.cells;
/// Error of a term, as a part of the accuracy, that summing few terms may cause.
const REDUCTION_SHARE: f64 = 0.1;

impl Problem<'_> {
    /// A solution of terms in cells; light of a known origin is not solved again.
    ///
    /// # Errors
    /// If it comes to no number, and on interruption by the user.
    pub fn solve(&self, fineness: Fineness, numbers: &[usize], before: Option<&MultipleScattering>, control: &Control) -> Result<Level> {
        let space = &*self.draft.space;
        let cells = self.cells(fineness.cells.max(1));
        let glow: Vec<Vec<f32>> = space.gas().iter().map(|gas| cells.means(gas)).collect();
        let kernels: Vec<_> = self.kernels(&cells).iter().map(|kernel| NearFieldKernel::even(kernel.reach_pc)).collect();
        let groups = if self.scatters_again() { numbers } else { &[] }.chunks(WIDTH);
        let origin = |numbers: &[usize]| FieldOrigin {
            lattice: cells.lattice.clone(),
            sigma: cells.sigma.clone(),
            dust: space.dust.clone().unwrap_or_else(|| Arc::new(Grid::from_lattice(cells.lattice.clone(), Vec::new()))),
            places: space.stars.clone(),
            star_factor: space.star_factor,
            precision: space.precision,
            kernels: kernels.clone(),
            terms: numbers.iter().map(|number| self.terms[*number]).collect(),
            direct_sources: DirectSources::new(self, numbers, &glow),
            directions: fineness.directions,
            harmonics: count(self.kept_degree(fineness)),
            bounces: self.draft.scene.method.bounces,
        };
        let all = groups.len();
        let solve = |(g, numbers): (usize, &[usize])| {
            let part = control.part(g as f64 / all as f64, (g + 1) as f64 / all as f64);
            self.solved(origin(numbers), &cells, fineness, before, &part)
        };
        // Small fields leave processors idle, many of them do not.
        let together = if fineness.cells <= SMALL { 1 } else { all.max(1) };
        let groups: Vec<_> = groups.enumerate().collect();
        let solved = groups.into_par_iter().with_min_len(together).map(solve).collect::<Result<Vec<_>>>()?;
        Ok(Level { cells, fineness, solved })
    }

    /// The field of some levels.
    pub fn field(&self, levels: Vec<Level>, reduction: Arc<Reduction>) -> Field {
        let finest = &levels[levels.len() - 1];
        let many_lights = self.draft.space.many_lights.clone();
        let part = |(p, terms): (usize, &[Term])| {
            let numbers: Vec<usize> = (p * WIDTH..p * WIDTH + terms.len()).collect();
            // Stars that are gathered are seen by each term for itself.
            let gathered = many_lights.as_ref().map(|_| DirectSources::new(self, &numbers, &[]));
            let near = gathered.as_ref().map_or([0.0; WIDTH], |sources| self.nearest(terms, sources));
            EightTerms { terms: terms.to_vec(), near, sent: gathered.map_or_else(Vec::new, |sources| sources.many_lights) }
        };
        let parts = self.terms.chunks(WIDTH).enumerate().map(part).collect();
        let phase = self.draft.spectral.phase.as_ref().filter(|_| many_lights.is_some()).cloned();
        let kernels = self.kernels(&finest.cells);
        Field { parts, reduction, unit: self.unit, many_lights, phase, kernels, levels }
    }

    /// The terms whose sums are all terms within a part of the accuracy, found on a coarse lattice.
    ///
    /// # Errors
    /// If a coarse solution comes to no number, and on interruption by the user.
    pub fn reduction(&self, before: Option<&MultipleScattering>, control: &Control) -> Result<Arc<Reduction>> {
        if !self.scatters_again() || Reduction::is_needless(self.terms.len()) {
            return Ok(Arc::new(Reduction::none(self.terms.len())));
        }
        let all: Vec<usize> = (0..self.terms.len()).collect();
        let Level { cells, solved, .. } = self.solve(Fineness::REDUCING, &all, before, &control.part(0.0, 0.0))?;
        let allowed = REDUCTION_SHARE * self.draft.scene.method.accuracy;
        let is_known = |reduction: &&Arc<Reduction>| {
            reduction.allowed == allowed
                && reduction.coarse.len() == solved.len()
                && reduction.coarse.iter().zip(&solved).all(|(a, b)| Arc::ptr_eq(a, b))
        };
        Ok(match before.map(|before| &before.field.reduction).filter(is_known) {
            Some(reduction) => reduction.clone(),
            None => Arc::new(Reduction::new(solved, &cells, allowed)),
        })
    }

    /// Light of an origin: that which is known, that of the cache, or a new solution.
    fn solved(
        &self,
        origin: FieldOrigin,
        cells: &SweepCells,
        fineness: Fineness,
        before: Option<&MultipleScattering>,
        control: &Control,
    ) -> Result<Arc<Solved>> {
        let mut known = before.into_iter().flat_map(|before| before.field.solved());
        if let Some(known) = known.find(|known| known.origin == origin) {
            return Ok(known.clone());
        }
        let faces = fineness.directions.map(faces);
        let medium = TermMedium { space: &self.draft.space, cells, faces: faces.each_ref().map(|f| &f[..]), origin };
        // Small fields are solved as soon as they are read.
        let cache = self.draft.options.cache.as_deref().filter(|_| fineness.cells > SMALL);
        medium.stored(cache, &self.sweepers, control).map(Arc::new)
    }

    /// Tells how a field was found.
    pub fn report(&self, field: &Field) -> ScatteringReport {
        let (finest, solved) = (field.finest(), || field.levels.iter().flat_map(|level| &level.solved));
        let mut swept_by: Vec<&str> = Vec::new();
        for solved in solved() {
            if !swept_by.contains(&&*solved.by) {
                swept_by.push(&solved.by);
            }
        }
        let reaches = || field.kernels.iter().map(|kernel| kernel.reach_pc);
        ScatteringReport {
            cells: finest.cells.lattice.dims,
            extrapolated_from: field.coarser().map(|level| level.cells.lattice.dims),
            coarser: false,
            is_estimate: false,
            directions: finest.fineness.directions.map(|edge| faces(edge).iter().map(|f| f.directions.len()).sum()),
            degree: self.kept_degree(finest.fineness),
            terms: (field.reduction.solved.len(), self.terms.len()),
            sweeps: solved().map(|solved| solved.sweeps).max().unwrap_or(0),
            swept_by: swept_by.join(" and ").into(),
            series: solved().map(|solved| solved.series).fold(0.0, f64::max),
            settled: solved().all(|solved| solved.settled),
            error_estimate: None,
            far_field: self.draft.space.many_lights.as_ref().map(|many_lights| FarFieldReport {
                stars: many_lights.stars.len(),
                near_pc: (reaches().fold(f64::INFINITY, f64::min), reaches().fold(0.0, f64::max)),
                shadows: many_lights.edge(),
                error: None,
            }),
            bytes: 0,
        }
    }

    /// The most that the brightest gathered star sends along a ray that passes it at a quarter of a voxel, ∫ σ ds/r²
    /// being less than σ π/b: about what may lie behind a ray's end.
    fn nearest(&self, terms: &[Term], sources: &DirectSources) -> EightLanes {
        let densest = f64::from(self.dust.densest());
        let spectral = &self.draft.spectral;
        let phase = spectral.phase_factor(1.0).max(spectral.phase_factor(-1.0));
        let bound = phase * densest * std::f64::consts::PI / (CLOSE * self.draft.space.voxel_pc()) * f64::from(sources.unit);
        let brightest = |t: usize| sources.many_lights.iter().fold(0.0f32, |most, sent| most.max(sent[t]));
        std::array::from_fn(|t| terms.get(t).map_or(0.0, |term| (f64::from(brightest(t)) * term.k * term.albedo * bound) as f32))
    }
}

/// The closest approach of a ray to a gathered star, in voxels of dust [1].
const CLOSE: f64 = 0.25;

/// Stars that have depths of their own, as cells see them.
fn marched<'a>(space: &'a SpatialPlan, stars: &'a [(usize, EightLanes)]) -> Vec<DirectSource<'a>> {
    let direct_source = |(star, sent): &'a (usize, EightLanes)| {
        let channel = space.star_channel(*star);
        let depth = move |place, _| channel.map_or(0.0, |(volume, slot)| volume.at(slot, place));
        DirectSource { place: space.stars[*star], sent, depth: Box::new(depth), kernel_pc: None }
    };
    stars.iter().map(direct_source).collect()
}

/// Eight terms of a problem, ready to be solved.
struct TermMedium<'a> {
    space: &'a SpatialPlan,
    cells: &'a SweepCells,
    faces: [&'a [Face]; 2],
    /// The terms, and what shines for them.
    origin: FieldOrigin,
}

impl TermMedium<'_> {
    /// The light of the cache, or of a new solution, which is stored unless a device gave up.
    fn stored(self, cache: Option<&dyn Cache>, sweepers: &Sweepers, control: &Control) -> Result<Solved> {
        let Some(cache) = cache else { return self.solve(sweepers, control) };
        let content = self.origin.fingerprint(sweepers.has_device());
        if let Some(record) = cache.get(KIND, content)
            && let [sweeps, series, settled] = record.numbers[..]
            && let Some(moments) =
                record.arrays.first().and_then(|data| Moments::from_flat(data, &self.cells.lattice, self.origin.harmonics))
        {
            let by = record.text.into();
            return Ok(Solved { origin: self.origin, moments, sweeps: sweeps as usize, series, settled: settled != 0.0, by });
        }
        let had_device = sweepers.has_device();
        let solved = self.solve(sweepers, control)?;
        if sweepers.has_device() == had_device {
            let Solved { moments, sweeps, series, settled, by, .. } = &solved;
            let numbers = vec![*sweeps as f64, *series, f64::from(u8::from(*settled))];
            cache.put(KIND, content, &Record { text: by.to_string(), numbers, arrays: vec![moments.data.as_flattened().to_vec().into()] });
        }
        Ok(solved)
    }

    /// The light of all orders below the bounces of its origin; by the first of the `sweepers` that can.
    fn solve(self, sweepers: &Sweepers, control: &Control) -> Result<Solved> {
        let FieldOrigin { ref terms, harmonics, bounces, ref direct_sources, .. } = self.origin;
        let k: EightLanes = std::array::from_fn(|t| terms.get(t).map_or(0.0, |term| term.k as f32));
        let scattering = scattering(terms);
        let DirectSources { glow, around, .. } = direct_sources;
        let transfer = Transfer {
            cells: self.cells,
            terms: terms.len(),
            k: &k,
            faces: self.faces,
            scattering: &scattering[..harmonics],
            glow: glow.as_deref(),
            around,
        };
        let ((moments, neumann), by) = sweepers.run(|sweeper| {
            let first = self.first(&k, &control.part(0.0, FIRST_SHARE))?;
            orders(sweeper, transfer, first, bounces, &control.part(FIRST_SHARE, 1.0))
        })?;
        let (series, _) = neumann.rest(bounces);
        let (sweeps, settled) = (neumann.orders.len(), neumann.is_known() || neumann.orders.len() + 1 == bounces);
        Ok(Solved { origin: self.origin, moments, sweeps, series, settled, by })
    }

    /// Moments of light that has not been scattered yet; `k` are the terms' extinctions.
    fn first(&self, k: &EightLanes, control: &Control) -> Result<Moments> {
        let FieldOrigin { direct_sources, kernels, harmonics, .. } = &self.origin;
        let many_lights = self.space.many_lights.as_deref();
        let far_field = many_lights.map(|many_lights| FarField { many_lights, sent: &direct_sources.many_lights, k, kernels });
        let dark = || Ok(Moments::dark(self.cells.lattice.cells(), *harmonics));
        let mut first = far_field.map_or_else(dark, |far| far.moments(self.cells, *harmonics, control))?;
        self.cells.direct(|_| marched(self.space, &direct_sources.stars), k, &mut first, control)?;
        if let Some(far_field) = &far_field {
            self.cells.direct(|row| far_field.near(self.cells, row), k, &mut first, control)?;
        }
        Ok(first)
    }
}

/// About the part of the work that light takes which has not been scattered yet.
const FIRST_SHARE: f64 = 0.2;

/// Sweeps all orders of scattering below `bounces`; returns their sum, and how they went.
fn orders(
    sweeper: &dyn Sweeper,
    transfer: Transfer,
    first: Moments,
    bounces: usize,
    control: &Control,
) -> std::result::Result<(Moments, NeumannSeries), Failure> {
    let mut orders = sweeper.start(transfer, first)?;
    let mut neumann = NeumannSeries::default();
    for sweeps in 1..bounces.min(MAX_SWEEPS + 1) {
        let (order, sum) = orders.next(control)?;
        if !order.iter().chain(&sum).all(|power| power.is_finite()) {
            return Err(Failure::Unable("the solution is not finite, because densities or lights are too large or too small".into()));
        }
        neumann.push(order, sum);
        control.report(Stage::Light, sweeps as u64, neumann.expected(bounces));
        if neumann.is_known() {
            break;
        }
    }
    let (_, rest) = neumann.rest(bounces);
    Ok((orders.sum(&rest)?, neumann))
}
