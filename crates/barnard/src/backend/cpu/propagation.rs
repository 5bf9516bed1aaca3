//! The light field of all stars, for sixteen rays: `spectra::propagation` in f32.
//!
//! A sample adds Δτ Σ_i (Σ_m q_m(τ) M_imj) V_i, eq. (20) of docs/method.md, to the ray's j-th polynomial, V being its
//! light there; a band is read from the polynomials at the end.

use super::context::Context;
use super::light_sums::LightSums;
use super::segment::Segment;
use super::state::PacketState;
use super::terms::DepthSpan;
use crate::packet::{LANES, lanes};

/// Adds what one segment scatters.
#[inline(always)]
pub(super) fn accumulate(context: &Context, sums: &LightSums, state: &mut PacketState, segment: &Segment) {
    if sums.size <= 4 {
        accumulate_rows::<4>(context, sums, state, segment);
    } else {
        accumulate_rows::<8>(context, sums, state, segment);
    }
}

#[inline(always)]
fn accumulate_rows<const ROW: usize>(context: &Context, sums: &LightSums, state: &mut PacketState, segment: &Segment) {
    let (growth, before, after) = (&segment.growth, segment.before, segment.after);
    let span = DepthSpan { middle: lanes!(|lane| state.tau[lane] + 0.5 * growth[lane]), half: lanes!(|lane| 0.5 * growth[lane]) };
    let means = sums.coordinates.means::<ROW>(&span);
    let (size, width) = (sums.size, sums.width);
    let light = &context.slots.light[..size * width];
    for i in 0..size {
        for j in i..size {
            // M does not change when its indices do places.
            let mut share = [0.0; LANES];
            for m in 0..size {
                let product = sums.products[(m * size + i) * size + j];
                for lane in 0..LANES {
                    share[lane] += product * means[m][lane];
                }
            }
            let share = lanes!(|lane| 0.5 * growth[lane] * share[lane]);
            for (from, to) in [(i, j), (j, i)].into_iter().take(if i == j { 1 } else { 2 }) {
                for (sum, slot) in state.channels[to * width..][..width].iter_mut().zip(&light[from * width..]) {
                    for lane in 0..LANES {
                        sum[lane] += share[lane] * (before[*slot][lane] + after[*slot][lane]);
                    }
                }
            }
        }
    }
    // How deep the stars shine is known for the whole field alone.
    let behind = context.plan.space.star_depth as f32;
    for lane in 0..LANES {
        let depth = if growth[lane] > 0.0 { state.tau[lane] + growth[lane] + behind } else { 0.0 };
        state.deepest[lane] = if depth > state.deepest[lane] { depth } else { state.deepest[lane] };
    }
}
