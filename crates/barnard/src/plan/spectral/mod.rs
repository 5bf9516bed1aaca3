//! What spectra decide: a solved rule for each passband, phase tables, and the certificate.

pub mod closed_form;
pub mod weights;

use std::sync::Arc;

use rayon::prelude::*;
use spectra::passband::Passband;
use spectra::rule::{BandProblem, BandRule, Form, Node, Source};

use crate::control::Control;
use crate::error::{Error, Result};
use crate::light::{Light, Route, factor, law};
use crate::phase::Phase;
use crate::plan::{ManyLights, Settings};
use crate::scene::Scene;

/// The rules of all passbands.
#[derive(Debug)]
pub struct SpectralPlan {
    /// The method's name.
    pub method: &'static str,
    /// The accuracy it was asked for \[1\].
    pub accuracy: f64,
    /// One for each passband.
    pub bands: Vec<BandPlan>,
    /// How scattered light is spread, if not evenly.
    pub phase: Option<PhaseTable>,
    /// Optical depth for which the certificates hold \[1\].
    pub depth: f64,
    /// The least extinction relative to V of any light in any passband \[1\].
    pub least_k: f64,
    /// The widest angle over which the phase function changes but little \[rad\]; infinite where scattering is
    /// isotropic.
    pub phase_angle: f64,
    phase_at_pivot: Option<(Arc<dyn Phase>, f64)>,
}

/// One passband.
pub struct BandPlan {
    /// The passband.
    pub band: Passband,
    /// What shines through it, in the order of the plan's lights.
    pub sources: Vec<Source>,
    /// How its integrals are done.
    pub rule: BandRule,
}

impl std::fmt::Debug for BandPlan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BandPlan({}, {:?})", self.band.name(), self.rule.certificates)
    }
}

impl SpectralPlan {
    /// p(cos θ) at the middle wavelength of the first band, for what needs no spectrum [sr⁻¹].
    pub fn phase_factor(&self, cosine: f64) -> f64 {
        self.phase_at_pivot.as_ref().map_or(1.0 / spectra::constants::SPHERE, |p| p.0.at(cosine, p.1))
    }
}

impl SpectralPlan {
    /// The angle at which the phase function has half of what it has forwards \[rad\]; π where it has no less.
    pub fn forward_peak(&self) -> f64 {
        let Some((phase, pivot)) = &self.phase_at_pivot else { return std::f64::consts::PI };
        let half = 0.5 * phase.at(1.0, *pivot);
        let angle = |i: usize| i as f64 * std::f64::consts::PI / PHASE_SAMPLES as f64;
        (1..=PHASE_SAMPLES).map(angle).find(|angle| phase.at(angle.cos(), *pivot) < half).unwrap_or(std::f64::consts::PI)
    }
}

/// Weights of scattered light over angle, linear in u: see [`PHASE_RANGE`].
#[derive(Debug, Clone)]
pub struct PhaseTable {
    /// Number of entries from u = 0, forwards, to u = √2, backwards.
    pub entries: usize,
    /// Whether one p(θ) serves all wavelengths: each light then has one number an entry, which multiplies its weights.
    pub separable: bool,
    /// For each light that is scattered: entry × term, a term being a node of the rule or a band of a lookup; empty for
    /// the others and those of the gathered stars.
    pub weights: Vec<Vec<f32>>,
    /// The phase function at the nodes themselves, for many lights: entry × term, one number an entry where it is
    /// separable; empty where there are no many lights.
    pub at_nodes: Vec<f32>,
}

impl PhaseTable {
    /// Entry, and place between it and the next, for cos θ and sin² θ in a table of so many.
    #[inline(always)]
    pub fn entry(entries: usize, cosine: f32, sine2: f32) -> (usize, f32) {
        // sin or cos of θ/2, whichever is small, without cancellation.
        let small = (sine2 / (2.0 * (1.0 + cosine.abs()))).sqrt();
        let at = if cosine >= 0.0 { small } else { PHASE_RANGE as f32 - small };
        let u = at * (entries.saturating_sub(1)) as f32 * (1.0 / PHASE_RANGE as f32);
        let entry = (u as usize).min(entries.saturating_sub(2));
        (entry, u - entry as f32)
    }
}

/// The strongest light through a band [W m⁻² at 1 pc, or its own unit]: 1/r² beside a star and columns of gas may make
/// a billion times more of it.
const STRONGEST: f64 = 1e28;

/// Angles at which the certificate must hold beside the mean.
const CERTIFIED_COSINES: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];
const MAX_PHASE_ENTRIES: usize = 4096;

