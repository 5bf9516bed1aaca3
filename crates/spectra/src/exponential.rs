//! Sums of exponentials, several at once: truths of certificates add up millions of them.
//!
//! e^x = 2^n e^r, n = round(x log₂ e), |r| ≤ ½ ln 2, e^r by its Taylor series to r¹³, relative error 4e-16: plain loops
//! that the compiler turns into whatever SIMD the machine has.

use std::f64::consts::LOG2_E;

use crate::simd;

/// The exponentials that are taken at once.
const LANES: usize = 8;
/// ln 2 in two parts: n times the first is exact.
const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
/// 1.5 · 2⁵²: adding it rounds to an integer, which then stands in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// Between which x e^x is neither nothing nor infinite; it stays what it is there beyond.
const RANGE: [f64; 2] = [-746.0, 709.0];
/// 1/13!, 1/12!, … 1/2!.
const TAYLOR: [f64; 12] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    1.0 / 2.0,
];

simd! {
    /// Σ mass e^(−depth k), in the unit of mass; `k` and `mass` have the same length.
    pub fn attenuated(k: &[f64], mass: &[f64], depth: f64) -> f64 {
        let mut sums = [0.0; LANES];
        let (k, last_k) = k.as_chunks::<LANES>();
        let (mass, last_mass) = mass.as_chunks::<LANES>();
        for (k, mass) in k.iter().zip(mass) {
            add(k, mass, depth, &mut sums);
        }
        let (mut k, mut mass) = ([0.0; LANES], [0.0; LANES]);
        k[..last_k.len()].copy_from_slice(last_k);
        mass[..last_mass.len()].copy_from_slice(last_mass);
        add(&k, &mass, depth, &mut sums);
        sums.iter().sum()
    }
}

#[inline(always)]
fn add(k: &[f64; LANES], mass: &[f64; LANES], depth: f64, sums: &mut [f64; LANES]) {
    for lane in 0..LANES {
        let x = -depth * k[lane];
        let x = if x < RANGE[0] { RANGE[0] } else { x };
        let x = if x > RANGE[1] { RANGE[1] } else { x };
        let n = fma(x, LOG2_E, ROUND) - ROUND;
        let r = fma(n, -LN_2[1], fma(n, -LN_2[0], x));
        let mut series = TAYLOR[0];
        for coefficient in &TAYLOR[1..] {
            series = fma(series, r, *coefficient);
        }
        let power = fma(fma(series, r, 1.0), r, 1.0);
        // In two parts, so that what is below the normal numbers is rounded to those there are.
        let half = fma(0.5, n, ROUND) - ROUND;
        let exp = scaled(power, half) * scaled(1.0, n - half);
        sums[lane] = fma(mass[lane], exp, sums[lane]);
    }
}

/// a b + c, rounded once. WebAssembly has no such instruction, and rounds twice.
#[inline(always)]
fn fma(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(target_family = "wasm") { a * b + c } else { a.mul_add(b, c) }
}

/// x 2^n for an integer n, where that is a normal number.
#[inline(always)]
fn scaled(x: f64, n: f64) -> f64 {
    f64::from_bits(x.to_bits().wrapping_add((n + ROUND).to_bits() << 52))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each exponential for itself, at every place of a chunk.
    #[test]
    fn exponentials_are_those_of_the_standard_library() {
        let mut worst = 0.0f64;
        for i in 0..40_000 {
            let (x, place) = (-700.0 * (i as f64 / 40_000.0).powi(3), i % 11);
            let (mut k, mut mass) = ([0.3; 11], [0.0; 11]);
            (k[place], mass[place]) = (-x / 2.5, 3.0);
            let truth = 3.0 * (-2.5 * k[place]).exp();
            worst = worst.max((attenuated(&k, &mass, 2.5) / truth - 1.0).abs());
        }
        assert!(worst < 1e-15 && worst > 0.0, "{worst:e}");
        // Down to the last number above nothing, as certificates of deep dust have it.
        for i in 0..1000 {
            let depth = 700.0 + 0.05 * f64::from(i);
            let (found, truth) = (attenuated(&[1.0], &[1.0], depth), (-depth).exp());
            assert!((found - truth).abs() <= 5e-324 + 1e-15 * truth, "{depth}: {found:e} {truth:e}");
        }
        assert_eq!(attenuated(&[1.0], &[1.0], 1e9), 0.0);
        assert!(attenuated(&[], &[], 1.0) == 0.0);
    }

    #[test]
    fn sums_are_sums() {
        let k: Vec<f64> = (0..29).map(|i| 0.1 + 0.07 * f64::from(i)).collect();
        let mass: Vec<f64> = (0..29).map(|i| 1.0 + f64::from(i).sin()).collect();
        for depth in [0.0, 1e-9, 0.3, 7.0, 60.0] {
            let truth: f64 = k.iter().zip(&mass).map(|(k, m)| m * (-depth * k).exp()).sum();
            assert!((attenuated(&k, &mass, depth) / truth - 1.0).abs() < 1e-14, "{depth}");
        }
    }
}
