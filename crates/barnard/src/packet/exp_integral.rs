//! The twin of `spectra::exp_integral::scaled` for sixteen numbers in f32: no lane waits for another.

use super::lane::{LANES, Lane, exp, lanes, ln};

/// Levels of the continued fraction, run from its end: enough for five digits from x = 1 on.
pub const EXP_INTEGRAL_LEVELS: usize = 24;
/// Terms of the series: enough for five digits below x = 1.
pub const EXP_INTEGRAL_TERMS: usize = 9;
/// Euler's constant γ.
pub const EULER: f32 = 0.577_215_7;

/// Writes e^x E_n(x) for n = 1 … `out.len()`, x > 0 \[1\].
#[inline(always)]
pub fn scaled_exp_integrals(x: &Lane, out: &mut [Lane]) {
    let count = out.len();
    // The order from which the recurrence is run up and down.
    let start = lanes!(|lane| {
        let above = x[lane].ceil();
        if above <= 1.0 {
            1.0
        } else if above >= count as f32 {
            count as f32
        } else {
            above
        }
    });
    let (mut sum, mut term) = ([0.0; LANES], [1.0; LANES]);
    for m in 1..=EXP_INTEGRAL_TERMS {
        for lane in 0..LANES {
            term[lane] *= -x[lane] / m as f32;
            sum[lane] -= term[lane] / m as f32;
        }
    }
    let mut tail = lanes!(|lane| x[lane] + start[lane] + 2.0 * EXP_INTEGRAL_LEVELS as f32);
    for i in (1..=EXP_INTEGRAL_LEVELS).rev() {
        let i = i as f32;
        for lane in 0..LANES {
            tail[lane] = x[lane] + start[lane] + 2.0 * (i - 1.0) - i * (start[lane] - 1.0 + i) / tail[lane];
        }
    }
    let first = lanes!(|lane| {
        let inside = if x[lane] <= 1.0 { x[lane] } else { 1.0 };
        let series = exp(inside) * (sum[lane] - EULER - ln(inside));
        if x[lane] <= 1.0 { series } else { 1.0 / tail[lane] }
    });
    out[0] = first;
    for n in 1..count {
        out[n] = lanes!(|lane| if n as f32 >= start[lane] { (1.0 - x[lane] * out[n - 1][lane]) / n as f32 } else { first[lane] });
    }
    for n in (1..count).rev() {
        out[n - 1] = lanes!(|lane| if (n as f32) < start[lane] { (1.0 - n as f32 * out[n][lane]) / x[lane] } else { out[n - 1][lane] });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the twin, which is held to values of arbitrary precision.
    #[test]
    fn five_digits() {
        const N: usize = 12;
        let mut worst = 0.0f64;
        for i in 0..4000 {
            let x: Lane = lanes!(|lane| 10f32.powf(-6.0 + 9.0 * (16 * i + lane) as f32 / 64_000.0));
            let mut out = [[0.0; LANES]; N];
            scaled_exp_integrals(&x, &mut out);
            for lane in 0..LANES {
                let mut truth = [0.0; N];
                spectra::exp_integral::scaled(f64::from(x[lane]), &mut truth);
                for n in 0..N {
                    let error = (f64::from(out[n][lane]) / truth[n] - 1.0).abs();
                    assert!(error < 1e-5, "E_{} of {}: {error:e}", n + 1, x[lane]);
                    worst = worst.max(error);
                }
            }
        }
        // f32 cannot do much better: the comparison sees its rounding.
        assert!(worst > 1e-8);
    }
}
