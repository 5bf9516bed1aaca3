//! The device of tests.

use super::Gpu;

/// A device, or none with a loud word; in CI there must be one.
pub fn device() -> Option<Gpu> {
    match Gpu::open() {
        Ok(gpu) => Some(gpu),
        Err(error) if std::env::var_os("CI").is_some() => panic!("CI needs an adapter: {error}"),
        Err(error) => {
            eprintln!("SKIPPED, nothing of the GPU was compared: {error}");
            None
        }
    }
}
