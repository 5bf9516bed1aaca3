//! Shared parts of tests.

pub mod cases;
pub mod rendered;
