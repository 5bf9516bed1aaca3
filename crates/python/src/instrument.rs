//! Instruments: what they record of a picture.

use std::path::PathBuf;
use std::sync::Arc;

use barnard::data::Inputs;
use barnard::instrument::{self, Instrument};
use barnard::{Error, memory};
use barnard_files::SceneFiles;
use barnard_files::formats::save_frame;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::raised;
use crate::image::Image;
use crate::scene::Owner;
use crate::{tree, work};

/// Instrument response to a picture, for all of its frames.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Exposures {
    exposures: instrument::Exposures,
    scene: Owner,
}

/// Lets an instrument look at a picture: the one that a table describes, or that of the picture's scene.
#[pyfunction]
#[pyo3(signature = (image, instrument=None, progress=None))]
pub fn observe(py: Python, image: &Image, instrument: Option<&Bound<PyDict>>, progress: Option<&Bound<PyAny>>) -> PyResult<Exposures> {
    let table = instrument.map(tree::table).transpose()?;
    let scene = image.scene.clone();
    work::run(py, progress, |control| {
        let described = match table {
            Some(table) => {
                let inputs = Inputs::new(Arc::new(SceneFiles::in_folder("")), memory::DEFAULT_LIMIT);
                Arc::new(Instrument::from_properties(&table, &inputs)?)
            }
            None => scene.instrument.clone().ok_or_else(|| {
                Error::missing("an instrument", "use Scene(instrument=Instrument(preset=\"hst-wfc3-uvis\")), or observe(instrument)")
            })?,
        };
        let exposures = instrument::Exposures::new(described, &image.image, &scene.bands, control)?;
        Ok(Exposures { exposures, scene })
    })
}

#[pymethods]
impl Exposures {
    /// The number of frames.
    #[getter]
    fn frames(&self) -> usize {
        self.exposures.instrument().frames
    }

    /// (height, width) in pixels of the detector.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        let [width, height] = self.exposures.size();
        (height, width)
    }

    /// Electrons that pixels gather in a frame on the average, without hits: number of the band, height × width \[e\].
    fn mean<'py>(&self, py: Python<'py>, band: usize) -> PyResult<Bound<'py, PyAny>> {
        let [width, height] = self.exposures.size();
        let values: Vec<f64> = py.detach(|| (0..width * height).map(|pixel| self.exposures.mean(band, pixel)).collect());
        Ok(PyArray1::from_vec(py, values).reshape([height, width])?.into_any())
    }

    /// Counts of a frame by band, or of the mosaic: height × width, the first row on top \[ADU\].
    fn frame<'py>(&self, py: Python<'py>, number: usize) -> PyResult<Bound<'py, PyDict>> {
        let frame = py.detach(|| self.exposures.frame(number));
        let (counts, [width, height]) = (PyDict::new(py), self.exposures.size());
        for (name, plane) in frame.planes.iter().zip(frame.counts) {
            counts.set_item(name, PyArray1::from_vec(py, plane).reshape([height, width])?)?;
        }
        Ok(counts)
    }

    /// Writes a frame as FITS, whole or not at all.
    fn write_frame(&self, py: Python, number: usize, path: PathBuf) -> PyResult<()> {
        py.detach(|| save_frame(&path, &self.exposures.frame(number))).map_err(|error| raised(py, error))
    }

    /// All frames, calibrated and combined.
    #[pyo3(signature = (progress=None))]
    fn master(&self, py: Python, progress: Option<&Bound<PyAny>>) -> PyResult<Image> {
        work::run(py, progress, |control| Ok(Image::new(self.scene.clone(), self.exposures.master(control)?).without_glare()))
    }
}
