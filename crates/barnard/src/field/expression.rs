//! Expressions of fields: products, sums and masks, such as `n_H^2 * x_ion^2` or `cloud * (1 - hole)`.
//!
//! Operators + − * / ^ and parentheses, bound as in mathematics (`formula`); functions sqrt, exp, ln, log10, abs, sin, cos, tan, tanh, floor, ceil, and
//! min(a, b), max(a, b), step(a, edge) = 1 where a ≥ edge; pi; variables are the scene's fields and x, y, z [pc]. The expression is zero outside of the union of its fields' boxes.

use std::sync::Arc;

use exmex::prelude::*;
use exmex::{BinOp, FloatOpsFactory, MakeOperators, Operator};
use glam::DVec3;

use super::formula::normalised;
use super::{Field, Grid};
use crate::geometry::{Bounds, Ray};

/// The field's own operators beside exmex's.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct FieldOperators;

impl MakeOperators<f64> for FieldOperators {
    fn make<'a>() -> Vec<Operator<'a, f64>> {
        let mut operators = FloatOpsFactory::<f64>::make();
        operators.push(Operator::make_bin("step", BinOp { apply: |a, edge| f64::from(a >= edge), prio: 0, is_commutative: false }));
        operators
    }
}

/// An expression over named fields.
#[derive(Debug)]
pub struct Expression {
    formula: FlatEx<f64, FieldOperators>,
    variables: Vec<Variable>,
    bounds: Bounds,
}

#[derive(Debug)]
enum Variable {
    Field(Arc<dyn Field>),
    Axis(usize),
}

/// The longest formula, in characters: parsing recurses with parentheses.
const MAX_LENGTH: usize = 2000;

impl Expression {
    /// Parses `formula`; `lookup` finds fields by name. The message says what is wrong.
    pub fn parse(formula: &str, lookup: impl Fn(&str) -> Result<Arc<dyn Field>, String>) -> Result<Self, String> {
        if formula.len() > MAX_LENGTH {
            return Err(format!("the expression has {} characters, at most {MAX_LENGTH} are read", formula.len()));
        }
        let wrong = |e: String| format!("\"{formula}\" is no expression: {e}");
        let normalised = normalised(formula).map_err(wrong)?;
        let parsed = FlatEx::<f64, FieldOperators>::parse(&normalised).map_err(|e| wrong(e.to_string()))?;
        let variables: Result<Vec<Variable>, String> = parsed
            .var_names()
            .iter()
            .map(|name| match name.as_str() {
                "x" => Ok(Variable::Axis(0)),
                "y" => Ok(Variable::Axis(1)),
                "z" => Ok(Variable::Axis(2)),
                name => lookup(name).map(Variable::Field),
            })
            .collect();
        let variables = variables?;
        let boxes = variables.iter().filter_map(|v| if let Variable::Field(f) = v { Some(f.bounds()) } else { None });
        let bounds = boxes.reduce(|a, b| a.union(&b)).ok_or_else(|| format!("\"{formula}\" uses no field"))?;
        Ok(Self { formula: parsed, variables, bounds })
    }

    fn fields(&self) -> impl Iterator<Item = &Arc<dyn Field>> {
        self.variables.iter().filter_map(|v| if let Variable::Field(f) = v { Some(f) } else { None })
    }

    /// The field this expression is: the named field itself, a grid where a grid takes part, the function otherwise.
    pub fn into_field(self) -> Arc<dyn Field> {
        let names = self.formula.var_names();
        if let ([Variable::Field(only)], [name]) = (&self.variables[..], names)
            && self.formula.unparse().trim().trim_matches(['{', '}']) == name
        {
            return only.clone();
        }
        let finest = self.fields().filter_map(|f| f.grid()).max_by_key(|g| g.lattice.cells()).map(|g| g.lattice.clone());
        match finest {
            Some(lattice) => Arc::new(Grid::sampled(lattice, |p| self.at(p))),
            None => Arc::new(self),
        }
    }
}

impl Field for Expression {
    fn at(&self, p: DVec3) -> f64 {
        if !self.bounds.contains(p) {
            return 0.0;
        }
        let values: Vec<f64> = self
            .variables
            .iter()
            .map(|v| match v {
                Variable::Field(f) => f.at(p),
                Variable::Axis(i) => p[*i],
            })
            .collect();
        self.formula.eval(&values).unwrap_or(f64::NAN)
    }
    fn bounds(&self) -> Bounds {
        self.bounds
    }
    fn feature_pc(&self) -> f64 {
        self.fields().map(|f| f.feature_pc()).fold(f64::INFINITY, f64::min)
    }
    fn crossings(&self, ray: &Ray, out: &mut Vec<f64>) {
        out.extend(self.bounds.clip(ray).into_iter().flat_map(|(a, b)| [a, b]));
        self.fields().for_each(|f| f.crossings(ray, out));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    struct Constant(f64);
    impl Field for Constant {
        fn at(&self, _: DVec3) -> f64 {
            self.0
        }
        fn bounds(&self) -> Bounds {
            Bounds::cube(DVec3::ZERO, 1.0)
        }
    }

    fn parse(formula: &str) -> Result<Expression, String> {
        Expression::parse(formula, |name| match name {
            "a" => Ok(Arc::new(Constant(3.0)) as Arc<dyn Field>),
            "b" => Ok(Arc::new(Constant(0.5))),
            name => Err(format!("no field {name}")),
        })
    }

    #[test]
    fn arithmetic_and_masks() {
        let p = DVec3::new(0.25, 0.0, 0.0);
        for (formula, value) in
            [("a^2*b", 4.5), ("a*(1-b)", 1.5), ("max(a, b)", 3.0), ("step(x, 0.2)*a", 3.0), ("step(x, 0.3)*a", 0.0), ("exp(-a*0)+b", 1.5)]
        {
            assert!((parse(formula).unwrap().at(p) - value).abs() < 1e-12, "{formula}");
        }
        for (formula, value) in [
            ("exp(-x^2)*a/3", (-0.0625f64).exp()),
            ("-a^2 + 20", 11.0),
            ("a*-b^2", -0.75),
            ("2*1e-3*a", 6e-3),
            ("a*1.5E+1", 45.0),
            ("(-a)^2", 9.0),
            ("a^(2^2)", 81.0),
            ("a*cos(pi)", -3.0),
            ("a - -b", 3.5),
            ("+a", 3.0),
        ] {
            assert!((parse(formula).unwrap().at(p) - value).abs() < 1e-12, "{formula}: {}", parse(formula).unwrap().at(p));
        }
        assert_eq!(parse("a + 1").unwrap().at(DVec3::splat(2.0)), 0.0);
    }

    #[test]
    fn mistakes_are_named() {
        assert!(parse("a + c").unwrap_err().contains("no field c"));
        assert!(parse("a +* b").is_err());
        assert!(parse("a^2^b").unwrap_err().contains("a^(b^c)"));
        assert!(parse("a/-b").unwrap_err().contains("parentheses"));
        assert!(parse("sine(a)").unwrap_err().contains("sin"));
        assert!(parse("a $ b").unwrap_err().contains("no place"));
        for name in ["x", "pi", "exp", "a-b", "2a", ""] {
            assert!(super::super::formula::check_name(name).is_err(), "{name}");
        }
        assert!(["max_n", "e", "step1", "n_H"].iter().all(|n| super::super::formula::check_name(n).is_ok()));
        assert!(parse("3").unwrap_err().contains("uses no field"));
        assert!(parse(&"(".repeat(5000)).is_err());
    }
}
