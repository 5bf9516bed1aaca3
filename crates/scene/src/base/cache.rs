//! Cache of results between runs of programs, by the fingerprint of their inputs.
//!
//! Nothing here opens a file: programs give a [`Cache`] to a [`Loader`](crate::scene::Loader) and to the options of plans.

use std::fmt::Debug;

use spectra::fingerprint::Fingerprint;

use super::shared::Shared;

/// Result of a computation, as numbers and text.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Record {
    /// Text.
    pub text: String,
    /// Single numbers.
    pub numbers: Vec<f64>,
    /// Arrays.
    pub arrays: Vec<Shared<f32>>,
}

/// Storage of results. A stored result has the same bits as a computed one.
pub trait Cache: Debug + Send + Sync {
    /// Stored result of a kind of computation, by the fingerprint of its inputs.
    fn get(&self, kind: &str, inputs: Fingerprint) -> Option<Record>;

    /// Stores a result. Failures are ignored: the result is computed again.
    fn put(&self, kind: &str, inputs: Fingerprint, record: &Record);
}
