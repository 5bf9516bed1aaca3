//! One octave of noise: simplex noise of variance one, in single precision by lanes and in double precision, from one text.
//!
//! n(p) = Σ_corners max(0, ½ − r²)⁴ (g · r) over its own deviation, g one of the eight diagonals of a cube by a hash of the corner
//! and the seed. With ½ each corner ends within its simplices: n has three derivatives everywhere. Source: Perlin 2001;
//! Gustavson 2005, "Simplex noise demystified".
//!
//! Its correlation passes zero at 0.48 and is least at 0.6: [`WAVELENGTH`] is twice that.

use std::ops::{Add, Mul};

/// The wavelength of the strongest waves, in units of the noise's place.
pub const WAVELENGTH: f64 = 1.2;
/// 1 over the deviation of the sum over corners.
pub const NORM: f64 = 159.93;
/// Upper bound of all values: 2.57 is the largest of 2e7 places.
pub const MOST: f64 = 2.6;
/// Cumulants of the values beyond the second, the fourth and the sixth, from 2e7 places.
pub const CUMULANTS: (f32, f32) = (-0.336, -0.21);
/// Combination of the three numbers of a corner.
const ROWS: [u32; 3] = [0x8da6_b343, 0xd816_3841, 0xcb1a_b31f];

/// ln of the mean of e^(s n), for |s| ≤ 1.5.
#[inline(always)]
pub fn log_mean<T: Copy + Mul<Output = T> + Add<Output = T> + From<f32>>(s: T) -> T {
    let (square, number) = (s * s, T::from);
    square * (number(0.5) + square * (number(CUMULANTS.0 / 24.0) + square * number(CUMULANTS.1 / 720.0)))
}

/// n(p) \[1\] in single precision.
#[inline(always)]
pub fn single(p: [f32; 3], seed: u32) -> f32 {
    noise!(p, seed, single_corner, f32, 12_582_912.0)
}

/// n(p) \[1\] in double precision.
#[inline(always)]
pub fn double(p: [f64; 3], seed: u32) -> f64 {
    noise!(p, seed, double_corner, f64, 6_755_399_441_055_744.0)
}

/// Contribution of a corner at a position relative to it; `rows` are those of the first corner; the steps lead from there to it.
#[inline(always)]
fn single_corner(rows: [u32; 3], steps: [bool; 3], seed: u32, at: [f32; 3]) -> f32 {
    corner!(rows, steps, seed, at, f32, u32)
}

#[inline(always)]
fn double_corner(rows: [u32; 3], steps: [bool; 3], seed: u32, at: [f64; 3]) -> f64 {
    corner!(rows, steps, seed, at, f64, u64)
}

/// The noise in one precision: `whole` is 1.5 times the first number that has no fraction; adding it rounds to an integer,
/// which then stands in the low bits.
macro_rules! noise {
    ($p:expr, $seed:expr, $corner:ident, $real:ty, $whole:expr) => {{
        let (p, seed): ([$real; 3], u32) = ($p, $seed);
        // Skew to find the simplex, unskew to measure distances; rounding what is less by a half is the floor.
        let skew = (p[0] + p[1] + p[2]) * (1.0 / 3.0) - 0.5;
        let rounded = [p[0] + skew + $whole, p[1] + skew + $whole, p[2] + skew + $whole];
        let cell = [rounded[0] - $whole, rounded[1] - $whole, rounded[2] - $whole];
        let unskew = (cell[0] + cell[1] + cell[2]) * (1.0 / 6.0);
        let d = [p[0] - (cell[0] - unskew), p[1] - (cell[1] - unskew), p[2] - (cell[2] - unskew)];
        // Steps from the first corner along the largest, then the second largest coordinate.
        let (xy, yz, xz) = (d[0] >= d[1], d[1] >= d[2], d[0] >= d[2]);
        let (second, third) = ([xy & xz, !xy & yz, !xz & !yz], [xy | xz, !xy | yz, !xz | !yz]);
        let whole = |axis: usize| (rounded[axis].to_bits() as u32).wrapping_sub((<$real>::to_bits($whole)) as u32);
        let rows = [whole(0).wrapping_mul(ROWS[0]), whole(1).wrapping_mul(ROWS[1]), whole(2).wrapping_mul(ROWS[2])];
        let away = |axis: usize, step: bool, unskew: $real| d[axis] - if step { 1.0 - unskew } else { -unskew };
        let at = |steps: [bool; 3], unskew: $real| [away(0, steps[0], unskew), away(1, steps[1], unskew), away(2, steps[2], unskew)];
        let first = $corner(rows, [false; 3], seed, d) + $corner(rows, second, seed, at(second, 1.0 / 6.0));
        let last = $corner(rows, third, seed, at(third, 1.0 / 3.0)) + $corner(rows, [true; 3], seed, at([true; 3], 0.5));
        NORM as $real * (first + last)
    }};
}
use noise;

