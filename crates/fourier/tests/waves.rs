//! Transforms of plane waves.

use fourier::{Complex, Complex32, real_part, transform, wave_number};

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
        data.push(Complex::new(angle.cos(), angle.sin()));
    }
    let before = data.clone();
    transform(&mut data, dims, true);
    for (i, value) in data.iter().enumerate() {
        let wave = (wave_number(i % 12, 12), wave_number(i / 12 % 5, 5), wave_number(i / 60, 7));
        let wanted = if wave == (kx, ky, kz) { data.len() as f64 } else { 0.0 };
        assert!((value - wanted).norm() < 1e-9, "{wave:?}: {value}");
    }
    transform(&mut data, dims, false);
    assert!(data.iter().zip(&before).all(|(a, b)| (a / 420.0 - b).norm() < 1e-12));
}

/// Real parts are those of the whole sum, for even and odd counts and axes of one value, of waves that no others mirror.
#[test]
fn real_parts_are_those_of_the_sum() {
    for dims in [[8, 6, 4], [7, 5, 3], [9, 4, 1], [1, 6, 5], [2, 1, 1], [1, 1, 1]] {
        let count = dims.iter().product::<usize>();
        let number = |i: usize| ((i as f32 * 12.9898).sin() * 43758.547).fract();
        let waves: Vec<Complex32> = (0..count).map(|i| Complex32::new(number(2 * i), number(2 * i + 1))).collect();
        let mut sums: Vec<Complex<f64>> = waves.iter().map(|w| Complex::new(f64::from(w.re), f64::from(w.im))).collect();
        transform(&mut sums, dims, false);
        let values = real_part(waves, dims);
        assert!(values.len() == count && sums.iter().zip(&values).all(|(sum, v)| (sum.re - f64::from(*v)).abs() < 2e-5), "{dims:?}");
    }
}
