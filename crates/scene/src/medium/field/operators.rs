//! The operators and functions of expressions, and the terms that the parser makes with them.

use std::sync::Arc;

/// A function of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Unary {
    Sqrt,
    Exp,
    Ln,
    Log10,
    Abs,
    Sin,
    Cos,
    Tan,
    Tanh,
    Floor,
    Ceil,
    /// A whole power, by multiplication.
    Power(u8),
}

impl Unary {
    /// Its value at a number.
    pub(super) fn of(self, a: f64) -> f64 {
        match self {
            Unary::Sqrt => a.sqrt(),
            Unary::Exp => a.exp(),
            Unary::Ln => a.ln(),
            Unary::Log10 => a.log10(),
            Unary::Abs => a.abs(),
            Unary::Sin => a.sin(),
            Unary::Cos => a.cos(),
            Unary::Tan => a.tan(),
            Unary::Tanh => a.tanh(),
            Unary::Floor => a.floor(),
            Unary::Ceil => a.ceil(),
            Unary::Power(exponent) => (0..exponent).fold(1.0, |product, _| product * a),
        }
    }
}

/// A function of two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Binary {
    Sum,
    Difference,
    Product,
    Quotient,
    Power,
    Min,
    Max,
    /// One where the first is at least the second, else zero.
    Step,
}

impl Binary {
    /// Its value at two numbers.
    pub(super) fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Binary::Sum => a + b,
            Binary::Difference => a - b,
            Binary::Product => a * b,
            Binary::Quotient => a / b,
            Binary::Power => a.powf(b),
            Binary::Min => a.min(b),
            Binary::Max => a.max(b),
            Binary::Step => f64::from(a >= b),
        }
    }

    /// True if the order of its numbers does not matter.
    pub(super) fn commutes(self) -> bool {
        matches!(self, Binary::Sum | Binary::Product | Binary::Min | Binary::Max)
    }
}

/// A formula, or a part of it, as a tree.
#[derive(Debug, Clone)]
pub(super) enum Term {
    Number(f64),
    /// A variable, by its place among the sorted names.
    Variable(usize),
    One(Unary, Arc<Term>),
    Two(Binary, Arc<Term>, Arc<Term>),
}
