//! F itself as a table over optical depth, for each source: eq. (11) of docs/method.md.
//!
//! ln F(a) is concave-up and smooth; it is tabulated at equal steps of a and taken linear between: in an interval the medium is grey
//! with the local mean extinction −d ln F/da. The number of entries doubles until `accuracy` is kept.

use super::{BandProblem, BandRule, Decay, Form, Measure, RuleEntry, mean_transmittance};
use crate::error::Result;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "lookup",
    summary: "a table of the band integral over optical depth for each source; size chosen by accuracy",
    nodes: false,
    solve,
};

const MIN_ENTRIES: usize = 64;
const MAX_ENTRIES: usize = 1 << 14;

/// A table for each source; one term.
#[derive(Debug, Clone)]
pub struct Lookup {
    /// ln F of each source.
    pub tables: Vec<DepthTable>,
    /// F(0), source × 1.
    weights: Vec<[f64; 1]>,
}

impl Decay for Lookup {
    fn terms(&self) -> usize {
        1
    }

    fn weights(&self, s: usize) -> &[f64] {
        &self.weights[s]
    }

    /// In a short course the medium is grey with the local mean extinction.
    fn mean(&self, s: usize, weights: &[f64], (from, to): (f64, f64)) -> f64 {
        let (log, slope) = self.tables[s].at(0.5 * (from + to));
        let y = 0.5 * slope * (to - from);
        weights[0] * log.exp() * mean_transmittance(-y, y)
    }
}

/// ln F at equal steps of optical depth.
#[derive(Debug, Clone)]
pub struct DepthTable {
    /// Step of the depth [1].
    pub step: f64,
    /// ln (F(a)/F(0)) at a = 0, step, 2 step … [1].
    pub log: Vec<f64>,
}

impl DepthTable {
    fn new(measure: &Measure, depth: f64, entries: usize) -> Self {
        let scale = measure.total();
        let step = depth.max(1e-3) / (entries - 1) as f64;
        let log = (0..entries).map(|i| ratio(measure.at(step * i as f64), scale).ln()).collect();
        Self { step, log }
    }

    /// ln (F(a)/F(0)) and its slope; beyond the last entry the last slope goes on.
    pub fn at(&self, depth: f64) -> (f64, f64) {
        let x = depth / self.step;
        let i = (x as usize).min(self.log.len() - 2);
        let rise = self.log[i + 1] - self.log[i];
        (self.log[i] + (x - i as f64) * rise, rise / self.step)
    }
}

/// F(a)/F(0), kept above the least number whose logarithm is harmless.
fn ratio(value: f64, scale: f64) -> f64 {
    if scale > 0.0 { (value / scale).max(1e-300) } else { 1.0 }
}

fn solve(problem: &BandProblem) -> Result<BandRule> {
    let of = |entries: usize| {
        let tables = problem.sources.iter().map(|s| DepthTable::new(&s.measure, problem.depth, entries)).collect();
        let weights = problem.sources.iter().map(|s| [s.measure.total()]).collect();
        BandRule::certified(problem, Form::Lookup(Lookup { tables, weights }))
    };
    let mut entries = problem.settings.count.unwrap_or(MIN_ENTRIES).max(2);
    let mut rule = of(entries);
    while problem.settings.count.is_none() && rule.worst() > problem.accuracy && entries < MAX_ENTRIES {
        entries *= 2;
        rule = of(entries);
    }
    Ok(rule)
}
