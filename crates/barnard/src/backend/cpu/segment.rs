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
        let mut segment = Self { span, before, after, middle, length, growth: [0.0; LANES], first: [0.0; LANES] };
        if let Some(dust) = context.slots.dust {
            let twice = segment.twice_the_mean(dust);
            segment.growth = lanes!(|lane| 0.5 * length[lane] * twice[lane]);
            if let Some(middle) = middle {
                segment.first = lanes!(|lane| 0.25 * length[lane] * (before[dust][lane] + middle[dust][lane]));
            }
        }
        segment
    }

    /// True if there is a sample in the middle.
    #[inline(always)]
    pub fn has_middle(&self) -> bool {
        self.middle.is_some()
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
