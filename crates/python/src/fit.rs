//! Fits of scenes to observed images.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use barnard::control::Control;
use barnard::plan::Options;
use barnard_fit::solve::{Measured, Model, Prediction};
use barnard_fit::{Assumed, Data, Images, Observation, Parameter, PixelData, PixelValues, fit, narrowed, planes_of};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyDict;

use crate::error::raised;
use crate::image::Image;
use crate::scene::{Reader, Scene};
use crate::{tree, work};

/// Observed images and the scenes that are their models.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct FitModel {
    images: Mutex<Images>,
    data: Measured,
    start: Vec<f64>,
    free: Vec<Parameter>,
    units: Vec<String>,
    scene: Py<Scene>,
}

/// Pixels in memory that a scene is fitted to.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct FitPixels(PixelData);

/// The pixels of a picture, or an array of all bands (bands × height × width, the first row on top, in the unit of the scene's pictures), with
/// standard errors and a mask of the same shape in place of their own.
#[pyfunction]
#[pyo3(signature = (name, picture, values, sigma, mask))]
pub fn fit_pixels(
    py: Python,
    name: String,
    picture: Option<&Image>,
    values: Option<PyReadonlyArray3<f64>>,
    sigma: Option<PyReadonlyArray3<f64>>,
    mask: Option<PyReadonlyArray3<bool>>,
) -> PyResult<FitPixels> {
    let values = match (picture, values) {
        (Some(picture), _) => PixelValues::Planes(planes_of(&picture.image).map_err(|error| raised(py, error))?),
        (None, values) => {
            let values = values.ok_or_else(|| PyTypeError::new_err("a picture or an array"))?;
            let [bands, height, width] = [0, 1, 2].map(|axis| values.shape()[axis]);
            PixelValues::Array([bands, height, width], values.as_array().iter().copied().collect())
        }
    };
    let sigma = sigma.map(|array| array.as_array().iter().copied().collect());
    let mask = mask.map(|array| array.as_array().iter().copied().collect());
    Ok(FitPixels(PixelData { name, values, sigma, mask }))
}

/// A free key: name, bounds, mean and standard deviation of its prior.
type FreeRow = (String, f64, f64, Option<(f64, f64)>);

/// Free keys of a text, such as "star[0].luminosity=1..10": name, bounds, prior.
#[pyfunction]
pub fn free_keys(py: Python, text: &str) -> PyResult<Vec<FreeRow>> {
    let row = |parameter: Parameter| (parameter.key, parameter.bounds.0, parameter.bounds.1, parameter.prior);
    let parsed: barnard::Result<Vec<Parameter>> = text.split(',').map(|part| part.trim().parse()).collect();
    parsed.map(|all| all.into_iter().map(row).collect()).map_err(|error| raised(py, error))
}

/// Source of pixels.
#[derive(FromPyObject)]
pub enum PixelSource<'py> {
    Pixels(PyRef<'py, FitPixels>),
    File(PathBuf),
}

/// Reads images, each with tables of its own in place of the scene's and whether its unit and its place are assumed, and finds what is free of the scene that a table describes.
#[pyfunction]
#[pyo3(signature = (reader, table, scene, free, images, progress=None))]
pub fn fit_model(
    py: Python,
    reader: &Reader,
    table: &Bound<PyDict>,
    scene: Py<Scene>,
    free: Vec<FreeRow>,
    images: Vec<(PixelSource, Bound<PyDict>, (bool, bool))>,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<FitModel> {
    let table = tree::table(table)?;
    let observation = |(source, with, assumed): (PixelSource, Bound<PyDict>, (bool, bool))| {
        let (data, assumed) = match source {
            PixelSource::File(file) => (Data::File(file), Assumed { unit: assumed.0, place: assumed.1 }),
            // Whoever gives an array says that it is as the scene's pictures are.
            PixelSource::Pixels(pixels) => (Data::Pixels(pixels.0.clone()), Assumed { unit: true, place: true }),
        };
        Ok(Observation { data, with: tree::table(&with)?, assumed })
    };
    let observations: Vec<Observation> = images.into_iter().map(observation).collect::<PyResult<_>>()?;
    let (loader, options) = (reader.loader.clone(), Options::within(reader.loader.inputs.memory_limit));
    let (images, data, start, free) = work::run(py, progress, |control| {
        let parameter = |(key, low, high, prior): FreeRow| Parameter { key, bounds: (low, high), prior };
        let free = narrowed(free.into_iter().map(parameter).collect(), &table)?;
        let (images, data, start) = Images::new(table, loader, &observations, &free, options, control)?;
        Ok((images, data, start, free))
    })?;
    let units = images.units().into_iter().map(str::to_owned).collect();
    Ok(FitModel { images: Mutex::new(images), data, start, free, units, scene })
}

impl FitModel {
    fn with<T: Send>(
        &self,
        py: Python,
        progress: Option<&Bound<PyAny>>,
        work: impl FnOnce(&mut Images, &Control) -> barnard::Result<T> + Send,
    ) -> PyResult<T> {
        // Locked by the thread that asks: one of the pool that waited for the lock could hold up what holds it.
        let images = &mut *self.images.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner);
        work::run(py, progress, |control| work(images, control))
    }
}

