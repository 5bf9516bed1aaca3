//! Back ends that stay open from picture to picture: a device, and the plan that lies on it.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use barnard::backend::{Backend, DeviceUse};
use barnard::{Result, Scene};
use barnard_cli::backends::registry;

/// The back ends that nobody works with at the moment, by name; none in the child of a fork.
static KEPT: Mutex<Option<HashMap<String, Box<dyn Backend>>>> = Mutex::new(None);

/// Does `work` with the back end of a name: one that is open, or another where somebody works with that.
///
/// # Errors
/// If there is none of this name, or its device does not open, and those of `work`.
pub fn with<T>(name: &str, scene: &Scene, work: impl FnOnce(&mut dyn Backend) -> Result<T>) -> Result<T> {
    let opened = KEPT.lock().unwrap_or_else(PoisonError::into_inner).as_mut().and_then(|backends| backends.remove(name));
    let registry = registry();
    let entry = registry.by_name(name)?;
    let mut backend = opened.map_or_else(|| (entry.open)(scene), Ok)?;
    let result = work(&mut *backend);
    // One whose device gave up is opened anew the next time.
    if entry.device != DeviceUse::Never && backend.device().is_none_or(|device| device.fallback().is_none() && device.warnings().is_empty())
    {
        KEPT.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_default().insert(name.into(), backend);
    }
    result
}

/// Forgets what is open, in the child of a fork: its devices belong to the parent.
pub fn after_fork() {
    if let Ok(mut backends) = KEPT.try_lock() {
        std::mem::forget(backends.take());
    }
}
