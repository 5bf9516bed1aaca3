//! The λ-mathematics of Barnard, in f64 and without rendering: units, dust, spectra, passbands, rules for spectral
//! integrals, colour.
//!
//! Arrows only go down: nothing here knows of scenes, grids or images. Catalogues are tables of data; a new law,
//! spectrum, passband or rule is one file and one row.

pub mod air;
pub mod basis;
pub mod cie;
pub mod colour;
pub mod components;
pub mod constants;
pub mod curve;
pub mod embedded;
pub mod error;
pub mod exp_integral;
mod exponential;
pub mod extinction;
pub mod fingerprint;
pub mod hydrogen_continuum;
pub mod nebular;
mod number;
pub mod passband;
pub mod polynomial;
pub mod propagation;
pub mod quadrature;
pub mod rule;
pub mod sed;
mod simd;
pub mod spectrum;
pub mod table;
pub mod units;

pub use error::{Result, SpectraError};
