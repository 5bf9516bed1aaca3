//! Barrès & Neyret's method: e^(−a k) projected on a few exponentials, F(a) ≈ Σ_i q_i(a) ∫ W Q_i dλ, eq. (17) of
//! docs/method.md.
//!
//! The integrals are constant over a picture, the coordinates q_i(a) a table that all passbands and lights share; see
//! [`crate::basis`]. The basis lives on one domain for all passbands and one range of the argument; beyond the range
//! the last coordinates are held, and the certificate says what that costs. F̂ can go negative where little light is
//! left.
//!
//! Source: Barrès & Neyret 2023.

use super::depths::TablePlace;
use super::{BandProblem, BandRule, Decay, DepthSpan, Form, Measure, RuleEntry, Source};
use crate::basis::{Basis, Criterion, Domain, MAX_SIZE};
use crate::error::Result;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "projection",
    summary: "Barrès & Neyret's projection on 1 to 8 exponentials; size chosen by accuracy",
    nodes: false,
    many_bands: None,
    solve,
};

/// The part of the accuracy that a basis may use up, as for the default.
const SHARE: f64 = 0.3;
/// The part of the accuracy that reading the table between its entries may cost.
const TABLE_SHARE: f64 = 0.03;
/// The part of the entries' step in which a span of depths is one depth.
const ONE_DEPTH: f64 = 1e-9;
const MIN_ENTRIES: usize = 256;
const MAX_ENTRIES: usize = 1 << 14;

/// Coordinates over depth and the integrals of each source.
#[derive(Debug, Clone)]
pub struct Projection {
    /// The basis that light is projected on.
    pub basis: Basis,
    /// Step of the table's depths \[1\].
    pub step: f64,
    /// The coordinates q_i(a) at a = 0, step, 2 step … \[entry\]\[element\].
    pub coordinates: Vec<Vec<f64>>,
    /// ∫ q_i da from there to the last entry, of coordinates that are linear between entries \[entry\]\[element\].
    pub left: Vec<Vec<f64>>,
    /// Half length of a span of depths up to which ⟨q⟩ is q + half² q″/6 at its middle, as exactly as the table is
    /// read \[1\].
    pub short: f64,
    /// ∫ W Q_i dλ, source × element.
    integrals: Vec<Vec<f64>>,
}

impl Projection {
    fn new(problem: &BandProblem, domain: &Domain, size: usize) -> Result<Self> {
        let range = problem.settings.range.unwrap_or(problem.depth);
        let basis = Basis::optimal(domain, range, size, problem.settings.criterion)?;
        let norm = domain.exponential(0.0).norm();
        let mut entries = MIN_ENTRIES + 1;
        while interpolation_error(&basis, entries) > TABLE_SHARE * problem.accuracy * norm && entries < MAX_ENTRIES {
            entries = 2 * entries - 1;
        }
        let step = basis.range / (entries - 1) as f64;
        let coordinates: Vec<Vec<f64>> = (0..entries).map(|i| basis.coordinates(step * i as f64)).collect();
        let mut left = vec![vec![0.0; size]; entries];
        for i in (0..entries - 1).rev() {
            left[i] = (0..size).map(|e| left[i + 1][e] + 0.5 * step * (coordinates[i][e] + coordinates[i + 1][e])).collect();
        }
        // What is left out is half⁴ q⁗/120.
        let bent = basis.moments(0.0, 4).into_iter().fold(f64::MIN_POSITIVE, |most, q| most.max(q.abs()));
        let short = (120.0 * TABLE_SHARE * problem.accuracy * norm / bent).powf(0.25);
        let integrals = problem.sources.iter().map(|s| integrals(&basis, &s.measure)).collect();
        Ok(Self { basis, step, coordinates, left, short, integrals })
    }

    /// The gap between two entries in which a depth lies, and how far within, held at the last entry.
    fn place(&self, depth: f64) -> TablePlace {
        let TablePlace { gap, fraction } = TablePlace::new(depth / self.step, self.coordinates.len());
        TablePlace { gap, fraction: fraction.min(1.0) }
    }

