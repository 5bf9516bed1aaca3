//! Errors that a user of the renderer can correct.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use spectra::SpectraError;

use crate::place::Place;

/// Errors of this crate. A message states the problem, the allowed values or the remedy, and the location.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Something in a scene is wrong.
    #[error("{message} ({place})")]
    Scene {
        /// Problem and remedy.
        message: String,
        /// Location: file and line of a text, or table and key.
        place: Place,
    },
    /// Value outside of its valid range.
    #[error("{what} is {value}; it must be {allowed}")]
    OutOfRange {
        /// Kind of value, such as an albedo.
        what: &'static str,
        /// The value.
        value: String,
        /// Allowed values.
        allowed: String,
    },
    /// Text that does not have the expected form.
    #[error("\"{text}\" is not a valid {what}; write {example}")]
    Malformed {
        /// Kind of value.
        what: &'static str,
        /// The text.
        text: String,
        /// Expected form, with an example.
        example: String,
    },
    /// Settings or data that exclude each other.
    #[error("{problem}; {remedy}")]
    Conflict {
        /// The conflict.
        problem: String,
        /// Change that resolves it.
        remedy: String,
    },
    /// Feature that a component does not support.
    #[error("{by} does not support {feature}; {alternative}")]
    Unsupported {
        /// The feature.
        feature: String,
        /// The component.
        by: String,
        /// Component or setting to use instead.
        alternative: String,
    },
    /// Required value that is not there.
    #[error("{what} is required; {remedy}")]
    Missing {
        /// The value.
        what: String,
        /// Addition that provides it.
        remedy: String,
    },
    /// Data whose size or kind differs from the expected one.
    #[error("{what}: expected {expected}, found {found}")]
    Mismatch {
        /// Kind of data.
        what: &'static str,
        /// Expected size or kind.
        expected: String,
        /// Actual size or kind.
        found: String,
    },
    /// Box that is empty, infinite or not a number.
    #[error("{0}")]
    Bounds(String),
    /// A data file that cannot be read or used.
    #[error("{}: {reason}", path.display())]
    File {
        /// The path of the file.
        path: PathBuf,
        /// Problem and remedy.
        reason: String,
    },
    /// Values of a field that no density can have.
    #[error(
        "field \"{field}\" has {count} {what} of {cells}, the first at [{x}, {y}, {z}] = {value}; densities must be finite and at least zero"
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
    /// Multiple scattering requested of a method that supports single scattering only.
    #[error("{0} supports only single scattering; set bounces = 1, or use {1}")]
    OneBounce(String, &'static str),
    /// Light or density beyond what single precision holds.
    #[error("{0}; check the unit of its brightness, and the scales of densities")]
    Strength(String),
    /// Star without escaping light or without a valid position.
    #[error("{0}")]
    Star(String),
    /// More stars in the star field than are drawn.
    #[error("the star field has {in_view:.1e} stars in view, at most {most:.0e} are supported; reduce its density")]
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
    /// The value that is out of range, by the name of its key; none for other errors.
    pub fn subject(&self) -> Option<&'static str> {
        match self {
            Error::OutOfRange { what, .. } | Error::Mismatch { what, .. } => Some(what),
            _ => None,
        }
    }

    /// An [`OutOfRange`](Self::OutOfRange) error; `allowed` follows "it must be".
    pub fn out_of_range(what: &'static str, value: impl Display, allowed: impl Into<String>) -> Self {
        Error::OutOfRange { what, value: value.to_string(), allowed: allowed.into() }
    }

    /// A [`Malformed`](Self::Malformed) error; `example` follows "write".
    pub fn malformed(what: &'static str, text: impl Into<String>, example: impl Into<String>) -> Self {
        Error::Malformed { what, text: text.into(), example: example.into() }
    }

    /// A [`Conflict`](Self::Conflict) error.
    pub fn conflict(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Error::Conflict { problem: problem.into(), remedy: remedy.into() }
    }

    /// An [`Unsupported`](Self::Unsupported) error.
    pub fn unsupported(feature: impl Into<String>, by: impl Into<String>, alternative: impl Into<String>) -> Self {
        Error::Unsupported { feature: feature.into(), by: by.into(), alternative: alternative.into() }
    }

    /// A [`Missing`](Self::Missing) error.
    pub fn missing(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Error::Missing { what: what.into(), remedy: remedy.into() }
    }

    /// A [`Mismatch`](Self::Mismatch) error.
    pub fn mismatch(what: &'static str, expected: impl Display, found: impl Display) -> Self {
        Error::Mismatch { what, expected: expected.to_string(), found: found.to_string() }
    }

    /// The error that something is wrong with the file at `path`.
    pub fn file(path: impl AsRef<Path>, reason: impl Into<String>) -> Self {
        Error::File { path: path.as_ref().to_owned(), reason: reason.into() }
    }
}

