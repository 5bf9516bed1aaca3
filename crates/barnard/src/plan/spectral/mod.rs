//! Spectral plan: a solved rule for each passband, phase tables, and the certificate.

pub mod closed_form;
mod phase_table;
pub mod weights;

use std::sync::Arc;

use rayon::prelude::*;
use spectra::extinction::Extinction;
use spectra::passband::Passband;
use spectra::rule::{BandProblem, BandRule, DepthSpan, Form, Node, Source, mean_transmittance};

use self::phase_table::PhaseAtPivot;
pub use self::phase_table::{PHASE_RANGE, PhaseEntry, PhaseTable};

use crate::control::Control;
use crate::error::{Error, Result};
use crate::light::{Light, Route, factor, law};
use crate::plan::SpatialPlan;
use crate::scene::{Scene, StarDepthSource};

/// The rules of all passbands.
#[derive(Debug)]
pub struct SpectralPlan {
    /// The name of the method.
    pub method: &'static str,
    /// The accuracy it was asked for \[1\].
    pub accuracy: f64,
    /// Accuracy of its rules alone \[1\].
    pub rule_accuracy: f64,
    /// The plan of each passband.
    pub bands: Vec<BandPlan>,
    /// The table of the phase function; none where scattering is even.
    pub phase: Option<PhaseTable>,
    /// Optical depth for which the certificates hold \[1\].
    pub depth: f64,
    /// The least extinction relative to V of any light in any passband \[1\].
    pub least_k: f64,
    /// The widest angle over which the phase function changes but little \[rad\]; infinite where scattering is
    /// isotropic.
    pub phase_angle: f64,
    phase_at_pivot: Option<PhaseAtPivot>,
}

/// Target of the rules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RuleTarget {
    /// The allowed error, relative to the light without extinction \[1\].
    pub accuracy: f64,
    /// The optical depth at V up to which it holds \[1\].
    pub depth: f64,
}

/// The plan of one passband.
pub struct BandPlan {
    /// The passband itself.
    pub band: Passband,
    /// The sources that shine through it, in the order of the plan's lights.
    pub sources: Vec<Source>,
    /// The rule by which its integrals are done.
    pub rule: BandRule,
}

impl std::fmt::Debug for BandPlan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BandPlan({}, {:?})", self.band.name(), self.rule.certificates)
    }
}

/// The strongest light through a band [W m⁻² at 1 pc, or its own unit]: 1/r² beside a star and columns of gas may make
/// a billion times more of it.
const STRONGEST: f64 = 1e28;

/// Angles at which the certificate must hold beside the mean.
const CERTIFIED_COSINES: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];

/// Inputs of the rules of all passbands.
struct BandInputs<'a> {
    scene: &'a Scene,
    lights: &'a [Light],
    law: &'a Arc<Extinction>,
    /// The wavelengths of all passbands together.
    support_um: (f64, f64),
    rules: RuleTarget,
    control: &'a Control,
}

impl BandInputs<'_> {
    /// The plan of a passband with the name of its method; by nodes that the passbands have in common, where it may share them.
    fn solved(&self, band: &Passband, may_share: bool) -> Result<(&'static str, BandPlan)> {
        let Self { scene, lights, law, support_um, rules, control } = *self;
        let method = &scene.method;
        let settings = &method.settings;
        control.check()?;
        let checked = |light| control.check().map(|()| source(scene, light, band, law));
        let sources = lights.iter().map(checked).collect::<Result<Vec<Source>>>()?;
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
            depth: rules.depth,
            accuracy: rules.accuracy,
            settings,
            interrupted: &|| control.interrupted(),
        };
        let stated_rule = method.entry.rule;
        let entry = if may_share { stated_rule.serving(scene.bands.len(), &problem) } else { stated_rule };
        let rule = (entry.solve)(&problem);
        control.check()?;
        let rule = rule?;
        let name = if entry.name == stated_rule.name { method.entry.name } else { entry.name };
        Ok((name, BandPlan { band: band.clone(), sources, rule }))
    }
}

