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
    /// The wavelength of the line at rest that velocities are relative to, in vacuum \[µm\].
    pub rest_um: Option<f64>,
    /// λ over the full width at half maximum of a line; none where channels have sharp edges.
    pub resolving_power: Option<f64>,
}

impl SpectralAxis {
    /// The middle of a channel \[µm\].
    pub fn middle_um(&self, channel: usize) -> f64 {
        self.first_um + channel as f64 * self.step_um
    }
}
