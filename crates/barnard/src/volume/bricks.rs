//! Bricks: which parts of space are empty, and how dense the others can be.

use glam::DVec3;
use rayon::prelude::*;

use crate::field::{Grid, Lattice};
use crate::geometry::Bounds;

/// Voxels along the edge of a brick.
pub const BRICK: usize = 8;

/// The largest value in each brick and one voxel around it: a bound for trilinear values inside.
#[derive(Debug, Clone)]
pub struct Bricks {
    /// The lattice of the voxels; a brick stands for BRICK³ of them.
    pub lattice: Lattice,
    /// Largest value of each brick.
    pub majorant: Vec<f32>,
    /// The distance to the next brick that is not empty, in bricks, diagonals counting as one; zero where the brick
    /// itself is not.
    distance: Vec<u8>,
}

impl Bricks {
    /// The bricks of one grid.
    pub fn new(grid: &Grid) -> Self {
        let dims = grid.lattice().dims;
        let counts = dims.map(|n| n.div_ceil(BRICK));
        let edge = grid.lattice().voxel_pc() * BRICK as f64;
        let low = grid.lattice().bounds.low;
        let high = low + edge * DVec3::from(counts.map(|n| n as f64));
        let lattice = Lattice { dims: counts, bounds: Bounds { low, high } };
        let majorant = (0..lattice.cells())
            .into_par_iter()
            .map(|index| {
                let brick = lattice.place(index);
                let range = |axis: usize| (brick[axis] * BRICK).saturating_sub(1)..((brick[axis] + 1) * BRICK + 1).min(dims[axis]);
                grid.largest([range(0), range(1), range(2)])
            })
            .collect();
        let mut bricks = Self { lattice, majorant, distance: Vec::new() };
        bricks.distance = bricks.distances();
        bricks
    }

    /// Distances by two passes, there and back: each brick is one further than the nearest of its neighbours.
    fn distances(&self) -> Vec<u8> {
        let mut distance: Vec<u8> = self.majorant.iter().map(|m| if *m > 0.0 { 0 } else { u8::MAX }).collect();
        let count = distance.len();
        for index in (0..count).chain((0..count).rev()) {
            let nearest = self.surroundings(index).map(|i| distance[i]).min().unwrap_or(u8::MAX);
            distance[index] = distance[index].min(nearest.saturating_add(1));
        }
        distance
    }

    /// A brick and its neighbours.
    fn surroundings(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        let place = self.lattice.place(index);
        let range = move |axis: usize| place[axis].saturating_sub(1)..=(place[axis] + 1).min(self.lattice.dims[axis] - 1);
        range(2).flat_map(move |z| range(1).flat_map(move |y| range(0).map(move |x| self.lattice.index(x, y, z))))
    }

    /// The number of edges of a brick that one may go in any direction from a place in it and still stand in an empty
    /// brick.
    pub fn clear(&self, brick: [usize; 3]) -> usize {
        usize::from(self.distance[self.lattice.index(brick[0], brick[1], brick[2])].saturating_sub(1))
    }

    /// The brick of `p`, the nearest where `p` is outside.
    pub fn brick_of(&self, p: DVec3) -> [usize; 3] {
        let cell = (p - self.lattice.bounds.low) / self.lattice.voxel_pc();
        // Conversion cuts fractions off and makes zero of what is negative.
        std::array::from_fn(|axis| (cell[axis] as usize).min(self.lattice.dims[axis] - 1))
    }

    /// The largest value of all.
    pub fn largest(&self) -> f32 {
        self.majorant.iter().fold(0.0, |m, v| m.max(*v))
    }

    /// The smallest box around all bricks that are not empty, within `bounds`.
    pub fn occupied(&self, bounds: &Bounds) -> Option<Bounds> {
        let edge = self.lattice.voxel_pc();
        let filled = (0..self.lattice.cells()).filter(|i| self.majorant[*i] > 0.0);
        let boxes = filled.map(|i| {
            let low = self.lattice.bounds.low + DVec3::from(self.lattice.place(i).map(|n| n as f64)) * edge;
            Bounds { low: low.max(bounds.low), high: (low + edge).min(bounds.high) }
        });
        boxes.reduce(|a, b| a.union(&b))
    }

    /// The part of the bricks that is not empty \[1\].
    pub fn filling(&self) -> f64 {
        self.majorant.iter().filter(|m| **m > 0.0).count() as f64 / self.majorant.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn majorants_bound_the_field() {
        let lattice = Lattice { dims: [20, 17, 9], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let grid = Grid::sampled(lattice, |p| (p.x * 5.0 + p.y * 3.0).sin().max(0.0));
        let bricks = Bricks::new(&grid);
        use crate::field::Field;
        for i in 0..4000 {
            let p = DVec3::new((i as f64 * 0.7).sin(), (i as f64 * 0.31).sin(), (i as f64 * 0.17).sin());
            let cell = ((p - bricks.lattice.bounds.low) / bricks.lattice.voxel_pc()).floor();
            let index = bricks.lattice.index(cell.x as usize, cell.y as usize, cell.z as usize);
            assert!(grid.at(p) <= f64::from(bricks.majorant[index]) + 1e-6);
        }
    }

    #[test]
    fn empty_space_is_found() {
        let lattice = Lattice { dims: [32; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let grid = Grid::sampled(lattice, |p| f64::from(p.length() < 0.2));
        let bricks = Bricks::new(&grid);
        let occupied = bricks.occupied(&grid.lattice().bounds).unwrap();
        assert!(occupied.size().x <= 1.0 + 1e-9 && bricks.filling() < 0.2);
    }
}
