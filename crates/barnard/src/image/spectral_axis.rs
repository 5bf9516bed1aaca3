//! The spectral axis of a cube.

/// Channels of equal width in wavelength: the first bands of an image, in order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralAxis {
    /// The middle of the first channel \[µm\].
    pub first_um: f64,
    /// The width of a channel \[µm\].
    pub step_um: f64,
    /// The number of channels.
    pub count: usize,
}

impl SpectralAxis {
    /// The middle of a channel \[µm\].
    pub fn middle_um(&self, channel: usize) -> f64 {
        self.first_um + channel as f64 * self.step_um
    }
}
