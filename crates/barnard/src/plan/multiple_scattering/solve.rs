//! Orders of scattering, one after the other, for all nodes of a plan.

use std::sync::Arc;

use rayon::prelude::*;
use spectra::rule::Node;

use super::cells::{Cells, DirectSource};
use super::direct_sources::DirectSources;
use super::directions::{Face, faces};
use super::far_field::FarField;
use super::harmonics::{DEGREE, count, legendre_moments};
use super::moments::Moments;
use super::neumann_series::NeumannSeries;
use super::ordinates::{EightLanes, Failure, Processor, Sweeper, Sweepers, Transfer, WIDTH};
use super::spot_check::{Deviation, SpotCheck};
use super::{FarFieldError, Field, Fineness, MultipleScattering, Origin, Part, ScatteringReport, Solved, Term, View, scattering};
use crate::control::{Control, Stage};
use crate::error::{Error, Result};
use crate::field::Grid;
use crate::light::Light;
use crate::memory;
use crate::plan::many_lights::near_field_kernel::NearFieldKernel;
use crate::plan::{BandPlan, Settings, SpatialPlan, SpectralPlan};
use crate::scene::Scene;

/// Fewest cells along the longest edge that are worth it.
const MIN: usize = 12;
/// Moments of the phase function that are none.
const NEGLIGIBLE: f64 = 0.02;
/// Most sweeps.
const MAX_SWEEPS: usize = 400;

/// What a field is solved for.
pub struct Problem<'a> {
    pub scene: &'a Scene,
    pub lights: &'a [Light],
    pub spectral: &'a SpectralPlan,
    pub space: &'a SpatialPlan,
    pub settings: &'a Settings,
    pub terms: Vec<Term>,
    pub sweepers: Sweepers<'a>,
}

