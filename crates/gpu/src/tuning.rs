//! Tuning options of a march on a device.

use barnard::scene::Scene;

/// The way in which a picture is made; all but `on_the_fly` leave the picture as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tuning {
    /// Rays of a workgroup, across and down.
    pub workgroup: (u32, u32),
    /// True if rays jump over empty bricks.
    pub skip_empty: bool,
    /// True if rays end where nothing behind can be seen.
    pub end_early: bool,
    /// True if rays pause, as they must in software; none: as the adapter needs it.
    pub pauses: Option<bool>,
    /// True if dust that is noise is evaluated at every sample and not read as it was sampled: another picture, by what
    /// a grid cannot show.
    pub on_the_fly: bool,
}

impl Tuning {
    /// The tuning that a scene asks for.
    pub fn of(scene: &Scene) -> Self {
        Self { on_the_fly: scene.method.backends.on_the_fly, ..Self::default() }
    }
}

impl Default for Tuning {
    fn default() -> Self {
        Self { workgroup: (8, 8), skip_empty: true, end_early: true, pauses: None, on_the_fly: false }
    }
}
