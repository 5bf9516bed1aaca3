//! Values in blocks of 16³ voxels: empty blocks take no memory, and the others as much as their storage takes.
//!
//! A block keeps its values as they are, or as halves in parts of a unit of its own, or as bytes: zero is zero, and
//! 1 to 255 are even steps from the least value above zero to the largest. So what is empty stays empty.

mod filling;

use crate::properties::Choices;
use std::ops::Range;

pub use filling::{Blocking, Filling};
use rayon::prelude::*;

use crate::stored::{Half, Stored, unit};

/// Voxels along the edge of a block.
const EDGE: usize = 16;
const SIZE: usize = EDGE * EDGE * EDGE;
/// Steps of a byte between the least value above zero and the largest.
const STEPS: f32 = 254.0;

/// Storage precisions of a block, the most exact first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[non_exhaustive]
pub enum Storage {
    /// Four bytes a value, as it is in single precision.
    #[default]
    Single,
    /// Two bytes a value, right to 1 in 2048 of it, or of 2⁻²⁹ of the largest in its block.
    Half,
    /// One byte a value, right to 1 in 508 of the largest in its block.
    Byte,
}

impl Choices for Storage {
    const ROWS: &'static [(&'static str, Self)] = &[("single", Self::Single), ("half", Self::Half), ("byte", Self::Byte)];
}

impl Storage {
    /// The largest error of a value, in parts of the largest in its block \[1\].
    pub fn error(self) -> f64 {
        match self {
            Self::Single => 0.0,
            Self::Half => 1.0 / 2048.0,
            Self::Byte => 0.5 / f64::from(STEPS),
        }
    }

    /// The largest error of a value in parts of itself \[1\]; none where there is no such bound.
    pub fn relative_error(self) -> Option<f64> {
        (self != Self::Byte).then(|| self.error())
    }
}

/// The values of a block, x fastest; those beyond the edge of the grid are zero.
#[derive(Debug, Clone, PartialEq)]
enum BlockValues {
    Single(Box<[f32]>),
    Half { unit: f32, values: Box<[Half]> },
    Byte { least: f32, step: f32, values: Box<[u8]> },
}

impl BlockValues {
    #[inline(always)]
    fn value(&self, local: usize) -> f32 {
        match self {
            Self::Single(values) => values[local],
            Self::Half { unit, values } => values[local].value() * unit,
            Self::Byte { least, step, values } => of_byte(values[local], *least, *step),
        }
    }

    /// Writes values that stand side by side.
    fn copy(&self, range: Range<usize>, out: &mut [f32]) {
        match self {
            Self::Single(values) => out.copy_from_slice(&values[range]),
            Self::Half { unit, values } => out.iter_mut().zip(&values[range]).for_each(|(out, v)| *out = v.value() * unit),
            Self::Byte { least, step, values } => out.iter_mut().zip(&values[range]).for_each(|(out, v)| *out = of_byte(*v, *least, *step)),
        }
    }

    /// Stores singles in another way; as they are where one is negative or no number.
    fn store(&mut self, storage: Storage) {
        let Self::Single(values) = self else { return };
        let largest = values.iter().fold(0.0f32, |most, v| most.max(*v));
        if storage == Storage::Single || !values.iter().all(|v| v.is_finite() && *v >= 0.0) {
            return;
        }
        if storage == Storage::Half {
            let unit = unit(largest);
            *self = Self::Half { unit, values: values.iter().map(|v| Half::of(v / unit)).collect() };
            return;
        }
        let least = values.iter().filter(|v| **v > 0.0).fold(largest, |least, v| least.min(*v));
        let step = (largest - least) / STEPS;
        let byte = |v: &f32| if *v > 0.0 { 1 + if step > 0.0 { ((v - least) / step).round().min(STEPS) as u8 } else { 0 } } else { 0 };
        *self = Self::Byte { least, step, values: values.iter().map(byte).collect() };
    }

    fn bytes(&self) -> u64 {
        match self {
            Self::Single(_) => 4 * SIZE as u64,
            Self::Half { .. } => 2 * SIZE as u64,
            Self::Byte { .. } => SIZE as u64,
        }
    }
}

#[inline(always)]
fn of_byte(byte: u8, least: f32, step: f32) -> f32 {
    if byte == 0 { 0.0 } else { least + f32::from(byte - 1) * step }
}

/// The values of a grid, block by block.
#[derive(Debug, Clone, PartialEq)]
pub struct Blocks {
    /// Voxels along x, y and z.
    dims: [usize; 3],
    /// Blocks along x, y and z.
    counts: [usize; 3],
    /// The blocks, x fastest; none where all values are zero.
    blocks: Vec<Option<BlockValues>>,
    storage: Storage,
}

impl Blocks {
    /// Blocks for a number of voxels, all of them zero.
    fn empty(dims: [usize; 3], storage: Storage) -> Self {
        let counts = dims.map(|n| n.div_ceil(EDGE));
        Self { dims, counts, blocks: vec![None; counts.iter().product()], storage }
    }

