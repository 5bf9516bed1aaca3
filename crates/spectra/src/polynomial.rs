//! Polynomials in λ, their least-squares fit to spectra, and their integral against e^(−a c/λ) in closed form, eq. (13)
//! of docs/method.md.
//!
//!   ∫ λⁿ e^(−g/λ) dλ = [λ^(n+1) E_{n+2}(g/λ)]
//!
//! whose integral over g, from g on, is [λ^(n+2) E_{n+3}(g/λ)].
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | λ | `lambda_um` | µm |
//! | cₙ | `coefficients` | of the spectrum / µmⁿ |
//! | g = a c | `g_um` | µm |
//!
//! On narrow intervals the powers are nearly dependent and the terms cancel: [`Polynomial::cancellation`] says by how
//! much. Source: Barrès & Neyret 2023; E_n: [`crate::exp_integral`].

use nalgebra::{DMatrix, DVector};

use crate::error::{Result, SpectraError};
use crate::exp_integral;

/// Σ cₙ λⁿ between two wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial {
    /// Lowest power first, λ in µm.
    pub coefficients: Vec<f64>,
    /// The interval over which the polynomial is fitted \[µm\].
    pub interval_um: (f64, f64),
}

/// A polynomial in place of a spectrum, with what that costs.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The polynomial that was fitted.
    pub polynomial: Polynomial,
    /// Root of the weighted mean square difference, relative to that of the spectrum \[1\].
    pub rms: f64,
    /// Largest difference, relative to the spectrum's largest value \[1\].
    pub largest: f64,
}

/// G(g) = ∫ P(λ) e^(−g/λ) dλ over an interval, with its neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attenuated {
    /// The integral G of a polynomial against an exponential.
    pub value: f64,
    /// −dG/dg = ∫ P/λ e^(−g/λ) dλ [per µm].
    pub slope: f64,
    /// ∫ G dg from g on = ∫ P λ e^(−g/λ) dλ \[µm\].
    pub left: f64,
}

/// The highest degree: its fit keeps six digits in f64.
pub const MAX_DEGREE: usize = 12;

impl Polynomial {
    /// The value of the polynomial at a wavelength.
    pub fn at(&self, lambda_um: f64) -> f64 {
        self.coefficients.iter().rev().fold(0.0, |sum, c| sum * lambda_um + c)
    }

    /// The least-squares fit of `degree` to (λ \[µm\], value, weight), in Legendre polynomials over the interval.
    ///
    /// # Errors
    /// If there are fewer points than coefficients, or they are no numbers.
    pub fn fit(points: &[(f64, f64, f64)], degree: usize) -> Result<Fit> {
        let distinct = points.iter().zip(points.iter().skip(1)).filter(|(a, b)| a.0 < b.0).count() + 1;
        if degree > MAX_DEGREE || points.is_empty() || distinct <= degree {
            let most = MAX_DEGREE.min(distinct.saturating_sub(1));
            let message =
                format!("a polynomial of degree {degree} through {distinct} wavelengths is underdetermined; use at most degree {most}");
            return Err(SpectraError::Fit(message));
        }
        let interval_um = (points[0].0, points[points.len() - 1].0);
        let unit = |l: f64| (2.0 * l - interval_um.0 - interval_um.1) / (interval_um.1 - interval_um.0);
        let rows: Vec<Vec<f64>> = points.iter().map(|(l, _, _)| legendre(unit(*l), degree)).collect();
        let matrix = DMatrix::from_fn(points.len(), degree + 1, |i, n| points[i].2.sqrt() * rows[i][n]);
        let target = DVector::from_iterator(points.len(), points.iter().map(|(_, y, w)| w.sqrt() * y));
        let solved = matrix.svd(true, true).solve(&target, 1e-14);
        let solved = solved.map_err(|e| SpectraError::Fit(format!("no polynomial of degree {degree} was found: {e}")))?;
        let polynomial = Self { coefficients: powers(solved.as_slice(), interval_um.0, interval_um.1), interval_um };
        let peak = points.iter().map(|(_, y, _)| y.abs()).fold(f64::MIN_POSITIVE, f64::max);
        // Of the powers themselves, which lose digits where Legendre polynomials do not.
        let largest = points.iter().map(|(l, y, _)| (polynomial.at(*l) - y).abs()).fold(0.0, f64::max) / peak;
        let (wrong, all) =
            points.iter().fold((0.0, 0.0), |(wrong, all), (l, y, w)| (wrong + w * (polynomial.at(*l) - y).powi(2), all + w * y * y));
        let rms = (wrong / all.max(f64::MIN_POSITIVE)).sqrt();
        Ok(Fit { polynomial, rms, largest })
    }

