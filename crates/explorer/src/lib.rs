//! Exploring a scene without a window or a page: what the explorer on a desktop and the one in a browser share.
//!
//! [`document`] is the scene's text, [`edit`] a change of it. A [`studio`] takes an [`order`] and makes [`picture`]s, coarse at
//! once, fine when nothing moves, by levels that an [`exposure`] holds. [`flight`] moves the observer, [`visit`] plans a path into the
//! cloud, [`clock`] is the moment; [`keyframes`] and [`tracks`] are keys of animations, [`comparison`] is a second picture, and
//! [`probe`] the spectrum of a pixel.

pub mod clock;
pub mod comparison;
pub mod document;
pub mod edit;
pub mod exposure;
pub mod flight;
pub mod keyframes;
pub mod order;
mod origin;
pub mod picture;
pub mod probe;
mod reading;
pub mod studio;
pub mod tracks;
pub mod visit;
