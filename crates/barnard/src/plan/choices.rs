//! Choices shared by many plans, so that pictures of a sequence differ by their content alone.
//!
//! Pilot rays choose steps, star depths, samples of functions and rules by the picture that is asked for. Two neighbouring
//! frames may come to two choices, each within the accuracy, and the step from one to the other is seen. [`Choices`] are
//! those of some plans together, the finest of each; a plan made by them ([`Quality::Chosen`](super::Quality::Chosen)) has no pilots of its own.

use super::spectral::RuleTarget;
use super::{Fineness, Plan, Stepping};
use crate::detail::Roughness;
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
    /// Roughness by which `[detail]` continues each density, the largest of all pilots; empty without `[detail]`. Measured per frame,
    /// it makes the noise flicker while gas moves.
    pub roughness: Vec<Roughness>,
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
            roughness: plan.detail.as_ref().map_or_else(Vec::new, |detail| detail.roughness.clone()),
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
            roughness: {
                let rougher = |(a, b): (&Roughness, &Roughness)| if b.deviation > a.deviation { *b } else { *a };
                let is_same = self.roughness.len() == other.roughness.len();
                if is_same { self.roughness.iter().zip(&other.roughness).map(rougher).collect() } else { self.roughness.clone() }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::control::Control;
    use crate::detail::Detail;
    use crate::field::{Field, Grid};
    use crate::fixtures::{dust, on_axis, scene, star};
    use crate::geometry::Bounds;
    use crate::plan::{Options, Planner, Quality};
    use crate::random::Counter;

    /// Frames of a film whose density changes are continued below their voxels by one roughness; planned one by one each has its own.
    #[test]
    fn noise_of_films_is_held() {
        let frame = |power: f64| {
            let mut random = Counter::nested(1, 2, 3);
            let bounds = Bounds { low: DVec3::splat(-1.0), high: DVec3::splat(1.0) };
            let values: Vec<f32> = (0..4096).map(|_| random.uniform().powf(power) as f32 + 0.1).collect();
            let grid: Arc<dyn Field> = Arc::new(Grid::new([16; 3], bounds, values).unwrap());
            let mut spec =
                scene(on_axis(4.0, 30.0, (4, 4)), 20).with_dust(dust(grid, "ccm89", 0.5)).with_star(star(9000.0, 1.0, DVec3::ZERO));
            (spec.detail, spec.method.accuracy) = (Some(Detail::default()), 0.1);
            spec.build().unwrap()
        };
        let (options, control) = (Options::default(), Control::default());
        let planned = |quality, power| Planner::new(&options).with_quality(quality).plan(frame(power), None, &control).unwrap();
        let roughness = |quality, power| planned(quality, power).detail.as_ref().unwrap().roughness.clone();
        let choices = Choices::of(&planned(Quality::Full, 1.0));
        let measured = roughness(Quality::Full, 2.0);
        let shared = roughness(Quality::Chosen(Box::new(choices.clone())), 2.0);
        assert!(shared == choices.roughness && measured != shared && measured.len() == 1, "{measured:?} {shared:?}");
        let rougher = choices.and(&Choices { roughness: measured.clone(), ..choices.clone() });
        assert_eq!(rougher.roughness[0].deviation, measured[0].deviation.max(shared[0].deviation));
    }
}
