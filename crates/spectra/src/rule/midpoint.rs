//! Barrès & Neyret's slow truth: M equal midpoints over a domain D.
//!
//! F(a) ≈ Σ_j W(λ_j) Δλ e^(−a k(λ_j)),  λ_j the midpoints of M equal intervals of D; a line counts at the midpoint of
//! its interval: eq. (8) of docs/method.md.
//!
//! Source: Barrès & Neyret 2023, "double integration". M = 30 there, and by default here.

use super::nodes::Weighting;
use super::{BandProblem, BandRule, Node, Nodes, RuleEntry};

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "midpoint",
    summary: "equal midpoints over the domain, 30 by default: Barrès & Neyret's double integration",
    nodes: true,
    many_bands: None,
    solve: |problem| Ok(with_panels(problem, problem.settings.count.unwrap_or(TALK_COUNT), &[(0.0, 2.0)])),
};

/// M of Barrès & Neyret.
const TALK_COUNT: usize = 30;

/// A composite rule: `rule` on [−1, 1] in each of `panels` equal intervals of the domain.
pub(super) fn with_panels(problem: &BandProblem, panels: usize, rule: &[(f64, f64)]) -> BandRule {
    let (low, high) = problem.domain_um;
    let width = (high - low) / panels as f64;
    let points: Vec<(f64, f64)> =
        (0..panels).flat_map(|p| rule.iter().map(move |(x, w)| (low + width * (p as f64 + 0.5 * (1.0 + x)), 0.5 * width * w))).collect();
    let nodes: Vec<Node> = points.iter().map(|(l, _)| Node { lambda_um: *l, k: (problem.k)(*l) }).collect();
    let nearest = |lambda: f64| {
        let distance = |j: &usize| (points[*j].0 - lambda).abs();
        (0..points.len()).min_by(|i, j| distance(i).total_cmp(&distance(j))).unwrap_or(0)
    };
    let weights = problem
        .sources
        .iter()
        .map(|source| {
            let mut weights: Vec<f64> = points.iter().map(|(l, w)| w * (source.density)(*l)).collect();
            for &(lambda, mass) in source.lines.iter().filter(|(l, _)| (low..=high).contains(l)) {
                weights[nearest(lambda)] += mass;
            }
            weights
        })
        .collect();
    Nodes::rule(problem, nodes, weights, vec![Weighting::AtNodes; problem.sources.len()])
}
