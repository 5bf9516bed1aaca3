//! Spectral rules: ways to evaluate F(a) = ∫ W(λ) e^(−a k(λ)) dλ for many optical depths a, cheaply, with a certificate.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | W = R·s·(k ω p …) | `Source` | of the owner |
//! | a | `depth` | 1 (optical depth at V) |
//! | k | `k` | 1 |
//! | w_sj, k_j | `weights`, `nodes` | of F, 1 |
//!
//! A rule serves one passband and all sources that shine through it. Rules of the nodes family share their nodes k_j between the sources,
//! so that a node is monochromatic transport: F_s(a) ≈ Σ_j w_sj e^(−a k_j). A rule is one file and one row of [`RULES`].

mod band_quadrature;
mod certificate;
mod fixed_wavelength;
mod gauss_legendre;
mod lookup;
mod newton;
mod source;
mod truth;

pub use certificate::Certificate;
pub use lookup::DepthTable;
pub use source::{Measure, Source};
pub use truth::truth_points;

use crate::error::{Result, SpectraError};

/// What a rule is asked for: one passband, its sources, the reach and the accuracy.
pub struct BandProblem<'a> {
    /// What shines through it.
    pub sources: &'a [Source],
    /// The domain D of rules that work in λ [µm].
    pub domain_um: (f64, f64),
    /// λ and k at the band's pivot.
    pub pivot: Node,
    /// The extinction law over λ [µm], for rules that place their own wavelengths.
    pub k: &'a (dyn Fn(f64) -> f64 + Sync),
    /// The largest optical depth the scene can reach [1].
    pub depth: f64,
    /// Allowed error of F relative to F(0) [1].
    pub accuracy: f64,
    /// A fixed number of nodes, for comparisons.
    pub count: Option<usize>,
}

/// A wavelength with its extinction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// λ [µm].
    pub lambda_um: f64,
    /// k(λ) [1].
    pub k: f64,
}

/// How a source's weights follow from its measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Weighting {
    /// w_j = ∫ W ℓ_j(k) dλ: any further spectral factor is integrated with them.
    Interpolatory,
    /// w_j fixed, a further spectral factor is taken at the node's wavelength.
    AtNodes,
}

/// The evaluated form of a rule.
#[derive(Debug, Clone)]
pub enum Form {
    /// Exponentials at shared nodes.
    Nodes {
        /// The nodes, ascending in k.
        nodes: Vec<Node>,
        /// Weights, source × node.
        weights: Vec<Vec<f64>>,
    },
    /// F itself as a table for each source.
    Lookup(Vec<DepthTable>),
}

/// A solved rule for one passband.
#[derive(Debug, Clone)]
pub struct BandRule {
    /// How F is evaluated.
    pub form: Form,
    weighting: Vec<Weighting>,
    /// The error bound of each source over the reachable depths.
    pub certificates: Vec<Certificate>,
}

impl BandRule {
    /// The rule's F(a) of source `s`.
    pub fn evaluate(&self, s: usize, depth: f64) -> f64 {
        match &self.form {
            Form::Nodes { nodes, weights } => nodes.iter().zip(&weights[s]).map(|(n, w)| w * (-depth * n.k).exp()).sum(),
            Form::Lookup(tables) => tables[s].at(depth),
        }
    }

    /// The weights of source `s` when its W carries one more factor f(λ), such as a phase function at one angle [node].
    pub fn weights_with(&self, s: usize, source: &Source, factor: impl Fn(f64) -> f64) -> Vec<f64> {
        let Form::Nodes { nodes, weights } = &self.form else { return Vec::new() };
        if self.weighting[s] == Weighting::Interpolatory {
            let measure = source.measure.reweighted(&factor);
            let integrated = band_quadrature::interpolatory_weights(nodes, &measure);
            if integrated.iter().all(|w| *w >= 0.0) {
                return integrated;
            }
        }
        nodes.iter().zip(&weights[s]).map(|(n, w)| w * factor(n.lambda_um)).collect()
    }

    /// Certificates over the depths up to `depth`, for the sources the rule was solved for.
    pub fn certify(&self, sources: &[Source], depth: f64) -> Vec<Certificate> {
        sources.iter().enumerate().map(|(s, source)| self.certify_source(s, source, depth)).collect()
    }

    fn certify_source(&self, s: usize, source: &Source, depth: f64) -> Certificate {
        let plain = Certificate::measured(&source.measure, |a| self.evaluate(s, a), depth);
        source.variants.iter().fold(plain, |worst, factor| {
            let measure = source.measure.reweighted(factor);
            let certificate = match &self.form {
                Form::Nodes { nodes, .. } => {
                    let weights = self.weights_with(s, source, factor);
                    let value = |a: f64| nodes.iter().zip(&weights).map(|(n, w)| w * (-a * n.k).exp()).sum();
                    Certificate::measured(&measure, value, depth)
                }
                // A table knows a further factor only by its mean.
                Form::Lookup(tables) => {
                    let mean = measure.total() / source.measure.total();
                    Certificate::measured(&measure, |a| mean * tables[s].at(a), depth)
                }
            };
            worst.or_worse(certificate)
        })
    }

    /// A rule at fixed wavelengths, certified.
    fn at_nodes(problem: &BandProblem, nodes: Vec<Node>, weights: Vec<Vec<f64>>, weighting: Vec<Weighting>) -> Self {
        let mut rule = Self { form: Form::Nodes { nodes, weights }, weighting, certificates: Vec::new() };
        rule.certificates = rule.certify(problem.sources, problem.depth);
        rule
    }

    /// The largest absolute error over the sources, relative to F(0) [1].
    pub fn worst(&self) -> f64 {
        self.certificates.iter().map(|c| c.absolute).fold(0.0, f64::max)
    }
}

/// One row of the catalogue.
#[derive(Clone, Copy)]
pub struct RuleEntry {
    /// Its name in scenes and on the command line.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Makes the rule for one band.
    pub solve: fn(&BandProblem) -> Result<BandRule>,
}

/// All rules; the first is the default.
pub const RULES: &[RuleEntry] = &[band_quadrature::ENTRY, lookup::ENTRY, gauss_legendre::ENTRY, newton::ENTRY, fixed_wavelength::ENTRY];

/// The rule called `name`.
pub fn rule(name: &str) -> Result<&'static RuleEntry> {
    let known: Vec<&str> = RULES.iter().map(|r| r.name).collect();
    RULES.iter().find(|r| r.name == name).ok_or_else(|| SpectraError::unknown("spectral method", name, &known))
}

#[cfg(test)]
mod tests;
