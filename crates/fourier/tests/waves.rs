//! Transforms of plane waves.

use fourier::{Complex, Complex32, transform, transform_singles, wave_number};

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
    transform_singles(&mut data, dims, true);
    for (i, value) in data.iter().enumerate() {
        let wave = (wave_number(i % 12, 12), wave_number(i / 12 % 5, 5), wave_number(i / 60, 7));
        let wanted = if wave == (kx, ky, kz) { data.len() as f32 } else { 0.0 };
        assert!((value - Complex32::new(wanted, 0.0)).norm() < 1e-3, "{wave:?}: {value}");
    }
    transform_singles(&mut data, dims, false);
    assert!(data.iter().zip(&before).all(|(a, b)| (a / 420.0 - b).norm() < 1e-5));
}
