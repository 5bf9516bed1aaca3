//! Support of an expression: its operators on boxes in place of numbers.
//!
//! A sum is not zero where any of its terms is not, a product where all of its factors are not, and so on; what has a
//! value outside of all boxes (a number, cos, exp) is everywhere. The box that comes out holds every place where the
//! expression is not zero, and is not always the smallest.

use super::operators::{Binary, Unary};
use super::program::{Operation, Program};
use crate::geometry::Bounds;

/// The region outside of which a formula is zero.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Support {
    /// Constant.
    Number(f64),
    /// Zero outside of a box.
    Within(Bounds),
    /// The region has no end.
    Everywhere,
}

impl Support {
    /// The region where either of two is not zero.
    fn either(self, other: Self) -> Self {
        match (self, other) {
            (Support::Number(0.0), other) | (other, Support::Number(0.0)) => other,
            (Support::Within(a), Support::Within(b)) => Support::Within(a.union(&b)),
            _ => Support::Everywhere,
        }
    }
}

impl Unary {
    /// The region where the function of something is not zero.
    fn support(self, a: Support) -> Support {
        match a {
            Support::Number(a) => Support::Number(self.of(a)),
            Support::Within(_) if self.of(0.0) == 0.0 => a,
            _ => Support::Everywhere,
        }
    }
}

impl Binary {
    /// The region where the function of two is not zero.
    fn support(self, a: Support, b: Support) -> Support {
        use Support::{Everywhere, Number, Within};
        if let (Number(a), Number(b)) = (&a, &b) {
            return Number(self.of(*a, *b));
        }
        match self {
            Binary::Sum | Binary::Difference => a.either(b),
            Binary::Product => match (a, b) {
                (Number(0.0), _) | (_, Number(0.0)) => Number(0.0),
                (Within(a), Within(b)) => a.intersection(&b).map_or(Number(0.0), Within),
                (Within(bounds), _) | (_, Within(bounds)) => Within(bounds),
                _ => Everywhere,
            },
            Binary::Quotient => match a {
                Number(0.0) | Within(_) => a,
                _ => Everywhere,
            },
            Binary::Power => match (&a, &b) {
                (Within(_), Number(exponent)) if *exponent > 0.0 => a,
                _ => Everywhere,
            },
            Binary::Min | Binary::Max => match (&a, &b) {
                (Within(_), Number(number)) if self.of(0.0, *number) == 0.0 => a,
                (Number(number), Within(_)) if self.of(*number, 0.0) == 0.0 => b,
                _ => a.either(b),
            },
            Binary::Step => match (&a, &b) {
                (Within(_), Number(edge)) if *edge > 0.0 => a,
                _ => Everywhere,
            },
        }
    }
}

/// Support of a program with `variables` in the order of their names.
pub(super) fn support(program: &Program, variables: &[Support]) -> Support {
    let mut known: Vec<Support> = Vec::new();
    for operation in program.operations() {
        known.push(match *operation {
            Operation::Number(bits) => Support::Number(f64::from_bits(bits)),
            Operation::Variable(variable) => variables[variable].clone(),
            Operation::One(function, a) => function.support(known[a].clone()),
            Operation::Two(function, a, b) => function.support(known[a].clone(), known[b].clone()),
        });
    }
    known.pop().unwrap_or(Support::Everywhere)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::expression::{Formula, parsed};
    use crate::field::formula::{functions, functions_of_two};

    fn ball(centre: f64, half: f64) -> Bounds {
        Bounds::cube(DVec3::new(centre, 0.0, 0.0), half)
    }

    fn support_of(formula: &str) -> Support {
        let (a, b) = (ball(0.0, 1.0), ball(1.5, 1.0));
        let variables = [("a", Support::Within(a)), ("b", Support::Within(b)), ("x", Support::Everywhere)];
        let Formula { names, program, .. } = parsed(formula).unwrap();
        let of_name = |name: &String| variables.iter().find(|(known, _)| known == name).unwrap().1.clone();
        support(&program, &names.iter().map(of_name).collect::<Vec<_>>())
    }

    #[test]
    fn boxes_follow_the_operators() {
        let (a, b) = (ball(0.0, 1.0), ball(1.5, 1.0));
        for formula in ["a + b", "a - b", "max(a, b)", "-a + 2*b^2", "a*x + b", "sqrt(a) + tanh(b)/2"] {
            assert_eq!(support_of(formula), Support::Within(a.union(&b)), "{formula}");
        }
        for formula in ["a * b", "a * (1 - x) * b", "a^2 * b / x", "2*b*a + 0*x"] {
            assert_eq!(support_of(formula), Support::Within(a.intersection(&b).unwrap()), "{formula}");
        }
        for formula in [
            "a",
            "a * (1 - b)",
            "a * exp(-x^2) * (1 + b)",
            "a*step(x, 0.2)",
            "step(a, 0.5)",
            "a * (b + 1)",
            "a^(-1 + 3)",
            "min(a, 0.5)",
            "min(2/3, a)",
            "max(a, -1)",
            "a^(1/2)",
            "a^sqrt(4)",
            "a*min(1, 2)",
        ] {
            assert_eq!(support_of(formula), Support::Within(a), "{formula}");
        }
        for formula in ["a * 0", "a * (1 - 2/2)", "a * step(0.2, 0.5)", "0/3 * b"] {
            assert_eq!(support_of(formula), Support::Number(0.0), "{formula}");
        }
        for formula in [
            "a + 1",
            "exp(a)",
            "a^0",
            "1 - a",
            "step(x, 1)",
            "step(a, 0)",
            "a^b",
            "a^(-2)",
            "a^(1 - 3)",
            "min(a, -1)",
            "max(a, 0.5)",
            "max(1/3, a)",
            "a^cos(3)",
        ] {
            assert_eq!(support_of(formula), Support::Everywhere, "{formula}");
        }
    }

    /// Every function that a formula may call is one of the parser's.
    #[test]
    fn every_function_is_known() {
        for formula in functions().iter().map(|f| format!("{f}(a)")).chain(functions_of_two().iter().map(|f| format!("{f}(a, 1)"))) {
            assert!(parsed(&formula).is_ok(), "{formula}");
        }
    }
}
