//! The diffuse field: light that was scattered, or sent out by gas, as it is before it scatters towards the eye.
//!
//!   S_t(x, n) = ω_t Σ_l p_lt Σ_m Y_lm(n) L_lm,t(x),   L = Σ_(i=1)^(N−1) Λ_t^i D
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | t: a node of a passband's rule, which is monochromatic transport | term | |
//! | L_lm: moments of the radiance, R dλ included | `moments` | W m⁻² sr⁻¹ |
//! | D: light of stars as it comes through the dust, and of gas and background | `Cells::direct`, `glow`, `around` | W m⁻² sr⁻¹ |
//! | Λ: one scattering, then a [`sweep`] | | 1 |
//! | S: source function towards n | `volumes` | W m⁻² sr⁻¹ |
//! | N: how often light may scatter | `bounces` | |
//!
//! This is eq. (22) of docs/method.md. The march reads S, which is smooth, beside σ, which is not: ΔI = k σ S Δs. Starlight that scatters once is not in it: the march
//! has it exactly, with the phase function itself. Orders of scattering are summed until what is left goes as a geometric series, whose rest is added.
//!
//! Valid where light is nearly diffuse after its first scattering. Left out: moments of the radiance above degree three, structure of the dust within a cell.

mod directions;
mod harmonics;
mod medium;
mod sweep;

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use spectra::rule::{Form, Node};

use self::directions::faces;
use self::harmonics::{COUNT, DEGREE, count, degree, harmonics, legendre_moments};
use self::medium::Cells;
use self::sweep::{Sources, sweep};
use super::volume::{Channel, MAX_CHANNELS, Volume};
use super::{BandPlan, Options, Space, Spectral};
use crate::camera::{Camera, Projection};
use crate::control::{Control, Stage};
use crate::error::{Error, Result};
use crate::formats::check_memory;
use crate::light::{Light, Path};
use crate::scene::Scene;

/// Terms that are swept side by side.
const WIDTH: usize = MAX_CHANNELS;
/// A number for each of them.
type Octet = [f32; WIDTH];

/// Moments of the radiance: cell × harmonic × term.
#[derive(Debug, Clone)]
struct Moments {
    /// Harmonics of a cell.
    count: usize,
    data: Vec<Octet>,
}

impl Moments {
    fn dark(cells: usize, count: usize) -> Self {
        Self { count, data: vec![[0.0; WIDTH]; cells * count] }
    }

    fn bytes(cells: usize, count: usize) -> u64 {
        (size_of::<Octet>() as u64).saturating_mul(cells as u64).saturating_mul(count as u64)
    }

    fn cell(&self, i: usize) -> &[Octet] {
        &self.data[i * self.count..][..self.count]
    }

    /// Adds what another has, by a factor for each term.
    fn add(&mut self, other: &Self, factor: &Octet) {
        self.data.par_iter_mut().zip(&other.data).with_min_len(4096).for_each(|(own, other)| {
            (0..WIDTH).for_each(|t| own[t] += factor[t] * other[t]);
        });
    }

    /// Scatters: moments become those of the source function.
    fn scatter(&mut self, scattering: &[Octet]) {
        self.data.par_chunks_mut(self.count).with_min_len(1024).for_each(|cell| {
            cell.iter_mut().zip(scattering).for_each(|(own, factor)| (0..WIDTH).for_each(|t| own[t] *= factor[t]));
        });
    }
}

/// How finely the field is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fineness {
    /// Most cells along an edge.
    pub cells: usize,
    /// Directions along each edge of a cube's face.
    pub directions: usize,
    /// Highest degree of harmonics.
    pub degree: usize,
}

impl Fineness {
    /// For pictures that are to be right.
    pub const FULL: Self = Self { cells: 64, directions: 3, degree: DEGREE };
    /// For a look while things move.
    pub const GLANCE: Self = Self { cells: 24, directions: 2, degree: 1 };
}

