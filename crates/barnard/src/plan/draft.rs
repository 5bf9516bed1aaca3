//! A plan on its way: what is decided of it before its fields of light are made, and what those are made from.

use std::sync::Arc;

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
}
