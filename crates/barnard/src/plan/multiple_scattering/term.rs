//! A node of a passband's rule as a medium: monochromatic transport.

use super::harmonics::{ALL_DEGREES, COUNT, degree};
use super::lanes::EightLanes;

/// A node as a medium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    pub lambda_um: f64,
    pub k: f64,
    pub albedo: f64,
    pub legendre: [f64; ALL_DEGREES + 1],
}

/// The albedo times the Legendre moment, ω p_l, of each harmonic and term.
pub fn scattering(terms: &[Term]) -> [EightLanes; COUNT] {
    std::array::from_fn(|h| std::array::from_fn(|t| terms.get(t).map_or(0.0, |term| (term.albedo * term.legendre[degree(h)]) as f32)))
}
