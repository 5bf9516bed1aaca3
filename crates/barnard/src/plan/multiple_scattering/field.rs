//! A solved field of scattered light, independent of the eye.

use std::sync::Arc;

use super::eye_source::EyeSource;
use super::far_field::{FarField, Scattering};
use super::lanes::{EightLanes, WIDTH};
use super::level::Level;
use super::moments::Moments;
use super::reduction::Reduction;
use super::solved::Solved;
use super::term::Term;
use super::view::Viewpoint;
use crate::control::Control;
use crate::error::Result;
use crate::plan::many_lights::near_field_kernel::{NearFieldKernel, Profile};
use crate::plan::{ManyLights, PhaseTable};

/// A field of scattered light, independent of the eye.
#[derive(Debug)]
pub struct Field {
    /// All terms, eight by eight.
    pub parts: Vec<EightTerms>,
    /// Light that was scattered before, in ever smaller cells; one level at least.
    pub levels: Vec<Level>,
    /// The terms that are solved, of which all are sums.
    pub reduction: Arc<Reduction>,
    /// The radiance in units of which moments are stored: radiances are so small that faint ones would not be numbers.
    pub unit: f32,
    /// Stars whose first light is part of it, and how that is scattered.
    pub many_lights: Option<Arc<ManyLights>>,
    pub phase: Option<PhaseTable>,
    /// The kernels around them, within which their light is marched.
    pub kernels: Vec<NearFieldKernel>,
}

/// Eight terms of the field.
#[derive(Debug)]
pub struct EightTerms {
    pub terms: Vec<Term>,
    /// The most that the gathered stars near a ray may add to each term.
    pub near: EightLanes,
    /// The weights that the gathered stars send, without k ω, in parts of the unit.
    pub sent: Vec<EightLanes>,
}

impl Field {
    /// The finest level, in whose cells the field is.
    pub fn finest(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }

    /// All light that was solved for it, on the coarse lattice of its terms too.
    pub fn solved(&self) -> impl Iterator<Item = &Arc<Solved>> {
        self.levels.iter().flat_map(|level| &level.solved).chain(&self.reduction.coarse)
    }

    /// The level before, where that is coarser.
    pub fn coarser(&self) -> Option<&Level> {
        let before = self.levels.len().checked_sub(2).map(|level| &self.levels[level]);
        before.filter(|level| level.cells.lattice.dims != self.finest().cells.lattice.dims)
    }

    /// S of the solved terms towards the eye, in the finest cells.
    pub fn towards(&self, view: Viewpoint) -> EyeSource {
        let finest = self.finest().towards(view);
        match self.coarser() {
            Some(coarser) => finest.extrapolated(&coarser.towards(view)),
            None => finest,
        }
    }

    /// The gathered stars' light, scattered once, in each cell as one eye sees it, part by part; nothing where there
    /// are no such stars.
    pub fn far_field(&self, view: Viewpoint, control: &Control) -> Result<Vec<Moments>> {
        let Some(many_lights) = &self.many_lights else { return Ok(Vec::new()) };
        let terms = self.parts.iter().map(|part| part.terms.len()).sum();
        let of_part = |(p, part): (usize, &EightTerms)| {
            let four = |value: fn(&Term) -> f64| std::array::from_fn(|t| part.terms.get(t).map_or(0.0, |term| value(term) as f32));
            let (k, albedo) = (four(|term| term.k), four(|term| term.albedo));
            let far_field = FarField { many_lights, sent: &part.sent, k: &k, kernels: &self.kernels };
            let scattering = Scattering { view, phase: self.phase.as_ref(), first: p * WIDTH, terms, albedo };
            far_field.seen(&self.finest().cells, &scattering, control)
        };
        self.parts.iter().enumerate().map(of_part).collect()
    }

    /// Depths from each gathered star towards the eye, as far as kernels go.
    pub fn profiles(&self, view: Viewpoint) -> Vec<Profile> {
        self.many_lights.as_ref().map_or_else(Vec::new, |many_lights| many_lights.profiles(&self.kernels, |place| view.towards(place)))
    }
}
