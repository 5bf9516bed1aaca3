//! Numbers side by side, and the operators of expressions on them: an expression that is asked for at many places is
//! looked through once for sixteen of them.

use std::str::FromStr;

use exmex::{BinOp, MakeOperators, Operator};

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
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    #[inline(always)]
    fn zip(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a = f(*a, b));
        self
    }

    /// Powers; squares, which most of them are, without a logarithm.
    fn power(self, exponent: Self) -> Self {
        if exponent.0 == [2.0; N] { self.map(|a| a * a) } else { self.zip(exponent, f64::powf) }
    }
}

/// The operators of expressions, on numbers side by side.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct FieldOperators;

impl<const N: usize> MakeOperators<SideBySide<N>> for FieldOperators {
    fn make<'a>() -> Vec<Operator<'a, SideBySide<N>>> {
        type Unary<const N: usize> = fn(SideBySide<N>) -> SideBySide<N>;
        type Binary<const N: usize> = fn(SideBySide<N>, SideBySide<N>) -> SideBySide<N>;
        let binary = |name, prio, is_commutative, apply: Binary<N>| Operator::make_bin(name, BinOp { apply, prio, is_commutative });
        let signs = |name, prio, is_commutative, apply: Binary<N>, unary: Unary<N>| {
            Operator::make_bin_unary(name, BinOp { apply, prio, is_commutative }, unary)
        };
        let unary = |(name, apply): (&'a str, Unary<N>)| Operator::make_unary(name, apply);
        let functions: [(&str, Unary<N>); 11] = [
            ("sqrt", |a| a.map(f64::sqrt)),
            ("exp", |a| a.map(f64::exp)),
            ("ln", |a| a.map(f64::ln)),
            ("log10", |a| a.map(f64::log10)),
            ("abs", |a| a.map(f64::abs)),
            ("sin", |a| a.map(f64::sin)),
            ("cos", |a| a.map(f64::cos)),
            ("tan", |a| a.map(f64::tan)),
            ("tanh", |a| a.map(f64::tanh)),
            ("floor", |a| a.map(f64::floor)),
            ("ceil", |a| a.map(f64::ceil)),
        ];
        let operators = [
            signs("+", 0, true, |a, b| a.zip(b, |a, b| a + b), |a| a),
            signs("-", 1, false, |a, b| a.zip(b, |a, b| a - b), |a| a.map(|a| -a)),
            binary("*", 2, true, |a, b| a.zip(b, |a, b| a * b)),
            binary("/", 3, false, |a, b| a.zip(b, |a, b| a / b)),
            binary("^", 4, false, SideBySide::power),
            binary("min", 0, false, |a, b| a.zip(b, f64::min)),
            binary("max", 0, false, |a, b| a.zip(b, f64::max)),
            binary("step", 0, false, |a, edge| a.zip(edge, |a, edge| f64::from(a >= edge))),
        ];
        operators.into_iter().chain(functions.map(unary)).collect()
    }
}
