//! A plan on its way: what places and spectra decide, from which fields of light are made.

use std::sync::Arc;

use super::{Options, SpatialPlan, SpectralPlan};
use crate::detail::{FineDetail, Roughness};
use crate::light::Light;
use crate::scene::Scene;

/// A scene with the method in force, and what places and spectra have decided.
#[derive(Debug, Clone)]
pub(crate) struct Draft<'a> {
    pub scene: &'a Scene,
    pub options: &'a Options,
    /// The lights, in the order of all tables.
    pub lights: Arc<Vec<Light>>,
    /// Spatial part of the plan.
    pub space: Arc<SpatialPlan>,
    /// Spectral part of the plan.
    pub spectral: Arc<SpectralPlan>,
    /// Density detail below the voxel size, at native resolution.
    pub detail: Option<Arc<FineDetail>>,
}

/// Density detail of a scene below the voxel size of a space that is sampled at their own resolution.
pub(crate) fn detail(scene: &Scene, space: &SpatialPlan, known: &[Roughness]) -> Option<Arc<FineDetail>> {
    let grids = space.dust.iter().map(|dust| &**dust).chain(space.gas());
    scene.detail.as_ref().map(|detail| Arc::new(FineDetail::by(detail, grids, known)))
}
