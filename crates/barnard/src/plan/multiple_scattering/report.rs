//! Report of a solution of multiple scattering, in numbers and in words.

use std::sync::Arc;

use crate::image::ScatteringError;

/// Facts about a solution.
#[derive(Debug, Clone, PartialEq)]
pub struct ScatteringReport {
    /// The number of cells along each axis.
    pub cells: [usize; 3],
    /// The coarser cells from which, and those, it was extrapolated to cells of no size.
    pub extrapolated_from: Option<[usize; 3]>,
    /// True if the cells are fewer than they should be, to keep to the memory limit.
    pub coarser: bool,
    /// True if it was solved in coarse cells for an estimate of errors; pictures are solved in finer ones where they need them.
    pub is_estimate: bool,
    /// Directions of light: of the first order and of the others.
    pub directions: [usize; 2],
    /// The degree of the harmonics.
    pub degree: usize,
    /// Terms that were solved, and all, which are sums of those.
    pub terms: (usize, usize),
    /// Orders of scattering that were swept.
    pub sweeps: usize,
    /// The name of what swept them, and why it was not what should have.
    pub swept_by: Arc<str>,
    /// The part of all that the geometric series behind them stands for, of the worst term.
    pub series: f64,
    /// True if the orders went as a geometric series in the end.
    pub settled: bool,
    /// The error that the field makes in the picture of the first camera; none where it was not measured.
    pub error_estimate: Option<ScatteringError>,
    /// The first light of the gathered stars, where the field has some.
    pub far_field: Option<FarFieldReport>,
    /// The bytes that the field takes.
    pub bytes: u64,
}

/// Light of stars that scatters once and is gathered in the field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarFieldReport {
    /// The number of stars.
    pub stars: usize,
    /// Smallest and largest radius of the kernels around them, within which their light is marched \[pc\].
    pub near_pc: (f64, f64),
    /// Voxels along the longest edge of their depths.
    pub shadows: usize,
    /// The mean difference from the exact light towards the first camera, in parts of its mean, at places in the dust;
    /// nothing where it was not measured.
    pub error: Option<f64>,
}

impl std::fmt::Display for FarFieldReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { stars, near_pc: (low, high), shadows, error } = self;
        write!(
            f,
            "light of {stars} stars is aggregated in cells beyond {low:.3} to {high:.3} pc of each, with shadows of {shadows} voxels per edge, "
        )?;
        match error {
            Some(error) => write!(f, "{:.1} % mean error at random places in the dust", 100.0 * error),
            None => write!(f, "its error is unknown"),
        }
    }
}

impl std::fmt::Display for ScatteringReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ScatteringReport {
            cells: [x, y, z],
            coarser,
            directions: [first, others],
            degree,
            terms: (solved, terms),
            sweeps,
            series,
            settled,
            error_estimate,
            ..
        } = *self;
        let by = &self.swept_by;
        write!(
            f,
            "{sweeps} scattering orders of {solved} of {terms} terms computed on {by} in {x} x {y} x {z} cells and {first} directions, then {others}, moments up to degree {degree}, {} MiB",
            self.bytes >> 20
        )?;
        if let Some([x, y, z]) = self.extrapolated_from {
            write!(f, ", extrapolated from {x} x {y} x {z} cells")?;
        }
        if coarser {
            write!(f, " (limited by memory: raise the memory limit for more cells)")?;
        }
        if self.is_estimate {
            write!(f, " (an estimate: pictures use finer cells where the accuracy needs them)")?;
        }
        if !settled {
            write!(f, " (not converged)")?;
        }
        write!(
            f,
            ", {:.1} % of this light extrapolated by a geometric series; error in the picture: spectral not certified",
            100.0 * series
        )?;
        match error_estimate {
            Some(ScatteringError { spatial, angular }) => {
                write!(
                    f,
                    ", spatial about {:.1} %, angular about {:.1} % (from coarser cells and other directions)",
                    100.0 * spatial,
                    100.0 * angular
                )?;
            }
            None => write!(f, ", spatial and angular unknown")?,
        }
        write!(f, ", truncation of moments unknown")
    }
}
