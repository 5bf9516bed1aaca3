//! How finely a field is solved: directions, then cells from coarse to fine, until the picture does not change by more than
//! the accuracy allows.

use super::MultipleScattering;
use super::eye_source::EyeSource;
use super::fineness::Fineness;
use super::harmonics::DEGREE;
use super::level::Level;
use super::pilot_light::PilotLight;
use super::problem::Problem;
use super::reduction::Reduction;
use super::view::Viewpoint;
use crate::control::Control;
use crate::error::Result;
use crate::image::ScatteringError;

/// Basis of the choice of cells and directions.
#[derive(Debug, Clone, Copy)]
pub(in crate::plan) enum Effort<'a> {
    /// The fineness of previews.
    Preview,
    /// A given fineness.
    Chosen(Fineness),
    /// As fine as the errors of cells and directions in the picture require.
    Measured(&'a PilotLight),
    /// Coarse cells, with their error.
    Estimated(&'a PilotLight),
}

/// Directions and degrees that are tried, from cheap to dear.
const ANGLES: [Fineness; 4] = [
    Fineness { cells: COARSEST, directions: [4, 2], degree: 2 },
    Fineness { cells: COARSEST, directions: [4, 3], degree: 3 },
    Fineness { cells: COARSEST, directions: [6, 3], degree: DEGREE },
    Fineness { cells: COARSEST, directions: [8, 4], degree: DEGREE },
];
/// Cells along an edge of the first level, and of the last.
const COARSEST: usize = 16;
const FINEST: usize = 128;
/// Cells where stars are aggregated in them, whose shadows they must show.
const AGGREGATED: usize = 64;
/// Parts of the accuracy that directions and cells may cost in the picture.
const ANGULAR_SHARE: f64 = 0.5;
const SPATIAL_SHARE: f64 = 0.7;
/// Error of an extrapolation relative to its difference from the one before: 1/3 where errors fall with the second power of a
/// cell's edge, 1 where they fall with the first.
const REMAINING: f64 = 0.5;
/// How much of the work the first levels are expected to be.
const EXPECTED: [f64; 4] = [0.02, 0.1, 0.4, 1.0];

/// Levels from coarse to fine.
pub struct Refined {
    pub levels: Vec<Level>,
    /// The error in the picture; none where it was not measured.
    pub error: Option<ScatteringError>,
    /// True if memory did not allow the level that was needed.
    pub coarser: bool,
    /// The bytes of the finest level.
    pub bytes: u64,
}

/// The levels of a problem on their way.
pub struct Refinement<'a> {
    pub problem: &'a Problem<'a>,
    pub reduction: &'a Reduction,
    pub before: Option<&'a MultipleScattering>,
    pub control: &'a Control,
}

