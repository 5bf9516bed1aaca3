//! Orders of scattering, one after the other, for all nodes of a plan.

use std::sync::Arc;

use rayon::prelude::*;
use spectra::rule::Node;

use super::course::Course;
use super::directions::{Face, faces};
use super::gather::Gathering;
use super::harmonics::{DEGREE, count, legendre_moments};
use super::lamps::Lamps;
use super::medium::{Cells, Lamp};
use super::moments::Moments;
use super::ordinates::{Failure, Octet, Processor, Sweeper, Sweepers, Transfer, WIDTH};
use super::trial::{Deviation, Trial};
use super::{Diffuse, Field, Fineness, Found, Gathered, Origin, Part, Solved, Term, View, scattering};
use crate::control::{Control, Stage};
use crate::error::{Error, Result};
use crate::field::Grid;
use crate::light::Light;
use crate::memory;
use crate::plan::window::Window;
use crate::plan::{BandPlan, Settings, Space, Spectral};
use crate::scene::Scene;

/// Fewest cells along the longest edge that are worth it.
const FEWEST: usize = 12;
/// Moments of the phase function that are none.
const NEGLIGIBLE: f64 = 0.02;
/// Most sweeps.
const MOST_SWEEPS: usize = 400;

/// What a field is solved for.
pub struct Problem<'a> {
    pub scene: &'a Scene,
    pub lights: &'a [Light],
    pub spectral: &'a Spectral,
    pub space: &'a Space,
    pub settings: &'a Settings,
    pub terms: Vec<Term>,
    pub sweepers: Sweepers<'a>,
}

