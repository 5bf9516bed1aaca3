//! Expressions of fields: products, sums and masks, such as `n_H^2 * x_ion^2` or `cloud * (1 - hole)`.
//!
//! Operators + − * / ^ and parentheses, bound as in mathematics (`formula`); functions sqrt, exp, ln, log10, abs, sin,
//! cos, tan, tanh, floor, ceil, and min(a, b), max(a, b), step(a, edge) = 1 where a ≥ edge; pi; variables are the
//! scene's fields and x, y, z [pc]. The expression is zero outside of the union of its fields' boxes.
//!
//! Where grids take part it lives on a lattice of its own: the voxels of the finest of them, all over the box in which
//! the expression can be other than zero (`support`).

use std::sync::Arc;

use glam::DVec3;
use spectra::fingerprint::Digest;

use super::formula::{Parsed, parse};
use super::operators::{Binary, Unary};
use super::program::{Operation, Program};
use super::support::{Support, support};
use super::{Field, Grid, Lattice, fingerprint};
use crate::cache::Cache;
use crate::control::Control;
use crate::error::Result;
use crate::geometry::{Bounds, Ray};
use crate::memory;

/// An expression over named fields.
#[derive(Debug)]
pub struct Expression {
    formula: Formula,
    variables: Vec<Variable>,
    bounds: Bounds,
}

/// A formula that was parsed.
#[derive(Debug)]
pub(super) struct Formula {
    /// Names of its variables, sorted.
    pub(super) names: Vec<String>,
    pub(super) program: Program,
    /// True if a function of it jumps.
    jumps: bool,
}

#[derive(Debug)]
enum Variable {
    Field(Arc<dyn Field>),
    Axis(usize),
}

/// Places at which the formula and its fields are evaluated together.
const BLOCK: usize = 64;
/// The longest formula, in characters: parsing recurses with parentheses.
const MAX_LENGTH: usize = 2000;

/// A formula, or what is wrong with it.
pub(super) fn parsed(formula: &str) -> std::result::Result<Formula, String> {
    if formula.len() > MAX_LENGTH {
        return Err(format!("the expression has {} characters; at most {MAX_LENGTH} are supported", formula.len()));
    }
    let wrong = |e: String| format!("\"{formula}\" is not a valid expression: {e}");
    let Parsed { names, term } = parse(formula).map_err(wrong)?;
    let program = Program::new(&term);
    let jumps = program
        .operations()
        .iter()
        .any(|operation| matches!(operation, Operation::Two(Binary::Step, ..) | Operation::One(Unary::Floor | Unary::Ceil, _)));
    Ok(Formula { names, program, jumps })
}

/// The axis that a variable is: x, y or z.
fn axis(name: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|axis| *axis == name)
}

/// Variables of a formula.
fn variables(
    formula: &Formula,
    lookup: impl Fn(&str) -> std::result::Result<Arc<dyn Field>, String>,
) -> std::result::Result<Vec<Variable>, String> {
    let variable = |name: &String| axis(name).map_or_else(|| lookup(name).map(Variable::Field), |axis| Ok(Variable::Axis(axis)));
    formula.names.iter().map(variable).collect()
}

impl Expression {
    /// Parses `formula`; `lookup` finds fields by name. The message says what is wrong.
    ///
    /// # Errors
    /// If it is no expression, uses no field, or one that there is not.
    pub fn parse(formula: &str, lookup: impl Fn(&str) -> std::result::Result<Arc<dyn Field>, String>) -> std::result::Result<Self, String> {
        let parsed = parsed(formula)?;
        let variables = variables(&parsed, lookup)?;
        let own_bounds = |v: &Variable| if let Variable::Field(f) = v { Some(f.bounds()) } else { None };
        let smaller = |a: &Bounds, b: &Bounds| a.size().element_product().total_cmp(&b.size().element_product());
        let boxes = variables.iter().filter_map(own_bounds);
        let union = boxes.reduce(|a, b| a.union(&b)).ok_or_else(|| format!("\"{formula}\" uses no field"))?;
        let of_variable = |v: &Variable| match v {
            Variable::Field(f) => Support::Within(f.bounds()),
            Variable::Axis(_) => Support::Everywhere,
        };
        let bounds = match support(&parsed.program, &variables.iter().map(of_variable).collect::<Vec<_>>()) {
            Support::Within(within) => within.intersection(&union).unwrap_or(union),
            // Nothing at all: in the smallest of the boxes.
            Support::Number(0.0) => variables.iter().filter_map(own_bounds).min_by(smaller).unwrap_or(union),
            Support::Number(_) | Support::Everywhere => union,
        };
        Ok(Self { formula: parsed, variables, bounds })
    }

