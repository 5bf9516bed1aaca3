//! What a march reads and never writes: the plan with its flat tables.

use super::state::Slots;
use super::tables::Tables;
use crate::plan::{PhaseEntry, PhaseTable, Plan, Scatterer};

/// The read-only context of a march: it is the same for all packets.
pub(super) struct Context<'a> {
    pub plan: &'a Plan,
    pub tables: &'a Tables,
    /// Where channels stand in a sample.
    pub slots: Slots,
    /// The edge of the smallest voxel [pc].
    pub voxel_pc: f64,
}

impl<'a> Context<'a> {
    /// Prepares the march of one plan.
    pub fn new(plan: &'a Plan, tables: &'a Tables) -> Self {
        Self { plan, tables, slots: Slots::new(plan), voxel_pc: plan.space.voxel_pc() }
    }

    /// Entry and fraction of the phase table for cos θ and sin² θ.
    #[inline(always)]
    pub fn phase_entry(&self, cosine: f32, sine2: f32) -> PhaseEntry {
        PhaseTable::entry(self.tables.phase_entries, cosine, sine2)
    }

    /// The weight of a term at an angle, 1/4π or p(θ) included.
    #[inline(always)]
    pub fn phase_weight(&self, scatterer: &Scatterer, term: usize, at: PhaseEntry) -> f32 {
        let Some(table) = &self.plan.spectral.phase else { return scatterer.weights[term] };
        let values = &table.weights[scatterer.light];
        let (stride, column, weight) =
            if table.separable { (1, 0, scatterer.weights[term]) } else { (self.tables.weights.band_of.len(), term, 1.0) };
        let (low, high) = (values[at.entry * stride + column], values[(at.entry + 1) * stride + column]);
        weight * (low + at.fraction * (high - low))
    }
}
