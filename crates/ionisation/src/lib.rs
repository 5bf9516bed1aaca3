//! Photo-ionised gas: what stars make of a density.
//!
//! Units are those of the field: cm, s, eV, K; energies of gas in erg.

pub mod atoms;
pub mod balance;
pub mod beam;
pub mod benchmarks;
mod blocks;
pub mod cloud;
pub mod coefficients;
pub mod emitted;
pub mod error;
mod follow;
mod known;
pub mod lanes;
pub mod light;
pub mod lit;
mod nodes;
pub mod packet;
mod passes;
pub mod patch;
pub mod processor;
mod quantity;
pub mod rays;
pub mod sphere;
mod spread;
mod state;
mod tally;
mod thermostat;
pub mod tracer;
mod transport;
pub mod voxel;
