//! Cache of results in a folder, shared by all processes of a user.
//!
//! A record is one file. Its name holds the kind, and a fingerprint of the inputs, the code and the instructions of the processor.
//! Files are written under another name and renamed, so that a killed process leaves no partial record, and carry a checksum. Once
//! their sizes exceed the limit, those used least recently are removed.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use barnard::cache::{Cache, Record};
use barnard::error::{Error, Result};
use spectra::fingerprint::{Digest, Fingerprint};

/// Environment variable with the folder of the cache; `off` for no cache.
pub const FOLDER: &str = "BARNARD_CACHE";
/// Environment variable with the limit of the cache in GiB.
pub const LIMIT: &str = "BARNARD_CACHE_SIZE";

/// Default limit [bytes].
const DEFAULT_LIMIT: u64 = 4 << 30;
/// Share of the limit that is left once files were removed, so that they are removed rarely.
const LEFT: f64 = 0.9;
/// Share of the limit above which a single record is not stored.
const LARGEST: f64 = 0.5;
/// Age at which the temporary file of a killed process is removed.
const ABANDONED: Duration = Duration::from_secs(3600);
/// First bytes of a record.
const MAGIC: &[u8; 8] = b"BARNARD1";
/// Hexadecimal digits of a checksum.
const DIGITS: usize = 32;
/// Extension of records.
const EXTENSION: &str = "record";
/// Beginning of the names of temporary files.
const TEMPORARY: &str = ".writing-";
/// Largest ratio that LZ4 compresses by.
const RATIO: usize = 256;

/// Cache in a folder.
#[derive(Debug)]
pub struct DiskCache {
    folder: PathBuf,
    limit: u64,
}

/// Records of one kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Usage {
    /// Kind of computation.
    pub kind: String,
    /// Number of records.
    pub records: usize,
    /// Size of their files \[bytes\].
    pub bytes: u64,
}

/// A record's file.
struct Entry {
    path: PathBuf,
    used: SystemTime,
    bytes: u64,
}

impl DiskCache {
    /// Cache in `folder` whose files take at most `limit` bytes. The folder is made with the first record.
    pub fn new(folder: impl Into<PathBuf>, limit: u64) -> Self {
        Self { folder: folder.into(), limit }
    }

    /// Cache of the user: in the folder `$BARNARD_CACHE`, or that of the platform, with at most `$BARNARD_CACHE_SIZE` GiB (default 4);
    /// `None` if `$BARNARD_CACHE` is `off` or there is no folder.
    ///
    /// # Errors
    /// If the limit is no positive number.
    pub fn of_user() -> Result<Option<Self>> {
        let limit = match std::env::var(LIMIT) {
            Err(_) => DEFAULT_LIMIT,
            Ok(text) => match text.trim().parse::<f64>() {
                Ok(gib) if gib > 0.0 && gib < 1e6 => (gib * (1u64 << 30) as f64) as u64,
                _ => return Err(Error::conflict(format!("{LIMIT}={text} is no size"), "give a positive number of GiB, such as 4")),
            },
        };
        let folder = match std::env::var_os(FOLDER) {
            Some(folder) if folder == "off" => None,
            Some(folder) if !folder.is_empty() => Some(PathBuf::from(folder)),
            _ => platform_folder().map(|folder| folder.join("barnard")),
        };
        Ok(folder.map(|folder| Self::new(folder, limit)))
    }

    /// Folder of the files.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Limit of the sizes of all files \[bytes\].
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// Records by kind.
    pub fn usage(&self) -> Vec<Usage> {
        let mut all: Vec<Usage> = Vec::new();
        for Entry { path, bytes, .. } in self.entries() {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let kind = name.rsplit_once('-').map_or("", |(kind, _)| kind);
            match all.iter_mut().find(|usage| usage.kind == kind) {
                Some(usage) => (usage.records, usage.bytes) = (usage.records + 1, usage.bytes + bytes),
                None => all.push(Usage { kind: kind.to_owned(), records: 1, bytes }),
            }
        }
        all.sort_by(|a, b| a.kind.cmp(&b.kind));
        all
    }

