//! Spectral rules: ways to evaluate F(a) = ∫ W(λ) e^(−a k(λ)) dλ for many optical depths a, cheaply, with a
//! certificate.
//!
//! Equations are numbered as in docs/method.md: F is eq. (2), terms are eq. (3).
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | W = R·s·(k ω p …) | `Source` | of the owner |
//! | a | `depth` | 1 (optical depth at V) |
//! | k | `k` | 1 |
//! | w_sj, k_j | `weights`, `nodes` | of F, 1 |
//!
//! A rule serves one passband and all sources that shine through it. Rules of the nodes family share their nodes k_j
//! between the sources, so that a node is monochromatic transport: F_s(a) ≈ Σ_j w_sj e^(−a k_j). A rule is one file and
//! one row of [`RULES`].

mod analytic;
mod band_quadrature;
mod certificate;
mod common_nodes;
mod depths;
mod fixed_wavelength;
mod gauss_legendre;
mod lookup;
mod midpoint;
mod nodes;
mod preintegrated;
mod projection;
mod sampled;
mod source;
mod truth;

pub use analytic::{Analytic, PolynomialSource};
pub use band_quadrature::PREVIEW;
pub use certificate::{Certificate, Rounding, Truth};
pub use common_nodes::CommonNodes;
pub use depths::DepthSpan;
pub use lookup::{DepthTable, Lookup};
pub use nodes::{Nodes, mean_transmittance};
pub use preintegrated::{Preintegrated, SegmentTable};
pub use projection::Projection;
pub use sampled::Sampled;
pub use source::{Measure, Source};
pub use truth::truth_points;

use crate::basis::Criterion;
use crate::error::{Result, SpectraError};
use crate::polynomial::Fit;

/// The problem that a rule solves: one passband, its sources, the reach and the accuracy.
pub struct BandProblem<'a> {
    /// The sources that shine through the passband.
    pub sources: &'a [Source],
    /// The domain D of rules that work in λ: what the settings say, or the passband's support \[µm\].
    pub domain_um: (f64, f64),
    /// The domain of rules that serve all passbands at once: what the settings say, or the support of all passbands
    /// \[µm\].
    pub common_um: (f64, f64),
    /// The wavelength and the extinction at the band's pivot.
    pub pivot: Node,
    /// The extinction law over λ \[µm\], for rules that place their own wavelengths.
    pub k: &'a (dyn Fn(f64) -> f64 + Sync),
    /// The largest optical depth the scene can reach \[1\].
    pub depth: f64,
    /// The allowed error of F relative to F(0) \[1\].
    pub accuracy: f64,
    /// Rule parameters fixed by the user.
    pub settings: &'a Settings,
    /// True if nobody waits for the rule any more: what is worked out from then on may be anything.
    pub interrupted: &'a (dyn Fn() -> bool + Sync),
}

/// Rule parameters that a user may fix, for comparisons.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Number of nodes, intervals, elements or samples; chosen by accuracy otherwise.
    pub count: Option<usize>,
    /// The domain D of a basis, (lowest, highest) \[µm\].
    pub domain_um: Option<(f64, f64)>,
    /// Degree of polynomials that stand for spectra.
    pub degree: usize,
    /// The largest argument a basis is made for; what the scene reaches otherwise \[1\].
    pub range: Option<f64>,
    /// The error that the exponents of a basis minimise.
    pub criterion: Criterion,
    /// Factors of all extinctions from the least to the largest, as of dust that may become less or more, for which nodes that passbands
    /// share are made.
    pub amounts: (f64, f64),
}

impl Default for Settings {
    /// Everything by accuracy; degree and criterion are Barrès & Neyret's.
    fn default() -> Self {
        Self { count: None, domain_um: None, degree: 5, range: None, criterion: Criterion::Mean, amounts: (1.0, 1.0) }
    }
}

/// A wavelength with its extinction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// The wavelength \[µm\].
    pub lambda_um: f64,
    /// The extinction k(λ) relative to V \[1\].
    pub k: f64,
}

/// F̂_s(a) = Σ_t w_st D_st(a): weights w are constant over a picture, decays D depend on the optical depth alone.
pub trait Decay {
    /// Number of terms of one source.
    fn terms(&self) -> usize;

    /// The weights w_st of source `s`, in the unit of F \[term\].
    fn weights(&self, s: usize) -> &[f64];

    /// The weights of source `s` when its W carries one more factor f(λ), such as a phase function at one angle
    /// \[term\].
    ///
    /// A form that does not know where its terms lie in λ knows the factor by its mean.
    fn weights_with(&self, _s: usize, source: &Source, factor: &dyn Fn(f64) -> f64) -> Vec<f64> {
        vec![source.measure.reweighted(factor).total() / self.terms() as f64; self.terms()]
    }

    /// Σ_t w_t ⟨D_st⟩ over a span of depths, in the unit of w.
    fn mean(&self, s: usize, weights: &[f64], depths: DepthSpan) -> f64;

    /// Σ_t |w_t D_st(a)| at one depth, in the unit of w: what rounding is a part of, where terms cancel.
    fn size(&self, s: usize, weights: &[f64], depth: f64) -> f64 {
        self.mean(s, weights, DepthSpan::at(depth)).abs()
    }

    /// The polynomial that stands for source `s`, where one does.
    fn fit(&self, _s: usize) -> Option<&Fit> {
        None
    }

