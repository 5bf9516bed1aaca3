//! Projection of e^(−a k(λ)) on a few of its own kind: eqs. (15) and (16) of docs/method.md.
//!
//!   e^(−a k) ≈ Σ_i A_i(a) e^(−d_i k) = Σ_i q_i(a) Q_i(λ),   ⟨f, g⟩ = ∫_D f g dλ
//!
//! The exponents d_i minimise the distance of e^(−a k) from its projection over the range of the argument, 0 ≤ a ≤ A.
//! The Q_i are the elements after Gram–Schmidt (twice, in f64): the A_i grow like the condition number of the raw
//! exponentials and cancel, the coordinates q_i(a) = ⟨e^(−a k), Q_i⟩ never pass the norm of what they stand for, so
//! that f32 tables of them lose nothing.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | D | `Domain` | µm |
//! | d_i | `exponents` | 1 |
//! | A | `range` | 1 |
//! | q_i(a) | `coordinates` | µm^½ |
//! | A_i(a) | `coefficients` | 1 |
//!
//! Source: Barrès & Neyret 2023.

use argmin::core::{CostFunction, Executor, State};
use argmin::solver::neldermead::NelderMead;
use nalgebra::{DMatrix, DVector};

use crate::error::{Result, SpectraError};
use crate::quadrature::gauss_legendre;

/// The domain of the inner product: points of a quadrature in λ with their extinction.
#[derive(Debug, Clone)]
pub struct Domain {
    /// The extinction k(λ) of each point relative to V [1].
    k: Vec<f64>,
    /// The length dλ of each point, times a weight where there is one [µm].
    weight: Vec<f64>,
}

/// Panels that a domain is cut into, and Gauss points in each.
const PANELS: usize = 4;
const PANEL_POINTS: usize = 16;

impl Domain {
    /// Wavelengths of `domain_um`, from the lowest to the highest, weighted by `weight`(λ): one, or a filter.
    ///
    /// # Errors
    /// If the interval has no width, or k or the weight are no numbers in it.
    pub fn new(domain_um: (f64, f64), k: impl Fn(f64) -> f64, weight: impl Fn(f64) -> f64) -> Result<Self> {
        let (low, high) = domain_um;
        if !(low >= 0.0 && low < high && high.is_finite()) {
            return Err(SpectraError::Fit(format!("a domain of {low} to {high} um is invalid; give two ascending wavelengths")));
        }
        let width = (high - low) / PANELS as f64;
        let rule = gauss_legendre(PANEL_POINTS);
        let panel = |p: usize| rule.iter().map(move |(x, w)| (low + width * (p as f64 + 0.5 * (1.0 + x)), 0.5 * width * w));
        let points: Vec<(f64, f64)> = (0..PANELS).flat_map(panel).collect();
        let domain = Self { k: points.iter().map(|(l, _)| k(*l)).collect(), weight: points.iter().map(|(l, w)| w * weight(*l)).collect() };
        if let Some(i) = domain.k.iter().zip(&domain.weight).position(|(k, w)| !(k.is_finite() && *k >= 0.0 && *w >= 0.0)) {
            let what = format!("extinction {} with weight {} at {:.4} um", domain.k[i], domain.weight[i], points[i].0);
            return Err(SpectraError::Fit(format!("{what} cannot be projected; use a domain within the validity of the law")));
        }
        Ok(domain)
    }

    /// The number of points.
    pub fn points(&self) -> usize {
        self.k.len()
    }

    /// The vector e^(−a k) at the points, times √dλ: inner products become sums.
    pub fn exponential(&self, a: f64) -> DVector<f64> {
        DVector::from_iterator(self.k.len(), self.k.iter().zip(&self.weight).map(|(k, w)| w.sqrt() * (-a * k).exp()))
    }
}

