//! The medium that light meets: densities, detail below their voxels, and scattering.

pub mod detail;
pub mod field;
pub mod phase;
