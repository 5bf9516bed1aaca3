//! The place that a scene is from.

use std::path::PathBuf;

use barnard_files::bundle::Bundle;

/// The place that a document is from.
#[derive(Debug, Clone, PartialEq)]
pub enum Origin {
    /// A built-in scene of this name.
    Builtin(&'static str),
    /// A file at this path.
    File(PathBuf),
    /// A bundle at this path.
    Bundle(PathBuf),
    /// A text of this name, without a file.
    Text(String),
}

impl Origin {
    /// The file at a path: a bundle or a scene, by its extension.
    pub fn at(path: PathBuf) -> Self {
        if Bundle::is_named_by(&path) { Self::Bundle(path) } else { Self::File(path) }
    }

    /// The name for titles.
    pub fn name(&self) -> String {
        match self {
            Origin::Builtin(name) => (*name).to_owned(),
            Origin::Text(name) => name.clone(),
            Origin::File(path) | Origin::Bundle(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        }
    }

    /// The name in messages, and that of a scene that states none.
    pub(crate) fn names(&self) -> (String, String) {
        match self {
            Origin::Builtin(name) => (format!("built-in {name}"), (*name).to_owned()),
            Origin::Text(name) => (name.clone(), name.clone()),
            Origin::File(path) | Origin::Bundle(path) => {
                (path.display().to_string(), path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default())
            }
        }
    }
}