/// The error that the exponents of a basis minimise over the range of the argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Criterion {
    /// The mean of ‖e^(−a k) − proj‖: Barrès & Neyret's.
    Mean,
    /// The largest error.
    Largest,
    /// The mean in a norm that is weighted by the light through each passband.
    Filter,
}

/// The criteria by name.
pub const CRITERIA: [(&str, Criterion); 3] = [("mean", Criterion::Mean), ("largest", Criterion::Largest), ("filter", Criterion::Filter)];

/// The largest number of elements.
pub const MAX_SIZE: usize = 8;
/// Panels over the range of the argument, each twice as long as the one before, and Gauss points in each.
const ARGUMENT_PANELS: i32 = 10;
const ARGUMENT_POINTS: usize = 6;
/// Steps of the simplex search for each element, and how often it starts anew from where it ended, with how large a
/// simplex.
const SEARCH_STEPS: u64 = 60;
const SEARCHES: [f64; 3] = [0.5, 0.2, 0.1];
/// A direction that keeps less than this part of its element is rounding, not a direction.
const DEPENDENT: f64 = 1e-11;

/// An orthonormal basis of exponentials.
#[derive(Debug, Clone)]
pub struct Basis {
    /// The exponents d_i, ascending \[1\].
    pub exponents: Vec<f64>,
    /// The largest argument it was made for \[1\].
    pub range: f64,
    /// Orthonormal elements at the domain's points, times √dλ: point × element.
    q: DMatrix<f64>,
    /// E = Q R, upper triangular.
    r: DMatrix<f64>,
    domain: Domain,
}

impl Basis {
    /// The elements e^(−d k) for given exponents; an error where they are dependent to working precision.
    ///
    /// # Errors
    /// If the exponents are dependent to working precision.
    pub fn of(domain: &Domain, exponents: &[f64], range: f64) -> Result<Self> {
        let mut exponents = exponents.to_vec();
        exponents.sort_by(f64::total_cmp);
        let n = exponents.len();
        let mut q = DMatrix::zeros(domain.points(), n);
        let mut r = DMatrix::zeros(n, n);
        for (i, d) in exponents.iter().enumerate() {
            let mut column = domain.exponential(*d);
            let norm = column.norm();
            for _ in 0..2 {
                for j in 0..i {
                    let part = q.column(j).dot(&column);
                    r[(j, i)] += part;
                    column.axpy(-part, &q.column(j), 1.0);
                }
            }
            r[(i, i)] = column.norm();
            if r[(i, i)] <= DEPENDENT * norm || !r[(i, i)].is_finite() {
                let message =
                    format!("a basis of {n} exponentials is numerically dependent on this domain; use fewer elements or a wider domain");
                return Err(SpectraError::Fit(message));
            }
            q.set_column(i, &(column / r[(i, i)]));
        }
        Ok(Self { exponents, range, q, r, domain: domain.clone() })
    }

    /// The best exponents for 0 ≤ a ≤ `range`.
    ///
    /// # Errors
    /// If no basis of that size is independent to working precision over the domain.
    pub fn optimal(domain: &Domain, range: f64, size: usize, criterion: Criterion) -> Result<Self> {
        if !(1..=MAX_SIZE).contains(&size) {
            return Err(SpectraError::Fit(format!("a basis of {size} elements is out of range; use 1 to {MAX_SIZE}")));
        }
        let range = range.max(1e-6);
        let targets: Vec<(f64, DVector<f64>)> = arguments(range).iter().map(|(a, share)| (*share, domain.exponential(*a))).collect();
        let search = |start: Vec<f64>| Search { domain, targets: &targets, range, criterion }.from(start);
        // Like the extrema of Chebyshev polynomials over √a, which suits narrow domains; in equal ratios, which suits
        // wide ones.
        let angle = |i: usize| std::f64::consts::PI * (i as f64 + 0.5) / size as f64;
        let even = (0..size).map(|i| (0.9 * range * (0.5 - 0.5 * angle(i).cos()).powi(2) + 1e-3 * range).ln());
        let ratios = (0..size).map(|i| (range.min(20.0) * 1e-2f64.powf(1.0 - (i as f64 + 0.5) / size as f64)).ln());
        let (one, other) = (search(even.collect())?, search(ratios.collect())?);
        let best = if one.1 <= other.1 { one.0 } else { other.0 };
        Self::of(domain, &best.iter().map(|d| d.exp()).collect::<Vec<f64>>(), range)
    }

