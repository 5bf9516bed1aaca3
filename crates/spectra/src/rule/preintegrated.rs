//! Pre-integration: the wavelengths of a passband in intervals, each with one extinction in front of a segment and a
//! table of what happens within it: eq. (12) of docs/method.md.
//!
//!   ∫ W e^(−k a) ds/Δs ≈ Σ_j e^(−k_j a₀) ∫_j W (1 − e^(−k Δ))/(k Δ) dλ,   a from a₀ to a₀ + Δ
//!
//! The tables are Engel, Kraus & Ertl's (2001) for a medium whose optical properties are linear in what is stored: of
//! their front value, back value and length only the segment's depth Δ is left. Factoring the light in front out of
//! each interval is Barrès & Neyret's spectral version.
//!
//! Source: Engel, Kraus & Ertl 2001, Graphics Hardware, doi:10.1145/383507.383515; Barrès & Neyret 2023.

use super::{BandProblem, BandRule, Certificate, Decay, DepthSpan, Form, Measure, RuleEntry, Source};
use crate::error::Result;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "preintegrated",
    summary: "intervals of wavelength with pre-integrated segments (Engel et al. 2001); their number chosen by accuracy",
    nodes: false,
    many_bands: None,
    solve,
};

const MAX_INTERVALS: usize = 256;
/// Entries of a table over a segment's depth.
const MIN_ENTRIES: usize = 64;
const MAX_ENTRIES: usize = 2048;
/// The part of the accuracy that reading it between its entries may cost.
const TABLE_SHARE: f64 = 0.1;

/// The form of intervals that the sources share, with tables for each.
#[derive(Debug, Clone)]
pub struct Preintegrated {
    /// Mean k of each interval \[1\].
    pub k: Vec<f64>,
    /// The tables, source × interval.
    pub tables: Vec<Vec<SegmentTable>>,
    /// The masses, source × interval.
    weights: Vec<Vec<f64>>,
    /// The interval of each point of the sources' measures goes by these ends [µm].
    ends: Vec<f64>,
    /// The error that reading the tables between their entries costs at most [1].
    reading: f64,
}

/// The mean over a segment of what is left of an interval's light at its front, over the root of the segment's depth:
/// thin segments and thick ones are read alike.
#[derive(Debug, Clone)]
pub struct SegmentTable {
    /// The step of √Δ \[1\].
    pub step: f64,
    /// The means at √Δ = 0, step, 2 step … \[1\].
    pub mean: Vec<f64>,
}

impl SegmentTable {
    /// The table of points (k, mass).
    fn new(points: &[(f64, f64)], step: f64, entries: usize) -> Self {
        let total: f64 = points.iter().map(|p| p.1).sum();
        let mean_to = |x: f64| if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 };
        let at = |delta: f64| points.iter().map(|(k, mass)| mass * mean_to(k * delta)).sum::<f64>() / total;
        let mean = if total > 0.0 { (0..entries).map(|i| at((step * i as f64).powi(2))).collect() } else { vec![1.0; 2] };
        Self { step, mean }
    }

    fn at(&self, delta: f64) -> f64 {
        let x = delta.sqrt() / self.step;
        let i = (x as usize).min(self.mean.len() - 2);
        self.mean[i] + (x - i as f64).min(1.0) * (self.mean[i + 1] - self.mean[i])
    }
}

impl Preintegrated {
    fn new(problem: &BandProblem, count: usize) -> Self {
        let (low, high) = problem.domain_um;
        let ends: Vec<f64> = (1..count).map(|i| low + (high - low) * i as f64 / count as f64).collect();
        let mut points = vec![vec![Vec::new(); count]; problem.sources.len()];
        let (mut k, mut mass) = (vec![0.0; count], vec![0.0; count]);
        for (points, source) in points.iter_mut().zip(problem.sources) {
            let measure = &source.measure;
            for ((lambda, at), m) in measure.lambda_um.iter().zip(&measure.k).zip(&measure.mass) {
                let j = ends.partition_point(|end| end <= lambda);
                points[j].push((*at, *m));
                // Every source has the same say in where an interval's extinction lies.
                let share = m / measure.total();
                k[j] += share * at;
                mass[j] += share;
            }
        }
        k.iter_mut().zip(&mass).for_each(|(k, mass)| *k = if *mass > 0.0 { *k / mass } else { problem.pivot.k });
        // The second derivative of (1 − e^(−k Δ))/(k Δ) over √Δ is never larger than k.
        let most = points.iter().flatten().flatten().map(|p| p.0).fold(f64::MIN_POSITIVE, f64::max);
        let root = problem.depth.max(1e-3).sqrt();
        let enough = root * (most / (8.0 * TABLE_SHARE * problem.accuracy)).sqrt();
        let entries = (enough.ceil() as usize).clamp(MIN_ENTRIES, MAX_ENTRIES);
        let step = root / (entries - 1) as f64;
        let reading = most * step * step / 8.0;
        let tables = points.iter().map(|s| s.iter().map(|p| SegmentTable::new(p, step, entries)).collect()).collect();
        let weights = points.iter().map(|s| s.iter().map(|p| p.iter().map(|p| p.1).sum()).collect()).collect();
        Self { k, tables, weights, ends, reading }
    }
}

impl Decay for Preintegrated {
    fn terms(&self) -> usize {
        self.k.len()
    }

    fn weights(&self, s: usize) -> &[f64] {
        &self.weights[s]
    }

    fn weights_with(&self, _: usize, source: &Source, factor: &dyn Fn(f64) -> f64) -> Vec<f64> {
        let mut weights = vec![0.0; self.k.len()];
        for (lambda, mass) in source.measure.lambda_um.iter().zip(&source.measure.mass) {
            weights[self.ends.partition_point(|end| end <= lambda)] += mass * factor(*lambda);
        }
        weights
    }

    fn mean(&self, s: usize, weights: &[f64], depths: DepthSpan) -> f64 {
        let (front, delta) = (depths.low(), depths.high() - depths.low());
        self.k.iter().zip(&self.tables[s]).zip(weights).map(|((k, table), w)| w * (-k * front).exp() * table.at(delta)).sum()
    }

    /// The certificate of light behind any depth, and of what reading adds in a segment: where that is thick its mean
    /// is small, and so is what is lost of it.
    fn certificate(&self, s: usize, weights: &[f64], measure: &Measure, depth: f64) -> Certificate {
        let plain = Certificate::measured(measure, |a| self.mean(s, weights, DepthSpan::at(a)), depth);
        Certificate { absolute: plain.absolute + self.reading, relative: plain.relative + 2.0 * self.reading, depth }
    }
}

fn solve(problem: &BandProblem) -> Result<BandRule> {
    let attempt = |count: usize| BandRule::certified(problem, Form::Preintegrated(Preintegrated::new(problem, count)));
    let mut count = problem.settings.count.unwrap_or(1);
    let mut rule = attempt(count);
    while problem.settings.count.is_none() && rule.worst() > problem.accuracy && count < MAX_INTERVALS {
        count *= 2;
        rule = attempt(count);
    }
    Ok(rule)
}
