//! Radiance of one ray per wavelength.

use spectra::rule::{DepthSpan, mean_transmittance};
use spectra::spectrum::Line;

use crate::error::Result;
use crate::geometry::Ray;
use crate::light::{factor, law};
use crate::plan::pilots::march_f64::{Eye, RayMarch};
use crate::plan::pilots::star_columns::StarColumns;
use crate::plan::{Planned, Stepping};

/// The samples along a voxel.
const STEPS: f64 = 2.0;

/// The light of a ray without that of unresolved sources.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Optical depth at V of all that the ray passes \[1\].
    pub depth: f64,
    /// I_λ at the wavelengths that were asked for [W m⁻² sr⁻¹ µm⁻¹].
    pub continuum: Vec<f64>,
    /// Spectral lines, each with its radiance [W m⁻² sr⁻¹].
    pub lines: Vec<Line>,
}

/// One wavelength: its extinction k, and the strength of each light there.
struct ProbeWave {
    k: f64,
    strength: Vec<f64>,
}

struct ProbeWaves {
    waves: Vec<ProbeWave>,
    radiance: Vec<f64>,
}

impl Eye for ProbeWaves {
    fn goes_on(&self) -> bool {
        true
    }

    fn light(&mut self, light: usize, amount: f64, depths: DepthSpan) {
        for (wave, radiance) in self.waves.iter().zip(&mut self.radiance).filter(|(wave, _)| wave.strength[light] != 0.0) {
            *radiance += amount * wave.strength[light] * mean_transmittance(wave.k * depths.from, wave.k * depths.to);
        }
    }
}

impl Planned {
    /// The spectrum that arrives along `ray` at `wavelengths_um`, in f64 with the star depths of this plan, exact ones
    /// where it has let go of them; the phase function is that of the first band's middle.
    ///
    /// # Errors
    /// If the extinction law is not known at one of the wavelengths.
    pub fn probe(&self, ray: &Ray, wavelengths_um: &[f64]) -> Result<Probe> {
        let scene = self.scene();
        let law = law(scene)?;
        let ends = wavelengths_um.iter().fold((f64::MAX, 0.0f64), |(low, high), l| (low.min(*l), high.max(*l)));
        if scene.dust.is_some() && ends.1 > 0.0 {
            law.check("the probe", ends.0, ends.1)?;
        }
        let factors: Vec<_> = self.lights.iter().map(|l| factor(l.route, scene.dust.as_ref())).collect();
        let continua = wavelengths_um.iter().map(|lambda| {
            let strength = self.lights.iter().zip(&factors).map(|(l, f)| l.spectrum.continuum(*lambda) * f(*lambda)).collect();
            ProbeWave { k: law.k(*lambda), strength }
        });
        let lines: Vec<(usize, Line)> =
            self.lights.iter().enumerate().flat_map(|(light, l)| l.spectrum.lines().iter().map(move |line| (light, *line))).collect();
        let lines: Vec<(usize, Line)> = lines.into_iter().filter(|(_, l)| (ends.0..=ends.1).contains(&l.lambda_um)).collect();
        let of_line = |(light, line): &(usize, Line)| {
            let strength = (0..self.lights.len()).map(|l| if l == *light { line.strength * factors[l](line.lambda_um) } else { 0.0 });
            ProbeWave { k: law.k(line.lambda_um), strength: strength.collect() }
        };
        let waves: Vec<ProbeWave> = continua.chain(lines.iter().map(of_line)).collect();
        let mut eye = ProbeWaves { radiance: vec![0.0; waves.len()], waves };
        let (stepping, exact) = (Stepping::PerVoxel(STEPS), self.light_field.is_some());
        // All stars are seen one by one: the field of the gathered ones knows no wavelengths but its own.
        let gathered = self.space.many_lights.iter().flat_map(|many_lights| &many_lights.stars);
        let columns = &StarColumns::new(&self.space, ray, self.space.marched().iter().chain(gathered).copied().collect(), 0.0);
        let march = RayMarch { space: &self.space, spectral: &self.spectral, lights: &self.lights, ray, stepping, exact, columns };
        let depth = march.run(&mut eye);
        let (continuum, strengths) = eye.radiance.split_at(wavelengths_um.len());
        let lines = lines.iter().zip(strengths).map(|((_, line), strength)| Line { strength: *strength, ..*line }).collect();
        Ok(Probe { depth, continuum: continuum.to_vec(), lines })
    }
}

#[cfg(test)]
mod tests {
    use crate::control::Control;
    use glam::DVec3;
    use spectra::sed::PowerLaw;
    use spectra::spectrum::{Line, Spectrum};
    use spectra::units::Wavelength;

    use crate::fixtures::{ball, dust, on_axis, scene, star};
    use crate::plan::{Options, Planner};
    use crate::scene::{Background, Emission};

    /// A power law of the wavelength, normalised at 550 nm.
    fn power_law(exponent: f64, level: f64) -> Spectrum {
        Spectrum::continuous(level, std::sync::Arc::new(PowerLaw { reference: Wavelength(0.55), exponent }))
    }

    /// The spectrum, seen through the passband, is what the reference sees in the pixel: starlight, gas with a line,
    /// and a background behind dust.
    #[test]
    fn spectra_add_up_to_bands() {
        let line = Line { lambda_um: 0.54, strength: 40e-24 };
        // 1 per nm is 10³ per µm.
        let glow = Spectrum::of_lines(vec![line]).plus(power_law(0.0, 1e-21));
        let scene = scene(on_axis(4.0, 10.0, (1, 1)), 48)
            .with_dust(dust(ball(1.0), "ccm89", 1.5))
            .with_star(star(9000.0, 100.0, DVec3::new(0.5, 0.9, 0.8)).hidden())
            .with_emission(Emission::new(ball(1.0), glow))
            .with_background(Background::even(power_law(-2.0, 1e-7)))
            .build()
            .unwrap();
        let options = Options::default();
        let scene = crate::plan::sample_functions(&scene, &options).unwrap();
        let plan = Planner::new(&options).plan(&scene, None, &Control::default()).unwrap();
        let truth = crate::render_reference(&scene, 1e-5, &Control::default()).unwrap().at(0, 0, 0);
        let band = &scene.bands[0];
        let (low, high) = band.support_um();
        let count = 2000;
        let step = (high - low) / count as f64;
        let wavelengths: Vec<f64> = (0..count).map(|i| low + (i as f64 + 0.5) * step).collect();
        let probe = plan.probe(&scene.camera.ray(0.5, 0.5), &wavelengths).unwrap();
        let continuum: f64 = wavelengths.iter().zip(&probe.continuum).map(|(l, v)| step * band.response(*l) * v).sum();
        let lines: f64 = probe.lines.iter().map(|l| band.response(l.lambda_um) * l.strength).sum();
        assert!(((continuum + lines) / truth - 1.0).abs() < 3e-3, "{continuum} {lines} {truth}");
        // Each part matters: without one of them the sum is another.
        assert!(lines > 0.02 * truth && continuum > 0.02 * truth && probe.lines.len() == 1);
        // Along the axis of a ball of radius 1 pc.
        assert!((probe.depth / 3.0 - 1.0).abs() < 0.03, "{}", probe.depth);
        assert!(plan.probe(&scene.camera.ray(0.5, 0.5), &[90.0]).is_err());
    }
}