/// A corner in one precision of a number of bits.
macro_rules! corner {
    ($rows:expr, $steps:expr, $seed:expr, $at:expr, $real:ty, $bits:ty) => {{
        let [x, y, z]: [$real; 3] = $at;
        let row = |axis: usize| $rows[axis].wrapping_add(if $steps[axis] { ROWS[axis] } else { 0 });
        let hash = mixed(row(0) ^ row(1) ^ row(2) ^ $seed);
        let falloff = 0.5 - (x * x + y * y + z * z);
        let falloff = if falloff > 0.0 { falloff } else { 0.0 };
        const SIGN: $bits = 1 << (<$bits>::BITS - 1);
        let signed = |v: $real, bit: u32| <$real>::from_bits(v.to_bits() ^ (((hash as $bits) << (<$bits>::BITS - 32 + bit)) & SIGN));
        (falloff * falloff) * (falloff * falloff) * (signed(x, 0) + signed(y, 1) + signed(z, 2))
    }};
}
use corner;

/// A number whose highest bits look random.
#[inline(always)]
fn mixed(h: u32) -> u32 {
    let h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    (h ^ (h >> 12)).wrapping_mul(0x297a_2d39)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Counter;

    fn place(i: u64) -> [f64; 3] {
        let mut random = Counter::new(9, i);
        [0; 3].map(|_| 900.0 * (random.uniform() - 0.5))
    }

    /// Mean, variance, bounds and the mean of e^(s n), over a million places of three seeds.
    #[test]
    fn moments_are_as_stated() {
        let values: Vec<f64> = (0..1_000_000).map(|i| double(place(i), [1, 77, 0xffff_ffff][i as usize % 3])).collect();
        let mean = |f: &dyn Fn(f64) -> f64| values.iter().map(|v| f(*v)).sum::<f64>() / values.len() as f64;
        assert!(mean(&|v| v).abs() < 4e-3 && (mean(&|v| v * v) - 1.0).abs() < 5e-3, "{} {}", mean(&|v| v), mean(&|v| v * v));
        assert!(values.iter().all(|v| v.abs() < MOST));
        for s in [0.2, 0.5, 1.0, 1.5] {
            let found = mean(&|v| (s * v).exp()).ln();
            assert!((found - log_mean(s)).abs() < 4e-3 * s + 2e-3 * s.powi(6), "{s}: {found} {}", log_mean(s));
        }
        // A normal distribution's mean would be seen.
        assert!((log_mean(1.5f64) - 1.125).abs() > 0.06);
    }

    /// Both precisions are one noise.
    #[test]
    fn precisions_agree() {
        let mut worst = 0.0f64;
        for i in 0..50_000 {
            let p = place(i).map(|x| x as f32);
            worst = worst.max((double(p.map(f64::from), 5) - f64::from(single(p, 5))).abs());
        }
        assert!(worst > 0.0 && worst < 2e-3, "{worst}");
    }

    /// The noise is continuous, and so is its slope: halving a step halves a difference, and quarters a second one.
    #[test]
    fn noise_is_smooth() {
        for i in 0..20_000 {
            let (p, h) = (place(i), 1e-4);
            let at = |t: f64| double([p[0] + t, p[1] - 0.7 * t, p[2] + 0.4 * t], 3);
            assert!((at(h) - at(0.0)).abs() < 30.0 * h && (at(h) - 2.0 * at(0.0) + at(-h)).abs() < 400.0 * h * h);
        }
    }

    /// Its waves have about the stated length: values half of it apart are opposed to each other, those a tenth of it apart alike.
    #[test]
    fn waves_have_their_length() {
        let correlation = |r: f64| {
            let product = |i: u64| {
                let p = place(i);
                let mut random = Counter::new(4, i);
                let (z, turn) = (2.0 * random.uniform() - 1.0, std::f64::consts::TAU * random.uniform());
                let aside = r * (1.0 - z * z).sqrt();
                double(p, 8) * double([p[0] + aside * turn.cos(), p[1] + aside * turn.sin(), p[2] + r * z], 8)
            };
            (0..200_000).map(product).sum::<f64>() / 200_000.0
        };
        assert!(correlation(0.1 * WAVELENGTH) > 0.8 && correlation(WAVELENGTH).abs() < 0.02);
        assert!((-0.09..-0.05).contains(&correlation(0.5 * WAVELENGTH)), "{}", correlation(0.5 * WAVELENGTH));
    }
}
