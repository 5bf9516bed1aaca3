//! The light field of all stars, for sixteen rays: `spectra::propagation` in f32.
//!
//! A sample adds Δτ Σ_i (Σ_m q_m(τ) M_imj) V_i, eq. (20) of docs/method.md, to the ray's j-th polynomial, V being its
//! light there; a band is read from the polynomials at the end.

use super::march::March;
use super::segment::Segment;
use super::state::State;
use super::terms::{CoordinateTable, DepthSpan};
use crate::packet::{LANES, Lane, lanes};
use crate::plan::LightField;

/// Tables of a light field.
#[derive(Debug)]
pub struct LightSums {
    coordinates: CoordinateTable,
    /// M_imj, element × element × element.
    products: Vec<f32>,
    /// The number of elements of the basis.
    size: usize,
    /// The number of polynomials a spectrum is written in.
    width: usize,
    /// Band × element × polynomial.
    resolution: Vec<Vec<f32>>,
}

impl LightSums {
    /// Converts the products and coordinates of `field` to single precision.
    pub fn new(field: &LightField) -> Self {
        let propagation = &field.propagation;
        let single = |values: &Vec<f64>| values.iter().map(|v| *v as f32).collect::<Vec<f32>>();
        Self {
            coordinates: CoordinateTable::new(&propagation.projection),
            products: single(&propagation.products),
            size: propagation.projection.basis.size(),
            width: propagation.span.len(),
            resolution: field.resolution.iter().map(single).collect(),
        }
    }

    /// The number of sums that each ray carries: element × polynomial.
    pub fn channels(&self) -> usize {
        self.size * self.width
    }

    /// Radiance of a ray's polynomials, into band × lane.
    pub fn resolve(&self, sum: &[Lane], radiance: &mut [f32]) {
        for (band, resolution) in self.resolution.iter().enumerate() {
            for (share, sum) in resolution.iter().zip(sum) {
                for lane in 0..LANES {
                    radiance[band * LANES + lane] += share * sum[lane];
                }
            }
        }
    }
}

/// Adds what one segment scatters.
#[inline(always)]
pub(super) fn accumulate(march: &March, sums: &LightSums, state: &mut State, segment: &Segment) {
    if sums.size <= 4 {
        accumulate_rows::<4>(march, sums, state, segment);
    } else {
        accumulate_rows::<8>(march, sums, state, segment);
    }
}

#[inline(always)]
fn accumulate_rows<const ROW: usize>(march: &March, sums: &LightSums, state: &mut State, segment: &Segment) {
    let (growth, before, after) = (&segment.growth, segment.before, segment.after);
    let span = DepthSpan { middle: lanes(|lane| state.tau[lane] + 0.5 * growth[lane]), half: lanes(|lane| 0.5 * growth[lane]) };
    let means = sums.coordinates.means::<ROW>(&span);
    let (size, width) = (sums.size, sums.width);
    let light = &march.slots.light[..size * width];
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
            let share = lanes(|lane| 0.5 * growth[lane] * share[lane]);
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
    let behind = march.plan.space.star_depth as f32;
    for lane in 0..LANES {
        let depth = if growth[lane] > 0.0 { state.tau[lane] + growth[lane] + behind } else { 0.0 };
        state.deepest[lane] = if depth > state.deepest[lane] { depth } else { state.deepest[lane] };
    }
}
