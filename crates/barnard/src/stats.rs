//! Render statistics: what the light of a job costs and reaches.

/// Measurements of a render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderStats {
    /// The largest optical depth, eye to sample to star, that was met \[1\]; NaN where a back end does not tell.
    pub depth: f64,
    /// Rays that were marched, or paths that were followed.
    pub rays: u64,
    /// Largest relative error of a density or a star's depth as the march keeps it: that of the
    /// [plan](crate::plan::Plan::storage), and [`HALF`](crate::plan::HALF) besides on a device.
    pub storage: f64,
    /// Values below zero, which a projection can make where little light is left.
    pub negative: u64,
}

impl RenderStats {
    /// Statistics of a back end that counts only rays.
    pub fn of_rays(rays: u64) -> Self {
        Self { depth: f64::NAN, rays, storage: 0.0, negative: 0 }
    }

    /// Sum of the measurements of two renders.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            // No number stays none.
            depth: if other.depth <= self.depth || self.depth.is_nan() { self.depth } else { other.depth },
            rays: self.rays + other.rays,
            storage: self.storage.max(other.storage),
            negative: self.negative + other.negative,
        }
    }
}
