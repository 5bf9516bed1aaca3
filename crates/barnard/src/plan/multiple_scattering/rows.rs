//! Moments of one term as sweeps read them: sixteen cells along x side by side.

use rayon::prelude::*;

use super::moments::Moments;
use crate::packet::{LANES, Lane};

/// Packets that a thread writes together: some pages of memory.
const TOUCHED_TOGETHER: usize = 1 << 11;

/// Numbers of each cell in rows along x: row × number × packet of sixteen cells. Rows stand along y, then along z.
#[derive(Debug, Clone)]
pub struct Rows {
    /// The number of cells along each axis.
    pub dims: [usize; 3],
    /// How many numbers a cell has.
    pub numbers: usize,
    data: Vec<Lane>,
}

impl Rows {
    /// Rows of zeros.
    pub fn zeroed(dims: [usize; 3], numbers: usize) -> Self {
        let [nx, ny, nz] = dims;
        let mut rows = Self { dims, numbers, data: vec![[0.0; LANES]; nx.div_ceil(LANES) * ny * nz * numbers] };
        // Memory that is read before it is written is found twice, and all threads must hear of it.
        rows.clear();
        rows
    }

    /// Rows of a function of (cell, number); cells count along x, then y, then z.
    pub fn from_function(dims: [usize; 3], numbers: usize, value: impl Fn(usize, usize) -> f32 + Sync) -> Self {
        let mut rows = Self::zeroed(dims, numbers);
        let (nx, packets, length) = (dims[0], rows.packets(), rows.row_length());
        rows.data.par_chunks_mut(length.max(1)).enumerate().for_each(|(row, out)| {
            for (i, packet) in out.iter_mut().enumerate() {
                let (number, first) = (i / packets, i % packets * LANES);
                let cells = first..(first + LANES).min(nx);
                packet.iter_mut().zip(cells).for_each(|(out, x)| *out = value(row * nx + x, number));
            }
        });
        rows
    }

    /// The moments of one term.
    pub fn of_term(dims: [usize; 3], moments: &Moments, term: usize) -> Self {
        Self::from_function(dims, moments.count, |cell, harmonic| moments.data[cell * moments.count + harmonic][term])
    }

    /// Writes them as the moments of one term.
    pub fn write(&self, moments: &mut Moments, term: usize) {
        let (nx, count, packets) = (self.dims[0], moments.count, self.packets());
        moments.data.par_chunks_mut((nx * count).max(1)).enumerate().for_each(|(row, out)| {
            let values = self.row(row);
            for (x, cell) in out.chunks_exact_mut(count).enumerate() {
                let of_cell = values.chunks_exact(packets).map(|number| number[x / LANES][x % LANES]);
                cell.iter_mut().zip(of_cell).for_each(|(lanes, value)| lanes[term] = value);
            }
        });
    }

    /// Packets along a row.
    pub fn packets(&self) -> usize {
        self.dims[0].div_ceil(LANES)
    }

    /// Packets of a row: of each number.
    pub fn row_length(&self) -> usize {
        self.packets() * self.numbers
    }

    /// A row: number × packet.
    pub fn row(&self, row: usize) -> &[Lane] {
        &self.data[row * self.row_length()..][..self.row_length()]
    }

    /// All rows from one on.
    pub fn rows_from(&mut self, row: usize) -> &mut [Lane] {
        let first = row * self.row_length();
        &mut self.data[first..]
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.data.par_chunks_mut(TOUCHED_TOGETHER).for_each(|some| some.fill([0.0; LANES]));
    }

    /// Adds what another has, by a factor.
    pub fn add(&mut self, other: &Self, factor: f32) {
        let pairs = self.data.par_iter_mut().zip(&other.data).with_min_len(TOUCHED_TOGETHER);
        pairs.for_each(|(values, other)| values.iter_mut().zip(other).for_each(|(value, other)| *value += factor * other));
    }

    /// Adds what another has whose x stands along y here, and whose y along x.
    pub fn add_turned(&mut self, other: &Self) {
        let (packets, ny) = (self.packets(), self.dims[1]);
        let (numbers, length) = (self.numbers, self.row_length());
        // Sixteen rows at once: blocks of sixteen cells either way.
        self.data.par_chunks_mut(ny * length).enumerate().for_each(|(z, slab)| {
            for y in (0..ny).step_by(LANES) {
                for number in 0..numbers {
                    for packet in 0..packets {
                        let mut block = [[0.0; LANES]; LANES];
                        let across = other.dims[1] - packet * LANES;
                        for (i, line) in block.iter_mut().enumerate().take(across) {
                            let row = other.row(z * other.dims[1] + packet * LANES + i);
                            *line = row[number * other.packets() + y / LANES];
                        }
                        for (i, row) in slab[y * length..].chunks_exact_mut(length).enumerate().take(LANES) {
                            let values = &mut row[number * packets + packet];
                            values.iter_mut().zip(&block).for_each(|(value, line)| *value += line[i]);
                        }
                    }
                }
            }
        });
    }

    /// Copy whose rows stand along y.
    pub fn turned(&self) -> Self {
        let [nx, ny, nz] = self.dims;
        let mut turned = Self::zeroed([ny, nx, nz], self.numbers);
        turned.add_turned(self);
        turned
    }

    /// The sum of the first number of every cell, by weights that have one number.
    pub fn weighted(&self, weights: &Self) -> f64 {
        let (nx, rows) = (self.dims[0], self.dims[1] * self.dims[2]);
        let of_row = |row: usize| -> f64 {
            let pairs = self.row(row).as_flattened()[..nx].iter().zip(&weights.row(row).as_flattened()[..nx]);
            pairs.map(|(value, weight)| f64::from(*value) * f64::from(*weight)).sum()
        };
        (0..rows).map(of_row).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::lanes::WIDTH;
    use super::*;

    /// Moments come back as they were, rows that are turned are those of turned moments, and sums are those over all cells.
    #[test]
    fn rows_hold_all_cells() {
        for dims in [[5, 7, 3], [40, 17, 2], [16, 33, 1], [1, 1, 9]] {
            let [nx, ny, nz] = dims;
            let value = |x: usize, y: usize, z: usize, h: usize| (x + 100 * y + 10_000 * z) as f32 + 0.25 * h as f32;
            let of_cell = |cell: usize, h: usize| value(cell % nx, cell / nx % ny, cell / (nx * ny), h);
            let mut moments = Moments::dark(nx * ny * nz, 3);
            for (i, lanes) in moments.data.iter_mut().enumerate() {
                lanes[2] = of_cell(i / 3, i % 3);
            }
            let rows = Rows::of_term(dims, &moments, 2);
            let mut back = Moments::dark(nx * ny * nz, 3);
            rows.write(&mut back, 2);
            assert!(back.data == moments.data);
            let turned = Rows::from_function([ny, nx, nz], 3, |cell, h| value(cell / ny % nx, cell % ny, cell / (nx * ny), h));
            assert!(rows.turned().data == turned.data && turned.turned().data == rows.data && (nx == 1 || rows.data != turned.data));
            let weights = Rows::from_function(dims, 1, |cell, _| (cell % 3) as f32);
            let sum: f64 = (0..nx * ny * nz).map(|cell| f64::from(of_cell(cell, 0)) * (cell % 3) as f64).sum();
            assert!((rows.weighted(&weights) - sum).abs() < 1e-9 * sum && back.data[0].len() == WIDTH);
        }
    }
}
