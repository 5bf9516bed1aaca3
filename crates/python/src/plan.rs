//! Plans: the numbers that a scene comes to, kept from picture to picture.

use barnard::plan::{Planned, Planner, Quality};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::open;
use crate::report;
use crate::scene::{Scene, plan_options};
use crate::work;

/// A scene with its plan, and what it states.
#[pyclass(frozen, module = "barnard._barnard")]
pub struct Plan(pub Planned);

#[pymethods]
impl Plan {
    /// The report that an image by it is expected to have, as facts.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let report = py.detach(|| self.0.expected_report());
        report::facts(py, &report)
    }

    /// Exponentials that a sample of a ray costs for each star.
    #[getter]
    fn terms(&self) -> usize {
        self.0.spectral().terms()
    }

    /// Bytes that tables and volumes take.
    #[getter]
    fn bytes(&self) -> u64 {
        self.0.bytes()
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
        let mut options = plan_options(memory_limit)?;
        let quality = if preview { Quality::Preview } else { Quality::Full };
        if !preview && scene.0.method.bounces > 1 {
            options.sweeper = open::with(backend, &scene.0, |backend| Ok(backend.sweeper()))?;
        }
        let planner = Planner::new(&options).with_quality(quality);
        planner.plan(scene.0.scene.clone(), before.map(|plan| &plan.0), control).map(Plan)
    })
}