/// What is left of the orders that are not swept, as a part of all.
const REST: f64 = 1e-3;
/// Light of less is none, in parts of the brightest.
const FAINT: f32 = 1e-15;
/// Fewest cells along the longest edge that are worth it.
const FEWEST: usize = 12;
/// Moments of the phase function that are none.
const NEGLIGIBLE: f64 = 0.02;
/// Most sweeps.
const MOST_SWEEPS: usize = 400;

/// The field of one scene, and how one camera sees it.
#[derive(Debug, Clone)]
pub struct Diffuse {
    /// S towards the eye, as many volumes of eight terms as it takes.
    pub volumes: Vec<Volume>,
    /// Largest S of each term.
    pub largest: Vec<f32>,
    /// What there is to say of it.
    pub found: Found,
    field: Arc<Vec<Part>>,
    cells: Arc<Cells>,
    /// Where the eye is or looks, for which the volumes hold.
    view: View,
}

/// How the field was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Cells along each axis.
    pub cells: [usize; 3],
    /// Whether they are fewer than they should be, to keep to the memory limit.
    pub coarser: bool,
    /// Directions of light.
    pub directions: usize,
    /// Degree of the harmonics.
    pub degree: usize,
    /// Orders of scattering that were swept.
    pub sweeps: usize,
    /// The part of all that the geometric series behind them stands for, of the worst term.
    pub series: f64,
    /// Bytes that it takes.
    pub bytes: u64,
}

/// Eight terms of it.
#[derive(Debug)]
struct Part {
    terms: Vec<Term>,
    moments: Moments,
    /// What the moments are in parts of: radiances are so small that their faint ones would not be numbers.
    unit: f32,
}

/// A node as a medium.
#[derive(Debug, Clone, Copy)]
struct Term {
    k: f64,
    albedo: f64,
    legendre: [f64; DEGREE + 1],
}

/// What of a camera decides in which direction light leaves a place.
#[derive(Debug, Clone, Copy, PartialEq)]
enum View {
    From(DVec3),
    Along(DVec3),
}

impl View {
    fn of(camera: &Camera) -> Self {
        match camera.projection {
            Projection::Perspective { .. } => Self::From(camera.position),
            Projection::Orthographic { .. } => Self::Along(camera.forward),
        }
    }

    /// Towards the eye.
    fn towards(self, place: DVec3) -> DVec3 {
        match self {
            Self::From(eye) => (eye - place).normalize_or(DVec3::Z),
            Self::Along(forward) => -forward,
        }
    }
}

impl Diffuse {
    /// The field of `scene` for its camera; none where light scatters once, or nothing scatters.
    ///
    /// # Errors
    /// For rules that have no nodes, more memory than is allowed, and when the user wishes to stop.
    pub fn new(
        scene: &Scene,
        lights: &[Light],
        spectral: &Spectral,
        space: &Space,
        (options, fineness): (&Options, Fineness),
        control: &Control,
    ) -> Result<Option<Self>> {
        let bounces = options.method.bounces;
        let (Some(dust), true) = (&space.dust, bounces > 1) else { return Ok(None) };
        let terms = terms(scene, spectral)?;
        let degree = kept_degree(&terms, fineness.degree);
        let harmonics = count(degree);
        let parts = terms.len().div_ceil(WIDTH);
        // All orders of each part, two orders of one, and what the march reads.
        let bytes_of = |cells: &Cells| {
            let count = cells.lattice.cells();
            Moments::bytes(count, harmonics).saturating_mul(2 + parts as u64).saturating_add(4 * (count * terms.len()) as u64)
        };
        let left = options.memory_limit.saturating_sub(space.bytes());
        let (mut edge, mut cells) = (fineness.cells, Cells::new(dust, space.gas(), fineness.cells));
        while bytes_of(&cells) > left && edge > FEWEST {
            edge = (3 * edge / 4).max(FEWEST);
            cells = Cells::new(dust, space.gas(), edge);
        }
        let bytes = bytes_of(&cells);
        check_memory("the field of light that is scattered more than once", space.bytes() + bytes, options.memory_limit)?;
        let glow: Vec<Vec<f32>> = space.gas().iter().map(|gas| cells.means(gas)).collect();
        let faces = faces(fineness.directions);
        let (mut field, mut sweeps, mut series) = (Vec::new(), 0, 0.0f64);
        for (p, own) in terms.chunks(WIDTH).enumerate() {
            let medium = Medium { cells: &cells, count: harmonics, faces: &faces, terms: own };
            let lamps = Lamps::new(lights, spectral, (p * WIDTH, own), &glow);
            let solved = medium.solve(space, &lamps, bounces, control)?;
            (sweeps, series) = (sweeps.max(solved.sweeps), series.max(solved.series));
            field.push(Part { terms: own.to_vec(), moments: solved.moments, unit: lamps.unit });
        }
        let coarser = edge < fineness.cells;
        let found = Found {
            cells: cells.lattice.dims,
            coarser,
            directions: faces.iter().map(|f| f.directions.len()).sum(),
            degree,
            sweeps,
            series,
            bytes,
        };
        let (cells, field) = (Arc::new(cells), Arc::new(field));
        Ok(Some(Self::resolved(cells, field, found, View::of(&scene.camera))))
    }

