//! How terms fall with optical depth, on the device: the forms of `spectra::rule`, one file, one shader and one row
//! each.

mod analytic;
mod common_nodes;
mod lookup;
mod nodes;
mod preintegrated;
mod projection;

pub use nodes::{GENTLE, cumulants};

use barnard::plan::Plan;
use spectra::rule::{Form, Projection};

use crate::error::{GpuError, Result};
use crate::tables::QuadList;

/// A form of spectral terms that shaders have.
pub struct FormEntry {
    /// The name of the form.
    pub name: &'static str,
    /// True if a rule's form is this one.
    pub is_form: fn(&Form) -> bool,
    /// The text of the functions `accumulate` and `left`.
    pub wgsl: &'static str,
    /// Heads of tables for each light.
    pub heads: Heads,
    /// True if `left` knows what is left behind a depth, so that rays can end early.
    pub bounded: bool,
    /// True if `accumulate` is so short that it is written out for each star.
    pub is_short: bool,
    /// Turns of loops for a segment.
    pub turns: Turns,
    /// Writes heads and tables; lights stand in the order of the shape.
    pub fill: fn(&Plan, &[usize], &mut Contents) -> Result<()>,
}

/// Turns of loops that a segment takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Turns {
    pub each_band: usize,
    pub each_term: usize,
}

/// The number of table heads that a form has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heads {
    /// The form has one head for each band.
    Bands,
    /// The form has one head for each light and band.
    LightsAndBands,
    /// The form has one head for each light and term.
    LightsAndTerms,
}

impl PartialEq for FormEntry {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl std::fmt::Debug for FormEntry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// All forms that shaders have.
pub const FORMS: &[&FormEntry] =
    &[&nodes::ENTRY, &common_nodes::ENTRY, &lookup::ENTRY, &projection::ENTRY, &analytic::ENTRY, &preintegrated::ENTRY];

/// The form of a plan's rules.
///
/// # Errors
/// If no shader has it.
pub fn form(plan: &Plan) -> Result<&'static FormEntry> {
    let Some(band) = plan.spectral().bands.first() else { return Ok(FORMS[0]) };
    let known = FORMS.iter().find(|f| (f.is_form)(&band.rule.form));
    known.copied().ok_or_else(|| GpuError::Method(plan.spectral().method.into()))
}

/// The extinction k of each term, zero where a form has none.
pub fn extinctions(plan: &Plan) -> Vec<f32> {
    if let Some(common) = plan.spectral().common_nodes() {
        return common.iter().map(|node| node.k as f32).collect();
    }
    let of_band = |form: &Form, terms: usize| match form {
        Form::Nodes(nodes) => nodes.nodes.iter().map(|n| n.k as f32).collect(),
        Form::Preintegrated(intervals) => intervals.k.iter().map(|k| *k as f32).collect(),
        _ => vec![0.0; terms],
    };
    plan.spectral().bands.iter().flat_map(|b| of_band(&b.rule.form, b.terms())).collect()
}

/// Heads, and the tables that they tell of.
pub struct Contents {
    /// The heads, as many as [`Heads`] says; where a table starts is a number of quads.
    pub heads: Vec<[f32; 4]>,
    /// Tables one behind the other.
    pub tables: QuadList,
    /// The quad at which the contents will stand.
    start: usize,
}

impl Contents {
    /// Empty contents that will stand at quad `start`, behind a number of headers.
    pub fn new(heads: usize, start: usize) -> Self {
        Self { heads: vec![[0.0; 4]; heads], tables: QuadList::default(), start }
    }

    /// The quad at which the next table starts.
    pub fn here(&self) -> f32 {
        (self.start + self.tables.0.len()) as f32
    }

    /// A table at equal steps: its head, with entries per unit, gaps and where it starts.
    pub fn equal_steps(&mut self, step: f64, values: &[f64]) -> [f32; 4] {
        let head = [(1.0 / step) as f32, (values.len() - 1) as f32, self.here(), 0.0];
        self.tables.numbers(&values.iter().map(|v| *v as f32).collect::<Vec<_>>(), 0);
        head
    }

    /// Coordinates of a basis as `coordinates.wgsl` reads them.
    pub fn coordinates(&mut self, projection: &Projection) -> [f32; 4] {
        let values = &projection.coordinates;
        let (size, gaps) = (projection.basis.size(), values.len() - 1);
        let head = [(1.0 / projection.step) as f32, gaps as f32, self.here(), size as f32];
        self.tables.0.push([projection.short as f32, 0.0, 0.0, 0.0]);
        let curvatures = |i: usize| projection.basis.moments(projection.step * i as f64, 2);
        let mut curvature = curvatures(0);
        for gap in 0..gaps {
            let next = curvatures(gap + 1);
            for e in 0..size {
                let (value, growth) = (values[gap][e], values[gap + 1][e] - values[gap][e]);
                self.tables.0.push([value as f32, growth as f32, (curvature[e] / 6.0) as f32, ((next[e] - curvature[e]) / 6.0) as f32]);
            }
            curvature = next;
        }
        // A number and what single precision loses of it.
        let pair = |v: f64| [v as f32, (v - f64::from(v as f32)) as f32];
        for left in &projection.left[..gaps] {
            self.tables.0.extend(left.iter().map(|v| pair(*v)).map(|[high, low]| [high, low, 0.0, 0.0]));
        }
        head
    }
}
