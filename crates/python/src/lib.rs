//! The native part of Barnard's Python package, as thin as can be: `python/barnard` is what people use.
//!
//! A scene comes as a tree of Python's own dictionaries, lists and values, and arrays by name beside it; work runs on
//! threads of its own, while the calling one handles Ctrl-C and progress.

mod arrays;
mod bricks;
mod bundle;
mod cache;
mod catalogue;
mod error;
mod fit;
mod image;
mod instrument;
mod open;
mod pickled;
mod plan;
mod plates;
mod report;
mod scene;
mod sequence;
mod tree;
mod work;

use std::ffi::OsString;
use std::process::ExitCode;

use pyo3::prelude::*;

/// Runs the command `barnard` with these arguments, the program's own name first; the exit code.
///
/// The process ends where they are none that the command has, as it does for `--help`.
#[pyfunction]
fn run(py: Python, arguments: Vec<OsString>) -> u8 {
    let code = py.detach(|| barnard_cli::run(arguments));
    (0..u8::MAX).find(|status| ExitCode::from(*status) == code).unwrap_or(u8::MAX)
}

#[pymodule]
fn _barnard(module: &Bound<PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    error::add(module)?;
    module.add_class::<scene::Reader>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<sequence::Sequence>()?;
    module.add_class::<plan::Plan>()?;
    module.add_class::<image::Image>()?;
    module.add_class::<plates::Plates>()?;
    module.add_class::<fit::FitModel>()?;
    module.add_class::<fit::FitPixels>()?;
    module.add_class::<instrument::Exposures>()?;
    module.add_class::<bricks::Whole>()?;
    module.add_class::<bricks::StarSweep>()?;
    module.add_function(wrap_pyfunction!(run, module)?)?;
    module.add_function(wrap_pyfunction!(bundle::bake, module)?)?;
    module.add_function(wrap_pyfunction!(bundle::bake_image, module)?)?;
    module.add_function(wrap_pyfunction!(bundle::html, module)?)?;
    module.add_function(wrap_pyfunction!(cache::cache_facts, module)?)?;
    module.add_function(wrap_pyfunction!(cache::clear_cache, module)?)?;
    module.add_function(wrap_pyfunction!(work::after_fork, module)?)?;
    module.add_function(wrap_pyfunction!(work::set_threads, module)?)?;
    module.add_function(wrap_pyfunction!(tree::from_toml, module)?)?;
    module.add_function(wrap_pyfunction!(tree::to_toml, module)?)?;
    module.add_function(wrap_pyfunction!(tree::parameters, module)?)?;
    module.add_function(wrap_pyfunction!(plan::plan, module)?)?;
    module.add_function(wrap_pyfunction!(plates::plates, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit_model, module)?)?;
    module.add_function(wrap_pyfunction!(fit::free_keys, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit_pixels, module)?)?;
    module.add_function(wrap_pyfunction!(plates::read_plates, module)?)?;
    module.add_function(wrap_pyfunction!(sequence::sequence, module)?)?;
    module.add_function(wrap_pyfunction!(image::render, module)?)?;
    module.add_function(wrap_pyfunction!(pickled::state, module)?)?;
    module.add_function(wrap_pyfunction!(pickled::restored, module)?)?;
    module.add_function(wrap_pyfunction!(instrument::observe, module)?)?;
    module.add_function(wrap_pyfunction!(bricks::densities, module)?)?;
    module.add_function(wrap_pyfunction!(bricks::dust_bounds, module)?)?;
    module.add_function(wrap_pyfunction!(image::check_writable, module)?)?;
    module.add_function(wrap_pyfunction!(catalogue::schema, module)?)?;
    module.add_function(wrap_pyfunction!(catalogue::quantities, module)?)?;
    module.add_function(wrap_pyfunction!(catalogue::catalogue, module)?)?;
    module.add_function(wrap_pyfunction!(catalogue::catalogues, module)?)?;
    module.add_function(wrap_pyfunction!(catalogue::builtin_text, module)?)?;
    Ok(())
}
