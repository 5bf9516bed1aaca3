//! Wavelengths of a band, drawn in proportion to what its lights send through it.
//!
//! The band's lights, each divided by its own band total, are averaged on narrow cells; spectral lines are cells of no
//! width. A wavelength is drawn by inverting the sum over cells: [`SampledWavelengths::draw`] takes four at once, a
//! quarter of the way apart, so that each carries the others' light.

use spectra::passband::Passband;

use crate::error::Result;
use crate::light::{Light, Route, factor, law};
use crate::scene::Scene;

/// Wavelengths that a path carries.
pub const CARRIED: usize = 4;

/// Narrow cells of a band, and the places in each at which it is asked.
const CELLS: usize = 256;
const ASKED: usize = 4;
/// The least density of a cell inside the band, of the mean one.
const LEAST: f64 = 0.01;

/// One wavelength that was drawn, with all that a path needs of it.
#[derive(Debug, Clone, Copy)]
pub struct Wave {
    /// The wavelength [µm].
    pub lambda_um: f64,
    /// The extinction relative to V there [1].
    pub k: f64,
    /// The light whose line this is; a place of the continuum if none.
    line: Option<(usize, f64)>,
    /// R dλ over the chance of being drawn [µm]; of a line R over the chance [1].
    weight: f64,
}

impl Wave {
    /// Emission of `light` at this wavelength through the band, divided by the probability density of the wavelength.
    pub fn of(&self, light: usize, lights: &[Light]) -> f64 {
        match self.line {
            Some((owner, strength)) => {
                if owner == light {
                    self.weight * strength
                } else {
                    0.0
                }
            }
            None => self.weight * lights[light].spectrum.continuum(self.lambda_um),
        }
    }
}

/// The wavelengths of one band.
pub struct SampledWavelengths {
    band: Passband,
    law: std::sync::Arc<spectra::extinction::Extinction>,
    /// Borders of the cells [µm]; one more than there are.
    borders: Vec<f64>,
    lines: Vec<(f64, usize, f64)>,
    /// Chances of the cells, then of the lines, summed.
    cumulative: Vec<f64>,
}

impl SampledWavelengths {
    /// The distribution of wavelengths for the extended lights of `scene` through band number `band`.
    pub fn new(scene: &Scene, lights: &[Light], band: usize) -> Result<Self> {
        let (band, law) = (scene.bands[band].clone(), law(scene)?);
        let extended: Vec<usize> = (0..lights.len()).filter(|l| is_extended(lights[*l].route)).collect();
        let (low, high) = band.support_um();
        let width = (high - low) / CELLS as f64;
        let borders: Vec<f64> = (0..=CELLS).map(|i| low + width * i as f64).collect();
        let mut density = vec![0.0; CELLS];
        let mut lines: Vec<(f64, usize, f64, f64)> = Vec::new();
        for light in extended {
            let (spectrum, factor) = (&lights[light].spectrum, factor(lights[light].route, scene.dust.as_ref()));
            let sent = |lambda: f64| (band.response(lambda) * spectrum.continuum(lambda) * factor(lambda)).abs();
            let at = |cell: usize, i: usize| borders[cell] + width * (i as f64 + 0.5) / ASKED as f64;
            let weights: Vec<f64> =
                (0..CELLS).map(|cell| width / ASKED as f64 * (0..ASKED).map(|i| sent(at(cell, i))).sum::<f64>()).collect();
            let through = |line: &spectra::spectrum::Line| (band.response(line.lambda_um) * line.strength * factor(line.lambda_um)).abs();
            let own_lines = spectrum.lines_through(&band);
            let total = weights.iter().sum::<f64>() + own_lines.iter().map(through).sum::<f64>();
            if total > 0.0 {
                density.iter_mut().zip(weights).for_each(|(d, o)| *d += o / total);
                let shares = own_lines.iter().map(|line| (line.lambda_um, light, line.strength, through(line) / total));
                lines.extend(shares.filter(|l| l.3 > 0.0));
            }
        }
        let least = LEAST * density.iter().sum::<f64>() / CELLS as f64;
        density.iter_mut().for_each(|d| *d = d.max(least));
        let cumulative: Vec<f64> = density
            .into_iter()
            .chain(lines.iter().map(|l| l.3))
            .scan(0.0, |sum, d| {
                *sum += d;
                Some(*sum)
            })
            .collect();
        Ok(Self { band, law, borders, lines: lines.into_iter().map(|(l, owner, s, _)| (l, owner, s)).collect(), cumulative })
    }

