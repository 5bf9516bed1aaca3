//! Scenes of files: texts and bundles.

use std::path::Path;

use barnard::error::Result;
use barnard::scene::{Loader, Provenance, Scene};

use crate::bundle::Bundle;
use crate::scene::{Change, SceneFile};

/// Reads the scene at `path`, a text or a bundle by its extension; arrays may take `memory_limit` bytes each.
///
/// # Errors
/// If the file cannot be read or is no scene; the error states file, line and key.
pub fn load(path: &Path, memory_limit: u64) -> Result<Scene> {
    load_by(path, memory_limit, Loader::clone)
}

/// Variant by a loader that was `prepared`, with a control for progress and interruption, or with a device.
///
/// # Errors
/// Errors of [`load`], and on interruption by the user.
pub fn load_by(path: &Path, memory_limit: u64, prepared: impl FnOnce(&Loader) -> Loader) -> Result<Scene> {
    Ok(open_with(path, &[], memory_limit, prepared)?.scene)
}

/// Variant with what the scene was read from, and with other values of some keys, such as "star\[0\].temperature".
///
/// # Errors
/// Errors of [`load_by`], and if the scene can have no such key.
pub fn open_with(path: &Path, changes: &[Change], memory_limit: u64, prepared: impl FnOnce(&Loader) -> Loader) -> Result<SceneFile> {
    if !Bundle::is_named_by(path) {
        return SceneFile::open_with(path, changes, memory_limit, prepared);
    }
    let mut file = Bundle::open(path, memory_limit)?.scene_with(&path.display().to_string(), changes, memory_limit, prepared)?;
    let provenance = file.scene.provenance.clone().map(|provenance| Provenance { files: vec![path.to_owned()], ..provenance });
    file.scene = file.scene.with_provenance(provenance);
    Ok(file)
}
