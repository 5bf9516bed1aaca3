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
//! Few terms are solved, of which all are sums ([`reduction`]), in cells as fine as the picture needs, extrapolated to
//! cells of no size ([`refinement`]).
//!
//! Left out: gas farther from the dust's box than half its size, the change of S within a cell around an eye that is inside
//! the dust, structure of the dust within a cell, and moments of the radiance above degree five but for what [`closure`]
//! makes of those below.

mod beam;
mod cells;
mod closure;
mod direct_sources;
mod directions;
mod eye_source;
mod far_field;
mod field;
mod fineness;
mod harmonics;
mod kernels;
mod lanes;
mod level;
mod mirrors;
mod moments;
mod neumann_series;
mod pilot_light;
mod problem;
mod processor;
mod reduction;
mod refinement;
mod report;
mod rows;
mod solve;
mod solved;
mod spot_check;
mod sweep;
pub(in crate::plan) mod sweeper;
mod term;
mod view;

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use self::field::{EightTerms, Field};
pub use self::fineness::Fineness;
use self::lanes::WIDTH;
use self::moments::Moments;
pub(in crate::plan) use self::pilot_light::PilotLight;
use self::problem::Problem;
pub(in crate::plan) use self::refinement::Effort;
use self::refinement::{Refined, Refinement};
pub use self::report::{FarFieldReport, ScatteringReport};
use self::spot_check::FirstLight;
use self::view::Viewpoint;
use super::SpectralPlan;
use super::draft::Draft;
use crate::camera::Camera;
use crate::control::Control;
use crate::error::Result;
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

impl MultipleScattering {
    /// The field of a draft for its scene's camera; none where light scatters once and no stars are gathered, or nothing
    /// scatters. What another field was found from is not solved again.
    ///
    /// # Errors
    /// For rules that have no nodes, more memory than is allowed, and on interruption by the user.
    pub(in crate::plan) fn new(draft: &Draft, effort: Effort, before: Option<&Self>, control: &Control) -> Result<Option<Self>> {
        let Some(problem) = Problem::new(draft)? else { return Ok(None) };
        let reduction = problem.reduction(before, control)?;
        let refinement = Refinement { problem: &problem, reduction: &reduction, before, control };
        let Refined { levels, error, coarser, bytes } = refinement.levels(effort)?;
        let field = Arc::new(problem.field(levels, reduction));
        let view = Viewpoint::of(&draft.scene.camera);
        let seen = field.far_field(view, control)?;
        let is_estimate = matches!(effort, Effort::Estimated(_)) && problem.scatters_again();
        let mut report = ScatteringReport { error_estimate: error, coarser, is_estimate, bytes, ..problem.report(&field) };
        if let (Some(far_field), Effort::Measured(_) | Effort::Estimated(_)) = (&mut report.far_field, effort) {
            far_field.error =
                spot_check::error(&FirstLight { field: &field, far: &seen, near: &field.profiles(view), view }, draft, control)?;
        }
        Ok(Some(Self::resolved(field, seen, report, view)))
    }

    /// How finely it was solved.
    pub fn fineness(&self) -> Fineness {
        self.field.finest().fineness
    }

    /// True if the light that was scattered before is shared with another field, and was not solved again.
    pub fn shares(&self, other: &Self) -> bool {
        let solved = |field: &Self| field.field.finest().solved.clone();
        let (a, b) = (solved(self), solved(other));
        a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| Arc::ptr_eq(a, b))
    }

    /// Copy of the field as `camera` sees it; the same volumes where that sees the same directions within an angle \[rad\].
    ///
    /// # Errors
    /// On interruption by the user.
    pub fn seen_by(self: &Arc<Self>, camera: &Camera, angle: f64, control: &Control) -> Result<Arc<Self>> {
        let view = Viewpoint::of(camera);
        let bounds = self.field.finest().cells.lattice.bounds;
        if view == self.view || view.is_near(self.view, 0.5 * (bounds.low + bounds.high), angle) {
            return Ok(self.clone());
        }
        let seen = self.field.far_field(view, control)?;
        Ok(Arc::new(Self::resolved(self.field.clone(), seen, self.report.clone(), view)))
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
        let (cells, source) = (&field.finest().cells, field.towards(view));
        let volume = |(p, part): (usize, &EightTerms)| {
            let channels: Vec<Channel> = (0..part.terms.len()).map(|t| Channel::MultipleScattering(p * WIDTH + t)).collect();
            let mut volume = Volume::zeroed(&cells.lattice, channels);
            let (lattice, dims) = (volume.lattice.clone(), cells.lattice.dims);
            let row = lattice.dims[0] * part.terms.len();
            let shares = field.reduction.shares(p * WIDTH, part.terms.len());
            volume.single_mut().par_chunks_mut(row).enumerate().for_each(|(r, values)| {
                for (x, out) in values.chunks_exact_mut(part.terms.len()).enumerate() {
                    // The layer around is like the border.
                    let [_, y, z] = lattice.place(r * lattice.dims[0]);
                    let inside = |axis: usize, i: usize| i.saturating_sub(1).min(dims[axis] - 1);
                    let cell = cells.lattice.index(inside(0, x), inside(1, y), inside(2, z));
                    let mut light = [0.0; WIDTH];
                    for (share, value) in shares.iter().zip(source.groups.iter().flat_map(|group| group[cell])) {
                        (0..WIDTH).for_each(|t| light[t] += share[t] * value);
                    }
                    let seen = seen.get(p).map_or([0.0; WIDTH], |seen| seen.cell(cell)[0]);
                    // What a series that is cut lets swing below zero is no light.
                    let all = light.iter().zip(seen).map(|(light, seen)| (light.max(0.0) + seen) * field.unit);
                    out.iter_mut().zip(all).for_each(|(out, light)| *out = light);
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
        Self { volumes, largest, profiles, report, field, view }
    }

    /// The bytes that the field takes.
    pub fn bytes(&self) -> u64 {
        self.report.bytes
    }
}
