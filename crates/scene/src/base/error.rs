//! Errors that a user of the renderer can correct.

use std::path::{Path, PathBuf};

use spectra::SpectraError;

use crate::place::Place;

/// Errors of this crate; each says what was wrong and what would be right, the place last.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Something in a scene is wrong.
    #[error("{message} ({place})")]
    Scene {
        /// Problem and remedy.
        message: String,
        /// Location: file and line of a text, or table and key.
        place: Place,
    },
    /// An argument that no object can be made of.
    #[error("{what}: {said} is not {wanted}")]
    Value {
        /// Kind of value, such as an albedo.
        what: &'static str,
        /// The value that was given.
        said: String,
        /// The values that would be right.
        wanted: String,
    },
    /// A box that numbers cannot live in.
    #[error("{0}")]
    Bounds(String),
    /// A data file that cannot be read or used.
    #[error("{reason} ({})", path.display())]
    File {
        /// The path of the file.
        path: PathBuf,
        /// Problem and remedy.
        reason: String,
    },
    /// Values of a field that no density can have.
    #[error(
        "field \"{field}\" has {count} {what} of {cells} cells, the first at [{x}, {y}, {z}] = {value}; densities must be finite and not negative"
    )]
    FieldValues {
        /// The name of the field.
        field: String,
        /// The number of bad cells.
        count: usize,
        /// "negative cells", "cells that are NaN or infinite".
        what: &'static str,
        /// The number of all cells.
        cells: usize,
        /// The index of the first bad cell along x.
        x: usize,
        /// The index of the first bad cell along y.
        y: usize,
        /// The index of the first bad cell along z.
        z: usize,
        /// The value of that cell.
        value: f64,
    },
    /// Something would take more memory than is allowed.
    #[error("{what} would need {needed_mib} MiB, the limit is {limit_mib} MiB; use a smaller grid or image, or raise the memory limit")]
    Memory {
        /// Requested allocation.
        what: String,
        /// The size of that \[MiB\].
        needed_mib: u64,
        /// The limit that is in force \[MiB\].
        limit_mib: u64,
    },
    /// A spectrum, passband or law.
    #[error(transparent)]
    Spectra(#[from] SpectraError),
    /// A method that knows light of one scattering alone, asked for more.
    #[error("{0} scatters light once: write bounces = 1, or take {1}")]
    OneBounce(String, &'static str),
    /// Light or density beyond what single precision holds.
    #[error("{0}; check the unit of its brightness, and the scales of densities")]
    Strength(String),
    /// A star whose light does not get out, or that stands nowhere.
    #[error("{0}")]
    Star(String),
    /// More stars in the star field than are drawn.
    #[error("the star field has {in_view:.1e} stars in view; at most {most:.0e} are drawn, lower its density")]
    StarField {
        /// The expected number of stars in view.
        in_view: f64,
        /// The largest number that is drawn.
        most: f64,
    },
    /// A density that no path can be followed through.
    #[error("{0}")]
    Density(String),
    /// The spectral method cannot do what the scene asks of it.
    #[error("{0}")]
    Method(String),
    /// An image that does not fit into a format.
    #[error("cannot encode .{format}: {reason}")]
    Encoding {
        /// The extension of the format's files.
        format: &'static str,
        /// Why the format cannot hold it.
        reason: String,
    },
    /// A device that a back end renders on.
    #[error(transparent)]
    Device(Box<dyn std::error::Error + Send + Sync>),
    /// The user stopped the work.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// The error for `what`, given as `said` where `wanted` would be right.
    pub fn value(what: &'static str, said: impl std::fmt::Display, wanted: impl Into<String>) -> Self {
        Error::Value { what, said: said.to_string(), wanted: wanted.into() }
    }

    /// The error that something is wrong with the file at `path`.
    pub fn file(path: impl AsRef<Path>, reason: impl Into<String>) -> Self {
        Error::File { path: path.as_ref().to_owned(), reason: reason.into() }
    }
}

/// The result of functions of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;
