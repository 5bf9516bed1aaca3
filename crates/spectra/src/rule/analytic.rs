//! Barrès & Neyret's closed form: k = c/λ and W a polynomial, F(a) = Σ cₙ [λ^(n+1) E_{n+2}(a c/λ)], eq. (13) of
//! docs/method.md.
//!
//! W of each source is fitted by a polynomial over the passband; the fit's error is reported apart, the certificate
//! holds all of it. Lines are no polynomials: they stay exponentials. See [`crate::polynomial`].
//!
//! Source: Barrès & Neyret 2023, "naive analytical".

use super::{BandProblem, BandRule, Decay, DepthSpan, Form, RuleEntry, Source, mean_transmittance};
use crate::error::{Result, SpectraError};
use crate::polynomial::{Attenuated, Fit, Polynomial};

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "analytic",
    summary: "exponential integrals of polynomial spectra, for extinction proportional to 1/lambda: Barrès & Neyret's naive analytical method",
    nodes: false,
    many_bands: None,
    solve,
};

/// Wavelengths at which a spectrum is fitted.
const SAMPLES: usize = 512;
/// Relative deviation of k λ from a constant that still is extinction proportional to 1/λ.
const TOLERANCE: f64 = 1e-9;
/// Half a span of depths times the spread of k up to which a medium is grey: its light is off by less than a sixth of
/// its square.
const GREY: f64 = 1e-3;

/// The form of one polynomial for each source, and one term.
#[derive(Debug, Clone)]
pub struct Analytic {
    /// The constant c = k λ \[µm\].
    pub c_um: f64,
    /// The polynomial of each source.
    pub sources: Vec<PolynomialSource>,
    /// The F(0) of each source, source × 1.
    weights: Vec<[f64; 1]>,
}

/// A source as a polynomial and lines.
#[derive(Debug, Clone)]
pub struct PolynomialSource {
    /// The polynomial with what its fit costs.
    pub fit: Fit,
    /// The (k, mass) of each line.
    pub lines: Vec<(f64, f64)>,
    /// The F(0) of the whole source.
    pub total: f64,
}

impl PolynomialSource {
    fn new(problem: &BandProblem, source: &Source) -> Result<Self> {
        let (low, high) = problem.domain_um;
        let at = |i: usize| low + (high - low) * i as f64 / (SAMPLES - 1) as f64;
        let points: Vec<(f64, f64, f64)> = (0..SAMPLES).map(|i| (at(i), (source.density)(at(i)), 1.0)).collect();
        let fit = Polynomial::fit(&points, problem.settings.degree)?;
        let lines: Vec<(f64, f64)> = source.lines.iter().map(|(l, mass)| ((problem.k)(*l), *mass)).collect();
        let total = fit.polynomial.against_exponential(0.0).value + lines.iter().map(|l| l.1).sum::<f64>();
        Ok(Self { fit, lines, total })
    }

    /// F, −dF/da and ∫ F da from there on at depth `a`.
    fn at(&self, c_um: f64, a: f64) -> Attenuated {
        let continuum = self.fit.polynomial.against_exponential(a * c_um);
        let continuum = Attenuated { value: continuum.value, slope: c_um * continuum.slope, left: continuum.left / c_um };
        self.lines.iter().fold(continuum, |sum, (k, mass)| {
            let line = mass * (-a * k).exp();
            Attenuated { value: sum.value + line, slope: sum.slope + k * line, left: sum.left + line / k }
        })
    }

    /// Half the difference between the largest and the smallest k at which the polynomial shines \[1\].
    pub fn spread(&self, c_um: f64) -> f64 {
        let (low, high) = self.fit.polynomial.interval_um;
        0.5 * (c_um / low - c_um / high)
    }

    /// The mean of F over a span of depths.
    pub fn mean(&self, c_um: f64, DepthSpan { from, to }: DepthSpan) -> f64 {
        let half = 0.5 * (to - from);
        if half.abs() * self.spread(c_um) > GREY {
            return (self.at(c_um, from).left - self.at(c_um, to).left) / (to - from);
        }
        let Attenuated { value, slope, .. } = self.at(c_um, 0.5 * (from + to));
        let y = if value > 0.0 { slope / value * half } else { 0.0 };
        value * mean_transmittance(-y, y)
    }
}

impl Decay for Analytic {
    fn terms(&self) -> usize {
        1
    }

    fn weights(&self, s: usize) -> &[f64] {
        &self.weights[s]
    }

    fn fit(&self, s: usize) -> Option<&Fit> {
        Some(&self.sources[s].fit)
    }

    fn mean(&self, s: usize, weights: &[f64], depths: DepthSpan) -> f64 {
        let source = &self.sources[s];
        if source.total == 0.0 { 0.0 } else { weights[0] * source.mean(self.c_um, depths) / source.total }
    }
}

fn solve(problem: &BandProblem) -> Result<BandRule> {
    let (low, high) = problem.domain_um;
    let c_um = high * (problem.k)(high);
    for i in 0..=16 {
        let lambda = low + (high - low) * f64::from(i) / 16.0;
        if lambda > 0.0 && (lambda * (problem.k)(lambda) / c_um - 1.0).abs() > TOLERANCE {
            let message =
                "method \"analytic\" requires extinction proportional to 1/lambda; use law = \"inverse_wavelength\" or another method";
            return Err(SpectraError::Rule(message.into()));
        }
    }
    let sources = problem.sources.iter().map(|s| PolynomialSource::new(problem, s)).collect::<Result<Vec<_>>>()?;
    let weights = sources.iter().map(|s| [s.total]).collect();
    Ok(BandRule::certified(problem, Form::Analytic(Analytic { c_um, sources, weights })))
}