    /// The number of elements.
    pub fn size(&self) -> usize {
        self.exponents.len()
    }

    /// The coordinates q_i(a) = ⟨e^(−a k), Q_i⟩ of each element [µm^½].
    pub fn coordinates(&self, a: f64) -> Vec<f64> {
        self.q.tr_mul(&self.domain.exponential(a)).iter().copied().collect()
    }

    /// ⟨kⁿ e^(−a k), Q_i⟩, the n-th derivative of q_i but for its sign [µm^½, element].
    pub fn moments(&self, a: f64, n: i32) -> Vec<f64> {
        let mut bent = self.domain.exponential(a);
        bent.iter_mut().zip(&self.domain.k).for_each(|(e, k)| *e *= k.powi(n));
        self.q.tr_mul(&bent).iter().copied().collect()
    }

    /// ⟨Q_i Q_m, Q_j⟩: products of two elements, projected back [µm^−½, element × element × element].
    pub fn products(&self) -> Vec<f64> {
        let n = self.size();
        let mut products = vec![0.0; n * n * n];
        for (row, weight) in self.q.row_iter().zip(&self.domain.weight).filter(|(_, w)| **w > 0.0) {
            for (at, product) in products.iter_mut().enumerate() {
                *product += row[at / (n * n)] * row[at / n % n] * row[at % n] / weight.sqrt();
            }
        }
        products
    }

    /// A_i(a), the coordinates in the raw exponentials \[element\].
    pub fn coefficients(&self, a: f64) -> Vec<f64> {
        let q = DVector::from_vec(self.coordinates(a));
        self.r.solve_upper_triangular(&q).map_or_else(Vec::new, |c| c.iter().copied().collect())
    }

    /// Q_i at a wavelength of extinction `k` [µm^−½, element].
    pub fn elements(&self, k: f64) -> Vec<f64> {
        let mut elements = vec![0.0; self.size()];
        for i in 0..self.size() {
            let known: f64 = (0..i).map(|j| self.r[(j, i)] * elements[j]).sum();
            elements[i] = ((-self.exponents[i] * k).exp() - known) / self.r[(i, i)];
        }
        elements
    }

    /// ‖e^(−a k) − proj‖ [µm^½].
    pub fn error(&self, a: f64) -> f64 {
        residual(&self.q, &self.domain.exponential(a))
    }

    /// The mean of [`error`](Self::error) over the range, relative to the norm at a = 0 \[1\].
    pub fn mean_error(&self) -> f64 {
        let mean: f64 = arguments(self.range).iter().map(|(a, share)| share * self.error(*a)).sum();
        mean / self.domain.exponential(0.0).norm()
    }

    /// The root of the mean square of [`error`](Self::error) over the range, relative to the norm at a = 0 \[1\].
    pub fn rms_error(&self) -> f64 {
        let mean: f64 = arguments(self.range).iter().map(|(a, share)| share * self.error(*a).powi(2)).sum();
        mean.sqrt() / self.domain.exponential(0.0).norm()
    }

    /// The condition number of the raw exponentials, each of norm one \[1\].
    pub fn condition(&self) -> f64 {
        let mut unit = self.r.clone();
        for mut column in unit.column_iter_mut() {
            let norm = column.norm();
            column /= norm;
        }
        let singular = unit.singular_values();
        singular.max() / singular.min()
    }
}

