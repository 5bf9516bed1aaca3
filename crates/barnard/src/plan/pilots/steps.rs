//! The steps of a ray that is marched in f64.

use crate::geometry::Ray;
use crate::plan::SpatialPlan;

/// The part of a step at whose ends an exact march looks within it: a field may jump where steps meet.
pub(super) const INSIDE: f64 = 1e-6;
/// Growth of the optical depth at V in a step of an exact march, and most parts of a step in which it grows by more.
const GROWTH: f64 = 0.1;
const MAX_PARTS: f64 = 4096.0;
/// Steps whose dust is looked at together.
const BLOCK: usize = 128;
/// The part of the places along a ray that lies evenly; the others lie where light comes from.
const EVEN: f64 = 0.4;

/// The end of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepEnd {
    /// Its distance \[pc\].
    pub(super) t: f64,
    /// True if a function jumps there.
    jump: bool,
    /// About how deep it lies in an exact march, once it is refined \[1\].
    depth: f64,
}

impl StepEnd {
    /// An end at which nothing jumps.
    pub(super) fn smooth(t: f64) -> Self {
        Self { t, jump: false, depth: 0.0 }
    }
}

/// The steps of a ray: where the first begins, and where each ends \[pc\].
pub(super) struct Steps {
    pub(super) near: f64,
    pub(super) ends: Vec<StepEnd>,
}

/// Start and end of a step, and which of the places that are looked at stand for its two ends.
pub(super) struct Step {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) before: usize,
    pub(super) after: usize,
    /// And for its middle, where that is looked at.
    pub(super) middle: Option<usize>,
}

impl Steps {
    /// The steps with the places at which they are looked at \[pc\]: the ends themselves.
    pub(super) fn at_ends(&self) -> (Vec<Step>, Vec<f64>) {
        let places = std::iter::once(self.near).chain(self.ends.iter().map(|end| end.t)).collect::<Vec<f64>>();
        let step = |(i, ends): (usize, &[f64])| Step { from: ends[0], to: ends[1], before: i, after: i + 1, middle: None };
        (places.windows(2).enumerate().map(step).collect(), places)
    }

    /// The steps with the places at which they are looked at \[pc\]: the ends, and the middles between them.
    pub(super) fn at_ends_and_middles(&self) -> (Vec<Step>, Vec<f64>) {
        let (mut steps, mut places) = (Vec::with_capacity(self.ends.len()), vec![self.near]);
        let mut from = self.near;
        for StepEnd { t, .. } in &self.ends {
            let before = places.len() - 1;
            places.extend([0.5 * (from + t), *t]);
            steps.push(Step { from, to: *t, before, after: before + 2, middle: Some(before + 1) });
            from = *t;
        }
        (steps, places)
    }

    /// The steps with the places at which they are looked at \[pc\]: the ends where fields go on, and a little within on
    /// either side of where they begin, end or jump.
    pub(super) fn within_ends(&self) -> (Vec<Step>, Vec<f64>) {
        let (mut steps, mut places) = (Vec::with_capacity(self.ends.len()), Vec::with_capacity(self.ends.len() + 2));
        let (mut from, mut jump) = (self.near, true);
        for (i, end) in self.ends.iter().enumerate() {
            let margin = INSIDE * (end.t - from);
            if jump {
                places.push(from + margin);
            }
            let before = places.len() - 1;
            jump = end.jump || i + 1 == self.ends.len();
            places.push(if jump { end.t - margin } else { end.t });
            steps.push(Step { from, to: end.t, before, after: places.len() - 1, middle: None });
            from = end.t;
        }
        (steps, places)
    }

    /// Cuts the steps of an exact march where functions jump, and where the depth grows fast, and leaves out
    /// those behind twice a depth of `enough`.
    pub(super) fn refine(&mut self, space: &SpatialPlan, ray: &Ray, enough: f64) {
        let (near, ends) = (self.near, &mut self.ends);
        let far = ends.last().map_or(near, |end| end.t);
        ends.extend(
            space.crossings(ray).into_iter().filter(|t| (near..far).contains(t)).map(|t| StepEnd { jump: true, ..StepEnd::smooth(t) }),
        );
        ends.sort_by(|a, b| a.t.total_cmp(&b.t));
        ends.dedup_by(|later, earlier| {
            let same = later.t - earlier.t <= 1e-12 * far;
            earlier.jump |= same && later.jump;
            same
        });
        let (mut fine, mut tau) = (Vec::with_capacity(ends.len()), 0.0);
        let starts = std::iter::once(near).chain(ends.iter().map(|end| end.t));
        // Blocks of steps: what lies behind enough dust is not asked for.
        let steps: Vec<(f64, StepEnd)> = starts.zip(ends.iter().copied()).collect();
        'blocks: for steps in steps.chunks(BLOCK) {
            let within = steps.iter().flat_map(|(from, end)| [INSIDE, 0.5, 1.0 - INSIDE].map(|u| ray.at(from + u * (end.t - from))));
            let sigma = space.dust_at(&within.collect::<Vec<_>>());
            for ((from, end), sigma) in steps.iter().zip(sigma.chunks_exact(3)) {
                let length = end.t - from;
                let parts = (sigma.iter().copied().fold(0.0, f64::max) * length / GROWTH).ceil().clamp(1.0, MAX_PARTS);
                let growth = length * (sigma[0] + 4.0 * sigma[1] + sigma[2]) / 6.0;
                for part in 1..=parts as usize {
                    let share = part as f64 / parts;
                    let end_of_part = if part == parts as usize { *end } else { StepEnd::smooth(from + length * share) };
                    fine.push(StepEnd { depth: tau + growth * share, ..end_of_part });
                }
                tau += growth;
                if tau > 2.0 * enough {
                    break 'blocks;
                }
            }
        }
        *ends = fine;
    }

    /// Chooses `count` places along refined steps: a part of them evenly, the others where light comes from, which falls
    /// with the depth.
    pub(super) fn places(&self, count: usize) -> Vec<f64> {
        let (near, ends) = (self.near, &self.ends);
        let (far, deepest) = ends.last().map_or((near, 0.0), |end| (end.t, end.depth));
        let seen = 1.0 - (-deepest).exp();
        let even = if seen > 0.0 { EVEN } else { 1.0 };
        let share = |t: f64, tau: f64| even * (t - near) / (far - near) + (1.0 - even) * (1.0 - (-tau).exp()) / seen.max(f64::MIN_POSITIVE);
        let (mut places, mut before) = (Vec::with_capacity(count), (near, 0.0));
        for StepEnd { t, depth, .. } in ends {
            let after = share(*t, *depth);
            while places.len() < count && (places.len() as f64 + 0.5) / count as f64 <= after {
                let part = ((places.len() as f64 + 0.5) / count as f64 - before.1) / (after - before.1);
                places.push(before.0 + part.clamp(0.0, 1.0) * (t - before.0));
            }
            before = (*t, after);
        }
        if places.is_empty() {
            places.push(0.5 * (near + far));
        }
        places
    }
}
