//! Nodes that all passbands share, for spectra by the hundred: e^(−a k) interpolated between equal steps of k, eq. (25) of
//! docs/method.md.
//!
//!   e^(−a k) ≈ Σ_j L_j(k) e^(−a k_j),    w_sj = ∫ W_s L_j(k(λ)) dλ
//!
//! L_j is the Lagrange polynomial of the [`STENCIL`] nodes next to k. A march sums each light at each node; the sums become
//! bands at the end, by the few weights that a narrow band has. With steps Δ of k the error of F(a) is at most about
//! (a Δ)^6 e^(2 a Δ)/43 of F(a) at the ends of the range and a fifth of that between, whatever the band: the dark is as
//! exact as the light.
//!
//! Common abscissae for several weights: Borges 1994, Numer. Math. 67, 271. They are the points of a Gauss-like rule there,
//! which is exact for the highest degree; equal steps need a few more, and keep the relative error.

use super::nodes::lagrange;
use super::{BandProblem, BandRule, Decay, DepthSpan, Form, Measure, Node, RuleEntry, Source, mean_transmittance};
use crate::error::{Result, SpectraError};

pub(super) const ENTRY: RuleEntry = RuleEntry {
    name: "common_nodes",
    summary: "one set of nodes for all passbands, the default for many passbands; single scattering",
    nodes: false,
    many_bands: None,
    solve,
};

/// Nodes that one depth is interpolated from.
const STENCIL: usize = 6;
/// The largest of |∏ (t − i)|/6! between the first two of six nodes: the error's factor.
const FACTOR: f64 = 0.0235;
/// The part of the accuracy that interpolation may cost.
const SHARE: f64 = 0.7;
/// Most nodes.
const MAX_NODES: usize = 4096;
/// The least part of an extinction that a range of nodes covers.
const NARROWEST: f64 = 1e-3;
/// Samples of the extinction law in which it is inverted.
const SAMPLES: usize = 1024;

/// Nodes in equal steps of k, and what a band takes of each.
#[derive(Debug, Clone)]
pub struct CommonNodes {
    /// The nodes of all passbands, ascending in k.
    pub nodes: Vec<Node>,
    /// The first node that the band takes something of.
    pub first: usize,
    /// The weights of each source from the first node on, source × node.
    pub weights: Vec<Vec<f64>>,
}

fn solve(problem: &BandProblem) -> Result<BandRule> {
    if problem.settings.domain_um.is_some() {
        let message = "method \"common_nodes\" does not support domain; remove it, or use another method";
        return Err(SpectraError::Rule(message.into()));
    }
    let nodes = nodes(problem);
    let weights: Vec<Vec<f64>> = problem.sources.iter().map(|source| interpolated(&nodes, &source.measure)).collect();
    let taken = |j: &usize| weights.iter().any(|row| row[*j] != 0.0);
    let (first, end) = ((0..nodes.len()).find(taken).unwrap_or(0), (0..nodes.len()).rfind(taken).map_or(1, |last| last + 1));
    let weights = weights.iter().map(|row| row[first..end].to_vec()).collect();
    Ok(BandRule::certified(problem, Form::CommonNodes(CommonNodes { nodes, first, weights })))
}

/// The number of nodes that all passbands need together, or that is asked for; never fewer than one value is interpolated
/// from.
pub(super) fn count(problem: &BandProblem) -> usize {
    let (low, high) = range(problem);
    // The largest a Δ = s with FACTOR s⁶ e^(2s) ≤ SHARE · accuracy: the derivative is that of the least k of six.
    let allowed = (SHARE * problem.accuracy.max(1e-12) / FACTOR).powf(1.0 / STENCIL as f64);
    let step = (0..32).fold(allowed, |s, _| allowed * (-2.0 * s / STENCIL as f64).exp());
    let wanted = (problem.depth * (high - low) / step).ceil() as usize + 1;
    problem.settings.count.unwrap_or(wanted).clamp(STENCIL, MAX_NODES)
}

/// The least extinction and the largest in the domain of all passbands, by all factors that they may have.
fn range(problem: &BandProblem) -> (f64, f64) {
    let (low, high) = law(problem).fold((f64::INFINITY, 0.0f64), |(low, high), node| (low.min(node.k), high.max(node.k)));
    let (low, high) = (low * problem.settings.amounts.0, high * problem.settings.amounts.1);
    (low, high.max(low + NARROWEST * low.max(NARROWEST)))
}

