//! The plan's spectral side as the march reads it: flat f32 tables.

use spectra::rule::Form;

use crate::light::Path;
use crate::plan::Plan;

/// How a term depends on optical depth.
#[derive(Debug)]
pub enum Terms {
    /// Exponentials with extinction k; weights light × term.
    Nodes {
        /// k of each term.
        k: Vec<f32>,
    },
    /// Tables of ln F, light × term.
    Lookup {
        /// For each light and band.
        tables: Vec<Vec<LogTable>>,
    },
}

/// ln (F(a)/F(0)) at equal steps.
#[derive(Debug, Clone)]
pub struct LogTable {
    /// Entries per unit of depth.
    pub per_depth: f32,
    /// The logarithms.
    pub log: Vec<f32>,
}

/// A light that is scattered, and how.
#[derive(Debug)]
pub struct Scatterer {
    /// Its number among the lights.
    pub light: usize,
    /// Its star.
    pub star: usize,
    /// Weight of each term, 1/4π included where scattering is isotropic.
    pub weights: Vec<f32>,
    /// Largest weight of each term over all angles.
    pub brightest: Vec<f32>,
}

/// Flat tables.
#[derive(Debug)]
pub struct Tables {
    /// How terms depend on depth.
    pub terms: Terms,
    /// The band of each term.
    pub band_of: Vec<usize>,
    /// Lights scattered by dust.
    pub scattered: Vec<Scatterer>,
    /// (light, species, weight of each term).
    pub emitted: Vec<(usize, usize, Vec<f32>)>,
    /// The light that is the background.
    pub background: Option<usize>,
    /// Entries of the phase tables, zero where scattering is isotropic.
    pub phase_entries: usize,
    /// Smallest and largest extinction of any term.
    pub k_range: (f32, f32),
}

impl Tables {
    /// Flattens `plan`.
    pub fn new(plan: &Plan) -> Self {
        let spectral = &plan.spectral;
        let band_of: Vec<usize> = spectral.bands.iter().enumerate().flat_map(|(b, p)| vec![b; p.terms()]).collect();
        let weights = |light: usize| -> Vec<f32> {
            let of_band = |p: &crate::plan::BandPlan| match &p.rule.form {
                Form::Nodes { weights, .. } => weights[light].iter().map(|w| *w as f32).collect::<Vec<f32>>(),
                Form::Lookup(tables) => vec![tables[light].scale as f32],
            };
            spectral.bands.iter().flat_map(of_band).collect()
        };
        let isotropic = if spectral.phase.is_some() { 1.0 } else { 1.0 / spectra::constants::SPHERE as f32 };
        let (mut scattered, mut emitted, mut background) = (Vec::new(), Vec::new(), None);
        for (light, l) in plan.lights.iter().enumerate() {
            match l.path {
                Path::Scattered { star } => {
                    let weights: Vec<f32> = weights(light).iter().map(|w| w * isotropic).collect();
                    let brightest = brightest(plan, light, &weights);
                    scattered.push(Scatterer { light, star, weights, brightest });
                }
                Path::Emitted { species } => emitted.push((light, species, weights(light))),
                Path::Background => background = Some(light),
                Path::Direct { .. } | Path::FieldStar { .. } => {}
            }
        }
        let terms = terms(plan);
        let k_range = match &terms {
            Terms::Nodes { k } => k.iter().fold((f32::MAX, f32::MIN_POSITIVE), |(l, h), k| (l.min(*k), h.max(*k))),
            Terms::Lookup { .. } => (0.0, 1.0),
        };
        let phase_entries = spectral.phase.as_ref().map_or(0, |p| p.entries);
        Self { terms, band_of, scattered, emitted, background, phase_entries, k_range }
    }
}

/// The largest weight that any angle gives each term.
fn brightest(plan: &Plan, light: usize, weights: &[f32]) -> Vec<f32> {
    let Some(table) = &plan.spectral.phase else { return weights.to_vec() };
    let values = &table.weights[light];
    let largest = |stride: usize, column: usize| values.iter().skip(column).step_by(stride).fold(0.0f32, |m, v| m.max(*v));
    match table.separable {
        true => weights.iter().map(|w| w * largest(1, 0)).collect(),
        false => (0..weights.len()).map(|term| largest(weights.len(), term)).collect(),
    }
}

fn terms(plan: &Plan) -> Terms {
    let bands = &plan.spectral.bands;
    if let Some(Form::Lookup(_)) = bands.first().map(|b| &b.rule.form) {
        let table = |light: usize, band: &crate::plan::BandPlan| match &band.rule.form {
            Form::Lookup(tables) => {
                let t = &tables[light];
                LogTable { per_depth: (1.0 / t.step) as f32, log: t.log.iter().map(|v| *v as f32).collect() }
            }
            Form::Nodes { .. } => LogTable { per_depth: 1.0, log: vec![0.0; 2] },
        };
        return Terms::Lookup { tables: (0..plan.lights.len()).map(|l| bands.iter().map(|b| table(l, b)).collect()).collect() };
    }
    let k = bands.iter().flat_map(|b| match &b.rule.form {
        Form::Nodes { nodes, .. } => nodes.iter().map(|n| n.k as f32).collect::<Vec<f32>>(),
        Form::Lookup(_) => Vec::new(),
    });
    Terms::Nodes { k: k.collect() }
}

impl LogTable {
    /// ln F and its slope −d ln F/da at depth `a`.
    #[inline(always)]
    pub fn at(&self, a: f32) -> (f32, f32) {
        let x = a * self.per_depth;
        let i = (x as usize).min(self.log.len() - 2);
        let rise = self.log[i + 1] - self.log[i];
        (self.log[i] + (x - i as f32) * rise, -rise * self.per_depth)
    }
}