    /// A formula that holds in all of space, of fields or of none; those are zero outside of their boxes.
    ///
    /// # Errors
    /// If it is no expression, or uses a field that there is not.
    pub fn everywhere(
        formula: &str,
        lookup: impl Fn(&str) -> std::result::Result<Arc<dyn Field>, String>,
    ) -> std::result::Result<Self, String> {
        let formula = parsed(formula)?;
        let bounds = Bounds { low: DVec3::NEG_INFINITY, high: DVec3::INFINITY };
        Ok(Self { variables: variables(&formula, lookup)?, formula, bounds })
    }

    /// The names of the fields that `formula` is made of.
    ///
    /// # Errors
    /// If it is no expression.
    pub fn names(formula: &str) -> std::result::Result<Vec<String>, String> {
        Ok(parsed(formula)?.names.into_iter().filter(|name| axis(name).is_none()).collect())
    }

    /// True if `formula` may be other than zero outside of any boxes, whatever those of its fields are.
    pub fn is_endless(formula: &str) -> bool {
        let Ok(formula) = parsed(formula) else { return false };
        let unit = Bounds::cube(DVec3::ZERO, 1.0);
        let support_of = |name: &String| if axis(name).is_some() { Support::Everywhere } else { Support::Within(unit) };
        match support(&formula.program, &formula.names.iter().map(support_of).collect::<Vec<_>>()) {
            Support::Everywhere => true,
            Support::Number(number) => number != 0.0,
            Support::Within(_) => false,
        }
    }

    fn fields(&self) -> impl Iterator<Item = &Arc<dyn Field>> {
        self.variables.iter().filter_map(|v| if let Variable::Field(f) = v { Some(f) } else { None })
    }

    /// The field this expression is: the named field itself, a grid where a grid takes part, the function otherwise.
    ///
    /// # Errors
    /// If that grid would take more than `memory_limit` bytes, and on interruption by the user.
    pub fn into_field(self, memory_limit: u64, cache: Option<&dyn Cache>, control: &Control) -> Result<Arc<dyn Field>> {
        if let Some(Variable::Field(only)) = self.formula.program.variable().map(|variable| &self.variables[variable]) {
            return Ok(only.clone());
        }
        let Some(dims) = self.lattice().map(|l| (l.0.map(|n| n as u64), l.1)) else { return Ok(Arc::new(self)) };
        let (dims, bounds) = dims;
        let cells = dims.iter().try_fold(1u64, |n, d| n.checked_mul(*d)).unwrap_or(u64::MAX);
        let size = bounds.size();
        let what = format!(
            "an expression over a box of {:.4} x {:.4} x {:.4} pc in the voxels of its finest grid, {} x {} x {},",
            size.x, size.y, size.z, dims[0], dims[1], dims[2]
        );
        memory::check(&what, cells.saturating_mul(4), memory_limit)?;
        let lattice = Lattice { dims: dims.map(|n| n as usize), bounds };
        let values = |centres: &[DVec3], places: &[DVec3], values: &mut [f64]| {
            if !control.interrupted() {
                self.values(centres, places, values);
            }
        };
        let make = || {
            // A mask cuts through a voxel; what the grids hold there is theirs at its centre.
            let grid = match self.has_edges() {
                true => Grid::averaged(lattice.clone(), values),
                false => Grid::filled(lattice.clone(), |places, out| values(places, places, out)),
            };
            control.check().map(|()| grid)
        };
        Ok(Arc::new(Grid::stored(cache, || fingerprint(&self), &lattice, make)?))
    }

    /// The values of the formula at some places, with grids as they are at `centres` and functions at `places`.
    fn values(&self, centres: &[DVec3], places: &[DVec3], values: &mut [f64]) {
        let mut rows = Vec::new();
        for ((centres, places), values) in centres.chunks(BLOCK).zip(places.chunks(BLOCK)).zip(values.chunks_mut(BLOCK)) {
            let fill = |variable: usize, out: &mut [f64]| match &self.variables[variable] {
                Variable::Field(field) => field.sample(if field.grid().is_some() { centres } else { places }, out),
                Variable::Axis(axis) => out.iter_mut().zip(places).for_each(|(out, p)| *out = p[*axis]),
            };
            let evaluated = self.formula.program.run(places.len(), &mut rows, fill);
            for ((value, there), p) in values.iter_mut().zip(evaluated).zip(places) {
                *value = if self.bounds.contains(*p) { *there } else { 0.0 };
            }
        }
    }

