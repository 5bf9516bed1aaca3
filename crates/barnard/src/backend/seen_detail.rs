//! Detail below voxels as a scene's camera sees it, for back ends that read the scene itself.

use crate::camera::Footprint;
use crate::control::Control;
use crate::detail::FineDetail;
use crate::error::Result;
use crate::geometry::Ray;
use crate::plan::{Options, sampled_densities};
use crate::scene::Scene;

/// The noise of a scene as its camera sees it.
#[derive(Debug, Clone)]
pub struct SeenDetail {
    noise: FineDetail,
    footprint: Footprint,
}

impl SeenDetail {
    /// The noise that continues the densities of a scene, functions as plans sample them; none where it asks for none.
    ///
    /// # Errors
    /// If densities cannot be sampled, and on interruption by the user.
    pub fn of(scene: &Scene, options: &Options, control: &Control) -> Result<Option<Self>> {
        let Some(detail) = &scene.detail else { return Ok(None) };
        let grids = sampled_densities(scene, options, control)?;
        Ok(Some(Self { noise: FineDetail::new(detail, grids.iter()), footprint: scene.camera.footprint() }))
    }

    /// The factor of a density at a distance along a ray from the camera \[pc\].
    pub fn factor(&self, density: usize, ray: &Ray, t: f64) -> f64 {
        self.noise.factor(density, ray.at(t), self.footprint.at(t))
    }

    /// Factor of a density that is rarely exceeded.
    pub fn usual_most(&self, density: usize) -> f64 {
        self.noise.usual_most(density)
    }

    /// The length of the shortest waves of a density that are seen from a distance \[pc\]; none where none are.
    pub fn finest_pc(&self, density: usize, distance_pc: f64) -> Option<f64> {
        self.noise.finest_pc(density, self.footprint.at(distance_pc))
    }
}