    /// ∫ P(λ) e^(−g/λ) dλ over the interval.
    pub fn against_exponential(&self, g_um: f64) -> Attenuated {
        let (low, high) = (self.antiderivative(self.interval_um.0, g_um), self.antiderivative(self.interval_um.1, g_um));
        Attenuated { value: high.value - low.value, slope: high.slope - low.slope, left: high.left - low.left }
    }

    fn antiderivative(&self, lambda_um: f64, g_um: f64) -> Attenuated {
        // e^(−g/λ) falls to nothing at λ = 0, with all its powers.
        if lambda_um <= 0.0 {
            return Attenuated { value: 0.0, slope: 0.0, left: 0.0 };
        }
        // The slope of a constant is ∫ dλ/λ at g = 0, a difference of two infinite E₁.
        let x = (g_um / lambda_um).max(1e-12);
        let mut e = [0.0; MAX_DEGREE + 3];
        exp_integral::scaled(x, &mut e[..self.coefficients.len() + 2]);
        let (mut value, mut slope, mut left, mut power) = (0.0, 0.0, 0.0, 1.0);
        for (n, c) in self.coefficients.iter().enumerate() {
            slope += c * power * e[n];
            power *= lambda_um;
            value += c * power * e[n + 1];
            left += c * power * lambda_um * e[n + 2];
        }
        let fall = (-x).exp();
        Attenuated { value: fall * value, slope: fall * slope, left: fall * left }
    }

    /// Σ |terms| / |sum| of the closed form at g = 0: how many times a rounding error grows \[1\].
    pub fn cancellation(&self) -> f64 {
        let terms = |l: f64| self.coefficients.iter().enumerate().map(move |(n, c)| (c * l.powi(n as i32 + 1) / (n + 1) as f64).abs());
        let size: f64 = terms(self.interval_um.0).chain(terms(self.interval_um.1)).sum();
        size / self.against_exponential(0.0).value.abs().max(f64::MIN_POSITIVE)
    }
}

/// P_0 … P_degree at x, by n P_n = (2n − 1) x P_{n−1} − (n − 1) P_{n−2}.
fn legendre(x: f64, degree: usize) -> Vec<f64> {
    let mut p = vec![1.0, x];
    for n in 2..=degree {
        p.push(((2 * n - 1) as f64 * x * p[n - 1] - (n - 1) as f64 * p[n - 2]) / n as f64);
    }
    p.truncate(degree + 1);
    p
}

