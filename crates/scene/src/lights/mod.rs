//! Sources of light, and stars drawn as points.

pub mod light;
pub mod points;
pub mod star_catalogue;
pub mod star_field;
