//! What a user of the renderer can put right.

use std::path::{Path, PathBuf};

use spectra::SpectraError;

/// Errors of this crate; each says what was wrong and what would be right, the place last.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Something in a scene file.
    #[error("{message} ({file}:{line}, {place})")]
    Scene {
        /// What is wrong and what would be right.
        message: String,
        /// The scene file.
        file: String,
        /// Line in it, from 1.
        line: usize,
        /// Table and key.
        place: String,
    },
    /// A data file that cannot be read or used.
    #[error("{reason} ({})", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// Values of a field that no density can have.
    #[error(
        "field \"{field}\" has {count} {what} of {cells} cells, the first at [{x}, {y}, {z}] = {value}; densities must be finite and not negative"
    )]
    FieldValues {
        /// The field's name.
        field: String,
        /// How many cells.
        count: usize,
        /// "negative cells", "cells that are NaN or infinite".
        what: &'static str,
        /// All cells.
        cells: usize,
        /// Index of the first.
        x: usize,
        /// Index of the first.
        y: usize,
        /// Index of the first.
        z: usize,
        /// Its value.
        value: f64,
    },
    /// More memory than allowed.
    #[error("{what} would need {needed_mib} MiB, the limit is {limit_mib} MiB; {advice}")]
    Memory {
        /// What would be allocated.
        what: String,
        /// Its size [MiB].
        needed_mib: u64,
        /// The limit [MiB].
        limit_mib: u64,
        /// What would fit.
        advice: String,
    },
    /// A spectrum, passband or law.
    #[error(transparent)]
    Spectra(#[from] SpectraError),
    /// A method that knows light of one scattering alone, asked for more.
    #[error("{0} scatters light once: write bounces = 1, or take {1}")]
    OneBounce(String, &'static str),
    /// A scene that cannot be rendered.
    #[error("{0}")]
    Render(String),
    /// Stopped by the user.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

impl Error {
    /// The error for `path`.
    pub fn file(path: impl AsRef<Path>, reason: impl Into<String>) -> Self {
        Error::File { path: path.as_ref().to_owned(), reason: reason.into() }
    }
}

/// Result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
