//! Generalised exponential integrals E_n(x) = ∫₁^∞ e^(−x t)/tⁿ dt, scaled by e^x, for all n up to some order at once;
//! eq. (14) of docs/method.md.
//!
//!   n E_{n+1}(x) = e^(−x) − x E_n(x)
//!
//! multiplies an error by x/n upwards and by n/x downwards: it is run up from n₀ = ⌈x⌉ and down from it (Gautschi 1973,
//! CACM 16, 761: the other way loses all digits). E_{n₀} comes from the series of E₁ where x ≤ 1 (Abramowitz & Stegun
//! 5.1.11), else from the continued fraction
//!
//!   e^x E_n(x) = 1/(x + n − 1·n/(x + n + 2 − 2(n + 1)/(x + n + 4 − …)))     (Abramowitz & Stegun 5.1.22, even part)
//!
//! | symbol | variable | range |
//! |---|---|---|
//! | n | `n` | 1 … `out.len()` |
//! | x | `x` | x > 0; at x = 0 E_n = 1/(n − 1), E₁ infinite |
//!
//! Relative error below 1e-13 for 1e-6 ≤ x ≤ 1e3, n ≤ 12 (tested against values of arbitrary precision).

/// Euler's constant γ (DLMF 5.2.3).
const EULER: f64 = 0.577_215_664_901_532_9;
/// Terms of the continued fraction that leave less than a rounding error for x ≥ 1.
const MAX_FRACTION: usize = 200;

/// Writes e^x E_n(x) for n = 1 … `out.len()` \[1\].
pub fn scaled(x: f64, out: &mut [f64]) {
    let count = out.len();
    let start = (x.ceil() as usize).clamp(1, count.max(1));
    if count == 0 {
        return;
    }
    out[start - 1] = if x <= 1.0 { x.exp() * first(x) } else { fraction(start as f64, x) };
    for n in start..count {
        // At x = 0 the product 0 · ∞ of E₁ counts as its limit, nothing.
        let below = if x > 0.0 { x * out[n - 1] } else { 0.0 };
        out[n] = (1.0 - below) / n as f64;
    }
    for n in (1..start).rev() {
        out[n - 1] = (1.0 - n as f64 * out[n]) / x;
    }
}

/// E₁(x) = −γ − ln x − Σ (−x)^m/(m m!) for 0 ≤ x ≤ 1.
fn first(x: f64) -> f64 {
    let (mut sum, mut term) = (0.0, 1.0);
    for m in 1..=22 {
        term *= -x / f64::from(m);
        sum -= term / f64::from(m);
    }
    sum - EULER - x.ln()
}

/// The value of e^x E_n(x) for x > 1, by the modified algorithm of Lentz.
fn fraction(n: f64, x: f64) -> f64 {
    let mut b = x + n;
    let mut c = 1.0 / f64::MIN_POSITIVE;
    let mut d = 1.0 / b;
    let mut value = d;
    for i in 1..=MAX_FRACTION {
        let a = -(i as f64) * (n - 1.0 + i as f64);
        b += 2.0;
        d = 1.0 / (a * d + b);
        c = b + a / c;
        let factor = c * d;
        value *= factor;
        if (factor - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 12;

    /// (n, x, e^x E_n(x)) with 20 digits.
    fn published() -> Vec<(usize, f64, f64)> {
        let text = include_str!("../data/tests/exp_integral.csv");
        let row = |line: &str| {
            let mut fields = line.split(',');
            let mut next = || fields.next().unwrap();
            (next().parse().unwrap(), next().parse().unwrap(), next().parse().unwrap())
        };
        text.lines().filter(|l| !l.starts_with('#')).map(row).collect()
    }

    fn worst(value: impl Fn(usize, f64) -> f64) -> f64 {
        published().iter().map(|&(n, x, truth)| (value(n, x) / truth - 1.0).abs()).fold(0.0, |w, e| if e <= w { w } else { e })
    }

    #[test]
    fn f64_has_thirteen_digits() {
        let value = |n: usize, x: f64| {
            let mut out = [0.0; N];
            scaled(x, &mut out);
            out[n - 1]
        };
        assert!(published().len() > 1000);
        assert!(worst(value) < 1e-13, "{:e}", worst(value));
        // The wrong way round loses them: the comparison can fail.
        let upwards = |n: usize, x: f64| {
            let mut out = [0.0; 1];
            scaled(x, &mut out);
            (1..n).fold(out[0], |e, m| (1.0 - x * e) / m as f64)
        };
        assert!(worst(upwards) > 1e-3);
    }

    #[test]
    fn zero_is_a_limit() {
        let mut out = [0.0; 4];
        scaled(0.0, &mut out);
        assert!(out[0].is_infinite());
        assert_eq!(out[1..], [1.0, 0.5, 1.0 / 3.0]);
    }
}