impl SpectralPlan {
    /// Solves the rule for every passband of `scene`, for optical depths up to `depth`.
    pub(crate) fn new(
        scene: &Scene,
        lights: &[Light],
        many_lights: Option<&ManyLights>,
        settings: &Settings,
        depth: f64,
        control: &Control,
    ) -> Result<Self> {
        let method = &settings.method;
        let law = law(scene)?;
        let settings = &method.settings;
        let support_um = support_um(scene);
        let phase = scene.dust.as_ref().map(|d| d.phase.clone());
        let bands = scene
            .bands
            .par_iter()
            .map(|band| {
                control.check()?;
                let sources: Vec<Source> = lights.iter().map(|light| source(scene, light, band, &law)).collect();
                let k = |l: f64| law.k(l);
                let pivot = Node { lambda_um: band.pivot().0, k: law.k(band.pivot().0) };
                if let (Some(dust), Some((low, high))) = (&scene.dust, settings.domain_um) {
                    dust.extinction.check("the method's domain", low, high)?;
                }
                let problem = BandProblem {
                    sources: &sources,
                    domain_um: settings.domain_um.unwrap_or(band.support_um()),
                    common_um: settings.domain_um.unwrap_or(support_um),
                    pivot,
                    k: &k,
                    depth,
                    accuracy: method.accuracy,
                    settings,
                };
                let rule = (method.entry.rule.solve)(&problem)?;
                Ok(BandPlan { band: band.clone(), sources, rule })
            })
            .collect::<Result<Vec<BandPlan>>>()?;
        let pivot = bands.first().map_or(0.55, |b| b.band.pivot().0);
        let anisotropic = phase.filter(|p| !p.is_isotropic());
        let table = anisotropic.as_ref().map(|p| phase_table(&**p, (lights, many_lights), &bands, pivot, method.accuracy));
        let measures = bands.iter().flat_map(|b| &b.sources).flat_map(|s| &s.measure.k);
        let least_k = measures.copied().fold(f64::INFINITY, f64::min);
        Ok(Self {
            method: method.entry.name,
            accuracy: method.accuracy,
            least_k,
            bands,
            phase: table,
            depth,
            phase_angle: anisotropic.as_ref().map_or(f64::INFINITY, |p| phase_angle(&**p, pivot, method.accuracy)),
            phase_at_pivot: anisotropic.map(|p| (p, pivot)),
        })
    }

    /// Refuses light that single precision cannot hold, before a ray is marched.
    ///
    /// # Errors
    /// Names the light and the band.
    pub fn check_strength(&self, lights: &[Light]) -> Result<()> {
        for band in &self.bands {
            for (light, source) in lights.iter().zip(&band.sources) {
                let total = source.measure.total();
                if total.is_nan() || total >= STRONGEST {
                    let (name, band) = (&light.name, band.band.name());
                    let room = format!("more than the {STRONGEST:.0e} that single precision leaves room for");
                    return Err(Error::Strength(format!("{name} sends {total:.1e} W m-2 through band {band}, {room}")));
                }
            }
        }
        Ok(())
    }

    /// Nodes of all bands, or bands of a lookup.
    pub fn terms(&self) -> usize {
        self.bands.iter().map(BandPlan::terms).sum()
    }

    /// Bytes of all tables.
    pub fn bytes(&self) -> u64 {
        4 * self.phase.iter().flat_map(|p| p.weights.iter().chain([&p.at_nodes])).map(Vec::len).sum::<usize>() as u64
    }

    /// The certificates for depths up to `depth`, which a render found to be reached.
    pub fn certify(&self, band: usize, depth: f64) -> Vec<spectra::rule::Certificate> {
        let plan = &self.bands[band];
        if depth <= self.depth { plan.rule.certificates.clone() } else { plan.rule.certify(&plan.sources, depth) }
    }
}

impl BandPlan {
    /// How many terms a sample of this band costs.
    pub fn terms(&self) -> usize {
        self.rule.form.decay().terms()
    }

    /// The nodes of its rule, where that has some.
    pub fn nodes(&self) -> Option<&[Node]> {
        match &self.rule.form {
            Form::Nodes(nodes) => Some(&nodes.nodes),
            _ => None,
        }
    }

    /// The weights of each term for a light whose W carries one more factor.
    fn weights_with(&self, light: usize, factor: impl Fn(f64) -> f64) -> Vec<f64> {
        self.rule.form.decay().weights_with(light, &self.sources[light], &factor)
    }
}