/// Coefficients of powers of λ from those of Legendre polynomials over an interval.
fn powers(legendre: &[f64], low: f64, high: f64) -> Vec<f64> {
    // x = s λ + t, and each polynomial from the two before it.
    let (s, t) = (2.0 / (high - low), -(high + low) / (high - low));
    let size = legendre.len();
    let times_x = |p: &[f64]| -> Vec<f64> { (0..size).map(|i| t * p[i] + if i > 0 { s * p[i - 1] } else { 0.0 }).collect() };
    let mut one = vec![0.0; size];
    one[0] = 1.0;
    let mut list = vec![one.clone(), times_x(&one)];
    for n in 2..size {
        let x = times_x(&list[n - 1]);
        let next = (0..size).map(|i| ((2 * n - 1) as f64 * x[i] - (n - 1) as f64 * list[n - 2][i]) / n as f64).collect();
        list.push(next);
    }
    (0..size).map(|i| legendre.iter().zip(&list).map(|(c, p)| c * p[i]).sum()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::integrate;

    fn points(f: impl Fn(f64) -> f64, low: f64, high: f64, count: usize) -> Vec<(f64, f64, f64)> {
        (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).map(|l| (l, f(l), 1.0)).collect()
    }

    #[test]
    fn polynomials_are_fitted_exactly() {
        let f = |l: f64| 1.0 - 2.0 * l + 0.5 * l.powi(3);
        for degree in [3, 5, 8] {
            let fit = Polynomial::fit(&points(f, 0.4, 0.7, 40), degree).unwrap();
            assert!(fit.largest < 1e-11 && fit.rms < 1e-11, "{degree}: {fit:?}");
        }
        // One degree less cannot.
        assert!(Polynomial::fit(&points(f, 0.4, 0.7, 40), 2).unwrap().largest > 1e-5);
    }

    #[test]
    fn integrals_are_closed() {
        for (low, high) in [(0.3, 1.0), (0.37, 0.51), (0.0, 1.0)] {
            let polynomial = Polynomial { coefficients: vec![0.3, -1.0, 2.0, 0.7, -0.4, 1.1], interval_um: (low, high) };
            for g in [1e-6, 0.05, 0.7, 4.0, 20.0] {
                let f = |l: f64| if l > 0.0 { polynomial.at(l) * (-g / l).exp() } else { 0.0 };
                let Attenuated { value, slope, left } = polynomial.against_exponential(g);
                let truth = integrate(f, low, high, 1e-13);
                let truth_slope = integrate(|l| if l > 0.0 { f(l) / l } else { 0.0 }, low, high, 1e-13);
                let truth_left = integrate(|l| l * f(l), low, high, 1e-13);
                assert!((value / truth - 1.0).abs() < 1e-8, "{low} {g}: {value} {truth}");
                assert!((slope / truth_slope - 1.0).abs() < 1e-7, "{low} {g}: {slope} {truth_slope}");
                assert!((left / truth_left - 1.0).abs() < 1e-8, "{low} {g}: {left} {truth_left}");
            }
        }
    }

    #[test]
    fn narrow_intervals_cancel() {
        let wide = Polynomial::fit(&points(|l| l * l, 0.3, 1.0, 40), 5).unwrap().polynomial.cancellation();
        let narrow = Polynomial::fit(&points(|l| ((l - 0.6563) * 3000.0).cos(), 0.656, 0.6566, 40), 5).unwrap().polynomial.cancellation();
        assert!(wide < 10.0 && narrow > 1e6, "{wide:e} {narrow:e}");
    }

    /// Twelve powers of λ through a narrow filter cancel: the fit says so.
    #[test]
    fn a_fit_reports_what_its_powers_lose() {
        let line = |l: f64| (-((l - 0.6563) / 0.0006).powi(2)).exp();
        let fit = Polynomial::fit(&points(line, 0.655, 0.6576, 200), MAX_DEGREE).unwrap();
        let worst = points(line, 0.655, 0.6576, 77).iter().map(|(l, y, _)| (fit.polynomial.at(*l) - y).abs()).fold(0.0, f64::max);
        assert!(fit.rms > 0.1 * worst && worst > 1.0, "{:e} {worst:e}", fit.rms);
    }

    #[test]
    fn too_high_a_degree_is_refused() {
        let error = Polynomial::fit(&points(|l| l, 0.4, 0.7, 4), 4).unwrap_err().to_string();
        assert!(error.contains("degree 4") && error.contains("at most degree 3"), "{error}");
        assert!(Polynomial::fit(&points(|l| l, 0.4, 0.7, 40), MAX_DEGREE + 1).is_err());
        assert!(Polynomial::fit(&[], 0).is_err());
    }
}
