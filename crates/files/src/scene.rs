//! Scene files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use barnard::error::{Error, Result};
use barnard::properties::Table;
use barnard::scene::{Loader, Provenance, Scene};
use barnard::sequence::Sequence;

use crate::source::{SceneFiles, read_limited};
use crate::toml;

/// The bytes of the longest scene file that is read.
const LONGEST: u64 = 4 << 20;

/// A scene, and what it was read from: for frames of one that changes.
#[derive(Debug, Clone)]
pub struct SceneFile {
    /// The scene; at its first moment, where it changes.
    pub scene: Scene,
    tree: Table,
    loader: Loader,
}

impl SceneFile {
    /// Reads the scene file at `path` by a loader that was `prepared`; arrays may take `memory_limit` bytes each.
    ///
    /// # Errors
    /// Those of [`load_by`].
    pub fn open(path: &Path, memory_limit: u64, prepared: impl FnOnce(&Loader) -> Loader) -> Result<Self> {
        let text = read_text(path)?;
        let files = Arc::new(SceneFiles::in_folder(path.parent().unwrap_or(Path::new(""))));
        let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let mut file = Self::parse(&path.display().to_string(), &name, text, prepared(&Loader::new(files.clone(), memory_limit)))?;
        if let Some(provenance) = &mut file.scene.provenance {
            provenance.files = std::iter::once(path.to_owned()).chain(files.read_files()).collect();
        }
        Ok(file)
    }

    /// Reads a scene from its text; `file` is its name in messages, `name` the scene's default name.
    ///
    /// # Errors
    /// Those of [`load_by`].
    pub fn parse(file: &str, name: &str, text: String, loader: Loader) -> Result<Self> {
        let tree = toml::properties(file, &text)?;
        let mut scene = Scene::from_properties(&tree, name, &loader)?;
        scene.provenance = Some(Provenance { text: text.into(), files: Vec::new() });
        Ok(Self { scene, tree, loader })
    }

    /// The frames of the scene, where it changes.
    ///
    /// # Errors
    /// Where nothing of it does.
    pub fn sequence(&self) -> Result<Sequence> {
        Sequence::new(self.tree.clone(), self.loader.clone(), &self.scene)
    }
}

/// Reads the scene file at `path`; arrays may take `memory_limit` bytes each.
///
/// # Errors
/// Where the file cannot be read or is no scene; file, line and key are said.
pub fn load(path: &Path, memory_limit: u64) -> Result<Scene> {
    load_by(path, memory_limit, Loader::clone)
}

/// The same by a loader that was `prepared`, with a control that hears of it and can stop it, or with a device.
///
/// # Errors
/// Those of [`load`], and once the user wished to stop.
pub fn load_by(path: &Path, memory_limit: u64, prepared: impl FnOnce(&Loader) -> Loader) -> Result<Scene> {
    Ok(SceneFile::open(path, memory_limit, prepared)?.scene)
}

/// The text of the scene file at `path`.
///
/// # Errors
/// Where it cannot be read, or is too long or no UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    let bytes = read_limited(path, LONGEST)?;
    String::from_utf8(bytes).map_err(|_| Error::file(path, "is no text in UTF-8; a scene is a TOML file"))
}

/// Reads a scene from its text; `file` is its name in messages, `name` the scene's default name.
///
/// # Errors
/// Those of [`load`].
pub fn parse(file: &str, name: &str, text: String, loader: &Loader) -> Result<Scene> {
    Ok(SceneFile::parse(file, name, text, loader.clone())?.scene)
}

/// The loader that reads the files which scenes in `folder` name.
pub fn in_folder(folder: impl Into<PathBuf>, memory_limit: u64) -> Loader {
    Loader::new(Arc::new(SceneFiles::in_folder(folder)), memory_limit)
}
