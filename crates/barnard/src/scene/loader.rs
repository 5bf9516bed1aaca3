//! Where a scene's files come from, and how large they may be.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::error::{Error, Result};
use crate::formats::check_memory;

/// Memory that a scene may use unless told otherwise [bytes].
pub const DEFAULT_MEMORY: u64 = 16 << 30;

/// Finds the files that a scene names.
#[derive(Debug)]
pub struct Loader {
    folder: PathBuf,
    read: Mutex<Vec<PathBuf>>,
    embedded: &'static [(&'static str, &'static [u8])],
    /// Most bytes that one array or image may take.
    pub memory_limit: u64,
}

impl Loader {
    /// Files are relative to `folder`.
    pub fn in_folder(folder: impl Into<PathBuf>, memory_limit: u64) -> Self {
        Self { folder: folder.into(), read: Mutex::default(), embedded: &[], memory_limit }
    }

    /// Files are those compiled in.
    pub fn embedded(files: &'static [(&'static str, &'static [u8])], memory_limit: u64) -> Self {
        Self { folder: PathBuf::new(), read: Mutex::default(), embedded: files, memory_limit }
    }

    /// The path of `file`, for messages and extensions.
    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// The bytes of `file`.
    pub fn read(&self, file: &str) -> Result<Cow<'static, [u8]>> {
        if let Some((_, bytes)) = self.embedded.iter().find(|(name, _)| *name == file) {
            return Ok(Cow::Borrowed(bytes));
        }
        let path = self.path(file);
        let bytes = read_limited(&path, self.memory_limit)?;
        if let Ok(mut read) = self.read.lock() {
            read.push(path);
        }
        Ok(Cow::Owned(bytes))
    }

    /// The files on disk that were read so far.
    pub fn files(&self) -> Vec<PathBuf> {
        self.read.lock().map(|read| read.clone()).unwrap_or_default()
    }

    /// The text of `file`.
    pub fn read_text(&self, file: &str) -> Result<String> {
        String::from_utf8(self.read(file)?.into_owned()).map_err(|_| Error::file(self.path(file), "is no text in UTF-8"))
    }
}

/// Reads a file after a look at its size.
pub fn read_limited(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let failed = |e: std::io::Error| Error::file(path, format!("cannot be read: {e}"));
    let metadata = std::fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        return Err(Error::file(path, "is not a file"));
    }
    check_memory(&format!("the file {}", path.display()), metadata.len(), limit)?;
    std::fs::read(path).map_err(failed)
}
