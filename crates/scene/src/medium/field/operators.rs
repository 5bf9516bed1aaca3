//! The operators and functions of expressions, for whatever they are evaluated on: numbers side by side, or the boxes in
//! which something is other than zero.

use exmex::{BinOp, DataType, MakeOperators, Operator};

/// Number types of expressions.
pub(super) trait Operand: Sized {
    /// a + b.
    fn sum(self, other: Self) -> Self;
    /// a − b.
    fn difference(self, other: Self) -> Self;
    /// a b.
    fn product(self, other: Self) -> Self;
    /// a/b.
    fn quotient(self, other: Self) -> Self;
    /// a^b.
    fn power(self, exponent: Self) -> Self;
    /// One of two, by a function that gives back either.
    fn chosen(self, other: Self, choose: fn(f64, f64) -> f64) -> Self;
    /// One where a ≥ edge, else zero.
    fn step(self, edge: Self) -> Self;
    /// A function of it.
    fn map(self, function: fn(f64) -> f64) -> Self;
}

/// The operators of expressions; the names of functions stand in `formula` too, which knows them before they are parsed.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct FieldOperators;

impl<T: Operand + DataType> MakeOperators<T> for FieldOperators {
    fn make<'a>() -> Vec<Operator<'a, T>> {
        type Binary<T> = fn(T, T) -> T;
        let binary = |name, prio, is_commutative, apply: Binary<T>| Operator::make_bin(name, BinOp { apply, prio, is_commutative });
        let sign = |name, prio, is_commutative, apply: Binary<T>, unary: fn(T) -> T| {
            Operator::make_bin_unary(name, BinOp { apply, prio, is_commutative }, unary)
        };
        let function = |name, apply: fn(T) -> T| Operator::make_unary(name, apply);
        vec![
            sign("+", 0, true, T::sum, |a| a),
            sign("-", 1, false, T::difference, |a| a.map(|a| -a)),
            binary("*", 2, true, T::product),
            binary("/", 3, false, T::quotient),
            binary("^", 4, false, T::power),
            binary("min", 0, false, |a, b| a.chosen(b, f64::min)),
            binary("max", 0, false, |a, b| a.chosen(b, f64::max)),
            binary("step", 0, false, T::step),
            function("sqrt", |a| a.map(f64::sqrt)),
            function("exp", |a| a.map(f64::exp)),
            function("ln", |a| a.map(f64::ln)),
            function("log10", |a| a.map(f64::log10)),
            function("abs", |a| a.map(f64::abs)),
            function("sin", |a| a.map(f64::sin)),
            function("cos", |a| a.map(f64::cos)),
            function("tan", |a| a.map(f64::tan)),
            function("tanh", |a| a.map(f64::tanh)),
            function("floor", |a| a.map(f64::floor)),
            function("ceil", |a| a.map(f64::ceil)),
        ]
    }
}
