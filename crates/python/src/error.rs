//! Errors as exceptions of Python.

use barnard::Error;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::prelude::*;

create_exception!(barnard, BarnardError, PyException, "Something that Barnard could not do; the message says what would be right.");
create_exception!(
    barnard,
    SceneError,
    BarnardError,
    "Something in a scene is wrong: `key` is its place, such as `star[2].temperature`, where there is one; the message says what would be right."
);
create_exception!(barnard, MemoryLimitError, BarnardError, "Something would take more memory than `memory` allows.");
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
