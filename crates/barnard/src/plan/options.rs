//! Options of plans that are not part of a scene.

use std::sync::Arc;

use crate::cache::Cache;
use crate::memory;
use crate::plan::multiple_scattering::sweeper::Sweeper;

/// Options of a plan that are not part of the scene.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Options {
    /// Most bytes a plan may take.
    pub memory_limit: u64,
    /// The device that sweeps light of more than one scattering; the processor where there is none.
    pub sweeper: Option<Arc<dyn Sweeper>>,
    /// Most voxels of star depths along one of dust.
    pub star_depth_voxels: usize,
    /// Cache of results between runs: sampled densities, multiple scattering and settings of films.
    pub cache: Option<Arc<dyn Cache>>,
}

impl Default for Options {
    /// Everything on the processor alone, within the default limit of memory.
    fn default() -> Self {
        Self { memory_limit: memory::DEFAULT_LIMIT, sweeper: None, star_depth_voxels: usize::MAX, cache: None }
    }
}

impl Options {
    /// Everything on the processor, with a memory limit \[bytes\].
    pub fn within(memory_limit: u64) -> Self {
        Self { memory_limit, ..Self::default() }
    }

    /// Options with a device for multiple scattering; none for the processor.
    #[must_use]
    pub fn with_sweeper(self, sweeper: Option<Arc<dyn Sweeper>>) -> Self {
        Self { sweeper, ..self }
    }

    /// Options with a cache of results between runs.
    #[must_use]
    pub fn with_cache(self, cache: Option<Arc<dyn Cache>>) -> Self {
        Self { cache, ..self }
    }

    /// Options with another limit of star-depth voxels per dust voxel edge.
    #[must_use]
    pub fn with_star_depth_voxels(self, star_depth_voxels: usize) -> Self {
        Self { star_depth_voxels, ..self }
    }
}
