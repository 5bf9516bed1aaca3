//! Cache of results between runs of programs, by the fingerprint of their inputs.
//!
//! Nothing here opens a file: programs give a [`Cache`] to a [`Loader`](crate::scene::Loader) and to the options of plans.

use std::fmt::Debug;
use std::sync::Arc;

use spectra::fingerprint::Fingerprint;

use super::shared::Shared;

/// Kind of the records of solved gas.
pub const GAS: &str = "gas";
/// Text of the record of n_p n_e by voxel.
pub const PAIRS: &str = "pairs";

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

/// Results that came with a scene, before those of another cache, which stores new ones.
#[derive(Debug)]
pub(crate) struct Layered {
    pub first: Arc<dyn Cache>,
    pub then: Option<Arc<dyn Cache>>,
}

impl Cache for Layered {
    fn get(&self, kind: &str, inputs: Fingerprint) -> Option<Record> {
        self.first.get(kind, inputs).or_else(|| self.then.as_ref()?.get(kind, inputs))
    }

    fn put(&self, kind: &str, inputs: Fingerprint, record: &Record) {
        if let Some(cache) = &self.then {
            cache.put(kind, inputs, record);
        }
    }
}
