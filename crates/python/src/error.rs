//! Errors as exceptions of Python.

use barnard::Error;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::prelude::*;

create_exception!(barnard, BarnardError, PyException, "Base class of all errors. A message has the problem, its location and the remedy.");
create_exception!(
    barnard,
    SceneError,
    BarnardError,
    "A scene is invalid. `key` is the location, such as `star[2].temperature`, if there is one."
);
create_exception!(barnard, MemoryLimitError, BarnardError, "An array, grid or image would exceed the memory limit of the scene.");
create_exception!(barnard, DeviceError, BarnardError, "A graphics processor could not be used.");

/// Adds the exceptions to the module.
pub fn add(module: &Bound<PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("BarnardError", py.get_type::<BarnardError>())?;
    module.add("SceneError", py.get_type::<SceneError>())?;
    module.add("MemoryLimitError", py.get_type::<MemoryLimitError>())?;
    module.add("DeviceError", py.get_type::<DeviceError>())
}

/// The exception that an error is.
pub fn raised(py: Python, error: Error) -> PyErr {
    let words = error.to_string();
    match error {
        Error::Interrupted => PyKeyboardInterrupt::new_err("interrupted"),
        Error::Memory { .. } => MemoryLimitError::new_err(words),
        Error::Device(_) => DeviceError::new_err(words),
        Error::Scene { message, place } => {
            let key = place.full_path();
            let error = SceneError::new_err(if place.origin.is_some() { words } else { format!("{key}: {message}") });
            match error.value(py).setattr("key", key) {
                Ok(()) => error,
                Err(failed) => failed,
            }
        }
        _ => SceneError::new_err(words),
    }
}
