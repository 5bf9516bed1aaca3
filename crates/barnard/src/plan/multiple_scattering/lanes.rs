//! Terms side by side: eight where they are kept, and as few as there are where they are swept.

/// Terms that are swept side by side.
pub const WIDTH: usize = crate::volume::MAX_CHANNELS;
/// A number for each of some terms.
pub type Lanes<const N: usize> = [f32; N];
/// A number for each of eight terms.
pub type EightLanes = Lanes<WIDTH>;
/// Fluence in the dust, for each of them.
pub type Powers = [f64; WIDTH];

/// The first of some lanes, or with others behind them that are dark.
pub fn resized<const N: usize, const M: usize>(lanes: &Lanes<N>) -> Lanes<M> {
    std::array::from_fn(|t| lanes.get(t).copied().unwrap_or(0.0))
}