impl Problem<'_> {
    /// As many cells as `fineness` says, or as the memory limit lets be; the bytes of all, and whether it was the limit.
    pub fn fitting(&self, dust: &Grid, fineness: Fineness) -> Result<(Cells, u64, bool)> {
        let harmonics = count(kept_degree(&self.terms, fineness));
        let parts = self.terms.len().div_ceil(WIDTH) as u64;
        // All orders of each part, two orders of one where it is swept, what the march reads, and that as it is gathered.
        let orders = if self.settings.method.bounces > 1 { 2 + parts } else { 0 };
        let gathered = if self.space.crowd.is_some() { 2 * parts } else { 0 };
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
        while bytes_of(&cells) > limit.saturating_sub(space) && edge > FEWEST {
            edge = (3 * edge / 4).max(FEWEST);
            cells = Cells::new(dust, self.space.gas(), edge);
        }
        let bytes = bytes_of(&cells);
        memory::check("the field of light that is scattered more than once", space + bytes, limit)?;
        Ok((cells, bytes, edge < fineness.cells))
    }

    /// The field in `cells`, seen by the scene's camera.
    ///
    /// `windows` are those around the stars of the crowd; their light is compared with the exact one by `trials`, and left out where there are none.
    pub fn solve(
        &self,
        (cells, fineness): (Cells, Fineness),
        (windows, trials): (&[Window], Option<&[Trial]>),
        before: Option<&Diffuse>,
        control: &Control,
    ) -> Result<Diffuse> {
        let degree = kept_degree(&self.terms, fineness);
        let glow: Vec<Vec<f32>> = self.space.gas().iter().map(|gas| cells.means(gas)).collect();
        let faces = fineness.directions.map(faces);
        let crowd = self.space.crowd.as_deref();
        let even: Vec<Window> = windows.iter().map(|window| Window::even(window.reach_pc)).collect();
        let (mut field, mut sweeps, mut series, mut settled) = (Vec::new(), 0, 0.0f64, true);
        let mut swept_by: Vec<Arc<str>> = Vec::new();
        let parts = self.terms.len().div_ceil(WIDTH) as f64;
        for (p, own) in self.terms.chunks(WIDTH).enumerate() {
            let medium = Medium { cells: &cells, count: count(degree), faces: faces.each_ref().map(|f| &f[..]), terms: own };
            let lamps = Lamps::new(self.lights, self.spectral, (p * WIDTH, own), &glow, crowd);
            let k: Octet = std::array::from_fn(|t| own.get(t).map_or(0.0, |term| term.k as f32));
            let gathering = crowd.map(|crowd| Gathering { crowd, sent: &lamps.crowd, k: &k, windows: &even });
            let origin = self.origin(&medium, (&lamps, &even), fineness);
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
            let near = self.nearest(own, &lamps);
            field.push(Part { terms: own.to_vec(), solved, unit: lamps.unit, near, sent: lamps.crowd });
        }
        let gathered =
            crowd.map(|crowd| Gathered { stars: crowd.stars.len(), near_pc: reaches(windows), shadows: crowd.edge(), error: None });
        let directions = faces.each_ref().map(|faces| faces.iter().map(|f| f.directions.len()).sum());
        let mut found = Found {
            cells: cells.lattice.dims,
            coarser: false,
            directions,
            degree,
            sweeps,
            swept_by: swept_by.join(" and ").into(),
            series,
            settled,
            doubt: None,
            gathered,
            bytes: 0,
        };
        let phase = self.spectral.phase.as_ref().filter(|_| crowd.is_some()).cloned();
        let field = Field { parts: field, cells, crowd: self.space.crowd.clone(), phase, windows: windows.to_vec() };
        let view = View::of(&self.scene.camera);
        let seen = trials.map_or(Ok(Vec::new()), |_| field.gathered(view, control))?;
        if let (Some(trials), Some(gathered), Some(dust)) = (trials, &mut found.gathered, &self.scene.dust) {
            let near = field.profiles(view);
            let of_trial = |trial: &Trial| trial.deviation(&field, (&seen, &near), &*dust.phase, view);
            let deviations: Vec<Deviation> = trials.par_iter().map(of_trial).collect();
            gathered.error = Deviation::part(&deviations);
        }
        Ok(Diffuse::resolved(Arc::new(field), seen, found, view))
    }

    /// What the light of some terms depends on.
    fn origin(&self, medium: &Medium, (lamps, windows): (&Lamps, &[Window]), fineness: Fineness) -> Origin {
        let none = || Arc::new(Grid { lattice: medium.cells.lattice.clone(), data: Vec::new() });
        Origin {
            lattice: medium.cells.lattice.clone(),
            sigma: medium.cells.sigma.clone(),
            dust: self.space.dust.clone().unwrap_or_else(none),
            places: self.space.stars.clone(),
            star_factor: self.space.star_factor,
            windows: windows.to_vec(),
            terms: medium.terms.to_vec(),
            lamps: lamps.clone(),
            directions: fineness.directions,
            harmonics: medium.count,
            bounces: self.settings.method.bounces,
        }
    }

    /// The most that the brightest star of the crowd sends along a ray that passes it at a quarter of a voxel, ∫ σ ds/r² being less than σ π/b: about what may lie behind a ray's end.
    fn nearest(&self, terms: &[Term], lamps: &Lamps) -> Octet {
        let Some(dust) = self.space.dust.as_ref().filter(|_| !lamps.crowd.is_empty()) else { return [0.0; WIDTH] };
        let densest = f64::from(dust.data.iter().fold(0.0f32, |most, sigma| most.max(*sigma)));
        let phase = self.spectral.phase_factor(1.0).max(self.spectral.phase_factor(-1.0));
        let bound = phase * densest * std::f64::consts::PI / (CLOSE * self.space.voxel_pc()) * f64::from(lamps.unit);
        let brightest = |t: usize| lamps.crowd.iter().fold(0.0f32, |most, sent| most.max(sent[t]));
        std::array::from_fn(|t| terms.get(t).map_or(0.0, |term| (f64::from(brightest(t)) * term.k * term.albedo * bound) as f32))
    }
}

/// Smallest and largest radius of some windows [pc].
fn reaches(windows: &[Window]) -> (f64, f64) {
    windows.iter().fold((f64::INFINITY, 0.0), |(low, high), w| (low.min(w.reach_pc), high.max(w.reach_pc)))
}

/// How close to a star of the crowd a ray passes, in voxels of dust [1].
const CLOSE: f64 = 0.25;

