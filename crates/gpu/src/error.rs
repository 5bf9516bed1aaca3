//! Errors of a graphics processor.

/// One variant for each thing that a user can do something about.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// Failure of the renderer, or interruption by the user.
    #[error(transparent)]
    Render(#[from] barnard::Error),
    /// There is no graphics adapter to render on.
    #[error("no graphics adapter was found; render on the processor, or install a driver (Mesa's mesa-vulkan-drivers renders in software)")]
    NoAdapter,
    /// An adapter that does not open.
    #[error("the adapter \"{0}\" cannot be used: {1}; render on the processor")]
    Device(String, String),
    /// A method that no shader has.
    #[error("method \"{0}\" is not supported on the GPU; render on the processor or use another method, such as band_quadrature")]
    Method(String),
    /// A closed form whose terms cancel.
    #[error(
        "the polynomial of {light} in {band} cancels in single precision; render on the processor, or use a wider domain, a lower degree, or another method"
    )]
    Digits {
        /// The light whose terms cancel.
        light: String,
        /// The passband through which they do.
        band: String,
    },
    /// Dust that cannot be evaluated at every sample.
    #[error("--on-the-fly requires dust of a single field of kind \"fbm\"; remove it to sample other dust to a grid")]
    NoCloud,
    /// A star that there is not, or that has no depths on the device.
    #[error(
        "star number {0} of {1} has no depths on the device; they require dust, a method that reads star depths, and a star that is not aggregated"
    )]
    NoStar(usize, usize),
    /// A star whose depths, or the dust on the way, stand in pages.
    #[error("the depths of star number {0} are sparse and can only be computed on the processor; make a new plan")]
    InPages(usize),
    /// More than the device holds.
    #[error("{what} is {size}, this device supports at most {most}; {instead}")]
    TooLarge {
        /// The thing that is too large.
        what: String,
        /// The size of the thing.
        size: u64,
        /// The largest size that the device takes.
        most: u64,
        /// Alternative that fits.
        instead: String,
    },
    /// The device has no room.
    #[error(
        "the device has no memory for this plan of {}; use fewer voxels, or render on the processor",
        format_args!("{} MiB", .0.div_ceil(1 << 20))
    )]
    Memory(u64),
    /// A place that no star can be swept from.
    #[error("the star position {0:?} pc is unsupported on the device: {1}")]
    Place([f64; 3], &'static str),
    /// A display that is made for other bands.
    #[error("the display has columns for {0} bands, the picture has {1}")]
    Bands(usize, usize),
    /// The device was asked for something wrong, which is a fault of this program.
    #[error("internal error: the device rejected a command; render on the processor and report this: {0}")]
    Fault(String),
    /// The device stopped answering.
    #[error("the device failed: {0}; render on the processor")]
    Lost(String),
}

impl From<GpuError> for barnard::Error {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::Render(error) => error,
            other => barnard::Error::Device(Box::new(other)),
        }
    }
}

impl GpuError {
    /// An error where `size` is more than the device takes; `instead` says what would fit.
    pub(crate) fn too_large(what: &str, size: u64, most: u64, instead: impl Into<String>) -> Result<()> {
        if size > most { Err(GpuError::TooLarge { what: what.into(), size, most, instead: instead.into() }) } else { Ok(()) }
    }
}

/// The result of functions of this crate.
pub type Result<T> = std::result::Result<T, GpuError>;
