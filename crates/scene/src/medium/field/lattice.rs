//! Lattices: where the voxels of a grid are.

use std::ops::Range;

use glam::DVec3;

use crate::geometry::Bounds;

/// A regular lattice of voxels in a box.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
    /// The box they fill \[pc\].
    pub bounds: Bounds,
}

impl Lattice {
    /// A lattice of nearly cubic voxels with `edge` of them along the longest edge of the box.
    pub fn along(bounds: Bounds, edge: usize) -> Self {
        let size = bounds.size();
        let dims = (size / size.max_element() * edge as f64).to_array().map(|n| (n.round() as usize).max(2));
        Self { dims, bounds }
    }

    /// The number of voxels.
    pub fn cells(&self) -> usize {
        self.dims.iter().product()
    }

    /// Edge lengths of a voxel \[pc\].
    pub fn voxel_pc(&self) -> DVec3 {
        self.bounds.size() / DVec3::from(self.dims.map(|n| n as f64))
    }

    /// Centre of voxel (x, y, z) \[pc\].
    pub fn centre(&self, x: usize, y: usize, z: usize) -> DVec3 {
        self.bounds.low + (DVec3::new(x as f64, y as f64, z as f64) + 0.5) * self.voxel_pc()
    }

    /// Position in the array; x runs fastest.
    pub fn index(&self, x: usize, y: usize, z: usize) -> usize {
        (z * self.dims[1] + y) * self.dims[0] + x
    }

    /// Positions of the voxels `along` x in one row.
    pub fn row(&self, along: Range<usize>, y: usize, z: usize) -> Range<usize> {
        let first = self.index(0, y, z);
        first + along.start..first + along.end
    }

    /// (x, y, z) of a position in the array.
    pub fn place(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.dims;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    /// Copy of the box with `factor` times as many voxels along each axis.
    pub fn refined(&self, factor: usize) -> Self {
        Self { dims: self.dims.map(|n| n * factor), bounds: self.bounds }
    }

    /// The lattice of some of the voxels along x, y and z, which must be among its own.
    pub fn part(&self, voxels: &[Range<usize>; 3]) -> Self {
        let corner = |ends: [usize; 3]| self.bounds.low + DVec3::from(ends.map(|n| n as f64)) * self.voxel_pc();
        let [low, high] = [voxels.each_ref().map(|v| v.start), voxels.each_ref().map(|v| v.end)].map(corner);
        Self { dims: voxels.each_ref().map(|v| v.len()), bounds: Bounds { low, high } }
    }

    /// `p` in units of voxels, zero at the first voxel centre.
    pub(super) fn index_space(&self, p: DVec3) -> DVec3 {
        (p - self.bounds.low) / self.voxel_pc() - 0.5
    }
}

/// Trilinear interpolation at a `fraction` of a cell between the values at its corners: x fastest, then y.
#[inline(always)]
pub fn trilinear([a, b, c, d, e, f, g, h]: [f64; 8], fraction: DVec3) -> f64 {
    let lerp = |a: f64, b: f64, t: f64| a + t * (b - a);
    let plane = |a, b, c, d| lerp(lerp(a, b, fraction.x), lerp(c, d, fraction.x), fraction.y);
    lerp(plane(a, b, c, d), plane(e, f, g, h), fraction.z)
}
