//! Terms side by side.

/// Terms that are kept side by side.
pub const WIDTH: usize = crate::volume::MAX_CHANNELS;
/// A number for each of eight terms.
pub type EightLanes = [f32; WIDTH];
/// Fluence in the dust, for each of them.
pub type Powers = [f64; WIDTH];
