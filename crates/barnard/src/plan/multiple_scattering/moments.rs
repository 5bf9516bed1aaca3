//! Moments of the radiance in cells, for terms side by side.

use rayon::prelude::*;

use super::lanes::{EightLanes, WIDTH};
use crate::field::Lattice;

/// Moments that a thread writes together: some pages of memory.
const TOUCHED_TOGETHER: usize = 1 << 12;

/// Moments of the radiance: cell × harmonic × term.
#[derive(Debug, Clone)]
pub struct Moments {
    /// The number of harmonics of a cell.
    pub count: usize,
    /// The moments, cell × harmonic × term.
    pub data: Vec<EightLanes>,
}

impl Moments {
    /// The bytes that the moments of a given number of cells take.
    pub fn bytes(cells: usize, count: usize) -> u64 {
        (size_of::<EightLanes>() as u64).saturating_mul(cells as u64).saturating_mul(count as u64)
    }

    /// The moments where there is no light.
    pub fn dark(cells: usize, count: usize) -> Self {
        let mut dark = Self { count, data: vec![[0.0; WIDTH]; cells * count] };
        // Memory that is read before it is written is found twice, and all threads must hear of it.
        dark.darken();
        dark
    }

    /// Puts out all light.
    pub fn darken(&mut self) {
        self.data.par_chunks_mut(TOUCHED_TOGETHER).for_each(|some| some.fill([0.0; WIDTH]));
    }

    /// The moments of a lattice from their numbers; `None` if these are too few or too many.
    pub fn from_flat(data: &[f32], lattice: &Lattice, count: usize) -> Option<Self> {
        let (data, rest) = data.as_chunks::<WIDTH>();
        (rest.is_empty() && data.len() == lattice.cells() * count).then(|| Self { count, data: data.to_vec() })
    }

    /// The moments of one cell, harmonic by harmonic.
    pub fn cell(&self, i: usize) -> &[EightLanes] {
        &self.data[i * self.count..][..self.count]
    }

    /// Adds what another has on a coarser lattice of the same box, trilinearly between its cells.
    pub fn add_interpolated(&mut self, fine: &Lattice, other: &Self, coarse: &Lattice) {
        let along = |axis: usize, i: usize| {
            let (n, m) = (fine.dims[axis], coarse.dims[axis]);
            let u = ((i as f64 + 0.5) * m as f64 / n as f64 - 0.5).clamp(0.0, (m - 1) as f64);
            let first = (u as usize).min(m.saturating_sub(2));
            (first, (first + 1).min(m - 1), (u - first as f64) as f32)
        };
        let columns: Vec<(usize, usize, f32)> = (0..fine.dims[0]).map(|x| along(0, x)).collect();
        let count = self.count;
        self.data.par_chunks_mut(fine.dims[0] * count).enumerate().for_each_init(Vec::new, |line, (row, out)| {
            let [_, y, z] = fine.place(row * fine.dims[0]);
            let ((y0, y1, fy), (z0, z1, fz)) = (along(1, y), along(2, z));
            let four = [(y0, z0, (1.0 - fy) * (1.0 - fz)), (y1, z0, fy * (1.0 - fz)), (y0, z1, (1.0 - fy) * fz), (y1, z1, fy * fz)];
            line.clear();
            line.resize(coarse.dims[0] * count, [0.0; WIDTH]);
            for (y, z, share) in four {
                let from = &other.data[coarse.index(0, y, z) * count..][..line.len()];
                line.iter_mut().zip(from).for_each(|(sum, value)| (0..WIDTH).for_each(|t| sum[t] += share * value[t]));
            }
            for (moments, (low, high, f)) in out.chunks_exact_mut(count).zip(&columns) {
                let (low, high) = (&line[low * count..][..count], &line[high * count..][..count]);
                for ((moment, low), high) in moments.iter_mut().zip(low).zip(high) {
                    (0..WIDTH).for_each(|t| moment[t] += low[t] + f * (high[t] - low[t]));
                }
            }
        });
    }

    /// Moves every value by −δ²/12 along each axis, not past nothing, so that what is trilinear between cells has the
    /// right mean over each.
    pub fn match_means(&mut self, fine: &Lattice) {
        let (dims, count) = (fine.dims, self.count);
        let strides = [1, dims[0], dims[0] * dims[1]].map(|stride| stride * count);
        let before = self.data.clone();
        self.data.par_chunks_mut(dims[0] * count).enumerate().for_each(|(row, out)| {
            let [_, y, z] = fine.place(row * dims[0]);
            for (i, value) in out.iter_mut().enumerate() {
                let (cell, at) = ([i / count, y, z], row * dims[0] * count + i);
                let mut second = [0.0; WIDTH];
                for axis in (0..3).filter(|axis| (1..dims[*axis].max(1) - 1).contains(&cell[*axis])) {
                    let (low, high) = (&before[at - strides[axis]], &before[at + strides[axis]]);
                    (0..WIDTH).for_each(|t| second[t] += low[t] + high[t] - 2.0 * before[at][t]);
                }
                (0..WIDTH).for_each(|t| value[t] = (value[t] - second[t] / 12.0).max(0.0));
            }
        });
    }
}
