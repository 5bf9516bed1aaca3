//! Planes of a grid across any of its axes, as the frustums' sweeps read them.

use std::ops::Range;

use rayon::prelude::*;

use crate::field::Grid;
use crate::volume::ROWS_TOGETHER;

/// Planes that are copied together: a line of memory holds sixteen values.
pub const BLOCK: usize = 16;

/// Dust, or the part of it that is at hand; places are counted in the whole.
#[derive(Clone, Copy)]
pub struct DustWindow<'a> {
    /// The extinction σ at V of the part [pc⁻¹].
    pub grid: &'a Grid,
    /// The voxel of the whole that is the part's first.
    pub first: [usize; 3],
    /// Voxels of the whole along x, y, z.
    pub dims: [usize; 3],
}

impl<'a> DustWindow<'a> {
    /// All of the dust.
    pub fn whole(grid: &'a Grid) -> Self {
        Self { grid, first: [0; 3], dims: grid.lattice().dims }
    }

    /// Voxels of the part along an axis.
    pub fn stored(&self, axis: usize) -> Range<usize> {
        self.first[axis]..self.first[axis] + self.grid.lattice().dims[axis]
    }
}

/// The part of a range that lies in another, counted from where that begins.
pub fn within(range: &Range<usize>, stored: &Range<usize>) -> Range<usize> {
    let place = |i: usize| i.clamp(stored.start, stored.end) - stored.start;
    place(range.start)..place(range.end)
}

/// The dust's planes along w, copied sixteen at a time, whichever way they lie in memory.
pub struct Planes<'a> {
    dust: DustWindow<'a>,
    axes: [usize; 3],
    backwards: bool,
    /// Number of the first plane in `block`.
    first: usize,
    /// The σ of a block of planes, v × plane × u.
    block: Vec<f32>,
    /// The columns and rows of it that are copied.
    copied: [Range<usize>; 2],
}

impl<'a> Planes<'a> {
    /// The planes of `dust`, w being the last of `axes`; they will be asked for one after the other, towards `sign`.
    pub fn new(dust: DustWindow<'a>, axes: [usize; 3], sign: f64) -> Self {
        Self { dust, axes, backwards: sign < 0.0, first: 0, block: Vec::new(), copied: [0..0, 0..0] }
    }

    /// Writes σ on the plane at `w` [voxels of dust] within a window of the part's columns and rows; values of `out` elsewhere
    /// are arbitrary. `far` is the window on the last plane of the block that is copied at once.
    pub fn slab(&mut self, w: f64, [columns, rows]: &[Range<usize>; 2], far: &[Range<usize>; 2], out: &mut Vec<f32>) {
        let [nu, nv, nw] = self.axes.map(|a| self.dust.grid.lattice().dims[a]);
        let (whole, first) = (self.dust.dims[self.axes[2]], self.dust.first[self.axes[2]]);
        let plane = (w as usize).min(whole - 1);
        let local = |plane: usize| plane.min(whole - 1).saturating_sub(first).min(nw - 1);
        let (low, high) = (local(plane), local(plane + 1));
        let row_length = self.block.len() / (nu * nv);
        let is_copied = |part: &Range<usize>, copied: &Range<usize>| part.start >= copied.start && part.end <= copied.end;
        let [copied_columns, copied_rows] = &self.copied;
        if low < self.first || high >= self.first + row_length || !is_copied(columns, copied_columns) || !is_copied(rows, copied_rows) {
            self.first = if self.backwards { (high + 1).saturating_sub(BLOCK) } else { low };
            let union = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
            self.copied = [union(columns, &far[0]), union(rows, &far[1])];
            self.copy(self.first, BLOCK.min(nw - self.first));
        }
        let row_length = self.block.len() / (nu * nv);
        let row = |k: usize, v: usize| &self.block[(v * row_length + k - self.first) * nu..][columns.clone()];
        out.resize(nu * nv, 0.0);
        let lines = out.par_chunks_exact_mut(nu).enumerate().skip(rows.start).take(rows.len()).with_min_len(ROWS_TOGETHER);
        lines.for_each(|(v, line)| mix(&mut line[columns.clone()], row(low, v), row(high, v), (w - plane as f64) as f32));
    }

    fn copy(&mut self, first: usize, count: usize) {
        let grid = self.dust.grid;
        let ([nu, nv, _], across) = (self.axes.map(|a| grid.lattice().dims[a]), self.axes[2]);
        if self.block.len() != count * nu * nv {
            // Memory that is never written is never found.
            self.block = vec![0.0; count * nu * nv];
        }
        let [columns, rows] = self.copied.clone();
        let lines = self.block.par_chunks_exact_mut(count * nu).enumerate().skip(rows.start).take(rows.len());
        lines.with_min_len(ROWS_TOGETHER).for_each(|(v, rows)| {
            if across == 0 {
                let mut line = [0.0; BLOCK];
                let line = &mut line[..count];
                for u in columns.clone() {
                    grid.row(first..first + count, u, v, line);
                    line.iter().enumerate().for_each(|(k, value)| rows[k * nu + u] = *value);
                }
            } else {
                for (k, row) in rows.chunks_exact_mut(nu).enumerate() {
                    let (y, z) = if across == 1 { (first + k, v) } else { (v, first + k) };
                    grid.row(columns.clone(), y, z, &mut row[columns.clone()]);
                }
            }
        });
    }
}

/// Writes a + f (b − a), value by value.
pub fn mix(out: &mut [f32], a: &[f32], b: &[f32], f: f32) {
    for ((o, a), b) in out.iter_mut().zip(a).zip(b) {
        *o = a + f * (b - a);
    }
}
