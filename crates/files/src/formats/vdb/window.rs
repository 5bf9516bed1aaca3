//! A box of voxels, and what falls into it.

use crate::formats::FileFloat;
use crate::formats::gather::Gather;

/// Voxels from one corner to before another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// The lowest voxel.
    pub low: [i64; 3],
    /// Voxels along x, y and z.
    pub dims: [u64; 3],
}

impl Window {
    /// From one voxel to another, both within.
    pub fn between(low: [i32; 3], last: [i32; 3]) -> Self {
        let low = low.map(i64::from);
        Self { low, dims: std::array::from_fn(|i| (i64::from(last[i]) - low[i] + 1) as u64) }
    }

    fn high(&self, axis: usize) -> i64 {
        self.low[axis] + self.dims[axis] as i64
    }

    /// The least window that holds both.
    pub fn union(&self, other: &Self) -> Self {
        let low = std::array::from_fn(|i| self.low[i].min(other.low[i]));
        Self { low, dims: std::array::from_fn(|i| (self.high(i).max(other.high(i)) - low[i]) as u64) }
    }

    /// Gathers a cube of voxels that all have one value.
    pub fn tile<T: FileFloat>(&self, gather: &mut Gather<T>, cube: [i32; 3], edge: i32, value: T) {
        let along = |axis: usize| {
            let low = i64::from(cube[axis]) - self.low[axis];
            low..low + i64::from(edge)
        };
        gather.fill([along(2), along(1), along(0)], value);
    }

    /// True if some voxel of a cube is gathered.
    pub fn touches<T>(&self, gather: &Gather<T>, cube: [i32; 3], edge: i32) -> bool {
        (0..3).all(|axis| !self.along(gather, axis, cube[axis], edge).is_empty())
    }

    /// Gathers a cube of voxels whose values run along z fastest.
    pub fn voxels<T: FileFloat>(&self, gather: &mut Gather<T>, cube: [i32; 3], edge: i32, values: &[T]) {
        let [x, y, z] = std::array::from_fn(|axis| self.along(gather, axis, cube[axis], edge));
        let [cx, cy, cz] = std::array::from_fn(|axis| i64::from(cube[axis]) - self.low[axis]);
        let within = |at: usize, cube: i64| (at as i64 - cube) as usize;
        let edge = edge as usize;
        for k in z {
            for j in y.clone() {
                let row = within(j, cy) * edge + within(k, cz);
                gather.run([k, j, x.start], x.clone().map(|i| values[within(i, cx) * edge * edge + row]));
            }
        }
    }

    /// Voxels of a cube along an axis that are gathered, counted from the window's first.
    fn along<T>(&self, gather: &Gather<T>, axis: usize, low: i32, edge: i32) -> std::ops::Range<usize> {
        // Gathered is with x running fastest.
        let range = &gather.ranges[2 - axis];
        let low = i64::from(low) - self.low[axis];
        let within = |at: i64| at.clamp(range.start as i64, range.end as i64) as usize;
        within(low)..within(low + i64::from(edge))
    }
}
