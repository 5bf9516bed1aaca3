//! Requested part of an array, collected from its rows or voxels.

use std::cmp::Ordering;
use std::ops::Range;
use std::path::Path;

use barnard::blocks::Filling;
use barnard::data::{ArrayPart, Numbers};
use barnard::error::Error;
use barnard::memory;
use rayon::prelude::*;

use super::FileFloat;
use super::numbers::Stored;

/// Elements along each axis, the slowest first.
pub type BlockRange = [Range<usize>; 3];

/// The places along the slower axes of a block's lines, one after the other.
pub fn lines([slow, middle, _]: &BlockRange) -> impl Iterator<Item = [usize; 2]> + use<> {
    let (slow, middle) = (slow.clone(), middle.clone());
    slow.flat_map(move |i| middle.clone().map(move |j| [i, j]))
}

/// The blocks into which blocks of this size, the first at the beginning of the array, cut what is wanted of it.
pub fn cut(ranges: &BlockRange, edges: [usize; 3]) -> impl Iterator<Item = BlockRange> + use<> {
    let along = |axis: usize| {
        let (range, edge) = (ranges[axis].clone(), edges[axis].max(1));
        (range.start / edge..range.end.div_ceil(edge)).map(move |i| (i * edge).max(range.start)..((i + 1) * edge).min(range.end))
    };
    let [slow, middle, fast] = [0, 1, 2].map(along);
    slow.flat_map(move |i| {
        let fast = fast.clone();
        middle.clone().flat_map(move |j| {
            let i = i.clone();
            fast.clone().map(move |k| [i.clone(), j.clone(), k])
        })
    })
}

/// The elements of a part, or the means of blocks of them, in the order in which the file stores them.
pub struct Gather<T> {
    /// Requested part of the array.
    pub ranges: BlockRange,
    shape: [usize; 3],
    every: usize,
    clip: bool,
    store: GatheredValues<T>,
}

enum GatheredValues<T> {
    Elements(Vec<T>),
    /// Sums of blocks of elements, and what their means fill at the end, where it is not an array.
    Sums(Vec<f64>, Option<Filling>),
    Blocks(Filling),
}

impl<T: FileFloat> Gather<T> {
    /// Room for a part of the array of `path`, all of it zero, in at most `limit` bytes.
    ///
    /// # Errors
    /// If it takes more.
    pub fn new(part: &ArrayPart, fortran: bool, path: &Path, limit: u64) -> Result<Self, Error> {
        let (mut ranges, mut shape) = (part.ranges.clone(), part.shape());
        if fortran {
            ranges.reverse();
            shape.reverse();
        }
        let blocks = part.blocking.clone().map(|mut blocking| {
            // The axes of what comes, the slowest first.
            blocking.axes = blocking.axes.map(|axis| if fortran { 2 - axis } else { axis });
            // Sums are there as long as what they fill.
            let sums = if part.every > 1 { shape.iter().fold(8, |bytes: u64, edge| bytes.saturating_mul(*edge as u64)) } else { 0 };
            Filling::new(blocking, shape, path, limit.saturating_sub(sums))
        });
        let blocks = match blocks.transpose()? {
            Some(blocks) if part.every == 1 => {
                return Ok(Self { ranges, shape, every: 1, clip: part.clip, store: GatheredValues::Blocks(blocks) });
            }
            blocks => blocks,
        };
        let cells = shape.iter().fold(1u64, |cells, edge| cells.saturating_mul(*edge as u64));
        // Doubles that stay as they are count as singles: a grid holds those, and the limit is a grid's.
        let size = if part.every > 1 { 8 } else { 4 };
        memory::check(&format!("the array of {}", path.display()), cells.saturating_mul(size as u64), limit)?;
        let cells = cells as usize;
        let store =
            if part.every > 1 { GatheredValues::Sums(vec![0.0; cells], blocks) } else { GatheredValues::Elements(vec![T::of(0.0); cells]) };
        Ok(Self { ranges, shape, every: part.every, clip: part.clip, store })
    }

