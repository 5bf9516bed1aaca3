//! Units of surface brightness.
//!
//! A band radiance B = ∫ R I_λ dλ is what a telescope measures through a passband; every unit below is one number of the passband
//! away from it. Densities are means over the passband, I_λ = B / ∫ R dλ, and I_ν = I_λ λ_p²/c, λ_p the
//! pivot wavelength, which makes both means those of one spectrum (Bessell & Murphy 2012, PASP 124, 140).

use crate::properties::Choices;
use spectra::constants::{PLANCK, SPEED_OF_LIGHT, SPHERE};
use spectra::curve::unit_symbols;
use spectra::passband::Passband;
use spectra::sed::{MagnitudeSystem, zero_point};

use crate::error::{Error, Result};

/// A square arcsecond \[sr\].
const SQUARE_ARCSECOND: f64 = (std::f64::consts::PI / 648_000.0) * (std::f64::consts::PI / 648_000.0);
/// 1 erg s⁻¹ cm⁻² Å⁻¹, which is 10 W m⁻² µm⁻¹, has ST magnitude minus this (Koornneef et al. 1986).
const ST_ZERO_MAGNITUDE: f64 = 21.10;
/// A Rayleigh, 10¹⁰/4π photons [s⁻¹ m⁻² sr⁻¹] (Hunten, Roach & Chamberlain 1956).
const RAYLEIGH: f64 = 1e10 / SPHERE;

/// The unit of a picture in a FITS file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum RadianceUnit {
    /// Band radiance [W m⁻² sr⁻¹].
    #[default]
    Si,
    /// Band radiance [erg s⁻¹ cm⁻² arcsec⁻²].
    Cgs,
    /// Mean radiance per frequency [MJy sr⁻¹].
    MegaJansky,
    /// Photons at the pivot wavelength \[Rayleigh\].
    Rayleigh,
    /// Photons at the pivot wavelength [s⁻¹ m⁻² sr⁻¹].
    Photons,
    /// Electrons that a pixel of the scene's instrument gathers [e s⁻¹].
    Electrons,
    /// Magnitudes of a square arcsecond, AB.
    Ab,
    /// Magnitudes of a square arcsecond, ST.
    St,
    /// Magnitudes of a square arcsecond, Vega.
    Vega,
}

impl Choices for RadianceUnit {
    const ROWS: &'static [(&'static str, Self)] = &[
        ("W m-2 sr-1", Self::Si),
        ("erg s-1 cm-2 arcsec-2", Self::Cgs),
        ("MJy/sr", Self::MegaJansky),
        ("R", Self::Rayleigh),
        ("photon s-1 m-2 sr-1", Self::Photons),
        ("electron s-1", Self::Electrons),
        ("mag/arcsec2 AB", Self::Ab),
        ("mag/arcsec2 ST", Self::St),
        ("mag/arcsec2 Vega", Self::Vega),
    ];
}

impl RadianceUnit {
    /// FITS name.
    pub fn fits(self) -> &'static str {
        match self {
            Self::Si => "W m-2 sr-1",
            Self::Cgs => "erg s-1 cm-2 arcsec-2",
            Self::MegaJansky => "MJy/sr",
            Self::Rayleigh => "R",
            Self::Photons => "photon s-1 m-2 sr-1",
            Self::Electrons => "electron s-1",
            Self::Ab | Self::St | Self::Vega => "mag arcsec-2",
        }
    }

    /// True if a text of a file spells this unit: "MJy / sr" and "MJy sr-1" are "MJy/sr".
    pub fn is_spelled(self, text: &str) -> bool {
        let sorted = |text: &str| {
            let mut symbols = unit_symbols(text);
            symbols.sort();
            symbols
        };
        text.trim() == self.fits() || sorted(text) == sorted(self.fits())
    }

    /// Short description.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Si | Self::Cgs => "band radiance, integral of R I_lambda",
            Self::MegaJansky => "mean I_nu at the pivot wavelength",
            Self::Rayleigh | Self::Photons => "photons at the pivot wavelength",
            Self::Electrons => "electrons of a pixel",
            Self::Ab | Self::St | Self::Vega => "magnitudes per square arcsecond",
        }
    }

    /// The zero point of magnitudes.
    pub fn magnitude_system(self) -> Option<&'static str> {
        match self {
            Self::Ab => Some("AB"),
            Self::St => Some("ST"),
            Self::Vega => Some("Vega"),
            _ => None,
        }
    }

    /// How band radiances through a passband become this unit; `electrons` is what an instrument's pixel gathers of 1 W m⁻² sr⁻¹ [e s⁻¹].
    ///
    /// # Errors
    /// If Vega's spectrum does not reach over the band, or there is no instrument that gathers electrons.
    pub fn of(self, band: &Passband, electrons: Option<f64>) -> Result<InUnit> {
        let (width_um, pivot_m) = (band.integrate(|_| 1.0), band.pivot().0 * 1e-6);
        let photons = pivot_m / (PLANCK * SPEED_OF_LIGHT);
        let magnitudes = |flux: f64| InUnit::Magnitudes { zero: flux / SQUARE_ARCSECOND };
        Ok(match self {
            Self::Si => InUnit::Times(1.0),
            // 1 W is 10⁷ erg/s, 1 m² is 10⁴ cm².
            Self::Cgs => InUnit::Times(1e3 * SQUARE_ARCSECOND),
            // [W m⁻² sr⁻¹ µm⁻¹] · m² µm / (m · µm) · 10⁶ µm/m; 1 MJy is 10⁻²⁰ W m⁻² Hz⁻¹.
            Self::MegaJansky => InUnit::Times(1e6 * pivot_m.powi(2) / (SPEED_OF_LIGHT * width_um) * 1e20),
            Self::Rayleigh => InUnit::Times(photons / RAYLEIGH),
            Self::Photons => InUnit::Times(photons),
            Self::Electrons => {
                let missing = || Error::missing("an instrument for unit electron s-1", "add [instrument] to the scene");
                InUnit::Times(electrons.ok_or_else(missing)?)
            }
            Self::Ab => magnitudes(zero_point(band, MagnitudeSystem::Ab)?),
            Self::St => magnitudes(10.0 * 10f64.powf(-0.4 * ST_ZERO_MAGNITUDE) * width_um),
            Self::Vega => magnitudes(zero_point(band, MagnitudeSystem::Vega)?),
        })
    }
}

