//! What many plans hold to, so that pictures of one sequence differ by what they show alone.
//!
//! Pilot rays choose steps, star depths, samples of functions and rules by the picture that is asked for. Two neighbouring
//! frames may come to two choices, each within the accuracy, and the step from one to the other is seen. [`Choices`] are
//! those of some plans together, the finest of each; a plan that holds to them has no pilots of its own.

use std::sync::Arc;

use super::draft::{Draft, detail};
use super::spectral::RuleTarget;
use super::{ErrorEstimate, Options, Plan, Settings, Spatial, SpatialPlan, SpectralPlan, Stepping};
use crate::control::Control;
use crate::error::Result;
use crate::scene::Scene;

/// What pilot rays chose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choices {
    /// The steps along a ray.
    pub stepping: Stepping,
    /// Star depth voxels along a voxel of dust.
    pub star_factor: usize,
    /// Voxels along the longest edge of the function that is sampled most coarsely; none where nothing is sampled.
    pub sampled_edge: Option<usize>,
    /// The accuracy of spectral rules, and the optical depth for which they are made.
    pub rules: RuleTarget,
    /// The spatial error that was measured: the worst.
    pub spatial: Option<Spatial>,
    /// The errors of light that was scattered before, and of that of the gathered stars, where they were measured: the worst.
    pub scattered: (Option<ErrorEstimate>, Option<f64>),
}

/// The larger of two numbers, where there are any.
fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (a, b) => a.or(b),
    }
}

impl Choices {
    /// The choices of a plan.
    pub fn of(plan: &Plan) -> Self {
        let space = &plan.space;
        Self {
            stepping: plan.stepping,
            star_factor: space.star_factor,
            sampled_edge: space.sampled_edge(),
            rules: RuleTarget { accuracy: plan.spectral.rule_accuracy, depth: plan.spectral.depth },
            spatial: space.spatial,
            scattered: plan
                .scattered_field
                .as_ref()
                .map_or((None, None), |field| (field.report.error_estimate, field.report.far_field.and_then(|far| far.error))),
        }
    }

    /// The finer ones of two, with the larger error.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let stepping = if other.stepping.density() > self.stepping.density() { other.stepping } else { self.stepping };
        let spatial = match (self.spatial, other.spatial) {
            (Some(a), Some(b)) => Some(Spatial { stepping, rays: a.rays + b.rays, ..if b.error > a.error { b } else { a } }),
            (a, b) => a.or(b),
        };
        Self {
            stepping,
            star_factor: self.star_factor.max(other.star_factor),
            sampled_edge: self.sampled_edge.max(other.sampled_edge),
            rules: RuleTarget { accuracy: self.rules.accuracy.min(other.rules.accuracy), depth: self.rules.depth.max(other.rules.depth) },
            spatial,
            scattered: {
                let part = |of: fn(&ErrorEstimate) -> f64| larger(self.scattered.0.as_ref().map(of), other.scattered.0.as_ref().map(of));
                let both = part(|e| e.spatial).zip(part(|e| e.angular));
                let estimate = both.map(|(spatial, angular)| ErrorEstimate { spatial, angular });
                (estimate, larger(self.scattered.1, other.scattered.1))
            },
        }
    }
}

impl Plan {
    /// Plans `scene` by choices that are made already, with the same bits from what another plan by the same choices has
    /// that still holds. What it states of its spatial error is what those say.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn holding(before: Option<&Self>, scene: &Scene, options: &Options, choices: &Choices, control: &Control) -> Result<Self> {
        scene.check()?;
        let settings = &Settings::of(scene, options);
        let lights = crate::light::lights(scene)?;
        // A light field stands in place of star depths, which are gone; dust that became more by a ratio is rounded otherwise
        // than dust that was sampled so.
        let known = before.filter(|plan| plan.light_field.is_none() && plan.space.has_as_much_dust_as(scene));
        let kept = known.map(|plan| plan.space.updated(scene, settings, control)).transpose()?.flatten();
        let kept_detail = before.filter(|_| kept.is_some()).and_then(|plan| plan.detail.clone());
        let mut space = kept.map_or_else(|| SpatialPlan::new(scene, settings, control).map(Arc::new), Ok)?;
        let detail = kept_detail.filter(|kept| Some(&kept.said) == scene.detail.as_ref()).or_else(|| detail(scene, &space));
        if let Some(edge) = choices.sampled_edge.filter(|edge| space.sampled_edge().is_some_and(|own| own < *edge))
            && let Some(finer) = space.resampled(scene, edge, settings, control)?
        {
            space = Arc::new(finer);
        }
        if space.star_factor != choices.star_factor {
            Arc::make_mut(&mut space).refine_stars(choices.star_factor, settings, control)?;
        }
        if space.spatial != choices.spatial {
            Arc::make_mut(&mut space).spatial = choices.spatial;
        }
        space.check_stars(scene)?;
        let spectral = SpectralPlan::with_rules(scene, &lights, &space, settings, choices.rules, control)?;
        spectral.check_strength(&lights)?;
        let draft = Draft { scene, settings, lights: Arc::new(lights), space, spectral: Arc::new(spectral), detail };
        let light_field = draft.light_field(control)?;
        let mut plan = draft.plan(choices.stepping, light_field, before.and_then(|plan| plan.scattered_field.as_deref()), control)?;
        if let Some(field) = &mut plan.scattered_field {
            // What was measured of one camera's picture is not said of another's.
            let report = &mut Arc::make_mut(field).report;
            report.error_estimate = choices.scattered.0;
            if let Some(far_field) = &mut report.far_field {
                far_field.error = choices.scattered.1;
            }
        }
        Ok(plan)
    }
}
