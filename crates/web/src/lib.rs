//! Barnard in a browser: the engine and the explorer's document, view and pictures as WebAssembly.
//!
//! The page (`www/`) has two workers with an [`Explorer`] each. One makes quick pictures while things move, the other
//! the final one; it is ended where the scene changes before it is done, since a worker hears nothing while it computes.

mod catalogue;
mod device;
mod explorer;
mod files;
mod panics;
mod progress;
mod state;

pub use catalogue::{catalogue, thumbnail};
pub use device::open_device;
pub use explorer::Explorer;
pub use files::{give, needs};
pub use panics::{catch_panics, last_panic};
