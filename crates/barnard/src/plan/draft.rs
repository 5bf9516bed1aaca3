//! A plan on its way: what is decided of it before its fields of light are made, and what those are made from.

use std::sync::Arc;

use crate::detail::{FineDetail, Roughness};
use crate::light::Light;
use crate::plan::{Settings, SpatialPlan, SpectralPlan};
use crate::scene::Scene;

/// A scene, the settings in force, and what places and spectra have decided.
#[derive(Debug, Clone)]
pub(crate) struct Draft<'a> {
    pub scene: &'a Scene,
    pub settings: &'a Settings,
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
