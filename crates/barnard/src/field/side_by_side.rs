//! Numbers side by side: an expression that is asked for at many places is looked through once for sixteen of them.

use std::str::FromStr;

use super::operators::Operand;

/// A number for each of `N` places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SideBySide<const N: usize>(pub(super) [f64; N]);

/// What exmex wants of every value.
impl<const N: usize> Default for SideBySide<N> {
    fn default() -> Self {
        Self([0.0; N])
    }
}

impl<const N: usize> FromStr for SideBySide<N> {
    type Err = std::num::ParseFloatError;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.parse().map(|number| Self([number; N]))
    }
}

impl<const N: usize> SideBySide<N> {
    #[inline(always)]
    fn zip(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a = f(*a, b));
        self
    }
}

impl<const N: usize> Operand for SideBySide<N> {
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
        if exponent.0 == [2.0; N] { self.product(self) } else { self.zip(exponent, f64::powf) }
    }
    fn chosen(self, other: Self, choose: fn(f64, f64) -> f64) -> Self {
        self.zip(other, choose)
    }
    fn step(self, edge: Self) -> Self {
        self.zip(edge, |a, edge| f64::from(a >= edge))
    }
    #[inline(always)]
    fn map(self, function: fn(f64) -> f64) -> Self {
        Self(self.0.map(function))
    }
}