/// The smallest [`Basis::rms_error`] that any linear basis of `size` elements has, by the singular values of all
/// exponentials \[1\].
pub fn best_linear_error(domain: &Domain, range: f64, size: usize) -> f64 {
    let columns: Vec<DVector<f64>> = arguments(range).iter().map(|(a, share)| share.sqrt() * domain.exponential(*a)).collect();
    let singular = DMatrix::from_columns(&columns).singular_values();
    let rest: f64 = singular.iter().skip(size).map(|s| s * s).sum();
    rest.sqrt() / domain.exponential(0.0).norm()
}

/// Arguments of the criterion and their shares of the range; dense near zero, where exponentials differ most.
fn arguments(range: f64) -> Vec<(f64, f64)> {
    let rule = gauss_legendre(ARGUMENT_POINTS);
    let end = |p: i32| if p == 0 { 0.0 } else { 2f64.powi(p - ARGUMENT_PANELS) };
    let panel = |p: i32| {
        let (low, high) = (end(p), end(p + 1));
        rule.iter().map(move |(x, w)| (range * (low + 0.5 * (high - low) * (1.0 + x)), 0.5 * (high - low) * w)).collect::<Vec<_>>()
    };
    (0..ARGUMENT_PANELS).flat_map(panel).collect()
}

fn residual(q: &DMatrix<f64>, target: &DVector<f64>) -> f64 {
    (target - q * q.tr_mul(target)).norm()
}

/// The search for exponents, in their logarithms.
#[derive(Clone, Copy)]
struct Search<'a> {
    domain: &'a Domain,
    /// Shares of the range and exponentials.
    targets: &'a [(f64, DVector<f64>)],
    range: f64,
    criterion: Criterion,
}

impl Search<'_> {
    /// The best logarithms that are found from a start, and their cost.
    fn from(self, start: Vec<f64>) -> Result<(Vec<f64>, f64)> {
        let size = start.len();
        let mut best = (start, f64::MAX);
        for spread in SEARCHES {
            let corner = |i: usize| {
                let mut corner = best.0.clone();
                corner.iter_mut().skip(i).take(1).for_each(|d| *d += spread);
                corner
            };
            let solver = NelderMead::new((0..=size).map(corner).collect());
            let run = Executor::new(self, solver).configure(|state| state.max_iters(SEARCH_STEPS * size as u64)).run();
            let found = run.map_err(|e| SpectraError::Fit(format!("no basis of {size} elements was found: {e}")))?;
            let cost = found.state.get_best_cost();
            best = (found.state.get_best_param().cloned().unwrap_or(best.0), cost);
        }
        Ok(best)
    }
}