    /// The same field as `camera` sees it; what it was if that sees the same directions.
    pub fn seen_by(self: &Arc<Self>, camera: &Camera) -> Arc<Self> {
        let view = View::of(camera);
        if view == self.view {
            return self.clone();
        }
        Arc::new(Self::resolved(self.cells.clone(), self.field.clone(), self.found, view))
    }

    /// S of every term towards the eye.
    fn resolved(cells: Arc<Cells>, field: Arc<Vec<Part>>, found: Found, view: View) -> Self {
        let volume = |(p, part): (usize, &Part)| {
            let channels: Vec<Channel> = (0..part.terms.len()).map(|t| Channel::Diffuse(p * WIDTH + t)).collect();
            let mut volume = Volume::zeroed(&cells.lattice, channels);
            let (lattice, dims) = (volume.lattice.clone(), cells.lattice.dims);
            let row = lattice.dims[0] * part.terms.len();
            let scattered = scattering(&part.terms);
            volume.data.par_chunks_mut(row).enumerate().for_each(|(r, values)| {
                for (x, out) in values.chunks_exact_mut(part.terms.len()).enumerate() {
                    // The layer around is like the border.
                    let [_, y, z] = lattice.place(r * lattice.dims[0]);
                    let inside = |axis: usize, i: usize| i.saturating_sub(1).min(dims[axis] - 1);
                    let [x, y, z] = [inside(0, x), inside(1, y), inside(2, z)];
                    let moments = part.moments.cell(cells.lattice.index(x, y, z));
                    let light = towards(moments, &scattered, view.towards(cells.lattice.centre(x, y, z)));
                    out.iter_mut().zip(light).for_each(|(out, light)| *out = light * part.unit);
                }
            });
            volume
        };
        let mut volumes: Vec<Volume> = field.iter().enumerate().map(volume).collect();
        let largest_of = |v: &Volume, c: usize| v.data.iter().skip(c).step_by(v.channels.len()).fold(0.0f32, |m, x| m.max(*x));
        let largest: Vec<f32> = volumes.iter().flat_map(|v| (0..v.channels.len()).map(move |c| largest_of(v, c))).collect();
        for (volume, largest) in volumes.iter_mut().zip(largest.chunks(WIDTH)) {
            let row = volume.channels.len();
            let faint = |(value, largest): (&mut f32, &f32)| *value = if *value > FAINT * largest { *value } else { 0.0 };
            volume.data.par_chunks_mut(row * 4096).for_each(|values| {
                values.chunks_exact_mut(row).for_each(|cell| cell.iter_mut().zip(largest).for_each(faint));
            });
        }
        Self { volumes, largest, found, field, cells, view }
    }

    /// Bytes of all of it.
    pub fn bytes(&self) -> u64 {
        self.found.bytes
    }
}