    fn value(&self, TablePlace { gap, fraction }: TablePlace, element: usize) -> f64 {
        let (low, high) = (self.coordinates[gap][element], self.coordinates[gap + 1][element]);
        low + fraction * (high - low)
    }

    /// The coordinates q_i at one depth \[element\].
    pub fn at(&self, depth: f64) -> impl Iterator<Item = f64> + '_ {
        let place = self.place(depth);
        (0..self.basis.size()).map(move |element| self.value(place, element))
    }

    /// ⟨q_i⟩ over the depths between two \[element\].
    pub fn means(&self, low: f64, high: f64) -> impl Iterator<Item = f64> + '_ {
        let (first, last) = (self.place(low), self.place(high));
        let end = self.step * (self.coordinates.len() - 1) as f64;
        let (steps, span) = ((high - low) / self.step, (high.max(end) - low.max(end)) / self.step);
        (0..self.basis.size()).map(move |element| {
            let (from, to) = (self.value(first, element), self.value(last, element));
            if steps < ONE_DEPTH {
                return 0.5 * (from + to);
            }
            let within = if first.gap == last.gap {
                0.5 * (last.fraction - first.fraction) * (from + to)
            } else {
                let before = 0.5 * (1.0 - first.fraction) * (from + self.coordinates[first.gap + 1][element]);
                let after = 0.5 * last.fraction * (self.coordinates[last.gap][element] + to);
                before + after + (self.left[first.gap + 1][element] - self.left[last.gap][element]) / self.step
            };
            (within + span * to) / steps
        })
    }
}

/// The largest difference between a coordinate and the line between its entries, where coordinates bend most.
fn interpolation_error(basis: &Basis, entries: usize) -> f64 {
    let step = basis.range / (entries - 1) as f64;
    let (a, m, b) = (basis.coordinates(0.0), basis.coordinates(0.5 * step), basis.coordinates(step));
    (0..basis.size()).map(|i| (0.5 * (a[i] + b[i]) - m[i]).abs()).fold(0.0, f64::max)
}

/// The integrals ∫ W Q_i dλ \[element\].
fn integrals(basis: &Basis, measure: &Measure) -> Vec<f64> {
    let mut sum = vec![0.0; basis.size()];
    for (k, mass) in measure.k.iter().zip(&measure.mass) {
        sum.iter_mut().zip(basis.elements(*k)).for_each(|(s, q)| *s += mass * q);
    }
    sum
}

impl Decay for Projection {
    fn terms(&self) -> usize {
        self.basis.size()
    }

    fn weights(&self, s: usize) -> &[f64] {
        &self.integrals[s]
    }

    fn weights_with(&self, _: usize, source: &Source, factor: &dyn Fn(f64) -> f64) -> Vec<f64> {
        integrals(&self.basis, &source.measure.reweighted(factor))
    }

    fn mean(&self, _: usize, weights: &[f64], depths: DepthSpan) -> f64 {
        self.means(depths.low(), depths.high()).zip(weights).map(|(q, w)| q * w).sum()
    }

    fn size(&self, _: usize, weights: &[f64], depth: f64) -> f64 {
        self.at(depth).zip(weights).map(|(q, w)| (q * w).abs()).sum()
    }
}

fn solve(problem: &BandProblem) -> Result<BandRule> {
    let weight = |l: f64| problem.sources.iter().map(|s| (s.density)(l) / s.measure.total().max(f64::MIN_POSITIVE)).sum::<f64>();
    let domain = match problem.settings.criterion {
        Criterion::Filter => Domain::new(problem.domain_um, problem.k, weight)?,
        Criterion::Mean | Criterion::Largest => Domain::new(problem.common_um, problem.k, |_| 1.0)?,
    };
    let sized = |size: usize| Ok(BandRule::certified(problem, Form::Projection(Projection::new(problem, &domain, size)?)));
    if let Some(size) = problem.settings.count {
        return sized(size);
    }
    let mut best: BandRule = sized(1)?;
    for size in 2..=MAX_SIZE {
        if best.worst() <= SHARE * problem.accuracy {
            break;
        }
        // Elements that rounding can no longer tell apart end the growth.
        match sized(size) {
            Ok(rule) if rule.worst() < best.worst() => best = rule,
            _ => break,
        }
    }
    Ok(best)
}
