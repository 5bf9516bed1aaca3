//! The nodes family: F(a) ≈ Σ_j w_j e^(−a k_j), eq. (7) of docs/method.md. A node is monochromatic transport.
//!
//! Over depths that run linearly between a₀ and a₁, mean ā and half difference y = (a₁ − a₀)/2,
//!
//!   ⟨e^(−k a)⟩ = e^(−k ā) sinh(k y)/(k y)                                      eq. (5)

use super::{BandProblem, BandRule, Decay, DepthSpan, Form, Measure, Node, Source};

/// Exponentials at nodes that the sources share.
#[derive(Debug, Clone)]
pub struct Nodes {
    /// The nodes, ascending in k.
    pub nodes: Vec<Node>,
    /// The weights, source × node.
    pub weights: Vec<Vec<f64>>,
    /// The way in which each source's weights follow from its measure.
    pub(super) weighting: Vec<Weighting>,
}

/// The way in which a source's weights follow from its measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Weighting {
    /// The weights are w_j = ∫ W ℓ_j(k) dλ: any further spectral factor is integrated with them.
    Interpolatory,
    /// The weights are fixed; a further spectral factor is taken at the node's wavelength.
    AtNodes,
}

impl Nodes {
    /// A rule at fixed wavelengths, certified.
    pub(super) fn rule(problem: &BandProblem, nodes: Vec<Node>, weights: Vec<Vec<f64>>, weighting: Vec<Weighting>) -> BandRule {
        BandRule::certified(problem, Form::Nodes(Self::of(nodes, weights, weighting)))
    }

    /// Nodes, and each source's weights.
    pub(super) fn of(nodes: Vec<Node>, weights: Vec<Vec<f64>>, weighting: Vec<Weighting>) -> Self {
        Self { nodes, weights, weighting }
    }
}

impl Decay for Nodes {
    fn terms(&self) -> usize {
        self.nodes.len()
    }

    fn weights(&self, s: usize) -> &[f64] {
        &self.weights[s]
    }

    fn weights_with(&self, s: usize, source: &Source, factor: &dyn Fn(f64) -> f64) -> Vec<f64> {
        if self.weighting[s] == Weighting::Interpolatory {
            let measure = source.measure.reweighted(factor);
            let integrated = interpolatory_weights(&self.nodes, &measure);
            if integrated.iter().all(|w| *w >= 0.0) {
                return integrated;
            }
        }
        self.nodes.iter().zip(&self.weights[s]).map(|(n, w)| w * factor(n.lambda_um)).collect()
    }

    fn mean(&self, _: usize, weights: &[f64], depths: DepthSpan) -> f64 {
        self.nodes.iter().zip(weights).map(|(n, w)| w * mean_transmittance(n.k * depths.from, n.k * depths.to)).sum()
    }
}

/// The Lagrange polynomial ℓ_j(k) of some nodes: one at node j, zero at the others.
pub(super) fn lagrange(nodes: &[Node], j: usize, k: f64) -> f64 {
    nodes.iter().enumerate().filter(|(i, _)| *i != j).map(|(_, n)| (k - n.k) / (nodes[j].k - n.k)).product()
}

/// The weights w_j = ∫ W ℓ_j(k) dλ of nodes in k.
pub(super) fn interpolatory_weights(nodes: &[Node], measure: &Measure) -> Vec<f64> {
    let mut weights = vec![0.0; nodes.len()];
    for (k, mass) in measure.k.iter().zip(&measure.mass) {
        for (j, weight) in weights.iter_mut().enumerate() {
            *weight += mass * lagrange(nodes, j, *k);
        }
    }
    weights
}

/// Mean of e^(−a) over a linear a \[1\]; never larger than its larger end.
pub fn mean_transmittance(from: f64, to: f64) -> f64 {
    let y = 0.5 * (to - from);
    if y.abs() < 0.5 {
        let y2 = y * y;
        return (-0.5 * (from + to)).exp() * (1.0 + y2 / 6.0 * (1.0 + y2 / 20.0 * (1.0 + y2 / 42.0 * (1.0 + y2 / 72.0))));
    }
    ((-from).exp() - (-to).exp()) / (to - from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::integrate;

    #[test]
    fn transmittance_is_its_integral() {
        for (from, to) in [(0.0, 0.0), (0.1, 0.1 + 1e-9), (0.0, 0.9), (2.0, 1.3), (0.0, 40.0), (30.0, 0.0)] {
            let truth = integrate(|u| (-(from + u * (to - from))).exp(), 0.0, 1.0, 1e-13);
            assert!((mean_transmittance(from, to) / truth - 1.0).abs() < 1e-9, "{from} {to}");
        }
    }

    /// No step size makes light from nothing.
    #[test]
    fn never_more_than_the_brighter_end() {
        for i in 0..200 {
            for j in 0..200 {
                let (a, b) = (0.3 * i as f64, 0.37 * j as f64);
                assert!(mean_transmittance(a, b) <= (-a.min(b)).exp() * (1.0 + 1e-12));
            }
        }
    }
}
