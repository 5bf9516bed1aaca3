//! Packets of rays: the arithmetic and the reads that the star depths and the march share. Shaders have twins of the
//! arithmetic.

mod exp_integral;
mod fetch;
mod lane;
mod quads;
mod shared_cells;
mod track;

pub use exp_integral::{EULER, EXP_INTEGRAL_LEVELS, EXP_INTEGRAL_TERMS, scaled_exp_integrals};
pub use fetch::Cursor;
pub(crate) use lane::lanes;
pub use lane::{LANES, Lane, RowPlace, SERIES_LIMIT, exp, fma, largest, ln, mean_transmittance, place, sinhc};
pub use quads::{four, lerp};
pub use track::{PacketPlaces, Track};
