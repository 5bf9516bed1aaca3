//! Blocks that are filled by an array, in whatever order its elements come.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::{BlockValues, Blocks, EDGE, SIZE, Storage};
use crate::error::Error;
use crate::memory;
use crate::stored::too_small;

/// Conversion of array elements to blocks of a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Blocking {
    /// The axes of the array that x, y and z are.
    pub axes: [usize; 3],
    /// True if x, y and z run against the array's indices.
    pub backwards: [bool; 3],
    /// Factor of the values.
    pub factor: f64,
    /// True if values that are negative or no numbers become zero.
    pub clip: bool,
    /// Storage precision.
    pub storage: Storage,
}

/// Blocks that are being filled, each stored as it is to be once all of its voxels have come.
pub struct Filling {
    blocking: Blocking,
    blocks: Blocks,
    /// Voxels of each block that have not come.
    left: Vec<u16>,
    /// Bytes that blocks take, and may take.
    bytes: u64,
    limit: u64,
    label: PathBuf,
    /// The largest value that came, without its sign.
    largest: f64,
    wrong: Option<Error>,
}

impl Filling {
    /// Room for an array of this shape, all of it zero; its blocks may take `limit` bytes, and `label` names it.
    ///
    /// # Errors
    /// If the list of the blocks alone takes more.
    pub fn new(blocking: Blocking, shape: [usize; 3], label: &Path, limit: u64) -> Result<Self, Error> {
        let dims = blocking.axes.map(|axis| shape[axis]);
        // Each with how many of its voxels have not come.
        let each = size_of::<Option<BlockValues>>() + size_of::<u16>();
        let list = dims.iter().fold(each as u64, |bytes, n| bytes.saturating_mul(n.div_ceil(EDGE) as u64));
        memory::check(&format!("the blocks of {}", label.display()), list, limit)?;
        let blocks = Blocks::empty(dims, blocking.storage);
        let block = |index: usize| {
            let [nx, ny, _] = blocks.counts;
            let place = [index % nx, index / nx % ny, index / (nx * ny)];
            (0..3).map(|axis| (dims[axis] - place[axis] * EDGE).min(EDGE)).product::<usize>() as u16
        };
        let left = (0..blocks.blocks.len()).map(block).collect();
        Ok(Self { blocking, blocks, left, bytes: list, limit, label: label.to_owned(), largest: 0.0, wrong: None })
    }

    /// Takes elements that follow one another along an axis of the array, from one on; each element comes once.
    pub fn run(&mut self, axis: usize, first: [usize; 3], elements: impl Iterator<Item = f64>) {
        if self.wrong.is_some() {
            return;
        }
        let Blocking { axes, backwards, factor, clip, .. } = self.blocking.clone();
        let dims = self.blocks.dims;
        let voxel = |axis: usize, index: usize| if backwards[axis] { dims[axis] - 1 - index } else { index };
        let along = axes.iter().position(|a| *a == axis).unwrap_or(0);
        let others: usize =
            (0..3).filter(|axis| *axis != along).map(|axis| self.blocks.address(axis, voxel(axis, first[axes[axis]]))).sum();
        for (index, element) in (first[axis]..).zip(elements) {
            let value = element * factor;
            // What is no number is not above zero either.
            let value = if clip && !matches!(value.partial_cmp(&0.0), Some(Ordering::Greater)) { 0.0 } else { value };
            self.largest = self.largest.max(value.abs());
            self.put(others + self.blocks.address(along, voxel(along, index)), value as f32);
        }
    }

    #[inline(always)]
    fn put(&mut self, address: usize, value: f32) {
        let (block, local) = (address / SIZE, address % SIZE);
        if value != 0.0 && !matches!(self.blocks.blocks[block], Some(BlockValues::Single(_))) {
            self.open(block);
        }
        if let Some(BlockValues::Single(values)) = &mut self.blocks.blocks[block] {
            values[local] = value;
        }
        self.left[block] = self.left[block].saturating_sub(1);
        if self.left[block] == 0 {
            self.close(block);
        }
    }

