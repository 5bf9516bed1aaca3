//! What can go wrong on a graphics processor.

/// One variant for each thing that a user can do something about.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// In the renderer, or the user's wish to stop.
    #[error(transparent)]
    Render(#[from] barnard::Error),
    /// There is nothing to render on.
    #[error("no graphics adapter was found; take --backend cpu, or install a driver (Mesa's mesa-vulkan-drivers renders in software)")]
    NoAdapter,
    /// An adapter that does not open.
    #[error("the adapter \"{0}\" cannot be used: {1}; take --backend cpu")]
    Device(String, String),
    /// A method that no shader has.
    #[error(
        "method \"{0}\" does not run on the GPU yet; take --backend cpu, or a method of exponentials: band_quadrature, gauss_legendre, newton, fixed_wavelength"
    )]
    Method(String),
    /// More than the device holds.
    #[error("{what} is {size}, this device takes at most {most}; {instead}")]
    TooLarge {
        /// What.
        what: String,
        /// How large it is.
        size: u64,
        /// How large it may be.
        most: u64,
        /// What would fit.
        instead: String,
    },
    /// The device stopped answering, or ran out of memory.
    #[error("the device gave up: {0}; take --backend cpu, or a smaller grid")]
    Lost(String),
}

/// Result of this crate.
pub type Result<T> = std::result::Result<T, GpuError>;