/// The extinction law at equal steps of the domain of all passbands.
fn law<'a>(problem: &'a BandProblem) -> impl Iterator<Item = Node> + 'a {
    let (low, high) = problem.common_um;
    let lambda = move |i: usize| low + (high - low) * i as f64 / SAMPLES as f64;
    (0..=SAMPLES).map(lambda).map(|lambda_um| Node { lambda_um, k: (problem.k)(lambda_um) })
}

/// The nodes, and the wavelength at which the law has the extinction of each: the longest, where it has it twice.
fn nodes(problem: &BandProblem) -> Vec<Node> {
    let ((low, high), count) = (range(problem), count(problem));
    let law: Vec<Node> = law(problem).collect();
    let lambda_um = |k: f64| {
        let crossing = law.windows(2).rev().find(|pair| (pair[0].k - k) * (pair[1].k - k) <= 0.0);
        let nearest = || law.iter().min_by(|a, b| (a.k - k).abs().total_cmp(&(b.k - k).abs()));
        match crossing {
            Some([a, b]) if a.k != b.k => a.lambda_um + (b.lambda_um - a.lambda_um) * (k - a.k) / (b.k - a.k),
            _ => nearest().map_or(problem.pivot.lambda_um, |node| node.lambda_um),
        }
    };
    let k = |j: usize| low + (high - low) * j as f64 / (count - 1) as f64;
    (0..count).map(k).map(|k| Node { lambda_um: lambda_um(k), k }).collect()
}

/// The weights ∫ W L_j(k) dλ of all nodes.
fn interpolated(nodes: &[Node], measure: &Measure) -> Vec<f64> {
    let mut weights = vec![0.0; nodes.len()];
    let (low, step) = (nodes[0].k, nodes[1].k - nodes[0].k);
    for (k, mass) in measure.k.iter().zip(&measure.mass) {
        let before = ((k - low) / step).floor().max(0.0) as usize;
        let first = before.saturating_sub(STENCIL / 2 - 1).min(nodes.len() - STENCIL);
        for (j, weight) in weights[first..first + STENCIL].iter_mut().enumerate() {
            *weight += mass * lagrange(&nodes[first..first + STENCIL], j, *k);
        }
    }
    weights
}

/// The part of a light that may lie outside of the nodes' range: it counts as if it were at the end.
const OUTSIDE: f64 = 1e-6;

impl CommonNodes {
    /// The weights ∫ W L_j(k) dλ that light has of `nodes` in equal steps of k, six of them or more, which were made for
    /// other light.
    ///
    /// # Errors
    /// If more than a millionth of it lies outside of the nodes; the error states its wavelengths.
    pub fn weights_of(nodes: &[Node], measure: &Measure) -> Result<Vec<f64>> {
        let (low, high) = (nodes[0].k, nodes[nodes.len() - 1].k);
        let rounding = 1e-9 * (high - low);
        let is_outside = |k: f64| k < low - rounding || k > high + rounding;
        let light = || measure.k.iter().zip(&measure.mass).zip(&measure.lambda_um);
        let outside: f64 = light().filter(|((k, _), _)| is_outside(**k)).map(|((_, mass), _)| mass.abs()).sum();
        if outside > OUTSIDE * measure.mass.iter().map(|mass| mass.abs()).sum::<f64>() {
            let wavelengths = light().filter(|((k, _), _)| is_outside(**k)).map(|(_, lambda)| *lambda * 1e3);
            let (from, to) = wavelengths.fold((f64::INFINITY, 0.0f64), |(low, high), nm| (low.min(nm), high.max(nm)));
            let ends = [nodes[nodes.len() - 1].lambda_um, nodes[0].lambda_um].map(|um| (um * 1e4).round() / 10.0);
            return Err(SpectraError::Reach(format!(
                "light from {from:.1} to {to:.1} nm has extinctions outside of the range of the nodes, {} to {} nm",
                ends[0].min(ends[1]),
                ends[0].max(ends[1])
            )));
        }
        let within = measure.k.iter().map(|k| k.clamp(low, high)).collect();
        Ok(interpolated(nodes, &Measure { k: within, ..measure.clone() }))
    }

