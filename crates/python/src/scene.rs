//! Scenes, read from trees.

use std::path::PathBuf;
use std::sync::Arc;

use barnard::scene::Loader;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::Arrays;
use crate::tree;
use crate::work;

/// Reads scenes, and keeps fields and tables of stars from reading to reading where their words did not change.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Reader {
    arrays: Arc<Arrays>,
    pub loader: Loader,
}

#[pymethods]
impl Reader {
    /// Reads files relative to `folder`, those that are built in where there is none; an array or an image may take
    /// `memory_limit` bytes.
    #[new]
    fn new(folder: Option<PathBuf>, memory_limit: u64) -> Self {
        let arrays = Arc::new(Arrays::new(folder));
        Self { loader: Loader::new(arrays.clone(), memory_limit), arrays }
    }

    /// Takes a contiguous, read-only array of float32 or float64 under a name; messages call it `label`.
    fn add_array(&self, name: String, label: String, array: &Bound<PyAny>) -> PyResult<()> {
        self.arrays.add(name, label, array)
    }

    /// Lets go of all arrays but those of these names.
    fn keep_arrays(&self, names: Vec<String>) {
        self.arrays.keep(&names);
    }

    /// The scene that a tree describes; it is called `name` where it does not say.
    fn read(&self, py: Python, scene: &Bound<PyDict>, name: &str) -> PyResult<Scene> {
        let table = tree::table(scene)?;
        let scene = work::run(py, None, |control| barnard::Scene::from_properties(&table, name, &self.loader.under(control)))?;
        Ok(Scene(Arc::new(scene)))
    }
}

/// A scene that was read and checked.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Scene(pub Arc<barnard::Scene>);

#[pymethods]
impl Scene {
    /// Names of the passbands.
    #[getter]
    fn bands(&self) -> Vec<&str> {
        self.0.bands.iter().map(|band| band.name()).collect()
    }

    /// Pixels along a row and along a column.
    #[getter]
    fn size(&self) -> (usize, usize) {
        (self.0.camera.width, self.0.camera.height)
    }
}
