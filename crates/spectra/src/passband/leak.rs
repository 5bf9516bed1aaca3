//! Light that a passband lets through far from where it is meant to.
//!
//! A band ends where its curve, from the peak outwards, first falls to a hundredth of that; what lies farther than its
//! full width at half maximum from either end is far. Behind enough dust, or before a cool star, an ultraviolet filter
//! sees little but its red leak.

use super::Passband;

/// Throughput far from the band, where there is more than 1e-4 of the peak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leak {
    /// The largest throughput there, in parts of the peak \[1\].
    pub throughput: f64,
    /// The share of the integral of the throughput \[1\].
    pub share: f64,
    /// The wavelength of the largest of it \[µm\].
    pub at_um: f64,
}

/// The throughput that is worth a word, in parts of the peak.
const LEAST: f64 = 1e-4;
/// The throughput at which a band ends, in parts of the peak.
const EDGE: f64 = 1e-2;
/// Places where a curve is looked at beside its own corners.
const SAMPLES: usize = 10_000;

impl std::fmt::Display for Leak {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { throughput, share, at_um } = self;
        write!(f, "leaks {throughput:.1e} of its peak at {:.0} nm, {share:.1e} of its integral", at_um * 1e3)
    }
}

impl Passband {
    /// The light that the band lets through far from where it is meant to; none where that is little.
    pub fn leak(&self) -> Option<Leak> {
        let (low, high) = self.support_um();
        let even = (0..=SAMPLES).map(|i| low + (high - low) * i as f64 / SAMPLES as f64);
        let lambda = self.pieces(&even.collect::<Vec<f64>>());
        // λ, the width that a sample stands for, T.
        let width = |i: usize| 0.5 * (lambda[(i + 1).min(lambda.len() - 1)] - lambda[i.saturating_sub(1)]);
        let samples: Vec<(f64, f64, f64)> = (0..lambda.len()).map(|i| (lambda[i], width(i), self.curve.throughput(lambda[i]))).collect();
        let (middle, peak) = samples.iter().enumerate().map(|(i, s)| (i, s.2)).max_by(|a, b| a.1.total_cmp(&b.1))?;
        let at = |i: usize| samples[i].0;
        let above = |level: f64| move |s: &(f64, f64, f64)| s.2 > level * peak;
        let first = samples[..middle].iter().rposition(|s| !above(EDGE)(s)).map_or(at(0), at);
        let last = samples[middle..].iter().position(|s| !above(EDGE)(s)).map_or(at(samples.len() - 1), |i| at(middle + i));
        let half = samples.iter().position(above(0.5)).map(at)?..samples.iter().rposition(above(0.5)).map(at)?;
        let width = half.end - half.start;
        let far = samples.iter().filter(|s| s.0 < first - width || s.0 > last + width);
        let (at_um, throughput) = far.clone().map(|s| (s.0, s.2 / peak)).max_by(|a, b| a.1.total_cmp(&b.1))?;
        let sum = |share: f64, s: &(f64, f64, f64)| share + s.1 * s.2;
        let share = far.fold(0.0, sum) / samples.iter().fold(0.0, sum);
        (throughput > LEAST).then_some(Leak { throughput, share, at_um })
    }
}
