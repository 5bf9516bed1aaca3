//! Numbers side by side: an expression that is asked for at many places is looked through once for all of them.

use std::str::FromStr;

use super::operators::Operand;

/// A number for each of some places.
///
/// A value is small to move, whatever the number of places is: exmex moves a row of 32 of them for each evaluation.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum SideBySide {
    /// Constant at all positions, or a single value.
    Same(f64),
    /// A number for each place.
    Each(Vec<f64>),
}

use SideBySide::{Each, Same};

/// Value requirement of exmex.
impl Default for SideBySide {
    fn default() -> Self {
        Same(0.0)
    }
}

impl FromStr for SideBySide {
    type Err = std::num::ParseFloatError;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.parse().map(Same)
    }
}

impl SideBySide {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        match (self, other) {
            (Same(a), Same(b)) => Same(f(a, b)),
            (Each(mut a), Same(b)) => {
                a.iter_mut().for_each(|a| *a = f(*a, b));
                Each(a)
            }
            (Same(a), Each(mut b)) => {
                b.iter_mut().for_each(|b| *b = f(a, *b));
                Each(b)
            }
            (Each(mut a), Each(b)) => {
                a.iter_mut().zip(b).for_each(|(a, b)| *a = f(*a, b));
                Each(a)
            }
        }
    }
}

impl Operand for SideBySide {
    fn sum(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    fn difference(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    fn product(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    fn quotient(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
    /// Squares, which most powers are, come without a logarithm.
    fn power(self, exponent: Self) -> Self {
        self.zip(exponent, |a, exponent| if exponent == 2.0 { a * a } else { a.powf(exponent) })
    }
    fn chosen(self, other: Self, choose: fn(f64, f64) -> f64) -> Self {
        self.zip(other, choose)
    }
    fn step(self, edge: Self) -> Self {
        self.zip(edge, |a, edge| f64::from(a >= edge))
    }
    fn map(self, function: fn(f64) -> f64) -> Self {
        match self {
            Same(a) => Same(function(a)),
            Each(mut a) => {
                a.iter_mut().for_each(|a| *a = function(*a));
                Each(a)
            }
        }
    }
}
