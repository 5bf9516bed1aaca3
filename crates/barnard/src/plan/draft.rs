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
    /// What the places of things decide.
    pub space: Arc<SpatialPlan>,
    /// What spectra decide.
    pub spectral: Arc<SpectralPlan>,
    /// What densities have below their voxels, at their own resolution.
    pub detail: Option<Arc<FineDetail>>,
}

/// What the densities of a scene have below the voxels of a space that is sampled at their own resolution.
pub(crate) fn detail(scene: &Scene, space: &SpatialPlan, known: &[Roughness]) -> Option<Arc<FineDetail>> {
    let grids = space.dust.iter().map(|dust| &**dust).chain(space.gas());
    scene.detail.as_ref().map(|detail| Arc::new(FineDetail::by(detail, grids, known)))
}
