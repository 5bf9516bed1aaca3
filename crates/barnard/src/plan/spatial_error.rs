//! The spatial error of a plan, as pilot rays measure it.

use crate::plan::Stepping;

/// The spatial error that pilot rays measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spatial {
    /// The steps of the rays.
    pub stepping: Stepping,
    /// Relative rms error of the worst band.
    pub error: f64,
    /// The part that samples of fields which are functions have of it, and the voxels along the longest edge of the
    /// coarsest.
    pub sampling: Option<(f64, usize)>,
    /// The number of rays that were marched.
    pub rays: usize,
    /// The error that samples of a function cost stars that are seen through it; none where they cost nothing.
    pub unresolved: Option<Unresolved>,
}

/// The error of stars' fluxes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unresolved {
    /// Relative rms over the stars that were asked, worst band.
    pub error: f64,
    /// The number of stars that were asked.
    pub stars: usize,
}
