//! Volumes: several scalar fields on one lattice, interleaved, so that one place is read together.

use glam::DVec3;

use crate::field::{Grid, Lattice};

/// What a channel holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// σ at V [pc⁻¹].
    Dust,
    /// Optical depth at V from a star [1].
    StarDepth(usize),
    /// Density of a glowing species, in its own unit.
    Emission(usize),
}

/// Fields on one lattice: depth × height × width × channels, f32.
#[derive(Debug, Clone)]
pub struct Volume {
    /// Where the voxels are; at least two along each axis.
    pub lattice: Lattice,
    /// What each channel holds.
    pub channels: Vec<Channel>,
    /// The values.
    pub data: Vec<f32>,
}

/// More channels than this are put into another volume: the march reads them together.
pub const MAX_CHANNELS: usize = 8;

impl Volume {
    /// Room for `channels` on a lattice, all zero. An axis of one voxel is doubled: trilinear between equals is the same.
    pub fn zeroed(lattice: &Lattice, channels: Vec<Channel>) -> Self {
        let lattice = Lattice { dims: lattice.dims.map(|n| n.max(2)), bounds: lattice.bounds };
        let data = vec![0.0; lattice.cells() * channels.len()];
        Self { lattice, channels, data }
    }

    /// Copies a grid of the same box and resolution into channel `slot`.
    pub fn fill(&mut self, slot: usize, grid: &Grid) {
        let own = &self.lattice;
        let from = &grid.lattice;
        for (index, values) in self.data.chunks_exact_mut(self.channels.len()).enumerate() {
            let [x, y, z] = own.place(index);
            values[slot] = grid.data[from.index(x.min(from.dims[0] - 1), y.min(from.dims[1] - 1), z.min(from.dims[2] - 1))];
        }
    }

    /// One channel as a grid, in f64 arithmetic.
    pub fn at(&self, channel: usize, p: DVec3) -> f64 {
        let size = DVec3::from(self.lattice.dims.map(|n| n as f64));
        let u = (p - self.lattice.bounds.low) / self.lattice.bounds.size() * size - 0.5;
        let u = u.clamp(DVec3::ZERO, size - 1.0);
        let cell = u.floor().min(size - 2.0);
        let f = u - cell;
        let (x, y, z) = (cell.x as usize, cell.y as usize, cell.z as usize);
        let value = |dx, dy, dz| f64::from(self.data[self.lattice.index(x + dx, y + dy, z + dz) * self.channels.len() + channel]);
        let lerp = |a: f64, b: f64, t: f64| a + t * (b - a);
        let plane = |dz| lerp(lerp(value(0, 0, dz), value(1, 0, dz), f.x), lerp(value(0, 1, dz), value(1, 1, dz), f.x), f.y);
        lerp(plane(0), plane(1), f.z)
    }

    /// Bytes of the values.
    pub fn bytes(&self) -> u64 {
        4 * self.data.len() as u64
    }
}

/// A grid's values times `factor`, with its lattice.
pub fn scaled(grid: &Grid, factor: f64) -> Grid {
    Grid { lattice: grid.lattice.clone(), data: grid.data.iter().map(|v| (f64::from(*v) * factor) as f32).collect() }
}
