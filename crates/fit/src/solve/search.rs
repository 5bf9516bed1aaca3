//! The search by Levenberg–Marquardt in parameters that are not linear.

use std::cell::RefCell;

use barnard::error::{Error, Result};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

use super::normal::solved;
use super::{Fitting, Projected, STEP};

/// A parameter as the search has it: without bounds.
#[derive(Debug, Clone, Copy)]
enum SearchWay {
    /// Between two bounds: an arc sine.
    Between(f64, f64),
    /// Above zero: a logarithm.
    Logarithm(f64, f64),
    /// As it is.
    Plain(f64, f64),
}

impl SearchWay {
    /// That of a parameter that begins at a value.
    fn of((low, high): (f64, f64), value: f64) -> Self {
        match high - low < f64::INFINITY {
            true => Self::Between(low, high),
            false if value > 0.0 => Self::Logarithm(low, high),
            false => Self::Plain(low, high),
        }
    }

    fn inner(self, value: f64) -> f64 {
        match self {
            Self::Between(low, high) => {
                // At a bound nothing would move: a little within it, but no farther than the value can tell.
                let part = if value == 0.0 { 1.0 } else { (20.0 * value.abs() / (high - low)).min(1.0) };
                let edge = 1.0 - 1e-4 * part;
                (2.0 * (value - low) / (high - low) - 1.0).clamp(-edge, edge).asin()
            }
            Self::Logarithm(..) => value.ln(),
            Self::Plain(..) => value,
        }
    }

    fn outer(self, inner: f64) -> f64 {
        match self {
            Self::Between(low, high) => low + 0.5 * (high - low) * (1.0 + inner.sin()),
            Self::Logarithm(low, high) => inner.exp().clamp(low, high),
            Self::Plain(low, high) => inner.clamp(low, high),
        }
    }

    /// A step of differences, by which a parameter of some scale moves about a step of its own: away from bounds.
    fn step(self, at: f64, scale: f64) -> f64 {
        match self {
            Self::Between(low, high) => {
                let slope = 0.5 * (high - low) * at.cos().abs();
                let step = STEP.min(STEP * scale / slope.max(f64::MIN_POSITIVE));
                if at.sin() * at.cos() > 0.0 { -step } else { step }
            }
            Self::Logarithm(_, high) => {
                if (at + STEP).exp() > high {
                    -STEP
                } else {
                    STEP
                }
            }
            Self::Plain(_, high) => {
                if at + STEP * scale > high {
                    -STEP * scale
                } else {
                    STEP * scale
                }
            }
        }
    }
}

impl Fitting<'_> {
    /// The values where Σ r² is least, and whether steps became small.
    pub(super) fn minimised(&mut self, values: &[f64]) -> Result<(Vec<f64>, bool)> {
        let ways: Vec<(usize, SearchWay)> =
            self.numbers(false).into_iter().map(|i| (i, SearchWay::of(self.parameters[i].bounds, values[i]))).collect();
        let start: Vec<f64> = ways.iter().map(|(i, way)| way.inner(values[*i])).collect();
        let mut values = values.to_vec();
        ways.iter().zip(&start).for_each(|((i, way), inner)| values[*i] = way.outer(*inner));
        let first = self.projected(&values)?;
        if ways.is_empty() {
            return Ok((first.values, true));
        }
        let problem = SearchProblem { at: DVector::from_vec(start), now: Some(first), refused: false, fitting: RefCell::new(self), ways };
        let (problem, report) =
            LevenbergMarquardt::new().with_ftol(1e-7).with_xtol(1e-6).with_gtol(1e-9).with_patience(30).minimize(problem);
        let SearchProblem { now, .. } = problem;
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        let now = now.ok_or_else(|| Error::conflict("the model of the fit is not a number", "use other start values, or bounds"))?;
        Ok((now.values, report.termination.was_successful()))
    }

    /// ∂r/∂x of a parameter that is not linear, x as the search has it, the linear ones following as well as they can: without what they can
    /// take up, the others being as they are (Kaufman 1975, BIT 15, 49).
    fn slope(&mut self, (i, way): (usize, SearchWay), at: f64, now: &Projected) -> Result<DVector<f64>> {
        let (step, residuals) = self.aside(way.step(at, self.scale(i, now.values[i])), |search, step| {
            let mut other = now.values.clone();
            other[i] = way.outer(at + step);
            let mean = search.at(&other)?;
            Ok(search.residuals(&other, &mean))
        })?;
        let change = (residuals - &now.residuals) / step;
        let taken = solved(&(now.basis.transpose() * &now.basis), &(now.basis.transpose() * &change));
        Ok(change - &now.basis * taken)
    }
}

/// The parameters that are not linear, as Levenberg–Marquardt moves them.
struct SearchProblem<'a, 'b> {
    at: DVector<f64>,
    /// The last values at which the model could be asked; none once the fit has failed.
    now: Option<Projected>,
    /// True if the model cannot be asked where the search is.
    refused: bool,
    fitting: RefCell<&'a mut Fitting<'b>>,
    ways: Vec<(usize, SearchWay)>,
}

impl SearchProblem<'_, '_> {
    /// Residuals of the data at some free parameters.
    fn projected(&self, at: &DVector<f64>, like: &[f64]) -> Result<Projected> {
        let mut fitting = self.fitting.borrow_mut();
        let mut values = like.to_vec();
        for ((i, way), inner) in self.ways.iter().zip(at.iter()) {
            values[*i] = way.outer(*inner);
        }
        fitting.projected(&values)
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for SearchProblem<'_, '_> {
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
        let mut jacobian = DMatrix::zeros(now.residuals.len(), self.ways.len());
        for (column, way_column) in self.ways.iter().enumerate() {
            match fitting.slope(*way_column, self.at[column], now) {
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
