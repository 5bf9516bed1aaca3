//! Spectral energy distributions of stars, and the ways to say how bright one is.
//!
//! An embedded spectrum is one column of a table and one row of [`STARS`].

mod blackbody;
mod embedded;
mod power_law;
mod scale;

pub use blackbody::{BlackBody, planck};
pub use embedded::{STARS, StarEntry, star, vega};
pub use power_law::PowerLaw;
pub use scale::{MagnitudeSystem, Scale, StarShape, scaled, zero_point};
