//! The default: for each passband, the Gauss rule of the weight itself, in the variable k, eq. (9) of docs/method.md.
//!
//! Nodes k_j: the n-point Gauss rule of the measure Σ_s W_s dλ / F_s(0) · e^(−t k) (Stieltjes, Golub & Welsch 1969).
//! Weights of each source: w_sj = ∫ W_s ℓ_j(k) dλ, ℓ_j the Lagrange polynomials of the nodes; where one comes out
//! negative, as a red leak can make it, non-negative least squares on samples of F_s. Tilt t moves accuracy into the
//! dark.
//!
//! e^(−a k) is entire in k, so the error falls faster than any power of n: F is exact for polynomials in k of degree 2n
//! − 1 (one source), n − 1 (each of several).

use nalgebra::{DMatrix, DVector};

use super::nodes::{Weighting, interpolatory_weights};
use super::{BandProblem, BandRule, Certificate, Decay, DepthSpan, Measure, Node, Nodes, RuleEntry, Source, Truth};
use crate::error::Result;
use crate::quadrature::{gauss_of_measure, non_negative_least_squares};

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "band_quadrature",
    summary: "Gauss rule of each passband's own weight in k; nodes chosen by accuracy (default)",
    nodes: true,
    many_bands: Some(&super::common_nodes::ENTRY),
    solve,
};

/// The rule of previews: a fixed number of nodes without a certificate.
pub const PREVIEW: RuleEntry = RuleEntry {
    name: "preview",
    summary: "three Gauss nodes per band, without a certificate, for previews",
    nodes: true,
    many_bands: Some(&super::common_nodes::ENTRY),
    solve: preview,
};

/// Nodes of a preview, and their tilt: about 1e-3 in broad filters.
const PREVIEW_NODES: usize = 3;
const PREVIEW_TILT: f64 = 0.5;

fn preview(problem: &BandProblem) -> Result<BandRule> {
    let (nodes, weights, _) = with_weights(problem, PREVIEW_NODES, PREVIEW_TILT, &choosing(problem));
    // A phase function is asked at the nodes alone.
    let weighting = vec![Weighting::AtNodes; problem.sources.len()];
    let form = super::Form::Nodes(Nodes::of(nodes, weights, weighting));
    let unknown = Certificate { absolute: f64::INFINITY, relative: f64::INFINITY, depth: f64::INFINITY };
    Ok(BandRule { form, certificates: vec![unknown; problem.sources.len()] })
}

const MAX_NODES: usize = 16;
/// The part of the accuracy that a rule may use up: errors are parts of F(0), pixels hold the light that dust has left.
const SHARE: f64 = 0.3;
const TILTS: [f64; 4] = [0.0, 0.5, 1.5, 4.0];

/// The number of sources that choose the nodes where there are more; the certificate is asked for all.
const CHOOSING: usize = 16;

fn solve(problem: &BandProblem) -> Result<BandRule> {
    let counts = match problem.settings.count {
        Some(n) => n..=n,
        None => 1..=MAX_NODES,
    };
    let choosing = choosing(problem);
    let choosers: Vec<Chooser> = choosing.iter().map(|source| Chooser::new(&problem.sources[*source], problem.depth)).collect();
    let allowed = SHARE * problem.accuracy;
    // All sources are certified only where those that choose allow it, and of all candidates where none is within the accuracy.
    let mut candidates = Vec::new();
    for n in counts {
        let tilts = TILTS.iter().map(|t| (*t, worst(problem, n, *t, &choosing, &choosers)));
        let Some((tilt, found)) = tilts.min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let rule = (found <= allowed).then(|| with_nodes(problem, n, tilt, &choosing));
        match rule {
            Some(rule) if rule.worst() <= allowed => return Ok(rule),
            rule => candidates.push((n, tilt, found, rule)),
        }
    }
    let best = candidates.into_iter().fold(None, |best: Option<BandRule>, (n, tilt, found, rule)| match best {
        Some(best) if best.worst() <= found => Some(best),
        best => {
            let rule = rule.unwrap_or_else(|| with_nodes(problem, n, tilt, &choosing));
            best.filter(|best| best.worst() <= rule.worst()).or(Some(rule))
        }
    });
    Ok(best.unwrap_or_else(|| with_nodes(problem, 1, 0.0, &choosing)))
}

/// The sources by which nodes are chosen: all, or from the lowest mean k to the highest.
fn choosing(problem: &BandProblem) -> Vec<usize> {
    let mut sources: Vec<(usize, f64)> = problem.sources.iter().map(|s| s.measure.mean_k()).enumerate().collect();
    if sources.len() > CHOOSING {
        sources.retain(|(_, mean)| mean.is_finite());
        sources.sort_by(|a, b| a.1.total_cmp(&b.1));
        let last = sources.len().saturating_sub(1);
        let mut places: Vec<usize> = (0..CHOOSING).map(|i| i * last / (CHOOSING - 1)).collect();
        places.dedup();
        sources = places.into_iter().filter_map(|i| sources.get(i).copied()).collect();
    }
    sources.into_iter().map(|(source, _)| source).collect()
}

