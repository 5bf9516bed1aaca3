//! Sources of the files of a scene: a folder, or what is compiled in.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use barnard::data::{Array, Choose, DataSource, TextTable};
use barnard::error::{Error, Result};
use barnard::memory;
use spectra::curve::Columns;

use crate::formats::{open, read_array, read_file, read_picture, replace, unreadable};
use crate::{columns, paths, text_table};

/// Files by name, each with what gives its bytes.
pub type Embedded = &'static [(&'static str, fn() -> &'static [u8])];

/// Bytes of a file in memory.
#[derive(Debug, Clone)]
enum FileBytes {
    Embedded(&'static [u8]),
    Given(Arc<[u8]>),
}

impl AsRef<[u8]> for FileBytes {
    fn as_ref(&self) -> &[u8] {
        match self {
            FileBytes::Embedded(bytes) => bytes,
            FileBytes::Given(bytes) => bytes,
        }
    }
}

/// The files that a scene names.
#[derive(Debug)]
pub struct SceneFiles {
    folder: PathBuf,
    embedded: Embedded,
    /// Files in memory by name; they hide those compiled in.
    given: Vec<(String, Arc<[u8]>)>,
    /// The files on disk that were read.
    read: Mutex<Vec<PathBuf>>,
    /// Names of those in memory that were read.
    unpacked: Mutex<Vec<String>>,
}

impl SceneFiles {
    /// Files are relative to `folder`.
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into(), embedded: &[], given: Vec::new(), read: Mutex::default(), unpacked: Mutex::default() }
    }

    /// Files are those compiled in.
    pub fn embedded(files: Embedded) -> Self {
        Self { embedded: files, ..Self::in_folder("") }
    }

    /// Variant with files in memory, each with its name in scenes.
    #[must_use]
    pub fn with_given(mut self, files: impl IntoIterator<Item = (String, Arc<[u8]>)>) -> Self {
        self.given.extend(files);
        self
    }

    /// True if a file is in memory.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.given.iter().any(|(known, _)| known == name) || self.embedded.iter().any(|(known, _)| *known == name)
    }

    /// The path that `name` stands for.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The files on disk that were read so far.
    pub fn read_files(&self) -> Vec<PathBuf> {
        self.read.lock().map(|read| read.clone()).unwrap_or_default()
    }

    /// The bytes that are in memory under `name`.
    fn unpack(&self, name: &str) -> Option<FileBytes> {
        let bytes = self.in_memory(name)?;
        if let Ok(mut unpacked) = self.unpacked.lock()
            && !unpacked.iter().any(|known| known == name)
        {
            unpacked.push(name.to_owned());
        }
        Some(bytes)
    }

    fn in_memory(&self, name: &str) -> Option<FileBytes> {
        if let Some((_, bytes)) = self.given.iter().find(|(known, _)| known == name) {
            return Some(FileBytes::Given(bytes.clone()));
        }
        self.embedded.iter().find(|(known, _)| *known == name).map(|(_, bytes)| FileBytes::Embedded(bytes()))
    }

    fn note(&self, path: PathBuf) {
        if let Ok(mut read) = self.read.lock()
            && !read.contains(&path)
        {
            read.push(path);
        }
    }

    /// Writes the files in memory that were read into `folder`, those that are not there yet.
    ///
    /// # Errors
    /// If one cannot be written, or another file stands in its place.
    pub fn write_embedded(&self, folder: &Path) -> Result<()> {
        let unpacked = self.unpacked.lock().map(|names| names.clone()).unwrap_or_default();
        for name in &unpacked {
            let (path, Some(bytes)) = (folder.join(name), self.in_memory(name)) else { continue };
            let bytes = bytes.as_ref();
            if path.exists() {
                let same = std::fs::metadata(&path).is_ok_and(|m| m.len() == bytes.len() as u64)
                    && std::fs::read(&path).is_ok_and(|found| found == bytes);
                if !same {
                    return Err(Error::file(&path, "already exists and differs from the scene's file; choose another folder"));
                }
            } else {
                let parent = path.parent().unwrap_or(folder);
                std::fs::create_dir_all(parent).map_err(|e| Error::file(parent, format!("cannot be made: {e}")))?;
                replace(&path, bytes)?;
            }
        }
        Ok(())
    }
}

