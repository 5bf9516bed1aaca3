//! Bundles and pages of scenes.

use std::io::Cursor;
use std::sync::Arc;

use barnard::control::Control;
use barnard::scene::Loader;
use barnard_files::bundle::{Baking, Bundle};
use barnard_files::{SceneFile, SceneFiles, builtin};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::raised;
use crate::image::Image;
use crate::scene::{Owner, Scene, plan_options};
use crate::work;

/// Bundle of a scene, of at most a number of bytes.
fn baked(owner: &Owner, bytes: usize, compares: bool, control: &Control) -> barnard::Result<Bundle> {
    let words = &owner.words;
    let files = words.folder.as_ref().map_or_else(builtin::files, |folder| Arc::new(SceneFiles::in_folder(folder)));
    let file = SceneFile::of(barnard::Scene::clone(&owner.scene), words.table.clone(), Loader::new(files, words.limit));
    barnard_files::bundle::bake(&file, &Baking { bytes, options: plan_options(words.limit)?, compares }, control)
}

fn bytes<'py>(
    py: Python<'py>,
    owner: &Owner,
    limit: usize,
    compares: bool,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let encoded = work::run(py, progress, |control| baked(owner, limit, compares, control)?.encoded())?;
    Ok(PyBytes::new(py, &encoded))
}

/// Bytes of a bundle of a scene, at most `limit` of them; with errors and a preview if it `compares`.
#[pyfunction]
pub fn bake<'py>(
    py: Python<'py>,
    scene: &Scene,
    limit: usize,
    compares: bool,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<Bound<'py, PyBytes>> {
    bytes(py, &scene.0, limit, compares, progress)
}

/// Bytes of a bundle of the scene of an image.
#[pyfunction]
pub fn bake_image<'py>(py: Python<'py>, image: &Image, limit: usize, progress: Option<&Bound<PyAny>>) -> PyResult<Bound<'py, PyBytes>> {
    bytes(py, &image.scene, limit, true, progress)
}

/// The page of the explorer with a bundle.
#[pyfunction]
pub fn html(py: Python, page: &str, bundle: &[u8]) -> PyResult<String> {
    let made = || Bundle::read(Cursor::new(bundle), "bundle".as_ref(), u64::MAX)?.html(page);
    made().map_err(|error| raised(py, error))
}
