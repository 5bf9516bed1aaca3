//! Archive of a bundle.

use std::collections::HashMap;
use std::io::{Cursor, Read, Seek, Write};
use std::path::Path;
use std::sync::Arc;

use barnard::error::{Error, Result};
use barnard::memory;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::manifest::{self, VolumeRow};
use super::results::GivenResult;
use super::volume::Volume;
use super::{Bundle, EXTENSION};
use crate::formats::{open, replace};

const MANIFEST: &str = "manifest.toml";
const SCENE: &str = "scene.toml";
const SOURCE: &str = "source.toml";
const PREVIEW: &str = "preview.jpg";
const VOLUMES: &str = "volumes/";
const RECORDS: &str = "records/";
const FILES: &str = "files/";

/// Most bytes of a text.
const LONGEST_TEXT: u64 = 16 << 20;
/// Most factors of a volume, and most levels of products.
const MOST_FACTORS: usize = 4;
const DEEPEST_PRODUCT: usize = 3;
/// Most bytes of a preview.
const LARGEST_PREVIEW: u64 = 16 << 20;

impl Bundle {
    /// Writes the bundle, whole or not at all.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        replace(path, &self.encoded()?)
    }

    /// Bytes of the file.
    ///
    /// # Errors
    /// If an entry is too large for an archive.
    pub fn encoded(&self) -> Result<Vec<u8>> {
        self.written().map_err(|e| Error::Encoding { format: EXTENSION, reason: e.to_string() })
    }

    fn written(&self) -> std::io::Result<Vec<u8>> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let mut put = |name: &str, bytes: &[u8], is_packed: bool| {
            let method = if is_packed { CompressionMethod::Stored } else { CompressionMethod::Deflated };
            let level = (!is_packed).then_some(9);
            zip.start_file(name, SimpleFileOptions::default().compression_method(method).compression_level(level))?;
            zip.write_all(bytes)
        };
        let names: Vec<&str> = self.files.iter().map(|(name, _)| name.as_str()).collect();
        put(MANIFEST, manifest::written(&self.name, &self.errors, &self.volumes, &self.results, &names).as_bytes(), false)?;
        put(SCENE, self.text.as_bytes(), false)?;
        put(SOURCE, self.source.as_bytes(), false)?;
        put(PREVIEW, &self.preview, true)?;
        for volume in &self.volumes {
            put(&format!("{VOLUMES}{}", volume.name), &volume.encoded(), false)?;
        }
        for volume in self.results.iter().flat_map(|result| &result.volumes) {
            put(&format!("{RECORDS}{}", volume.name), &volume.encoded(), false)?;
        }
        for (name, bytes) in &self.files {
            put(&format!("{FILES}{name}"), bytes, false)?;
        }
        Ok(zip.finish()?.into_inner())
    }

    /// Reads a bundle; all of it may take `memory_limit` bytes.
    ///
    /// # Errors
    /// If the file is no bundle of a version that this program reads, is damaged, or takes more memory.
    pub fn open(path: &Path, memory_limit: u64) -> Result<Self> {
        Self::read(open(path)?, path, memory_limit)
    }

    /// Variant from bytes; `path` is their name in messages.
    ///
    /// # Errors
    /// Errors of [`open`](Self::open).
    pub fn read(source: impl Read + Seek, path: &Path, memory_limit: u64) -> Result<Self> {
        let zip = ZipArchive::new(source).map_err(|e| Error::file(path, format!("is not a .{EXTENSION} file: {e}")))?;
        Entries { zip, path, left: memory_limit }.bundle()
    }
}

/// Entries of an archive, and the bytes that more of them may take.
struct Entries<'a, R> {
    zip: ZipArchive<R>,
    path: &'a Path,
    left: u64,
}

