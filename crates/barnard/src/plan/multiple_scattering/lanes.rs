//! Eight terms side by side.

/// Terms that are swept side by side.
pub const WIDTH: usize = crate::volume::MAX_CHANNELS;
/// A number for each of them.
pub type EightLanes = [f32; WIDTH];
/// Fluence in the dust, for each of them.
pub type Powers = [f64; WIDTH];
