//! A density as an eye sees it along a ray, with detail below its voxels.

use glam::DVec3;

use crate::backend::seen_detail::SeenDetail;
use crate::field::Field;
use crate::geometry::{Bounds, Ray};

/// A density, one of a scene's, along a ray of its camera.
#[derive(Debug)]
pub struct SeenField<'a> {
    pub field: &'a dyn Field,
    /// Which of the scene's densities it is.
    pub density: usize,
    pub detail: &'a SeenDetail,
    pub ray: &'a Ray,
    /// The length of the shortest waves that are seen \[pc\].
    pub finest_pc: f64,
}

impl Field for SeenField<'_> {
    fn at(&self, p: DVec3) -> f64 {
        let t = (p - self.ray.origin).dot(self.ray.direction);
        self.field.at(p) * self.detail.factor(self.density, self.ray, t)
    }
    fn bounds(&self) -> Bounds {
        self.field.bounds()
    }
    fn feature_pc(&self) -> f64 {
        self.field.feature_pc().min(0.5 * self.finest_pc)
    }
    fn crossings(&self, ray: &Ray, out: &mut Vec<f64>) {
        self.field.crossings(ray, out);
    }
}