    /// Removes all records; other files of the folder stay.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn clear(&self) -> Result<()> {
        for Entry { path, .. } in self.entries() {
            match fs::remove_file(&path) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(Error::file(path, format!("cannot be removed: {e}"))),
                _ => {}
            }
        }
        Ok(())
    }

    fn entries(&self) -> Vec<Entry> {
        let entry = |entry: fs::DirEntry| {
            let path = entry.path();
            let metadata = entry.metadata().ok().filter(|_| path.extension().is_some_and(|extension| extension == EXTENSION))?;
            Some(Entry { path, used: metadata.modified().ok()?, bytes: metadata.len() })
        };
        fs::read_dir(&self.folder).into_iter().flatten().flatten().filter_map(entry).collect()
    }

    /// File of a record.
    fn path(&self, kind: &str, inputs: Fingerprint) -> PathBuf {
        let key = Digest::new("record").text(env!("BARNARD_CODE")).text(&processor()).part(inputs).finish();
        self.folder.join(format!("{kind}-{key}.{EXTENSION}"))
    }

    fn write(&self, path: &Path, record: &Record) -> std::io::Result<()> {
        let body = encoded(record);
        if body.len() as f64 > LARGEST * self.limit as f64 {
            return Ok(());
        }
        fs::create_dir_all(&self.folder)?;
        let mut file = tempfile::Builder::new().prefix(TEMPORARY).tempfile_in(&self.folder)?;
        file.write_all(MAGIC)?;
        file.write_all(checksum(&body).as_bytes())?;
        file.write_all(&body)?;
        file.persist(path)?;
        self.shrink();
        Ok(())
    }

    /// Removes what was used least recently beyond the limit, and temporary files of killed processes.
    fn shrink(&self) {
        let now = SystemTime::now();
        for entry in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let is_temporary = entry.file_name().to_string_lossy().starts_with(TEMPORARY);
            let age = entry.metadata().and_then(|metadata| metadata.modified()).ok().and_then(|at| now.duration_since(at).ok());
            if is_temporary && age.is_some_and(|age| age > ABANDONED) {
                let _ = fs::remove_file(entry.path());
            }
        }
        let mut entries = self.entries();
        let mut bytes: u64 = entries.iter().map(|entry| entry.bytes).sum();
        if bytes <= self.limit {
            return;
        }
        entries.sort_by_key(|entry| entry.used);
        for entry in entries {
            if bytes as f64 <= LEFT * self.limit as f64 {
                break;
            }
            // Another process may have removed it.
            let _ = fs::remove_file(entry.path);
            bytes -= entry.bytes;
        }
    }
}

impl Cache for DiskCache {
    fn get(&self, kind: &str, inputs: Fingerprint) -> Option<Record> {
        let path = self.path(kind, inputs);
        let file = fs::read(&path).ok()?;
        let record = file
            .strip_prefix(MAGIC)
            .and_then(|rest| rest.split_at_checked(DIGITS))
            .filter(|(digits, body)| *digits == checksum(body).as_bytes())
            .and_then(|(_, body)| decoded(body));
        match record {
            Some(record) => {
                let _ = fs::File::options().append(true).open(&path).and_then(|file| file.set_modified(SystemTime::now()));
                Some(record)
            }
            None => {
                let _ = fs::remove_file(&path);
                None
            }
        }
    }

    fn put(&self, kind: &str, inputs: Fingerprint, record: &Record) {
        let _ = self.write(&self.path(kind, inputs), record);
    }
}

/// The cache of the user, as a program hands it on.
///
/// # Errors
/// Errors of [`DiskCache::of_user`].
pub fn of_user() -> Result<Option<Arc<dyn Cache>>> {
    Ok(DiskCache::of_user()?.map(|cache| Arc::new(cache) as Arc<dyn Cache>))
}

/// Folder in which programs of the platform keep caches.
fn platform_folder() -> Option<PathBuf> {
    let absolute = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let below_home = |path: &str| std::env::home_dir().filter(|home| home.is_absolute()).map(|home| home.join(path));
    match std::env::consts::OS {
        "windows" => absolute("LOCALAPPDATA").or_else(|| below_home("AppData/Local")),
        "macos" => below_home("Library/Caches"),
        _ => absolute("XDG_CACHE_HOME").or_else(|| below_home(".cache")),
    }
}

/// Architecture, and instructions by which results may be rounded otherwise.
fn processor() -> String {
    #[cfg(target_arch = "x86_64")]
    let instructions = [is_x86_feature_detected!("fma"), is_x86_feature_detected!("avx2"), is_x86_feature_detected!("avx512f")];
    #[cfg(not(target_arch = "x86_64"))]
    let instructions = [false; 3];
    format!("{} {instructions:?}", std::env::consts::ARCH)
}

fn checksum(body: &[u8]) -> String {
    Digest::new("checksum").bytes(body).finish().to_string()
}

/// Bytes of a record: text, numbers and arrays, each behind its length; arrays as LZ4 blocks, in the order of bytes of the machine.
fn encoded(Record { text, numbers, arrays }: &Record) -> Vec<u8> {
    let mut body = Vec::new();
    let mut part = |count: usize, bytes: &[u8]| {
        body.extend((count as u64).to_le_bytes());
        body.extend((bytes.len() as u64).to_le_bytes());
        body.extend(bytes);
    };
    part(text.len(), text.as_bytes());
    part(numbers.len(), &numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>());
    for array in arrays {
        part(array.len(), &lz4_flex::block::compress(bytemuck::cast_slice(array)));
    }
    body
}

fn decoded(mut body: &[u8]) -> Option<Record> {
    let mut part = || -> Option<Option<(usize, &[u8])>> {
        if body.is_empty() {
            return Some(None);
        }
        let (count, rest) = body.split_first_chunk::<8>()?;
        let (length, rest) = rest.split_first_chunk::<8>()?;
        let (bytes, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
        body = rest;
        Some(Some((usize::try_from(u64::from_le_bytes(*count)).ok()?, bytes)))
    };
    let (_, text) = part()??;
    let (_, numbers) = part()??;
    let text = String::from_utf8(text.to_vec()).ok()?;
    let numbers = numbers.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let mut arrays = Vec::new();
    while let Some((count, packed)) = part()? {
        let size = count.checked_mul(4).filter(|size| size / RATIO <= packed.len())?;
        let mut array = vec![0.0f32; count];
        lz4_flex::block::decompress_into(packed, bytemuck::cast_slice_mut(&mut array)).ok().filter(|found| *found == size)?;
        arrays.push(array.into());
    }
    Some(Record { text, numbers, arrays })
}
