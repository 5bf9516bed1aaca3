//! Depths from stars to the places of one ray, exact through the samples of the dust: marched to knots that stand close
//! beside the voxels, and cubic between them.
//!
//! Along a ray a depth from a star is as smooth as a column through a trilinear field: it turns within a voxel and not
//! faster. So a few knots a voxel serve for the dozens of places that a truth asks for. Where every voxel is another, four
//! are off by a hundredth of a voxel's depth (rms), and two by a twentieth at most.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::geometry::Ray;
use crate::plan::SpatialPlan;

/// Knots along a voxel edge.
const KNOTS: f64 = 4.0;
/// Accuracy of a picture from which half as many do: the error of a voxel's depth averages out along a ray.
const LOOSE: f64 = 4e-3;

/// The depths along one ray that were asked for so far.
pub(in crate::plan) struct StarColumns {
    ray: Ray,
    /// The numbers of the stars that are seen, those with depths of their own first.
    pub(super) stars: Vec<usize>,
    near: f64,
    apart: f64,
    /// For each star that is seen its depth at every knot \[1\], as bits; those of NaN where nobody has asked. Whoever
    /// writes one writes the same number.
    depths: Vec<Vec<AtomicU64>>,
}

impl StarColumns {
    /// Room for the depths of `stars` along `ray`, for a picture of an accuracy.
    pub(in crate::plan) fn new(space: &SpatialPlan, ray: &Ray, stars: Vec<usize>, accuracy: f64) -> Self {
        Self::with_knots(if accuracy < LOOSE { KNOTS } else { 0.5 * KNOTS }, space, ray, stars)
    }

    fn with_knots(knots: f64, space: &SpatialPlan, ray: &Ray, stars: Vec<usize>) -> Self {
        let (near, far) = space.occupied.and_then(|bounds| bounds.clip(ray)).unwrap_or((0.0, 1.0));
        let pieces = ((far - near) / space.voxel_along(ray.direction) * knots).ceil().max(3.0);
        let unknown = || (0..=pieces as usize).map(|_| AtomicU64::new(f64::NAN.to_bits())).collect();
        let depths = stars.iter().map(|_| unknown()).collect();
        Self { ray: *ray, stars, near, apart: (far - near) / pieces, depths }
    }

    /// The bytes that they take.
    pub(super) fn bytes(&self) -> usize {
        self.depths.iter().map(|depths| size_of::<AtomicU64>() * depths.len()).sum()
    }

    /// The depth from the star that is seen as number `seen` to distance `t` \[pc\].
    pub(super) fn depth(&self, space: &SpatialPlan, seen: usize, t: f64) -> f64 {
        let (star, depths) = (space.stars[self.stars[seen]], &self.depths[seen]);
        let u = (t - self.near) / self.apart;
        // The piece between the middle two of four knots, or the outermost there is.
        let first = (u.floor() - 1.0).clamp(0.0, (depths.len() - 4) as f64);
        let knot = |i: usize| {
            let place = &depths[first as usize + i];
            let known = f64::from_bits(place.load(Ordering::Relaxed));
            if !known.is_nan() {
                return known;
            }
            let depth = space.depth(star, self.ray.at(self.near + (first + i as f64) * self.apart));
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

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::control::Control;
    use crate::field::{Grid, Lattice};
    use crate::fixtures::{dust, on_axis, scene, star};
    use crate::geometry::Bounds;
    use crate::plan::{Options, Planner, Quality};
    use crate::random::Counter;

    /// Cubics are exact, at knots and between them.
    #[test]
    fn cubics_are_cubics() {
        let f = |u: f64| 2.0 - u + 0.5 * u * u - 0.25 * u * u * u;
        for i in 0..=30 {
            let u = 0.1 * f64::from(i);
            assert!((cubic([0.0, 1.0, 2.0, 3.0].map(f), u) - f(u)).abs() < 1e-12);
        }
    }

    /// Between knots a depth is that of a column to a hundredth of the depth of a voxel (rms), in dust whose every voxel
    /// is another, for stars inside and outside; by half as many knots to a twentieth.
    #[test]
    fn depths_between_knots_are_those_of_columns() {
        let mut random = Counter::new(5, 0);
        let lattice = Lattice { dims: [24; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let noise = Grid::new(lattice.dims, lattice.bounds, (0..lattice.cells()).map(|_| random.uniform() as f32).collect()).unwrap();
        let stars = [DVec3::new(0.13, 0.21, -0.08), DVec3::new(-2.0, 1.1, 0.7)];
        let scene = stars.iter().fold(scene(on_axis(4.0, 20.0, (8, 8)), 4).with_dust(dust(noise, "ccm89", 6.0)), |scene, place| {
            scene.with_star(star(9000.0, 1.0, *place))
        });
        let scene = scene.build().unwrap();
        let space = Planner::new(&Options::default())
            .with_quality(Quality::Fixed(4))
            .plan(&scene, None, &Control::default())
            .unwrap()
            .space()
            .clone();
        let voxel_depth = 0.5 * f64::from(space.bricks[0].largest()) * space.voxel_pc();
        let rms = |knots: f64| {
            let (mut sum, mut count) = (0.0, 0.0);
            for ray in (0..8).map(|i| scene.camera.ray(0.37 + i as f64, 7.4 - 0.9 * i as f64)) {
                let columns = StarColumns::with_knots(knots, &space, &ray, vec![0, 1]);
                let (near, far) = space.occupied.and_then(|bounds| bounds.clip(&ray)).unwrap();
                for (seen, place) in stars.iter().enumerate() {
                    for t in (0..400).map(|i| near + (far - near) * (i as f64 + 0.5) / 400.0) {
                        // Near the star itself back ends and pilots march columns.
                        if (ray.at(t) - *place).length() > 2.5 * space.voxel_pc() {
                            let error = columns.depth(&space, seen, t) - space.depth(*place, ray.at(t));
                            sum += error * error;
                            count += 1.0;
                        }
                    }
                }
            }
            f64::sqrt(sum / count) / voxel_depth
        };
        let (error, coarse) = (rms(KNOTS), rms(0.5 * KNOTS));
        assert!(error < 1.2e-2 && coarse > 2.5 * error && coarse < 0.05, "{error:.1e} {coarse:.1e}");
    }
}
