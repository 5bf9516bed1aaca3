//! The search by Levenberg–Marquardt in parameters that are not linear.

use std::cell::RefCell;

use barnard::error::{Error, Result};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

use super::normal::solved;
use super::{Fitting, Projected, STEP};

/// A step by which the search's own way to parameters is told.
const SMALL: f64 = 1e-7;

impl Fitting<'_> {
    /// The values where Σ r² is least, and whether steps became small.
    pub(super) fn minimised(&mut self, values: &[f64]) -> Result<(Vec<f64>, bool)> {
        let free = self.numbers(false);
        let first = self.projected(values)?;
        if free.is_empty() {
            return Ok((first.values, true));
        }
        let start: Vec<f64> = free.iter().map(|i| self.inner(*i, values[*i])).collect();
        let problem = Problem { at: DVector::from_vec(start), now: Some(first), refused: false, fitting: RefCell::new(self), free };
        let (problem, report) =
            LevenbergMarquardt::new().with_ftol(1e-7).with_xtol(1e-6).with_gtol(1e-9).with_patience(30).minimize(problem);
        let Problem { now, .. } = problem;
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        let now = now.ok_or_else(|| Error::value("fit", "a model that is no number", "other values to begin at, or bounds"))?;
        Ok((now.values, report.termination.was_successful()))
    }

    /// A parameter as the search has it: without bounds, and of about one. Between two bounds it is an arc sine, above zero a logarithm.
    fn inner(&self, i: usize, value: f64) -> f64 {
        match self.parameters[i].bounds {
            (low, high) if high - low < f64::INFINITY => {
                // At a bound nothing would move: a little within it, but no farther than the value can tell.
                let part = if value == 0.0 { 1.0 } else { (20.0 * value.abs() / (high - low)).min(1.0) };
                let edge = 1.0 - 1e-4 * part;
                (2.0 * (value - low) / (high - low) - 1.0).clamp(-edge, edge).asin()
            }
            _ if value > 0.0 => value.ln(),
            _ => value,
        }
    }

    fn outer(&self, i: usize, inner: f64, like: f64) -> f64 {
        match self.parameters[i].bounds {
            (low, high) if high - low < f64::INFINITY => low + 0.5 * (high - low) * (1.0 + inner.sin()),
            (low, high) if like > 0.0 => inner.exp().clamp(low, high),
            (low, high) => inner.clamp(low, high),
        }
    }

    /// ∂r/∂x of a parameter that is not linear, x as the search has it, the linear ones following as well as they can: without what they can
    /// take up, the others being as they are (Kaufman 1975, BIT 15, 49).
    fn slope(&mut self, i: usize, at: f64, now: &Projected) -> Result<DVector<f64>> {
        // At a bound there is one side alone.
        let value = now.values[i];
        // As far as a step of the parameter itself: between bounds that are wide the search's own would be many.
        let slope = (self.outer(i, at + SMALL, value) - self.outer(i, at - SMALL, value)).abs() / (2.0 * SMALL);
        let step = STEP.min(STEP * self.scale(i, value) / slope.max(f64::MIN_POSITIVE));
        let held = self.outer(i, at + step, value) == value;
        let (step, residuals) = self.aside(if held { -step } else { step }, |own, step| {
            let mut other = now.values.clone();
            other[i] = own.outer(i, at + step, now.values[i]);
            let mean = own.at(&other)?;
            Ok(own.residuals(&other, &mean))
        })?;
        let change = (residuals - &now.residuals) / step;
        let taken = solved(&(now.basis.transpose() * &now.basis), &(now.basis.transpose() * &change));
        Ok(change - &now.basis * taken)
    }
}

/// The parameters that are not linear, as Levenberg–Marquardt moves them.
struct Problem<'a, 'b> {
    at: DVector<f64>,
    /// The last values at which the model could be asked; none once the fit has failed.
    now: Option<Projected>,
    /// Whether the model cannot be asked where the search is.
    refused: bool,
    fitting: RefCell<&'a mut Fitting<'b>>,
    free: Vec<usize>,
}

impl Problem<'_, '_> {
    /// What is left of the data at some of the free parameters.
    fn projected(&self, at: &DVector<f64>, like: &[f64]) -> Result<Projected> {
        let mut fitting = self.fitting.borrow_mut();
        let mut values = like.to_vec();
        for (i, inner) in self.free.iter().zip(at.iter()) {
            values[*i] = fitting.outer(*i, *inner, like[*i]);
        }
        fitting.projected(&values)
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_, '_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, at: &DVector<f64>) {
        self.at.copy_from(at);
        let Some(like) = self.now.as_ref().map(|now| now.values.clone()) else { return };
        let projected = self.projected(at, &like);
        self.refused = projected.is_err();
        match projected {
            Ok(projected) => self.now = Some(projected),
            Err(error @ Error::Interrupted) => {
                self.fitting.get_mut().failure = Some(error);
                self.now = None;
            }
            // No way: a shorter step is tried.
            Err(_) => {}
        }
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let residuals = &self.now.as_ref()?.residuals;
        Some(if self.refused { residuals.map(|r| 10.0 * r.abs() + 1.0) } else { residuals.clone() })
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let now = self.now.as_ref()?;
        let mut fitting = self.fitting.borrow_mut();
        let mut jacobian = DMatrix::zeros(now.residuals.len(), self.free.len());
        for (column, i) in self.free.iter().enumerate() {
            match fitting.slope(*i, self.at[column], now) {
                Ok(slope) => jacobian.set_column(column, &slope),
                Err(error) => {
                    fitting.failure.get_or_insert(error);
                    return None;
                }
            }
        }
        Some(jacobian)
    }
}
