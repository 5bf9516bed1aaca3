//! Sampled functions of one variable.

use crate::error::{Result, SpectraError};
use crate::fingerprint::Digest;

/// A piecewise linear function given by samples with ascending abscissae.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    x: Vec<f64>,
    y: Vec<f64>,
}

/// The most samples a user's table may have: far past any real curve, small enough to hold.
pub const MAX_SAMPLES: usize = 1_000_000;

impl Table {
    /// Adds the content to a digest.
    pub fn add_to(&self, digest: &mut Digest) {
        digest.numbers(&self.x).numbers(&self.y);
    }

    /// A table of samples; `x` must be strictly ascending, all finite, at least two.
    ///
    /// # Errors
    /// If they are not, or the columns have different lengths.
    pub fn new(name: &str, x: Vec<f64>, y: Vec<f64>) -> Result<Self> {
        if x.len() < 2 || x.len() != y.len() {
            return Err(SpectraError::table(name, format!("requires at least two rows of two numbers, has {}", x.len())));
        }
        if let Some(i) = (0..x.len()).find(|&i| !x[i].is_finite() || !y[i].is_finite()) {
            return Err(SpectraError::table(name, format!("row {} is not finite: {}, {}", i + 1, x[i], y[i])));
        }
        if let Some(i) = (1..x.len()).find(|&i| x[i] <= x[i - 1]) {
            return Err(SpectraError::table(name, format!("abscissae must ascend, row {} has {} after {}", i + 1, x[i], x[i - 1])));
        }
        Ok(Self { x, y })
    }

    /// The value at `x`, linear between samples; the border values outside.
    pub fn at(&self, x: f64) -> f64 {
        let i = self.x.partition_point(|&v| v <= x);
        if i == 0 {
            return self.y[0];
        }
        if i == self.x.len() {
            return self.y[i - 1];
        }
        let t = (x - self.x[i - 1]) / (self.x[i] - self.x[i - 1]);
        self.y[i - 1] + t * (self.y[i] - self.y[i - 1])
    }

    /// The value at `x`, zero outside of the samples.
    pub fn at_or_zero(&self, x: f64) -> f64 {
        let (low, high) = self.range();
        if x < low || x > high { 0.0 } else { self.at(x) }
    }

    /// The first and the last abscissa.
    pub fn range(&self) -> (f64, f64) {
        (self.x[0], self.x[self.x.len() - 1])
    }

    /// The abscissae.
    pub fn x(&self) -> &[f64] {
        &self.x
    }

    /// The ordinates.
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// Copy of the function with both axes scaled.
    pub fn scaled(&self, x_factor: f64, y_factor: f64) -> Self {
        Self { x: self.x.iter().map(|v| v * x_factor).collect(), y: self.y.iter().map(|v| v * y_factor).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolates_and_clamps() {
        let table = Table::new("t", vec![1.0, 2.0, 4.0], vec![0.0, 10.0, 20.0]).unwrap();
        assert_eq!(table.at(1.5), 5.0);
        assert_eq!(table.at(3.0), 15.0);
        assert_eq!(table.at(9.0), 20.0);
        assert_eq!(table.at_or_zero(9.0), 0.0);
    }

    #[test]
    fn bad_tables_are_refused() {
        assert!(Table::new("t", vec![1.0], vec![1.0]).is_err());
        assert!(Table::new("t", vec![1.0, 1.0], vec![1.0, 1.0]).is_err());
        assert!(Table::new("t", vec![1.0, f64::NAN], vec![1.0, 1.0]).is_err());
    }
}
