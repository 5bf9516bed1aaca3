//! A solution in cells of one size, and its source function towards an eye.

use std::sync::Arc;

use super::cells::SweepCells;
use super::eye_source::EyeSource;
use super::fineness::Fineness;
use super::solved::Solved;
use super::view::Viewpoint;

/// A solution in cells of one size.
#[derive(Debug, Clone)]
pub struct Level {
    pub cells: SweepCells,
    pub fineness: Fineness,
    /// Light that was scattered before, of the solved terms, eight by eight.
    pub solved: Vec<Arc<Solved>>,
}

impl Level {
    /// S of the solved terms towards the eye.
    pub fn towards(&self, view: Viewpoint) -> EyeSource {
        EyeSource { lattice: self.cells.lattice.clone(), groups: self.solved.iter().map(|solved| solved.towards(view)).collect() }
    }
}
