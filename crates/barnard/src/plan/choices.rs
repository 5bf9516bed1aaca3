//! Choices shared by many plans, so that pictures of a sequence differ by their content alone.
//!
//! Pilot rays choose steps, star depths, samples of functions and rules by the picture that is asked for. Two neighbouring
//! frames may come to two choices, each within the accuracy, and the step from one to the other is seen. [`Choices`] are
//! those of some plans together, the finest of each; a plan made by them ([`Quality::Chosen`](super::Quality::Chosen)) has no pilots of its own.

use super::spectral::RuleTarget;
use super::{Fineness, Plan, Stepping};
use crate::image::{ScatteringError, SpatialError};

/// Choices of the pilot rays.
#[derive(Debug, Clone, PartialEq)]
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
    pub spatial: Option<SpatialError>,
    /// How finely light that was scattered before is solved; none where it is not.
    pub scattered_fineness: Option<Fineness>,
    /// The errors of light that was scattered before, and of that of the gathered stars, where they were measured: the worst.
    pub scattered: (Option<ScatteringError>, Option<f64>),
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
            scattered_fineness: plan.scattered_field.as_ref().map(|field| field.fineness()),
            scattered: plan
                .scattered_field
                .as_ref()
                .map_or((None, None), |field| (field.report.error_estimate, field.report.far_field.and_then(|far| far.error))),
        }
    }

    /// The finer ones of two, with the larger error.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let stepping = if other.stepping.density() > self.stepping.density() { other.stepping } else { self.stepping };
        let spatial = match (self.spatial, other.spatial) {
            (Some(a), Some(b)) => Some(SpatialError { stepping, rays: a.rays + b.rays, ..if b.error > a.error { b } else { a } }),
            (a, b) => a.or(b),
        };
        Self {
            stepping,
            star_factor: self.star_factor.max(other.star_factor),
            sampled_edge: self.sampled_edge.max(other.sampled_edge),
            rules: RuleTarget { accuracy: self.rules.accuracy.min(other.rules.accuracy), depth: self.rules.depth.max(other.rules.depth) },
            spatial,
            scattered_fineness: match (self.scattered_fineness, other.scattered_fineness) {
                (Some(a), Some(b)) => Some(a.and(b)),
                (a, b) => a.or(b),
            },
            scattered: {
                let part = |quantity: fn(&ScatteringError) -> f64| {
                    larger(self.scattered.0.as_ref().map(quantity), other.scattered.0.as_ref().map(quantity))
                };
                let both = part(|e| e.spatial).zip(part(|e| e.angular));
                let estimate = both.map(|(spatial, angular)| ScatteringError { spatial, angular });
                (estimate, larger(self.scattered.1, other.scattered.1))
            },
        }
    }
}
