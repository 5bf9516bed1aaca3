//! Bundles: a scene with all that its first picture requires, in one `.barnard` file.
//!
//! | entry of the zip archive | contents |
//! |---|---|
//! | `manifest.toml` | format, version, program, errors, and a row for each volume and record |
//! | `scene.toml` | the scene, whose densities are volumes of the archive |
//! | `source.toml` | the scene that it was made from |
//! | `preview.jpg` | a picture, shown until the first one is computed |
//! | `volumes/*` | densities as floats of a few bits |
//! | `records/*` | volumes of the solution of the gas |
//! | `files/*` | other files that the scene names, unchanged |
//!
//! Every entry carries the checksum of the archive (CRC-32). A changed scene uses the records where their inputs did not
//! change; all else is computed as usual.

mod archive;
mod bake;
mod collected;
mod html;
mod manifest;
pub(crate) mod predictor;
mod results;
mod volume;

use std::path::Path;
use std::sync::Arc;

use barnard::cache::Cache;
use barnard::control::Control;
use barnard::error::{Error, Result};
use barnard::scene::Loader;

pub use bake::{Baking, bake};
pub use manifest::{Errors, PictureErrors};
use results::GivenResult;
use volume::Volume;

use crate::scene::{Change, SceneFile};
use crate::source::SceneFiles;

/// Extension of the files.
pub const EXTENSION: &str = "barnard";

/// A scene with all that its first picture requires.
#[derive(Debug, Clone)]
pub struct Bundle {
    /// Name of the scene.
    pub name: String,
    /// Text of the scene.
    pub text: String,
    /// Text that the scene was made from.
    pub source: String,
    /// Picture as JPEG; empty for none.
    pub preview: Vec<u8>,
    /// Errors of the bundle relative to its source.
    pub errors: Errors,
    files: Vec<(String, Arc<[u8]>)>,
    volumes: Vec<Volume>,
    results: Vec<GivenResult>,
}

impl Bundle {
    /// True if a path has the extension of bundles.
    pub fn is_named_by(path: &Path) -> bool {
        path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION))
    }

    /// Files that the scene names.
    ///
    /// # Errors
    /// If a volume cannot be written as an array.
    pub fn files(&self) -> Result<Arc<SceneFiles>> {
        let array = |volume: &Volume| {
            let bytes = volume.npy().map_err(|e| Error::Encoding { format: "npy", reason: e.to_string() })?;
            Ok((format!("{}.npy", volume.name), bytes.into()))
        };
        let arrays: Vec<(String, Arc<[u8]>)> = self.volumes.iter().map(array).collect::<Result<_>>()?;
        Ok(Arc::new(SceneFiles::in_folder("").with_given(arrays.into_iter().chain(self.files.iter().cloned()))))
    }

    /// The scene.
    ///
    /// # Errors
    /// If the text is no scene, its arrays take more than `memory_limit` bytes each, or `control` stops the reading.
    pub fn scene(&self, memory_limit: u64, control: &Control) -> Result<SceneFile> {
        self.scene_with("scene.toml", &[], memory_limit, |loader| loader.under(control))
    }

    /// Variant with other values of some keys, by a loader that was `prepared`; `file` is the name of the text in messages.
    ///
    /// # Errors
    /// Errors of [`scene`](Self::scene), and if the scene can have no such key.
    pub fn scene_with(
        &self,
        file: &str,
        changes: &[Change],
        memory_limit: u64,
        prepared: impl FnOnce(&Loader) -> Loader,
    ) -> Result<SceneFile> {
        let loader = prepared(&Loader::new(self.files()?, memory_limit)).with_given(self.results());
        SceneFile::parse_with(file, &self.name, self.text.clone(), changes, loader)
    }

    /// Results of long computations.
    pub fn results(&self) -> Arc<dyn Cache> {
        results::cache(&self.results, &self.volumes)
    }
}