    /// Voxels along each axis, and the box that they fill, where a grid takes part: those of the grid with the finest
    /// voxels, and as many more of the same edge and places as cover the expression's box.
    fn lattice(&self) -> Option<([usize; 3], Bounds)> {
        let volume = |lattice: &Lattice| lattice.voxel_pc().element_product();
        let lattices = self.fields().filter_map(|f| f.grid()).map(|g| &g.lattice);
        let finest = lattices.min_by(|a, b| volume(a).total_cmp(&volume(b)))?;
        let voxel = finest.voxel_pc();
        // Whole voxels from the finest grid's lowest corner; rounding makes no voxel of its own.
        let low = ((self.bounds.low - finest.bounds.low) / voxel + 1e-6).floor();
        let high = ((self.bounds.high - finest.bounds.low) / voxel - 1e-6).ceil().max(low + 1.0);
        let dims = <[f64; 3]>::from(high - low).map(|n| n as usize);
        if dims == finest.dims && low == DVec3::ZERO {
            return Some((dims, finest.bounds));
        }
        Some((dims, Bounds { low: finest.bounds.low + low * voxel, high: finest.bounds.low + high * voxel }))
    }
}

impl Field for Expression {
    fn content(&self, digest: &mut Digest) {
        digest.plain(&self.formula.program).plain(&self.formula.names).plain(&self.bounds);
        for variable in &self.variables {
            match variable {
                Variable::Field(field) => field.content(digest.text("field")),
                Variable::Axis(axis) => drop(digest.text("axis").integer(*axis as u64)),
            }
        }
    }
    fn at(&self, p: DVec3) -> f64 {
        let mut value = [0.0];
        self.sample(&[p], &mut value);
        value[0]
    }
    fn sample(&self, places: &[DVec3], values: &mut [f64]) {
        self.values(places, places, values);
    }
    fn bounds(&self) -> Bounds {
        self.bounds
    }
    fn has_edges(&self) -> bool {
        self.formula.jumps || self.fields().any(|f| f.has_edges())
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

    fn parse(formula: &str) -> std::result::Result<Expression, String> {
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
            ("max(max(b, 0.1), max(1, 2)) + a", 5.0),
            ("min(a, max(b, min(2, a*a)))^2", 4.0),
            ("min(min(min(a, 9), b + 2), sqrt((a + 1)^2)) - max(0, -b)^1.5*step(a, b)", 2.5),
            ("2*min(-a, (b))", -6.0),
        ] {
            assert!((parse(formula).unwrap().at(p) - value).abs() < 1e-12, "{formula}: {}", parse(formula).unwrap().at(p));
        }
        assert_eq!(parse("a + 1").unwrap().at(DVec3::splat(2.0)), 0.0);
    }

    /// Side by side the values have the bits that they have one by one, for every operator, within the box and outside.
    #[test]
    fn samples_are_the_values_themselves() {
        let places: Vec<DVec3> =
            (0..150).map(|i| DVec3::new(0.01 * i as f64 - 0.3, (i as f64).sin(), 0.9 * (0.3 * i as f64).cos())).collect();
        let one_argument = super::super::formula::functions().into_iter().map(|name| format!("a * {name}(x + 2) + b"));
        let two_arguments = super::super::formula::functions_of_two().into_iter().map(|name| format!("a * {name}(x, 0.4*y)"));
        let operators = ["a^2*x - b/(y+3)", "-(a^x) + z^3", "a*(x-y)^2"].map(String::from);
        for formula in one_argument.chain(two_arguments).chain(operators) {
            let expression = parse(&formula).unwrap();
            let mut values = vec![f64::NAN; places.len()];
            expression.sample(&places, &mut values);
            assert!(places.iter().zip(&values).all(|(p, value)| expression.at(*p) == *value), "{formula}");
            assert!(values.iter().filter(|v| **v != 0.0).count() > 40 && values.contains(&0.0), "{formula}");
        }
    }

    /// Grids of different boxes and voxels: a sum holds all that both hold, in the finest voxels; a product is no
    /// larger than its factors allow.
    #[test]
    fn nested_grids_lose_nothing() {
        let grid = |half: f64, n: usize| {
            let lattice = Lattice { dims: [n; 3], bounds: Bounds::cube(DVec3::ZERO, half) };
            Arc::new(Grid::sampled(lattice, |p| 1.0 + (3.0 * p.x).sin().powi(2)))
        };
        let (outer, inner) = (grid(2.0, 16), grid(0.5, 16));
        let field = |formula: &str, limit: u64| {
            let lookup = |name: &str| Ok(if name == "outer" { outer.clone() } else { inner.clone() } as Arc<dyn Field>);
            Expression::parse(formula, lookup).unwrap().into_field(limit, None, &Control::default())
        };
        let mass = |g: &Grid| g.values().iter().map(|v| f64::from(*v)).sum::<f64>() * g.lattice.voxel_pc().element_product();
        let sum = field("outer + inner", 1 << 30).unwrap();
        let sum = sum.grid().unwrap();
        assert_eq!((sum.lattice.dims, sum.lattice.bounds), ([64; 3], outer.lattice.bounds));
        assert!((mass(sum) / (mass(&outer) + mass(&inner)) - 1.0).abs() < 2e-3, "{} {}", mass(sum), mass(&outer) + mass(&inner));
        // Detail is where it was: at the centres of the finest voxels the sum is the sum.
        for i in 0..16 {
            let p = inner.lattice.centre(i, 15 - i, i / 2);
            assert!((sum.at(p) - outer.at(p) - inner.at(p)).abs() < 1e-5);
        }
        let corner = DVec3::splat(-1.9);
        assert!((sum.at(corner) - outer.at(corner)).abs() < 1e-2 && sum.at(corner) > 0.9);
        assert_eq!(field("outer * inner", 1 << 30).unwrap().grid().unwrap().lattice, inner.lattice);
        let refused = field("outer + inner", 1 << 19).unwrap_err().to_string();
        assert!(refused.contains("64 x 64 x 64") && refused.contains("finest grid"), "{refused}");
    }

