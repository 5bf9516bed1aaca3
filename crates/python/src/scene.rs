//! Scenes, read from trees.

use std::ops::Deref;
use std::path::PathBuf;
use std::sync::Arc;

use barnard::Options;
use barnard::properties::{Part, Table};
use barnard::scene::Loader;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::Arrays;
use crate::error::raised;
use crate::tree;
use crate::work;

/// Reads scenes, and keeps fields and tables of stars from reading to reading where their words did not change.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Reader {
    arrays: Arc<Arrays>,
    pub loader: Loader,
    folder: Option<PathBuf>,
}

#[pymethods]
impl Reader {
    /// Reads files relative to `folder`, those that are built in where there is none; an array or an image may take
    /// `memory_limit` bytes.
    #[new]
    pub fn new(py: Python, folder: Option<PathBuf>, memory_limit: u64) -> PyResult<Self> {
        let arrays = Arc::new(Arrays::new(folder.clone()));
        let cache = barnard_files::cache::of_user().map_err(|error| raised(py, error))?;
        let loader = Loader::new(arrays.clone(), memory_limit).with_cache(cache);
        Ok(Self { loader, arrays, folder })
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
    pub fn read(&self, py: Python, scene: &Bound<PyDict>, name: &str) -> PyResult<Scene> {
        let table = tree::table(scene)?;
        let scene = work::run(py, None, |control| barnard::Scene::from_properties(&table, name, &self.loader.under(control)))?;
        Ok(Scene(Owner { scene: Arc::new(scene), words: self.words(table) }))
    }
}

impl Reader {
    /// Source of a scene.
    pub fn words(&self, table: Table) -> Arc<Words> {
        Arc::new(Words { table, folder: self.folder.clone(), limit: self.loader.inputs.memory_limit })
    }
}

/// Options of a plan within a memory limit \[bytes\], with the cache of the user.
pub fn plan_options(memory_limit: u64) -> barnard::Result<Options> {
    Ok(Options::within(memory_limit).with_cache(barnard_files::cache::of_user()?))
}

/// Source of a scene.
pub struct Words {
    pub table: Table,
    /// The folder of its files; none where they are built in.
    pub folder: Option<PathBuf>,
    /// Most bytes that an array may take.
    pub limit: u64,
}

/// A scene, and what it was read from.
#[derive(Clone)]
pub struct Owner {
    pub scene: Arc<barnard::Scene>,
    pub words: Arc<Words>,
}

impl Deref for Owner {
    type Target = barnard::Scene;

    fn deref(&self) -> &barnard::Scene {
        &self.scene
    }
}

/// A scene that was read and checked.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Scene(pub Owner);

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

    /// Names of the parts in which another scene differs, such as "space", "spectra" and "view".
    fn differing(&self, other: &Self) -> Vec<String> {
        self.0.parts().differing(&other.0.parts()).iter().map(Part::to_string).collect()
    }

    /// Copy by the camera of another scene; lines of moving gas keep their shifts.
    fn seen_as(&self, other: &Self) -> Self {
        let scene = barnard::Scene::clone(&self.0).with_camera(other.0.camera.clone());
        Self(Owner { scene: Arc::new(scene), words: other.0.words.clone() })
    }
}
