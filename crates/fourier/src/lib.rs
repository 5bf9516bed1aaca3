//! Fourier transforms of arrays with up to three axes, on all cores, the same bits on any number of threads.
//!
//! A crate of its own, because the algorithms of `rustfft` are compiled where their type is chosen: here once for each
//! precision, and not again in every test of what uses them.

use rayon::prelude::*;
pub use rustfft::num_complex::{Complex, Complex32};
use rustfft::{FftDirection, FftNum, FftPlanner};

/// Bytes that a transform in single precision takes for each value, its input included.
pub const BYTES: u64 = 2 * size_of::<Complex32>() as u64;

/// Replaces an array of `dims` values, the first axis running fastest, by its transform along all axes, without a factor:
/// Σ v e^(∓2πi jk/n), minus `forward`.
///
/// # Panics
/// If the length of the array is not the product of `dims`.
pub fn transform(data: &mut Vec<Complex<f64>>, dims: [usize; 3], forward: bool) {
    along_all_axes(data, dims, forward);
}

/// Variant in single precision.
///
/// # Panics
/// If the length of the array is not the product of `dims`.
pub fn transform_singles(data: &mut Vec<Complex32>, dims: [usize; 3], forward: bool) {
    along_all_axes(data, dims, forward);
}

fn along_all_axes<T: FftNum>(data: &mut Vec<Complex<T>>, dims: [usize; 3], forward: bool) {
    assert_eq!(data.len(), dims.iter().product::<usize>(), "values of a transform");
    let direction = if forward { FftDirection::Forward } else { FftDirection::Inverse };
    let mut turned = vec![Complex::new(T::zero(), T::zero()); data.len()];
    let [mut nx, mut ny, mut nz] = dims;
    for _ in 0..3 {
        if nx > 1 {
            let plan = FftPlanner::new().plan_fft(nx, direction);
            data.par_chunks_mut(nx * TOGETHER).for_each(|rows| plan.process(rows));
            // Turning an axis of one value moves nothing.
            rotate(data, [nx, ny, nz], &mut turned);
            std::mem::swap(data, &mut turned);
        }
        [nx, ny, nz] = [ny, nz, nx];
    }
}

/// Rows that are turned together, so that lines of memory are used whole.
const TOGETHER: usize = 16;

/// Turns an array so that its second axis runs fastest, and its first slowest.
fn rotate<T: FftNum>(data: &[Complex<T>], [nx, ny, nz]: [usize; 3], out: &mut [Complex<T>]) {
    // Value (x, y, z) goes to place (y, z, x).
    out.par_chunks_mut(ny * nz * TOGETHER).enumerate().for_each(|(block, out)| {
        let (first, count) = (block * TOGETHER, out.len() / (ny * nz));
        for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
            let row = &data[(z * ny + y) * nx + first..][..count];
            row.iter().enumerate().for_each(|(x, value)| out[(x * nz + z) * ny + y] = *value);
        }
    });
}

/// The signed number of the wave that value `index` of `count` stands for after a transform.
pub fn wave_number(index: usize, count: usize) -> i64 {
    if index <= count / 2 { index as i64 } else { index as i64 - count as i64 }
}
