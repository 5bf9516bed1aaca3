//! The result of a fit.

use super::Prediction;
use nalgebra::DMatrix;

/// From where on χ² of a degree of freedom is far from one, in either direction.
const FAR: f64 = 3.0;

/// Result.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The value of each parameter.
    pub values: Vec<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// By how much each may be wrong since the model is, at most.
    pub floor: Vec<f64>,
    /// True if the model is linear in each, together with the others that it is linear in.
    pub linear: Vec<bool>,
    /// Σ r² of the data, and their number.
    pub chi2: (f64, usize),
    /// Predictions at the values.
    pub prediction: Prediction,
    /// Standard errors by which data were weighed.
    pub sigma: Vec<f64>,
    /// Number of model evaluations.
    pub evaluations: usize,
    /// True if steps became small.
    pub converged: bool,
    /// The parameters that these data cannot tell apart.
    pub degenerate: Vec<usize>,
    /// The parameters that ended at a bound.
    pub bounded: Vec<usize>,
}

impl Fitted {
    /// The standard error of a parameter.
    pub fn sigma_of(&self, parameter: usize) -> f64 {
        self.covariance[(parameter, parameter)].max(0.0).sqrt()
    }

    /// χ² for each degree of freedom; one where there are none.
    pub fn reduced_chi2(&self) -> f64 {
        match self.chi2.1.saturating_sub(self.values.len()) {
            0 => 1.0,
            freedom => self.chi2.0 / freedom as f64,
        }
    }

    /// A warning where χ² is far from the number of degrees of freedom: the model or the errors are wrong.
    pub fn chi2_warning(&self) -> Option<String> {
        let reduced = self.reduced_chi2();
        let why = if reduced > FAR {
            "far above 1: the model does not describe the data (position, scale, missing light), or their errors are too small; the standard errors are invalid"
        } else if reduced < 1.0 / FAR {
            "far below 1: errors of the data are too large, or neighbouring pixels are correlated"
        } else {
            return None;
        };
        Some(format!("chi2 per degree of freedom is {reduced:.3}, {why}"))
    }

    /// How two parameters go together, from −1 to 1.
    pub fn correlation(&self, a: usize, b: usize) -> f64 {
        self.covariance[(a, b)] / (self.sigma_of(a) * self.sigma_of(b))
    }
}