impl DataSource for SceneFiles {
    fn label(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    fn text(&self, name: &str, memory_limit: u64) -> Result<Cow<'static, str>> {
        let no_text = || Error::file(self.path(name), "is not UTF-8 text");
        match self.unpack(name) {
            Some(FileBytes::Embedded(bytes)) => return std::str::from_utf8(bytes).map(Cow::Borrowed).map_err(|_| no_text()),
            Some(FileBytes::Given(bytes)) => return String::from_utf8(bytes.to_vec()).map(Cow::Owned).map_err(|_| no_text()),
            None => {}
        }
        String::from_utf8(self.bytes(name, memory_limit)?).map(Cow::Owned).map_err(|_| no_text())
    }

    fn bytes(&self, name: &str, memory_limit: u64) -> Result<Vec<u8>> {
        if let Some(bytes) = self.unpack(name) {
            return Ok(bytes.as_ref().to_vec());
        }
        let path = self.path(name);
        let bytes = read_limited(&path, memory_limit)?;
        self.note(path);
        Ok(bytes)
    }

    fn columns(&self, name: &str, memory_limit: u64) -> Result<Columns> {
        if let Some(bytes) = self.unpack(name) {
            return columns::read(name, bytes.as_ref(), memory_limit);
        }
        columns::read(name, &self.bytes(name, memory_limit)?, memory_limit)
    }

    fn table(&self, name: &str, most_rows: usize, memory_limit: u64) -> Result<TextTable> {
        let (label, path) = (self.label(name), self.path(name));
        let made = |bytes: &[u8], read: fn(&paths::Request) -> Result<TextTable>| {
            let folder = Path::new(name).parent().unwrap_or(Path::new(""));
            let beside = |other: &str| {
                let path = self.path(&folder.join(other).to_string_lossy());
                let bytes = read_limited(&path, memory_limit)?;
                self.note(path);
                Ok(bytes)
            };
            read(&paths::Request { bytes, path: &path, beside: &beside, most_rows })
        };
        if let Some(bytes) = self.unpack(name) {
            return paths::reader(name)
                .map_or_else(|| text_table::read(&label, bytes.as_ref(), most_rows), |read| made(bytes.as_ref(), read));
        }
        if let Some(read) = paths::reader(name) {
            let table = made(&read_limited(&path, memory_limit)?, read)?;
            self.note(path);
            return Ok(table);
        }
        let (file, _) = open_limited(&path, memory_limit)?;
        let table = text_table::read(&label, BufReader::new(file), most_rows)?;
        self.note(path);
        Ok(table)
    }

    fn picture(&self, name: &str, hdu: Option<&str>, memory_limit: u64) -> Result<([usize; 2], Vec<f64>)> {
        let path = self.path(name);
        let picture = read_picture(&path, hdu, memory_limit)?;
        self.note(path);
        Ok(picture)
    }

    fn array(&self, name: &str, member: Option<&str>, choose: Choose, memory_limit: u64) -> Result<Array> {
        let path = self.path(name);
        if let Some(bytes) = self.unpack(name) {
            return read_array(Cursor::new(bytes), &path, member, choose, memory_limit);
        }
        let array = read_file(&path, member, choose, memory_limit)?;
        self.note(path);
        Ok(array)
    }
}

/// Opens a file after a look at its size; its size in bytes is given too.
fn open_limited(path: &Path, limit: u64) -> Result<(File, u64)> {
    let file = open(path)?;
    let length = file.metadata().map_err(|e| Error::file(path, format!("cannot be read: {e}")))?.len();
    memory::check(&format!("the file {}", path.display()), length, limit)?;
    Ok((file, length))
}

/// True if a path is a pipe, a terminal or a device: what can be read once, from its beginning.
pub(crate) fn is_stream(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// Reads a file after a look at its size, or a pipe to its end.
///
/// # Errors
/// If it is none, cannot be read, or has more than `limit` bytes.
pub fn read_limited(path: &Path, limit: u64) -> Result<Vec<u8>> {
    use std::io::Read;
    let failed = |e: std::io::Error| unreadable(path, &e);
    let mut bytes = Vec::new();
    if is_stream(path) {
        // A pipe does not tell how much will come.
        File::open(path).map_err(failed)?.take(limit + 1).read_to_end(&mut bytes).map_err(failed)?;
        memory::check(&format!("the text of {}", path.display()), bytes.len() as u64, limit)?;
        return Ok(bytes);
    }
    let (file, length) = open_limited(path, limit)?;
    bytes.reserve(length as usize);
    file.take(limit).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}
