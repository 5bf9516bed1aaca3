//! Barnard: physically calibrated spectral rendering of nebulae.
//!
//! [`scene::Scene`] is what a file says, [`plan::Plan`] the numbers it comes to, [`image::Image`] what a telescope sees; a back end
//! ([`backend`]) turns one into the other.

pub mod backend;
pub mod bench;
pub mod builtin;
pub mod camera;
pub mod catalogue;
pub mod control;
mod counter;
pub mod error;
pub mod field;
pub mod formats;
pub mod geometry;
pub mod image;
pub mod keywords;
pub mod light;
pub mod packet;
pub mod phase;
pub mod plan;
pub mod points;
pub mod scene;

pub use error::{Error, Result};
pub use glam;
