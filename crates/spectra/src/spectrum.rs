//! Spectra: continua and lines together, of stars, gas and sky alike.
//!
//! The unit is the owner's: W µm⁻¹ for a star, W m⁻³ sr⁻¹ µm⁻¹ for gas, W m⁻² sr⁻¹ µm⁻¹ for a sky; lines carry the
//! integral over λ.

use std::sync::Arc;

use crate::constants::SPEED_OF_LIGHT;
use crate::error::{Result, SpectraError};
use crate::fingerprint::{Digest, Fingerprint};
use crate::passband::Passband;
use crate::quadrature::gauss_legendre;
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
    /// Adds the content to a digest. The default distinguishes objects by address.
    fn content(&self, digest: &mut Digest) {
        digest.object(self);
    }
}

impl Shape for Table {
    fn content(&self, digest: &mut Digest) {
        self.add_to(digest.text("table"));
    }
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
    /// The standard deviation of each line relative to its wavelength, zero for a narrow one.
    widths: Vec<f64>,
}

/// Standard deviations from its middle to which a broadened line reaches, and the pieces of it.
const REACH: f64 = 5.0;
/// Points and weights of a Gaussian, in standard deviations.
const HERMITE: [(f64, f64); 3] = [(-1.732_050_807_568_877_2, 1.0 / 6.0), (0.0, 2.0 / 3.0), (1.732_050_807_568_877_2, 1.0 / 6.0)];
const PIECES: usize = 8;
/// Points of a piece.
const PIECE_ORDER: usize = 4;

impl Spectrum {
    /// Fingerprint of all continua and lines.
    pub fn fingerprint(&self) -> Fingerprint {
        let mut digest = Digest::new("spectrum");
        digest.integer(self.continua.len() as u64);
        self.continua.iter().for_each(|(factor, shape)| shape.content(digest.number(*factor)));
        let lines: Vec<f64> = self.lines.iter().flat_map(|line| [line.lambda_um, line.strength]).collect();
        digest.numbers(&lines).numbers(&self.widths).finish()
    }

    /// `factor` times a continuous shape.
    pub fn continuous(factor: f64, shape: Arc<dyn Shape>) -> Self {
        Self { continua: vec![(factor, shape)], ..Self::default() }
    }

    /// A spectrum of lines alone.
    pub fn of_lines(lines: Vec<Line>) -> Self {
        Self { widths: vec![0.0; lines.len()], continua: Vec::new(), lines }
    }

    /// The sum of both spectra.
    pub fn plus(mut self, other: Spectrum) -> Self {
        self.continua.extend(other.continua);
        self.lines.extend(other.lines);
        self.widths.extend(other.widths);
        self
    }

