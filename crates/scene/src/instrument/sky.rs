//! Sky brightness.

use spectra::passband::Passband;

use crate::error::{Error, Result};
use crate::observation::{InUnit, RadianceUnit};

/// The brightness of the sky by passband: magnitudes of a square arcsecond.
#[derive(Debug, Clone, PartialEq)]
pub struct Sky {
    /// The zero point: [`Ab`](RadianceUnit::Ab), [`St`](RadianceUnit::St) or [`Vega`](RadianceUnit::Vega).
    pub system: RadianceUnit,
    /// Surface brightness.
    pub brightness: Brightness,
}

/// Surface brightness of a sky, in magnitudes per square arcsecond.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub enum Brightness {
    /// No light.
    #[default]
    Dark,
    /// One magnitude per passband in order, or one for all.
    Listed(Vec<f64>),
    /// Magnitudes by passband name; other passbands use the nearest in wavelength.
    ByName(&'static [(&'static str, f64)]),
    /// Zodiacal light: its magnitude at V, scaled to other passbands by its spectrum.
    Zodiacal(f64),
}

/// Zodiacal light by wavelength \[µm\], 90° from the Sun in the ecliptic \[10⁻⁸ W m⁻² sr⁻¹ µm⁻¹\]: Leinert et al. 1998, A&AS 127, 1,
/// Table 19. Its colour is taken to be the same everywhere.
const ZODIACAL: [(f64, f64); 16] = [
    (0.2, 2.5),
    (0.3, 53.0),
    (0.4, 220.0),
    (0.5, 260.0),
    (0.7, 200.0),
    (0.9, 130.0),
    (1.0, 120.0),
    (1.2, 81.0),
    (2.2, 17.0),
    (3.5, 5.2),
    (4.8, 12.0),
    (12.0, 75.0),
    (25.0, 32.0),
    (60.0, 1.8),
    (100.0, 0.32),
    (140.0, 0.069),
];
/// Wavelength of its magnitude \[µm\].
const AT_V_UM: f64 = 0.55;

impl Default for Sky {
    /// A dark sky.
    fn default() -> Self {
        Self { system: RadianceUnit::Ab, brightness: Brightness::Dark }
    }
}

/// Magnitudes that a sky may have.
const RANGE: std::ops::RangeInclusive<f64> = -30.0..=40.0;

impl Sky {
    /// A sky of one AB magnitude in all bands.
    pub fn even(magnitude: f64) -> Self {
        Self { brightness: Brightness::Listed(vec![magnitude]), ..Self::default() }
    }

    /// Zodiacal light of an AB magnitude at V.
    pub fn zodiacal(magnitude: f64) -> Self {
        Self { brightness: Brightness::Zodiacal(magnitude), ..Self::default() }
    }

    pub(super) fn check(&self) -> Result<()> {
        let magnitudes = match &self.brightness {
            Brightness::Listed(magnitudes) => &magnitudes[..],
            Brightness::Zodiacal(magnitude) => std::slice::from_ref(magnitude),
            Brightness::Dark | Brightness::ByName(_) => &[],
        };
        match magnitudes.iter().find(|m| !RANGE.contains(*m)) {
            Some(wrong) => Err(Error::out_of_range("sky", wrong, "between -30 and 40 magnitudes per square arcsecond")),
            None => Ok(()),
        }
    }

    /// Radiance of the sky in a passband, by its index [W m⁻² sr⁻¹].
    ///
    /// # Errors
    /// If there are other than one or as many magnitudes as passbands, or the zero point is not known in the passband.
    pub fn radiance(&self, band: &Passband, number: usize, count: usize) -> Result<f64> {
        let magnitude = match &self.brightness {
            Brightness::Dark => return Ok(0.0),
            Brightness::Zodiacal(at_v) => at_v + zodiacal_colour(band.pivot().0),
            Brightness::ByName(named) => nearest(named, band),
            Brightness::Listed(magnitudes) => match magnitudes[..] {
                [all] => all,
                _ if magnitudes.len() == count => magnitudes[number],
                _ => {
                    let expected = format!("one magnitude for all passbands, or {count}, one for each");
                    return Err(Error::mismatch("sky", expected, magnitudes.len()));
                }
            },
        };
        match self.system.of(band, None)? {
            InUnit::Magnitudes { zero } => Ok(zero * 10f64.powf(-0.4 * magnitude)),
            InUnit::Times(_) => Err(Error::mismatch("sky", "magnitudes in AB, ST or Vega", "another unit")),
        }
    }
}

