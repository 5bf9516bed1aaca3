//! Gauss–Legendre points over the domain D, a quarter more of them until `accuracy` is kept.
//!
//! F(a) ≈ Σ_j W(λ_j) w_j e^(−a k(λ_j));  fast for smooth weights, slow for tabulated curves with kinks: eq. (8) of
//! docs/method.md.

use super::midpoint::with_panels;
use super::{BandProblem, BandRule, RuleEntry};
use crate::error::Result;
use crate::quadrature::gauss_legendre;

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "gauss_legendre",
    summary: "Gauss-Legendre points over the domain; their number chosen by accuracy",
    nodes: true,
    many_bands: None,
    solve,
};

const MAX_NODES: usize = 128;

fn solve(problem: &BandProblem) -> Result<BandRule> {
    let attempt = |n: usize| with_panels(problem, 1, &gauss_legendre(n));
    if let Some(n) = problem.settings.count {
        return Ok(attempt(n));
    }
    let mut n = 2;
    let mut rule = attempt(n);
    while rule.worst() > problem.accuracy && n < MAX_NODES {
        n += (n / 4).max(1);
        rule = attempt(n);
    }
    Ok(rule)
}
