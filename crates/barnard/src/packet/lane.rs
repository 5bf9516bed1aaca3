//! Sixteen rays side by side: arithmetic on arrays that the compiler turns into whatever SIMD the machine has.
//!
//! e^x = 2^(x log₂e): the integer part goes into the exponent by adding 1.5·2²³ (no float-to-int conversion, which
//! would stop vectorisation), the rest through a polynomial of degree 5, relative error 1e-7. Valid for x ≤ 80; below
//! −87 the result is 2^−126, practically zero.

/// The number of rays in a packet.
pub const LANES: usize = 16;
/// One number for each ray.
pub type Lane = [f32; LANES];

/// 1.5 · 2²³: adding it rounds to an integer, which then stands in the low bits.
const ROUND: f32 = 12_582_912.0;

/// a b + c, rounded once: one instruction of AVX2, AVX-512 and NEON, slow on processors without it. WebAssembly has none,
/// and rounds twice.
#[inline(always)]
pub fn fma(a: f32, b: f32, c: f32) -> f32 {
    if cfg!(target_family = "wasm") { a * b + c } else { a.mul_add(b, c) }
}

/// e^x for x ≤ 80.
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    let z = x * std::f32::consts::LOG2_E;
    let z = if z < -126.0 { -126.0 } else { z };
    let rounded = z + ROUND;
    let f = z - (rounded - ROUND);
    let p = fma(f, 0.001_327_647_1, 0.009_675_541);
    let p = fma(fma(fma(fma(p, f, 0.055_507_133), f, 0.240_221_2), f, 0.693_146_97), f, 1.0);
    f32::from_bits(p.to_bits().wrapping_add(rounded.to_bits() << 23))
}

/// ln x for x > 0: the exponent's bits, and 2 atanh((m − 1)/(m + 1)) of a mantissa between √½ and √2, relative error
/// 2e-7.
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    let bits = x.to_bits().wrapping_sub(std::f32::consts::FRAC_1_SQRT_2.to_bits());
    let exponent = (bits as i32 >> 23) as f32;
    let mantissa = f32::from_bits((bits & 0x007f_ffff).wrapping_add(std::f32::consts::FRAC_1_SQRT_2.to_bits()));
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let s2 = s * s;
    let series = fma(s2, fma(s2, fma(s2, fma(s2, 1.0 / 9.0, 1.0 / 7.0), 1.0 / 5.0), 1.0 / 3.0), 1.0);
    fma(exponent, std::f32::consts::LN_2, 2.0 * s * series)
}

/// sinh(y)/y for |y| ≤ [`SERIES_LIMIT`], error 2e-6.
#[inline(always)]
pub fn sinhc(y2: f32) -> f32 {
    fma(y2, fma(y2, fma(y2, 1.0 / 5040.0, 1.0 / 120.0), 1.0 / 6.0), 1.0)
}

/// Half difference of depth up to which the series is used.
pub const SERIES_LIMIT: f32 = 1.0;

/// Mean of e^(−a) over a linear a, any size of step.
#[inline(always)]
pub fn mean_transmittance(middle: f32, y: f32) -> f32 {
    if y.abs() <= SERIES_LIMIT {
        return exp(-middle) * sinhc(y * y);
    }
    let y = y.abs();
    (exp(y - middle) - exp(-y - middle)) / (2.0 * y)
}

/// A number for each lane: `lanes!(|lane| 2.0 * x[lane])`. A loop where it stands and no function of a closure, which
/// may not be inlined into what `multiversion` compiles for a machine, and then calls libm for each `fma`.
macro_rules! lanes {
    (|$lane:ident| $value:expr) => {{
        let mut values = [0.0; $crate::packet::LANES];
        for $lane in 0..$crate::packet::LANES {
            values[$lane] = $value;
        }
        values
    }};
}
pub(crate) use lanes;

/// A place in a row of cells.
#[derive(Debug, Clone, Copy, Default)]
pub struct RowPlace {
    /// The cell it lies in.
    pub cell: u32,
    /// The fraction of the cell that lies before it \[1\].
    pub fraction: f32,
}

/// The place of `u` among `count` cells from 0, held at both ends.
#[inline(always)]
pub fn place(u: f32, count: usize) -> RowPlace {
    let (last, last_cell) = (count as f32, (count - 1) as u32);
    let u = if u < 0.0 { 0.0 } else { u };
    let u = if u > last { last } else { u };
    // Rounding u − ½ gives floor(u), or u − 1 on an integer: the fraction is then 1, which is the same place.
    let rounded = (u - 0.5 + ROUND).to_bits() & 0x003f_ffff;
    let cell = if rounded > last_cell { last_cell } else { rounded };
    RowPlace { cell, fraction: u - cell as i32 as f32 }
}

/// The largest of the lanes, by halves: a chain of sixteen comparisons would wait for each.
#[inline(always)]
pub fn largest(lane: &Lane) -> f32 {
    let mut rest = *lane;
    let mut width = LANES / 2;
    while width > 0 {
        for i in 0..width {
            rest[i] = if rest[i + width] > rest[i] { rest[i + width] } else { rest[i] };
        }
        width /= 2;
    }
    rest[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ln_is_ln() {
        for i in 0..200_000 {
            let x = 10f32.powf(-30.0 + 60.0 * i as f32 / 200_000.0);
            let truth = f64::from(x).ln();
            assert!((f64::from(ln(x)) - truth).abs() <= 3e-7 * truth.abs().max(1.0), "{x}");
        }
    }

    #[test]
    fn exp_is_exp() {
        for i in -8700..=4000 {
            let x = 0.01 * i as f32;
            let truth = f64::from(x).exp();
            assert!((f64::from(exp(x)) / truth - 1.0).abs() < 2e-7 + 1.2e-7 * f64::from(x).abs(), "{x}");
        }
        assert!(exp(-1000.0) < 2e-38 && exp(0.0) <= 1.0 + 2e-7);
    }

    /// This `mean_transmittance` is the twin of `spectra::rule::mean_transmittance`.
    #[test]
    fn mean_transmittance_is_its_twin() {
        for i in 0..60 {
            for j in 0..60 {
                let (a, b) = (0.21 * i as f64, 0.17 * j as f64);
                let truth = spectra::rule::mean_transmittance(a, b);
                let value = f64::from(mean_transmittance((0.5 * (a + b)) as f32, (0.5 * (b - a)) as f32));
                assert!((value / truth - 1.0).abs() < 6e-6, "{a} {b}: {value} {truth}");
            }
        }
    }

    #[test]
    fn cells_are_held_at_both_ends() {
        for (u, truth) in [(-3.0, (0, 0.0)), (0.25, (0, 0.25)), (2.5, (2, 0.5)), (4.75, (4, 0.75)), (5.0, (4, 1.0)), (1e9, (4, 1.0))] {
            let RowPlace { cell, fraction } = place(u, 5);
            assert_eq!((cell, fraction), truth, "{u}");
        }
        // Whole numbers are an end of a cell, whichever; NaN is some cell.
        let RowPlace { cell, fraction } = place(3.0, 5);
        assert_eq!(cell as f32 + fraction, 3.0);
        assert!(place(f32::NAN, 5).cell < 5);
    }
}
