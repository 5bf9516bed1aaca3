//! Foundations: errors, control of long work, memory limits, caches, geometry, random numbers, stored arrays, and the property tree.

pub mod blocks;
pub mod cache;
pub mod control;
pub mod curve;
pub mod data;
pub mod error;
pub mod geometry;
pub mod keywords;
pub mod memory;
pub mod place;
pub mod properties;
pub mod random;
pub mod shared;
pub mod stored;
