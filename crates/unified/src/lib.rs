//! Features of small dependencies that all larger builds of Barnard share.
//!
//! Cargo compiles a crate anew for each set of features of its dependencies. The explorer and its tests turn on features of `smallvec`, `half`
//! and others, which would compile the core crates twice. The feature `formats` of the command depends on this crate, so tests, explorer
//! and Python package share one compilation. `.ci/features.py` checks the list.
