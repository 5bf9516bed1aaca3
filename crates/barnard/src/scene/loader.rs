//! Where a scene's files come from, and how large they may be.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, Weak};

use super::Star;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::formats::check_memory;

/// Memory that a scene may use unless told otherwise [bytes].
pub const DEFAULT_MEMORY: u64 = 16 << 30;

/// Tables of stars that are kept at most.
const MOST_TABLES: usize = 8;

/// Finds the files that a scene names.
#[derive(Debug)]
pub struct Loader {
    folder: PathBuf,
    read: Mutex<Vec<PathBuf>>,
    embedded: &'static [(&'static str, &'static [u8])],
    /// Names of those that were read.
    unpacked: Mutex<Vec<&'static str>>,
    fields: Mutex<HashMap<String, Weak<dyn Field>>>,
    stars: Mutex<HashMap<String, Arc<Vec<Star>>>>,
    /// Most bytes that one array or image may take.
    pub memory_limit: u64,
}

impl Loader {
    /// Files are relative to `folder`.
    pub fn in_folder(folder: impl Into<PathBuf>, memory_limit: u64) -> Self {
        Self::new(folder.into(), &[], memory_limit)
    }

    /// Files are those compiled in.
    pub fn embedded(files: &'static [(&'static str, &'static [u8])], memory_limit: u64) -> Self {
        Self::new(PathBuf::new(), files, memory_limit)
    }

    fn new(folder: PathBuf, embedded: &'static [(&'static str, &'static [u8])], memory_limit: u64) -> Self {
        Self {
            folder,
            embedded,
            memory_limit,
            read: Mutex::default(),
            unpacked: Mutex::default(),
            fields: Mutex::default(),
            stars: Mutex::default(),
        }
    }

    /// The path of `file`, for messages and extensions.
    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// The bytes of `file`.
    pub fn read(&self, file: &str) -> Result<Cow<'static, [u8]>> {
        if let Some((name, bytes)) = self.embedded.iter().find(|(name, _)| *name == file) {
            if let Ok(mut unpacked) = self.unpacked.lock() {
                unpacked.push(name);
            }
            return Ok(Cow::Borrowed(bytes));
        }
        let path = self.path(file);
        let bytes = read_limited(&path, self.memory_limit)?;
        if let Ok(mut read) = self.read.lock()
            && !read.contains(&path)
        {
            read.push(path);
        }
        Ok(Cow::Owned(bytes))
    }

    /// The field that `text` describes: the same one as before, as long as somebody holds it, or a new one. Files are not read again for it.
    pub(crate) fn field(&self, text: &str, build: impl FnOnce() -> Result<Arc<dyn Field>>) -> Result<Arc<dyn Field>> {
        let kept = self.fields.lock().ok().and_then(|fields| fields.get(text).and_then(Weak::upgrade));
        if let Some(field) = kept {
            return Ok(field);
        }
        let field = build()?;
        if let Ok(mut fields) = self.fields.lock() {
            fields.retain(|_, field| field.strong_count() > 0);
            fields.insert(text.to_owned(), Arc::downgrade(&field));
        }
        Ok(field)
    }

    /// The stars of the table that `text` describes: those of before, or new ones. The file is not read again for it.
    pub(super) fn stars(&self, text: &str, build: impl FnOnce() -> Result<Vec<Star>>) -> Result<Arc<Vec<Star>>> {
        let kept = self.stars.lock().ok().and_then(|stars| stars.get(text).cloned());
        if let Some(stars) = kept {
            return Ok(stars);
        }
        let built = Arc::new(build()?);
        if let Ok(mut stars) = self.stars.lock() {
            if stars.len() >= MOST_TABLES {
                stars.clear();
            }
            stars.insert(text.to_owned(), built.clone());
        }
        Ok(built)
    }

    /// Writes the files that are compiled in and were read into `folder`, those that are not there yet.
    ///
    /// # Errors
    /// Where one cannot be written.
    pub fn write_embedded(&self, folder: &Path) -> Result<()> {
        let unpacked = self.unpacked.lock().map(|names| names.clone()).unwrap_or_default();
        for (name, bytes) in self.embedded.iter().filter(|(name, _)| unpacked.contains(name)) {
            let path = folder.join(name);
            if path.exists() {
                let same = std::fs::metadata(&path).is_ok_and(|m| m.len() == bytes.len() as u64)
                    && std::fs::read(&path).is_ok_and(|own| own == *bytes);
                if !same {
                    return Err(Error::file(&path, "is there already and is another file than the scene's; choose another folder"));
                }
            } else {
                let parent = path.parent().unwrap_or(folder);
                std::fs::create_dir_all(parent).map_err(|e| Error::file(parent, format!("cannot be made: {e}")))?;
                crate::formats::replace(&path, bytes)?;
            }
        }
        Ok(())
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
