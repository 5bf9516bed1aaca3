//! Integrals of a field along a straight line, by a fixed rule: for measuring what samples of the field are wrong by,
//! not for the truth itself.

use glam::DVec3;

use super::Field;
use super::cells::OFFSET;
use crate::geometry::Ray;

/// Most parts of a piece between two crossings.
const MAX_PARTS: f64 = 1024.0;

/// ∫ of the field from `a` to `b` [unit of the field × pc]: exact for grids; of functions by two points in every part
/// of the length over which they change, cut where they are known to jump.
pub fn column(field: &dyn Field, a: DVec3, b: DVec3) -> f64 {
    if let Some(grid) = field.grid() {
        return grid.column(a, b, f64::INFINITY);
    }
    let (ray, length) = Ray::between(a, b);
    let Some((near, far)) = field.bounds().clip(&ray) else { return 0.0 };
    let far = far.min(length);
    let mut ends = vec![near, far];
    field.crossings(&ray, &mut ends);
    ends.retain(|t| (near..=far).contains(t));
    ends.sort_by(f64::total_cmp);
    let (mut places, mut widths) = (Vec::new(), Vec::new());
    for ends in ends.windows(2) {
        let parts = ((ends[1] - ends[0]) / field.feature_pc()).ceil().clamp(1.0, MAX_PARTS);
        let width = (ends[1] - ends[0]) / parts;
        for part in 0..parts as usize {
            let middle = ends[0] + (part as f64 + 0.5) * width;
            places.extend([middle - OFFSET * width, middle + OFFSET * width].map(|t| ray.at(t)));
            widths.push(width);
        }
    }
    let mut values = vec![0.0; places.len()];
    field.sample(&places, &mut values);
    values.chunks_exact(2).zip(widths).map(|(pair, width)| 0.5 * width * (pair[0] + pair[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Grid, Lattice};
    use crate::geometry::Bounds;

    /// A ramp that is sharply cut, as a function without a grid, and as one of many voxels.
    #[derive(Debug)]
    struct Ramp;
    impl Field for Ramp {
        fn at(&self, p: DVec3) -> f64 {
            if p.x < 0.3 { 1.0 + p.x } else { 0.0 }
        }
        fn bounds(&self) -> Bounds {
            Bounds::cube(DVec3::ZERO, 1.0)
        }
        fn crossings(&self, ray: &Ray, out: &mut Vec<f64>) {
            out.push((0.3 - ray.origin.x) / ray.direction.x);
        }
    }

    #[test]
    fn columns_are_cut_where_fields_jump() {
        let (a, b) = (DVec3::new(-2.0, 0.0, 0.0), DVec3::new(2.0, 0.0, 0.0));
        // (1.3² − 0²)/2
        assert!((column(&Ramp, a, b) - 0.845).abs() < 1e-12, "{}", column(&Ramp, a, b));
        let grid = Grid::sampled(Lattice { dims: [200, 2, 2], bounds: Bounds::cube(DVec3::ZERO, 1.0) }, |p| 1.0 + p.x);
        assert!((column(&grid, a, b) - 2.0).abs() < 1e-6);
    }
}
