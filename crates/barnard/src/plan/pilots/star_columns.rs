//! Depths from stars to the places of one ray, exact through the samples of the dust: marched to knots that stand close
//! beside the voxels, and cubic between them.
//!
//! Along a ray a depth from a star is as smooth as a column through a trilinear field: it turns within a voxel and not
//! faster. So a few knots a voxel are as good as a column to every place, of which a truth asks for dozens.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::geometry::Ray;
use crate::plan::SpatialPlan;

/// Knots along a voxel edge.
const KNOTS: f64 = 3.0;

/// The depths along one ray that were asked for so far.
pub(in crate::plan) struct StarColumns {
    near: f64,
    apart: f64,
    /// For each star that is seen its depth at every knot \[1\], as bits; those of NaN where nobody has asked. Whoever
    /// writes one writes the same number.
    depths: Vec<Vec<AtomicU64>>,
}

impl StarColumns {
    /// Room for the depths of so many stars along `ray`.
    pub(in crate::plan) fn new(space: &SpatialPlan, ray: &Ray, stars: usize) -> Self {
        let (near, far) = space.occupied.and_then(|bounds| bounds.clip(ray)).unwrap_or((0.0, 1.0));
        let pieces = ((far - near) / space.voxel_along(ray.direction) * KNOTS).ceil().max(3.0);
        let unknown = || (0..=pieces as usize).map(|_| AtomicU64::new(f64::NAN.to_bits())).collect();
        Self { near, apart: (far - near) / pieces, depths: (0..stars).map(|_| unknown()).collect() }
    }

    /// The depth from star number `star`, which is the one that is seen as number `seen`, to distance `t` \[pc\].
    pub(super) fn depth(&self, space: &SpatialPlan, ray: &Ray, (star, seen): (usize, usize), t: f64) -> f64 {
        let depths = &self.depths[seen];
        let u = (t - self.near) / self.apart;
        // The piece between the middle two of four knots, or the outermost there is.
        let first = (u.floor() - 1.0).clamp(0.0, (depths.len() - 4) as f64);
        let knot = |i: usize| {
            let place = &depths[first as usize + i];
            let known = f64::from_bits(place.load(Ordering::Relaxed));
            if !known.is_nan() {
                return known;
            }
            let depth = space.depth(space.stars[star], ray.at(self.near + (first + i as f64) * self.apart));
            place.store(depth.to_bits(), Ordering::Relaxed);
            depth
        };
        cubic([0, 1, 2, 3].map(knot), u - first).max(0.0)
    }
}

/// The cubic through four values at 0, 1, 2 and 3.
fn cubic([a, b, c, d]: [f64; 4], u: f64) -> f64 {
    let [p, q, r, s] = [u, u - 1.0, u - 2.0, u - 3.0];
    -a * q * r * s / 6.0 + 0.5 * b * p * r * s - 0.5 * c * p * q * s + d * p * q * r / 6.0
}
