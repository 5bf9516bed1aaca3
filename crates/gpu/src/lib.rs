//! The pictures of `barnard` on a graphics processor: wgpu and WGSL, reading nothing but the plan.
//!
//! [`Gpu`] is a device, [`OnDevice`] a back end on it, [`DeviceMarch`] a plan that stays on the device while it changes.
//! `layout` turns a plan into flat tables and the shape of a shader, `forms` adds what the plan's spectral rule needs,
//! `frame` what changes from picture to picture; `shader` prints the shape (`shader_constants`) in front of `shaders/*.wgsl`, `written_out`
//! their loops, `pipelines` compiles them, `textures` uploads volumes, `resources` what fits, `march` keeps a plan on
//! the device, dispatches strips of rows and reads them back, `resolve` makes display colours of them, `sweep` the
//! depths of a star that has moved, `ordinates` light that is scattered more than once, `ray_tracer` light that ionises gas. Twins: a function of a shader names the Rust function that it repeats.

mod atlas;
mod backend;
#[cfg(test)]
mod bad_devices;
mod device;
mod error;
#[cfg(test)]
mod fixtures;
mod forms;
mod frame;
mod layout;
mod many_lights;
mod march;
mod ordinates;
mod pipelines;
mod ray_tracer;
mod resolve;
mod resources;
mod shader;
mod shader_constants;
mod shape;
mod signal;
mod sweep;
mod tables;
#[cfg(test)]
#[path = "../tests/common/device.rs"]
mod test_device;
mod textures;
mod tuning;
#[cfg(test)]
mod twins;
mod written_out;

pub use backend::{Auto, BACKENDS, OnDevice, unable};
pub use device::{Adapter, Gpu, adapters, device_descriptor};
pub use error::{GpuError, Result};
pub use march::DeviceMarch;
pub use ordinates::Ordinates;
pub use ray_tracer::IonisingRays;
pub use tuning::Tuning;
