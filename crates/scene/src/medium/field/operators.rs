//! The operators and functions of expressions, and the terms that the parser makes with them.

use std::str::FromStr;
use std::sync::Arc;

use exmex::{BinOp, MakeOperators, Operator};

/// A function of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Unary {
    Negation,
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
            Unary::Negation => -a,
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

/// Value requirement of exmex; unused.
impl Default for Term {
    fn default() -> Self {
        Term::Number(0.0)
    }
}

impl FromStr for Term {
    type Err = std::num::ParseFloatError;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.parse().map(Term::Number)
    }
}

/// The operators of expressions; the names of functions stand in `formula` too, which knows them before they are parsed.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct FieldOperators;

impl MakeOperators<Term> for FieldOperators {
    fn make<'a>() -> Vec<Operator<'a, Term>> {
        macro_rules! two {
            ($function:ident, $priority:expr) => {
                BinOp {
                    apply: |a, b| Term::Two(Binary::$function, Arc::new(a), Arc::new(b)),
                    prio: $priority,
                    is_commutative: Binary::$function.commutes(),
                }
            };
        }
        macro_rules! one {
            ($function:ident) => {
                |a| Term::One(Unary::$function, Arc::new(a))
            };
        }
        vec![
            Operator::make_bin_unary("+", two!(Sum, 0), |a| a),
            Operator::make_bin_unary("-", two!(Difference, 1), one!(Negation)),
            Operator::make_bin("*", two!(Product, 2)),
            Operator::make_bin("/", two!(Quotient, 3)),
            Operator::make_bin("^", two!(Power, 4)),
            Operator::make_bin("min", two!(Min, 0)),
            Operator::make_bin("max", two!(Max, 0)),
            Operator::make_bin("step", two!(Step, 0)),
            Operator::make_unary("sqrt", one!(Sqrt)),
            Operator::make_unary("exp", one!(Exp)),
            Operator::make_unary("ln", one!(Ln)),
            Operator::make_unary("log10", one!(Log10)),
            Operator::make_unary("abs", one!(Abs)),
            Operator::make_unary("sin", one!(Sin)),
            Operator::make_unary("cos", one!(Cos)),
            Operator::make_unary("tan", one!(Tan)),
            Operator::make_unary("tanh", one!(Tanh)),
            Operator::make_unary("floor", one!(Floor)),
            Operator::make_unary("ceil", one!(Ceil)),
        ]
    }
}
