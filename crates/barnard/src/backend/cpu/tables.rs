//! The plan's spectral side as the march reads it: flat f32 tables.

use super::light_sums::LightSums;
use super::terms::Terms;
use crate::plan::{Plan, Weights};

/// What a march reads of the spectral plan, as flat tables in single precision.
#[derive(Debug)]
pub struct Tables {
    /// How each term falls with depth.
    pub terms: Terms,
    /// The weight of each term for each light.
    pub weights: Weights,
    /// The light field, in place of what is scattered star by star.
    pub light_sums: Option<LightSums>,
    /// Entries of the phase tables, zero where scattering is isotropic.
    pub phase_entries: usize,
}

impl Tables {
    /// Flattens the spectral side of `plan`.
    pub fn new(plan: &Plan) -> Self {
        let phase_entries = plan.spectral.phase.as_ref().map_or(0, |p| p.entries);
        let light_sums = plan.light_field.as_deref().map(LightSums::new);
        Self { terms: Terms::new(plan), weights: Weights::new(plan), light_sums, phase_entries }
    }
}
