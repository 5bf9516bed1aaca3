//! The explorer: fly through a nebula and change every spectrum while you look.
//!
//! `barnard_explorer` has the scene, the view and the pictures. [`engine`] is a worker that takes its orders. [`editor`] shows the tables of
//! the text as widgets by the rows of `scene::schema`. [`model`] is all that [`panels`] and the [`viewport`] read; they
//! send [`command`]s, which [`app`] does once a frame is drawn. [`timings`] measures the rate of frames, [`progress`] says how far a
//! picture is. Everything but [`open`] runs without a window.

pub mod app;
pub mod command;
pub mod editor;
pub mod engine;
pub mod export;
pub mod files;
pub mod layout;
pub mod model;
pub mod panels;
pub mod progress;
pub mod session;
pub mod timings;
pub mod viewport;
mod window;

pub use barnard_explorer::document::Origin;
pub use window::{Start, ViewerError, open};
