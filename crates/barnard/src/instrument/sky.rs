//! How bright the sky is.

use spectra::passband::Passband;

use crate::error::{Error, Result};
use crate::observation::{InUnit, RadianceUnit};

/// The brightness of the sky by passband: magnitudes of a square arcsecond.
#[derive(Debug, Clone, PartialEq)]
pub struct Sky {
    /// The zero point: [`Ab`](RadianceUnit::Ab), [`St`](RadianceUnit::St) or [`Vega`](RadianceUnit::Vega).
    pub system: RadianceUnit,
    /// The magnitude in each passband, in order, or one for all; none where the sky is dark.
    pub magnitudes: Vec<f64>,
    /// Magnitudes by the name of a passband, where there is no list; the nearest in wavelength holds for others.
    pub by_name: &'static [(&'static str, f64)],
}

impl Default for Sky {
    /// A dark sky.
    fn default() -> Self {
        Self { system: RadianceUnit::Ab, magnitudes: Vec::new(), by_name: &[] }
    }
}

/// Magnitudes that a sky may have.
const RANGE: std::ops::RangeInclusive<f64> = -30.0..=40.0;

impl Sky {
    /// A sky of one AB magnitude in all bands.
    pub fn even(magnitude: f64) -> Self {
        Self { magnitudes: vec![magnitude], ..Self::default() }
    }

    pub(super) fn check(&self) -> Result<()> {
        match self.magnitudes.iter().find(|m| !RANGE.contains(*m)) {
            Some(wrong) => Err(Error::value("sky of an instrument", wrong, "a magnitude of a square arcsecond, from -30 to 40")),
            None => Ok(()),
        }
    }

    /// The magnitude by name, or of the named passband that is nearest in wavelength.
    fn nearest(&self, band: &Passband) -> Option<f64> {
        let apart = |name: &str| match Passband::named(name) {
            _ if name == band.name() => -1.0,
            Ok(own) => (own.pivot().0 / band.pivot().0).ln().abs(),
            Err(_) => f64::INFINITY,
        };
        self.by_name.iter().min_by(|a, b| apart(a.0).total_cmp(&apart(b.0))).map(|(_, magnitude)| *magnitude)
    }

    /// The radiance of the sky in a passband, the one of this number of so many [W m⁻² sr⁻¹].
    ///
    /// # Errors
    /// Where there are other than one or as many magnitudes as passbands, or the zero point is not known in the passband.
    pub fn radiance(&self, band: &Passband, number: usize, count: usize) -> Result<f64> {
        let magnitude = match self.magnitudes[..] {
            [] => self.nearest(band),
            [all] => Some(all),
            _ if self.magnitudes.len() == count => Some(self.magnitudes[number]),
            _ => {
                let said = format!("{} magnitudes for {count} passbands", self.magnitudes.len());
                return Err(Error::value("sky of an instrument", said, "one magnitude for all passbands, or one for each"));
            }
        };
        let Some(magnitude) = magnitude else { return Ok(0.0) };
        match self.system.of(band, None)? {
            InUnit::Magnitudes { zero } => Ok(zero * 10f64.powf(-0.4 * magnitude)),
            InUnit::Times(_) => Err(Error::value("sky of an instrument", "no magnitudes", "one of the systems AB, ST or Vega")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sky of 21 mag is a star of 21 mag in each square arcsecond; named ones hold by name, or for those that are nearest.
    #[test]
    fn skies_are_as_bright_as_said() {
        use spectra::sed::{MagnitudeSystem, zero_point};
        let band = |name: &str| Passband::named(name).unwrap();
        let star = zero_point(&band("johnson-V"), MagnitudeSystem::Ab).unwrap() * 10f64.powf(-0.4 * 21.0);
        let own = Sky::even(21.0).radiance(&band("johnson-V"), 0, 1).unwrap() * (std::f64::consts::PI / 648_000.0).powi(2);
        assert!((own / star - 1.0).abs() < 1e-9, "{own} {star}");
        let named = Sky { by_name: &[("johnson-B", 22.0), ("johnson-V", 21.0)], ..Sky::default() };
        let even = |magnitude: f64, name: &str| Sky::even(magnitude).radiance(&band(name), 0, 1).unwrap();
        for (name, magnitude) in [("johnson-B", 22.0), ("johnson-V", 21.0), ("amateur-ha-3nm", 21.0), ("galex-nuv", 22.0)] {
            assert_eq!(named.radiance(&band(name), 0, 1).unwrap(), even(magnitude, name), "{name}");
        }
        assert_eq!(Sky::default().radiance(&band("johnson-V"), 0, 1).unwrap(), 0.0);
        assert!(Sky { magnitudes: vec![20.0, 21.0], ..Sky::default() }.radiance(&band("johnson-V"), 0, 3).is_err());
    }
}
