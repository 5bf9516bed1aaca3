//! Detectors: from electrons to counts and back.

use rand_distr::{Distribution, Poisson, StandardNormal};

use crate::error::{Error, Result};
use crate::random::Counter;

/// A detector that counts electrons.
#[derive(Debug, Clone, PartialEq)]
pub struct Detector {
    /// Electrons that a pixel gathers in the dark [e s⁻¹].
    pub dark_current: f64,
    /// The standard deviation of reading a pixel \[e\].
    pub read_noise: f64,
    /// Electrons of a count [e ADU⁻¹].
    pub gain: f64,
    /// Counts of an empty pixel \[ADU\].
    pub bias: f64,
    /// Most electrons of a pixel \[e\]; infinite where nothing is lost.
    pub full_well: f64,
    /// Bits of a count.
    pub bits: u32,
    /// The edge of a pixel \[µm\], and the thickness of its silicon, for cosmic rays.
    pub pixel_um: f64,
    /// Hits of cosmic rays [cm⁻² s⁻¹].
    pub cosmic_rays: f64,
    /// The passbands that the pixels of a square of two by two see, from its upper left along its rows; none: each band is a frame.
    pub mosaic: Option<[String; 4]>,
}

impl Default for Detector {
    /// One without noise of its own: an electron is a count.
    fn default() -> Self {
        Self {
            dark_current: 0.0,
            read_noise: 0.0,
            gain: 1.0,
            bias: 0.0,
            full_well: f64::INFINITY,
            bits: 16,
            pixel_um: 10.0,
            cosmic_rays: 0.0,
            mosaic: None,
        }
    }
}

/// Margin of a full pixel below its full well, in standard deviations of the read noise.
const READINGS: f64 = 6.0;
/// Smallest full well, in the same unit.
const LEAST_WELL: f64 = 8.0;
/// Bias of an empty pixel above zero, in the same unit.
const BIAS: f64 = 6.0;
/// Means beyond this have no Poisson numbers: their noise is far below a count's part of them.
const COUNTABLE: f64 = 1e12;

impl Detector {
    pub(super) fn check(&self) -> Result<()> {
        for (what, value) in
            [("dark_current", self.dark_current), ("read_noise", self.read_noise), ("bias", self.bias), ("cosmic_rays", self.cosmic_rays)]
        {
            if !(0.0..=1e9).contains(&value) {
                return Err(Error::out_of_range(what, value, "between 0 and 1e9"));
            }
        }
        for (what, value) in [("gain", self.gain), ("full_well", self.full_well), ("pixel_size", self.pixel_um)] {
            if value.is_nan() || value <= 0.0 {
                return Err(Error::out_of_range(what, value, "above zero"));
            }
        }
        if !(1..=16).contains(&self.bits) {
            return Err(Error::out_of_range("bits", self.bits, "between 1 and 16"));
        }
        // Below a count of zero there is none: what reading takes away would be lost, and the mean be too large.
        if self.bias < self.least_bias() {
            let allowed = format!("at least {} ADU, so that read noise rarely gives negative counts", self.least_bias());
            return Err(Error::out_of_range("bias", self.bias, allowed));
        }
        if self.full_well <= LEAST_WELL * self.read_noise {
            return Err(Error::out_of_range("full_well", self.full_well, format!("more than {LEAST_WELL} times the read noise")));
        }
        if self.bias >= f64::from(self.largest()) {
            let allowed = format!("below the largest count of its bits, {}", self.largest());
            return Err(Error::out_of_range("bias", self.bias, allowed));
        }
        Ok(())
    }

    /// The smallest bias of which reading noise takes nothing away \[ADU\].
    pub fn least_bias(&self) -> f64 {
        (BIAS * self.read_noise / self.gain).ceil()
    }

    /// The largest count that its bits hold \[ADU\].
    pub fn largest(&self) -> u16 {
        u16::MAX >> (16 - self.bits.clamp(1, 16))
    }

    /// The count from which on a pixel is taken to be full \[ADU\]: that of its well, less what reading may take away.
    pub fn saturation(&self) -> u16 {
        let least = self.full_well - READINGS * self.read_noise;
        (least / self.gain + self.bias).clamp(0.0, f64::from(self.largest())).floor() as u16
    }

