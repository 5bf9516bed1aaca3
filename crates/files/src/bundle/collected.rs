//! Files that a scene reads, collected while it is read.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

use barnard::data::{Array, Choose, DataSource, TextTable};
use barnard::error::Result;
use spectra::curve::Columns;

use crate::source::SceneFiles;

/// Files in memory, before those of another source, whose names are recorded.
#[derive(Debug)]
pub(super) struct Collected {
    first: Arc<SceneFiles>,
    then: Arc<dyn DataSource>,
    names: Mutex<BTreeSet<String>>,
}

impl Collected {
    pub fn new(first: Arc<SceneFiles>, then: Arc<dyn DataSource>) -> Self {
        Self { first, then, names: Mutex::default() }
    }

    /// Files of the other source that were read.
    ///
    /// # Errors
    /// If one is not a file, or larger than `memory_limit` bytes.
    pub fn files(&self, memory_limit: u64) -> Result<Vec<(String, Arc<[u8]>)>> {
        let names = self.names.lock().map(|names| names.clone()).unwrap_or_default();
        let file = |name: String| {
            let bytes = self.then.bytes(&name, memory_limit)?;
            Ok((name, bytes.into()))
        };
        names.into_iter().map(file).collect()
    }

    fn source(&self, name: &str) -> &dyn DataSource {
        if self.first.has(name) {
            return &*self.first;
        }
        if let Ok(mut names) = self.names.lock() {
            names.insert(name.to_owned());
        }
        &*self.then
    }
}

impl DataSource for Collected {
    fn label(&self, name: &str) -> String {
        if self.first.has(name) { name.to_owned() } else { self.then.label(name) }
    }

    fn text(&self, name: &str, memory_limit: u64) -> Result<Cow<'static, str>> {
        self.source(name).text(name, memory_limit)
    }

    fn table(&self, name: &str, most_rows: usize, memory_limit: u64) -> Result<TextTable> {
        self.source(name).table(name, most_rows, memory_limit)
    }

    fn columns(&self, name: &str, memory_limit: u64) -> Result<Columns> {
        self.source(name).columns(name, memory_limit)
    }

    fn picture(&self, name: &str, hdu: Option<&str>, memory_limit: u64) -> Result<([usize; 2], Vec<f64>)> {
        self.source(name).picture(name, hdu, memory_limit)
    }

    fn array(&self, name: &str, member: Option<&str>, choose: Choose, memory_limit: u64) -> Result<Array> {
        self.source(name).array(name, member, choose, memory_limit)
    }
}
