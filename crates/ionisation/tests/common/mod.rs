//! Shared parts of tests.

pub mod chance;
pub mod clump;
