//! Stellar brightness: four ways to scale a spectral shape.
//!
//! | way | equation | unit of L_λ |
//! |---|---|---|
//! | luminosity | L_λ = L s(λ)/∫ s dλ | W µm⁻¹ |
//! | radius | L_λ = 4π R² F_λ, F_λ = π B_λ(T) of a black body | W µm⁻¹ |
//! | magnitude | L_λ = 4π d² F₀ 10^(−0.4 m) s(λ) / ∫ R s dλ, F₀ the band flux of magnitude zero | W µm⁻¹ |
//! | spectral luminosity | L_λ = L_λ0 s(λ)/s(λ₀) | W µm⁻¹ |
//!
//! Extinction on the way to an observed magnitude is a factor 10^(−0.4 A_V k(λ)) of s in the denominator; without it
//! magnitudes are those without dust. Vega has magnitude zero in every band of the Vega system (CALSPEC
//! alpha_lyr_stis_011; its true 0.03 at V is left out); AB is Oke & Gunn 1983.

use std::sync::Arc;

use super::{BlackBody, vega};
use crate::constants::{AB_ZERO_POINT, PARSEC, SOLAR_RADIUS, SPEED_OF_LIGHT, SPHERE, STEFAN_BOLTZMANN};
use crate::error::{Result, SpectraError};
use crate::extinction::Extinction;
use crate::passband::Passband;
use crate::spectrum::{Shape, Spectrum};
use crate::table::Table;
use crate::units::{Length, Luminosity, Magnitude, SpectralLuminosity, Temperature, Wavelength};

/// The zero point of magnitudes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum MagnitudeSystem {
    /// The star Vega has magnitude zero.
    Vega,
    /// A source of f_ν = 3631 Jy at all frequencies has magnitude zero.
    Ab,
}

/// The scale of a spectrum: how bright the star is.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Scale {
    /// The star has this bolometric luminosity.
    Luminosity(Luminosity),
    /// Radius of a black body or of a model atmosphere.
    Radius(Length),
    /// Apparent magnitude in a band at a distance, behind dust or without.
    Magnitude(Magnitude, Box<Passband>, Length, MagnitudeSystem, Option<Foreground>),
    /// Luminosity per wavelength at a wavelength.
    SpectralLuminosity(SpectralLuminosity, Wavelength),
}

/// Dust between a star and who measured its magnitude.
#[derive(Debug, Clone)]
pub struct Foreground {
    /// The extinction A_V on the way.
    pub extinction: Magnitude,
    /// The shape of that extinction over wavelength.
    pub law: Arc<Extinction>,
}

impl Foreground {
    /// The part of the light that is left at a wavelength [1].
    fn transmittance(&self, lambda_um: f64) -> f64 {
        10f64.powf(-0.4 * self.extinction.0 * self.law.k(lambda_um))
    }
}

/// The kinds of shape that can be scaled.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum StarShape {
    /// A black body of this temperature.
    BlackBody(Temperature),
    /// Flux at the surface of a star of that temperature, F_λ [W m⁻² µm⁻¹] over λ \[µm\].
    Surface(Temperature, Arc<Table>),
    /// A table over λ \[µm\].
    Table(Arc<Table>),
    /// Any other shape, without a finite integral.
    Other(Arc<dyn Shape>),
}

/// The specific luminosity of a black body, L_λ = L B_λ(T) π/(σ T⁴) [W µm⁻¹].
pub fn blackbody(temperature: Temperature, luminosity: Luminosity) -> Spectrum {
    let factor = luminosity.0 * std::f64::consts::PI / (STEFAN_BOLTZMANN * temperature.0.powi(4));
    Spectrum::continuous(factor, Arc::new(BlackBody(temperature)))
}

