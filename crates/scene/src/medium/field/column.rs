//! Integrals of a field along a straight line: of grids exact, of others by a fixed rule, for measuring what samples of
//! the field are wrong by, not for the truth itself.
//!
//! Along a ray a trilinear field is a cubic polynomial between the planes through the voxel centres, so the two-point
//! Gauss rule integrates each piece exactly: [`Grid::column`] is exact up to rounding.

use glam::DVec3;

use super::cells::CellWalk;
use super::{Field, Grid};
use crate::geometry::Ray;

/// Two-point Gauss: abscissae ½ ± 1/(2√3).
const OFFSET: f64 = 0.288_675_134_594_812_9;
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

impl Grid {
    /// ∫ of the field from `a` to `b` [unit of the field × pc], exact; stops early past `enough`.
    pub fn column(&self, a: DVec3, b: DVec3, enough: f64) -> f64 {
        let (ray, length) = Ray::between(a, b);
        let Some((near, far)) = self.lattice.bounds.clip(&ray) else { return 0.0 };
        let far = far.min(length);
        if far <= near {
            return 0.0;
        }
        let mut cells = CellWalk::new(&self.lattice, &self.store, &ray, near);
        let enough = if self.factor > 0.0 { enough / self.factor } else { f64::INFINITY };
        let (mut t, mut sum) = (near, 0.0);
        // A ray crosses each plane once: whatever rounding does, the march ends.
        for _ in 0..self.lattice.dims.iter().sum::<usize>() + 8 {
            if t >= far || sum >= enough {
                break;
            }
            let (axis, plane) = cells.exit();
            let end = plane.min(far);
            if end > t {
                let (middle, width) = (0.5 * (t + end), end - t);
                let cell = cells.read();
                let low = cell.at(cells.place(middle - OFFSET * width));
                let high = cell.at(cells.place(middle + OFFSET * width));
                sum += 0.5 * width * (low + high);
                t = end;
            }
            cells.advance(axis);
        }
        self.factor * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Lattice;
    use crate::field::grid::linear;
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

    /// The exact column against a fine midpoint sum, along many directions.
    #[test]
    fn columns_are_exact() {
        let lattice = Lattice { dims: [7, 9, 5], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let grid = Grid::sampled(lattice, |p| (7.0 * p.x).sin().powi(2) + (5.0 * p.y * p.z).cos().powi(2));
        for i in 0..20 {
            let angle = i as f64;
            let a = 1.7 * DVec3::new(angle.cos(), angle.sin(), (1.3 * angle).sin());
            let b = -0.8 * DVec3::new((0.7 * angle).sin(), angle.cos(), (0.4 * angle).cos());
            let n = 40_000;
            let midpoints: f64 = (0..n).map(|j| grid.at(a.lerp(b, (j as f64 + 0.5) / n as f64))).sum::<f64>() * (b - a).length() / n as f64;
            let exact = grid.column(a, b, f64::INFINITY);
            assert!((exact - midpoints).abs() < 2e-4, "{i}: {exact} {midpoints}");
        }
    }

    /// An axis-parallel column of a linear field, by hand: no sampling in the expectation.
    #[test]
    fn column_along_an_axis() {
        let grid = linear();
        // Inside y from −0.75 to 1.75 the field is 10 + 2y at x = z-centre plane; the outer half voxels are constant.
        let at = |y: f64| 10.0 + 0.25 + 2.0 * y + 4.0 * 0.375;
        let expected = 0.25 * at(-0.75) + 2.5 * at(0.5) + 0.25 * at(1.75);
        let column = grid.column(DVec3::new(0.25, -3.0, 0.375), DVec3::new(0.25, 3.0, 0.375), f64::INFINITY);
        assert!((column - expected).abs() < 1e-4, "{column} {expected}");
    }
}
