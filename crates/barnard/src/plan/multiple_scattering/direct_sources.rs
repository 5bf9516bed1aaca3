//! Source of first-order light for eight terms.

use std::collections::HashMap;

use super::lanes::{EightLanes, WIDTH};
use super::problem::Problem;
use crate::light::Route;
use crate::plan::BandPlan;
use crate::plan::draft::Draft;

/// The stars, the gas and the background that shine.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectSources {
    /// Stars that are marched one by one, and what each sends: weights without k ω.
    pub stars: Vec<(usize, EightLanes)>,
    /// The weights without k ω of the gathered stars, in their order.
    pub many_lights: Vec<EightLanes>,
    /// The emission of gas per length in each cell, where there is gas.
    pub glow: Option<Vec<EightLanes>>,
    pub around: EightLanes,
    /// Radiance that all this is in parts of.
    pub unit: f32,
}

impl DirectSources {
    /// The sources of the terms of a problem with these numbers; `gas` is the density of each species in cells, without
    /// which it does not shine.
    pub fn new(problem: &Problem, numbers: &[usize], gas: &[Vec<f32>]) -> Self {
        let Draft { lights, spectral, space, .. } = problem.draft;
        let all = |light| spectral.bands.iter().flat_map(move |b: &BandPlan| b.rule.form.decay().weights(light)).copied();
        let unit = f64::from(problem.unit);
        let mut direct_sources = Self { stars: Vec::new(), many_lights: Vec::new(), glow: None, around: [0.0; WIDTH], unit: problem.unit };
        for (light, l) in lights.iter().enumerate() {
            let weights: Vec<f64> = all(light).collect();
            let weight = |t: usize| numbers.get(t).and_then(|number| weights.get(*number)).map_or(0.0, |w| w / unit);
            match l.route {
                Route::Scattered { star } => {
                    let term = |t: usize| numbers.get(t).map(|number| &problem.terms[*number]);
                    let sent = |t: usize| term(t).map_or(0.0, |term| term.k * term.albedo);
                    direct_sources
                        .stars
                        .push((star, std::array::from_fn(|t| if sent(t) > 0.0 { (weight(t) / sent(t)) as f32 } else { 0.0 })));
                }
                Route::Emitted { species } => {
                    let Some(gas) = gas.get(species) else { continue };
                    let weights: EightLanes = std::array::from_fn(|t| weight(t) as f32);
                    let glow = direct_sources.glow.get_or_insert_with(|| vec![[0.0; WIDTH]; gas.len()]);
                    glow.iter_mut().zip(gas).for_each(|(glow, density)| (0..WIDTH).for_each(|t| glow[t] += weights[t] * density));
                }
                Route::Background => direct_sources.around = std::array::from_fn(|t| weight(t) as f32),
                Route::Direct { .. } | Route::FieldStar { .. } => {}
            }
        }
        if let Some(many_lights) = &space.many_lights {
            let (gathered, marched): (Vec<_>, Vec<_>) = direct_sources.stars.into_iter().partition(|(star, _)| many_lights.holds(*star));
            let sent: HashMap<usize, EightLanes> = gathered.into_iter().collect();
            direct_sources.many_lights = many_lights.stars.iter().map(|star| sent.get(star).copied().unwrap_or_default()).collect();
            direct_sources.stars = marched;
        }
        direct_sources
    }
}
