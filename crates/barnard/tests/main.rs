//! Renderings against what is known of them: one program, so that its tests share the processor.

mod bounces;
mod bricks;
mod cases;
mod common;
mod detail;
mod layers;
mod library;
mod many_lights;
mod methods;
mod panorama;
mod path;
mod plates;
mod sequence;
mod sparse;
mod stated;
mod truths;
