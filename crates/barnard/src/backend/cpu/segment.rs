//! One segment of sixteen rays, between two samples.

use super::context::Context;
use super::state::{State, StepSpan};
use crate::packet::{LANES, Lane, lanes};

/// One segment of sixteen rays, with what it needs to be shaded.
pub(super) struct Segment<'a> {
    /// The steps it covers.
    pub span: StepSpan,
    /// What the volumes hold at its two ends, by slots.
    pub before: &'a [Lane],
    pub after: &'a [Lane],
    /// The length of the segment on each lane [pc].
    pub length: Lane,
    /// By how much the optical depth at V grows on it \[1\].
    pub growth: Lane,
}

impl<'a> Segment<'a> {
    /// Makes the segment of a span from what the volumes hold at its ends.
    #[inline(always)]
    pub fn new(context: &Context, state: &State, span: StepSpan, before: &'a [Lane], after: &'a [Lane]) -> Self {
        let length = lanes(|lane| span.length * state.dt[lane]);
        let growth = match context.slots.dust {
            Some(dust) => lanes(|lane| 0.5 * length[lane] * (before[dust][lane] + after[dust][lane])),
            None => [0.0; LANES],
        };
        Self { span, before, after, length, growth }
    }
}
