//! Fourier transforms of arrays with up to three axes, on all cores, the same bits on any number of threads.
//!
//! A crate of its own, because the algorithms of `rustfft` are compiled where their type is chosen: here once for each
//! precision, and not again in every test of what uses them.

use rayon::prelude::*;
pub use rustfft::num_complex::{Complex, Complex32};
use rustfft::{FftDirection, FftNum, FftPlanner};

/// Most bytes that [`real_part`] takes for each value, its input included.
pub const BYTES: u64 = 2 * size_of::<Complex32>() as u64;

/// Replaces an array of `dims` values, the first axis running fastest, by its transform along all axes, without a factor:
/// Σ v e^(∓2πi jk/n), minus `forward`.
///
/// # Panics
/// If the length of the array is not the product of `dims`.
pub fn transform(data: &mut Vec<Complex<f64>>, dims: [usize; 3], forward: bool) {
    assert_eq!(data.len(), dims.iter().product::<usize>(), "values of a transform");
    let direction = if forward { FftDirection::Forward } else { FftDirection::Inverse };
    let mut turned = vec![Complex::default(); data.len()];
    let mut dims = dims;
    for _ in 0..3 {
        along_first_axis(data, dims[0], direction);
        turn(data, &mut dims, &mut turned);
    }
}

/// Real part of the sum of waves, Re Σ w e^(2πi jk/n) along all axes of `dims`, the first running fastest.
///
/// With h_k = (w_k + w*_(−k))/2 the sum itself is real: half of its waves and two of its rows in each transform suffice.
///
/// # Panics
/// If the length of the array is not the product of `dims`.
pub fn real_part(waves: Vec<Complex32>, dims: [usize; 3]) -> Vec<f32> {
    assert_eq!(waves.len(), dims.iter().product::<usize>(), "values of a transform");
    let [nx, ny, nz] = dims;
    let half = nx / 2 + 1;
    let opposite = |index: usize, count: usize| (count - index) % count;
    let mut folded = vec![Complex32::default(); half * ny * nz];
    folded.par_chunks_mut(half).enumerate().for_each(|(row, out)| {
        let other_row = opposite(row / ny, nz) * ny + opposite(row % ny, ny);
        let [here, there] = [row, other_row].map(|row| &waves[row * nx..][..nx]);
        out.iter_mut().enumerate().for_each(|(x, h)| *h = 0.5 * (here[x] + there[opposite(x, nx)].conj()));
    });
    drop(waves);
    let mut turned = vec![Complex32::default(); folded.len()];
    let mut of_folded = [half, ny, nz];
    for _ in 0..2 {
        turn(&mut folded, &mut of_folded, &mut turned);
        along_first_axis(&mut folded, of_folded[0], FftDirection::Inverse);
    }
    turn(&mut folded, &mut of_folded, &mut turned);
    drop(turned);
    let plan = FftPlanner::new().plan_fft(nx, FftDirection::Inverse);
    let mut values = vec![0.0; nx * ny * nz];
    let rows = values.par_chunks_mut(2 * nx).zip(folded.par_chunks(2 * half));
    rows.for_each_init(
        || vec![Complex32::default(); nx],
        |row, (out, waves)| {
            // One row of values becomes the real part, the next the imaginary part.
            let (first, second) = waves.split_at(half);
            let wave = |of_row: &[Complex32], x: usize| if x < half { of_row[x] } else { of_row[nx - x].conj() };
            row.iter_mut().enumerate().for_each(|(x, sum)| *sum = wave(first, x));
            if !second.is_empty() {
                row.iter_mut().enumerate().for_each(|(x, sum)| *sum += Complex32::i() * wave(second, x));
            }
            plan.process(row);
            let (real, imaginary) = out.split_at_mut(nx);
            real.iter_mut().zip(&*row).for_each(|(value, sum)| *value = sum.re);
            imaginary.iter_mut().zip(&*row).for_each(|(value, sum)| *value = sum.im);
        },
    );
    values
}

/// Transforms each row of `count` values.
fn along_first_axis<T: FftNum>(data: &mut [Complex<T>], count: usize, direction: FftDirection) {
    if count > 1 {
        let plan = FftPlanner::new().plan_fft(count, direction);
        data.par_chunks_mut(count * TOGETHER).for_each(|rows| plan.process(rows));
    }
}

/// Turns an array so that its second axis runs fastest, and its first slowest; `turned` is room for as many values.
fn turn<T: FftNum>(data: &mut Vec<Complex<T>>, dims: &mut [usize; 3], turned: &mut Vec<Complex<T>>) {
    if dims[0] > 1 {
        rotate(data, *dims, turned);
        std::mem::swap(data, turned);
    }
    // An axis of one value moves nothing.
    dims.rotate_left(1);
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
