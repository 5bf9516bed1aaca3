//! Requested quantities of the gas.

use crate::balance::{Gas, GasState};

/// Requested quantities of the gas in each voxel.
pub struct Quantity<'a> {
    /// The most that it can be: what is more counts as that.
    pub most: f64,
    /// Value for a gas and its state.
    pub value: &'a (dyn Fn(&Gas, &GasState) -> f64 + Sync),
}

impl Quantity<'_> {
    /// Quantity of a gas, relative to its maximum.
    pub(crate) fn part(&self, gas: &Gas, state: &GasState) -> f64 {
        ((self.value)(gas, state) / self.most).clamp(0.0, 1.0)
    }
}
