//! Back ends of a studio: on the processor, or on a device that is lent.

use std::sync::Arc;

use barnard::Result;
use barnard::backend::{Backend, BackendEntry};
use barnard::plan::ordinates::Sweeper;
use barnard::scene::Scene;

/// A device that is lent to a studio.
pub struct LentDevice {
    /// Opens a back end on it.
    pub backend: Box<dyn Fn() -> Box<dyn Backend> + Send>,
    /// Sweeps light of more than one scattering on it, where that is faster.
    pub sweeper: Option<Arc<dyn Sweeper>>,
}

/// The maker of back ends, one for each kind of plan of each view.
pub(super) struct Opener {
    /// The one where there is no device.
    pub backend: BackendEntry,
    /// The device that pictures are rendered on.
    pub device: Option<LentDevice>,
}

impl Opener {
    /// The back end that is kept, or one that is opened now.
    pub fn backend_in<'a>(&self, slot: &'a mut Option<Box<dyn Backend>>, scene: &Scene) -> Result<&'a mut dyn Backend> {
        let backend = match (slot.take(), &self.device) {
            (Some(backend), _) => backend,
            (None, None) => (self.backend.open)(scene)?,
            (None, Some(device)) => (device.backend)(),
        };
        Ok(&mut **slot.insert(backend))
    }
}
