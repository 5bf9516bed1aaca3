//! The borders that a packet's rays cross: of the occupied box, and of volumes that end within it.

use crate::geometry::{Bounds, Ray};
use crate::packet::LANES;
use crate::plan::SpatialPlan;

/// Start and end of a part of each ray [pc].
pub type Span = ([f64; LANES], [f64; LANES]);

/// By how much the border of a part of space is moved out where rays are asked whether they cross it, in parts of the
/// whole: what lies on it is found from both sides, whatever rounding does, and belongs to one.
const MARGIN: f64 = 1e-9;

/// A part of space with its border moved out a little; `all` is the box of everything.
pub fn moved_out(part: &Bounds, all: &Bounds) -> Bounds {
    part.grown(MARGIN * all.size().max_element())
}

/// The boxes whose borders count.
pub struct Borders {
    occupied: Option<Bounds>,
    /// Boxes of volumes that end within the occupied one.
    inner: Vec<Bounds>,
}

impl Borders {
    /// Finds the borders at which a march over `space` must stop, those of volumes that end within it among them where
    /// they count.
    pub fn new(space: &SpatialPlan, volumes_count: bool) -> Self {
        Self { occupied: space.occupied, inner: if volumes_count { space.inner_boxes() } else { Vec::new() } }
    }

    /// The parts of the rays between the borders of all boxes: within one, a ray is inside or outside of each volume.
    pub fn spans(&self, rays: &[Ray; LANES]) -> Vec<Span> {
        let Some(occupied) = self.occupied else { return Vec::new() };
        let whole = rays.each_ref().map(|ray| occupied.clip(ray).unwrap_or((0.0, 0.0)));
        let mut ends = vec![whole.map(|(near, _)| near), whole.map(|(_, far)| far)];
        for inner in &self.inner {
            let clipped = std::array::from_fn(|lane| {
                let (low, high) = whole[lane];
                let (near, far) = inner.clip(&rays[lane]).unwrap_or((high, high));
                (near.clamp(low, high), far.clamp(low, high))
            });
            ends.extend([clipped.map(|(near, _): (f64, f64)| near), clipped.map(|(_, far)| far)]);
        }
        sort_lanes(&mut ends);
        ends.windows(2).map(|pair| (pair[0], pair[1])).collect()
    }
}

/// Sorts each lane by itself, from near to far.
fn sort_lanes(rows: &mut [[f64; LANES]]) {
    for end in (1..rows.len()).rev() {
        for i in 0..end {
            for lane in 0..LANES {
                let (a, b) = (rows[i][lane], rows[i + 1][lane]);
                (rows[i][lane], rows[i + 1][lane]) = (a.min(b), a.max(b));
            }
        }
    }
}