impl Problem<'_> {
    /// As many cells as `fineness` says, or as the memory limit lets be; the bytes of all, and whether it was the
    /// limit.
    pub fn fitting(&self, dust: &Grid, fineness: Fineness) -> Result<(Cells, u64, bool)> {
        let harmonics = count(kept_degree(&self.terms, fineness));
        let parts = self.terms.len().div_ceil(WIDTH) as u64;
        // All orders of each part, two orders of one where it is swept, what the march reads, and that as it is
        // gathered.
        let orders = if self.settings.method.bounces > 1 { 2 + parts } else { 0 };
        let gathered = if self.space.many_lights.is_some() { 2 * parts } else { 0 };
        let bytes_of = |cells: &Cells| {
            let count = cells.lattice.cells();
            let field = Moments::bytes(count, harmonics).saturating_mul(orders).saturating_add(4 * (count * self.terms.len()) as u64);
            let glow = if self.space.gas().is_empty() { 0 } else { Moments::bytes(count, 1) };
            // A quarter more for the halves beside it.
            (field + glow) / 4 * 5 + Moments::bytes(count, 1) * gathered
        };
        let (limit, space) = (self.settings.memory_limit, self.space.bytes());
        let mut edge = fineness.cells;
        let mut cells = Cells::new(dust, self.space.gas(), edge);
        while bytes_of(&cells) > limit.saturating_sub(space) && edge > MIN {
            edge = (3 * edge / 4).max(MIN);
            cells = Cells::new(dust, self.space.gas(), edge);
        }
        let bytes = bytes_of(&cells);
        memory::check("the field of light that is scattered more than once", space + bytes, limit)?;
        Ok((cells, bytes, edge < fineness.cells))
    }

    /// The field in `cells`, seen by the scene's camera.
    ///
    /// `kernels` are those around the gathered stars; their light is compared with the exact one by `spot_checks`, and
    /// left out where there are none.
    pub fn solve(
        &self,
        (cells, fineness): (Cells, Fineness),
        (kernels, spot_checks): (&[NearFieldKernel], Option<&[SpotCheck]>),
        before: Option<&MultipleScattering>,
        control: &Control,
    ) -> Result<MultipleScattering> {
        let degree = kept_degree(&self.terms, fineness);
        let glow: Vec<Vec<f32>> = self.space.gas().iter().map(|gas| cells.means(gas)).collect();
        let faces = fineness.directions.map(faces);
        let many_lights = self.space.many_lights.as_deref();
        let even: Vec<NearFieldKernel> = kernels.iter().map(|kernel| NearFieldKernel::even(kernel.reach_pc)).collect();
        let (mut field, mut sweeps, mut series, mut settled) = (Vec::new(), 0, 0.0f64, true);
        let mut swept_by: Vec<Arc<str>> = Vec::new();
        let parts = self.terms.len().div_ceil(WIDTH) as f64;
        for (p, own) in self.terms.chunks(WIDTH).enumerate() {
            let medium = Medium { cells: &cells, count: count(degree), faces: faces.each_ref().map(|f| &f[..]), terms: own };
            let direct_sources = DirectSources::new(self.lights, self.spectral, (p * WIDTH, own), &glow, many_lights);
            let k: EightLanes = std::array::from_fn(|t| own.get(t).map_or(0.0, |term| term.k as f32));
            let gathering =
                many_lights.map(|many_lights| FarField { many_lights, sent: &direct_sources.many_lights, k: &k, kernels: &even });
            let origin = self.origin(&medium, (&direct_sources, &even), fineness);
            let known = before.and_then(|b| b.field.parts.get(p)).filter(|part| part.solved.origin == origin);
            let solved = match known {
                Some(part) => part.solved.clone(),
                None => {
                    let part = control.part((p as f64 / parts, (p + 1) as f64 / parts));
                    Arc::new(medium.solve(self.space, origin, (&k, gathering), (&self.sweepers, &part))?)
                }
            };
            (sweeps, series) = (sweeps.max(solved.sweeps), series.max(solved.series));
            settled &= solved.settled;
            if !swept_by.contains(&solved.by) {
                swept_by.push(solved.by.clone());
            }
            let near = self.nearest(own, &direct_sources);
            field.push(Part { terms: own.to_vec(), solved, unit: direct_sources.unit, near, sent: direct_sources.many_lights });
        }
        let gathered = many_lights.map(|many_lights| FarFieldError {
            stars: many_lights.stars.len(),
            near_pc: reaches(kernels),
            shadows: many_lights.edge(),
            error: None,
        });
        let directions = faces.each_ref().map(|faces| faces.iter().map(|f| f.directions.len()).sum());
        let mut found = ScatteringReport {
            cells: cells.lattice.dims,
            coarser: false,
            directions,
            degree,
            sweeps,
            swept_by: swept_by.join(" and ").into(),
            series,
            settled,
            error_estimate: None,
            gathered,
            bytes: 0,
        };
        let phase = self.spectral.phase.as_ref().filter(|_| many_lights.is_some()).cloned();
        let field = Field { parts: field, cells, many_lights: self.space.many_lights.clone(), phase, kernels: kernels.to_vec() };
        let view = View::of(&self.scene.camera);
        let seen = spot_checks.map_or(Ok(Vec::new()), |_| field.gathered(view, control))?;
        if let (Some(spot_checks), Some(gathered), Some(dust)) = (spot_checks, &mut found.gathered, &self.scene.dust) {
            let near = field.profiles(view);
            let of_trial = |spot_check: &SpotCheck| spot_check.deviation(&field, (&seen, &near), &*dust.phase, view);
            let deviations: Vec<Deviation> = spot_checks.par_iter().map(of_trial).collect();
            gathered.error = Deviation::part(&deviations);
        }
        Ok(MultipleScattering::resolved(Arc::new(field), seen, found, view))
    }

    /// What the light of some terms depends on.
    fn origin(&self, medium: &Medium, (direct_sources, kernels): (&DirectSources, &[NearFieldKernel]), fineness: Fineness) -> Origin {
        let none = || Arc::new(Grid { lattice: medium.cells.lattice.clone(), data: Vec::new() });
        Origin {
            lattice: medium.cells.lattice.clone(),
            sigma: medium.cells.sigma.clone(),
            dust: self.space.dust.clone().unwrap_or_else(none),
            places: self.space.stars.clone(),
            star_factor: self.space.star_factor,
            kernels: kernels.to_vec(),
            terms: medium.terms.to_vec(),
            direct_sources: direct_sources.clone(),
            directions: fineness.directions,
            harmonics: medium.count,
            bounces: self.settings.method.bounces,
        }
    }

    /// The most that the brightest gathered star sends along a ray that passes it at a quarter of a voxel, ∫ σ ds/r²
    /// being less than σ π/b: about what may lie behind a ray's end.
    fn nearest(&self, terms: &[Term], direct_sources: &DirectSources) -> EightLanes {
        let Some(dust) = self.space.dust.as_ref().filter(|_| !direct_sources.many_lights.is_empty()) else { return [0.0; WIDTH] };
        let densest = f64::from(dust.data.iter().fold(0.0f32, |most, sigma| most.max(*sigma)));
        let phase = self.spectral.phase_factor(1.0).max(self.spectral.phase_factor(-1.0));
        let bound = phase * densest * std::f64::consts::PI / (CLOSE * self.space.voxel_pc()) * f64::from(direct_sources.unit);
        let brightest = |t: usize| direct_sources.many_lights.iter().fold(0.0f32, |most, sent| most.max(sent[t]));
        std::array::from_fn(|t| terms.get(t).map_or(0.0, |term| (f64::from(brightest(t)) * term.k * term.albedo * bound) as f32))
    }
}

/// Smallest and largest radius of some kernels [pc].
fn reaches(kernels: &[NearFieldKernel]) -> (f64, f64) {
    kernels.iter().fold((f64::INFINITY, 0.0), |(low, high), w| (low.min(w.reach_pc), high.max(w.reach_pc)))
}

/// How close to a gathered star a ray passes, in voxels of dust [1].
const CLOSE: f64 = 0.25;

/// The highest degree that any phase function still has something of: moments of the light above it scatter into
/// nothing.
fn kept_degree(terms: &[Term], fineness: Fineness) -> usize {
    // What so few directions tell apart.
    let most = fineness.degree.min(if fineness.directions[1] > 2 { DEGREE } else { 2 });
    let has = |l: usize| terms.iter().any(|term| term.legendre[l].abs() > NEGLIGIBLE);
    (0..=most).rev().find(|l| has(*l)).unwrap_or(0)
}

