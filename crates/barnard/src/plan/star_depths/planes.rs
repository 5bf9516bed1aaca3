//! Planes of a grid across any of its axes, as the frustums' sweeps read them.

use std::ops::Range;

use rayon::prelude::*;

use crate::field::Grid;

/// Planes that are copied together: a line of memory holds sixteen values.
const BLOCK: usize = 16;
/// The fewest rows that a thread takes.
pub const ROWS_TOGETHER: usize = 8;

/// The dust's planes along w, copied sixteen at a time, whichever way they lie in memory.
pub struct Planes<'a> {
    dust: &'a Grid,
    axes: [usize; 3],
    backwards: bool,
    /// Number of the first plane in `block`.
    first: usize,
    /// The σ of a block of planes, v × plane × u.
    block: Vec<f32>,
}

impl<'a> Planes<'a> {
    /// The planes of `dust`, w being the last of `axes`; they will be asked for one after the other, towards `sign`.
    pub fn new(dust: &'a Grid, axes: [usize; 3], sign: f64) -> Self {
        Self { dust, axes, backwards: sign < 0.0, first: 0, block: Vec::new() }
    }

    /// Writes σ on the plane at `w` [voxels of dust] within a window of columns and rows; what `out` holds elsewhere
    /// means nothing.
    pub fn slab(&mut self, w: f64, [columns, rows]: &[Range<usize>; 2], out: &mut Vec<f32>) {
        let [nu, nv, nw] = self.axes.map(|a| self.dust.lattice.dims[a]);
        let low = (w as usize).min(nw - 1);
        let high = (low + 1).min(nw - 1);
        let held = self.block.len() / (nu * nv);
        if low < self.first || high >= self.first + held {
            self.first = if self.backwards { (high + 1).saturating_sub(BLOCK) } else { low };
            self.copy(self.first, BLOCK.min(nw - self.first));
        }
        let held = self.block.len() / (nu * nv);
        let row = |k: usize, v: usize| &self.block[(v * held + k - self.first) * nu..][columns.clone()];
        out.resize(nu * nv, 0.0);
        let lines = out.par_chunks_exact_mut(nu).enumerate().skip(rows.start).take(rows.len()).with_min_len(ROWS_TOGETHER);
        lines.for_each(|(v, line)| mix(&mut line[columns.clone()], row(low, v), row(high, v), (w - low as f64) as f32));
    }

    fn copy(&mut self, first: usize, count: usize) {
        let [nx, ny, _] = self.dust.lattice.dims;
        let strides = [1, nx, nx * ny];
        let [nu, nv, _] = self.axes.map(|a| self.dust.lattice.dims[a]);
        let [du, dv, dw] = self.axes.map(|a| strides[a]);
        self.block.resize(count * nu * nv, 0.0);
        self.block.par_chunks_exact_mut(count * nu).enumerate().with_min_len(ROWS_TOGETHER).for_each(|(v, rows)| {
            if dw == 1 {
                for u in 0..nu {
                    let line = u * du + v * dv + first;
                    self.dust.run(line..line + count).enumerate().for_each(|(k, value)| rows[k * nu + u] = value);
                }
            } else {
                for (k, row) in rows.chunks_exact_mut(nu).enumerate() {
                    let line = v * dv + (first + k) * dw;
                    row.iter_mut().zip(self.dust.run(line..line + nu)).for_each(|(own, value)| *own = value);
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
