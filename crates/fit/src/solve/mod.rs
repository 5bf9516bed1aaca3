//! Least squares of numbers: linear parameters inside, the others by Levenberg–Marquardt.
//!
//! | symbol | variable | |
//! |---|---|---|
//! | y, σ | `values`, `sigma` | data and their standard errors |
//! | m(x) | `Prediction::mean` | the model |
//! | r = (y − m)/σ, and (x − prior)/its σ | `residuals` | |
//! | C = (JᵀJ)⁻¹, J = −∂r/∂x | `covariance` | |
//!
//! Where the model knows the noise of what it predicts, σ is that of the model and not that of the data, which are fainter where noise was
//! low: weights are renewed until parameters stay (iteratively reweighted least squares), so that means are not too low.

mod fitted;
mod linearity;
mod normal;
mod search;

use barnard::control::Control;
use barnard::error::{Error, Result};
use nalgebra::{DMatrix, DVector};

pub use self::fitted::Fitted;
use self::normal::{inverse, solved};
use crate::Parameter;

/// Model predictions for all data, in their order.
#[derive(Debug, Clone, Default)]
pub struct Prediction {
    /// The values.
    pub mean: Vec<f64>,
    /// Their standard errors, where the model knows them.
    pub sigma: Option<Vec<f64>>,
}

/// Forward model.
pub trait Model {
    /// Predicted data at some values of the parameters.
    ///
    /// # Errors
    /// If values cannot be, and on interruption by the user.
    fn predict(&mut self, values: &[f64], control: &Control) -> Result<Prediction>;

    /// The largest errors of what it says, without noise.
    ///
    /// # Errors
    /// Errors of [`predict`](Self::predict).
    fn floor(&mut self, values: &[f64], control: &Control) -> Result<Vec<f64>>;

    /// Makes ready for values near these, if it was for others; whether it says something else from now on.
    ///
    /// # Errors
    /// Errors of [`predict`](Self::predict).
    fn renew(&mut self, values: &[f64], control: &Control) -> Result<bool> {
        let _ = (values, control);
        Ok(false)
    }
}

/// Measurement.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The values.
    pub values: Vec<f64>,
    /// Their standard errors, where the model does not know them.
    pub sigma: Vec<f64>,
}

/// Step of the test of linearity, and the largest relative change of a linear model.
const TRIED: f64 = 0.05;
const LINEAR: f64 = 2e-3;
/// Factor by which a step grows if the smaller one changes nothing.
const LARGER: [f64; 3] = [1e2, 1e4, 1e6];
/// Rounding of single-precision pictures, relative to the brightest of the data.
const ROUNDED: f64 = 5e-7;
/// The step of differences, as a part of a parameter's scale.
const STEP: f64 = 3e-3;
/// Substitute of zero for parameters that exclude zero, as a part of the value that a parameter begins with.
const LEAST: f64 = 1e-6;
/// Searches, each from where the one before ended, where that was far from where it began.
const SEARCHES: usize = 4;
/// Rounds of weights, and the change in standard errors from which on they stay.
const ROUNDS: usize = 6;
const STAYS: f64 = 0.02;
/// Distance at which a parameter counts as at its bound, relative to its scale.
const AT_BOUND: f64 = 1e-9;

/// Fits the parameters of a model to data, from `start` on.
///
/// # Errors
/// If a parameter begins outside of its bounds, the model does not depend on it, data are no numbers, and those of the model.
pub fn fit(model: &mut dyn Model, data: &Measured, parameters: &[Parameter], start: &[f64], control: &Control) -> Result<Fitted> {
    for (parameter, value) in parameters.iter().zip(start) {
        let (low, high) = parameter.bounds;
        if !(low..=high).contains(value) {
            let problem = format!("the start value of {}, {value}, is outside of its bounds, {low} to {high}", parameter.key);
            return Err(Error::conflict(problem, "change one of them"));
        }
    }
    let mut fitting = Fitting {
        model,
        data,
        parameters: parameters.to_vec(),
        reference: start.to_vec(),
        control,
        sigma: data.sigma.clone(),
        linear: Vec::new(),
        evaluations: 0,
        failure: None,
    };
    let first = fitting.predict(start)?;
    fitting.linear = fitting.classified(start, &first)?;
    let (mut values, mut converged) = fitting.searched(start, first.sigma)?;
    // Where the fit began far away, what was found out there may not hold here.
    for _ in 1..SEARCHES {
        let shown = fitting.shown(&values);
        let far = |i: usize, range: std::ops::Range<f64>| !range.contains(&(shown[i] / fitting.reference[i]));
        let is_far = fitting.numbers(true).into_iter().any(|i| far(i, 0.1..10.0));
        if !is_far && !fitting.numbers(false).into_iter().any(|i| far(i, 0.67..1.5)) {
            break;
        }
        match fitting.searched_anew(&shown, is_far) {
            Ok(Some(found)) => (values, converged) = found,
            // What was found holds there too, or nothing can be asked there.
            Ok(None) => break,
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(_) => break,
        }
    }
    fitting.finished(values, converged)
}

