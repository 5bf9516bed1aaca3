//! Spectral energy distributions of stars, and the ways to say how bright one is.
//!
//! An embedded spectrum is one column of a table, whose head names its spectral type.

mod atmosphere;
mod blackbody;
mod embedded;
mod power_law;
mod scale;
mod spectral_type;

pub use atmosphere::atmosphere;
pub use blackbody::{BlackBody, planck};
pub use embedded::{star, star_names, star_summary, vega};
pub use power_law::PowerLaw;
pub use scale::{Foreground, MagnitudeSystem, Scale, StarShape, blackbody, scaled, zero_point};
pub use spectral_type::SpectralType;