/// The star's specific luminosity L_λ [W µm⁻¹].
///
/// # Errors
/// If shape and scale do not go together, or the spectrum is zero where its scale is fixed.
pub fn scaled(shape: StarShape, scale: &Scale) -> Result<Spectrum> {
    let dynamic: Arc<dyn Shape> = match &shape {
        StarShape::BlackBody(t) => Arc::new(BlackBody(*t)),
        StarShape::Table(t) | StarShape::Surface(_, t) => t.clone(),
        StarShape::Other(s) => s.clone(),
    };
    let factor = match (scale, &shape) {
        (Scale::Luminosity(l), StarShape::BlackBody(t)) => l.0 * std::f64::consts::PI / (STEFAN_BOLTZMANN * t.0.powi(4)),
        (Scale::Luminosity(l), StarShape::Surface(t, _)) => l.0 / (STEFAN_BOLTZMANN * t.0.powi(4)),
        (Scale::Luminosity(l), StarShape::Table(t)) => l.0 / trapezoid(t),
        (Scale::Luminosity(_), StarShape::Other(_)) => {
            return Err(SpectraError::Brightness(
                "this spectral shape has no finite luminosity; give spectral_luminosity at a wavelength instead".into(),
            ));
        }
        (Scale::Radius(r), StarShape::BlackBody(_)) => SPHERE * std::f64::consts::PI * (r.0 * PARSEC).powi(2),
        (Scale::Radius(r), StarShape::Surface(..)) => SPHERE * (r.0 * PARSEC).powi(2),
        (Scale::Radius(r), _) => {
            let solar = r.0 * PARSEC / SOLAR_RADIUS;
            return Err(SpectraError::Brightness(format!(
                "a radius ({solar:.3} Rsun) requires a black body or model atmosphere; give luminosity, magnitude or spectral_luminosity"
            )));
        }
        (Scale::Magnitude(m, band, distance, system, foreground), _) => {
            if let Some(dust) = foreground {
                let (low, high) = band.support_um();
                dust.law.check(&format!("passband {}", band.name()), low, high)?;
            }
            let left = |l: f64| foreground.as_ref().map_or(1.0, |dust| dust.transmittance(l));
            let shape_flux = band.integrate(|l| dynamic.at(l) * left(l));
            let flux = zero_point(band, *system)? * 10f64.powf(-0.4 * m.0);
            SPHERE * (distance.0 * PARSEC).powi(2) * flux / shape_flux
        }
        (Scale::SpectralLuminosity(l, at), _) => l.0 / dynamic.at(at.0),
    };
    if !factor.is_finite() || factor < 0.0 {
        return Err(SpectraError::Brightness("the spectrum is zero where its scale is defined; use another band or wavelength".into()));
    }
    Ok(Spectrum::continuous(factor, dynamic))
}

/// The integral of a table by trapezoids.
fn trapezoid(table: &Table) -> f64 {
    let (x, y) = (table.x(), table.y());
    (1..x.len()).map(|i| 0.5 * (x[i] - x[i - 1]) * (y[i] + y[i - 1])).sum()
}

