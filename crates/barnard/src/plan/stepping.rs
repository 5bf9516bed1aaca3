//! How far the samples of a ray are apart.

/// The spacing of the samples on a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stepping {
    /// So many samples in each voxel edge of the finest grid.
    PerVoxel(f64),
    /// So many samples on every ray.
    Fixed(usize),
}

impl Stepping {
    /// Samples along so many parsecs.
    pub fn steps(self, length_pc: f64, voxel_pc: f64) -> usize {
        match self {
            Stepping::PerVoxel(n) => (length_pc / voxel_pc * n).ceil().max(1.0) as usize,
            Stepping::Fixed(n) => n,
        }
    }
}

impl std::fmt::Display for Stepping {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Stepping::PerVoxel(n) => write!(f, "{n} samples a voxel"),
            Stepping::Fixed(n) => write!(f, "{n} samples a ray"),
        }
    }
}
