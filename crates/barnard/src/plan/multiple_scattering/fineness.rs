//! How finely a field of scattered light is solved.

use super::harmonics::DEGREE;

/// The fineness of a field of scattered light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fineness {
    /// Most cells along an edge.
    pub cells: usize,
    /// Directions along each edge of a cube's face: of light that has scattered once, which comes from near the stars,
    /// and of all other.
    pub directions: [usize; 2],
    /// The highest degree of harmonics.
    pub degree: usize,
}

impl Fineness {
    /// The fineness where no pilots say what is needed.
    pub const UNMEASURED: Self = Self { cells: 64, directions: [6, 3], degree: DEGREE };
    /// The fineness of previews while things move.
    pub const PREVIEW: Self = Self { cells: 24, directions: [4, 2], degree: 1 };
    /// The fineness at which it is found which terms are solved in full.
    pub(super) const REDUCING: Self = Self { cells: 12, directions: [3, 2], degree: 2 };

    /// The finer of two.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let [a, b] = [0, 1].map(|i| self.directions[i].max(other.directions[i]));
        Self { cells: self.cells.max(other.cells), directions: [a, b], degree: self.degree.max(other.degree) }
    }

    pub(super) fn with_cells(self, cells: usize) -> Self {
        Self { cells, ..self }
    }
}
