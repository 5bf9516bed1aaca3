//! What several tests share.

pub mod chance;
pub mod clump;
