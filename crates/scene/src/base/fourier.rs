//! Fourier transforms of arrays with up to three axes, on all cores, the same bits on any number of threads.

use rayon::prelude::*;
pub use rustfft::num_complex::{Complex, Complex32};
use rustfft::{FftDirection, FftNum, FftPlanner};

/// Bytes that a transform in single precision takes for each value, its input included.
pub const BYTES: u64 = 2 * size_of::<Complex32>() as u64;

/// Replaces an array of `dims` values, the first axis running fastest, by its transform along all axes, without a factor:
/// Σ v e^(∓2πi jk/n), minus `forward`.
///
/// # Panics
/// Where the array has another length.
pub fn transform<T: FftNum>(data: &mut Vec<Complex<T>>, dims: [usize; 3], forward: bool) {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture, which has an axis of one value, is the array of its plane waves, whichever axis that is.
    #[test]
    fn axes_of_one_value_move_nothing() {
        for dims in [[6, 4, 1], [6, 1, 4], [1, 6, 4]] {
            let wave = |i: usize| Complex::from_polar(1.0, std::f64::consts::TAU * ((i % 6) as f64 / 6.0 + 2.0 * (i / 6) as f64 / 4.0));
            let mut data: Vec<Complex<f64>> = (0..24).map(wave).collect();
            transform(&mut data, dims, true);
            for (i, value) in data.iter().enumerate() {
                let wanted = if i == 2 * 6 + 1 { 24.0 } else { 0.0 };
                assert!((value - wanted).norm() < 1e-12, "{dims:?} {i}: {value}");
            }
        }
    }

    /// A plane wave becomes one value at its wave numbers, on axes of different lengths, and comes back.
    #[test]
    fn waves_have_one_value() {
        let dims = [12, 5, 7];
        let (kx, ky, kz) = (-3i64, 2i64, -1i64);
        let mut data = Vec::new();
        for (z, y, x) in (0..7).flat_map(|z| (0..5).flat_map(move |y| (0..12).map(move |x| (z, y, x)))) {
            let turns = kx as f64 * x as f64 / 12.0 + ky as f64 * y as f64 / 5.0 + kz as f64 * z as f64 / 7.0;
            let angle = std::f64::consts::TAU * turns;
            data.push(Complex32::new(angle.cos() as f32, angle.sin() as f32));
        }
        let before = data.clone();
        transform(&mut data, dims, true);
        for (i, value) in data.iter().enumerate() {
            let wave = (wave_number(i % 12, 12), wave_number(i / 12 % 5, 5), wave_number(i / 60, 7));
            let wanted = if wave == (kx, ky, kz) { data.len() as f32 } else { 0.0 };
            assert!((value - Complex32::new(wanted, 0.0)).norm() < 1e-3, "{wave:?}: {value}");
        }
        transform(&mut data, dims, false);
        assert!(data.iter().zip(&before).all(|(a, b)| (a / 420.0 - b).norm() < 1e-5));
    }
}
