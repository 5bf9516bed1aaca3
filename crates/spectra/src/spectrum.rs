//! Spectra: continua and lines together, of stars, gas and sky alike.
//!
//! The unit is the owner's: W µm⁻¹ for a star, W m⁻³ sr⁻¹ µm⁻¹ for gas, W m⁻² sr⁻¹ µm⁻¹ for a sky; lines carry the
//! integral over λ.

use std::sync::Arc;

use crate::constants::SPEED_OF_LIGHT;
use crate::error::{Result, SpectraError};
use crate::table::Table;
use crate::units::Velocity;

/// A continuous spectral shape, which can be implemented outside of this crate.
pub trait Shape: std::fmt::Debug + Send + Sync {
    /// The value at λ \[µm\], in the shape's own unit; zero outside of its range.
    fn at(&self, lambda_um: f64) -> f64;
    /// The interval in which the shape is known, (lowest, highest) \[µm\].
    fn range_um(&self) -> (f64, f64) {
        (0.0, f64::INFINITY)
    }
    /// Wavelengths at which it is not smooth \[µm\].
    fn breakpoints_um(&self) -> &[f64] {
        &[]
    }
}

impl Shape for Table {
    fn at(&self, lambda_um: f64) -> f64 {
        self.at_or_zero(lambda_um)
    }
    /// A table that has come down to zero at an end is known to be zero beyond it.
    fn range_um(&self) -> (f64, f64) {
        let ended = |y: f64| y == 0.0;
        let (low, high) = self.range();
        (if ended(self.y()[0]) { 0.0 } else { low }, if ended(self.y()[self.y().len() - 1]) { f64::INFINITY } else { high })
    }
    fn breakpoints_um(&self) -> &[f64] {
        self.x()
    }
}

/// A spectral line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// The wavelength \[µm\].
    pub lambda_um: f64,
    /// The integral over wavelength, in the spectrum's unit times µm.
    pub strength: f64,
}

/// A spectrum: continua and lines.
#[derive(Debug, Clone, Default)]
pub struct Spectrum {
    continua: Vec<(f64, Arc<dyn Shape>)>,
    lines: Vec<Line>,
}

/// Points of a broadened line: enough for a Gaussian within ±4 σ to 1e-6.
const PROFILE_POINTS: usize = 33;

impl Spectrum {
    /// `factor` times a continuous shape.
    pub fn continuous(factor: f64, shape: Arc<dyn Shape>) -> Self {
        Self { continua: vec![(factor, shape)], lines: Vec::new() }
    }

    /// A spectrum of lines alone.
    pub fn of_lines(lines: Vec<Line>) -> Self {
        Self { continua: Vec::new(), lines }
    }

    /// The sum of both spectra.
    pub fn plus(mut self, other: Spectrum) -> Self {
        self.continua.extend(other.continua);
        self.lines.extend(other.lines);
        self
    }

    /// The same spectrum, `factor` times as bright.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.continua.iter_mut().for_each(|(f, _)| *f *= factor);
        self.lines.iter_mut().for_each(|l| l.strength *= factor);
        self
    }

    /// The lines, each a Gaussian of this full width at half maximum in velocity.
    pub fn broadened(mut self, fwhm: Velocity) -> Self {
        let sigma = fwhm.0 * 1e3 / SPEED_OF_LIGHT / (8.0 * std::f64::consts::LN_2).sqrt();
        let offsets: Vec<f64> = (0..PROFILE_POINTS).map(|i| 8.0 * i as f64 / (PROFILE_POINTS - 1) as f64 - 4.0).collect();
        let total: f64 = offsets.iter().map(|u| (-0.5 * u * u).exp()).sum();
        self.lines = self
            .lines
            .iter()
            .flat_map(|line| {
                offsets.iter().map(move |u| Line {
                    lambda_um: line.lambda_um * (1.0 + u * sigma),
                    strength: line.strength * (-0.5 * u * u).exp() / total,
                })
            })
            .collect();
        self
    }

    /// The lines as they are seen of what recedes with a velocity: λ (1 + v/c). Continua stay.
    pub fn shifted(mut self, velocity: Velocity) -> Self {
        let factor = 1.0 + velocity.0 * 1e3 / SPEED_OF_LIGHT;
        self.lines.iter_mut().for_each(|line| line.lambda_um *= factor);
        self
    }

    /// The continuum at λ \[µm\].
    pub fn continuum(&self, lambda_um: f64) -> f64 {
        self.continua.iter().map(|(f, s)| f * s.at(lambda_um)).sum()
    }

    /// The lines of the spectrum.
    pub fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// Wavelengths at which the continuum is not smooth \[µm\].
    pub fn breakpoints_um(&self) -> impl Iterator<Item = f64> + '_ {
        self.continua.iter().flat_map(|(_, s)| s.breakpoints_um().iter().copied())
    }

    /// Checks that the continua are known from `low_um` to `high_um`; the error names `what` asked.
    ///
    /// # Errors
    /// Where they are not, with the interval in which they are.
    pub fn check(&self, what: &str, low_um: f64, high_um: f64) -> Result<()> {
        for (_, shape) in &self.continua {
            let (low, high) = shape.range_um();
            if low_um < low || high_um > high {
                return Err(SpectraError::Reach(format!(
                    "{what} needs the spectrum from {low_um:.4} to {high_um:.4} um, but it is tabulated from {low:.4} to {high:.4} um only; choose another passband, or a spectrum such as blackbody that reaches further"
                )));
            }
        }
        Ok(())
    }

    /// Whether it is light as far as can be told at its own points, its lines and in the middle of the visible: finite,
    /// and nowhere negative.
    pub fn is_light(&self) -> bool {
        let sound = |v: f64| v.is_finite() && v >= 0.0;
        let (low, high) = self.continua.iter().fold((0.0f64, f64::INFINITY), |(low, high), (_, s)| {
            let (l, h) = s.range_um();
            (low.max(l), high.min(h))
        });
        let middle = 0.55f64.max(low).min(high);
        self.breakpoints_um().chain([middle]).all(|l| sound(self.continuum(l))) && self.lines.iter().all(|l| sound(l.strength))
    }

    /// Negative values are no light: the first wavelength \[µm\] at which a tabulated continuum or a line is negative,
    /// if any.
    pub fn first_negative_um(&self) -> Option<f64> {
        let in_tables = self.breakpoints_um().find(|&l| self.continuum(l) < 0.0);
        in_tables.or_else(|| self.lines.iter().find(|l| l.strength < 0.0).map(|l| l.lambda_um))
    }
}
