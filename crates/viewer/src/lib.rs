//! The explorer: fly through a nebula and change every spectrum while you look.
//!
//! [`document`] is the scene's text, [`edit`] a change of it, [`editor`] its tables as widgets by the rows of
//! `scene::schema`. [`engine`] is a worker that takes an [`order`] and makes [`picture`]s in a [`studio`], coarse at
//! once, fine when nothing moves, by levels that an [`exposure`] holds. [`model`] is all that [`panels`] and the [`viewport`] read; they
//! send [`command`]s, which [`app`] does once a frame is drawn. [`flight`] moves the observer, [`visit`] plans a path into the cloud, [`clock`] the moment; [`keyframes`] and
//! [`tracks`] are keys of animations, [`timings`] measures the rate of frames, [`progress`] says how far a picture is. Everything but [`open`] runs without a window.

pub mod app;
pub mod clock;
pub mod command;
pub mod comparison;
pub mod document;
pub mod edit;
pub mod editor;
pub mod engine;
pub mod export;
pub mod exposure;
pub mod files;
pub mod flight;
pub mod keyframes;
pub mod layout;
pub mod model;
pub mod order;
mod origin;
pub mod panels;
pub mod picture;
pub mod probe;
pub mod progress;
pub mod session;
pub mod studio;
pub mod timings;
pub mod tracks;
pub mod viewport;
pub mod visit;
mod window;

pub use window::{Start, ViewerError, open};
