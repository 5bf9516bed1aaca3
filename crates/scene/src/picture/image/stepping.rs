//! Step lengths along a ray.

/// The spacing of the samples on a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stepping {
    /// So many samples in each voxel edge of the finest grid, between which densities are linear.
    PerVoxel(f64),
    /// So many segments in each voxel edge, each with a sample in its middle as well: densities are read twice as finely
    /// as light is shaded, behind the depth that the segment's light has in the mean.
    Paired(f64),
    /// So many samples on every ray.
    Fixed(usize),
}

/// Number of the kind of a stepping, and its samples.
pub type SteppingNumbers = (usize, f64);

impl Stepping {
    /// The stepping as numbers, for storage.
    pub fn to_numbers(self) -> SteppingNumbers {
        match self {
            Stepping::PerVoxel(samples) => (0, samples),
            Stepping::Paired(segments) => (1, segments),
            Stepping::Fixed(samples) => (2, samples as f64),
        }
    }

    /// The stepping of [numbers](Self::to_numbers); `None` for an unknown kind.
    pub fn from_numbers((kind, samples): SteppingNumbers) -> Option<Self> {
        match kind {
            0 => Some(Stepping::PerVoxel(samples)),
            1 => Some(Stepping::Paired(samples)),
            2 => Some(Stepping::Fixed(samples as usize)),
            _ => None,
        }
    }

    /// True if segments have a sample in their middle.
    pub fn has_middles(self) -> bool {
        matches!(self, Stepping::Paired(_))
    }

    /// Samples in a voxel edge, to tell finer ones from coarser; none are finer than those of a number for each ray.
    pub fn density(self) -> f64 {
        match self {
            Stepping::PerVoxel(n) => n,
            Stepping::Paired(n) => 2.0 * n,
            Stepping::Fixed(_) => f64::INFINITY,
        }
    }

    /// Segments along a length in parsecs.
    pub fn steps(self, length_pc: f64, voxel_pc: f64) -> usize {
        match self {
            Stepping::PerVoxel(n) | Stepping::Paired(n) => (length_pc / voxel_pc * n).ceil().max(1.0) as usize,
            Stepping::Fixed(n) => n,
        }
    }
}

impl std::fmt::Display for Stepping {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Stepping::PerVoxel(1.0) => write!(f, "1 sample per voxel"),
            Stepping::PerVoxel(n) => write!(f, "{n} samples per voxel"),
            Stepping::Paired(n) => write!(f, "{n} segments of two samples per voxel"),
            Stepping::Fixed(n) => write!(f, "{n} samples per ray"),
        }
    }
}
