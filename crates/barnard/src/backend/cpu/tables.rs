//! The plan's spectral side as the march reads it: flat f32 tables.

use super::propagation::Gathered;
use super::terms::Terms;
use crate::light::Path;
use crate::plan::Plan;

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
    /// The light field, in place of what is scattered star by star.
    pub gathered: Option<Gathered>,
    /// Entries of the phase tables, zero where scattering is isotropic.
    pub phase_entries: usize,
}

impl Tables {
    /// Flattens `plan`.
    pub fn new(plan: &Plan) -> Self {
        let spectral = &plan.spectral;
        let band_of: Vec<usize> = spectral.bands.iter().enumerate().flat_map(|(b, p)| vec![b; p.terms()]).collect();
        let weights = |light: usize| -> Vec<f32> {
            spectral.bands.iter().flat_map(|p| p.rule.form.decay().weights(light)).map(|w| *w as f32).collect()
        };
        let isotropic = if spectral.phase.is_some() { 1.0 } else { 1.0 / spectra::constants::SPHERE as f32 };
        let (mut scattered, mut emitted, mut background) = (Vec::new(), Vec::new(), None);
        for (light, l) in plan.lights.iter().enumerate() {
            match l.path {
                Path::Scattered { .. } if plan.light_field.is_some() => {}
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
        let phase_entries = spectral.phase.as_ref().map_or(0, |p| p.entries);
        let gathered = plan.light_field.as_deref().map(Gathered::new);
        Self { terms: Terms::new(plan), band_of, scattered, emitted, background, gathered, phase_entries }
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