impl Refinement<'_> {
    /// Levels as fine as an effort says.
    ///
    /// # Errors
    /// If memory is too small for the coarsest, if light comes to no number, and on interruption by the user.
    pub fn levels(&self, effort: Effort) -> Result<Refined> {
        let (scatters, aggregated) = (self.problem.scatters_again(), self.problem.draft.space.many_lights.is_some());
        match effort {
            Effort::Preview => self.fixed(Fineness::PREVIEW),
            Effort::Chosen(fineness) => self.fixed(fineness),
            Effort::Measured(_) | Effort::Estimated(_) if !scatters => self.fixed(Fineness::UNMEASURED),
            Effort::Estimated(pilots) => self.refined(pilots, self.angles(pilots)?, (2 * COARSEST, f64::INFINITY)),
            Effort::Measured(pilots) if aggregated => self.refined(pilots, self.angles(pilots)?, (AGGREGATED, f64::INFINITY)),
            Effort::Measured(pilots) => {
                let accuracy = SPATIAL_SHARE * self.problem.draft.scene.method.accuracy;
                self.refined(pilots, self.angles(pilots)?, (2 * COARSEST, accuracy))
            }
        }
    }

    /// Two levels: as many cells as are given, or as memory allows, and half as many.
    fn fixed(&self, fineness: Fineness) -> Result<Refined> {
        let fitting = self.problem.fitting(fineness, self.reduction.solved.len())?;
        let finest = fineness.with_cells(fitting.cells);
        let mut levels = Vec::new();
        if self.problem.scatters_again() {
            levels.push(self.level(finest.with_cells(fitting.cells / 2), (0.0, EXPECTED[1]))?);
        }
        levels.push(self.level(finest, (EXPECTED[1], 1.0))?);
        Ok(Refined { levels, error: None, coarser: fitting.cells < fineness.cells, bytes: fitting.bytes })
    }

    fn level(&self, fineness: Fineness, (from, to): (f64, f64)) -> Result<Level> {
        self.problem.solve(fineness, &self.reduction.solved, self.before, &self.control.part(from, to))
    }

    /// A solution in the coarsest cells by the cheapest directions whose error is small enough, and that error.
    fn angles(&self, pilots: &PilotLight) -> Result<(Level, f64)> {
        let view = Viewpoint::of(&self.problem.draft.scene.camera);
        let allowed = ANGULAR_SHARE * self.problem.draft.scene.method.accuracy;
        let level = |fineness| self.level(fineness, (0.0, 0.0));
        let mut chosen = level(ANGLES[0])?;
        for finer in &ANGLES[1..ANGLES.len() - 1] {
            let finer = level(*finer)?;
            let error = self.difference(pilots, &chosen.towards(view), &finer.towards(view));
            if error <= allowed {
                return Ok((chosen, error));
            }
            chosen = finer;
        }
        let finest = level(ANGLES[ANGLES.len() - 1])?;
        let error = self.difference(pilots, &chosen.towards(view), &finest.towards(view));
        Ok((chosen, error))
    }

    fn difference(&self, pilots: &PilotLight, source: &EyeSource, other: &EyeSource) -> f64 {
        pilots.difference(self.problem, self.reduction, source, other)
    }

    /// Levels of twice as many cells each, from `first` on, until the picture changes by no more than what is allowed.
    fn refined(&self, pilots: &PilotLight, (probe, angular): (Level, f64), (first, allowed): (usize, f64)) -> Result<Refined> {
        let angles = probe.fineness;
        let view = Viewpoint::of(&self.problem.draft.scene.camera);
        let fitting = |cells: usize| self.problem.fitting(angles.with_cells(cells), self.reduction.solved.len());
        let mut fits = fitting(first)?;
        let mut coarser = fits.cells < first;
        let half = if fits.cells / 2 == angles.cells { probe } else { self.level(angles.with_cells(fits.cells / 2), (0.0, EXPECTED[0]))? };
        let (mut best, mut spatial, mut levels) = (half.towards(view), f64::INFINITY, vec![half]);
        for expected in EXPECTED.windows(2) {
            let finer = self.level(angles.with_cells(fits.cells), (expected[0], expected[1]))?;
            let extrapolated = finer.towards(view).extrapolated(&levels[levels.len() - 1].towards(view));
            spatial = REMAINING * self.difference(pilots, &extrapolated, &best);
            best = extrapolated;
            levels.push(finer);
            let cells = 2 * fits.cells;
            // Cells beyond the usual number are worth their price only where without them the accuracy is missed, and with them met.
            let promises = cells <= Fineness::UNMEASURED.cells || (SPATIAL_SHARE * spatial > allowed && REMAINING * spatial <= allowed);
            let is_finer = self.problem.lattice(cells).dims != self.problem.lattice(fits.cells).dims;
            if spatial <= allowed || coarser || cells > FINEST || !promises || !is_finer {
                break;
            }
            let next = fitting(cells)?;
            coarser = next.cells < cells;
            if coarser {
                break;
            }
            fits = next;
        }
        Ok(Refined { levels, error: Some(ScatteringError { spatial, angular }), coarser, bytes: fits.bytes })
    }
}
