//! The cache of long computations.

use std::path::PathBuf;

use barnard_files::cache::DiskCache;
use pyo3::prelude::*;

use crate::error::raised;

/// Folder, limit [bytes], and by kind the number and size [bytes] of records; `None` without a cache.
type CacheFacts = Option<(PathBuf, u64, Vec<(String, usize, u64)>)>;

fn of_user(py: Python) -> PyResult<Option<DiskCache>> {
    DiskCache::of_user().map_err(|error| raised(py, error))
}

/// Folder, limit and records of the cache.
#[pyfunction]
pub fn cache_facts(py: Python) -> PyResult<CacheFacts> {
    let facts = |cache: DiskCache| {
        let usage = cache.usage().into_iter().map(|kind| (kind.kind, kind.records, kind.bytes)).collect();
        (cache.folder().to_owned(), cache.limit(), usage)
    };
    Ok(of_user(py)?.map(facts))
}

/// Removes all records of the cache.
#[pyfunction]
pub fn clear_cache(py: Python) -> PyResult<()> {
    of_user(py)?.map_or(Ok(()), |cache| cache.clear().map_err(|error| raised(py, error)))
}
