//! The pictures of `barnard` on a graphics processor: wgpu and WGSL, reading nothing but the plan.
//!
//! [`Gpu`] is a device, [`render`] a picture. `layout` turns a plan into flat tables and the shape of a shader, `shader` prints that shape in front of
//! `shaders/*.wgsl`, `march` uploads, dispatches strips of rows and reads them back. Twins: a function of a shader names the Rust function that it repeats.

mod device;
mod error;
mod layout;
mod march;
mod shader;

pub use device::{Adapter, Gpu, adapters};
pub use error::{GpuError, Result};
pub use march::{Tuning, radiance, radiance_with, render, unable};