impl<R: Read + Seek> Entries<'_, R> {
    /// Bytes of an entry, at most `limit` of them.
    fn bytes(&mut self, name: &str, limit: u64) -> Result<Vec<u8>> {
        let damaged = |reason: &dyn std::fmt::Display| Error::file(self.path, format!("{name}: {reason}; make the file again"));
        let entry = self.zip.by_name(name).map_err(|e| damaged(&e))?;
        let limit = limit.min(self.left);
        memory::check(&format!("{name} of {}", self.path.display()), entry.size(), limit)?;
        let mut bytes = Vec::new();
        // The stated size may be wrong.
        entry.take(limit + 1).read_to_end(&mut bytes).map_err(|e| damaged(&e))?;
        if bytes.len() as u64 > limit {
            return Err(damaged(&"it has more bytes than it states"));
        }
        self.left -= bytes.len() as u64;
        Ok(bytes)
    }

    fn text(&mut self, name: &str) -> Result<String> {
        String::from_utf8(self.bytes(name, LONGEST_TEXT)?).map_err(|_| Error::file(self.path, format!("{name} is not UTF-8 text")))
    }

    /// Refuses names that leave the folder into which files are saved.
    fn check_name(&self, name: &str) -> Result<()> {
        if Path::new(name).components().all(|part| matches!(part, std::path::Component::Normal(_))) {
            return Ok(());
        }
        Err(Error::file(self.path, format!("the file name \"{name}\" leaves the folder of the scene; remove it")))
    }

    /// A volume; `depths` has the levels of products of those before it, of which its values may be products.
    fn volume(&mut self, folder: &str, row: VolumeRow, depths: &mut HashMap<String, usize>) -> Result<Volume> {
        self.check_name(&row.name)?;
        let name = format!("{folder}{}", row.name);
        let levels: Option<Vec<usize>> = row.times.iter().map(|factor| depths.get(factor).copied()).collect();
        let depth = levels.map(|levels| levels.into_iter().map(|level| level + 1).max().unwrap_or(0));
        let Some(depth) = depth.filter(|depth| *depth <= DEEPEST_PRODUCT && row.times.len() <= MOST_FACTORS) else {
            return Err(Error::file(self.path, format!("{name} is a product of unknown or too many volumes; make the file again")));
        };
        if depths.insert(row.name.clone(), depth).is_some() {
            return Err(Error::file(self.path, format!("{name} occurs twice; make the file again")));
        }
        let planes = self.bytes(&name, u64::MAX)?;
        let volume = Volume::decoded(&row.name, row.shape, row.exponent, row.times, &planes);
        volume.ok_or_else(|| Error::file(self.path, format!("{name} does not have the shape {:?}; make the file again", row.shape)))
    }

    fn bundle(mut self) -> Result<Bundle> {
        let text = self.text(MANIFEST)?;
        let manifest = manifest::read(&format!("{}/{MANIFEST}", self.path.display()), &text)?;
        let mut depths = HashMap::new();
        let volumes = manifest.volumes.into_iter().map(|row| self.volume(VOLUMES, row, &mut depths)).collect::<Result<_>>()?;
        let mut results = Vec::new();
        for row in manifest.results {
            let volumes = row.volumes.into_iter().map(|volume| self.volume(RECORDS, volume, &mut depths)).collect::<Result<_>>()?;
            results.push(GivenResult { key: row.key, text: row.text, numbers: row.numbers, volumes });
        }
        let mut files: Vec<(String, Arc<[u8]>)> = Vec::new();
        for name in manifest.files {
            self.check_name(&name)?;
            let bytes = self.bytes(&format!("{FILES}{name}"), u64::MAX)?;
            files.push((name, bytes.into()));
        }
        Ok(Bundle {
            name: manifest.name,
            text: self.text(SCENE)?,
            source: self.text(SOURCE)?,
            preview: self.bytes(PREVIEW, LARGEST_PREVIEW)?,
            errors: manifest.errors,
            files,
            volumes,
            results,
        })
    }
}
