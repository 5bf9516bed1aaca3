//! Writing so that a killed render leaves no half file: to a temporary name in the same folder, then renamed.

use std::io::Write;
use std::path::Path;

use super::writer;
use crate::error::{Error, Result};
use crate::image::{Display, Image};

/// Whether `path` can be written at all: known extension, folder there and writable. Asked before a long render.
pub fn check_writable(path: &Path) -> Result<()> {
    writer(path)?;
    temporary(path).map(drop)
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
    tempfile::Builder::new()
        .prefix(".barnard-")
        .tempfile_in(folder)
        .map_err(|e| Error::file(path, format!("the output folder {} cannot be written to: {e}", folder.display())))
}

/// Writes `image` in the format of the path's extension.
pub fn save(image: &Image, display: &Display, path: &Path) -> Result<()> {
    let bytes = (writer(path)?.encode)(image, display)?;
    let failed = |e: std::io::Error| Error::file(path, format!("cannot be written, nothing was kept: {e}"));
    let mut file = temporary(path)?;
    file.write_all(&bytes).and_then(|()| file.as_file().sync_all()).map_err(failed)?;
    let mode = permissions(path);
    let file = file.persist(path).map_err(|e| failed(e.error))?;
    file.set_permissions(mode).map_err(failed)
}

/// Those of the file that is replaced; read by all, written by the owner, otherwise.
fn permissions(path: &Path) -> std::fs::Permissions {
    #[cfg(unix)]
    let fallback = std::os::unix::fs::PermissionsExt::from_mode(0o644);
    #[cfg(unix)]
    return std::fs::metadata(path).map_or(fallback, |m| m.permissions());
    #[cfg(not(unix))]
    return std::fs::metadata(path).map(|m| m.permissions()).expect("the file was persisted a moment ago");
}