/// Conversion of the radiances of a band to another unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InUnit {
    /// They are multiplied.
    Times(f64),
    /// They become magnitudes, zero where the radiance is this [W m⁻² sr⁻¹].
    Magnitudes {
        /// The radiance of magnitude zero.
        zero: f64,
    },
}

impl InUnit {
    /// A radiance [W m⁻² sr⁻¹] in the unit; where there is no light a magnitude is infinite.
    pub fn value(self, radiance: f64) -> f64 {
        match self {
            Self::Times(factor) => factor * radiance,
            Self::Magnitudes { zero } => -2.5 * (radiance.max(0.0) / zero).log10(),
        }
    }

    /// The standard error of a radiance, both [W m⁻² sr⁻¹], in the unit: to first order where that is magnitudes.
    pub fn error(self, error: f64, radiance: f64) -> f64 {
        match self {
            Self::Times(factor) => factor * error,
            Self::Magnitudes { .. } => 2.5 * std::f64::consts::LOG10_E * error / radiance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64, tolerance: f64) {
        assert!((a / b - 1.0).abs() < tolerance, "{a} is not {b}");
    }

    fn band(name: &str) -> Passband {
        Passband::by_name(name).unwrap()
    }

    /// A sky of 3631 Jy in a square arcsecond at all frequencies has AB magnitude zero, and as many MJy/sr as that is: 3631e-6 over
    /// 2.3504e-11 sr.
    #[test]
    fn megajanskys_and_magnitudes_agree() {
        for name in ["johnson-V", "hst-wfc3-f656n", "jwst-nircam-f200w"] {
            let InUnit::Magnitudes { zero } = RadianceUnit::Ab.of(&band(name), None).unwrap() else { panic!("no magnitudes") };
            let wanted = 3631e-6 / 2.350_443_053_909_789e-11;
            close(RadianceUnit::MegaJansky.of(&band(name), None).unwrap().value(zero), wanted, 1e-4);
        }
        // AB and ST are one where 3.631e-20 erg/s/cm2/Hz c/λ² is 3.631e-9 erg/s/cm2/angstrom, at 5475.6 angstrom.
        for name in ["hst-wfc3-f656n", "jwst-nircam-f200w"] {
            let value = |unit: RadianceUnit| unit.of(&band(name), None).unwrap().value(1e-8);
            let wanted = -5.0 * (band(name).pivot().0 / 0.547_56).log10();
            assert!((value(RadianceUnit::Ab) - value(RadianceUnit::St) - wanted).abs() < 1e-3, "{name}");
        }
    }

    /// Hα: one Rayleigh is 5.661e-18 erg/s/cm2/arcsec2 (Haffner et al. 2003, ApJS 149, 405: 2.41e-7 erg/s/cm2/sr).
    #[test]
    fn rayleighs_are_photons() {
        let narrow = band("hst-wfc3-f656n");
        let radiance = 1.0
            / match RadianceUnit::Rayleigh.of(&narrow, None).unwrap() {
                InUnit::Times(factor) => factor,
                InUnit::Magnitudes { .. } => panic!("no factor"),
            };
        close(RadianceUnit::Cgs.of(&narrow, None).unwrap().value(radiance), 5.661e-18, 2e-3);
        close(radiance * 1e3, 2.41e-7, 5e-3);
        close(RadianceUnit::Photons.of(&narrow, None).unwrap().value(radiance), 1e10 / (4.0 * std::f64::consts::PI), 1e-12);
    }

    /// No light has no magnitude, errors of magnitudes are relative, and Vega is not known everywhere.
    #[test]
    fn magnitudes_have_their_ends() {
        let unit = RadianceUnit::Vega.of(&band("johnson-V"), None).unwrap();
        assert!(unit.value(0.0) == f64::INFINITY && unit.value(-1.0) == f64::INFINITY);
        assert!((unit.value(1e-8) - unit.value(1e-6) - 5.0).abs() < 1e-12);
        close(unit.error(1e-10, 1e-8), 0.010_857_362, 1e-8);
        close(InUnit::Times(3.0).error(2.0, 1.0), 6.0, 1e-15);
    }
}
