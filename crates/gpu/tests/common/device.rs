//! The device of tests.

use super::Gpu;

/// A device; tests that ask for one are ignored unless it is said that there is one.
pub fn device() -> Gpu {
    Gpu::open().expect("this test needs a graphics adapter; software Vulkan (mesa-vulkan-drivers) is one")
}
