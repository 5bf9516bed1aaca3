//! The phase function over angle, as back ends read it: tables of the weights of scattered light, and how finely it
//! must be asked.

use std::sync::Arc;

use spectra::rule::Node;

use super::BandPlan;
use crate::packet::{RowPlace, place};
use crate::phase::Phase;

/// The largest abscissa of a phase table, backwards.
pub const PHASE_RANGE: f64 = std::f64::consts::SQRT_2;
/// Most entries of a table.
const MAX_ENTRIES: usize = 4096;
/// Samples of an angle from 0 to π.
const SAMPLES: usize = 4096;

/// Weights of scattered light over angle, linear in u: see [`PHASE_RANGE`].
#[derive(Debug, Clone)]
pub struct PhaseTable {
    /// Number of entries from u = 0, forwards, to u = √2, backwards.
    pub entries: usize,
    /// True if one p(θ) serves all wavelengths: each light then has one number an entry, which multiplies its weights.
    pub separable: bool,
    /// The weights of each light that is scattered, entry × term, a term being a node of the rule or a band of a
    /// lookup; empty for other lights and those of the gathered stars.
    pub weights: Vec<Vec<f32>>,
    /// The phase function at the nodes themselves, for many lights: entry × term, one number an entry where it is
    /// separable; empty where there are no many lights.
    pub at_nodes: Vec<f32>,
}

/// A place in a phase table.
#[derive(Debug, Clone, Copy, Default)]
pub struct PhaseEntry {
    /// The entry before the place.
    pub entry: u32,
    /// The fraction of the way from that to the next \[1\].
    pub fraction: f32,
}

impl PhaseTable {
    /// The place of cos θ and sin² θ in a table of a given number of entries.
    #[inline(always)]
    pub fn entry(entries: usize, cosine: f32, sine2: f32) -> PhaseEntry {
        // sin or cos of θ/2, whichever is small, without cancellation.
        let small = (sine2 / (2.0 * (1.0 + cosine.abs()))).sqrt();
        let at = if cosine >= 0.0 { small } else { PHASE_RANGE as f32 - small };
        let cells = entries.max(2) - 1;
        let RowPlace { cell, fraction } = place(at * cells as f32 * (1.0 / PHASE_RANGE as f32), cells);
        PhaseEntry { entry: cell, fraction }
    }
}

/// A phase function at the middle wavelength of the first band.
#[derive(Debug)]
pub struct PhaseAtPivot {
    pub phase: Arc<dyn Phase>,
    pub lambda_um: f64,
}

impl PhaseAtPivot {
    /// The phase function p(cos θ) at that wavelength [sr⁻¹].
    pub fn at(&self, cosine: f64) -> f64 {
        self.phase.at(cosine, self.lambda_um)
    }

    /// The angle at which it has half of what it has forwards \[rad\]; π where it has no less.
    pub fn forward_peak(&self) -> f64 {
        let half = 0.5 * self.at(1.0);
        let angle = |i: usize| i as f64 * std::f64::consts::PI / SAMPLES as f64;
        (1..=SAMPLES).map(angle).find(|angle| self.at(angle.cos()) < half).unwrap_or(std::f64::consts::PI)
    }

    /// The angle at whose middle it is evaluated \[rad\]: over it ln p changes so that the error of the midpoint,
    /// Δ²/24, is `accuracy` where it is steepest.
    pub fn midpoint_angle(&self, accuracy: f64) -> f64 {
        let step = std::f64::consts::PI / SAMPLES as f64;
        let log = |i: usize| self.at((i as f64 * step).cos()).max(f64::MIN_POSITIVE).ln();
        let steepest = (0..SAMPLES).map(|i| (log(i + 1) - log(i)).abs() / step).fold(f64::MIN_POSITIVE, f64::max);
        (24.0 * accuracy).sqrt() / steepest
    }

    /// The number of entries that a table needs for a tenth of `accuracy`.
    pub fn entries(&self, accuracy: f64) -> usize {
        let at = |u: f64| self.at(cosine(u));
        let error = |entries: usize| {
            let u = |i: f64| PHASE_RANGE * i / (entries - 1) as f64;
            (0..entries - 1)
                .map(|i| (i as f64, i as f64 + 0.5, i as f64 + 1.0))
                .map(|(a, m, b)| (0.5 * (at(u(a)) + at(u(b))) / at(u(m)).max(f64::MIN_POSITIVE) - 1.0).abs())
                .fold(0.0, f64::max)
        };
        let mut entries = 65;
        while error(entries) > 0.1 * accuracy && entries < MAX_ENTRIES {
            entries = 2 * entries - 1;
        }
        entries
    }

    /// The weights of a light: entry × term, or one number an entry where it is separable.
    pub fn weights(&self, entries: usize, bands: &[BandPlan], light: usize) -> Vec<f32> {
        if !self.phase.is_spectral() {
            return (0..entries).map(|i| self.at(cosine_of(i, entries)) as f32).collect();
        }
        if bands.iter().any(|band| band.common_nodes().is_some()) {
            return self.at_nodes(entries, bands);
        }
        let entry = |i: usize| {
            let cosine = cosine_of(i, entries);
            bands.iter().flat_map(move |b| b.weights_with(light, |lambda| self.phase.at(cosine, lambda))).map(|w| w as f32)
        };
        (0..entries).flat_map(entry).collect()
    }

    /// The phase function at the nodes of all bands, once where they share them: entry × term, or one number an entry where it is separable.
    pub fn at_nodes(&self, entries: usize, bands: &[BandPlan]) -> Vec<f32> {
        let mut nodes: Vec<Node> = match bands.first().and_then(BandPlan::common_nodes) {
            Some(common) => common.to_vec(),
            None => bands.iter().filter_map(BandPlan::nodes).flatten().copied().collect(),
        };
        let separable = !self.phase.is_spectral();
        if separable {
            nodes.truncate(1);
        }
        let lambda_um = |node: &Node| if separable { self.lambda_um } else { node.lambda_um };
        let entry = |i: usize| nodes.iter().map(move |node| self.phase.at(cosine_of(i, entries), lambda_um(node)) as f32);
        (0..entries).flat_map(entry).collect()
    }
}

/// The cos θ of an entry in a table of a given length.
fn cosine_of(entry: usize, entries: usize) -> f64 {
    cosine(PHASE_RANGE * entry as f64 / (entries - 1) as f64)
}

/// The cos θ at the table's abscissa u, which is sin(θ/2) up to 90 degrees and √2 − cos(θ/2) behind, so that both poles
/// are seen as finely.
fn cosine(u: f64) -> f64 {
    if u < 0.5 * PHASE_RANGE { 1.0 - 2.0 * u * u } else { 2.0 * (PHASE_RANGE - u).powi(2) - 1.0 }
}