impl CostFunction for Search<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, logarithms: &Vec<f64>) -> std::result::Result<f64, argmin::core::Error> {
        let exponents: Vec<f64> = logarithms.iter().map(|l| l.exp()).collect();
        // Exponentials that fall together, or lie far outside of the range, are no basis.
        let Ok(basis) = Basis::of(self.domain, &exponents, self.range) else { return Ok(f64::MAX) };
        let errors = self.targets.iter().map(|(share, target)| (share, residual(&basis.q, target)));
        Ok(match self.criterion {
            Criterion::Mean | Criterion::Filter => errors.map(|(share, e)| share * e).sum::<f64>(),
            Criterion::Largest => errors.map(|(_, e)| e).fold(0.0, f64::max),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn domain(low: f64, high: f64) -> Domain {
        Domain::new((low, high), |l| 0.55 / l, |_| 1.0).unwrap()
    }

    #[test]
    fn projection_is_idempotent_and_exact_on_its_elements() {
        let basis = Basis::optimal(&domain(0.4, 0.7), 20.0, 4, Criterion::Mean).unwrap();
        for (i, d) in basis.exponents.clone().iter().enumerate() {
            assert!(basis.error(*d) < 1e-13);
            let coefficients = basis.coefficients(*d);
            for (j, c) in coefficients.iter().enumerate() {
                assert!((c - f64::from(u8::from(i == j))).abs() < 1e-6, "{coefficients:?}");
            }
        }
        // Between them it is not: the comparison can fail.
        assert!(basis.error(0.5 * (basis.exponents[0] + basis.exponents[1])) > 1e-9);
    }

    /// The two ways to write a projection are the same function.
    #[test]
    fn coordinates_and_coefficients_agree() {
        let basis = Basis::optimal(&domain(0.3, 1.0), 20.0, 3, Criterion::Largest).unwrap();
        for a in [0.0, 0.4, 3.0, 17.0] {
            for k in [0.6, 1.0, 1.7] {
                let q: f64 = basis.coordinates(a).iter().zip(basis.elements(k)).map(|(q, e)| q * e).sum();
                let raw: f64 = basis.coefficients(a).iter().zip(&basis.exponents).map(|(c, d)| c * (-d * k).exp()).sum();
                assert!((q - raw).abs() < 1e-9, "{q} {raw}");
            }
        }
    }

    /// Facts of Barrès & Neyret: the error falls 8 to 13 times for each further element in the visible, 2 to 3 times on
    /// [0, 1 µm]; and no basis of exponentials is better than the best linear one.
    #[test]
    fn errors_fall_as_barres_and_neyret_say() {
        for (low, high, ratios) in [(0.4, 0.7, 8.0..14.0), (0.0, 1.0, 1.9..3.1)] {
            let domain = domain(low, high);
            let bases: Vec<Basis> = (1..=5).map(|n| Basis::optimal(&domain, 20.0, n, Criterion::Mean).unwrap()).collect();
            for pair in bases.windows(2) {
                let ratio = pair[0].mean_error() / pair[1].mean_error();
                assert!(ratios.contains(&ratio), "[{low}, {high}] {} elements: {ratio}", pair[1].size());
            }
            for basis in &bases {
                let least = best_linear_error(&domain, 20.0, basis.size());
                assert!((1.0..3.0).contains(&(basis.rms_error() / least)), "{} {least}", basis.rms_error());
            }
        }
    }

    /// The worst argument is served better by the criterion that asks for it.
    #[test]
    fn criteria_differ() {
        let domain = domain(0.3, 1.0);
        let worst = |criterion| {
            let basis = Basis::optimal(&domain, 20.0, 3, criterion).unwrap();
            (0..400).map(|i| basis.error(0.05 * f64::from(i))).fold(0.0, f64::max)
        };
        assert!(worst(Criterion::Largest) < 0.9 * worst(Criterion::Mean), "{} {}", worst(Criterion::Largest), worst(Criterion::Mean));
    }

    #[test]
    fn dependent_exponentials_are_refused() {
        let domain = domain(0.5, 0.6);
        assert!(Basis::of(&domain, &[1.0, 1.0], 20.0).unwrap_err().to_string().contains("dependent"));
        assert!(Basis::of(&domain, &[1.0, 2.0], 20.0).is_ok());
        assert!(Basis::optimal(&domain, 20.0, 9, Criterion::Mean).unwrap_err().to_string().contains("1 to 8"));
        assert!(Domain::new((0.7, 0.4), |l| 1.0 / l, |_| 1.0).is_err());
        assert!(Domain::new((0.4, 0.7), |_| f64::NAN, |_| 1.0).is_err());
    }

    /// Five raw exponentials lose four digits (Barrès & Neyret: 3e4); the orthonormal elements none.
    #[test]
    fn raw_exponentials_are_ill_conditioned() {
        let basis = Basis::optimal(&domain(0.4, 0.7), 20.0, 5, Criterion::Mean).unwrap();
        assert!((1e4..1e5).contains(&basis.condition()), "{:e}", basis.condition());
        assert!((&basis.q.tr_mul(&basis.q) - DMatrix::identity(5, 5)).amax() < 1e-14);
    }
}
