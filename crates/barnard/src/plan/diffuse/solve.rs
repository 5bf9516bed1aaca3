//! Orders of scattering, one after the other, for all nodes of a plan.

use std::sync::Arc;

use spectra::rule::{Form, Node};

use super::course::Course;
use super::directions::{Face, faces};
use super::harmonics::{DEGREE, count, legendre_moments};
use super::lamps::Lamps;
use super::medium::Cells;
use super::moments::Moments;
use super::sweep::{Sources, sweep};
use super::{Diffuse, Fineness, Found, Octet, Part, Term, View, WIDTH, scattering};
use crate::control::{Control, Stage};
use crate::error::{Error, Result};
use crate::field::Grid;
use crate::formats::check_memory;
use crate::light::Light;
use crate::plan::{BandPlan, Options, Space, Spectral};
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
    pub options: &'a Options,
    pub terms: Vec<Term>,
}

impl Problem<'_> {
    /// As many cells as `fineness` says, or as the memory limit lets be; the bytes of all, and whether it was the limit.
    pub fn fitting(&self, dust: &Grid, fineness: Fineness) -> Result<(Cells, u64, bool)> {
        let harmonics = count(kept_degree(&self.terms, fineness));
        let parts = self.terms.len().div_ceil(WIDTH) as u64;
        // All orders of each part, two orders of one, and what the march reads.
        let bytes_of = |cells: &Cells| {
            let count = cells.lattice.cells();
            let field = Moments::bytes(count, harmonics).saturating_mul(2 + parts).saturating_add(4 * (count * self.terms.len()) as u64);
            let glow = if self.space.gas().is_empty() { 0 } else { Moments::bytes(count, 1) };
            // A quarter more for the halves beside it.
            (field + glow) / 4 * 5
        };
        let (limit, space) = (self.options.memory_limit, self.space.bytes());
        let mut edge = fineness.cells;
        let mut cells = Cells::new(dust, self.space.gas(), edge);
        while bytes_of(&cells) > limit.saturating_sub(space) && edge > FEWEST {
            edge = (3 * edge / 4).max(FEWEST);
            cells = Cells::new(dust, self.space.gas(), edge);
        }
        let bytes = bytes_of(&cells);
        check_memory("the field of light that is scattered more than once", space + bytes, limit)?;
        Ok((cells, bytes, edge < fineness.cells))
    }

    /// The field in `cells`, seen by the scene's camera.
    pub fn solve(&self, cells: Cells, fineness: Fineness, control: &Control) -> Result<Diffuse> {
        let degree = kept_degree(&self.terms, fineness);
        let glow: Vec<Vec<f32>> = self.space.gas().iter().map(|gas| cells.means(gas)).collect();
        let faces = faces(fineness.directions);
        let (mut field, mut sweeps, mut series, mut settled) = (Vec::new(), 0, 0.0f64, true);
        for (p, own) in self.terms.chunks(WIDTH).enumerate() {
            let medium = Medium { cells: &cells, count: count(degree), faces: &faces, terms: own };
            let lamps = Lamps::new(self.lights, self.spectral, (p * WIDTH, own), &glow);
            let solved = medium.solve(self.space, &lamps, self.options.method.bounces, control)?;
            (sweeps, series) = (sweeps.max(solved.sweeps), series.max(solved.series));
            settled &= solved.settled;
            field.push(Part { terms: own.to_vec(), moments: solved.moments, unit: lamps.unit });
        }
        let directions = faces.iter().map(|f| f.directions.len()).sum();
        let found = Found { cells: cells.lattice.dims, coarser: false, directions, degree, sweeps, series, settled, doubt: None, bytes: 0 };
        Ok(Diffuse::resolved(Arc::new(cells), Arc::new(field), found, View::of(&self.scene.camera)))
    }
}

/// The highest degree that any phase function still has something of: moments of the light above it scatter into nothing.
fn kept_degree(terms: &[Term], fineness: Fineness) -> usize {
    // What so few directions tell apart.
    let most = fineness.degree.min(if fineness.directions > 2 { DEGREE } else { 2 });
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
    match &band.rule.form {
        Form::Nodes(nodes) => Ok(&nodes.nodes),
        _ => Err(Error::OneBounce("this spectral method".into(), "a method of nodes such as band_quadrature")),
    }
}

/// What light meets.
struct Medium<'a> {
    cells: &'a Cells,
    /// Harmonics that are kept.
    count: usize,
    faces: &'a [Face],
    terms: &'a [Term],
}

/// A field that was found.
struct Solved {
    moments: Moments,
    sweeps: usize,
    series: f64,
    settled: bool,
}

impl Medium<'_> {
    /// The light of all orders below `bounces`.
    fn solve(&self, space: &Space, lamps: &Lamps, bounces: usize, control: &Control) -> Result<Solved> {
        let k: Octet = std::array::from_fn(|t| self.terms.get(t).map_or(0.0, |term| term.k as f32));
        let scattered = scattering(self.terms);
        let mut order = Moments::dark(self.cells.lattice.cells(), self.count);
        let (mut all, mut next) = (order.clone(), order.clone());
        self.cells.direct(space, &lamps.stars, &k, &mut order, control)?;
        let mut course = Course::default();
        for sweeps in 1..bounces.min(MOST_SWEEPS + 1) {
            order.scatter(&scattered);
            next.data.fill([0.0; WIDTH]);
            let first = sweeps == 1;
            let glow = lamps.glow.as_deref().filter(|_| first);
            let around = if first { lamps.around } else { [0.0; WIDTH] };
            sweep(self.cells, &k, self.faces, &Sources { scattered: &order, glow, around }, &mut next, control)?;
            all.add(&next, &[1.0; WIDTH]);
            std::mem::swap(&mut order, &mut next);
            let (own, sum) = (self.power(&order), self.power(&all));
            if !own.iter().chain(&sum).all(|power| power.is_finite()) {
                let message = "light that is scattered more than once comes to no number here: densities or lights are too large or too small; write bounces = 1";
                return Err(Error::Render(message.into()));
            }
            course.push(own, sum);
            control.report(Stage::Light, sweeps as u64, course.expected(bounces));
            if course.is_known() {
                break;
            }
        }
        let (series, rest) = course.rest(bounces);
        all.add(&order, &rest);
        let settled = course.is_known() || course.orders.len() + 1 == bounces;
        Ok(Solved { moments: all, sweeps: course.orders.len(), series, settled })
    }

    /// Fluence in the dust, for each term.
    fn power(&self, moments: &Moments) -> [f64; WIDTH] {
        let mut power = [0.0; WIDTH];
        for (fluence, sigma) in moments.data.iter().step_by(self.count).zip(&self.cells.sigma) {
            power.iter_mut().zip(fluence).for_each(|(p, m)| *p += f64::from(*sigma) * f64::from(*m));
        }
        power
    }
}
