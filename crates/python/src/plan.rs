//! Plans: the numbers that a scene comes to, kept from picture to picture.

use barnard::plan::Options;
use pyo3::prelude::*;

use crate::open;
use crate::scene::Scene;
use crate::work;

/// The certificate of one light in one passband: light, part of F(0), part of F(a), depth.
pub type Certificate = (String, f64, f64, f64);

/// A plan, and what it states.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Plan(pub barnard::Plan);

/// Certificates of all lights that shine in each passband.
pub fn certificates(plan: &barnard::Plan, stats: &barnard::backend::RenderStats) -> Vec<Vec<Certificate>> {
    let told = |(light, c): (usize, spectra::rule::Certificate)| (plan.lights()[light].name.clone(), c.absolute, c.relative, c.depth);
    (0..plan.spectral().bands.len()).map(|band| plan.certificates(band, stats).into_iter().map(told).collect()).collect()
}

#[pymethods]
impl Plan {
    /// Name of the spectral method.
    #[getter]
    fn method(&self) -> String {
        self.0.spectral().method.to_string()
    }

    /// Exponentials that a sample of a ray costs for each star.
    #[getter]
    fn terms(&self) -> usize {
        self.0.spectral().terms()
    }

    /// Step length along a ray, in words.
    #[getter]
    fn steps(&self) -> String {
        self.0.stepping().to_string()
    }

    /// Bytes that tables and volumes take.
    #[getter]
    fn bytes(&self) -> u64 {
        self.0.bytes()
    }

    /// The accuracy that was asked for.
    #[getter]
    fn accuracy(&self) -> f64 {
        self.0.spectral().accuracy
    }

    /// True if pilot rays found a larger error than was asked for.
    #[getter]
    fn misses_accuracy(&self) -> bool {
        self.0.misses_accuracy()
    }

    /// Relative rms spatial error of the worst band, and the number of pilot rays that it was measured on; none where it
    /// was not measured.
    #[getter]
    fn spatial_error(&self) -> Option<(f64, usize)> {
        self.0.space().spatial.map(|spatial| (spatial.error, spatial.rays))
    }

    /// Notes of the plan, each with its topic.
    #[getter]
    fn notes(&self) -> Vec<(String, String)> {
        self.0.notes()
    }

    /// For each passband the certificate of each light that shines in it, for the depths that are expected.
    #[getter]
    fn certificates(&self, py: Python) -> Vec<Vec<Certificate>> {
        py.detach(|| certificates(&self.0, &self.0.expected()))
    }

    /// Copy of the plan seen by the camera of `scene`; nothing else of the scene is looked at.
    #[pyo3(signature = (scene, progress=None))]
    fn look_from(&self, py: Python, scene: &Scene, progress: Option<&Bound<PyAny>>) -> PyResult<Plan> {
        work::run(py, progress, |control| {
            let mut plan = self.0.clone();
            plan.look_from(scene.0.camera.clone(), control)?;
            Ok(Plan(plan))
        })
    }
}

/// Plans a scene for a back end, from what another plan has that still holds; `preview` is for a look at once, of which
/// nothing is stated.
#[pyfunction]
#[pyo3(signature = (scene, before, backend, memory_limit, preview=false, progress=None))]
pub fn plan(
    py: Python,
    scene: &Scene,
    before: Option<&Plan>,
    backend: &str,
    memory_limit: u64,
    preview: bool,
    progress: Option<&Bound<PyAny>>,
) -> PyResult<Plan> {
    work::run(py, progress, |control| {
        let mut options = Options::within(memory_limit);
        let before = before.map(|plan| &plan.0);
        if preview {
            return barnard::Plan::preview(before, &scene.0, &options, control).map(Plan);
        }
        if scene.0.method.bounces > 1 {
            options.sweeper = open::with(backend, &scene.0, |backend| Ok(backend.sweeper()))?;
        }
        barnard::Plan::updated(before, &scene.0, &options, control).map(Plan)
    })
}