#[pymethods]
impl FitModel {
    /// The keys that are free.
    #[getter]
    fn keys(&self) -> Vec<&str> {
        self.free.iter().map(|parameter| parameter.key.as_str()).collect()
    }

    /// The unit of each, as the scene writes it.
    #[getter]
    fn units(&self) -> Vec<String> {
        self.units.clone()
    }

    /// Bounds of each.
    #[getter]
    fn bounds(&self) -> Vec<(f64, f64)> {
        self.free.iter().map(|parameter| parameter.bounds).collect()
    }

    /// Values of each in the scene.
    #[getter]
    fn start(&self) -> Vec<f64> {
        self.start.clone()
    }

    /// Rounding of predictions, relative to the brightest.
    #[getter]
    fn rounding(&self) -> f64 {
        self.images.lock().unwrap_or_else(PoisonError::into_inner).rounding()
    }

    /// The pixels that count, one after the other.
    #[getter]
    fn data<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.data.values)
    }

    /// Predicted data at some values, and their standard errors: those of the model, or those of the files.
    fn predict<'py>(&self, py: Python<'py>, values: Vec<f64>) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
        let Prediction { mean, sigma } = self.with(py, None, |images, control| images.predict(&values, control))?;
        Ok([mean, sigma.unwrap_or_else(|| self.data.sigma.clone())].map(|values| PyArray1::from_vec(py, values)))
    }

    /// Fits from `start` on: a dictionary of what was found.
    #[pyo3(signature = (start, progress=None))]
    fn fit<'py>(&self, py: Python<'py>, start: Vec<f64>, progress: Option<&Bound<PyAny>>) -> PyResult<Bound<'py, PyDict>> {
        let (found, residuals) = self.with(py, progress, |images, control| {
            // What it makes ready for the values that it finds is its own: predictions stay what they were.
            let images = &mut images.clone();
            let found = fit(images, &self.data, &self.free, &start, control)?;
            let residuals = images.residuals(&self.data, &found.prediction, &found.sigma, control)?;
            Ok((found, residuals))
        })?;
        let count = self.free.len();
        let result = PyDict::new(py);
        let covariance: Vec<f64> = (0..count * count).map(|i| found.covariance[(i / count, i % count)]).collect();
        result.set_item("covariance", PyArray1::from_vec(py, covariance).reshape([count, count])?)?;
        result.set_item("chi2_warning", found.chi2_warning())?;
        result.set_item("values", found.values)?;
        result.set_item("floor", found.floor)?;
        result.set_item("linear", found.linear)?;
        result.set_item("chi2", found.chi2.0)?;
        result.set_item("pixels", found.chi2.1)?;
        result.set_item("pictures", found.evaluations)?;
        result.set_item("converged", found.converged)?;
        result.set_item("degenerate", found.degenerate)?;
        result.set_item("bounded", found.bounded)?;
        let scene = self.scene.get().0.clone();
        let images: Vec<Image> = residuals.into_iter().map(|residual| Image::new(scene.clone(), residual.image).without_glare()).collect();
        result.set_item("residuals", images)?;
        Ok(result)
    }
}
