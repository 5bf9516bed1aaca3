//! Gauss rules and adaptive integration in f64.
//!
//! Gauss–Legendre nodes by Newton's iteration on P_n; Gauss rules for any discrete measure by the Stieltjes procedure
//! and the eigenvalues of the Jacobi matrix (Golub & Welsch 1969, Math. Comp. 23, 221; Gautschi 2004, §2.2);
//! the (G7, K15) pair of QUADPACK (Piessens et al. 1983) for adaptive integration.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Nodes on [−1, 1] and weights of the `n`-point Gauss–Legendre rule \[1\].
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut derivative = 1.0;
            for _ in 0..100 {
                let (value, d) = legendre(n, x);
                derivative = d;
                let step = value / d;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (-x, 2.0 / ((1.0 - x * x) * derivative * derivative))
        })
        .collect()
}

/// The Legendre polynomial P_n(x) and its derivative.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut current) = (1.0, x);
    for j in 2..=n {
        let j = j as f64;
        (previous, current) = (current, ((2.0 * j - 1.0) * x * current - (j - 1.0) * previous) / j);
    }
    if n == 0 {
        return (1.0, 0.0);
    }
    (current, n as f64 * (x * current - previous) / (x * x - 1.0))
}

/// The Gauss rule of at most `n` nodes for the discrete measure Σ `mass`ᵢ δ(x − `x`ᵢ), masses ≥ 0.
///
/// Fewer nodes come back where the measure has fewer points of support.
pub fn gauss_of_measure(x: &[f64], mass: &[f64], n: usize) -> Vec<(f64, f64)> {
    let total: f64 = mass.iter().sum();
    if total <= 0.0 {
        return Vec::new();
    }
    // Shift and scale to [−1, 1]: the three-term recurrence then stays well conditioned.
    let (low, high) = x.iter().zip(mass).filter(|(_, m)| **m > 0.0).fold((f64::MAX, f64::MIN), |(l, h), (x, _)| (l.min(*x), h.max(*x)));
    let (centre, half) = (0.5 * (low + high), (0.5 * (high - low)).max(f64::MIN_POSITIVE));
    if high - low <= 1e-12 * centre.abs() {
        return vec![(centre, total)];
    }
    let scaled: Vec<f64> = x.iter().map(|x| (x - centre) / half).collect();
    let (alpha, beta) = stieltjes(&scaled, mass, n);
    let size = alpha.len();
    let jacobi = DMatrix::from_fn(size, size, |i, j| match i.abs_diff(j) {
        0 => alpha[i],
        1 => beta[i.max(j)].sqrt(),
        _ => 0.0,
    });
    let eigen = SymmetricEigen::new(jacobi);
    let mut rule: Vec<(f64, f64)> =
        (0..size).map(|j| (centre + half * eigen.eigenvalues[j], total * eigen.eigenvectors[(0, j)].powi(2))).collect();
    rule.sort_by(|a, b| a.0.total_cmp(&b.0));
    rule
}

/// Recurrence coefficients α, β of the monic orthogonal polynomials of a discrete measure.
fn stieltjes(x: &[f64], mass: &[f64], n: usize) -> (Vec<f64>, Vec<f64>) {
    let mut previous = vec![0.0; x.len()];
    let mut current = vec![1.0; x.len()];
    let mut norm: f64 = mass.iter().sum();
    let (mut alpha, mut beta) = (Vec::new(), vec![norm]);
    while alpha.len() < n {
        let moment: f64 = (0..x.len()).map(|i| mass[i] * x[i] * current[i] * current[i]).sum();
        alpha.push(moment / norm);
        let (a, b) = (alpha[alpha.len() - 1], if alpha.len() == 1 { 0.0 } else { beta[alpha.len() - 1] });
        let next: Vec<f64> = (0..x.len()).map(|i| (x[i] - a) * current[i] - b * previous[i]).collect();
        let next_norm: f64 = (0..x.len()).map(|i| mass[i] * next[i] * next[i]).sum();
        // The measure's support is exhausted: the rule found so far is exact.
        if next_norm <= 1e-24 * beta[0] {
            break;
        }
        beta.push(next_norm / norm);
        norm = next_norm;
        previous = std::mem::replace(&mut current, next);
    }
    (alpha, beta)
}

const KRONROD: [(f64, f64, f64); 8] = [
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0),
    (0.949_107_912_342_758_5, 0.063_092_092_629_978_56, 0.129_484_966_168_869_7),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_19, 0.0),
    (0.741_531_185_599_394_5, 0.140_653_259_715_525_92, 0.279_705_391_489_276_64),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (0.405_845_151_377_397_2, 0.190_350_578_064_785_4, 0.381_830_050_505_118_9),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_89, 0.0),
    (0.0, 0.209_482_141_084_727_82, 0.417_959_183_673_469_4),
];

/// The 15 Kronrod points of [`a`, `b`]: (abscissa, Kronrod weight, Gauss weight).
pub fn kronrod_points(a: f64, b: f64) -> impl Iterator<Item = (f64, f64, f64)> {
    let (centre, half) = (0.5 * (a + b), 0.5 * (b - a));
    KRONROD.iter().flat_map(move |&(x, wk, wg)| {
        let signs: &[f64] = if x == 0.0 { &[1.0] } else { &[-1.0, 1.0] };
        signs.iter().map(move |s| (centre + s * half * x, half * wk, half * wg))
    })
}

/// ∫ f over [`a`, `b`] to `accuracy` relative to ∫|f|, by bisection of (G7, K15) panels.
pub fn integrate(f: impl Fn(f64) -> f64, a: f64, b: f64, accuracy: f64) -> f64 {
    let [sum] = integrate_each(|x| [f(x)], a, b, accuracy);
    sum
}

