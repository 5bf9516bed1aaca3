//! A few random wavelengths for each ray, chosen by importance: what real-time engines do, with its noise.
//!
//!   F(a) ≈ 1/n Σ_j W(λ_j)/p(λ_j) e^(−a k(λ_j)),   eq. (10) of docs/method.md
//!
//! p is the mean of all sources through the passband, each normalised; λ_j is drawn from the j-th of n parts of equal
//! probability (stratified), so no ray can be further off than the sum over the parts of what lies between the largest
//! and the smallest value in each, over n: that bound is the certificate. The mean over many rays is exact.

use super::{BandProblem, BandRule, Certificate, Decay, DepthSpan, Form, Measure, RuleEntry, mean_transmittance};
use crate::error::{Result, SpectraError};

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "sampled",
    summary: "random wavelengths per ray by importance, stratified: noise instead of bias; 4 by default",
    nodes: false,
    many_bands: None,
    solve,
};

/// The number of wavelengths for each ray.
const COUNT: usize = 4;
/// Most wavelengths for each ray.
const MAX_COUNT: usize = 256;
/// Depths at which the noise is bounded.
const DEPTHS: usize = 64;

/// The distribution that rays draw from.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// Wavelengths drawn for each ray.
    pub count: usize,
    /// The extinction k of each possible draw \[1\].
    pub k: Vec<f64>,
    /// Probability of all draws up to and with each \[1\].
    pub cumulative: Vec<f64>,
    /// W/p relative to F(0) of each draw, source × draw \[1\].
    pub ratio: Vec<Vec<f64>>,
    /// The measure that the mean over many rays has.
    expected: Vec<Measure>,
    /// The weights F(0)/n, source × sample.
    weights: Vec<Vec<f64>>,
}

impl Sampled {
    fn new(problem: &BandProblem, count: usize) -> Self {
        // All points of all sources, by wavelength.
        let mut points: Vec<(f64, f64, usize, f64)> = Vec::new();
        for (s, source) in problem.sources.iter().enumerate() {
            let total = source.measure.total();
            let measure = &source.measure;
            points.extend(measure.lambda_um.iter().zip(&measure.k).zip(&measure.mass).map(|((l, k), m)| (*l, *k, s, m / total)));
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|b, a| {
            // The same wavelength of another source is another draw unless it is the same point.
            a.0 == b.0 && a.2 == b.2 && {
                a.3 += b.3;
                true
            }
        });
        let mut sampled = Self::empty(problem, count);
        let sources = problem.sources.iter().filter(|s| s.measure.total() > 0.0).count().max(1) as f64;
        let mut sum = 0.0;
        for group in points.chunk_by(|a, b| a.0 == b.0) {
            let probability: f64 = group.iter().map(|p| p.3).sum::<f64>() / sources;
            if probability > 0.0 {
                sum += probability;
                sampled.k.push(group[0].1);
                sampled.cumulative.push(sum);
                for (s, ratio) in sampled.ratio.iter_mut().enumerate() {
                    ratio.push(group.iter().filter(|p| p.2 == s).map(|p| p.3).sum::<f64>() / probability);
                }
            }
        }
        sampled.cumulative.iter_mut().for_each(|c| *c /= sum);
        sampled
    }

    fn empty(problem: &BandProblem, count: usize) -> Self {
        let sources = problem.sources;
        Self {
            count,
            k: Vec::new(),
            cumulative: Vec::new(),
            ratio: vec![Vec::new(); sources.len()],
            expected: sources.iter().map(|s| s.measure.condensed(problem.depth)).collect(),
            weights: sources.iter().map(|s| vec![s.measure.total() / count as f64; count]).collect(),
        }
    }

    /// The draw of sample `j` of a ray at `u` in [0, 1) of its part.
    pub fn draw(&self, j: usize, u: f64) -> usize {
        let at = (j as f64 + u) / self.count as f64;
        self.cumulative.partition_point(|c| *c <= at).min(self.cumulative.len().saturating_sub(1))
    }

    /// The largest error that any ray can have, over the depths up to `depth`.
    fn bound(&self, s: usize, depth: f64) -> Certificate {
        let total = self.expected[s].total();
        let mut worst = Certificate { absolute: 0.0, relative: 0.0, depth };
        if total == 0.0 || self.k.is_empty() {
            return worst;
        }
        for i in 0..DEPTHS {
            let a = depth * (i as f64 / (DEPTHS - 1) as f64).powi(2);
            let part = |j: usize| {
                let (first, last) = (self.draw(j, 0.0), self.draw(j, 1.0 - 1e-12));
                let values = (first..=last).map(|i| self.ratio[s][i] * (-a * self.k[i]).exp());
                let (low, high) = values.fold((f64::MAX, 0.0), |(l, h), v| (f64::min(l, v), f64::max(h, v)));
                high - low
            };
            let absolute = (0..self.count).map(part).sum::<f64>() / self.count as f64;
            let relative = absolute * total / self.expected[s].at(a).max(f64::MIN_POSITIVE);
            worst = worst.or_worse(Certificate { absolute, relative, depth });
        }
        worst
    }
}

impl Decay for Sampled {
    fn terms(&self) -> usize {
        self.count
    }

    fn weights(&self, s: usize) -> &[f64] {
        &self.weights[s]
    }

    fn mean(&self, s: usize, weights: &[f64], depths: DepthSpan) -> f64 {
        let measure = &self.expected[s];
        let total = measure.total();
        if total == 0.0 {
            return 0.0;
        }
        let sum: f64 = measure.k.iter().zip(&measure.mass).map(|(k, m)| m * mean_transmittance(k * depths.from, k * depths.to)).sum();
        weights.iter().sum::<f64>() * sum / total
    }

    /// The certificate of what one ray can be off by, beside what the mean of all is off by.
    fn certificate(&self, s: usize, weights: &[f64], measure: &Measure, depth: f64) -> Certificate {
        let (mean, ray) = (Certificate::measured(measure, |a| self.mean(s, weights, DepthSpan::at(a)), depth), self.bound(s, depth));
        Certificate { absolute: mean.absolute + ray.absolute, relative: mean.relative + ray.relative, depth }
    }
}

fn solve(problem: &BandProblem) -> Result<BandRule> {
    let count = problem.settings.count.unwrap_or(COUNT);
    if count > MAX_COUNT {
        return Err(SpectraError::Rule(format!("{count} random wavelengths per ray are out of range; use at most {MAX_COUNT}")));
    }
    Ok(BandRule::certified(problem, Form::Sampled(Sampled::new(problem, count))))
}