    /// Takes elements along the fastest axis from one on, all of them within the range.
    pub fn run(&mut self, [slow, middle, first]: [usize; 3], elements: impl Iterator<Item = T>) {
        let (i, j) = (self.cell(0, slow), self.cell(1, middle));
        let start = (i * self.shape[1] + j) * self.shape[2];
        let (first, every, clip) = (first - self.ranges[2].start, self.every, self.clip);
        let elements = elements.map(|v| clipped(v, clip));
        match &mut self.store {
            GatheredValues::Elements(stored) => stored[start + first..].iter_mut().zip(elements).for_each(|(element, v)| *element = v),
            GatheredValues::Sums(sums, _) => elements.zip(first..).for_each(|(v, i)| sums[start + i / every] += v.number()),
            GatheredValues::Blocks(blocks) => blocks.run(2, [i, j, first], elements.map(FileFloat::number)),
        }
    }

    /// Takes a cuboid of elements that all have one value, and of it what is within the ranges.
    pub fn fill(&mut self, cuboid: [Range<i64>; 3], value: T) {
        let value = clipped(value, self.clip);
        let [slow, middle, fast] = std::array::from_fn(|axis| self.shares(axis, &cuboid[axis]));
        for (i, by_slow) in slow {
            for (j, by_middle) in middle.clone() {
                let row = (i * self.shape[1] + j) * self.shape[2];
                match &mut self.store {
                    GatheredValues::Elements(elements) => fast.clone().for_each(|(k, _)| elements[row + k] = value),
                    GatheredValues::Sums(sums, _) => {
                        fast.clone().for_each(|(k, by_fast)| sums[row + k] += value.number() * (by_slow * by_middle * by_fast) as f64)
                    }
                    GatheredValues::Blocks(blocks) => {
                        let first = fast.clone().next().map_or(0, |(first, _)| first);
                        blocks.run(2, [i, j, first], fast.clone().map(|_| value.number()));
                    }
                }
            }
        }
    }

    /// The cell that an element belongs to, along an axis.
    fn cell(&self, axis: usize, element: usize) -> usize {
        (element - self.ranges[axis].start) / self.every
    }

    /// The cells along an axis that some elements belong to, with how many to each.
    fn shares(&self, axis: usize, elements: &Range<i64>) -> impl Iterator<Item = (usize, usize)> + Clone + use<T> {
        let range = &self.ranges[axis];
        let within = |at: i64| at.clamp(range.start as i64, range.end as i64) as usize - range.start;
        let (first, end, every) = (within(elements.start), within(elements.end), self.every);
        (first / every..end.div_ceil(every))
            .map(move |cell| (cell, ((cell + 1) * every).min(end).saturating_sub((cell * every).max(first))))
            .filter(|(_, count)| *count > 0)
    }