/// Moments of a phase function that do not grow when they scatter: nine directions a face make up to a tenth too much
/// of harmonics above the second degree.
fn stable(mut legendre: [f64; DEGREE + 1]) -> [f64; DEGREE + 1] {
    legendre.iter_mut().skip(3).for_each(|p| *p = p.clamp(-0.9, 0.9));
    legendre
}

/// The nodes of all passbands.
pub fn terms(scene: &Scene, spectral: &SpectralPlan) -> Result<Vec<Term>> {
    let Some(dust) = &scene.dust else { return Ok(Vec::new()) };
    let term = |node: &Node| Term {
        k: node.k,
        lambda_um: node.lambda_um,
        albedo: dust.albedo.at(node.lambda_um),
        legendre: stable(legendre_moments(&*dust.phase, node.lambda_um)),
    };
    Ok(spectral.bands.iter().map(nodes).collect::<Result<Vec<_>>>()?.into_iter().flatten().map(term).collect())
}

/// The nodes of a passband.
///
/// # Errors
/// For rules that have none.
pub fn nodes(band: &BandPlan) -> Result<&[Node]> {
    band.nodes().ok_or_else(|| Error::OneBounce("this spectral method".into(), "a method of nodes such as band_quadrature"))
}

/// What light meets.
struct Medium<'a> {
    cells: &'a Cells,
    /// Harmonics that are kept.
    count: usize,
    faces: [&'a [Face]; 2],
    terms: &'a [Term],
}

/// Stars that have depths of their own, as cells see them.
fn marched<'a>(space: &'a SpatialPlan, stars: &'a [(usize, EightLanes)]) -> Vec<DirectSource<'a>> {
    let direct_source = |(star, sent): &'a (usize, EightLanes)| {
        let channel = space.star_channel(*star);
        let depth = move |place, _| channel.map_or(0.0, |(volume, slot)| volume.at(slot, place));
        DirectSource { place: space.stars[*star], sent, depth: Box::new(depth), kernel_pc: None }
    };
    stars.iter().map(direct_source).collect()
}

impl Medium<'_> {
    /// The light of all orders below the bounces of its `origin`; by the first of the `sweepers` that can.
    fn solve(
        &self,
        space: &SpatialPlan,
        origin: Origin,
        (k, gathering): (&EightLanes, Option<FarField>),
        (sweepers, control): (&Sweepers, &Control),
    ) -> Result<Solved> {
        if origin.bounces == 1 {
            let moments = Moments::dark(0, self.count);
            return Ok(Solved { origin, moments, sweeps: 0, series: 0.0, settled: true, by: Processor.name().into() });
        }
        let scattering = scattering(self.terms);
        let DirectSources { glow, around, .. } = &origin.direct_sources;
        let transfer =
            Transfer { cells: self.cells, k, faces: self.faces, scattering: &scattering[..self.count], glow: glow.as_deref(), around };
        let ((moments, neumann), by) = sweepers.run(|sweeper| {
            let first = self.first(space, &origin.direct_sources, (k, gathering), &control.part((0.0, FIRST_SHARE)))?;
            orders(sweeper, transfer, first, origin.bounces, &control.part((FIRST_SHARE, 1.0)))
        })?;
        let (series, _) = neumann.rest(origin.bounces);
        let (sweeps, settled) = (neumann.orders.len(), neumann.is_known() || neumann.orders.len() + 1 == origin.bounces);
        Ok(Solved { origin, moments, sweeps, series, settled, by })
    }

    /// Moments of light that has not been scattered yet.
    fn first(
        &self,
        space: &SpatialPlan,
        direct_sources: &DirectSources,
        (k, gathering): (&EightLanes, Option<FarField>),
        control: &Control,
    ) -> Result<Moments> {
        let dark = || Ok(Moments::dark(self.cells.lattice.cells(), self.count));
        let mut first = gathering.map_or_else(dark, |g| g.moments(self.cells, self.count, control))?;
        if let Some(dust) = &space.dust {
            self.cells.direct(dust, |_| marched(space, &direct_sources.stars), k, &mut first, control)?;
            if let Some(gathering) = &gathering {
                self.cells.direct(dust, |row| gathering.near(self.cells, row), k, &mut first, control)?;
            }
        }
        Ok(first)
    }
}

/// About the part of the work that light takes which has not been scattered yet.
const FIRST_SHARE: f64 = 0.2;

/// All orders of scattering below `bounces`, and how they went.
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
        let (own, sum) = orders.next(control)?;
        if !own.iter().chain(&sum).all(|power| power.is_finite()) {
            return Err(Failure::Unable("it comes to no number, since densities or lights are too large or too small".into()));
        }
        neumann.push(own, sum);
        control.report(Stage::Light, sweeps as u64, neumann.expected(bounces));
        if neumann.is_known() {
            break;
        }
    }
    let (_, rest) = neumann.rest(bounces);
    Ok((orders.sum(&rest)?, neumann))
}
