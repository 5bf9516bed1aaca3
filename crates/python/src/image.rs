//! Pictures: rendered, as arrays, in colours, and as files.

use std::path::PathBuf;

use barnard::Result;
use barnard::backend::{Backend, Job, Renderer};
use barnard::control::Control;
use barnard::image::{Band, Display, FAR_AWAY, LayerContent, PixelScale, Samples, SaveOptions};
use barnard::keywords::Value;
use barnard::plan::Planned;
use barnard::properties::Table;
use barnard_files::SaveImage;
use barnard_files::formats::encode_png;
use numpy::{PyArray1, PyArray3, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::error::raised;
use crate::plan::Plan;
use crate::report;
use crate::scene::{Owner, Scene, plan_options};
use crate::{open, tree, work};

/// The display that a table describes for pictures of a scene.
fn display(scene: &barnard::Scene, table: &Table) -> Result<Display> {
    Display::from_properties(table, &scene.bands)
}

/// A band: pivot wavelength [um], width [um], how it counts.
type BandDetails = (Option<f64>, Option<f64>, Option<&'static str>);

/// A rendered picture, with what is stated of it.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Image {
    pub scene: Owner,
    pub image: barnard::Image,
    pub options: SaveOptions,
    pub warnings: Vec<String>,
}

#[pymethods]
impl Image {
    /// Names of the bands, those of standard errors behind those of radiances.
    #[getter]
    fn bands(&self) -> Vec<String> {
        self.image.bands.iter().map(Band::label).collect()
    }

    /// Numbers of the bands that are radiances.
    #[getter]
    fn radiances(&self) -> Vec<usize> {
        self.image.radiances().collect()
    }

    /// (height, width) in pixels.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.image.height, self.image.width)
    }

    /// Band radiances, bands × height × width, the first row on top, float32 or float64 [W m-2 sr-1]; a new array each time.
    fn radiance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        values(py, &self.image.samples, &[self.image.bands.len(), self.image.height, self.image.width])
    }

    /// Layers by name: of light bands × height × width [W m-2 sr-1]; "depth" height × width, the mean distance of the light of dust
    /// and gas [pc], infinite where there is none; "tau" height × width, optical depth at V. New arrays each time.
    #[getter]
    fn layers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (height, width) = (self.image.height, self.image.width);
        let layers = PyDict::new(py);
        for layer in &self.image.layers {
            let array = match layer.content {
                LayerContent::Light => values(py, &layer.samples, &[self.image.bands.len(), height, width])?,
                LayerContent::Mask => values(py, &layer.samples, &[self.image.radiances().count(), height, width])?,
                LayerContent::Depth | LayerContent::OpticalDepth => {
                    let far = |v: f64| if v >= FAR_AWAY { f32::INFINITY } else { v as f32 };
                    let values: Vec<f32> = layer.channel(0, height * width).map(far).collect();
                    PyArray1::from_vec(py, values).reshape([height, width])?.into_any()
                }
            };
            layers.set_item(&layer.name, array)?;
        }
        Ok(layers)
    }

    /// The report, as facts.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        report::facts(py, &self.image.report)
    }

    /// Warnings of the render, in words.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Notes of the picture, each with its topic.
    #[getter]
    fn notes(&self) -> Vec<(String, String)> {
        self.image.statements()
    }

    /// For each band its pivot wavelength [um], its width ∫ R dλ [um], and how it counts.
    #[getter]
    fn band_details(&self) -> Vec<BandDetails> {
        self.image.bands.iter().map(|b| (b.pivot_um, b.width_um, b.counting)).collect()
    }

    /// Keywords as FITS headers have them: name to value.
    #[getter]
    fn keywords<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let keywords = PyDict::new(py);
        for keyword in self.image.cards() {
            match keyword.value {
                Value::Text(text) => keywords.set_item(keyword.name, text)?,
                Value::Number(number) => keywords.set_item(keyword.name, number)?,
                Value::Integer(number) => keywords.set_item(keyword.name, number)?,
            }
        }
        Ok(keywords)
    }

    /// Position of the optical axis in the image, from its middle to the right and upwards [pixels].
    #[getter]
    fn axis(&self) -> (f64, f64) {
        self.image.axis
    }

    /// Size of a pixel in the middle, and its unit, "deg" or "pc"; none where it is not known.
    #[getter]
    fn pixel_scale(&self) -> Option<(f64, &'static str)> {
        self.image.pixel.map(PixelScale::in_unit)
    }

    /// Writes the picture, whole or not at all; the extension says how.
    fn write(&self, py: Python, path: PathBuf) -> PyResult<()> {
        work::run(py, None, |_| self.image.save(&path, &self.options))
    }

    /// The bytes of a file with this extension.
    fn encode<'py>(&self, py: Python<'py>, extension: &str) -> PyResult<Bound<'py, PyBytes>> {
        let name = PathBuf::from(format!("image.{extension}"));
        let bytes = work::run(py, None, |_| (barnard_files::formats::writer(&name)?.encode)(&self.image, &self.options))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The picture in colours, height × width × 3 of uint8 in sRGB; `display` is a table [display], that of the scene
    /// where there is none.
    fn rgb<'py>(&self, py: Python<'py>, display: Option<&Bound<PyDict>>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let pixels = self.coloured(py, display)?;
        PyArray1::from_vec(py, pixels).reshape([self.image.height, self.image.width, 3])
    }

    /// The picture in colours as the bytes of a .png.
    fn png<'py>(&self, py: Python<'py>, display: Option<&Bound<PyDict>>) -> PyResult<Bound<'py, PyBytes>> {
        let pixels = self.coloured(py, display)?;
        let bytes = work::run(py, None, |_| encode_png((self.image.width, self.image.height), &pixels, &self.image.statements()))?;
        Ok(PyBytes::new(py, &bytes))
    }
}

