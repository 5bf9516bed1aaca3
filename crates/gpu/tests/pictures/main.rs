//! Pictures of the graphics processor beside those of the processor: the same plan, the same light.

#[path = "../common/device.rs"]
mod test_device;

mod changes;
mod light;
mod parts;

use barnard_gpu::Gpu;
