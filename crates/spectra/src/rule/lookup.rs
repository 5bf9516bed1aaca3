//! F itself as a table over optical depth, for each source: eq. (11) of docs/method.md.
//!
//! ln F(a) is concave-up and smooth; it is tabulated at equal steps of a and taken linear between: in an interval the
//! medium is grey with the local mean extinction −d ln F/da. The number of entries doubles until `accuracy` is kept.
//! Means over a span of depths are those of the table, exactly: what it leaves behind every entry, ∫ F da, is
//! tabulated too.

use super::depths::TablePlace;
use super::{BandProblem, BandRule, Decay, DepthSpan, Form, Measure, RuleEntry, mean_transmittance};
use crate::error::Result;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "lookup",
    summary: "a table of the band integral over optical depth for each source; size chosen by accuracy",
    nodes: false,
    many_bands: None,
    solve,
};

const MIN_ENTRIES: usize = 64;
const MAX_ENTRIES: usize = 1 << 14;

/// A table for each source; one term.
#[derive(Debug, Clone)]
pub struct Lookup {
    /// The table of ln F of each source.
    pub tables: Vec<DepthTable>,
    /// The F(0) of each source, source × 1.
    weights: Vec<[f64; 1]>,
}

impl Decay for Lookup {
    fn terms(&self) -> usize {
        1
    }

    fn weights(&self, s: usize) -> &[f64] {
        &self.weights[s]
    }

    fn mean(&self, s: usize, weights: &[f64], depths: DepthSpan) -> f64 {
        weights[0] * self.tables[s].mean(depths.low(), depths.high())
    }
}

/// A table of ln F at equal steps of optical depth.
#[derive(Debug, Clone)]
pub struct DepthTable {
    /// Step of the depth \[1\].
    pub step: f64,
    /// The ln (F(a)/F(0)) at a = 0, step, 2 step … \[1\].
    pub log: Vec<f64>,
    /// ∫ F/F(0) da from there to the last entry \[1\].
    pub left: Vec<f64>,
}

impl DepthTable {
    /// Half growth of −ln F up to which [`rows`](Self::rows) may be read in the middle of a span alone, and what its
    /// bend may change there: third cumulants of a passband and squares of the second are left out, 1e-6 at most.
    pub const THIN: f32 = 0.15;
    /// The most that the bend may change the mean of a span, for [`THIN`](Self::THIN) spans.
    pub const EVEN: f32 = 1e-3;

    fn new(measure: &Measure, depth: f64, entries: usize) -> Self {
        let scale = measure.total();
        let step = depth.max(1e-3) / (entries - 1) as f64;
        let log = (0..entries).map(|i| ratio(measure.at(step * i as f64), scale).ln()).collect();
        Self::of(step, log)
    }

    /// The table of logarithms at equal steps.
    fn of(step: f64, log: Vec<f64>) -> Self {
        let mut left = vec![0.0; log.len()];
        for i in (0..log.len() - 1).rev() {
            left[i] = left[i + 1] + step * mean_transmittance(-log[i], -log[i + 1]);
        }
        Self { step, log, left }
    }

    /// The gap between two entries in which a depth lies, and how far within; beyond the last entry the last gap goes
    /// on.
    fn place(&self, depth: f64) -> TablePlace {
        TablePlace::new(depth / self.step, self.log.len())
    }

    /// −ln (F/F(0)) at a place.
    fn depth_at(&self, TablePlace { gap, fraction }: TablePlace) -> f64 {
        -(self.log[gap] + fraction * (self.log[gap + 1] - self.log[gap]))
    }

    /// The mean of F/F(0) over the depths between two.
    fn mean(&self, low: f64, high: f64) -> f64 {
        let (first, last) = (self.place(low), self.place(high));
        let within = mean_transmittance(self.depth_at(first), self.depth_at(last));
        if first.gap == last.gap {
            return within;
        }
        let before = (1.0 - first.fraction) * mean_transmittance(self.depth_at(first), -self.log[first.gap + 1]);
        let after = last.fraction * mean_transmittance(-self.log[last.gap], self.depth_at(last));
        let gaps = (1.0 - first.fraction) + (last.gap - first.gap - 1) as f64 + last.fraction;
        (before + after + (self.left[first.gap + 1] - self.left[last.gap]) / self.step) / gaps
    }

    /// The rows that back ends read: ln F at each entry but the last, how much it rises to the next, half of its second
    /// derivative over the depth, and what is left behind the entry.
    pub fn rows(&self) -> impl Iterator<Item = [f64; 4]> + '_ {
        let gaps = self.log.len() - 1;
        let rise = |i: usize| self.log[i + 1] - self.log[i];
        let bend = move |i: usize| {
            let (low, high) = (i.saturating_sub(1), (i + 1).min(gaps - 1));
            if high > low { 0.5 * (rise(high) - rise(low)) / ((high - low) as f64 * self.step * self.step) } else { 0.0 }
        };
        (0..gaps).map(move |i| [self.log[i], rise(i), bend(i), self.left[i]])
    }
}

/// F(a)/F(0), kept above the least number whose logarithm is harmless.
fn ratio(value: f64, scale: f64) -> f64 {
    if scale > 0.0 { (value / scale).max(1e-300) } else { 1.0 }
}

fn solve(problem: &BandProblem) -> Result<BandRule> {
    let table = |entries: usize| {
        let tables = problem.sources.iter().map(|s| DepthTable::new(&s.measure, problem.depth, entries)).collect();
        let weights = problem.sources.iter().map(|s| [s.measure.total()]).collect();
        BandRule::certified(problem, Form::Lookup(Lookup { tables, weights }))
    };
    let mut entries = problem.settings.count.unwrap_or(MIN_ENTRIES).max(2);
    let mut rule = table(entries);
    while problem.settings.count.is_none() && rule.worst() > problem.accuracy && entries < MAX_ENTRIES {
        entries *= 2;
        rule = table(entries);
    }
    Ok(rule)
}
