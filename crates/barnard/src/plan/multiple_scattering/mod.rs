//! The field of scattered light: light that was scattered, or sent out by gas, as it is before it scatters towards the
//! eye.
//!
//!   S_t(x, n) = ω_t Σ_l p_lt Σ_m Y_lm(n) L_lm,t(x),   L = Σ_(i=1)^(N−1) Λ_t^i D
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | t: a node of a passband's rule, which is monochromatic transport | term | |
//! | L_lm: moments of the radiance, R dλ included | `moments` | W m⁻² sr⁻¹ |
//! | D: light of stars as it comes through the dust, and of gas and background | `SweepCells::direct`, `DirectSources` | W m⁻² sr⁻¹ |
//! | Λ: one scattering, then a [`sweep`] | | 1 |
//! | S: source function towards n | `volumes` | W m⁻² sr⁻¹ |
//! | N: how often light may scatter | `bounces` | |
//!
//! This is eq. (22) of docs/method.md. The march reads S, which is smooth, beside σ, which is not: ΔI = k σ S Δs.
//! Starlight that scatters once is not in it, but that of the gathered stars (`far_field`): the march has it exactly,
//! with the phase function itself. Orders of scattering are summed until what is left goes as a geometric series, whose
//! rest is added.
//!
//! Valid where light is nearly diffuse after its first scattering. Left out: gas farther from the dust's box than half
//! its size, the change of S within a cell around an eye that is inside the dust, moments of the radiance above degree
//! five, structure of the dust within a cell.

mod beam;
mod cells;
mod direct_sources;
mod directions;
mod far_field;
mod field;
mod harmonics;
mod kernels;
mod lanes;
mod mirrors;
mod moments;
mod neumann_series;
mod problem;
mod processor;
mod report;
mod solve;
mod spot_check;
mod sweep;
pub(in crate::plan) mod sweeper;
mod term;
mod view;

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use self::field::{EightTerms, Field};
use self::harmonics::{DEGREE, harmonics};
use self::lanes::{EightLanes, WIDTH};
use self::moments::Moments;
use self::problem::{Fitting, Problem};
pub use self::report::{FarFieldReport, ScatteringReport};
use self::solve::{Discretization, Solution};
use self::spot_check::FirstLight;
use self::term::scattering;
use self::view::Viewpoint;
use super::SpectralPlan;
use super::draft::Draft;
use crate::camera::Camera;
use crate::control::Control;
use crate::error::Result;
use crate::image::ScatteringError;
use crate::plan::many_lights::near_field_kernel::{NearFieldKernel, Profile};
use crate::scene::Method;
use crate::volume::{Channel, Volume};

/// Interface for devices that sweep orders of scattering.
pub mod ordinates {
    pub use super::beam::{Beam, beam};
    pub use super::cells::SweepCells;
    pub use super::directions::{Face, across, faces};
    pub use super::lanes::{EightLanes, Powers, WIDTH};
    pub use super::moments::Moments;
    pub use super::processor::{Processor, Sweepers};
    pub use super::sweep::THIN_CELL;
    pub use super::sweeper::{Failure, Orders, Sweeper, Transfer};
}

/// The fineness of a field of scattered light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    /// Most cells along an edge.
    pub cells: usize,
    /// Directions along each edge of a cube's face: of light that has scattered once, which comes from near the stars,
    /// and of all other.
    pub directions: [usize; 2],
    /// The highest degree of harmonics.
    pub degree: usize,
}

impl Fineness {
    /// The fineness of pictures that are to be right.
    pub const FULL: Self = Self { cells: 64, directions: [6, 3], degree: DEGREE };
    /// The fineness of previews while things move.
    pub const PREVIEW: Self = Self { cells: 24, directions: [4, 2], degree: 1 };
}

/// Directions of the field that estimates the error of the full one: fewer of the first order, more of the
/// others.
const OTHER: [usize; 2] = [4, 4];
/// Light of less is none, in parts of the brightest.
const FAINT: f32 = 1e-15;

/// The field of one scene, and how one camera sees it.
#[derive(Debug, Clone)]
pub struct MultipleScattering {
    /// S towards the eye, as many volumes of eight terms as it takes.
    pub volumes: Vec<Volume>,
    /// Largest S of each term, and what the gathered stars near a ray may add.
    pub largest: Vec<f32>,
    /// Depths from each gathered star towards the eye.
    pub profiles: Vec<Profile>,
    /// Report of the solution.
    pub report: ScatteringReport,
    field: Arc<Field>,
    /// The fields by which its error is known: half as fine, and with other directions.
    halves: Option<Arc<(Self, Self)>>,
    /// The eye for which the volumes hold.
    view: Viewpoint,
}