/// The highest degree that any phase function still has something of: moments of the light above it scatter into nothing.
fn kept_degree(terms: &[Term], fineness: Fineness) -> usize {
    // What so few directions tell apart.
    let most = fineness.degree.min(if fineness.directions[1] > 2 { DEGREE } else { 2 });
    let has = |l: usize| terms.iter().any(|term| term.legendre[l].abs() > NEGLIGIBLE);
    (0..=most).rev().find(|l| has(*l)).unwrap_or(0)
}

/// Moments of a phase function that do not grow when they scatter: nine directions a face make up to a tenth too much of harmonics above the second degree.
fn stable(mut legendre: [f64; DEGREE + 1]) -> [f64; DEGREE + 1] {
    legendre.iter_mut().skip(3).for_each(|p| *p = p.clamp(-0.9, 0.9));
    legendre
}

/// The nodes of all passbands.
pub fn terms(scene: &Scene, spectral: &Spectral) -> Result<Vec<Term>> {
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
fn marched<'a>(space: &'a Space, stars: &'a [(usize, Octet)]) -> Vec<Lamp<'a>> {
    let lamp = |(star, sent): &'a (usize, Octet)| {
        let channel = space.star_channel(*star);
        let depth = move |place, _| channel.map_or(0.0, |(volume, slot)| volume.at(slot, place));
        Lamp { place: space.stars[*star], sent, depth: Box::new(depth), window_pc: None }
    };
    stars.iter().map(lamp).collect()
}

impl Medium<'_> {
    /// The light of all orders below the bounces of its `origin`; by the first of the `sweepers` that can.
    fn solve(
        &self,
        space: &Space,
        origin: Origin,
        (k, gathering): (&Octet, Option<Gathering>),
        (sweepers, control): (&Sweepers, &Control),
    ) -> Result<Solved> {
        if origin.bounces == 1 {
            let moments = Moments::dark(0, self.count);
            return Ok(Solved { origin, moments, sweeps: 0, series: 0.0, settled: true, by: Processor.name().into() });
        }
        let scattering = scattering(self.terms);
        let Lamps { glow, around, .. } = &origin.lamps;
        let transfer =
            Transfer { cells: self.cells, k, faces: self.faces, scattering: &scattering[..self.count], glow: glow.as_deref(), around };
        let ((moments, course), by) = sweepers.run(|sweeper| {
            let first = self.first(space, &origin.lamps, (k, gathering), &control.part((0.0, FIRST_SHARE)))?;
            orders(sweeper, transfer, first, origin.bounces, &control.part((FIRST_SHARE, 1.0)))
        })?;
        let (series, _) = course.rest(origin.bounces);
        let (sweeps, settled) = (course.orders.len(), course.is_known() || course.orders.len() + 1 == origin.bounces);
        Ok(Solved { origin, moments, sweeps, series, settled, by })
    }

    /// Moments of light that has not been scattered yet.
    fn first(&self, space: &Space, lamps: &Lamps, (k, gathering): (&Octet, Option<Gathering>), control: &Control) -> Result<Moments> {
        let dark = || Ok(Moments::dark(self.cells.lattice.cells(), self.count));
        let mut first = gathering.map_or_else(dark, |g| g.moments(self.cells, self.count, control))?;
        if let Some(dust) = &space.dust {
            self.cells.direct(dust, |_| marched(space, &lamps.stars), k, &mut first, control)?;
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
) -> std::result::Result<(Moments, Course), Failure> {
    let mut orders = sweeper.start(transfer, first)?;
    let mut course = Course::default();
    for sweeps in 1..bounces.min(MOST_SWEEPS + 1) {
        let (own, sum) = orders.next(control)?;
        if !own.iter().chain(&sum).all(|power| power.is_finite()) {
            return Err(Failure::Unable("it comes to no number, since densities or lights are too large or too small".into()));
        }
        course.push(own, sum);
        control.report(Stage::Light, sweeps as u64, course.expected(bounces));
        if course.is_known() {
            break;
        }
    }
    let (_, rest) = course.rest(bounces);
    Ok((orders.sum(&rest)?, course))
}