    /// Takes what is wanted of an array of this shape, the slowest axis first, whose numbers stand one behind the other.
    ///
    /// `fill` fills some bytes with those from a place on, counted from the first number; places only ever grow. `value`
    /// is what a number stands for.
    ///
    /// # Errors
    /// Errors of `fill`.
    pub fn rows(
        &mut self,
        shape: [usize; 3],
        stored: Stored,
        value: impl Fn(T) -> T,
        mut fill: impl FnMut(u64, &mut [u8]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let fast = self.ranges[2].clone();
        let mut bytes = vec![0; fast.len() * stored.size()];
        let mut elements = Vec::with_capacity(fast.len());
        for [i, j] in lines(&self.ranges) {
            let first = (i as u64 * shape[1] as u64 + j as u64) * shape[2] as u64 + fast.start as u64;
            fill(first * stored.size() as u64, &mut bytes)?;
            elements.clear();
            stored.decode(&bytes, |v| elements.push(value(v)));
            self.run([i, j, fast.start], elements.iter().copied());
        }
        Ok(())
    }

    /// Takes blocks of elements, the last index fastest within each, several of them unpacked at once.
    ///
    /// `fetch` gets what is stored of a block, one after the other; `unpack` makes its elements of that. A block takes
    /// `bytes` while it is unpacked, and no more of them are together than `limit` holds, but one.
    ///
    /// # Errors
    /// Errors of `fetch` and `unpack`, of the first block that has one.
    pub fn blocks<B: Send, E: Send>(
        &mut self,
        mut blocks: impl Iterator<Item = BlockRange>,
        (bytes, limit): (u64, u64),
        mut fetch: impl FnMut(&BlockRange) -> Result<B, E>,
        unpack: impl Fn(&BlockRange, B) -> Result<Vec<T>, E> + Sync,
    ) -> Result<(), E> {
        let together = usize::try_from(limit / bytes.max(1)).unwrap_or(usize::MAX).clamp(1, 2 * rayon::current_num_threads());
        loop {
            let fetched: Vec<_> = blocks.by_ref().take(together).map(|block| (fetch(&block), block)).collect();
            if fetched.is_empty() {
                return Ok(());
            }
            let unpacked_block = |(stored, block): (Result<B, E>, BlockRange)| (stored.and_then(|stored| unpack(&block, stored)), block);
            let unpacked: Vec<_> = fetched.into_par_iter().map(unpacked_block).collect();
            for (elements, block) in unpacked {
                for ([i, j], line) in lines(&block).zip(elements?.chunks(block[2].len())) {
                    self.run([i, j, block[2].start], line.iter().copied());
                }
            }
        }
    }

    /// Collected data.
    ///
    /// # Errors
    /// If blocks took more memory than they may.
    pub fn finish(self) -> Result<Numbers, Error> {
        let share = (self.every as f64).powi(-3);
        let [_, middle, fast] = self.shape;
        Ok(match self.store {
            GatheredValues::Elements(elements) => T::numbers(elements),
            GatheredValues::Sums(sums, None) => T::numbers(sums.iter().map(|sum| T::of(sum * share)).collect()),
            GatheredValues::Sums(sums, Some(mut blocks)) => {
                for (row, sums) in sums.chunks(fast).enumerate() {
                    blocks.run(2, [row / middle, row % middle, 0], sums.iter().map(|sum| T::of(sum * share).number()));
                }
                Numbers::Blocks(blocks.finish()?)
            }
            GatheredValues::Blocks(blocks) => Numbers::Blocks(blocks.finish()?),
        })
    }
}

/// A value as it counts.
fn clipped<T: FileFloat>(value: T, clip: bool) -> T {
    // What is no number is not above zero either.
    if clip && !matches!(value.number().partial_cmp(&0.0), Some(Ordering::Greater)) { T::of(0.0) } else { value }
}

/// A part of an array in memory that `label` calls, in at most `limit` bytes.
///
/// # Errors
/// If it takes more.
pub fn part_of(numbers: &Numbers, shape: [usize; 3], fortran: bool, part: &ArrayPart, label: &Path, limit: u64) -> Result<Numbers, Error> {
    fn gathered<T: FileFloat>(all: &[T], shape: [usize; 3], mut gather: Gather<T>) -> Result<Numbers, Error> {
        let fast = gather.ranges[2].clone();
        for [i, j] in lines(&gather.ranges) {
            let line = &all[(i * shape[1] + j) * shape[2]..];
            gather.run([i, j, fast.start], line[fast.clone()].iter().copied());
        }
        gather.finish()
    }
    let [a, b, c] = shape;
    let stored = if fortran { [c, b, a] } else { shape };
    match numbers {
        Numbers::Single(all) => gathered(all, stored, Gather::new(part, fortran, label, limit)?),
        Numbers::Double(all) => gathered(all, stored, Gather::new(part, fortran, label, limit)?),
        Numbers::Blocks(_) => Err(Error::file(label, "blocks are cut when they are made")),
    }
}