/// Refuses more than one bounce by rules that have no nodes.
///
/// # Errors
/// That is [`OneBounce`](crate::Error::OneBounce).
pub(super) fn check(spectral: &SpectralPlan, method: &Method) -> Result<()> {
    let mut bands = spectral.bands.iter().filter(|_| method.bounces > 1);
    bands.try_for_each(|band| problem::nodes(band).map(|_| ()))
}

/// About the part of the work that a field half as fine takes.
const HALF_SHARE: f64 = 0.1;

impl MultipleScattering {
    /// The field of a draft for its scene's camera; none where light scatters once and no stars are gathered, or nothing
    /// scatters. What another field was found from is not solved again.
    ///
    /// # Errors
    /// For rules that have no nodes, more memory than is allowed, and on interruption by the user.
    pub(crate) fn new(draft: &Draft, fineness: Fineness, before: Option<&Self>, control: &Control) -> Result<Option<Self>> {
        let Some(problem) = Problem::new(draft)? else { return Ok(None) };
        let Fitting { cells, bytes, coarser } = problem.fitting(fineness)?;
        let kernels = &problem.kernels(&cells);
        let view = Viewpoint::of(&draft.scene.camera);
        // Half as fine, then with other directions too: what that changes says how exact the field is, at a part of its
        // price.
        let (halves, begun) = if fineness == Fineness::FULL && problem.scatters_again() {
            let known = before.and_then(|b| b.halves.as_deref());
            let half = |fineness: Fineness, before: Option<&Self>, control: &Control| -> Result<Self> {
                let most = cells.lattice.dims.into_iter().max().unwrap_or(1) / 2;
                let Solution { field, report } =
                    problem.solve(Discretization { cells: problem.cells(most.max(1)), fineness, kernels }, before, control)?;
                Ok(Self::resolved(Arc::new(field), Vec::new(), report, view))
            };
            let other = Fineness { directions: OTHER, ..fineness };
            let solved = half(fineness, known.map(|k| &k.0), &control.part(0.0, HALF_SHARE))?;
            (Some((solved, half(other, known.map(|k| &k.1), &control.part(HALF_SHARE, 2.0 * HALF_SHARE))?)), 2.0 * HALF_SHARE)
        } else {
            (None, 0.0)
        };
        let Solution { field, mut report } =
            problem.solve(Discretization { cells, fineness, kernels }, before, &control.part(begun, 1.0))?;
        (report.bytes, report.coarser) = (bytes, coarser);
        let field = Arc::new(field);
        let seen = field.far_field(view, control)?;
        if let (Some(far_field), Fineness::FULL) = (&mut report.far_field, fineness) {
            far_field.error =
                spot_check::error(&FirstLight { field: &field, far: &seen, near: &field.profiles(view), view }, draft, control)?;
        }
        let halves = halves.filter(|(half, _)| half.field.cells.lattice.dims != field.cells.lattice.dims);
        let mut made = Self::resolved(field, seen, report, view);
        made.report.error_estimate = halves.as_ref().map(|(half, other)| {
            // Of light that was scattered before, alone.
            let alone = made.field.many_lights.as_ref().map(|_| made.scattered_before());
            ScatteringError { spatial: half.differs_from(alone.as_ref().unwrap_or(&made)), angular: other.differs_from(half) }
        });
        made.halves = halves.map(Arc::new);
        Ok(Some(made))
    }

    /// Copy of the field without the first light of the gathered stars.
    fn scattered_before(&self) -> Self {
        Self::resolved(self.field.clone(), Vec::new(), self.report.clone(), self.view)
    }

    /// True if the light that was scattered before is shared with another field, and was not solved again.
    pub fn shares(&self, other: &Self) -> bool {
        let pairs = || self.field.parts.iter().zip(&other.field.parts);
        self.field.parts.len() == other.field.parts.len() && pairs().all(|(a, b)| Arc::ptr_eq(&a.solved, &b.solved))
    }

    /// Copy of the field as `camera` sees it; the same volumes where that sees the same directions.
    ///
    /// # Errors
    /// On interruption by the user.
    pub fn seen_by(self: &Arc<Self>, camera: &Camera, control: &Control) -> Result<Arc<Self>> {
        let view = Viewpoint::of(camera);
        if view == self.view {
            return Ok(self.clone());
        }
        let seen = self.field.far_field(view, control)?;
        Ok(Arc::new(Self { halves: self.halves.clone(), ..Self::resolved(self.field.clone(), seen, self.report.clone(), view) }))
    }

    /// The kernels around the gathered stars, within which their light is marched.
    pub fn kernels(&self) -> &[NearFieldKernel] {
        &self.field.kernels
    }

    /// The direction from a place towards the eye.
    pub fn towards_eye(&self, place: DVec3) -> DVec3 {
        self.view.towards(place)
    }

