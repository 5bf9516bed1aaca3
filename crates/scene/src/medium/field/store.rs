//! Memory layout of a grid: row by row, or in blocks.
//!
//! A voxel's address is the sum of one number for its place along each axis, whichever way the values stand.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use spectra::fingerprint::{Digest, Fingerprint};

use crate::blocks::{Blocks, Storage};
use crate::data::Shared;

/// Values that a thread asks together.
const ASKED_TOGETHER: usize = 1 << 16;

/// The values of a grid; clones are other holds on the same memory.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Store {
    /// Depth × height × width, x fastest, of these lengths of the axes.
    Rows([usize; 3], Shared<f32>),
    /// Block by block.
    Blocks(Arc<Blocks>),
}

impl Store {
    /// Address offset of a voxel's index along an axis.
    #[inline(always)]
    pub fn address(&self, axis: usize, i: usize) -> usize {
        match self {
            Self::Rows([nx, ny, _], _) => i * [1, *nx, nx * ny][axis],
            Self::Blocks(blocks) => blocks.address(axis, i),
        }
    }

    /// The values at eight corners, x fastest, then y, given the addresses of both sides along each axis.
    #[inline(always)]
    pub fn corners(&self, sides: [[usize; 2]; 3]) -> [f64; 8] {
        match self {
            Self::Rows(_, values) => {
                // One virtual call for all corners.
                let values: &[f32] = values;
                at_corners(sides, |at| values[at])
            }
            Self::Blocks(blocks) => at_corners(sides, |at| blocks.value(at)),
        }
    }

    /// Writes the values of some voxels of a row.
    pub fn row(&self, along: Range<usize>, y: usize, z: usize, out: &mut [f32]) {
        match self {
            Self::Rows([nx, ny, _], values) => {
                let first = (z * ny + y) * nx;
                out.copy_from_slice(&values[first + along.start..first + along.end]);
            }
            Self::Blocks(blocks) => blocks.row(along, y, z, out),
        }
    }

    /// The largest value of some voxels along x, y and z; zero where all are less.
    pub fn largest(&self, [x, y, z]: [Range<usize>; 3]) -> f32 {
        match self {
            Self::Rows([nx, ny, _], values) => {
                let values: &[f32] = values;
                let rows = z.flat_map(|z| y.clone().map(move |y| (z * ny + y) * nx));
                rows.fold(0.0, |most, first| values[first + x.start..first + x.end].iter().fold(most, |most, v| v.max(most)))
            }
            Self::Blocks(blocks) => blocks.largest([x, y, z]),
        }
    }

    /// True if a value is such a one; zeros of empty blocks are not asked.
    pub fn any(&self, is_such: impl Fn(f32) -> bool + Sync) -> bool {
        match self {
            Self::Rows(_, values) => values.par_chunks(ASKED_TOGETHER).any(|part| part.iter().any(|v| is_such(*v))),
            Self::Blocks(blocks) => blocks.any(is_such),
        }
    }

    /// True if another is the same memory.
    pub fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Rows(_, rows), Self::Rows(_, other)) => rows.is(other),
            (Self::Blocks(blocks), Self::Blocks(other)) => Arc::ptr_eq(blocks, other),
            _ => false,
        }
    }

    /// Fingerprint of the values and their storage.
    pub(super) fn hashed(&self, dims: [usize; 3]) -> Fingerprint {
        let mut digest = Digest::new("values");
        digest.plain(&self.storage()).plain(&dims);
        let mut row = vec![0.0; dims[0]];
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                self.row(0..dims[0], y, z, &mut row);
                digest.singles(&row);
            }
        }
        digest.finish()
    }

    /// The bytes that the values take.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Rows(_, values) => 4 * values.len() as u64,
            Self::Blocks(blocks) => blocks.bytes(),
        }
    }

    /// Storage precision of the values.
    pub fn storage(&self) -> Storage {
        match self {
            Self::Rows(..) => Storage::Single,
            Self::Blocks(blocks) => blocks.storage(),
        }
    }
}

#[inline(always)]
fn at_corners([[x0, x1], [y0, y1], [z0, z1]]: [[usize; 2]; 3], value: impl Fn(usize) -> f32) -> [f64; 8] {
    let at = |i: usize| f64::from(value(i));
    let row = |yz: usize| [at(yz + x0), at(yz + x1)];
    let [[a, b], [c, d], [e, f], [g, h]] = [row(y0 + z0), row(y1 + z0), row(y0 + z1), row(y1 + z1)];
    [a, b, c, d, e, f, g, h]
}
