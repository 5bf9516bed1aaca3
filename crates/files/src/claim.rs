//! Claims: who writes which file, where several processes share a folder.
//!
//! A claim is a lock on a hidden file beside the one that is to be written. The system lets go of it when its process ends,
//! however it ends.

use std::fs::File;
use std::path::{Path, PathBuf};

use barnard::error::{Error, Result};

/// The right to write one file, until it is dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    /// The lock; none where the folder's file system knows none.
    lock: Option<File>,
}

impl Claim {
    /// Claims the file at `path`; none where another process has.
    ///
    /// # Errors
    /// If nothing can be written beside it.
    pub fn of(path: &Path) -> Result<Option<Self>> {
        let claim_path = beside(path);
        for _ in 0..TRIES {
            let open = File::options().create(true).truncate(false).write(true).open(&claim_path);
            let file = open.map_err(|e| Error::file(&claim_path, format!("cannot be written: {e}")))?;
            match file.try_lock() {
                Ok(()) if is_at(&file, &claim_path) => return Ok(Some(Self { path: claim_path, lock: Some(file) })),
                // Whoever had it has taken it away in between.
                Ok(()) => {}
                Err(std::fs::TryLockError::WouldBlock) => return Ok(None),
                Err(std::fs::TryLockError::Error(_)) => return Ok(Some(Self { path: claim_path, lock: None })),
            }
        }
        Ok(None)
    }

    /// Takes away what a killed process left of its claim of a file that is there.
    pub fn sweep(path: &Path) {
        if beside(path).exists() {
            // Whoever has it still takes it away himself.
            drop(Self::of(path));
        }
    }

    /// True if a lock keeps others from claiming the same: some file systems know none.
    pub fn is_locked(&self) -> bool {
        self.lock.is_some()
    }
}

/// Attempts at a claim that other processes remove meanwhile.
const TRIES: usize = 100;

/// The file whose lock is the claim.
fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    path.with_file_name(format!(".{name}.claim"))
}

impl Drop for Claim {
    fn drop(&mut self) {
        // It may be gone.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// True if an open file is the one at a path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (held_file, there) = (file.metadata(), std::fs::metadata(path));
    held_file.is_ok_and(|meta| there.is_ok_and(|there| (meta.dev(), meta.ino()) == (there.dev(), there.ino())))
}

/// An open file cannot be taken away where it is not Unix.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file is claimed once, again when the claim is gone, and nothing of it stays.
    #[test]
    fn a_file_is_claimed_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let claim = Claim::of(&path).unwrap();
        assert!(claim.is_some() && Claim::of(&path).unwrap().is_none() && Claim::of(&folder.path().join("b.exr")).unwrap().is_some());
        drop(claim);
        assert!(Claim::of(&path).unwrap().is_some_and(|claim| claim.is_locked()));
        std::fs::write(beside(&path), "").unwrap();
        Claim::sweep(&path);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(Claim::of(&folder.path().join("no/a.exr")).unwrap_err().to_string().contains("cannot be written"));
    }
}