/// Band flux ∫ R F_λ dλ of magnitude zero [W m⁻²].
///
/// # Errors
/// If Vega's spectrum does not reach over the band.
pub fn zero_point(band: &Passband, system: MagnitudeSystem) -> Result<f64> {
    match system {
        MagnitudeSystem::Ab => Ok(band.integrate(|l| AB_ZERO_POINT * SPEED_OF_LIGHT / (l * 1e-6).powi(2) * 1e-6)),
        MagnitudeSystem::Vega => {
            let vega = vega()?;
            let (low, high) = band.support_um();
            let (first, last) = vega.range();
            if low < first || high > last {
                return Err(SpectraError::Brightness(format!(
                    "Vega's spectrum covers {first:.4} to {last:.4} um, passband {} {low:.4} to {high:.4} um; use magnitude_system = \"ab\"",
                    band.name()
                )));
            }
            Ok(band.integrate(|l| vega.at(l)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Sun as a black body: L from R and T is the nominal luminosity within the rounding of 5772 K (IAU 2015 B3).
    #[test]
    fn radius_and_luminosity_agree_on_the_sun() {
        let sun = StarShape::BlackBody(Temperature(5772.0));
        let by_radius = scaled(sun.clone(), &Scale::Radius("1 Rsun".parse().unwrap())).unwrap();
        let by_luminosity = scaled(sun, &Scale::Luminosity("1 Lsun".parse().unwrap())).unwrap();
        assert!((by_radius.continuum(0.55) / by_luminosity.continuum(0.55) - 1.0).abs() < 2e-4);
    }

    /// The Sun has V = −26.76 at 1 au (Willmer 2018, Vega system, Johnson V).
    #[test]
    fn a_solar_spectrum_of_the_suns_magnitude_has_the_suns_luminosity_at_v() {
        let v = Passband::by_name("johnson-V").unwrap();
        let g2v = StarShape::Table(crate::sed::star("g2v").unwrap());
        let scale = Scale::Magnitude(Magnitude(-26.76), Box::new(v), "1 au".parse().unwrap(), MagnitudeSystem::Vega, None);
        let sun = scaled(g2v, &scale).unwrap();
        // Solar irradiance at 0.55 µm is 1.86 W m⁻² nm⁻¹ (ASTM E490); 4π au² of it is L_λ.
        let expected = SPHERE * crate::constants::ASTRONOMICAL_UNIT.powi(2) * 1860.0;
        assert!((sun.continuum(0.55) / expected - 1.0).abs() < 0.04, "{}", sun.continuum(0.55) / expected);
    }

    /// AB magnitude zero at pivot wavelength: F_λ = 3631 Jy c/λ_p² (definition of the pivot).
    #[test]
    fn ab_zero_point_is_the_pivots() {
        for name in ["sdss2010-r", "johnson-V", "hst-wfc3-f606w"] {
            let band = Passband::by_name(name).unwrap();
            let mean = zero_point(&band, MagnitudeSystem::Ab).unwrap() / band.integrate(|_| 1.0);
            let expected = AB_ZERO_POINT * SPEED_OF_LIGHT / (band.pivot().0 * 1e-6).powi(2) * 1e-6;
            assert!((mean / expected - 1.0).abs() < 1e-6, "{name} {mean} {expected}");
        }
    }

    /// Behind A_V = 2 a star that looks as bright is brighter: by two magnitudes and the little that a broad band makes
    /// of them, −2.5 lg of the mean of 10^(−0.4 A k) over its own light.
    #[test]
    fn dust_on_the_way_is_taken_off() {
        let v = Passband::by_name("johnson-V").unwrap();
        let law = Arc::new(Extinction::by_name("gordon23").unwrap());
        let scale = |dust: Option<Foreground>| {
            Scale::Magnitude(Magnitude(5.0), Box::new(v.clone()), "100 pc".parse().unwrap(), MagnitudeSystem::Vega, dust)
        };
        let hot = StarShape::BlackBody(Temperature(20_000.0));
        let plain = scaled(hot.clone(), &scale(None)).unwrap().continuum(0.55);
        let behind = scaled(hot, &scale(Some(Foreground { extinction: Magnitude(2.0), law: law.clone() }))).unwrap();
        let magnitudes = 2.5 * (behind.continuum(0.55) / plain).log10();
        assert!((magnitudes - 2.0).abs() < 0.06 && magnitudes != 2.0, "{magnitudes}");
        // And dimmed again it has the magnitude that was seen.
        let seen = v.integrate(|l| behind.continuum(l) * 10f64.powf(-0.8 * law.k(l)));
        let asked = zero_point(&v, MagnitudeSystem::Vega).unwrap() * 0.01;
        let sphere = SPHERE * (100.0 * PARSEC).powi(2);
        assert!((seen / sphere / asked - 1.0).abs() < 1e-12);
    }

    #[test]
    fn spectral_luminosity_is_met_at_its_wavelength() {
        let star = StarShape::BlackBody(Temperature(10_000.0));
        let scale = Scale::SpectralLuminosity("2 W/nm".parse().unwrap(), "550 nm".parse().unwrap());
        assert!((scaled(star, &scale).unwrap().continuum(0.55) - 2000.0).abs() < 1e-9);
    }
}
