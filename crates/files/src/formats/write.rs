//! Writing so that a killed render leaves no half file: to a temporary name in the same folder, then renamed.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::fits::encode_frame;
use super::{GridFile, extension, grid_writer, writer};
use barnard::error::{Error, Result};
use barnard::image::{Image, SaveOptions};
use barnard::instrument::Frame;

/// Checks that `path` can be written at all: the extension is known, the folder is there and writable. Programs ask
/// before a long render.
///
/// # Errors
/// If it cannot.
pub fn check_writable(path: &Path) -> Result<()> {
    writer(path)?;
    check_replaceable(path)
}

/// Checks that a file of this name could be written, and leaves alone what others are writing there.
///
/// # Errors
/// If the extension is not known, or there is no folder for it.
pub fn check_folder(path: &Path) -> Result<()> {
    writer(path)?;
    let folder = folder(path);
    let probe = tempfile::Builder::new().prefix(".barnard-probe-").tempfile_in(folder);
    match probe {
        _ if !folder.is_dir() => Err(Error::file(path, format!("the output folder {} does not exist; create it first", folder.display()))),
        Err(e) => Err(Error::file(path, format!("the output folder {} is not writable: {e}", folder.display()))),
        Ok(_) => Ok(()),
    }
}

/// Checks the same for a file of any extension.
///
/// # Errors
/// If it cannot be written.
pub fn check_replaceable(path: &Path) -> Result<()> {
    if std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        return Err(Error::file(path, "is not a regular file; choose another output"));
    }
    temporary(&target(path)?).map(drop)
}

/// The file that is written: a link stays a link, what it leads to is replaced.
fn target(path: &Path) -> Result<PathBuf> {
    if !path.is_symlink() {
        return Ok(path.to_owned());
    }
    let lost = |e: std::io::Error| Error::file(path, format!("is a broken link ({e}); remove it or choose another output"));
    std::fs::canonicalize(path).map_err(lost)
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn temporary(path: &Path) -> Result<tempfile::NamedTempFile> {
    let folder = folder(path);
    if !folder.is_dir() {
        return Err(Error::file(path, format!("the output folder {} does not exist; create it first", folder.display())));
    }
    if path.is_dir() {
        return Err(Error::file(path, "is a folder; give a file name"));
    }
    let start = start_of_temporaries(path);
    sweep(folder, &start);
    let mut builder = tempfile::Builder::new();
    // As any new file: the system takes away what the user's mask forbids.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
        .prefix(&format!("{start}{}-{}-", host(), std::process::id()))
        .tempfile_in(folder)
        .map_err(|e| Error::file(path, format!("the output folder {} is not writable: {e}", folder.display())))
}

/// Which machine this is, and which of its processes know each other's numbers: others may write into the same folder.
fn host() -> &'static str {
    static HOST: OnceLock<String> = OnceLock::new();
    HOST.get_or_init(|| {
        use std::hash::{Hash, Hasher};
        let boot = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
        let namespace = std::fs::read_link("/proc/self/ns/pid").map(|link| link.display().to_string()).unwrap_or_default();
        let mut hasher = std::hash::DefaultHasher::new();
        (boot, namespace).hash(&mut hasher);
        format!("{:08x}", hasher.finish() as u32)
    })
}

/// The beginning of the names of a file's temporaries; the machine and the number of the process that writes follow.
fn start_of_temporaries(path: &Path) -> String {
    const LONGEST: usize = 60;
    let name: String = path.file_name().map(|n| n.to_string_lossy().chars().take(LONGEST).collect()).unwrap_or_default();
    format!(".{name}.barnard-")
}

/// Removes what killed processes left of temporaries of the same file; whatever cannot be removed stays.
fn sweep(folder: &Path, start: &str) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        // Whether a process of another machine is gone, nobody here knows.
        let writer = name.strip_prefix(start).and_then(|rest| rest.strip_prefix(host())?.strip_prefix('-'));
        let process: Option<u32> = writer.and_then(|rest| rest.split('-').next()?.parse().ok());
        if process.is_some_and(is_gone) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// True if a process no longer runs; where a system does not tell, it may have ended.
