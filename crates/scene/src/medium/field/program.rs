//! A formula as a list of operations, each part that it repeats once, evaluated at many places at a time.

use std::collections::HashMap;

use spectra::simd;

use super::operators::{Binary, Term, Unary};

/// Largest whole exponent that becomes multiplications.
const MAX_POWER: f64 = 16.0;

/// One step of a program; operands are numbers of earlier operations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Operation {
    /// Bits of a number.
    Number(u64),
    /// A variable, by its place among the sorted names.
    Variable(usize),
    One(Unary, usize),
    Two(Binary, usize, usize),
}

/// Operations in the order in which they are done; the last is the formula.
#[derive(Debug, Clone, Default)]
pub(super) struct Program {
    operations: Vec<Operation>,
}

impl Program {
    /// The program of a term. Parts of numbers alone are numbers, equal parts are one operation.
    pub fn new(term: &Term) -> Self {
        let mut program = Self::default();
        let mut known = HashMap::new();
        let root = program.add(term, &mut known);
        // Operands of a formula that is a number may stand behind it.
        program.operations.truncate(root + 1);
        program
    }

    fn add(&mut self, term: &Term, known: &mut HashMap<Operation, usize>) -> usize {
        let operation = match term {
            Term::Number(number) => Operation::Number(number.to_bits()),
            Term::Variable(variable) => Operation::Variable(*variable),
            Term::One(function, a) => {
                let a = self.add(a, known);
                match self.number(a) {
                    Some(a) => Operation::Number(function.of(a).to_bits()),
                    None => Operation::One(*function, a),
                }
            }
            Term::Two(function, a, b) => {
                let (a, b) = (self.add(a, known), self.add(b, known));
                match (*function, self.number(a), self.number(b)) {
                    (function, Some(a), Some(b)) => Operation::Number(function.of(a, b).to_bits()),
                    (Binary::Power, _, Some(n)) if (0.0..=MAX_POWER).contains(&n) && n.fract() == 0.0 => {
                        Operation::One(Unary::Power(n as u8), a)
                    }
                    (function, ..) if function.commutes() => Operation::Two(function, a.min(b), a.max(b)),
                    (function, ..) => Operation::Two(function, a, b),
                }
            }
        };
        *known.entry(operation).or_insert_with(|| {
            self.operations.push(operation);
            self.operations.len() - 1
        })
    }

    fn number(&self, operation: usize) -> Option<f64> {
        if let Operation::Number(bits) = self.operations[operation] { Some(f64::from_bits(bits)) } else { None }
    }

    /// Operations in the order in which they are done.
    pub fn operations(&self) -> &[Operation] {
        &self.operations
    }

    /// The variable that the formula is, if it is one and no more.
    pub fn variable(&self) -> Option<usize> {
        if let [Operation::Variable(variable)] = self.operations[..] { Some(variable) } else { None }
    }

    /// The formula at `count` places, whose variables `fill` writes; `rows` is room for all operations.
    pub fn run<'a>(&self, count: usize, rows: &'a mut Vec<f64>, fill: impl Fn(usize, &mut [f64])) -> &'a [f64] {
        rows.resize(self.operations.len() * count, 0.0);
        for (i, operation) in self.operations.iter().enumerate() {
            let (before, rest) = rows.split_at_mut(i * count);
            let (row, out) = (|operand: usize| &before[operand * count..][..count], &mut rest[..count]);
            match *operation {
                Operation::Number(bits) => out.fill(f64::from_bits(bits)),
                Operation::Variable(variable) => fill(variable, out),
                Operation::One(function, a) => one(function, row(a), out),
                Operation::Two(function, a, b) => two(function, row(a), row(b), out),
            }
        }
        &rows[(self.operations.len() - 1) * count..][..count]
    }
}

simd! {
    /// A function of one number at each place; those that a processor has itself have loops of their own.
    fn one(function: Unary, a: &[f64], out: &mut [f64]) {
        match function {
            Unary::Sqrt => each(a, out, f64::sqrt),
            Unary::Abs => each(a, out, f64::abs),
            Unary::Power(2) => each(a, out, |a| a * a),
            Unary::Power(exponent) => each(a, out, |a| Unary::Power(exponent).of(a)),
            function => each(a, out, |a| function.of(a)),
        }
    }
}

simd! {
    /// A function of two numbers at each place.
    fn two(function: Binary, a: &[f64], b: &[f64], out: &mut [f64]) {
        match function {
            Binary::Sum => pairs(a, b, out, |a, b| a + b),
            Binary::Difference => pairs(a, b, out, |a, b| a - b),
            Binary::Product => pairs(a, b, out, |a, b| a * b),
            Binary::Quotient => pairs(a, b, out, |a, b| a / b),
            function => pairs(a, b, out, |a, b| function.of(a, b)),
        }
    }
}

#[inline(always)]
fn each(a: &[f64], out: &mut [f64], f: impl Fn(f64) -> f64) {
    out.iter_mut().zip(a).for_each(|(out, a)| *out = f(*a));
}

#[inline(always)]
fn pairs(a: &[f64], b: &[f64], out: &mut [f64], f: impl Fn(f64, f64) -> f64) {
    out.iter_mut().zip(a).zip(b).for_each(|((out, a), b)| *out = f(*a, *b));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::formula::parse;

    fn program(formula: &str) -> Program {
        Program::new(&parse(formula).unwrap().term)
    }

    /// Functions in a formula, as it is done: no number among them, none twice.
    fn functions(formula: &str) -> usize {
        program(formula).operations().iter().filter(|o| matches!(o, Operation::One(..) | Operation::Two(..))).count()
    }

    #[test]
    fn repeated_parts_are_done_once() {
        for (formula, count) in [
            ("a + 2*3", 1),
            ("exp(a) * exp(a)", 2),
            ("sqrt(y^2 + a^2) + ln(a^2 + y^2)", 6),
            ("(a - y) * (y - a)", 3),
            ("a^3 + a^0.5", 3),
            ("2^(1 + 1) / 4 * a", 1),
        ] {
            assert_eq!(functions(formula), count, "{formula}: {:?}", program(formula));
        }
        assert_eq!(program("((a))").variable(), Some(0));
        assert_eq!(program("a + 0").variable(), None);
        let constant = program("2 + 3*4 - 2");
        assert_eq!(constant.run(2, &mut Vec::new(), |_, _| ()), [12.0; 2]);
    }

    /// Whole powers are those of the standard library, also of negative numbers and of exponent zero.
    #[test]
    fn whole_powers_are_powers() {
        for exponent in 0..=16u8 {
            for a in [-2.5f64, -1.0, 0.0, 1.7, 30.0] {
                let (ours, exact) = (Unary::Power(exponent).of(a), a.powf(f64::from(exponent)));
                assert!((ours - exact).abs() <= 2e-15 * exact.abs(), "{a}^{exponent}: {ours} {exact}");
            }
        }
    }
}
