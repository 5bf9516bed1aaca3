//! Phase tables as packets read them: what all terms are at one angle stands side by side, in whole quads.

use wide::f32x4;

use crate::packet::{LANES, Lane, four, lerp};

/// The table of a light, or of the nodes: entry × term.
#[derive(Debug)]
pub(super) struct PhaseRows {
    values: Vec<f32>,
    /// Values of an entry, with what fills its last quad; one where all terms scatter alike.
    stride: usize,
}

/// A place in a phase table for each ray.
pub(super) struct PhaseEntries {
    pub(super) entry: [u32; LANES],
    pub(super) fraction: Lane,
}

impl PhaseRows {
    /// A table of `values`, several per entry.
    pub(super) fn new(values: &[f32], columns: usize) -> Self {
        if columns == 1 {
            return Self { values: values.to_vec(), stride: 1 };
        }
        let stride = columns.next_multiple_of(4);
        let rows = values.chunks_exact(columns.max(1));
        Self { values: rows.flat_map(|row| row.iter().copied().chain(std::iter::repeat_n(0.0, stride - columns))).collect(), stride }
    }

    /// Room for what is spread, column × lane.
    pub(super) fn columns(&self) -> usize {
        self.stride
    }

    /// Writes `light` times what the table holds at these places, column × lane.
    #[inline(always)]
    pub(super) fn spread(&self, at: &PhaseEntries, light: &Lane, out: &mut [Lane]) {
        self.put::<false>(at, light, out);
    }

    /// Adds `light` times what the table holds at these places to column × lane.
    #[inline(always)]
    pub(super) fn add(&self, at: &PhaseEntries, light: &Lane, out: &mut [Lane]) {
        self.put::<true>(at, light, out);
    }

    #[inline(always)]
    fn put<const ADD: bool>(&self, at: &PhaseEntries, light: &Lane, out: &mut [Lane]) {
        if let [out] = out {
            for lane in 0..LANES {
                let pair = &self.values[at.entry[lane] as usize..][..2];
                let phase = light[lane] * (pair[0] + at.fraction[lane] * (pair[1] - pair[0]));
                out[lane] = if ADD { out[lane] + phase } else { phase };
            }
            return;
        }
        for first in (0..LANES).step_by(4) {
            for (quad, out) in out.chunks_exact_mut(4).enumerate() {
                let mut turning = [f32x4::ZERO; 4];
                for (i, values) in turning.iter_mut().enumerate() {
                    let lane = first + i;
                    let rows = &self.values[at.entry[lane] as usize * self.stride..][..2 * self.stride];
                    let (low, high) = (four(rows, 4 * quad), four(rows, self.stride + 4 * quad));
                    *values = lerp(low, high, f32x4::splat(at.fraction[lane])) * f32x4::splat(light[lane]);
                }
                for (out, row) in out.iter_mut().zip(f32x4::transpose(turning)) {
                    let sum = if ADD { four(out, first) + row } else { row };
                    out[first..first + 4].copy_from_slice(&sum.to_array());
                }
            }
        }
    }

    /// Table values of a term at one position.
    #[inline(always)]
    pub(super) fn at(&self, entry: u32, fraction: f32, term: usize) -> f32 {
        let row = entry as usize * self.stride + if self.stride == 1 { 0 } else { term };
        let (low, high) = (self.values[row], self.values[row + self.stride]);
        low + fraction * (high - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packet::lanes;

    /// What is spread and added is what the table holds between two entries, times the light, for every number of terms.
    #[test]
    fn rows_are_spread_term_by_term() {
        for columns in 1..=11 {
            let value = |entry: usize, column: usize| (1.3 * entry as f32 + 0.7 * column as f32).sin();
            let values: Vec<f32> = (0..9).flat_map(|entry| (0..columns).map(move |column| value(entry, column))).collect();
            let rows = PhaseRows::new(&values, columns);
            let entry = std::array::from_fn(|lane| lane as u32 % 8);
            let at = PhaseEntries { entry, fraction: lanes!(|lane| lane as f32 / 16.0) };
            let light = lanes!(|lane| 1.0 + lane as f32);
            let mut out = vec![[2.0; LANES]; rows.columns()];
            rows.spread(&at, &light, &mut out);
            rows.add(&at, &lanes!(|lane| 2.0 * light[lane]), &mut out);
            for lane in 0..LANES {
                for (column, share) in out.iter().enumerate().take(columns) {
                    let (i, f) = (entry[lane] as usize, at.fraction[lane]);
                    let table = value(i, column) + f * (value(i + 1, column) - value(i, column));
                    let truth = 3.0 * light[lane] * table;
                    assert!((share[lane] - truth).abs() < 3e-5, "{columns} {column} {lane}: {} {truth}", share[lane]);
                    assert!((rows.at(entry[lane], f, column) - table).abs() < 1e-6);
                }
            }
        }
    }
}
