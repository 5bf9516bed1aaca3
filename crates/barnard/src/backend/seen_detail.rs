//! Detail below voxels as a scene's camera sees it, for back ends that read the scene itself.

use glam::DVec3;

use crate::camera::Footprint;
use crate::control::Control;
use crate::detail::FineDetail;
use crate::error::Result;
use crate::geometry::{Bounds, Ray};
use crate::plan::{Options, sampled_densities};
use crate::scene::Scene;

/// The displacement of a scene as its camera sees it.
#[derive(Debug, Clone)]
pub struct SeenDetail {
    noise: FineDetail,
    footprint: Footprint,
}

impl SeenDetail {
    /// The displacement of a scene, whose functions have the voxels of plans; none where it asks for none.
    ///
    /// # Errors
    /// If densities cannot be sampled, and on interruption by the user.
    pub fn of(scene: &Scene, options: &Options, control: &Control) -> Result<Option<Self>> {
        let Some(detail) = &scene.detail else { return Ok(None) };
        let grids = sampled_densities(scene, options, control)?;
        Ok(Some(Self { noise: FineDetail::new(detail, grids.iter()), footprint: scene.camera.footprint() }))
    }

    /// Displaced place at a distance along a ray from the camera \[pc\], within the bounds of a density, which continues beyond them.
    pub fn place(&self, ray: &Ray, t: f64, bounds: &Bounds) -> DVec3 {
        let place = ray.at(t);
        let displaced = place + self.noise.displacement(place, self.footprint.at(t));
        let inset = 1e-9 * bounds.size();
        if bounds.contains(place) { displaced.clamp(bounds.low + inset, bounds.high - inset) } else { place }
    }

    /// The length of the shortest waves that are seen from a distance \[pc\]; none where none are.
    pub fn finest_pc(&self, distance_pc: f64) -> Option<f64> {
        self.noise.finest_pc(self.footprint.at(distance_pc))
    }
}
