//! A density as an eye sees it along a ray, with detail below its voxels.

use glam::DVec3;

use crate::backend::seen_detail::SeenDetail;
use crate::field::Field;
use crate::geometry::{Bounds, Ray};

/// A density along a ray of a scene's camera.
#[derive(Debug)]
pub struct SeenField<'a> {
    pub field: &'a dyn Field,
    pub detail: &'a SeenDetail,
    pub ray: &'a Ray,
    /// The length of the shortest waves that are seen \[pc\].
    pub finest_pc: f64,
}

impl Field for SeenField<'_> {
    fn at(&self, p: DVec3) -> f64 {
        let t = (p - self.ray.origin).dot(self.ray.direction);
        self.field.at(self.detail.place(self.ray, t, &self.field.bounds()))
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
