//! The plan's spectral side as a march reads it: the weight of each term for each light, in f32.

use crate::light::Route;
use crate::plan::{BandPlan, Plan};

/// A light that is scattered, and how.
#[derive(Debug, Clone)]
pub struct Scatterer {
    /// The number of the light in the plan.
    pub light: usize,
    /// The number of its star in the scene.
    pub star: usize,
    /// Weight of each term, 1/4π included where scattering is isotropic.
    pub weights: Vec<f32>,
    /// Largest weight of each term over all angles.
    pub brightest: Vec<f32>,
}

/// A light that a species of gas sends out.
#[derive(Debug, Clone)]
pub struct Emitter {
    /// The number of the light in the plan.
    pub light: usize,
    /// The number of the species in the scene.
    pub species: usize,
    /// Emission through all bands relative to that of all species \[1\].
    pub total: f32,
    /// The weight of each term.
    pub weights: Vec<f32>,
}

/// Weights of all lights; a term is a node of the rule of one passband, or of all.
#[derive(Debug, Clone)]
pub struct Weights {
    /// The number of terms.
    pub terms: usize,
    /// The passband of each term; none where passbands share them.
    pub band_of: Vec<usize>,
    /// Lights scattered by dust, star by star.
    pub scattered: Vec<Scatterer>,
    /// Weights of each term for the gathered stars, in its order, 1/4π included where scattering is isotropic.
    pub many_lights: Vec<Vec<f32>>,
    /// The lights of gas, species by species.
    pub emitted: Vec<Emitter>,
    /// The light that is the background.
    pub background: Option<usize>,
}

impl Weights {
    /// Flattens `plan`; light that its light field holds is left out, and light that does not shine.
    pub fn new(plan: &Plan) -> Self {
        let spectral = &plan.spectral;
        let of_terms = |(band, plan): (usize, &BandPlan)| vec![band; plan.terms()];
        let band_of =
            if spectral.common_nodes().is_some() { Vec::new() } else { spectral.bands.iter().enumerate().flat_map(of_terms).collect() };
        let isotropic = if spectral.phase.is_some() { 1.0 } else { 1.0 / spectra::constants::SPHERE as f32 };
        let (mut scattered, mut emitted, mut background) = (Vec::new(), Vec::new(), None);
        let many_lights = plan.space.many_lights.as_deref();
        let gas = plan.lights.iter().enumerate().filter(|(_, light)| matches!(light.route, Route::Emitted { .. }));
        let brightest_gas = gas.map(|(light, _)| spectral.total(light)).fold(f64::MIN_POSITIVE, f64::max);
        let mut of_many = vec![Vec::new(); plan.space.stars.len()];
        for (light, l) in plan.lights.iter().enumerate().filter(|(light, _)| plan.shines(*light)) {
            match l.route {
                Route::Scattered { .. } if plan.light_field.is_some() => {}
                Route::Scattered { star } if many_lights.is_some_and(|c| c.holds(star)) => {
                    of_many[star] = weights(plan, light).iter().map(|w| w * isotropic).collect();
                }
                Route::Scattered { star } => {
                    let weights: Vec<f32> = weights(plan, light).iter().map(|w| w * isotropic).collect();
                    let brightest = brightest(plan, light, &weights);
                    scattered.push(Scatterer { light, star, weights, brightest });
                }
                Route::Emitted { species } => {
                    let total = spectral.total(light) / brightest_gas;
                    emitted.push(Emitter { light, species, total: total as f32, weights: weights(plan, light) });
                }
                Route::Background => background = Some(light),
                Route::Direct { .. } | Route::FieldStar { .. } => {}
            }
        }
        let many_lights = many_lights
            .map_or_else(Vec::new, |many_lights| many_lights.stars.iter().map(|star| std::mem::take(&mut of_many[*star])).collect());
        Self { terms: spectral.terms(), band_of, scattered, many_lights, emitted, background }
    }
}

/// The weight of each term for a light, in the order of [`Weights::band_of`]; one for each node that passbands share,
/// whose own weights turn sums into light.
pub fn weights(plan: &Plan, light: usize) -> Vec<f32> {
    if plan.spectral.common_nodes().is_some() {
        return vec![1.0; plan.spectral.terms()];
    }
    plan.spectral.bands.iter().flat_map(|p| p.rule.form.decay().weights(light)).map(|w| *w as f32).collect()
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