    /// True if any light comes through.
    pub fn is_dark(&self) -> bool {
        self.total() <= 0.0
    }

    fn total(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// Wavelengths by a number in [0, 1): the first by itself, each other a step further around.
    pub fn draw(&self, u: f64) -> [Wave; CARRIED] {
        std::array::from_fn(|i| self.wave((u + i as f64 / CARRIED as f64).fract()))
    }

    fn wave(&self, u: f64) -> Wave {
        let at = u * self.total();
        let cell = self.cumulative.partition_point(|c| *c <= at).min(self.cumulative.len() - 1);
        let before = if cell == 0 { 0.0 } else { self.cumulative[cell - 1] };
        let chance = (self.cumulative[cell] - before) / self.total();
        let (lambda_um, line, measure) = match cell.checked_sub(CELLS) {
            Some(i) => (self.lines[i].0, Some((self.lines[i].1, self.lines[i].2)), 1.0),
            None => {
                let (low, high) = (self.borders[cell], self.borders[cell + 1]);
                let part = (at - before) / (self.cumulative[cell] - before);
                (low + part.clamp(0.0, 1.0) * (high - low), None, high - low)
            }
        };
        Wave { lambda_um, k: self.law.k(lambda_um), line, weight: self.band.response(lambda_um) * measure / chance }
    }
}

/// True if a light fills more than a point.
pub fn is_extended(route: Route) -> bool {
    matches!(route, Route::Scattered { .. } | Route::Emitted { .. } | Route::Background)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::lights;
    use std::sync::Arc;

    use glam::DVec3;
    use spectra::passband;
    use spectra::sed::BlackBody;
    use spectra::spectrum::{Line, Spectrum};
    use spectra::units::Temperature;

    use crate::camera::Camera;
    use crate::fixtures::ball;
    use crate::scene::{Background, Emission, SceneSpec};

    /// The wavelengths that are drawn bring each light's own band total in the mean, lines among them, and lines of
    /// others nothing.
    #[test]
    fn wavelengths_bring_the_band() {
        let line = |nm: f64, strength: f64| Line { lambda_um: 1e-3 * nm, strength: 1e-24 * strength };
        let gas = Emission::new(ball(1.0), Spectrum::of_lines(vec![line(656.28, 1.0), line(658.3, 0.4)]));
        let narrow = passband::names().into_iter().find(|n| n.to_lowercase().contains("f656n")).unwrap();
        let bands = ["cousins-R", narrow].map(|name| passband::Passband::by_name(name).unwrap());
        let camera = Camera::look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO).with_orthographic_pc(1.0).with_size(1, 1);
        let sky = Spectrum::continuous(1e-9, Arc::new(BlackBody(Temperature(3000.0))));
        let scene =
            SceneSpec::new(camera).with_bands(bands.to_vec()).with_emission(gas).with_background(Background::even(sky)).build().unwrap();
        let lights = lights(&scene).unwrap();
        for (b, band) in scene.bands.iter().enumerate() {
            let waves = SampledWavelengths::new(&scene, &lights, b).unwrap();
            for (l, light) in lights.iter().enumerate() {
                let continuum = band.integrate(|lambda| light.spectrum.continuum(lambda));
                let truth =
                    continuum + light.spectrum.lines().iter().map(|line| band.response(line.lambda_um) * line.strength).sum::<f64>();
                // Evenly spaced numbers: the sum over the inverse is the integral to the square of the step.
                let count = 100_000;
                let drawn = |i: usize| waves.draw((i as f64 + 0.5) / count as f64).iter().map(|w| w.of(l, &lights)).sum::<f64>();
                let mean = (0..count).map(drawn).sum::<f64>() / (count * CARRIED) as f64;
                assert!(truth > 0.0 && (mean / truth - 1.0).abs() < 1e-3, "{} {}: {mean:e} {truth:e}", band.name(), light.name);
            }
        }
    }
}