    /// The largest error of Σ_t w_t D_st(a) against what `measure` says, over depths up to `depth`.
    fn certificate(&self, s: usize, weights: &[f64], measure: &Measure, depth: f64) -> Certificate {
        Certificate::measured(measure, |a| self.mean(s, weights, DepthSpan::at(a)), depth)
    }
}

/// The evaluated form of a rule.
#[derive(Debug, Clone)]
pub enum Form {
    /// Exponentials at nodes that all sources share.
    Nodes(Nodes),
    /// Exponentials at nodes that all passbands share.
    CommonNodes(CommonNodes),
    /// F itself as a table for each source.
    Lookup(Lookup),
    /// Polynomial spectra against the exponential in closed form.
    Analytic(Analytic),
    /// Coordinates in a basis of exponentials.
    Projection(Projection),
    /// Intervals of wavelength with tables over a segment's own depth.
    Preintegrated(Preintegrated),
    /// A few random wavelengths for each ray.
    Sampled(Sampled),
}

impl Form {
    /// The form as what all forms can do.
    pub fn decay(&self) -> &dyn Decay {
        match self {
            Form::Nodes(nodes) => nodes,
            Form::CommonNodes(nodes) => nodes,
            Form::Lookup(lookup) => lookup,
            Form::Analytic(analytic) => analytic,
            Form::Projection(projection) => projection,
            Form::Preintegrated(preintegrated) => preintegrated,
            Form::Sampled(sampled) => sampled,
        }
    }
}

/// A solved rule for one passband.
#[derive(Debug, Clone)]
pub struct BandRule {
    /// The form in which F is evaluated.
    pub form: Form,
    /// The error bound of each source over the reachable depths.
    pub certificates: Vec<Certificate>,
}

impl BandRule {
    /// A form with its certificates.
    fn certified(problem: &BandProblem, form: Form) -> Self {
        let mut rule = Self { form, certificates: Vec::new() };
        let awaited = problem.sources.iter().take_while(|_| !(problem.interrupted)());
        rule.certificates = awaited.enumerate().map(|(s, source)| rule.certify_source(s, source, problem.depth)).collect();
        rule
    }

    /// The rule's F(a) of source `s`.
    pub fn evaluate(&self, s: usize, depth: f64) -> f64 {
        self.mean(s, DepthSpan::at(depth))
    }

    /// The rule's ⟨F⟩ of source `s` over a span of depths.
    pub fn mean(&self, s: usize, depths: DepthSpan) -> f64 {
        let decay = self.form.decay();
        decay.mean(s, decay.weights(s), depths)
    }

    /// Certificates over the depths up to `depth`, for the sources the rule was solved for.
    pub fn certify(&self, sources: &[Source], depth: f64) -> Vec<Certificate> {
        sources.iter().enumerate().map(|(s, source)| self.certify_source(s, source, depth)).collect()
    }

    fn certify_source(&self, s: usize, source: &Source, depth: f64) -> Certificate {
        let decay = self.form.decay();
        let plain = decay.certificate(s, decay.weights(s), &source.measure, depth);
        source.variants.iter().fold(plain, |worst, factor| {
            let weights = decay.weights_with(s, source, factor);
            worst.or_worse(decay.certificate(s, &weights, &source.measure.reweighted(factor), depth))
        })
    }

    /// The largest absolute error over the sources, relative to F(0) \[1\].
    pub fn worst(&self) -> f64 {
        self.certificates.iter().map(|c| c.absolute).fold(0.0, f64::max)
    }
}

/// One row of the catalogue of rules.
#[derive(Clone, Copy)]
pub struct RuleEntry {
    /// The name in scenes and on the command line.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// True if its terms are nodes, each of which is monochromatic transport.
    pub nodes: bool,
    /// The rule that may stand in for it where passbands are many and share their nodes.
    pub many_bands: Option<&'static RuleEntry>,
    /// Makes the rule for one band.
    pub solve: fn(&BandProblem) -> Result<BandRule>,
}

impl RuleEntry {
    /// The rule that serves a number of passbands at the least cost, of which `problem` is one: this one, or that whose
    /// nodes they share where these are less than half as many.
    pub fn serving(&'static self, bands: usize, problem: &BandProblem) -> &'static RuleEntry {
        let is_free = problem.settings.count.is_none() && problem.settings.domain_um.is_none();
        let shares = || is_free && 2 * common_nodes::count(problem) < bands;
        self.many_bands.filter(|_| shares()).unwrap_or(self)
    }
}

/// All rules; the first is the default.
pub const RULES: &[RuleEntry] = &[
    band_quadrature::ENTRY,
    common_nodes::ENTRY,
    lookup::ENTRY,
    projection::ENTRY,
    analytic::ENTRY,
    preintegrated::ENTRY,
    sampled::ENTRY,
    gauss_legendre::ENTRY,
    midpoint::ENTRY,
    fixed_wavelength::ENTRY,
];

/// The rule called `name`.
///
/// # Errors
/// If there is none.
pub fn rule(name: &str) -> Result<&'static RuleEntry> {
    let known: Vec<&str> = RULES.iter().map(|r| r.name).collect();
    RULES.iter().find(|r| r.name == name).ok_or_else(|| SpectraError::unknown("spectral method", name, &known))
}

#[cfg(test)]
mod tests;
