//! Support of an expression: its operators on boxes in place of numbers.
//!
//! A sum is not zero where any of its terms is not, a product where all of its factors are not, and so on; what has a
//! value outside of all boxes (a number, cos, exp) is everywhere. The box that comes out holds every place where the
//! expression is not zero, and is not always the smallest.

use std::str::FromStr;

use exmex::prelude::*;

use super::operators::{FieldOperators, Operand};
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

/// Value requirement of exmex; unused.
impl Default for Support {
    fn default() -> Self {
        Support::Number(0.0)
    }
}

impl FromStr for Support {
    type Err = std::num::ParseFloatError;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.parse().map(Support::Number)
    }
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

impl Operand for Support {
    fn sum(self, other: Self) -> Self {
        match (&self, &other) {
            (Support::Number(a), Support::Number(b)) => Support::Number(a + b),
            _ => self.either(other),
        }
    }

    fn difference(self, other: Self) -> Self {
        match (&self, &other) {
            (Support::Number(a), Support::Number(b)) => Support::Number(a - b),
            _ => self.either(other),
        }
    }

    /// The region where both of two are not zero.
    fn product(self, other: Self) -> Self {
        match (self, other) {
            (Support::Number(a), Support::Number(b)) => Support::Number(a * b),
            (Support::Number(0.0), _) | (_, Support::Number(0.0)) => Support::Number(0.0),
            (Support::Within(a), Support::Within(b)) => a.intersection(&b).map_or(Support::Number(0.0), Support::Within),
            (Support::Within(bounds), _) | (_, Support::Within(bounds)) => Support::Within(bounds),
            _ => Support::Everywhere,
        }
    }

    /// The region where a function of this one is not zero.
    fn map(self, function: fn(f64) -> f64) -> Self {
        match self {
            Support::Number(n) => Support::Number(function(n)),
            Support::Within(_) if function(0.0) == 0.0 => self,
            _ => Support::Everywhere,
        }
    }

    fn quotient(self, other: Self) -> Self {
        match (&self, &other) {
            (Support::Number(a), Support::Number(b)) => Support::Number(a / b),
            (Support::Number(0.0) | Support::Within(_), _) => self,
            _ => Support::Everywhere,
        }
    }

    fn power(self, exponent: Self) -> Self {
        match (&self, &exponent) {
            (Support::Number(a), Support::Number(n)) => Support::Number(a.powf(*n)),
            (Support::Within(_), Support::Number(n)) if *n > 0.0 => self,
            _ => Support::Everywhere,
        }
    }

    /// The region of the lesser or the greater of two, by `choose`.
    fn chosen(self, other: Self, choose: fn(f64, f64) -> f64) -> Self {
        match (&self, &other) {
            (Support::Number(a), Support::Number(b)) => Support::Number(choose(*a, *b)),
            (Support::Within(_), Support::Number(n)) if choose(0.0, *n) == 0.0 => self,
            (Support::Number(n), Support::Within(_)) if choose(*n, 0.0) == 0.0 => other,
            _ => self.either(other),
        }
    }

    /// The region of a step: one where the first is at least the second.
    fn step(self, edge: Self) -> Self {
        match (&self, &edge) {
            (Support::Number(a), Support::Number(edge)) => Support::Number(if a >= edge { 1.0 } else { 0.0 }),
            (Support::Within(_), Support::Number(edge)) if *edge > 0.0 => self,
            _ => Support::Everywhere,
        }
    }
}

/// Support of a normalised formula, of `variables` in the order of their names; everywhere where
/// nothing is known of it.
pub(super) fn support(normalised: &str, variables: &[Support]) -> Support {
    let parsed = FlatEx::<Support, FieldOperators>::parse(normalised);
    parsed.ok().and_then(|formula| formula.eval(variables).ok()).unwrap_or(Support::Everywhere)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::formula::{FUNCTIONS, FUNCTIONS_OF_TWO, normalised};

    fn ball(centre: f64, half: f64) -> Bounds {
        Bounds::cube(DVec3::new(centre, 0.0, 0.0), half)
    }

    fn support_of(formula: &str) -> Support {
        let (a, b) = (ball(0.0, 1.0), ball(1.5, 1.0));
        // Names in the order of the alphabet, as the parser has them.
        let variables = [("a", Support::Within(a)), ("b", Support::Within(b)), ("x", Support::Everywhere)];
        let normalised = normalised(formula).unwrap();
        let used: Vec<Support> = variables.iter().filter(|v| normalised.contains(&format!("{{{}}}", v.0))).map(|v| v.1.clone()).collect();
        support(&normalised, &used)
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

    /// Every function that a formula may have is known here: none makes an expression that is everywhere for want of a
    /// row.
    #[test]
    fn every_function_is_known() {
        for formula in FUNCTIONS.map(|f| format!("{f}(a)")).into_iter().chain(FUNCTIONS_OF_TWO.map(|f| format!("{f}(a, 1)"))) {
            assert!(FlatEx::<Support, FieldOperators>::parse(&normalised(&formula).unwrap()).is_ok(), "{formula}");
        }
    }
}
