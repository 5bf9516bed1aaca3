//! The plan's spectral side as the march reads it: flat f32 tables.

use super::light_sums::LightSums;
use super::phase_rows::PhaseRows;
use super::terms::Terms;
use crate::plan::{PhaseTable, Plan, Weights};

/// Spectral plan as flat tables in single precision.
#[derive(Debug)]
pub struct Tables {
    /// How each term falls with depth.
    pub terms: Terms,
    /// The weight of each term for each light.
    pub weights: Weights,
    /// The light field, in place of what is scattered star by star.
    pub light_sums: Option<LightSums>,
    /// The terms that some species of gas sends light with.
    pub(super) glowing: Vec<bool>,
    /// The phase function; none where scattering is isotropic.
    pub(super) phase: Option<Phase>,
}

/// A phase function at the terms of all lights.
#[derive(Debug)]
pub(super) struct Phase {
    /// Entries of each table.
    pub(super) entries: usize,
    /// True if all terms scatter alike, so that weights stand beside the tables and not in them.
    pub(super) separable: bool,
    /// The weights of each light at its angles.
    pub(super) lights: Vec<PhaseRows>,
    /// The phase function at the nodes.
    pub(super) at_nodes: PhaseRows,
}

impl Phase {
    fn new(table: &PhaseTable, terms: usize) -> Self {
        let columns = if table.separable { 1 } else { terms };
        Self {
            entries: table.entries,
            separable: table.separable,
            lights: table.weights.iter().map(|values| PhaseRows::new(values, columns)).collect(),
            at_nodes: PhaseRows::new(&table.at_nodes, columns),
        }
    }
}

impl Tables {
    /// Flattens the spectral side of `plan`.
    pub fn new(plan: &Plan) -> Self {
        let light_sums = plan.light_field.as_deref().map(LightSums::new);
        let weights = Weights::new(plan);
        let phase = plan.spectral.phase.as_ref().map(|table| Phase::new(table, weights.terms));
        let glowing = (0..weights.terms).map(|term| weights.emitted.iter().any(|e| e.weights[term] != 0.0)).collect();
        Self { terms: Terms::new(plan, &weights), weights, light_sums, glowing, phase }
    }
}