    /// The nodes that the band takes something of.
    fn taken(&self) -> &[Node] {
        let count = self.weights.first().map_or(0, Vec::len);
        &self.nodes[self.first..self.first + count]
    }
}

impl Decay for CommonNodes {
    fn terms(&self) -> usize {
        self.taken().len()
    }

    fn weights(&self, s: usize) -> &[f64] {
        &self.weights[s]
    }

    /// What is interpolated is the factor times the exponential.
    fn weights_with(&self, s: usize, _: &Source, factor: &dyn Fn(f64) -> f64) -> Vec<f64> {
        self.taken().iter().zip(&self.weights[s]).map(|(n, w)| w * factor(n.lambda_um)).collect()
    }

    fn mean(&self, _: usize, weights: &[f64], depths: DepthSpan) -> f64 {
        self.taken().iter().zip(weights).map(|(n, w)| w * mean_transmittance(n.k * depths.from, n.k * depths.to)).sum()
    }

    fn size(&self, _: usize, weights: &[f64], depth: f64) -> f64 {
        self.taken().iter().zip(weights).map(|(n, w)| w.abs() * (-n.k * depth).exp()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extinction::Extinction;
    use crate::passband::{Counting, Window, window};
    use crate::rule::Settings;
    use crate::rule::source::Factor;
    use crate::sed::BlackBody;
    use crate::spectrum::Spectrum;
    use crate::units::{Temperature, Wavelength};

    /// The rule of a top hat of 10 nm around `centre_um`, among bands from 400 to 1000 nm, for a black body through
    /// depths up to 12; its certificate holds with each of `variants` as well.
    fn solved(centre_um: f64, k: &(dyn Fn(f64) -> f64 + Sync), variants: Vec<Factor>, count: Option<usize>) -> BandRule {
        let law = Extinction::by_name("ccm89").unwrap();
        let spectrum = Spectrum::continuous(1.0, std::sync::Arc::new(BlackBody(Temperature(9000.0))));
        let shape = Window::TopHat { centre: Wavelength(centre_um), width: Wavelength(0.01) };
        let band = window("narrow", Counting::Energy, shape).unwrap();
        let mut source = Source::new("star", &band, &spectrum, &*law, |_| 1.0);
        source.measure.k = source.measure.lambda_um.iter().map(|lambda| k(*lambda)).collect();
        source.variants = variants;
        let problem = BandProblem {
            sources: &[source],
            domain_um: band.support_um(),
            common_um: (0.4, 1.0),
            pivot: Node { lambda_um: centre_um, k: k(centre_um) },
            k,
            depth: 12.0,
            accuracy: 1e-3,
            settings: &Settings { count, ..Settings::default() },
            interrupted: &|| false,
        };
        solve(&problem).unwrap()
    }

    /// Sixty narrow bands over the visible need a tenth as many nodes, and keep the accuracy of F(a) itself: in the
    /// dark, at the ends, and where W has one more factor. With nodes twice as far apart they miss it.
    #[test]
    fn narrow_bands_share_their_nodes() {
        let law = Extinction::by_name("ccm89").unwrap();
        let worst = |count: Option<usize>| {
            let of_band = |i: usize| {
                let solved =
                    solved(0.405 + 0.01 * i as f64, &|lambda| law.k(lambda), vec![Box::new(|lambda| 1.0 / (1.0 + lambda * lambda))], count);
                let Form::CommonNodes(CommonNodes { nodes, .. }) = &solved.form else { panic!("another form") };
                assert!(solved.form.decay().terms() <= STENCIL + 2);
                (nodes.len(), solved.certificates[0].relative)
            };
            (0..60).map(of_band).fold((0, 0.0f64), |all, band_error| (band_error.0, all.1.max(band_error.1)))
        };
        let (count, error) = worst(None);
        assert!(count <= 30 && error < 1e-3, "{count} {error:e}");
        let (_, coarse) = worst(Some(count / 2));
        assert!(coarse > 1e-3, "{coarse:e}");
    }

    /// Dust that takes nothing, or the same of all light, leaves nodes that differ.
    #[test]
    fn a_grey_law_has_nodes() {
        for k in [0.0, 1.0] {
            let solved = solved(0.55, &|_| k, Vec::new(), None);
            assert!(solved.certificates[0].relative < 1e-9, "{k}: {:?}", solved.certificates);
        }
    }
}
