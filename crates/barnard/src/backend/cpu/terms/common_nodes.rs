//! Nodes that all bands share: each light is summed at each node, and the sums become bands at the end of a ray.

use spectra::rule::Form;
use spectra::simd;

use super::{Bases, DepthSpan, NodeTerms};
use crate::packet::{LANES, Lane, fma};
use crate::plan::{Plan, Weights};

/// The nodes of all bands, and what each band takes of them.
#[derive(Debug)]
pub struct CommonTerms {
    /// The nodes.
    pub nodes: NodeTerms,
    /// Offsets of the sums of each light; unused for lights that are not marched.
    starts: Vec<usize>,
    /// The lights that are marched: those that stars send, then those of gas.
    lights: usize,
    /// The extinction of each node in double precision.
    k: Vec<f64>,
    bands: Vec<BandWeights>,
}

/// Weights of the nodes in a band.
#[derive(Debug)]
struct BandWeights {
    /// The first node of which it takes something.
    first: usize,
    /// The weights from there on, marched light × node.
    weights: Vec<Vec<f32>>,
    /// Those of the background, whose light is one exponential and no sum: it keeps what double precision gives.
    background: Vec<f64>,
}

impl CommonTerms {
    pub(super) fn new(plan: &Plan, weights: &Weights) -> Self {
        let k: Vec<f64> = plan.spectral.common_nodes().unwrap_or_default().iter().map(|node| node.k).collect();
        let marched: Vec<usize> = weights.scattered.iter().map(|s| s.light).chain(weights.emitted.iter().map(|e| e.light)).collect();
        let mut starts = vec![0; plan.lights.len()];
        marched.iter().enumerate().for_each(|(i, light)| starts[*light] = i * k.len());
        let share = |form: &Form| {
            let Form::CommonNodes(nodes) = form else { return None };
            let of_light = |light: &usize| nodes.weights[*light].iter().map(|w| *w as f32).collect::<Vec<f32>>();
            let background = weights.background.map_or_else(Vec::new, |light| nodes.weights[light].clone());
            Some(BandWeights { first: nodes.first, weights: marched.iter().map(of_light).collect(), background })
        };
        let bands = plan.spectral.bands.iter().filter_map(|band| share(&band.rule.form)).collect();
        Self { nodes: NodeTerms::of(k.iter().map(|k| *k as f32).collect()), starts, lights: marched.len(), k, bands }
    }

    /// The number of sums that a ray carries.
    pub(super) fn sums(&self) -> usize {
        self.lights * self.nodes.k.len()
    }

    /// Offset of the sums of a light.
    #[inline(always)]
    pub(super) fn start(&self, light: usize) -> usize {
        self.starts[light]
    }

    #[inline(always)]
    pub(super) fn accumulate(&self, light: usize, span: &DepthSpan, bases: Bases, sum: &mut [Lane]) {
        self.nodes.accumulate(span, bases, &mut sum[self.start(light)..][..self.nodes.k.len()]);
    }

    /// Adds what the bands make of a ray's sums, and of a background behind the depth `tau`, to band × lane.
    pub fn resolve(&self, sum: &[Lane], tau: &Lane, radiance: &mut [f32]) {
        resolve(self, sum, radiance);
        if self.bands.iter().all(|share| share.background.is_empty()) {
            return;
        }
        for lane in 0..LANES {
            let left: Vec<f64> = self.k.iter().map(|k| (-k * f64::from(tau[lane])).exp()).collect();
            for (share, out) in self.bands.iter().zip(radiance.chunks_exact_mut(LANES)) {
                out[lane] += share.background.iter().zip(&left[share.first..]).map(|(w, left)| w * left).sum::<f64>() as f32;
            }
        }
    }

    /// Upper bound of a band's remaining light that falls as e^(−k τ) from a depth on and is at most `bounds` times
    /// `brightest` of each node, by marched lights, and what it has, on one lane.
    pub fn behind(&self, band: usize, left: &[f32], bounds: &[f32], brightest: &[&[f32]], sum: &[Lane], lane: usize) -> (f32, f32) {
        let BandWeights { first, weights, .. } = &self.bands[band];
        let count = self.nodes.k.len();
        let (mut behind, mut has) = (0.0, 0.0);
        for (light, weights) in weights.iter().enumerate() {
            for (j, weight) in (*first..).zip(weights) {
                behind += weight.abs() * brightest[light][j] * left[j] * bounds[light];
                has += weight * sum[light * count + j][lane];
            }
        }
        (behind, has)
    }
}

simd! {
    fn resolve(terms: &CommonTerms, sum: &[Lane], radiance: &mut [f32]) {
        let count = terms.nodes.k.len();
        for (share, out) in terms.bands.iter().zip(radiance.chunks_exact_mut(LANES)) {
            let mut band = [0.0; LANES];
            for (weights, node_sums) in share.weights.iter().zip(sum.chunks_exact(count)) {
                for (weight, node_sum) in weights.iter().zip(&node_sums[share.first..]) {
                    for lane in 0..LANES {
                        band[lane] = fma(*weight, node_sum[lane], band[lane]);
                    }
                }
            }
            for lane in 0..LANES {
                out[lane] += band[lane];
            }
        }
    }
}