impl std::fmt::Display for Diffuse {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Found { cells: [x, y, z], coarser, directions, degree, sweeps, series, bytes } = self.found;
        write!(
            f,
            "{sweeps} orders of scattering swept in {x} x {y} x {z} cells and {directions} directions, moments to degree {degree}, {} MiB",
            bytes >> 20
        )?;
        if coarser {
            write!(f, " (more cells would not fit: give more --memory)")?;
        }
        write!(f, ", {:.1} % of this light by their geometric series; its spatial and angular error is unknown", 100.0 * series)
    }
}

/// Σ_lm Y_lm(n) Q_lm, not below zero: what a series that is cut lets swing there is no light.
fn towards(moments: &[Octet], scattered: &[Octet], n: DVec3) -> Octet {
    let mut light = [0.0; WIDTH];
    for ((y, moment), scattered) in harmonics(n).into_iter().zip(moments).zip(scattered) {
        for t in 0..WIDTH {
            light[t] += y as f32 * scattered[t] * moment[t];
        }
    }
    light.map(|l| l.max(0.0))
}

/// ω p_l of each harmonic and term.
fn scattering(terms: &[Term]) -> [Octet; COUNT] {
    std::array::from_fn(|h| std::array::from_fn(|t| terms.get(t).map_or(0.0, |term| (term.albedo * term.legendre[degree(h)]) as f32)))
}

/// The highest degree that any phase function still has something of: moments of the light above it scatter into nothing.
fn kept_degree(terms: &[Term], most: usize) -> usize {
    let has = |l: usize| terms.iter().any(|term| term.legendre[l].abs() > NEGLIGIBLE);
    (0..=most.min(DEGREE)).rev().find(|l| has(*l)).unwrap_or(0)
}

/// The nodes of all passbands.
fn terms(scene: &Scene, spectral: &Spectral) -> Result<Vec<Term>> {
    let Some(dust) = &scene.dust else { return Ok(Vec::new()) };
    let term =
        |node: &Node| Term { k: node.k, albedo: dust.albedo.at(node.lambda_um), legendre: legendre_moments(&*dust.phase, node.lambda_um) };
    let of_band = |band: &BandPlan| match &band.rule.form {
        Form::Nodes(nodes) => Ok(nodes.nodes.iter().map(term).collect::<Vec<Term>>()),
        _ => Err(Error::Render(format!(
            "method \"{}\" knows light that is scattered once: write bounces = 1, or take a method of nodes such as band_quadrature",
            spectral.method
        ))),
    };
    Ok(spectral.bands.iter().map(of_band).collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}

/// What shines, for eight terms, before it is scattered.
struct Lamps {
    /// Stars, and what each sends: weights without k ω.
    stars: Vec<(usize, Octet)>,
    /// Emission per length.
    glow: Option<Vec<Octet>>,
    around: Octet,
    /// Radiance that all this is in parts of.
    unit: f32,
}

impl Lamps {
    /// Of terms from `first` on.
    fn new(lights: &[Light], spectral: &Spectral, (first, terms): (usize, &[Term]), gas: &[Vec<f32>]) -> Self {
        let all = |light| spectral.bands.iter().flat_map(move |b: &BandPlan| b.rule.form.decay().weights(light)).copied();
        let extended = lights.iter().enumerate().filter(|(_, l)| !matches!(l.path, Path::Direct { .. } | Path::FieldStar { .. }));
        let unit = extended.flat_map(|(light, _)| all(light)).fold(f64::MIN_POSITIVE, |most, w| most.max(w.abs()));
        let mut lamps = Self { stars: Vec::new(), glow: None, around: [0.0; WIDTH], unit: (unit as f32).max(f32::MIN_POSITIVE) };
        for (light, l) in lights.iter().enumerate() {
            let weights: Vec<f64> = all(light).collect();
            let of = |t: usize| weights.get(first + t).map_or(0.0, |w| w / unit);
            match l.path {
                Path::Scattered { star } => {
                    let sent = |t: usize| terms.get(t).map_or(0.0, |term| term.k * term.albedo);
                    lamps.stars.push((star, std::array::from_fn(|t| if sent(t) > 0.0 { (of(t) / sent(t)) as f32 } else { 0.0 })));
                }
                Path::Emitted { species } => {
                    let own: Octet = std::array::from_fn(|t| of(t) as f32);
                    let glow = lamps.glow.get_or_insert_with(|| vec![[0.0; WIDTH]; gas[species].len()]);
                    glow.iter_mut().zip(&gas[species]).for_each(|(glow, density)| (0..WIDTH).for_each(|t| glow[t] += own[t] * density));
                }
                Path::Background => lamps.around = std::array::from_fn(|t| of(t) as f32),
                Path::Direct { .. } | Path::FieldStar { .. } => {}
            }
        }
        lamps
    }
}

/// What light meets.
struct Medium<'a> {
    cells: &'a Cells,
    /// Harmonics that are kept.
    count: usize,
    faces: &'a [directions::Face],
    terms: &'a [Term],
}

