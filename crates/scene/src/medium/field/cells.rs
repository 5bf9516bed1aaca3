//! The cells between voxel centres along a straight line, each found from the one before: their eight values are read
//! once, however many places within are asked for.
//!
//! In index space the first voxel centre is the origin and the planes between cells are the integers. Beyond the outer
//! centres, in the outer half voxel, a cell has the border's values on both sides.

use glam::DVec3;

use super::lattice::{Lattice, trilinear};
use super::store::Store;
use crate::geometry::Ray;

/// Eight values around a place.
pub(super) struct Cell {
    /// The lowest corner in index space.
    corner: DVec3,
    /// The values at the corners, x fastest, then y.
    values: [f64; 8],
}

impl Cell {
    /// Reads the values of `store` in the cell with this lowest corner, whose voxels have addresses at `sides` along each
    /// axis.
    #[inline(always)]
    pub(super) fn read(store: &Store, corner: DVec3, sides: [[usize; 2]; 3]) -> Self {
        Self { corner, values: store.corners(sides) }
    }

    /// The trilinear value at a place in index space.
    #[inline(always)]
    pub(super) fn at(&self, u: DVec3) -> f64 {
        trilinear(self.values, u - self.corner)
    }
}

/// A line's way through the cells of a grid.
pub(super) struct CellWalk<'a> {
    store: &'a Store,
    /// The line in index space: where it starts, and how far it comes in a parsec.
    origin: DVec3,
    slope: DVec3,
    /// Along each axis: the distance at which the line meets the next plane, and the distance between planes \[pc\].
    next: [f64; 3],
    apart: [f64; 3],
    /// The cell, the step to the next along each axis, and the last voxel.
    cell: [i64; 3],
    step: [i64; 3],
    last: [i64; 3],
    /// Along each axis: addresses of the voxels on either side of the cell.
    sides: [[usize; 2]; 3],
}

impl<'a> CellWalk<'a> {
    /// The cells of a grid's values along `ray`, from distance `near` on \[pc\].
    pub(super) fn new(lattice: &Lattice, store: &'a Store, ray: &Ray, near: f64) -> Self {
        let dims = lattice.dims;
        let origin = lattice.index_space(ray.origin);
        let slope = ray.direction / lattice.voxel_pc();
        let mut cells = Self {
            store,
            origin,
            slope,
            next: [f64::INFINITY; 3],
            apart: [f64::INFINITY; 3],
            cell: [0; 3],
            step: [0; 3],
            last: dims.map(|n| n as i64 - 1),
            sides: [[0; 2]; 3],
        };
        for axis in 0..3 {
            let s = slope[axis];
            let u = origin[axis] + near * s;
            // A line that starts on a plane is already past it.
            let (plane, cell) = if s > 0.0 {
                let plane = (u + 1e-12).floor() + 1.0;
                (plane, plane - 1.0)
            } else if s < 0.0 {
                let plane = (u - 1e-12).ceil() - 1.0;
                (plane, plane)
            } else {
                (f64::INFINITY, u.floor())
            };
            if s != 0.0 {
                cells.next[axis] = (plane - origin[axis]) / s;
                cells.apart[axis] = 1.0 / s.abs();
                cells.step[axis] = s.signum() as i64;
            }
            cells.cell[axis] = cell as i64;
            cells.stand(axis);
        }
        cells
    }

    /// The axis along which the line leaves the cell, and the distance at which it does \[pc\].
    #[inline(always)]
    pub(super) fn exit(&self) -> (usize, f64) {
        let [x, y, z] = self.next;
        let axis = if x < y {
            if x < z { 0 } else { 2 }
        } else if y < z {
            1
        } else {
            2
        };
        (axis, self.next[axis])
    }

    /// Goes on to the next cell along an axis.
    #[inline(always)]
    pub(super) fn advance(&mut self, axis: usize) {
        self.next[axis] += self.apart[axis];
        self.cell[axis] += self.step[axis];
        self.stand(axis);
    }

    /// Finds the voxels on either side of the cell along an axis.
    #[inline(always)]
    fn stand(&mut self, axis: usize) {
        let side = |i: i64| self.store.address(axis, i.clamp(0, self.last[axis]) as usize);
        self.sides[axis] = [side(self.cell[axis]), side(self.cell[axis] + 1)];
    }

    /// Reads the cell.
    #[inline(always)]
    pub(super) fn read(&self) -> Cell {
        let [x, y, z] = self.cell;
        Cell::read(self.store, DVec3::new(x as f64, y as f64, z as f64), self.sides)
    }

    /// The place in index space at a distance \[pc\].
    #[inline(always)]
    pub(super) fn place(&self, t: f64) -> DVec3 {
        self.origin + t * self.slope
    }
}