impl Image {
    /// Image whose optics are in its light already.
    pub fn without_glare(self) -> Self {
        Self { options: self.options.without_glare(), ..self }
    }

    /// An image of a scene.
    pub fn new(scene: Owner, image: barnard::Image) -> Self {
        Self { options: scene.save_options(), scene, image, warnings: Vec::new() }
    }

    fn coloured(&self, py: Python, table: Option<&Bound<PyDict>>) -> PyResult<Vec<u8>> {
        let shown = match table {
            None => self.options.display.clone(),
            Some(table) => display(&self.scene, &tree::table(table)?).map_err(|error| raised(py, error))?,
        };
        work::run(py, None, |_| Ok(shown.picture(&self.image).iter().flatten().map(|v| (v * 255.0 + 0.5) as u8).collect()))
    }
}

/// Values of an image as an array of this shape.
fn values<'py>(py: Python<'py>, samples: &Samples, shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    Ok(match samples {
        Samples::Single(values) => values.to_pyarray(py).reshape(shape.to_vec())?.into_any(),
        Samples::Double(values) => values.to_pyarray(py).reshape(shape.to_vec())?.into_any(),
    })
}

/// Raises where no picture can be written to a path.
#[pyfunction]
pub fn check_writable(py: Python, path: PathBuf) -> PyResult<()> {
    barnard_files::formats::check_writable(&path).map_err(|error| raised(py, error))
}

/// Renders a scene by a back end; those that read a plan take `plan`, which must be of the same scene and camera.
#[pyfunction]
#[pyo3(signature = (scene, plan, backend, options, memory_limit, progress=None))]
pub fn render(
    py: Python,
    scene: &Scene,
    plan: Option<&Plan>,
    backend: &str,
    options: &Bound<PyDict>,
    memory_limit: u64,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<Image> {
    let (owner, options) = (scene.0.clone(), tree::table(options)?);
    work::run(py, progress, move |control| rendered(&owner, plan.map(|plan| &plan.0), backend, &options, memory_limit, control))
}

/// The picture of a scene by a back end, with options as the tables `path` and `reference` of `[method]` have them.
pub fn rendered(
    scene: &Owner,
    plan: Option<&Planned>,
    backend: &str,
    options: &Table,
    memory_limit: u64,
    control: &Control,
) -> Result<Image> {
    scene.check_image(memory_limit)?;
    let backends = scene.method.backends.with_properties(options)?;
    let adjusted = barnard::Scene::clone(scene).with_method(barnard::scene::Method { backends, ..scene.method.clone() });
    let options = plan_options(memory_limit)?;
    let planned = plan.map(|plan| plan.for_scene(&adjusted, control)).transpose()?;
    let job = match &planned {
        Some(planned) => Job::from(planned),
        None => Job::new(adjusted.clone(), &options)?,
    };
    let render = |backend: &mut dyn Backend| {
        let (image, _) = Renderer::new(backend).render(job, control)?;
        let Some(device) = backend.device() else { return Ok((image, Vec::new())) };
        let mut warnings = device.warnings();
        warnings.extend(device.fallback().map(|why| format!("on the cpu: {why}")));
        Ok((image, warnings))
    };
    let (image, warnings) = open::with(backend, &adjusted, render)?;
    Ok(Image { warnings, ..Image::new(scene.clone(), image) })
}
