//! Read-only context of a march: the plan with its flat tables.

use super::phase_rows::PhaseEntries;
use super::state::Slots;
use super::tables::Tables;
use crate::packet::{LANES, Lane};
use crate::plan::{PhaseEntry, PhaseTable, Plan, Scatterer};

/// The read-only context of a march: it is the same for all packets.
pub(super) struct Context<'a> {
    pub plan: &'a Plan,
    pub tables: &'a Tables,
    /// Offsets of channels in a sample.
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
        PhaseTable::entry(self.tables.phase.as_ref().map_or(0, |phase| phase.entries), cosine, sine2)
    }

    /// The weight of a term at an angle, 1/4π or p(θ) included.
    #[inline(always)]
    pub fn phase_weight(&self, scatterer: &Scatterer, term: usize, at: PhaseEntry) -> f32 {
        let Some(phase) = &self.tables.phase else { return scatterer.weights[term] };
        let value = phase.lights[scatterer.light].at(at.entry, at.fraction, term);
        if phase.separable { scatterer.weights[term] * value } else { value }
    }

    /// Entries and fractions of the phase table for cos θ and sin² θ of each ray.
    #[inline(always)]
    pub fn phase_entries(&self, cosine: &Lane, sine2: &Lane) -> PhaseEntries {
        let mut entries = PhaseEntries { entry: [0; LANES], fraction: [0.0; LANES] };
        for lane in 0..LANES {
            let PhaseEntry { entry, fraction } = self.phase_entry(cosine[lane], sine2[lane]);
            (entries.entry[lane], entries.fraction[lane]) = (entry, fraction);
        }
        entries
    }
}
