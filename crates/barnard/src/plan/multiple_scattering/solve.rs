//! Solver of multiple scattering: eight terms at a time, one order of scattering after the other.

use std::sync::Arc;

use super::cells::{DirectSource, SweepCells};
use super::direct_sources::DirectSources;
use super::directions::{Face, faces};
use super::far_field::FarField;
use super::field::{EightTerms, Field, FieldOrigin, Solved};
use super::harmonics::count;
use super::lanes::{EightLanes, WIDTH};
use super::moments::Moments;
use super::neumann_series::NeumannSeries;
use super::problem::Problem;
use super::processor::{Processor, Sweepers};
use super::sweeper::{Failure, Sweeper, Transfer};
use super::term::scattering;
use super::{FarFieldReport, Fineness, MultipleScattering, ScatteringReport};
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

/// The cells in which a field is solved, and how finely.
pub struct Discretization<'a> {
    pub cells: SweepCells,
    pub fineness: Fineness,
    /// The kernels around the gathered stars.
    pub kernels: &'a [NearFieldKernel],
}

/// A field, and how it was found.
pub struct Solution {
    pub field: Field,
    pub report: ScatteringReport,
}

impl Problem<'_> {
    /// The field in some cells; what another was found from is not solved again.
    ///
    /// # Errors
    /// If it comes to no number, and on interruption by the user.
    pub fn solve(&self, discretization: Discretization, before: Option<&MultipleScattering>, control: &Control) -> Result<Solution> {
        let Discretization { cells, fineness, kernels } = discretization;
        let space = &*self.draft.space;
        let glow: Vec<Vec<f32>> = space.gas().iter().map(|gas| cells.means(gas)).collect();
        let faces = fineness.directions.map(faces);
        let even: Vec<NearFieldKernel> = kernels.iter().map(|kernel| NearFieldKernel::even(kernel.reach_pc)).collect();
        let groups = self.terms.len().div_ceil(WIDTH) as f64;
        let mut parts = Vec::new();
        for (p, terms) in self.terms.chunks(WIDTH).enumerate() {
            let none = || Arc::new(Grid::from_lattice(cells.lattice.clone(), Vec::new()));
            let origin = FieldOrigin {
                lattice: cells.lattice.clone(),
                sigma: cells.sigma.clone(),
                dust: space.dust.clone().unwrap_or_else(none),
                places: space.stars.clone(),
                star_factor: space.star_factor,
                precision: space.precision,
                kernels: even.clone(),
                terms: terms.to_vec(),
                direct_sources: DirectSources::new(self.draft, p * WIDTH, terms, &glow),
                directions: fineness.directions,
                harmonics: count(self.kept_degree(fineness)),
                bounces: self.draft.scene.method.bounces,
            };
            let DirectSources { unit, ref many_lights, .. } = origin.direct_sources;
            let (near, sent) = (self.nearest(&origin), many_lights.clone());
            let known = before.and_then(|b| b.field.parts.get(p)).filter(|part| part.solved.origin == origin);
            let solved = match known {
                Some(part) => part.solved.clone(),
                None => {
                    let medium = TermMedium { space, cells: &cells, faces: faces.each_ref().map(|f| &f[..]), origin };
                    // Previews change too often to be stored.
                    let cache = self.draft.options.cache.as_deref().filter(|_| fineness.degree == Fineness::FULL.degree);
                    let part = control.part(p as f64 / groups, (p + 1) as f64 / groups);
                    Arc::new(medium.stored(cache, &self.sweepers, &part)?)
                }
            };
            parts.push(EightTerms { terms: terms.to_vec(), solved, unit, near, sent });
        }
        let report = self.report(&parts, &cells, fineness, kernels);
        let many_lights = space.many_lights.clone();
        let phase = self.draft.spectral.phase.as_ref().filter(|_| many_lights.is_some()).cloned();
        Ok(Solution { field: Field { parts, cells, many_lights, phase, kernels: kernels.to_vec() }, report })
    }

    /// Tells how the parts of a field were found.
    fn report(&self, parts: &[EightTerms], cells: &SweepCells, fineness: Fineness, kernels: &[NearFieldKernel]) -> ScatteringReport {
        let mut swept_by: Vec<&str> = Vec::new();
        for part in parts {
            if !swept_by.contains(&&*part.solved.by) {
                swept_by.push(&part.solved.by);
            }
        }
        let reaches = || kernels.iter().map(|kernel| kernel.reach_pc);
        ScatteringReport {
            cells: cells.lattice.dims,
            coarser: false,
            directions: fineness.directions.map(|edge| faces(edge).iter().map(|f| f.directions.len()).sum()),
            degree: self.kept_degree(fineness),
            sweeps: parts.iter().map(|part| part.solved.sweeps).max().unwrap_or(0),
            swept_by: swept_by.join(" and ").into(),
            series: parts.iter().map(|part| part.solved.series).fold(0.0, f64::max),
            settled: parts.iter().all(|part| part.solved.settled),
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
    fn nearest(&self, origin: &FieldOrigin) -> EightLanes {
        let sources = &origin.direct_sources;
        if sources.many_lights.is_empty() {
            return [0.0; WIDTH];
        }
        let densest = f64::from(self.dust.densest());
        let spectral = &self.draft.spectral;
        let phase = spectral.phase_factor(1.0).max(spectral.phase_factor(-1.0));
        let bound = phase * densest * std::f64::consts::PI / (CLOSE * self.draft.space.voxel_pc()) * f64::from(sources.unit);
        let brightest = |t: usize| sources.many_lights.iter().fold(0.0f32, |most, sent| most.max(sent[t]));
        std::array::from_fn(|t| origin.terms.get(t).map_or(0.0, |term| (f64::from(brightest(t)) * term.k * term.albedo * bound) as f32))
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
        let Some(cache) = cache.filter(|_| self.origin.bounces > 1) else { return self.solve(sweepers, control) };
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
        if bounces == 1 {
            let moments = Moments::dark(0, harmonics);
            return Ok(Solved { origin: self.origin, moments, sweeps: 0, series: 0.0, settled: true, by: Processor.name().into() });
        }
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
        if let Some(dust) = &self.space.dust {
            self.cells.direct(dust, |_| marched(self.space, &direct_sources.stars), k, &mut first, control)?;
            if let Some(far_field) = &far_field {
                self.cells.direct(dust, |row| far_field.near(self.cells, row), k, &mut first, control)?;
            }
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
