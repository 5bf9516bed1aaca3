//! Error of a cloud that cannot be solved.

/// Problem and remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IonisationError {
    /// The densities are not as many as the voxels.
    #[error("{found} densities for {} x {} x {} voxels: there is one for each, x fastest", dims[0], dims[1], dims[2])]
    Length {
        /// Number of densities.
        found: usize,
        /// Voxels along x, y and z.
        dims: [usize; 3],
    },
    /// A density that no gas has.
    #[error("the density of hydrogen in voxel {voxel:?} is {value} cm-3: densities are finite, not negative, and at most 1e12 cm-3")]
    Density {
        /// Index of the voxel along x, y and z.
        voxel: [usize; 3],
        /// Density of hydrogen \[cm⁻³\].
        value: f32,
    },
    /// A box without a size.
    #[error("the voxels have edges of {0} pc: they are finite and above zero")]
    Voxel(glam::DVec3),
    /// An abundance that no gas has.
    #[error("there are {value} nuclei of {element} for one of hydrogen: hydrogen has 1, helium 0 to 10, a metal 0 to 0.1")]
    Abundance {
        /// The element's symbol.
        element: &'static str,
        /// Abundance by number relative to hydrogen.
        value: f64,
    },
    /// Dust that no gas has.
    #[error("dust absorbs {0} cm2 for a nucleus of hydrogen: that is finite and not negative")]
    Dust(f64),
    /// Lights in nodes of their own.
    #[error("star {0} has nodes of photon energy that the first has not: make the light of all stars by IonisingLight::several")]
    Nodes(usize),
    /// A star that is nowhere.
    #[error("star {star} is at {place} pc: coordinates are finite")]
    Place {
        /// Which star.
        star: usize,
        /// Stated position.
        place: glam::DVec3,
    },
    /// More than there may be.
    #[error("{stars} stars in {cells} voxels take {bytes} bytes, {limit} are allowed: fewer voxels or stars take less")]
    Memory {
        /// Stars.
        stars: usize,
        /// Voxels.
        cells: usize,
        /// Required memory \[bytes\].
        bytes: u64,
        /// Memory limit \[bytes\].
        limit: u64,
    },
    /// Somebody has had enough.
    #[error("stopped before the gas was solved")]
    Stopped,
}