/// The phase function at the angles of marched lights, with its weights in the bands.
fn phase_table(phase: &PhaseAtPivot, accuracy: f64, (lights, bands): (&[Light], &[BandPlan]), space: &SpatialPlan) -> PhaseTable {
    let many_lights = space.many_lights.as_deref();
    let entries = phase.entries(accuracy);
    let marched = |light: &Light| matches!(light.route, Route::Scattered { star } if many_lights.is_none_or(|c| !c.holds(star)));
    let weights = lights.iter().enumerate().map(|(i, light)| if marched(light) { phase.weights(entries, bands, i) } else { Vec::new() });
    let at_nodes = if many_lights.is_some() { phase.at_nodes(entries, bands) } else { Vec::new() };
    PhaseTable { entries, separable: !phase.phase.is_spectral(), weights: weights.collect(), at_nodes }
}

impl SpectralPlan {
    /// Solves the rule for every passband of `scene`, for the optical depths of `space`.
    pub(crate) fn new(scene: &Scene, lights: &[Light], space: &SpatialPlan, control: &Control) -> Result<Self> {
        let rules = RuleTarget { accuracy: scene.method.accuracy, depth: space.reach(&scene.camera) };
        Self::with_rules(scene, lights, space, rules, control)
    }

    /// Variant by rules that are made for something else than all else is.
    pub(crate) fn with_rules(scene: &Scene, lights: &[Light], space: &SpatialPlan, rules: RuleTarget, control: &Control) -> Result<Self> {
        let method = &scene.method;
        let law = law(scene)?;
        let RuleTarget { accuracy: rule_accuracy, depth } = rules;
        // A node that passbands share is no passband's own transport: what it scatters again is no one's.
        let scatters_once = method.bounces == 1 && space.many_lights.is_none() && method.entry.star_depth == StarDepthSource::Cached;
        let inputs = BandInputs { scene, lights, law: &law, support_um: support_um(scene), rules, control };
        let solved = |may_share: bool| scene.bands.par_iter().map(|band| inputs.solved(band, may_share)).collect::<Result<Vec<_>>>();
        let mut bands = solved(scatters_once)?;
        // Nodes that were not asked for must keep what was: a law that turns back has them at one of two wavelengths.
        let keeps = |(name, band): &(&str, BandPlan)| {
            *name == method.entry.name || band.rule.certificates.iter().all(|c| c.absolute <= rule_accuracy)
        };
        if !bands.iter().all(keeps) {
            bands = solved(false)?;
        }
        let name = bands.first().map_or(method.entry.name, |(name, _)| name);
        let bands: Vec<BandPlan> = bands.into_iter().map(|(_, band)| band).collect();
        let phase = scene.dust.as_ref().map(|d| d.phase.clone()).filter(|p| !p.is_isotropic());
        let pivot = |phase| PhaseAtPivot { phase, lambda_um: bands.first().map_or(0.55, |b: &BandPlan| b.band.pivot().0) };
        let phase_at_pivot = phase.map(pivot);
        let measures = bands.iter().flat_map(|b| &b.sources).flat_map(|s| &s.measure.k);
        let least_k = measures.copied().fold(f64::INFINITY, f64::min);
        Ok(Self {
            method: name,
            accuracy: method.accuracy,
            rule_accuracy,
            least_k,
            phase: phase_at_pivot.as_ref().map(|phase| phase_table(phase, scene.method.accuracy, (lights, &bands), space)),
            depth,
            phase_angle: phase_at_pivot.as_ref().map_or(f64::INFINITY, |p| p.midpoint_angle(method.accuracy)),
            phase_at_pivot,
            bands,
        })
    }

    /// The phase function p(cos θ) at the middle wavelength of the first band, for what needs no spectrum [sr⁻¹].
    pub fn phase_factor(&self, cosine: f64) -> f64 {
        self.phase_at_pivot.as_ref().map_or(1.0 / spectra::constants::SPHERE, |p| p.at(cosine))
    }

