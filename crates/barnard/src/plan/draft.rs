//! A plan on its way: what places and spectra decide, from which fields of light are made.

use std::sync::Arc;

use super::{Options, SpatialPlan, SpectralPlan};
use crate::detail::FineDetail;
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
    /// Detail below the voxel size.
    pub detail: Option<Arc<FineDetail>>,
}

/// Detail of a scene below the voxels of a space.
pub(crate) fn detail(scene: &Scene, space: &SpatialPlan) -> Option<Arc<FineDetail>> {
    let grids = space.dust.iter().map(|dust| &**dust).chain(space.gas());
    scene.detail.as_ref().map(|detail| Arc::new(FineDetail::new(detail, grids)))
}