/// The result of functions of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

#[cfg(test)]
mod tests {
    use super::*;

    /// One example of each variant.
    fn examples() -> Vec<Error> {
        let place = Place { origin: None, path: "star[2]".into(), key: "temperature".into() };
        vec![
            Error::Scene { message: "temperature is -1 K; it must be above zero".into(), place },
            Error::out_of_range("albedo", 1.2, "between 0 and 1"),
            Error::malformed("place on the sky", "18h", "two angles such as \"18h18m48s -13d49m\""),
            Error::conflict("up of the camera is its viewing direction", "choose another direction"),
            Error::unsupported("a stereo camera", "a set of plates", "remove [camera.stereo]"),
            Error::missing("albedo", "set a value such as 0.6"),
            Error::mismatch("data of a grid", "2 x 2 x 2 values, x fastest", 7),
            Error::Bounds("the box is empty; high must exceed low".into()),
            Error::file("cloud.npy", "is truncated: 512 values of 4 bytes announced, 64 bytes found"),
            Error::FieldValues { field: "n_H".into(), count: 3, what: "negative cells", cells: 512, x: 1, y: 2, z: 3, value: -0.5 },
            Error::Memory { what: "the grid \"n_H\"".into(), needed_mib: 4096, limit_mib: 1024 },
            Error::Spectra(SpectraError::unknown("passband", "johnson-W", &["johnson-V", "johnson-B"])),
            Error::OneBounce("the reference".into(), "the path tracer"),
            Error::Strength("star[0] emits 1.0e40 W m-2 through band johnson-V, more than the limit of single precision, 1e30".into()),
            Error::Star("star[0] is in a voxel of optical depth 461.5, so none of its light escapes; move the star".into()),
            Error::StarField { in_view: 3e7, most: 1e6 },
            Error::Density("a density near (0, 0, 0) pc is not finite, so collisions have no bound; limit it, as in min(f, 1e3)".into()),
            Error::Method("no spectral rule reaches the accuracy; increase accuracy".into()),
            Error::Encoding { format: "jpg", reason: "70000 pixels exceed 65535 per edge".into() },
            Error::Device("no graphics adapter was found; render on the processor".into()),
            Error::Interrupted,
        ]
    }

    /// Number of a variant; a new variant does not compile here until it has a number.
    fn number(error: &Error) -> usize {
        match error {
            Error::Scene { .. } => 0,
            Error::OutOfRange { .. } => 1,
            Error::Malformed { .. } => 2,
            Error::Conflict { .. } => 3,
            Error::Unsupported { .. } => 4,
            Error::Missing { .. } => 5,
            Error::Mismatch { .. } => 6,
            Error::Bounds(_) => 7,
            Error::File { .. } => 8,
            Error::FieldValues { .. } => 9,
            Error::Memory { .. } => 10,
            Error::Spectra(_) => 11,
            Error::OneBounce(..) => 12,
            Error::Strength(_) => 13,
            Error::Star(_) => 14,
            Error::StarField { .. } => 15,
            Error::Density(_) => 16,
            Error::Method(_) => 17,
            Error::Encoding { .. } => 18,
            Error::Device(_) => 19,
            Error::Interrupted => 20,
        }
    }

    /// `errors.txt` has the message of each variant, for review; `BLESS=1` writes it.
    #[test]
    fn messages_are_those_reviewed() {
        let page: String = examples().iter().map(|error| format!("{error}\n")).collect();
        assert!(examples().iter().enumerate().all(|(i, error)| number(error) == i), "an example is missing");
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/base/errors.txt");
        if std::env::var("BLESS").is_ok_and(|v| v == "1") {
            std::fs::write(&path, &page).unwrap();
        }
        assert!(std::fs::read_to_string(&path).unwrap() == page, "errors.txt is stale; run BLESS=1 cargo test -p barnard-scene messages");
        for line in page.lines() {
            assert!(!line.ends_with('.') && !line.contains(" is no ") && line.len() < 240, "{line}");
        }
    }
}
