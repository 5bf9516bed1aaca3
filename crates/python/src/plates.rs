//! Plates: pictures kept light by light.

use std::path::PathBuf;

use barnard::plates::Reach;
use pyo3::prelude::*;
use spectra::units::Wavelength;

use crate::error::raised;
use crate::image::Image;
use crate::plan::Plan;
use crate::scene::{Scene, plan_options};
use crate::work;

/// Plates of a scene, or of a file.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Plates(barnard::Plates);

/// Makes plates of a scene for wavelengths of `range`, texts such as "380 nm", and parts of its dust from the least to the largest; what holds
/// of a plan of it is taken from that.
#[pyfunction]
#[pyo3(signature = (scene, range, dust, before, memory_limit, progress=None))]
pub fn plates(
    py: Python,
    scene: &Scene,
    range: Option<(String, String)>,
    dust: (f64, f64),
    before: Option<&Plan>,
    memory_limit: u64,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<Plates> {
    work::run(py, progress, |control| {
        let wavelength = |text: &str| text.parse::<Wavelength>().map(|length| length.0);
        let range_um = range.map(|(from, to)| Ok::<_, spectra::SpectraError>((wavelength(&from)?, wavelength(&to)?))).transpose()?;
        barnard::Plates::new(&scene.0, Reach { range_um, dust }, before.map(|plan| &plan.0), &plan_options(memory_limit)?, control)
            .map(Plates)
    })
}

/// Reads plates that `write` wrote; each array may take `memory_limit` bytes.
#[pyfunction]
pub fn read_plates(py: Python, path: PathBuf, memory_limit: u64) -> PyResult<Plates> {
    py.detach(|| barnard_files::plates::load(&path, memory_limit)).map(Plates).map_err(|error| raised(py, error))
}

#[pymethods]
impl Plates {
    /// (height, width) in pixels.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        let [width, height] = self.0.record().size;
        (height, width)
    }

    /// The number of lights.
    #[getter]
    fn lights(&self) -> usize {
        self.0.record().plates.len()
    }

    /// Bytes that they take.
    #[getter]
    fn bytes(&self) -> u64 {
        self.0.bytes()
    }

    /// The shortest and the longest wavelength that they serve \[um\].
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.0.range_um()
    }

    /// The picture of a scene that differs from theirs in spectra alone.
    fn expose(&self, py: Python, scene: &Scene) -> PyResult<Image> {
        work::run(py, None, |control| Ok(Image::new(scene.0.clone(), self.0.expose(&scene.0, control)?)))
    }

    /// Writes them down, whole or not at all.
    fn write(&self, py: Python, path: PathBuf) -> PyResult<()> {
        py.detach(|| barnard_files::plates::save(&path, &self.0)).map_err(|error| raised(py, error))
    }
}