fn is_gone(process: u32) -> bool {
    Path::new("/proc/self").exists() && !Path::new(&format!("/proc/{process}")).exists()
}

/// The saving of images to files.
pub trait SaveImage {
    /// Writes the image in the format of the path's extension, whole or not at all.
    ///
    /// # Errors
    /// If the extension is none of [`WRITERS`](super::WRITERS), or the file cannot be written.
    fn save(&self, path: impl AsRef<Path>, options: &SaveOptions) -> Result<()>;
}

impl SaveImage for Image {
    fn save(&self, path: impl AsRef<Path>, options: &SaveOptions) -> Result<()> {
        let path = path.as_ref();
        replace(path, &(writer(path)?.encode)(self, options)?)
    }
}

/// Writes a grid in the format of the path's extension, whole or not at all.
///
/// # Errors
/// If the extension is none of [`GRID_WRITERS`](super::GRID_WRITERS), or the file cannot be written.
pub fn save_grid(path: &Path, file: &GridFile) -> Result<()> {
    let write = grid_writer(path)?.write;
    replace_by(path, |out| {
        let mut out = BufWriter::with_capacity(1 << 18, out);
        let reason = |e: Error| match e {
            Error::Encoding { reason, .. } => std::io::Error::other(reason),
            other => std::io::Error::other(other.to_string()),
        };
        write(file, &mut out).map_err(reason)?;
        out.flush()
    })
}

/// Writes a frame of an instrument as FITS, whole or not at all.
///
/// # Errors
/// If the extension is another, or the file cannot be written.
pub fn save_frame(path: &Path, frame: &Frame) -> Result<()> {
    if extension(path) != "fits" {
        return Err(Error::file(path, "frames are FITS files; use a name such as raw_001.fits"));
    }
    replace(path, &encode_frame(frame))
}

/// Writes a file whole or not at all.
///
/// # Errors
/// If it cannot be written.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_by(path, |out| out.write_all(bytes))
}

/// Variant by what `write` writes.
pub(crate) fn replace_by(path: &Path, write: impl FnOnce(&mut tempfile::NamedTempFile) -> std::io::Result<()>) -> Result<()> {
    let failed = |e: std::io::Error| Error::file(path, format!("cannot be written, nothing was saved: {e}"));
    let target = target(path)?;
    let mut file = temporary(&target)?;
    write(&mut file).and_then(|()| file.as_file().sync_all()).map_err(failed)?;
    let replaced = std::fs::metadata(&target).map(|m| m.permissions());
    let file = file.persist(&target).map_err(|e| failed(e.error))?;
    replaced.map_or(Ok(()), |permissions| file.set_permissions(permissions).map_err(failed))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The next process that writes a file sweeps what a killed one left; what a living one writes, and anybody else's
    /// files, stay.
    #[test]
    #[cfg(target_os = "linux")]
    fn leftovers_are_swept() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        // Numbers of processes end below 2^22.
        let file_name = |host: &str, process: u32| format!(".out.npy.barnard-{host}-{process}-abc");
        let (dead, living, elsewhere) =
            (file_name(host(), 4_194_399), file_name(host(), std::process::id()), file_name("01234567", 4_194_399));
        let others = [".other.npy.barnard-4194399-abc", ".out.npy", "out.npy.barnard-4194399", living.as_str(), elsewhere.as_str()];
        for name in others.iter().chain([&dead.as_str()]) {
            std::fs::write(file(name), "x").unwrap();
        }
        replace(&file("out.npy"), b"whole").unwrap();
        assert_eq!(std::fs::read(file("out.npy")).unwrap(), b"whole");
        assert!(!file(&dead).exists() && others.iter().all(|name| file(name).exists()));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1 + others.len());
    }
}