/// A field that was found.
struct Solved {
    moments: Moments,
    sweeps: usize,
    series: f64,
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
            course.push(self.power(&order), self.power(&all));
            control.report(Stage::Light, sweeps as u64, course.expected(bounces));
            if course.is_known() {
                break;
            }
        }
        let (series, rest) = course.rest(bounces);
        all.add(&order, &rest);
        Ok(Solved { moments: all, sweeps: course.orders.len(), series })
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

/// How the orders of scattering go.
#[derive(Default)]
struct Course {
    /// The power of each order, and of all up to it.
    orders: Vec<([f64; WIDTH], [f64; WIDTH])>,
}

impl Course {
    fn push(&mut self, own: [f64; WIDTH], all: [f64; WIDTH]) {
        self.orders.push((own, all));
    }

    /// The ratio of the last order to that before, and the last order as a part of all.
    fn last(&self, back: usize, t: usize) -> Option<(f64, f64)> {
        let at = self.orders.len().checked_sub(1 + back)?;
        let ((own, all), (before, _)) = (&self.orders[at], &self.orders[at.checked_sub(1)?]);
        (all[t] > 0.0 && before[t] > 0.0).then(|| (own[t] / before[t], own[t] / all[t]))
    }

    /// Whether the series that goes on from here is known well enough.
    fn is_known(&self) -> bool {
        let known = |t: usize| {
            let (Some((ratio, part)), Some((before, _))) = (self.last(0, t), self.last(1, t)) else {
                return self.orders.last().is_some_and(|(_, all)| all[t] <= 0.0);
            };
            // By how much the sum of the series may be wrong.
            ratio < 1.0 && part * (ratio - before).abs() / (1.0 - ratio).powi(2) < REST
        };
        (0..WIDTH).all(known)
    }

    /// What the series that goes on stands for, as a part of all, and in units of the last order.
    fn rest(&self, bounces: usize) -> (f64, Octet) {
        let left = bounces.saturating_sub(1 + self.orders.len());
        let (mut series, mut rest) = (0.0f64, [0.0; WIDTH]);
        for (t, rest) in rest.iter_mut().enumerate() {
            if let Some((ratio, part)) = self.last(0, t).filter(|_| left > 0) {
                let ratio = ratio.clamp(0.0, 0.9999);
                let sum = ratio * (1.0 - ratio.powf(left as f64)) / (1.0 - ratio);
                *rest = sum as f32;
                series = series.max(part * sum / (1.0 + part * sum));
            }
        }
        (series, rest)
    }

    /// How many orders there may be in all.
    fn expected(&self, bounces: usize) -> u64 {
        let ratio = (0..WIDTH).filter_map(|t| self.last(0, t)).map(|l| l.0).fold(0.1, f64::max).min(0.99);
        let part = (0..WIDTH).filter_map(|t| self.last(0, t)).map(|l| l.1).fold(0.0, f64::max).max(REST);
        let more = ((REST / part).ln() / ratio.ln()).max(0.0) as usize;
        (self.orders.len() + more).min(bounces - 1) as u64
    }
}
