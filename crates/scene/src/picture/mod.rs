//! Cameras and the images that they take.

pub mod camera;
pub mod composite;
pub mod image;
pub mod observation;