/// Magnitude of the passband with this name, or of the nearest in wavelength.
fn nearest(named: &[(&str, f64)], band: &Passband) -> f64 {
    let apart = |name: &str| match Passband::by_name(name) {
        _ if name == band.name() => -1.0,
        Ok(known) => (known.pivot().0 / band.pivot().0).ln().abs(),
        Err(_) => f64::INFINITY,
    };
    named.iter().min_by(|a, b| apart(a.0).total_cmp(&apart(b.0))).map_or(f64::INFINITY, |(_, magnitude)| *magnitude)
}

/// Zodiacal light at a wavelength \[µm\] relative to V, in AB magnitudes (positive is fainter).
fn zodiacal_colour(lambda_um: f64) -> f64 {
    // Per frequency, linear in both logarithms.
    let per_frequency = |lambda: f64| {
        let above = ZODIACAL.partition_point(|(known, _)| *known < lambda).clamp(1, ZODIACAL.len() - 1);
        let ((a, low), (b, high)) = (ZODIACAL[above - 1], ZODIACAL[above]);
        let part = (lambda / a).ln() / (b / a).ln();
        low * (high / low).powf(part) * lambda * lambda
    };
    -2.5 * (per_frequency(lambda_um) / per_frequency(AT_V_UM)).log10()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sky of 21 mag is a star of 21 mag in each square arcsecond; named ones hold by name, or for those that are nearest.
    #[test]
    fn skies_are_as_bright_as_said() {
        use spectra::sed::{MagnitudeSystem, zero_point};
        let band = |name: &str| Passband::by_name(name).unwrap();
        let star = zero_point(&band("johnson-V"), MagnitudeSystem::Ab).unwrap() * 10f64.powf(-0.4 * 21.0);
        let found = Sky::even(21.0).radiance(&band("johnson-V"), 0, 1).unwrap() * (std::f64::consts::PI / 648_000.0).powi(2);
        assert!((found / star - 1.0).abs() < 1e-9, "{found} {star}");
        let named = Sky { brightness: Brightness::ByName(&[("johnson-B", 22.0), ("johnson-V", 21.0)]), ..Sky::default() };
        let even = |magnitude: f64, name: &str| Sky::even(magnitude).radiance(&band(name), 0, 1).unwrap();
        for (name, magnitude) in [("johnson-B", 22.0), ("johnson-V", 21.0), ("amateur-ha-3nm", 21.0), ("galex-nuv", 22.0)] {
            assert_eq!(named.radiance(&band(name), 0, 1).unwrap(), even(magnitude, name), "{name}");
        }
        // Leinert's own numbers: at 2.2 um 17e-8 W m-2 sr-1 um-1 where there are 2.6e-6 at 0.5 um.
        let zodiacal = Sky::zodiacal(22.7);
        let per_um = |name: &str| zodiacal.radiance(&band(name), 0, 1).unwrap() / band(name).integrate(|_| 1.0);
        let ratio = per_um("twomass-Ks") / per_um("hst-wfc3-f502n");
        assert!((ratio / (17.0 / 260.0) - 1.0).abs() < 0.1, "{ratio}");
        assert!(per_um("hst-wfc3-f275w") < 0.2 * per_um("hst-wfc3-f502n"));
        assert_eq!(Sky::default().radiance(&band("johnson-V"), 0, 1).unwrap(), 0.0);
        assert!(Sky { brightness: Brightness::Listed(vec![20.0, 21.0]), ..Sky::default() }.radiance(&band("johnson-V"), 0, 3).is_err());
    }
}