    /// Blocks for a number of voxels whose values are made row by row along x, at y and z: `row` writes all of one.
    pub(crate) fn made<R>(dims: [usize; 3], room: impl Fn() -> R + Sync, row: impl Fn(&mut R, [usize; 2], &mut [f32]) + Sync) -> Self {
        let mut made = Self::empty(dims, Storage::Single);
        let [nx, ny, nz] = dims;
        let [across, down, _] = made.counts;
        made.blocks.par_chunks_exact_mut(across).enumerate().for_each_init(
            || (room(), vec![0.0; nx]),
            |(room, values), (number, blocks)| {
                let (y, z) = (number % down * EDGE, number / down * EDGE);
                for (j, k) in (z..(z + EDGE).min(nz)).flat_map(|k| (y..(y + EDGE).min(ny)).map(move |j| (j, k))) {
                    row(room, [j, k], values);
                    let first = ((k - z) * EDGE + j - y) * EDGE;
                    for (block, part) in blocks.iter_mut().zip(values.chunks(EDGE)).filter(|(_, part)| part.iter().any(|v| *v != 0.0)) {
                        let block = block.get_or_insert_with(|| BlockValues::Single(vec![0.0; SIZE].into_boxed_slice()));
                        if let BlockValues::Single(values) = block {
                            values[first..first + part.len()].copy_from_slice(part);
                        }
                    }
                }
            },
        );
        made
    }

    /// Storage precision of the values.
    pub fn storage(&self) -> Storage {
        self.storage
    }

    /// The voxels along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The bytes that the values take.
    pub fn bytes(&self) -> u64 {
        self.blocks.iter().flatten().map(BlockValues::bytes).sum::<u64>() + (size_of::<Option<BlockValues>>() * self.blocks.len()) as u64
    }

    /// Address offset of a voxel's index along an axis: the number of its block, and its place in there.
    #[inline(always)]
    pub(crate) fn address(&self, axis: usize, i: usize) -> usize {
        let [nx, ny, _] = self.counts;
        let (block, local) = ([1, nx, nx * ny][axis], [1, EDGE, EDGE * EDGE][axis]);
        i / EDGE * block * SIZE + i % EDGE * local
    }

    /// The value at the sum of three addresses.
    #[inline(always)]
    pub(crate) fn value(&self, address: usize) -> f32 {
        self.blocks[address / SIZE].as_ref().map_or(0.0, |block| block.value(address % SIZE))
    }

    /// True if a value that is stored is such a one; empty blocks are not asked.
    pub(crate) fn any(&self, is_such: impl Fn(f32) -> bool + Sync) -> bool {
        self.blocks.par_iter().flatten().any(|block| (0..SIZE).any(|local| is_such(block.value(local))))
    }

    /// Writes the values of some voxels of a row.
    pub(crate) fn row(&self, along: Range<usize>, y: usize, z: usize, out: &mut [f32]) {
        let row = self.address(1, y) + self.address(2, z);
        let mut x = along.start;
        while x < along.end {
            let end = ((x / EDGE + 1) * EDGE).min(along.end);
            let (address, part) = (row + self.address(0, x), &mut out[x - along.start..end - along.start]);
            match &self.blocks[address / SIZE] {
                None => part.fill(0.0),
                Some(block) => block.copy(address % SIZE..address % SIZE + (end - x), part),
            }
            x = end;
        }
    }

    /// All values, x fastest.
    pub fn values(&self) -> Vec<f32> {
        let [nx, ny, nz] = self.dims;
        let mut values = vec![0.0; nx * ny * nz];
        values.chunks_exact_mut(nx.max(1)).enumerate().for_each(|(r, out)| self.row(0..nx, r % ny, r / ny, out));
        values
    }

    /// The largest value of some voxels along x, y and z; zero where all are less.
    pub(crate) fn largest(&self, [x, y, z]: [Range<usize>; 3]) -> f32 {
        let touched = |range: &Range<usize>| range.start / EDGE..range.end.div_ceil(EDGE);
        let (bx, by, bz) = (touched(&x), touched(&y), touched(&z));
        let voxel = |[i, j, k]: [usize; 3]| {
            let Some(block) = &self.blocks[(k * self.counts[1] + j) * self.counts[0] + i] else { return 0.0 };
            let within = |block: usize, range: &Range<usize>| {
                range.start.max(block * EDGE) - block * EDGE..range.end.min((block + 1) * EDGE) - block * EDGE
            };
            let (x, y, z) = (within(i, &x), within(j, &y), within(k, &z));
            let mut row = [0.0; EDGE];
            let rows = z.flat_map(|z| y.clone().map(move |y| (z * EDGE + y) * EDGE));
            rows.fold(0.0f32, |most, first| {
                let cells = &mut row[x.clone()];
                block.copy(first + x.start..first + x.end, cells);
                cells.iter().fold(most, |most, v| most.max(*v))
            })
        };
        let blocks = bz.flat_map(|k| {
            by.clone().flat_map({
                let bx = bx.clone();
                move |j| bx.clone().map(move |i| [i, j, k])
            })
        });
        blocks.fold(0.0f32, |most, block| most.max(voxel(block)))
    }
}