    /// Makes a block one that can be written, where memory allows.
    fn open(&mut self, block: usize) {
        let before = self.blocks.blocks[block].as_ref().map_or(0, BlockValues::bytes);
        let bytes = self.bytes - before + 4 * SIZE as u64;
        match memory::check(&format!("the array of {}", self.label.display()), bytes, self.limit) {
            Ok(()) => {
                let mut values = vec![0.0; SIZE].into_boxed_slice();
                self.blocks.blocks[block].iter().for_each(|part| part.copy(0..SIZE, &mut values));
                self.blocks.blocks[block] = Some(BlockValues::Single(values));
                self.bytes = bytes;
            }
            Err(wrong) => self.wrong = self.wrong.take().or(Some(wrong)),
        }
    }

    /// Stores a block as it is to be.
    fn close(&mut self, block: usize) {
        if let Some(block_values) = &mut self.blocks.blocks[block] {
            self.bytes -= block_values.bytes();
            block_values.store(self.blocks.storage);
            self.bytes += block_values.bytes();
        }
    }

    /// The finished blocks.
    ///
    /// # Errors
    /// If it took more memory than it may, or all values are less than single precision holds.
    pub fn finish(mut self) -> Result<Blocks, Error> {
        if let Some(wrong) = self.wrong {
            return Err(wrong);
        }
        if let Some(message) = too_small(self.largest) {
            return Err(Error::file(&self.label, message));
        }
        let storage = self.blocks.storage;
        self.blocks.blocks.par_iter_mut().flatten().for_each(|block| block.store(storage));
        Ok(self.blocks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lumps in an empty array of 37 x 20 x 33 elements, and how it becomes blocks: y, z and x are its axes, x and z run
    /// backwards.
    const SHAPE: [usize; 3] = [20, 33, 37];

    fn element([i, j, k]: [usize; 3]) -> f64 {
        let lump = |at: [usize; 3]| [i, j, k].iter().zip(at).map(|(a, b)| (*a as f64 - b as f64).powi(2)).sum::<f64>();
        (9.0 - lump([3, 4, 5])).max(0.0) + 1e-4 * (20.0 - lump([17, 30, 34])).max(0.0)
    }

    fn blocks(storage: Storage, limit: u64) -> Result<Blocks, Error> {
        let blocking = Blocking { axes: [2, 0, 1], backwards: [true, false, true], factor: 2.0, clip: false, storage };
        let mut filling = Filling::new(blocking, SHAPE, Path::new("lumps"), limit)?;
        for (i, j) in (0..SHAPE[0]).flat_map(|i| (0..SHAPE[1]).map(move |j| (i, j))) {
            // A row in two parts, one of them along another axis.
            filling.run(2, [i, j, 0], (0..30).map(|k| element([i, j, k])));
            (30..SHAPE[2]).for_each(|k| filling.run(1, [i, j, k], [element([i, j, k])].into_iter()));
        }
        filling.finish()
    }

    /// The value that is meant for a voxel.
    fn truth([x, y, z]: [usize; 3]) -> f32 {
        (2.0 * element([y, SHAPE[1] - 1 - z, SHAPE[2] - 1 - x])) as f32
    }

    fn voxels() -> impl Iterator<Item = [usize; 3]> {
        (0..33).flat_map(|z| (0..20).flat_map(move |y| (0..37).map(move |x| [x, y, z])))
    }

    #[test]
    fn arrays_become_blocks_along_x_y_and_z() {
        for (storage, bytes) in [(Storage::Single, 4), (Storage::Half, 2), (Storage::Byte, 1)] {
            let blocks = blocks(storage, 1 << 20).unwrap();
            assert_eq!(blocks.dims, [37, 20, 33]);
            let filled = blocks.blocks.iter().flatten().count();
            assert!((2..9).contains(&filled) && blocks.blocks.len() == 18, "{filled}");
            assert_eq!(blocks.bytes(), (bytes * SIZE * filled + size_of::<Option<BlockValues>>() * 18) as u64);
            for (voxel, value) in voxels().zip(blocks.values()) {
                let address: usize = (0..3).map(|axis| blocks.address(axis, voxel[axis])).sum();
                assert_eq!(blocks.value(address), value);
                let block: [usize; 3] = voxel.map(|i| i / EDGE * EDGE);
                let within = |axis: usize| block[axis]..(block[axis] + EDGE).min(blocks.dims[axis]);
                let largest =
                    within(2).flat_map(|z| within(1).flat_map(move |y| within(0).map(move |x| truth([x, y, z])))).fold(0.0, f32::max);
                let error = f64::from((value - truth(voxel)).abs());
                // Single precision has errors of its own.
                assert!(
                    error <= f64::from(largest) * storage.error() * (1.0 + 1e-4) && (value > 0.0) == (truth(voxel) > 0.0),
                    "{storage:?} {voxel:?}"
                );
                assert!(storage == Storage::Byte || error <= f64::from(truth(voxel)) * storage.error());
            }
        }
        // A coarser storage has an error.
        let [single, byte] = [Storage::Single, Storage::Byte].map(|storage| blocks(storage, 1 << 20).unwrap().values());
        assert!(single != byte);
    }

    #[test]
    fn the_largest_of_a_box_is_found() {
        let blocks = blocks(Storage::Single, 1 << 20).unwrap();
        for (x, y, z) in [(0..37, 0..20, 0..33), (30..33, 2..5, 27..33), (1..6, 16..20, 2..3), (10..12, 0..20, 5..25)] {
            let inside = voxels().filter(|[a, b, c]| x.contains(a) && y.contains(b) && z.contains(c)).map(truth);
            assert_eq!(blocks.largest([x.clone(), y.clone(), z.clone()]), inside.fold(0.0, f32::max), "{x:?} {y:?} {z:?}");
        }
        assert_eq!(blocks.largest([0..37, 0..20, 0..33]), voxels().map(truth).fold(0.0, f32::max));
    }

    /// Memory is asked for block by block, and refused where it is too much; the list of blocks before it is made.
    #[test]
    fn memory_is_limited() {
        assert!(blocks(Storage::Single, 18 * 40).unwrap_err().to_string().contains("lumps"));
        assert!(blocks(Storage::Single, 60_000).is_err() && blocks(Storage::Byte, 60_000).is_ok());
        let blocking = Blocking { axes: [0, 1, 2], backwards: [false; 3], factor: 1.0, clip: false, storage: Storage::Single };
        assert!(Filling::new(blocking, [1 << 40; 3], Path::new("huge"), u64::MAX / 2).is_err());
    }

    /// Blocks that are made row by row are those that an array fills.
    #[test]
    fn rows_become_blocks() {
        let made = Blocks::made([37, 20, 33], || (), |(), [y, z], row| row.iter_mut().enumerate().for_each(|(x, v)| *v = truth([x, y, z])));
        assert!(made == blocks(Storage::Single, 1 << 20).unwrap() && made != blocks(Storage::Half, 1 << 20).unwrap());
    }

    /// Values that no density has stay as they are, to be refused by whoever looks at them.
    #[test]
    fn bad_values_are_kept() {
        for bad in [f64::NAN, -1.0, f64::INFINITY] {
            let blocking = Blocking { axes: [0, 1, 2], backwards: [false; 3], factor: 1.0, clip: false, storage: Storage::Byte };
            let mut filling = Filling::new(blocking, [1, 1, 3], Path::new("bad"), 1 << 20).unwrap();
            filling.run(2, [0; 3], [1.0, bad, 0.5].into_iter());
            let values = filling.finish().unwrap().values();
            assert!(values[0] == 1.0 && (values[1] == bad as f32 || values[1].is_nan() && bad.is_nan()) && values[2] == 0.5, "{values:?}");
        }
    }

    /// Clipped, they are zero; what is too small for single precision is an error, and what is nearly so no panic.
    #[test]
    fn values_are_clipped_and_refused() {
        let filled = |factor: f64, clip: bool, storage: Storage, values: [f64; 3]| {
            let blocking = Blocking { axes: [0, 1, 2], backwards: [false; 3], factor, clip, storage };
            let mut filling = Filling::new(blocking, [1, 1, 3], Path::new("small"), 1 << 20).unwrap();
            filling.run(2, [0; 3], values.into_iter());
            filling.finish().map(|blocks| blocks.values())
        };
        assert_eq!(filled(-2.0, true, Storage::Single, [1.0, f64::NAN, -0.5]).unwrap(), [0.0, 0.0, 1.0]);
        assert!(filled(1e-50, false, Storage::Single, [1.0, 2.0, 3.0]).unwrap_err().to_string().contains("single precision"));
        let tiny = filled(1.0, false, Storage::Byte, [1e-42, 1.5e-42, 1.3e-38]).unwrap();
        assert!(tiny.iter().all(|v| *v > 0.0), "{tiny:?}");
        let even = filled(1e-42, false, Storage::Byte, [1.0, 1.5, 2e4]).unwrap();
        assert!(even[2] > 0.9e-38 && even[0] > 0.0, "{even:?}");
    }
}
