//! One segment of sixteen rays, between two samples.

use super::context::Context;
use super::state::{PacketState, StepSpan};
use crate::packet::{LANES, Lane, fma, lanes};

/// One segment of sixteen rays, with what it needs to be shaded.
pub(super) struct Segment<'a> {
    /// The steps it covers.
    pub span: StepSpan,
    /// Volume samples at its two ends, by slots.
    pub before: &'a [Lane],
    pub after: &'a [Lane],
    /// And in its middle, where it has a sample there.
    middle: Option<&'a [Lane]>,
    /// The length of the segment on each lane [pc].
    pub length: Lane,
    /// By how much the optical depth at V grows on it \[1\].
    pub growth: Lane,
    /// By how much it grows before the middle sample, where there is one \[1\].
    first: Lane,
    /// Shares of its gas that are on the ionised side of the front: of both halves, or of the whole without a middle sample \[1\].
    front: Option<[Lane; 2]>,
}

impl<'a> Segment<'a> {
    /// Makes the segment of a span from what the volumes hold at its ends.
    #[inline(always)]
    pub fn new(
        context: &Context,
        state: &PacketState,
        span: StepSpan,
        [before, after]: [&'a [Lane]; 2],
        middle: Option<&'a [Lane]>,
    ) -> Self {
        let length = lanes!(|lane| span.length * state.dt[lane]);
        let mut segment = Self { span, before, after, middle, length, growth: [0.0; LANES], first: [0.0; LANES], front: None };
        segment.front = context.slots.front.map(|front| segment.shares(front));
        if let Some(dust) = context.slots.dust {
            let twice = segment.twice_the_mean(dust);
            segment.growth = lanes!(|lane| 0.5 * length[lane] * twice[lane]);
            if let Some(middle) = middle {
                segment.first = lanes!(|lane| 0.25 * length[lane] * (before[dust][lane] + middle[dust][lane]));
            }
        }
        segment
    }

    /// The mean of what a slot holds over the light that the dust scatters: by σ, both linear between samples.
    #[inline(always)]
    pub fn mean_over_dust(&self, slot: usize, dust: usize) -> Lane {
        let (before, after) = (&self.before[slot], &self.after[slot]);
        let Some(middle) = self.middle else { return lanes!(|lane| 0.5 * (before[lane] + after[lane])) };
        let [s0, s1, s2] = [&self.before[dust], &middle[dust], &self.after[dust]];
        let (v0, v1, v2) = (before, &middle[slot], after);
        let mut mean = [0.0; LANES];
        for lane in 0..LANES {
            let all = fma(2.0, s1[lane], s0[lane] + s2[lane]);
            let ends = fma(s0[lane], fma(2.0, v0[lane], v1[lane]), s2[lane] * fma(2.0, v2[lane], v1[lane]));
            let sum = fma(s1[lane], fma(4.0, v1[lane], v0[lane] + v2[lane]), ends);
            mean[lane] = sum / if all > 0.0 { 3.0 * all } else { 1.0 };
        }
        mean
    }

    /// The mean depth from the segment's beginning of light that is sent along it, given two times what is sent on the
    /// whole and on the half before the middle sample \[1\].
    #[inline(always)]
    pub fn mean_depth(&self, all: &Lane, early: &Lane) -> Lane {
        if self.middle.is_none() {
            return lanes!(|lane| 0.5 * self.growth[lane]);
        }
        let mut depth = [0.0; LANES];
        for lane in 0..LANES {
            let share = early[lane] / if all[lane] > 0.0 { all[lane] } else { 1.0 };
            depth[lane] = fma(0.5 * self.growth[lane], 1.0 - share, 0.5 * self.first[lane]);
        }
        depth
    }

    /// Two times what a slot holds before the middle sample, in parts of the whole segment; nothing without that sample.
    #[inline(always)]
    pub fn twice_the_early(&self, slot: usize) -> Lane {
        match self.middle {
            None => [0.0; LANES],
            Some(middle) => lanes!(|lane| 0.5 * (self.before[slot][lane] + middle[slot][lane])),
        }
    }

    /// Mean shares of the halves, or of the whole without a middle sample, by the slot of u.
    #[inline(always)]
    fn shares(&self, front: usize) -> [Lane; 2] {
        let (before, after) = (&self.before[front], &self.after[front]);
        match self.middle {
            None => [mean_share(before, after), [0.0; LANES]],
            Some(middle) => [mean_share(before, &middle[front]), mean_share(&middle[front], after)],
        }
    }

    /// [Twice the mean](Self::twice_the_mean) and [twice the early](Self::twice_the_early) density of a gas that ends at the front.
    #[inline(always)]
    pub fn twice_the_glow(&self, slot: usize, has_front: bool) -> [Lane; 2] {
        let Some([first, second]) = self.front.as_ref().filter(|_| has_front) else {
            return [self.twice_the_mean(slot), self.twice_the_early(slot)];
        };
        let (before, after) = (&self.before[slot], &self.after[slot]);
        let Some(middle) = self.middle else { return [lanes!(|lane| first[lane] * (before[lane] + after[lane])), [0.0; LANES]] };
        let early = lanes!(|lane| 0.5 * first[lane] * (before[lane] + middle[slot][lane]));
        [lanes!(|lane| fma(0.5 * second[lane], middle[slot][lane] + after[lane], early[lane])), early]
    }

    /// Two times the mean of what a slot holds, which is linear between the places that are looked at.
    #[inline(always)]
    pub fn twice_the_mean(&self, slot: usize) -> Lane {
        let (before, after) = (&self.before[slot], &self.after[slot]);
        match self.middle {
            None => lanes!(|lane| before[lane] + after[lane]),
            Some(middle) => lanes!(|lane| fma(0.5, before[lane] + after[lane], middle[slot][lane])),
        }
    }
}

/// Change of u over a segment below which the value in the middle replaces the mean.
pub const EVEN_FRONT: f32 = 1e-2;

/// Mean of min(max(u, 0), 1) between two values of u, linear in between.
#[inline(always)]
fn mean_share(from: &Lane, to: &Lane) -> Lane {
    let primitive = |u: f32| {
        let below = if u > 0.0 { u } else { 0.0 };
        if u < 1.0 { 0.5 * below * below } else { u - 0.5 }
    };
    lanes!(|lane| {
        let (a, b) = (from[lane], to[lane]);
        let (change, middle) = (b - a, 0.5 * (a + b));
        let middle = if middle > 0.0 { middle } else { 0.0 };
        let middle = if middle < 1.0 { middle } else { 1.0 };
        let is_even = change.abs() < EVEN_FRONT;
        let slope = (primitive(b) - primitive(a)) / if is_even { 1.0 } else { change };
        if is_even { middle } else { slope }
    })
}