    /// Copy of the spectrum, `factor` times as bright.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.continua.iter_mut().for_each(|(f, _)| *f *= factor);
        self.lines.iter_mut().for_each(|l| l.strength *= factor);
        self
    }

    /// Copy of the spectrum with lines that are Gaussians of this full width at half maximum in velocity; widths of lines
    /// that are broadened already add in squares.
    pub fn broadened(mut self, fwhm: Velocity) -> Self {
        let sigma = fwhm.0 * 1e3 / SPEED_OF_LIGHT / (8.0 * std::f64::consts::LN_2).sqrt();
        self.widths.iter_mut().for_each(|width| *width = width.hypot(sigma));
        self
    }

    /// Narrow lines that carry through a passband what the lines do: a line without a width as it is, a Gaussian as the
    /// points and weights of a Gauss rule on each piece of it on which the passband is smooth. Pieces are 1.25 σ wide at
    /// most, up to 5 σ from the middle, which is right to 6e-7 of the line. Where all of it lies in one piece, the three points of a
    /// Gauss–Hermite rule are right for curves of the fifth order.
    pub fn lines_through(&self, band: &Passband) -> Vec<Line> {
        let rule = gauss_legendre(PIECE_ORDER);
        let (low, high) = band.support_um();
        let ends = band.pieces(&[]);
        let mut lines = Vec::new();
        for (line, width) in self.lines.iter().zip(&self.widths) {
            let sigma = width * line.lambda_um;
            if sigma <= 0.0 {
                lines.push(*line);
                continue;
            }
            let reach = REACH * sigma;
            let is_within = low <= line.lambda_um - reach && line.lambda_um + reach <= high;
            if is_within && !ends.iter().any(|end| (end - line.lambda_um).abs() < reach) {
                let point =
                    |(apart, share): (f64, f64)| Line { lambda_um: line.lambda_um + apart * sigma, strength: line.strength * share };
                lines.extend(HERMITE.map(point));
                continue;
            }
            let inside = |lambda: &f64| (low..=high).contains(lambda) && (lambda - line.lambda_um).abs() <= REACH * sigma;
            let steps = (0..=PIECES).map(|i| line.lambda_um + sigma * REACH * (2.0 * i as f64 / PIECES as f64 - 1.0));
            let mut pieces: Vec<f64> = steps.chain(ends.iter().copied()).filter(inside).collect();
            pieces.sort_by(f64::total_cmp);
            for pair in pieces.windows(2) {
                let (centre, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
                lines.extend(rule.iter().map(|(x, weight)| {
                    let u = (centre + half * x - line.lambda_um) / sigma;
                    let share = half * weight * (-0.5 * u * u).exp() / (sigma * (2.0 * std::f64::consts::PI).sqrt());
                    Line { lambda_um: centre + half * x, strength: line.strength * share }
                }));
            }
        }
        lines
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

    /// The lines of the spectrum, by their middles.
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
    /// If they are not, with the interval in which they are.
    pub fn check(&self, what: &str, low_um: f64, high_um: f64) -> Result<()> {
        for (_, shape) in &self.continua {
            let (low, high) = shape.range_um();
            if low_um < low || high_um > high {
                return Err(SpectraError::Reach(format!(
                    "{what} requires the spectrum from {low_um:.4} to {high_um:.4} um, but it is tabulated only from {low:.4} to {high:.4} um; use another passband, or a spectrum such as blackbody"
                )));
            }
        }
        Ok(())
    }

    /// True if it is valid light at its tabulated points, its lines and in the middle of the visible: finite,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passband::{Counting, Window, window};
    use crate::units::Wavelength;

    /// Parts of a Gaussian within channels, by tables of the normal distribution (Abramowitz & Stegun 1964, table 26.1).
    #[test]
    fn broadened_lines_are_gaussians_in_every_channel() {
        // σ of 10 km/s at 500 nm; channel widths and distances from the middle in σ.
        let sigma_um = 0.5 * 10e3 / SPEED_OF_LIGHT;
        let fwhm = Velocity(10.0 * (8.0 * std::f64::consts::LN_2).sqrt());
        let line = Spectrum::of_lines(vec![Line { lambda_um: 0.5, strength: 2.0 }]).broadened(fwhm);
        let part = |middle: f64, width: f64| {
            let shape = Window::TopHat { centre: Wavelength(0.5 + middle * sigma_um), width: Wavelength(width * sigma_um) };
            let band = window("channel", Counting::Energy, shape).unwrap();
            line.lines_through(&band).iter().map(|line| line.strength * band.response(line.lambda_um)).sum::<f64>() / 2.0
        };
        for (middle, width, expected) in [
            (0.0, 2.0, 0.682_689_49),
            (0.0, 4.0, 0.954_499_74),
            (0.0, 40.0, 1.0),
            (0.0, 0.1, 0.039_877_61),
            (0.125, 0.25, 0.098_706_33),
            (0.5, 1.0, 0.341_344_75),
            (1.5, 1.0, 0.135_905_12),
            (8.0, 1.0, 0.0),
        ] {
            assert!((part(middle, width) - expected).abs() < 1e-6, "{middle} {width}: {}", part(middle, width));
        }
        let twice = line.broadened(fwhm);
        assert!((twice.widths[0] * SPEED_OF_LIGHT - 2f64.sqrt() * 10e3).abs() < 1e-3);
    }
}
