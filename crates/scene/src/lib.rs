//! Scenes of Barnard: fields, dust, gas, stars, cameras, instruments and images. Crate `barnard` renders them.
//!
//! | | |
//! |---|---|
//! | [`scene`] | [`Scene`], its parts, and the reader of scene files |
//! | [`field`], [`detail`], [`phase`] | densities, noise below their voxels, phase functions |
//! | [`light`], [`points`], [`star_catalogue`], [`star_field`] | sources of light, and stars drawn as points |
//! | [`camera`], [`image`], [`composite`], [`observation`] | projections, band radiances with their display, positions on the sky |
//! | [`instrument`] | point-spread functions, detectors and exposures |
//! | [`animation`] | keyframes, paths and time lines |
//! | [`properties`], [`data`] | the neutral tree that scenes are read from, and access to arrays and tables by name |

pub mod animation;
mod base;
#[doc(hidden)]
pub mod fixtures;
pub mod instrument;
mod lights;
mod medium;
mod picture;
pub mod scene;

pub use base::{blocks, cache, control, data, error, geometry, keywords, memory, properties, random, stored};
pub use camera::Camera;
pub use control::Control;
pub use error::{Error, Result};
pub use glam;
pub use image::Image;
pub use lights::{light, points, star_catalogue, star_field};
pub use medium::{detail, field, phase};
pub use picture::{camera, composite, image, observation};
pub use scene::Scene;
pub use spectra;

use base::{curve, place};