    /// The angle at which the phase function has half of what it has forwards \[rad\]; π where it has no less.
    pub fn forward_peak(&self) -> f64 {
        self.phase_at_pivot.as_ref().map_or(std::f64::consts::PI, PhaseAtPivot::forward_peak)
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
                    let room = format!("more than the limit of single precision, {STRONGEST:.0e}");
                    return Err(Error::Strength(format!("{name} emits {total:.1e} W m-2 through band {band}, {room}")));
                }
            }
        }
        Ok(())
    }

    /// Unattenuated light through all bands.
    pub(crate) fn total(&self, light: usize) -> f64 {
        self.bands.iter().map(|band| band.sources[light].measure.total()).sum()
    }

    /// Nodes of all bands, those once that they share, or bands of a lookup.
    pub fn terms(&self) -> usize {
        self.common_nodes().map_or_else(|| self.bands.iter().map(BandPlan::terms).sum(), <[Node]>::len)
    }

    /// The nodes that all bands share, where they do.
    pub fn common_nodes(&self) -> Option<&[Node]> {
        self.bands.first().and_then(BandPlan::common_nodes)
    }

    /// Adds `amount` of a light, fallen by its mean over a span of depths, to sums that [`resolved`](Self::resolved)
    /// makes bands of; none at first.
    pub(crate) fn add(&self, light: usize, amount: f64, depths: DepthSpan, sums: &mut Vec<f64>) {
        let Some(nodes) = self.common_nodes() else {
            sums.resize(self.bands.len(), 0.0);
            return self.bands.iter().zip(sums).for_each(|(band, sum)| *sum += amount * band.rule.mean(light, depths));
        };
        // Each light at each node.
        sums.resize(sums.len().max((light + 1) * nodes.len()), 0.0);
        for (node, sum) in nodes.iter().zip(&mut sums[light * nodes.len()..]) {
            *sum += amount * mean_transmittance(node.k * depths.from, node.k * depths.to);
        }
    }

    /// The radiance of each band that [sums](Self::add) come to.
    pub(crate) fn resolved(&self, sums: &[f64]) -> Vec<f64> {
        let of_band = |(b, band): (usize, &BandPlan)| match &band.rule.form {
            Form::CommonNodes(nodes) => {
                let lights = sums.chunks_exact(nodes.nodes.len()).zip(&nodes.weights);
                lights.map(|(sums, weights)| weights.iter().zip(&sums[nodes.first..]).map(|(w, sum)| w * sum).sum::<f64>()).sum()
            }
            _ => sums.get(b).copied().unwrap_or(0.0),
        };
        self.bands.iter().enumerate().map(of_band).collect()
    }

    /// The bytes that all tables take.
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
    /// The number of terms that this band's light is a sum of.
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

    /// The nodes that it shares with all other bands, where it does.
    pub fn common_nodes(&self) -> Option<&[Node]> {
        match &self.rule.form {
            Form::CommonNodes(common) => Some(&common.nodes),
            _ => None,
        }
    }

    /// True if what is left behind a depth is known, so that rays can end early.
    pub fn is_bounded(&self) -> bool {
        matches!(self.rule.form, Form::Nodes(_) | Form::CommonNodes(_))
    }

    /// The weights of each term for a light whose W carries one more factor.
    fn weights_with(&self, light: usize, factor: impl Fn(f64) -> f64) -> Vec<f64> {
        self.rule.form.decay().weights_with(light, &self.sources[light], &factor)
    }
}

/// The interval of wavelengths that any passband lets through [µm].
pub(in crate::plan) fn support_um(scene: &Scene) -> (f64, f64) {
    let ends = scene.bands.iter().map(Passband::support_um);
    ends.fold((f64::MAX, 0.0), |(low, high): (f64, f64), (l, h)| (low.min(l), high.max(h)))
}

/// Unattenuated light through a passband.
pub(crate) fn source(scene: &Scene, light: &Light, band: &Passband, law: &Arc<Extinction>) -> Source {
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