struct Fitting<'a> {
    model: &'a mut dyn Model,
    data: &'a Measured,
    parameters: Vec<Parameter>,
    /// Values of linear parameters at which the model is asked: those that it was begun with, which can be.
    reference: Vec<f64>,
    control: &'a Control,
    sigma: Vec<f64>,
    linear: Vec<bool>,
    evaluations: usize,
    failure: Option<Error>,
}

/// Parameters whose linear ones are the best for the others, and what is left of the data.
#[derive(Clone)]
struct Projected {
    values: Vec<f64>,
    residuals: DVector<f64>,
    /// −∂r/∂x of the linear parameters that no bound holds.
    basis: DMatrix<f64>,
}

impl Fitting<'_> {
    /// The best values from where a search ended on, where the model or what is linear is another there or it `is_far`.
    fn searched_anew(&mut self, from: &[f64], is_far: bool) -> Result<Option<(Vec<f64>, bool)>> {
        let is_other = self.model.renew(from, self.control)?;
        let first = self.predict(from)?;
        let before = (std::mem::replace(&mut self.reference, from.to_vec()), self.linear.clone());
        // A parameter that ended where nothing hangs on it stays what it was.
        match self.classified(from, &first) {
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(_) => self.reference = before.0,
            Ok(linear) => self.linear = linear,
        }
        if is_other || is_far || self.linear != before.1 { self.searched(from, first.sigma).map(Some) } else { Ok(None) }
    }

    /// The best values from some on, by the errors that the model has there or those of the data, and whether steps became small.
    fn searched(&mut self, start: &[f64], sigma: Option<Vec<f64>>) -> Result<(Vec<f64>, bool)> {
        let (mut values, mut renewed, mut converged) = (start.to_vec(), sigma, true);
        let mut errors: Option<Vec<f64>> = None;
        for _ in 0..ROUNDS {
            let Some(sigma) = renewed.take().or_else(|| errors.is_none().then(|| self.data.sigma.clone())) else { break };
            self.sigma = sigma;
            let before = values.clone();
            (values, converged) = self.minimised(&values)?;
            let sizes = match errors.take() {
                Some(sizes) => sizes,
                None => {
                    let jacobian = self.jacobian(&values)?;
                    inverse(&(jacobian.transpose() * &jacobian)).0.diagonal().iter().map(|variance| variance.max(0.0).sqrt()).collect()
                }
            };
            let moved = |((a, b), size): ((&f64, &f64), &f64)| (a - b).abs() <= STAYS * size;
            let stays = values.iter().zip(&before).zip(&sizes).all(moved);
            errors = Some(sizes);
            if stays {
                break;
            }
            renewed = self.predict(&self.shown(&values))?.sigma;
        }
        Ok((values, converged))
    }

    fn predict(&mut self, values: &[f64]) -> Result<Prediction> {
        self.control.check()?;
        self.evaluations += 1;
        let predicted = self.model.predict(values, self.control)?;
        if predicted.mean.len() != self.data.values.len() || !predicted.mean.iter().all(|value| value.is_finite()) {
            return Err(Error::mismatch("model of a fit", "one finite number per data point", "other values"));
        }
        Ok(predicted)
    }

    fn mean(&mut self, values: &[f64]) -> Result<Vec<f64>> {
        Ok(self.predict(values)?.mean)
    }

    /// Scale of a parameter.
    fn scale(&self, i: usize, value: f64) -> f64 {
        let (low, high) = self.parameters[i].bounds;
        if value != 0.0 {
            value.abs()
        } else if high - low < f64::INFINITY {
            high - low
        } else {
            1.0
        }
    }

    /// A step from a value that stays within the bounds.
    fn step(&self, i: usize, value: f64, part: f64) -> f64 {
        let (low, high) = self.parameters[i].bounds;
        let step = part * self.scale(i, value);
        match (value + 2.0 * step <= high, value - 2.0 * step >= low) {
            (true, _) => step,
            (false, true) => -step,
            (false, false) => 0.25 * if high - value > value - low { high - value } else { low - value },
        }
    }

    /// What is asked a step aside: to the other side where the model cannot be asked there. The step that was taken is given too.
    fn aside<T>(&mut self, step: f64, ask: impl Fn(&mut Self, f64) -> Result<T>) -> Result<(f64, T)> {
        match ask(self, step) {
            Ok(predicted) => Ok((step, predicted)),
            Err(Error::Interrupted) => Err(Error::Interrupted),
            Err(error) => ask(self, -step).map(|predicted| (-step, predicted)).map_err(|_| error),
        }
    }

    /// Copy of the values in the domain of the model: linear parameters above a bound of zero.
    fn shown(&self, values: &[f64]) -> Vec<f64> {
        let share = |(i, value): (usize, &f64)| {
            if self.linear[i] && self.parameters[i].bounds.0 == 0.0 { value.max(LEAST * self.reference[i].abs()) } else { *value }
        };
        values.iter().enumerate().map(share).collect()
    }

    fn numbers(&self, linear: bool) -> Vec<usize> {
        (0..self.parameters.len()).filter(|i| self.linear[*i] == linear).collect()
    }

    /// The model at the reference of its linear parameters, the others being those of `values`, and its derivatives by the linear ones.
    fn columns(&mut self, values: &[f64]) -> Result<(Vec<f64>, Vec<Vec<f64>>)> {
        let mut at = values.to_vec();
        let linear = self.numbers(true);
        linear.iter().for_each(|i| at[*i] = self.reference[*i]);
        let first = self.mean(&at)?;
        let mut columns = Vec::new();
        for i in linear {
            let step = self.step(i, at[i], 0.5);
            let mut other = at.clone();
            other[i] += step;
            let other = self.mean(&other)?;
            columns.push(other.iter().zip(&first).map(|(a, b)| (a - b) / step).collect());
        }
        Ok((first, columns))
    }

    /// The model at any values; where it cannot be asked for its linear parameters, of what it is at their reference.
    fn at(&mut self, values: &[f64]) -> Result<Vec<f64>> {
        if self.shown(values) == values {
            return self.mean(values);
        }
        let (mut mean, columns) = self.columns(values)?;
        for (i, column) in self.numbers(true).into_iter().zip(columns) {
            let shift = values[i] - self.reference[i];
            mean.iter_mut().zip(column).for_each(|(mean, c)| *mean += shift * c);
        }
        Ok(mean)
    }

    /// The best linear parameters for the others.
    fn projected(&mut self, values: &[f64]) -> Result<Projected> {
        let numbers = self.numbers(true);
        let (first, columns) = self.columns(values)?;
        let mut best = values.to_vec();
        numbers.iter().for_each(|i| best[*i] = self.reference[*i]);
        let left = self.residuals(&best, &first);
        let basis = self.fall(&numbers, &columns);
        let mut shifts = DVector::zeros(numbers.len());
        let mut open: Vec<usize> = (0..numbers.len()).collect();
        // Whoever goes beyond a bound is held there, and the others are solved again.
        while !open.is_empty() {
            let open_basis = basis.select_columns(&open);
            open.iter().for_each(|n| shifts[*n] = 0.0);
            let solved = solved(&(open_basis.transpose() * &open_basis), &(open_basis.transpose() * (&left - &basis * &shifts)));
            open.iter().zip(solved.iter()).for_each(|(n, shift)| shifts[*n] = *shift);
            let before = open.len();
            open.retain(|n| {
                let (reference, (low, high)) = (self.reference[numbers[*n]], self.parameters[numbers[*n]].bounds);
                let value = reference + shifts[*n];
                shifts[*n] = value.clamp(low, high) - reference;
                (low..=high).contains(&value)
            });
            if open.len() == before {
                break;
            }
        }
        numbers.iter().zip(shifts.iter()).for_each(|(i, shift)| best[*i] += shift);
        Ok(Projected { values: best, residuals: left - &basis * shifts, basis: basis.select_columns(&open) })
    }

    /// −∂r/∂x of some parameters, by whose derivatives of the model: rows of the data, then those of what is known beforehand.
    fn fall(&self, numbers: &[usize], columns: &[Vec<f64>]) -> DMatrix<f64> {
        let known = |(i, parameter): (usize, &Parameter)| parameter.prior.map(|(_, sigma)| (i, sigma));
        let priors: Vec<(usize, f64)> = self.parameters.iter().enumerate().filter_map(known).collect();
        let count = self.data.values.len();
        DMatrix::from_fn(count + priors.len(), numbers.len(), |d, n| match d.checked_sub(count) {
            None => columns[n][d] / self.sigma[d],
            Some(prior) if priors[prior].0 == numbers[n] => -1.0 / priors[prior].1,
            Some(_) => 0.0,
        })
    }

    /// Residuals of data and priors.
    fn residuals(&self, values: &[f64], mean: &[f64]) -> DVector<f64> {
        let of_data = self.data.values.iter().zip(mean).zip(&self.sigma).map(|((y, m), sigma)| (y - m) / sigma);
        let of_priors =
            self.parameters.iter().zip(values).filter_map(|(parameter, value)| parameter.prior.map(|(mean, sigma)| (value - mean) / sigma));
        DVector::from_vec(of_data.chain(of_priors).collect())
    }

    /// −∂r/∂x of all parameters at some values, by central differences where the model is not linear.
    fn jacobian(&mut self, values: &[f64]) -> Result<DMatrix<f64>> {
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); values.len()];
        let (_, linear) = self.columns(values)?;
        for (i, column) in self.numbers(true).into_iter().zip(linear) {
            columns[i] = column;
        }
        for i in self.numbers(false) {
            let (low, high) = self.parameters[i].bounds;
            let step = STEP * self.scale(i, values[i]);
            let at = |value: f64| values.iter().enumerate().map(|(j, known)| if i == j { value } else { *known }).collect::<Vec<f64>>();
            // Where the model ends, so does the difference.
            let mut end = |value: f64| match self.at(&at(value)) {
                Ok(mean) => Ok((value, mean)),
                Err(Error::Interrupted) => Err(Error::Interrupted),
                Err(_) => self.at(values).map(|mean| (values[i], mean)),
            };
            let ((above, a), (below, b)) = (end((values[i] + step).min(high))?, end((values[i] - step).max(low))?);
            columns[i] = a.iter().zip(&b).map(|(a, b)| (a - b) / (above - below)).collect();
        }
        let all: Vec<usize> = (0..values.len()).collect();
        Ok(self.fall(&all, &columns))
    }

    /// Report of the fitted values.
    fn finished(mut self, values: Vec<f64>, converged: bool) -> Result<Fitted> {
        let prediction = Prediction { mean: self.at(&values)?, sigma: None };
        let jacobian = self.jacobian(&values)?;
        let (mut covariance, degenerate) = inverse(&(jacobian.transpose() * &jacobian));
        let errors = self.model.floor(&self.shown(&values), self.control)?;
        // C Jᵀ/σ times the errors of the model, all of one sign for each parameter.
        let gain = &covariance * jacobian.transpose();
        let floor =
            |i: usize| errors.iter().zip(&self.sigma).enumerate().map(|(d, (error, sigma))| (gain[(i, d)] * error / sigma).abs()).sum();
        let floor = (0..values.len()).map(floor).collect();
        // What the data do not tell has no error that they tell.
        for (i, j) in degenerate.iter().flat_map(|i| (0..values.len()).map(move |j| (*i, j))) {
            let unknown = if i == j { f64::INFINITY } else { f64::NAN };
            (covariance[(i, j)], covariance[(j, i)]) = (unknown, unknown);
        }
        let residuals = self.residuals(&values, &prediction.mean);
        let count = self.data.values.len();
        let chi2 = residuals.iter().take(count).map(|r| r * r).sum();
        let at_bound = |i: &usize| {
            let ((low, high), room) = (self.parameters[*i].bounds, AT_BOUND * self.scale(*i, values[*i]));
            values[*i] - low <= room || high - values[*i] <= room
        };
        Ok(Fitted {
            bounded: (0..values.len()).filter(at_bound).collect(),
            values,
            covariance,
            floor,
            linear: self.linear,
            chi2: (chi2, count),
            prediction,
            sigma: self.sigma,
            evaluations: self.evaluations,
            converged,
            degenerate,
        })
    }
}

/// The largest of some values, whatever their signs.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}