/// Where any passband lets light through [µm].
pub(in crate::plan) fn support_um(scene: &Scene) -> (f64, f64) {
    let ends = scene.bands.iter().map(Passband::support_um);
    ends.fold((f64::MAX, 0.0), |(low, high): (f64, f64), (l, h)| (low.min(l), high.max(h)))
}

fn source(scene: &Scene, light: &Light, band: &Passband, law: &Arc<spectra::extinction::Extinction>) -> Source {
    let mut source = Source::new(&light.name, band, &light.spectrum, &***law, factor(light.route, scene.dust.as_ref()));
    let spectral = scene.dust.as_ref().map(|d| d.phase.clone()).filter(|p| p.is_spectral());
    if let (Route::Scattered { .. }, Some(phase)) = (light.route, spectral) {
        for cosine in CERTIFIED_COSINES {
            let phase = phase.clone();
            source.variants.push(Box::new(move |lambda| phase.at(cosine, lambda)));
        }
    }
    source
}

/// Samples of an angle from 0 to π.
const PHASE_SAMPLES: usize = 4096;

/// The angle at whose middle the phase function may be asked [rad]: over it ln p changes so much that the error of the
/// midpoint, Δ²/24, is the accuracy where it is steepest.
fn phase_angle(phase: &dyn Phase, pivot: f64, accuracy: f64) -> f64 {
    let step = std::f64::consts::PI / PHASE_SAMPLES as f64;
    let log = |i: usize| phase.at((i as f64 * step).cos(), pivot).max(f64::MIN_POSITIVE).ln();
    let steepest = (0..PHASE_SAMPLES).map(|i| (log(i + 1) - log(i)).abs() / step).fold(f64::MIN_POSITIVE, f64::max);
    (24.0 * accuracy).sqrt() / steepest
}

/// The largest abscissa of a phase table, backwards.
pub const PHASE_RANGE: f64 = std::f64::consts::SQRT_2;

/// cos θ at the table's abscissa u: sin(θ/2) up to 90 degrees, √2 − cos(θ/2) behind, so that both poles are seen as
/// finely.
fn cosine(u: f64) -> f64 {
    if u < 0.5 * PHASE_RANGE { 1.0 - 2.0 * u * u } else { 2.0 * (PHASE_RANGE - u).powi(2) - 1.0 }
}

fn phase_table(
    phase: &dyn Phase,
    (lights, many_lights): (&[Light], Option<&ManyLights>),
    bands: &[BandPlan],
    pivot: f64,
    accuracy: f64,
) -> PhaseTable {
    let at = |u: f64| phase.at(cosine(u), pivot);
    let error = |entries: usize| {
        let u = |i: f64| PHASE_RANGE * i / (entries - 1) as f64;
        (0..entries - 1)
            .map(|i| (i as f64, i as f64 + 0.5, i as f64 + 1.0))
            .map(|(a, m, b)| (0.5 * (at(u(a)) + at(u(b))) / at(u(m)).max(f64::MIN_POSITIVE) - 1.0).abs())
            .fold(0.0, f64::max)
    };
    let mut entries = 65;
    while error(entries) > 0.1 * accuracy && entries < MAX_PHASE_ENTRIES {
        entries = 2 * entries - 1;
    }
    let separable = !phase.is_spectral();
    let weights = lights
        .iter()
        .enumerate()
        .map(|(light, l)| {
            if !matches!(l.route, Route::Scattered { star } if many_lights.is_none_or(|c| !c.holds(star))) {
                return Vec::new();
            }
            if separable {
                return (0..entries).map(|i| at(PHASE_RANGE * i as f64 / (entries - 1) as f64) as f32).collect();
            }
            let entry = |i: usize| {
                let cosine = cosine(PHASE_RANGE * i as f64 / (entries - 1) as f64);
                bands.iter().flat_map(move |b| b.weights_with(light, |lambda| phase.at(cosine, lambda))).map(|w| w as f32)
            };
            (0..entries).flat_map(entry).collect()
        })
        .collect();
    let nodes: Vec<Node> = bands.iter().filter_map(BandPlan::nodes).flatten().copied().collect();
    let of_nodes = |i: usize| {
        let cosine = cosine(PHASE_RANGE * i as f64 / (entries - 1) as f64);
        let count = if separable { 1 } else { nodes.len() };
        nodes[..count.min(nodes.len())].iter().map(move |node| phase.at(cosine, if separable { pivot } else { node.lambda_um }) as f32)
    };
    let at_nodes = if many_lights.is_some() { (0..entries).flat_map(of_nodes).collect() } else { Vec::new() };
    PhaseTable { entries, separable, weights, at_nodes }
}
