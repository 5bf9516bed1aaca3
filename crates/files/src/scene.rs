//! Scene files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use barnard::error::{Error, Result};
use barnard::properties::places::set;
use barnard::properties::{Table, Value};
use barnard::scene::{Loader, Provenance, Scene};
use barnard::sequence::Sequence;

use crate::source::{SceneFiles, is_stream, read_limited};
use crate::toml;

/// The bytes of the longest scene file that is read.
const LONGEST: u64 = 4 << 20;

/// A key of a scene, and what it says in place of what stands in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The place of the key, such as "star\[0\].temperature" or "star.0.temperature".
    pub key: String,
    /// New value of the key.
    pub value: Value,
}

impl std::str::FromStr for Change {
    type Err = String;

    /// Reads KEY=VALUE: the value as TOML, or as a text without quotes.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (key, value) =
            text.split_once('=').ok_or_else(|| format!("\"{text}\" is invalid; write KEY=VALUE, such as star[0].temperature=9000 K"))?;
        let (key, value) = (key.trim(), value.trim());
        let read = toml::properties("", &format!("value = {value}")).ok().and_then(|table| Some(table.get("value")?.value.clone()));
        Ok(Self { key: key.to_owned(), value: read.unwrap_or_else(|| Value::Text(value.to_owned())) })
    }
}

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
    /// If the file cannot be read or is no scene, and on interruption by the user; the error states file, line and key.
    pub fn open(path: &Path, memory_limit: u64, prepared: impl FnOnce(&Loader) -> Loader) -> Result<Self> {
        Self::open_with(path, &[], memory_limit, prepared)
    }

    /// Variant with other values of some keys, such as "star\[0\].temperature", in place of the file's.
    ///
    /// # Errors
    /// Errors of [`open`](Self::open), and if the scene can have no such key.
    pub fn open_with(path: &Path, changes: &[Change], memory_limit: u64, prepared: impl FnOnce(&Loader) -> Loader) -> Result<Self> {
        let text = read_text(path)?;
        // What a scene from a pipe names is in the working folder.
        let (folder, stem) = if is_stream(path) { (None, Some("scene".as_ref())) } else { (path.parent(), path.file_stem()) };
        let files = Arc::new(SceneFiles::in_folder(folder.unwrap_or(Path::new(""))));
        let name = stem.map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let loader = prepared(&Loader::new(files.clone(), memory_limit));
        let mut file = Self::parse_with(&path.display().to_string(), &name, text, changes, loader)?;
        let files = std::iter::once(path.to_owned()).chain(files.read_files()).collect();
        let provenance = file.scene.provenance.clone().map(|provenance| Provenance { files, ..provenance });
        file.scene = file.scene.with_provenance(provenance);
        Ok(file)
    }

    /// Reads a scene from its text; `file` is its name in messages, `name` the scene's default name.
    ///
    /// # Errors
    /// Errors of [`open`](Self::open).
    pub fn parse(file: &str, name: &str, text: String, loader: Loader) -> Result<Self> {
        Self::parse_with(file, name, text, &[], loader)
    }

    /// Variant with other values of some keys.
    ///
    /// # Errors
    /// Errors of [`parse`](Self::parse), and if the scene can have no such key.
    pub fn parse_with(file: &str, name: &str, mut text: String, changes: &[Change], loader: Loader) -> Result<Self> {
        let mut tree = toml::properties(file, &text)?;
        for Change { key, value } in changes {
            set(&mut tree, key, value.clone().into())
                .map_err(|reason| Error::conflict(format!("cannot set {key}: {reason}"), "check the key with docs/scene-format.md"))?;
        }
        if !changes.is_empty() {
            text = toml::text(&tree);
        }
        let scene = Scene::from_properties(&tree, name, &loader)?;
        let scene = scene.with_provenance(Provenance { text: text.into(), files: Vec::new() });
        Ok(Self { scene, tree, loader })
    }

    /// Scene that was read from a tree by a loader.
    pub fn of(scene: Scene, tree: Table, loader: Loader) -> Self {
        Self { scene, tree, loader }
    }

    /// The tree that the scene was read from, with the keys that were changed.
    pub fn tree(&self) -> &Table {
        &self.tree
    }

    /// Reader.
    pub fn loader(&self) -> &Loader {
        &self.loader
    }

    /// The frames of the scene, where it changes.
    ///
    /// # Errors
    /// If nothing of it does.
    pub fn sequence(&self) -> Result<Sequence> {
        Sequence::new(self.tree.clone(), self.loader.clone(), &self.scene)
    }
}

/// The text of the scene file at `path`.
///
/// # Errors
/// If it cannot be read, or is too long or no UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    let bytes = read_limited(path, LONGEST)?;
    String::from_utf8(bytes).map_err(|_| Error::file(path, "is not UTF-8 text; a scene must be a TOML file"))
}

/// Reads a scene from its text; `file` is its name in messages, `name` the scene's default name.
///
/// # Errors
/// Errors of [`SceneFile::open`].
pub fn parse(file: &str, name: &str, text: String, loader: &Loader) -> Result<Scene> {
    Ok(SceneFile::parse(file, name, text, loader.clone())?.scene)
}

/// The loader that reads the files which scenes in `folder` name.
pub fn in_folder(folder: impl Into<PathBuf>, memory_limit: u64) -> Loader {
    Loader::new(Arc::new(SceneFiles::in_folder(folder)), memory_limit)
}
