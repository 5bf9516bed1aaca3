//! Convolutions by Fourier transform.

use fourier::{Complex, transform};
use rayon::prelude::*;

use super::kernel::Kernel;

/// The convolution of pictures of one size with a kernel.
#[derive(Debug)]
pub(crate) struct Spread {
    width: usize,
    height: usize,
    dims: [usize; 3],
    /// The kernel's transform, over the number of values.
    factors: Vec<Complex<f64>>,
}

impl Spread {
    pub(crate) fn new(kernel: &Kernel, width: usize, height: usize) -> Self {
        let reach = kernel.reach;
        let dims = [smooth(width + reach), smooth(height + reach), 1];
        let (mut factors, count) = (vec![Complex::default(); dims[0] * dims[1]], (dims[0] * dims[1]) as f64);
        for (row, values) in kernel.values.chunks(2 * reach + 1).enumerate() {
            // The middle of the kernel is the first value; what is left of it or above comes from the other end.
            let wrapped = |at: usize, count: usize| (at + count - reach % count) % count;
            let out = &mut factors[wrapped(row, dims[1]) * dims[0]..][..dims[0]];
            let mut column = wrapped(0, dims[0]);
            for value in values {
                out[column] += value / count;
                column = if column + 1 == dims[0] { 0 } else { column + 1 };
            }
        }
        transform(&mut factors, dims, true);
        Self { width, height, dims, factors }
    }

    /// The bytes that it takes.
    pub(crate) fn bytes(&self) -> u64 {
        size_of_val(&self.factors[..]) as u64
    }

    /// Spreads the light of a picture whose rows are so far apart.
    pub(crate) fn apply(&self, values: &mut [f64], stride: usize) {
        let largest = |row: &[f64]| row[..self.width].iter().fold(0.0f64, |most, v| most.max(v.abs()));
        let level = values.par_chunks(stride).take(self.height).map(largest).reduce(|| f64::MIN_POSITIVE, f64::max);
        // The even picture is the imaginary part, which a real kernel keeps apart.
        let spread = self.convolved(values, stride, |value| Complex::new(value / level, 1.0));
        let rows = values.par_chunks_mut(stride).take(self.height).zip(spread.par_chunks(self.dims[0]));
        rows.for_each(|(row, spread)| row[..self.width].iter_mut().zip(spread).for_each(|(v, spread)| *v = level * spread.re / spread.im));
    }

    /// Spreads the light of a picture beyond whose edges there is none.
    pub(crate) fn within(&self, values: &mut [f64]) {
        let spread = self.convolved(values, self.width, |value| Complex::new(value, 0.0));
        let rows = values.par_chunks_mut(self.width).zip(spread.par_chunks(self.dims[0]));
        rows.for_each(|(row, spread)| row.iter_mut().zip(spread).for_each(|(v, spread)| *v = spread.re));
    }

    fn convolved(&self, values: &[f64], stride: usize, value: impl Fn(f64) -> Complex<f64> + Sync) -> Vec<Complex<f64>> {
        let mut data = vec![Complex::default(); self.factors.len()];
        let rows = data.par_chunks_mut(self.dims[0]).zip(values.par_chunks(stride).take(self.height));
        rows.for_each(|(out, row)| out.iter_mut().zip(&row[..self.width]).for_each(|(out, sample)| *out = value(*sample)));
        transform(&mut data, self.dims, true);
        data.par_iter_mut().zip(&self.factors).for_each(|(v, factor)| *v *= factor);
        transform(&mut data, self.dims, false);
        data
    }
}

/// The next number that twos, threes and fives make, of which transforms are fast.
fn smooth(at_least: usize) -> usize {
    let is_smooth = |number: &usize| {
        let rest = [2, 3, 5].into_iter().fold(*number, |mut rest, prime| {
            while rest % prime == 0 {
                rest /= prime;
            }
            rest
        });
        rest == 1
    };
    (at_least.max(1)..).find(is_smooth).unwrap_or(at_least)
}
