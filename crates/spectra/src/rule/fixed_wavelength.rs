//! One fixed wavelength a band: the plain RGB march, for comparisons.
//!
//! F(a) ≈ F(0) e^(−a k(λ_p)),  λ_p the pivot of the passband. What a renderer without spectra does; its certificate
//! shows the price.

use super::nodes::Weighting;
use super::{BandProblem, Nodes, RuleEntry};

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "fixed_wavelength",
    summary: "one wavelength per band, its pivot: the plain RGB march, for comparisons",
    nodes: true,
    many_bands: None,
    solve: |problem: &BandProblem| {
        let weights = problem.sources.iter().map(|s| vec![s.measure.total()]).collect();
        let weighting = vec![Weighting::AtNodes; problem.sources.len()];
        Ok(Nodes::rule(problem, vec![problem.pivot], weights, weighting))
    },
};