    /// Approximate number of pixels, of a given number, hit by cosmic rays in an exposure \[s\]: a track crosses six of them on the average.
    pub(super) fn charges(&self, pixels: usize, exposure_s: f64) -> f64 {
        6.0 * self.cosmic_rays * pixels as f64 * (self.pixel_um * 1e-4).powi(2) * exposure_s
    }

    /// Reads a pixel with a mean number of electrons, and those of cosmic rays in addition.
    pub fn read(&self, mean: f64, hits: f64, random: &mut Counter) -> u16 {
        let electrons = (gathered(mean, random) + hits).min(self.full_well) + noise(self.read_noise, random);
        (electrons / self.gain + self.bias).round().clamp(0.0, f64::from(self.largest())) as u16
    }

    /// The electrons that a count says.
    pub fn electrons(&self, count: u16) -> f64 {
        (f64::from(count) - self.bias) * self.gain
    }

    /// Variance of reading a pixel with a mean number of electrons \[e²\]: shot noise, read noise, and that of whole counts.
    pub fn variance(&self, mean: f64) -> f64 {
        mean.max(0.0) + self.read_noise.powi(2) + self.gain.powi(2) / 12.0
    }
}

/// A Poisson number of a mean.
fn gathered(mean: f64, random: &mut Counter) -> f64 {
    match Poisson::new(mean) {
        Ok(poisson) if mean < COUNTABLE => poisson.sample(random),
        // No light has no Poisson distribution either.
        _ => mean.max(0.0),
    }
}

/// A normal number of a standard deviation.
fn noise(deviation: f64, random: &mut Counter) -> f64 {
    let normal: f64 = StandardNormal.sample(random);
    deviation * normal
}

/// Both together.
pub(super) fn scattered(mean: f64, deviation: f64, random: &mut Counter) -> f64 {
    gathered(mean, random) + noise(deviation, random)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means and variances of many readings are as predicted, faint and bright (χ² of 20 000: 5 σ of their own scatter).
    #[test]
    fn readings_scatter_as_predicted() {
        let detector = Detector { read_noise: 4.0, gain: 1.7, bias: 300.0, ..Detector::default() };
        const COUNT: u64 = 20_000;
        for (i, mean) in [0.0, 0.3, 7.0, 150.0, 4e4].into_iter().enumerate() {
            let read = |k: u64| detector.electrons(detector.read(mean, 0.0, &mut Counter::new(i as u64, k)));
            let all: Vec<f64> = (0..COUNT).map(read).collect();
            let measured = all.iter().sum::<f64>() / COUNT as f64;
            let variance = all.iter().map(|v| (v - measured).powi(2)).sum::<f64>() / (COUNT - 1) as f64;
            let wanted = detector.variance(mean);
            assert!((measured - mean).abs() < 5.0 * (wanted / COUNT as f64).sqrt(), "{mean}: {measured}");
            // The kurtosis of Poisson numbers widens the scatter of a variance.
            let scatter = wanted * ((2.0 + 1.0 / mean.max(1.0)) / COUNT as f64).sqrt();
            assert!((variance - wanted).abs() < 5.0 * scatter, "{mean}: {variance} {wanted}");
        }
    }

    /// A pixel holds no more than its well, and a count no more than its bits.
    #[test]
    fn what_is_full_is_full() {
        let detector = Detector { full_well: 5e4, gain: 1.0, bias: 100.0, ..Detector::default() };
        assert_eq!(detector.saturation(), 50_100);
        for mean in [1e5, 1e11, 1e20, f64::INFINITY] {
            assert_eq!(detector.read(mean, 0.0, &mut Counter::new(1, 2)), 50_100);
        }
        let narrow = Detector { bits: 12, ..detector.clone() };
        assert_eq!((narrow.largest(), narrow.saturation(), narrow.read(1e5, 0.0, &mut Counter::new(1, 2))), (4095, 4095, 4095));
        assert_eq!(detector.read(0.0, 7.0, &mut Counter::new(1, 2)), 107);
    }
}