    /// Nothing is made of an expression whose reading was interrupted.
    #[test]
    fn reading_can_be_interrupted() {
        let grid = Arc::new(Grid::sampled(Lattice { dims: [8; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) }, |_| 1.0));
        let control = Control::default();
        let read =
            || Expression::parse("n * step(0.5, x)", |_| Ok(grid.clone() as Arc<dyn Field>)).unwrap().into_field(1 << 30, None, &control);
        assert!(read().is_ok());
        control.interrupt();
        assert!(matches!(read(), Err(crate::error::Error::Interrupted)));
    }

    /// A mask that cuts through a grid's voxels leaves as much as it covers, and does not blur what the grid holds
    /// elsewhere.
    #[test]
    fn masks_cut_through_the_voxels_of_a_grid() {
        let lattice = Lattice { dims: [20; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let cube = Arc::new(Grid::sampled(lattice.clone(), |p| if (7.3 * p.x + 3.1 * p.y * p.z).sin() > 0.0 { 5.0 } else { 1.0 }));
        let lookup = |_: &str| Ok(cube.clone() as Arc<dyn Field>);
        let field = |formula: &str| Expression::parse(formula, lookup).unwrap().into_field(1 << 30, None, &Control::default()).unwrap();
        let cut = field("n * step(0.51, sqrt(x^2 + y^2 + z^2)) / n");
        let cut = cut.grid().unwrap();
        let volume = cut.values().iter().map(|v| f64::from(*v)).sum::<f64>() * cut.lattice.voxel_pc().element_product();
        let sphere = 4.0 / 3.0 * std::f64::consts::PI * 0.51f64.powi(3);
        assert!((volume / sphere - 1.0).abs() < 2e-3, "{}", volume / sphere - 1.0);
        // By the middles of voxels alone it is a percent off.
        let middles = Grid::sampled(cut.lattice.clone(), |p| f64::from(p.length() <= 0.51));
        assert!((middles.values().iter().sum::<f32>() * 1e-3 / sphere as f32 - 1.0).abs() > 5e-3);
        let masked = field("n * step(x, 0.02)");
        let masked = masked.grid().unwrap();
        for [x, y, z] in [[11, 3, 4], [15, 10, 0], [19, 19, 19]] {
            assert_eq!(masked.at(lattice.centre(x, y, z)), cube.at(lattice.centre(x, y, z)));
        }
        let edge = masked.at(lattice.centre(10, 3, 4)) / cube.at(lattice.centre(10, 3, 4));
        // Five of six parts.
        assert!((edge - 5.0 / 6.0).abs() < 1e-6, "{edge}");
    }

    #[test]
    fn mistakes_are_named() {
        assert!(parse("a + c").unwrap_err().contains("no field c"));
        assert!(parse("a +* b").is_err());
        assert!(parse("a^2^b").unwrap_err().contains("a^(b^c)"));
        assert!(parse("a/-b").unwrap_err().contains("parentheses"));
        assert!(parse("sine(a)").unwrap_err().contains("sin"));
        assert!(parse("a $ b").unwrap_err().contains("not allowed"));
        assert!(parse("min(a)").unwrap_err().contains("min(x, 0.5)"));
        assert!(parse("a, b").unwrap_err().contains("comma"));
        assert!(parse("max(a, b, 1)").unwrap_err().contains("comma"));
        assert!(parse("sqrt(a, b)").unwrap_err().contains("comma"));
        assert!(parse("max(a, b").is_err() && parse("a + max").is_err());
        for name in ["x", "pi", "exp", "a-b", "2a", ""] {
            assert!(super::super::formula::check_name(name).is_err(), "{name}");
        }
        assert!(["max_n", "e", "step1", "n_H"].iter().all(|n| super::super::formula::check_name(n).is_ok()));
        assert!(parse("3").unwrap_err().contains("uses no field"));
        assert!(parse(&"(".repeat(5000)).is_err());
    }
}