/// A source that chooses the nodes, with F for each of its spectral factors, the first of which is one.
struct Chooser<'a> {
    source: &'a Source,
    truths: Vec<Truth>,
}

impl<'a> Chooser<'a> {
    fn new(source: &'a Source, depth: f64) -> Self {
        let plain = std::iter::once(Truth::new(&source.measure, depth));
        let variants = source.variants.iter().map(|factor| Truth::new(&source.measure.reweighted(factor), depth));
        Self { source, truths: plain.chain(variants).collect() }
    }

    /// The largest error of a rule with these nodes.
    fn error(&self, nodes: &[Node], depth: f64) -> f64 {
        let (weights, weighting) = weights_of(nodes, self.source, depth);
        let rule = Nodes::of(nodes.to_vec(), vec![weights.clone()], vec![weighting]);
        let variants = self.source.variants.iter().map(|factor| rule.weights_with(0, self.source, factor));
        let weights = std::iter::once(weights).chain(variants);
        let error = |(truth, weights): (&Truth, Vec<f64>)| truth.certificate(|a| rule.mean(0, &weights, DepthSpan::at(a))).absolute;
        self.truths.iter().zip(weights).map(error).fold(0.0, f64::max)
    }
}

/// The largest error of the rule of `n` nodes and tilt `t` for some sources.
fn worst(problem: &BandProblem, n: usize, t: f64, sources: &[usize], choosers: &[Chooser]) -> f64 {
    let nodes = nodes(problem, n, t, sources);
    choosers.iter().map(|chooser| chooser.error(&nodes, problem.depth)).fold(0.0, f64::max)
}

/// The rule of `n` nodes and tilt `t`.
fn with_nodes(problem: &BandProblem, n: usize, t: f64, choosing: &[usize]) -> BandRule {
    let (nodes, weights, weighting) = with_weights(problem, n, t, choosing);
    Nodes::rule(problem, nodes, weights, weighting)
}

/// Nodes, and each source's weights and how they were found.
fn with_weights(problem: &BandProblem, n: usize, t: f64, choosing: &[usize]) -> (Vec<Node>, Vec<Vec<f64>>, Vec<Weighting>) {
    let nodes = nodes(problem, n, t, choosing);
    let (weights, weighting) =
        problem.sources.iter().map_while(|source| (!(problem.interrupted)()).then(|| weights_of(&nodes, source, problem.depth))).unzip();
    (nodes, weights, weighting)
}

/// The weights of one source, and how they were found.
fn weights_of(nodes: &[Node], source: &Source, depth: f64) -> (Vec<f64>, Weighting) {
    let integrated = interpolatory_weights(nodes, &source.measure);
    match integrated.iter().all(|w| *w >= 0.0) {
        true => (integrated, Weighting::Interpolatory),
        false => (fitted_weights(nodes, &source.measure, depth), Weighting::AtNodes),
    }
}

/// Gauss nodes of the sum of the sources that choose, each normalised.
fn nodes(problem: &BandProblem, n: usize, t: f64, choosing: &[usize]) -> Vec<Node> {
    let (mut k, mut mass, mut lambda) = (Vec::new(), Vec::new(), Vec::new());
    for source in choosing.iter().map(|s| &problem.sources[*s]) {
        let tilted: Vec<f64> = source.measure.mass.iter().zip(&source.measure.k).map(|(m, k)| m * (-t * k).exp()).collect();
        let total: f64 = tilted.iter().sum();
        if total > 0.0 {
            k.extend_from_slice(&source.measure.k);
            lambda.extend_from_slice(&source.measure.lambda_um);
            mass.extend(tilted.iter().map(|m| m / total));
        }
    }
    let nearest = |at: f64| {
        let i = (0..k.len()).min_by(|&i, &j| (k[i] - at).abs().total_cmp(&(k[j] - at).abs()));
        i.map_or(problem.pivot.lambda_um, |i| lambda[i])
    };
    let rule = gauss_of_measure(&k, &mass, n);
    if rule.is_empty() {
        return vec![problem.pivot];
    }
    rule.iter().map(|(k, _)| Node { k: *k, lambda_um: nearest(*k) }).collect()
}

/// The weights w ≥ 0 that fit F(a) best on samples of a.
fn fitted_weights(nodes: &[Node], measure: &Measure, depth: f64) -> Vec<f64> {
    let samples: Vec<f64> = (0..40).map(|i| depth.min(40.0) * (i as f64 / 39.0).powi(2)).collect();
    let a = DMatrix::from_fn(samples.len(), nodes.len(), |i, j| (-samples[i] * nodes[j].k).exp());
    let total = measure.total().max(f64::MIN_POSITIVE);
    let b = DVector::from_iterator(samples.len(), samples.iter().map(|s| measure.at(*s) / total));
    non_negative_least_squares(&a, &b).iter().map(|w| w * total).collect()
}
