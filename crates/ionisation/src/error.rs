//! Error of a cloud that cannot be solved.

/// Problem and remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IonisationError {
    /// The densities are not as many as the voxels.
    #[error("{found} densities for {} x {} x {} voxels; give one per voxel, x fastest", dims[0], dims[1], dims[2])]
    Length {
        /// Number of densities.
        found: usize,
        /// Voxels along x, y and z.
        dims: [usize; 3],
    },
    /// A density that no gas has.
    #[error("the density of hydrogen in voxel {voxel:?} is {value} cm-3; it must be between 0 and 1e12 cm-3")]
    Density {
        /// Index of the voxel along x, y and z.
        voxel: [usize; 3],
        /// Density of hydrogen \[cm⁻³\].
        value: f32,
    },
    /// A box without a size.
    #[error("the voxels have edges of {0} pc; they must be finite and above zero")]
    Voxel(glam::DVec3),
    /// An abundance that no gas has.
    #[error(
        "the abundance of {element} is {value} per hydrogen nucleus; it must be 1 for hydrogen, 0 to 10 for helium, 0 to 0.1 for metals"
    )]
    Abundance {
        /// The element's symbol.
        element: &'static str,
        /// Abundance by number relative to hydrogen.
        value: f64,
    },
    /// Dust that no gas has.
    #[error("the cross section of dust is {0} cm2 per hydrogen nucleus; it must be finite and at least zero")]
    Dust(f64),
    /// Lights in nodes of their own.
    #[error("star {0} and the first star have different energy nodes; make the light of all stars with IonisingLight::several")]
    Nodes(usize),
    /// A star that is nowhere.
    #[error("the position of star {star}, {place} pc, must be finite")]
    Place {
        /// Which star.
        star: usize,
        /// Stated position.
        place: glam::DVec3,
    },
    /// More than there may be.
    #[error("{stars} stars in {cells} voxels need {bytes} bytes, the limit is {limit}; use fewer voxels or stars")]
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
    #[error("interrupted before the gas was solved")]
    Stopped,
}
