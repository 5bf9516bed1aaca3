//! Exponentials: all they need is k and a weight for each term.

use spectra::rule::Form;

use super::{FormEntry, Heads, Turns};

/// k times the half difference of depth up to which a mean is the one exponential of [`cumulants`]; error 7e-7 of it.
pub const GENTLE: f64 = 0.35;

/// What the mean of e^(−k a) over depths between m − h and m + h has as its exponent to the base 2, in front of m, h²
/// and h⁴: ln(sinh(y)/y) = y²/6 − y⁴/180 + y⁶/2835 − …
pub fn cumulants(k: f32) -> [f32; 3] {
    let (k, log2_e) = (f64::from(k), std::f64::consts::LOG2_E);
    [-k * log2_e, k * k * (log2_e / 6.0), -k.powi(4) * (log2_e / 180.0)].map(|c| c as f32)
}

pub(super) const ENTRY: FormEntry = FormEntry {
    name: "nodes",
    is_form: |form| matches!(form, Form::Nodes(_)),
    wgsl: include_str!("../shaders/forms/nodes.wgsl"),
    bounded: true,
    is_short: true,
    turns: Turns { each_band: 2, each_term: 1 },
    heads: Heads::Bands,
    fill: |_, _, _| Ok(()),
};

#[cfg(test)]
mod tests {
    use super::*;

    /// One exponential is the mean of e^(−k a), up to `GENTLE` and not much further.
    #[test]
    fn cumulants_make_the_mean() {
        let error = |k: f64, y: f64| {
            let ([first, second, fourth], half, middle) = (cumulants(k as f32).map(f64::from), y / k, 1.0);
            let term = (first * middle + second * half.powi(2) + fourth * half.powi(4)).exp2();
            (term / ((-k * middle).exp() * y.sinh() / y) - 1.0).abs()
        };
        let worst = |y: f64| (1..60).map(|i| error(0.05 * f64::from(i), y)).fold(0.0, f64::max);
        assert!(worst(GENTLE) < 1e-6, "{}", worst(GENTLE));
        assert!(worst(2.0 * GENTLE) > 1e-5);
    }
}
