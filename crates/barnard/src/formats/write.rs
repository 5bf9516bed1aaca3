//! Writing so that a killed render leaves no half file: to a temporary name in the same folder, then renamed.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::writer;
use crate::error::{Error, Result};
use crate::image::{Display, Image};

/// Whether `path` can be written at all: known extension, folder there and writable. Asked before a long render.
pub fn check_writable(path: &Path) -> Result<()> {
    writer(path)?;
    check_replaceable(path)
}

/// The same for a file of any extension.
pub fn check_replaceable(path: &Path) -> Result<()> {
    if std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        return Err(Error::file(path, "is no plain file; it cannot be replaced by a picture"));
    }
    temporary(&target(path)?).map(drop)
}

/// The file that is written: a link stays a link, what it leads to is replaced.
fn target(path: &Path) -> Result<PathBuf> {
    if !path.is_symlink() {
        return Ok(path.to_owned());
    }
    let lost = |e: std::io::Error| Error::file(path, format!("is a link that leads to no file ({e}); remove it or name another output"));
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
        return Err(Error::file(path, "is a folder; give the name of a file in it"));
    }
    let mut builder = tempfile::Builder::new();
    // As any new file: the system takes away what the user's mask forbids.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
        .prefix(".barnard-")
        .tempfile_in(folder)
        .map_err(|e| Error::file(path, format!("the output folder {} cannot be written to: {e}", folder.display())))
}

/// Writes `image` in the format of the path's extension.
pub fn save(image: &Image, display: &Display, path: &Path) -> Result<()> {
    replace(path, &(writer(path)?.encode)(image, display)?)
}

/// Writes a file whole or not at all.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    let failed = |e: std::io::Error| Error::file(path, format!("cannot be written, nothing was kept: {e}"));
    let target = target(path)?;
    let mut file = temporary(&target)?;
    file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map_err(failed)?;
    let replaced = std::fs::metadata(&target).map(|m| m.permissions());
    let file = file.persist(&target).map_err(|e| failed(e.error))?;
    replaced.map_or(Ok(()), |permissions| file.set_permissions(permissions).map_err(failed))
}
