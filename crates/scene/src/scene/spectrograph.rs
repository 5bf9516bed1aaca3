//! The `[spectrograph]` table: hundreds of narrow passbands side by side, which files hold as a cube.

use spectra::passband::{Counting, Passband, Window, window};
use spectra::units::Wavelength;

use crate::error::Result;
use crate::image::SpectralAxis;
use crate::properties::{Integer, Key, KeyRow, Number, Required, Section};

const LOW: Key<Wavelength, Required> =
    Key::quantity::<Wavelength>("low", "lower edge of the first channel").example("\"400 nm\"").positive().required();
const HIGH: Key<Wavelength, Required> =
    Key::quantity::<Wavelength>("high", "upper edge of the last channel").example("\"700 nm\"").positive().required();
const COUNT: Key<Integer<usize>, Required> =
    Key::integer("count", "number of channels of equal width in wavelength").range(1..=MAX_CHANNELS).example("200").required();
const RESOLVING_POWER: Key<Number> = Key::number(
    "resolving_power",
    "resolving power: wavelength over the full width at half maximum of a Gaussian line; by default channels have sharp edges",
)
.range(1.0..=1e7)
.example("3000.0");
const REST_WAVELENGTH: Key<Wavelength> =
    Key::quantity::<Wavelength>("rest_wavelength", "vacuum wavelength of the line for velocities (RESTWAV)")
        .positive()
        .otherwise("the only line in range");

pub(super) const KEYS: &[KeyRow] = &[LOW.row, HIGH.row, COUNT.row, RESOLVING_POWER.row, REST_WAVELENGTH.row];

/// Most channels.
const MAX_CHANNELS: i64 = 4096;
/// The full width at half maximum of a Gaussian of deviation one.
const FWHM: f64 = 2.354_820_045_030_949;

/// Width of a sharp edge, relative to a channel.
const SHARP: f64 = 1e-7;

/// A spectrograph: its channels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spectrograph {
    /// The channels.
    pub axis: SpectralAxis,
}

impl Spectrograph {
    /// The one of some lines that its channels see \[µm\]; none where there is none, or more than one.
    pub(super) fn only_line(&self, lines_um: &[f64]) -> Option<f64> {
        let half = 0.5 * self.axis.step_um;
        let (low, high) = (self.axis.first_um - half, self.axis.middle_um(self.axis.count - 1) + half);
        let mut seen: Vec<f64> = lines_um.iter().copied().filter(|line| (low..high).contains(line)).collect();
        seen.dedup();
        match seen[..] {
            [one] => Some(one),
            _ => None,
        }
    }

    /// A channel's passband: one between its edges, spread by the width of a line, so that all channels together are one in between.
    ///
    /// # Errors
    /// If its wavelengths are none.
    pub fn channel(&self, number: usize) -> Result<Passband> {
        let (centre, width) = (Wavelength(self.axis.middle_um(number)), Wavelength(self.axis.step_um));
        // As many digits as tell one channel from the next.
        let digits = (1.0 - (1e3 * self.axis.step_um).log10().floor()).clamp(1.0, 9.0) as usize;
        let name = format!("{:.digits$} nm", centre.nm());
        // One width for all channels: their edges meet, and a line is neither lost nor seen twice, one that lies on an edge too.
        let deviation = match self.axis.resolving_power {
            Some(power) => self.axis.middle_um(self.axis.count / 2) / power / FWHM,
            None => SHARP * self.axis.step_um,
        };
        Ok(window(&name, Counting::Energy, Window::Channel { centre, width, deviation: Wavelength(deviation) })?)
    }
}

pub(super) fn build(section: &Section) -> Result<Spectrograph> {
    section.check(KEYS)?;
    let (low, high) = (section.read(&LOW)?.0, section.read(&HIGH)?.0);
    if high <= low {
        return Err(section.error(&HIGH, "high must exceed low"));
    }
    let count = section.read(&COUNT)?;
    let step_um = (high - low) / count as f64;
    let rest_um = section.read(&REST_WAVELENGTH)?.map(|rest| rest.0);
    let resolving_power = section.read(&RESOLVING_POWER)?;
    let spectrograph = Spectrograph { axis: SpectralAxis { first_um: low + 0.5 * step_um, step_um, count, rest_um, resolving_power } };
    section.wrap(&LOW, spectrograph.channel(0))?;
    Ok(spectrograph)
}

/// The passbands of all channels.
pub(super) fn bands(section: &Section, spectrograph: &Spectrograph) -> Result<Vec<Passband>> {
    (0..spectrograph.axis.count).map(|number| section.wrap(&COUNT, spectrograph.channel(number))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Channels together are one everywhere between the ends, on their edges too, however wide lines are.
    #[test]
    fn channels_are_one_together() {
        for resolving_power in [None, Some(2000.0)] {
            let axis = SpectralAxis { first_um: 0.49805, step_um: 1e-4, count: 40, rest_um: None, resolving_power };
            let spectrograph = Spectrograph { axis };
            let channels: Vec<Passband> = (0..40).map(|i| spectrograph.channel(i).unwrap()).collect();
            assert_eq!((channels[0].name(), channels[20].name()), ("498.05 nm", "500.05 nm"));
            for lambda in [0.4993, 0.5, 0.500_05, 0.5001, 0.500_123_4, 0.5007] {
                let sum: f64 = channels.iter().map(|channel| channel.response(lambda)).sum();
                assert!((sum - 1.0).abs() < 1e-3, "{lambda}: {sum}");
            }
            let width: f64 = channels.iter().map(|channel| channel.integrate(|_| 1.0)).sum();
            assert!((width / 4e-3 - 1.0).abs() < 1e-5, "{width}");
        }
    }
}