    /// S of every term towards the eye; `seen` is the far field of the gathered stars, part by part.
    fn resolved(field: Arc<Field>, seen: Vec<Moments>, report: ScatteringReport, view: Viewpoint) -> Self {
        let cells = &field.cells;
        let volume = |(p, part): (usize, &EightTerms)| {
            let channels: Vec<Channel> = (0..part.terms.len()).map(|t| Channel::MultipleScattering(p * WIDTH + t)).collect();
            let mut volume = Volume::zeroed(&cells.lattice, channels);
            let (lattice, dims) = (volume.lattice.clone(), cells.lattice.dims);
            let row = lattice.dims[0] * part.terms.len();
            let scattered = scattering(&part.terms);
            volume.single_mut().par_chunks_mut(row).enumerate().for_each(|(r, values)| {
                for (x, out) in values.chunks_exact_mut(part.terms.len()).enumerate() {
                    // The layer around is like the border.
                    let [_, y, z] = lattice.place(r * lattice.dims[0]);
                    let inside = |axis: usize, i: usize| i.saturating_sub(1).min(dims[axis] - 1);
                    let [x, y, z] = [inside(0, x), inside(1, y), inside(2, z)];
                    let cell = cells.lattice.index(x, y, z);
                    if !part.solved.moments.data.is_empty() {
                        let light = towards(part.solved.moments.cell(cell), &scattered, view.towards(cells.lattice.centre(x, y, z)));
                        out.iter_mut().zip(light).for_each(|(out, light)| *out = light * part.unit);
                    }
                    if let Some(seen) = seen.get(p) {
                        out.iter_mut().zip(seen.cell(cell)[0]).for_each(|(out, light)| *out += light * part.unit);
                    }
                }
            });
            volume
        };
        let mut volumes: Vec<Volume> = field.parts.iter().enumerate().map(volume).collect();
        let largest_of = |v: &Volume, c: usize| v.single().iter().skip(c).step_by(v.channels.len()).fold(0.0f32, |m, x| m.max(*x));
        let largest: Vec<f32> = volumes.iter().flat_map(|v| (0..v.channels.len()).map(move |c| largest_of(v, c))).collect();
        for (volume, largest) in volumes.iter_mut().zip(largest.chunks(WIDTH)) {
            let row = volume.channels.len();
            let faint = |(value, largest): (&mut f32, &f32)| *value = if *value > FAINT * largest { *value } else { 0.0 };
            volume.single_mut().par_chunks_mut(row * 4096).for_each(|values| {
                values.chunks_exact_mut(row).for_each(|cell| cell.iter_mut().zip(largest).for_each(faint));
            });
        }
        let near = field.parts.iter().flat_map(|part| part.near);
        let largest = largest.iter().zip(near).map(|(cell_light, near)| cell_light + near).collect();
        let profiles = field.profiles(view);
        Self { volumes, largest, profiles, report, field, halves: None, view }
    }

    /// Relative rms difference of S from that of a finer field, over the dust of this one's cells.
    fn differs_from(&self, finer: &Self) -> f64 {
        let lattice = &self.field.cells.lattice;
        let of_cell = |(cell, sigma): (usize, &f32)| {
            let [x, y, z] = lattice.place(cell);
            let place = lattice.centre(x, y, z);
            let channels = self.volumes.iter().zip(&finer.volumes).flat_map(|(a, b)| (0..a.channels.len()).map(move |c| (a, b, c)));
            let pairs = channels.map(|(a, b, c)| (a.at(c, place), b.at(c, place)));
            let sums = pairs.fold((0.0, 0.0), |(wrong, all), (a, b)| (wrong + (a - b).powi(2), all + b * b));
            (f64::from(*sigma) * sums.0, f64::from(*sigma) * sums.1)
        };
        let (wrong, all) = self.field.cells.sigma.iter().enumerate().map(of_cell).fold((0.0, 0.0), |s, c| (s.0 + c.0, s.1 + c.1));
        if all > 0.0 { (wrong / all).sqrt() } else { 0.0 }
    }

    /// The bytes that the field takes.
    pub fn bytes(&self) -> u64 {
        self.report.bytes
    }
}

/// Σ_lm Y_lm(n) Q_lm, not below zero: what a series that is cut lets swing there is no light.
fn towards(moments: &[EightLanes], scattered: &[EightLanes], n: DVec3) -> EightLanes {
    let mut light = [0.0; WIDTH];
    for ((y, moment), scattered) in harmonics(n).into_iter().zip(moments).zip(scattered) {
        for t in 0..WIDTH {
            light[t] += y as f32 * scattered[t] * moment[t];
        }
    }
    light.map(|l| l.max(0.0))
}
