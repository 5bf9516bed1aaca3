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
    /// Where densities cannot be sampled, and when the user wishes to stop.
    pub fn of(scene: &Scene, control: &Control) -> Result<Option<Self>> {
        let Some(detail) = &scene.detail else { return Ok(None) };
        let grids = sampled_densities(scene, &Options::default(), control)?;
        Ok(Some(Self { noise: FineDetail::new(detail, grids.iter()), footprint: scene.camera.footprint() }))
    }

    /// The factor of a density at a distance along a ray from the camera \[pc\].
    pub fn factor(&self, density: usize, ray: &Ray, t: f64) -> f64 {
        self.noise.factor(density, ray.at(t), self.footprint.at(t))
    }

    /// The length of the shortest waves \[pc\].
    pub fn finest_pc(&self) -> f64 {
        self.noise.octaves.last().map_or(f64::INFINITY, |octave| octave.wavelength_pc)
    }
}