/// Integrals of several functions over [`a`, `b`] by the same panels, each to `accuracy` relative to its ∫|f|.
pub fn integrate_each<const N: usize>(f: impl Fn(f64) -> [f64; N], a: f64, b: f64, accuracy: f64) -> [f64; N] {
    let panel = |a: f64, b: f64| {
        let (mut kronrod, mut gauss, mut magnitude) = ([0.0; N], [0.0; N], [0.0; N]);
        for (x, wk, wg) in kronrod_points(a, b) {
            for (i, y) in f(x).into_iter().enumerate() {
                kronrod[i] += wk * y;
                gauss[i] += wg * y;
                magnitude[i] += wk * y.abs();
            }
        }
        (kronrod, gauss, magnitude)
    };
    let mut scale = panel(a, b).2;
    let mut pending = vec![(a, b, 0)];
    let mut sum = [0.0; N];
    while let Some((a, b, depth)) = pending.pop() {
        let (kronrod, gauss, magnitude) = panel(a, b);
        scale = std::array::from_fn(|i| f64::max(scale[i], magnitude[i]));
        if (0..N).all(|i| (kronrod[i] - gauss[i]).abs() <= accuracy * scale[i]) || depth >= 40 {
            sum.iter_mut().zip(kronrod).for_each(|(sum, part)| *sum += part);
        } else {
            let middle = 0.5 * (a + b);
            pending.push((a, middle, depth + 1));
            pending.push((middle, b, depth + 1));
        }
    }
    sum
}

/// The x ≥ 0 that minimises ‖A x − b‖: the active-set method of Lawson & Hanson 1974, ch. 23.
pub fn non_negative_least_squares(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let columns = a.ncols();
    let mut passive: Vec<usize> = Vec::new();
    let mut x = DVector::zeros(columns);
    for _ in 0..3 * columns {
        // The variable that would lower the residual most joins the passive set.
        let gradient = a.transpose() * (b - a * &x);
        let entering = (0..columns).filter(|j| !passive.contains(j)).max_by(|&i, &j| gradient[i].total_cmp(&gradient[j]));
        match entering {
            Some(j) if gradient[j] > 1e-14 * b.norm() => passive.push(j),
            _ => break,
        }
        // Walk to the unconstrained solution, dropping each variable that would turn negative on the way.
        loop {
            let sub = DMatrix::from_fn(a.nrows(), passive.len(), |i, j| a[(i, passive[j])]);
            let Ok(solution) = sub.svd(true, true).solve(b, 1e-15) else { return x };
            if solution.iter().all(|v| *v > 0.0) {
                x.fill(0.0);
                passive.iter().zip(solution.iter()).for_each(|(&j, &v)| x[j] = v);
                break;
            }
            let step = passive
                .iter()
                .zip(solution.iter())
                .filter(|(_, v)| **v <= 0.0)
                .map(|(&j, &v)| x[j] / (x[j] - v).max(f64::MIN_POSITIVE))
                .fold(1.0, f64::min);
            for (&j, &v) in passive.iter().zip(solution.iter()) {
                x[j] += step * (v - x[j]);
            }
            passive.retain(|&j| x[j] > 1e-300);
            if passive.is_empty() {
                break;
            }
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ x^m over [−1, 1] is exact up to degree 2n − 1.
    #[test]
    fn legendre_integrates_polynomials() {
        for n in 1..=32 {
            for m in (0..2 * n).step_by(2) {
                let sum: f64 = gauss_legendre(n).iter().map(|(x, w)| w * x.powi(m as i32)).sum();
                assert!((sum - 2.0 / (m as f64 + 1.0)).abs() < 1e-13, "n {n} m {m}: {sum}");
            }
        }
    }

    /// A fine uniform measure has the Legendre rule.
    #[test]
    fn measure_of_legendre_points_gives_legendre() {
        let (x, w): (Vec<f64>, Vec<f64>) = gauss_legendre(200).into_iter().unzip();
        for n in 1..=8 {
            for (a, b) in gauss_of_measure(&x, &w, n).iter().zip(gauss_legendre(n)) {
                assert!((a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12, "{n}: {a:?} {b:?}");
            }
        }
    }

    #[test]
    fn small_support_gives_small_rules() {
        assert_eq!(gauss_of_measure(&[0.8, 0.8], &[1.0, 2.0], 4), vec![(0.8, 3.0)]);
        assert_eq!(gauss_of_measure(&[0.5, 0.8, 1.0], &[1.0, 2.0, 1.0], 6).len(), 3);
        assert!(gauss_of_measure(&[0.5], &[0.0], 3).is_empty());
    }

    #[test]
    fn adaptive_integration_keeps_its_accuracy() {
        for exponent in 1..=10 {
            let accuracy = 10f64.powi(-exponent);
            let value = integrate(|x: f64| (-30.0 * x).exp() + x.sqrt(), 0.0, 1.0, accuracy);
            let truth = (1.0 - (-30f64).exp()) / 30.0 + 2.0 / 3.0;
            assert!((value - truth).abs() <= 2.0 * accuracy * truth, "{accuracy}: {value} {truth}");
        }
    }

    #[test]
    fn nnls_stays_positive() {
        let a = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        let x = non_negative_least_squares(&a, &DVector::from_row_slice(&[1.0, -2.0, 0.5]));
        assert!(x[1] == 0.0 && (x[0] - 0.75).abs() < 1e-12, "{x}");
        let exact = non_negative_least_squares(&a, &DVector::from_row_slice(&[1.0, 2.0, 3.0]));
        assert!((exact[0] - 1.0).abs() < 1e-12 && (exact[1] - 2.0).abs() < 1e-12);
    }
}
