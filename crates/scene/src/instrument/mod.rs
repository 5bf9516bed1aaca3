//! Instrument: a telescope, the air, a detector and its noise.
//!
//! A pixel of solid angle Ω gathers, in an exposure of t seconds,
//!
//!   N = t [k Ω (B + B_s) + D],   k = A T λ_p/(h c),   A = (π/4) d² (1 − ε²),
//!
//! electrons on the average, B the picture's band radiance spread by the [point-spread function](psf). For passbands that count photons
//! k B is exact, since B λ_p/(h c) is what they count; for those that count energy all photons are taken to have the pivot wavelength.
//! What is read out is (Howell 2006, Handbook of CCD Astronomy, 4.4)
//!
//!   counts = ⌊(min(P(N) + H, w) + r G)/g + b + ½⌋, from 0 to 2ⁿ − 1,
//!
//! P a Poisson number, G a normal one, H the charge of cosmic rays. All numbers depend on the seed, the frame, the band and the pixel alone.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | d, ε, T | `aperture_m`, `obstruction`, `throughput` | m, 1, 1 |
//! | A | `collecting_area_m2`, if stated | m² |
//! | B_s | `sky` | mag arcsec⁻² |
//! | D, r, g, b, w, n | `detector`: dark current, read noise, gain, bias, full well, bits | e s⁻¹, e, e ADU⁻¹, ADU, e, 1 |
//! | t | `exposure_s` | s |
//!
//! Left out: charge that runs over into neighbours, nonlinearity, flat fields, and pixels that differ.

mod cosmic_rays;
mod detector;
mod exposures;
mod filters;
mod kernels;
mod layout;
mod master;
mod points;
mod presets;
pub mod psf;
mod rebinning;
mod sky;

use std::sync::Arc;

use spectra::constants::{PLANCK, SPEED_OF_LIGHT};

pub use detector::Detector;
pub use exposures::{Exposures, Frame};
pub use filters::Filters;
pub use kernels::Kernels;
pub use master::Flag;
pub use presets::{PRESETS, Preset, preset};
pub use psf::PointSpread;
pub use sky::{Brightness, Sky};

use crate::error::{Error, Result};

/// Telescope, atmosphere, detector and exposure.
///
/// # Examples
/// ```
/// use barnard_scene::instrument::{Instrument, preset};
///
/// let hubble = Instrument { exposure_s: 600.0, frames: 4, ..preset("hst-wfc3-uvis")? };
/// hubble.check()?;
/// assert!(hubble.area_m2() > 4.0);
/// # Ok::<(), barnard_scene::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Instrument {
    /// Name in headers.
    pub name: String,
    /// The diameter of the aperture \[m\].
    pub aperture_m: f64,
    /// The diameter of what stands in the middle of the aperture, as a part of it.
    pub obstruction: f64,
    /// The area that collects light \[m²\], where it is another than that of the ring of both.
    pub collecting_area_m2: Option<f64>,
    /// The part of the light that is recorded, beside what the passband says.
    pub throughput: f64,
    /// Point-spread functions, applied in sequence.
    pub psf: Vec<Arc<dyn PointSpread>>,
    /// The angle that a pixel of the detector sees \[rad\]; none: that of the picture.
    pub pixel_rad: Option<f64>,
    /// The passbands of the catalogue that it has; none: all.
    pub filters: &'static [Filters],
    /// True if it is asked for passbands that it does not have.
    pub allow_foreign_filters: bool,
    /// Sky brightness.
    pub sky: Sky,
    /// True if the master is without the sky's mean.
    pub subtract_sky: bool,
    /// The detector.
    pub detector: Detector,
    /// The exposure of a frame \[s\].
    pub exposure_s: f64,
    /// The number of frames.
    pub frames: usize,
    /// The seed of all noise.
    pub seed: u64,
}

/// Most frames: of all, the median of a pixel is asked.
pub const MAX_FRAMES: usize = 10_000;

impl Instrument {
    /// An instrument that records all light of an aperture \[m\] without noise of its own, diffraction alone spreading it.
    pub fn of_aperture(aperture_m: f64) -> Self {
        Self {
            name: "telescope".into(),
            aperture_m,
            obstruction: 0.0,
            collecting_area_m2: None,
            throughput: 1.0,
            psf: vec![Arc::new(psf::Airy::default())],
            pixel_rad: None,
            filters: &[],
            allow_foreign_filters: false,
            sky: Sky::default(),
            subtract_sky: true,
            detector: Detector::default(),
            exposure_s: 60.0,
            frames: 1,
            seed: 1,
        }
    }

    /// The area that collects light \[m²\].
    pub fn area_m2(&self) -> f64 {
        let ring = 0.25 * std::f64::consts::PI * self.aperture_m.powi(2) * (1.0 - self.obstruction.powi(2));
        self.collecting_area_m2.unwrap_or(ring)
    }

    /// The electrons that a band irradiance of 1 W m⁻² brings through a passband of a pivot wavelength \[µm\] [e s⁻¹ W⁻¹ m²].
    pub fn electrons(&self, pivot_um: f64) -> f64 {
        self.area_m2() * self.throughput * pivot_um * 1e-6 / (PLANCK * SPEED_OF_LIGHT)
    }

    /// Copy of the instrument with squares of `edge` × `edge` pixels summed after reading.
    #[must_use]
    pub fn binned(self, pixels: usize) -> Self {
        let (edge, area) = (pixels as f64, (pixels * pixels) as f64);
        let before = self.detector;
        let full_well = before.full_well.min((f64::from(before.largest()) - before.bias) * before.gain) * area;
        // The variances of whole counts and of readings add up.
        let detector = Detector {
            dark_current: before.dark_current * area,
            read_noise: before.read_noise * edge,
            gain: before.gain * edge,
            full_well,
            ..before
        };
        Self { pixel_rad: self.pixel_rad.map(|pixel| pixel * edge), detector, ..self }
    }

    /// True if another spreads and gathers the same light, however it records it.
    pub fn sees_like(&self, other: &Self) -> bool {
        let light = |instrument: &Self| {
            let name = String::new();
            Self { name, detector: Detector::default(), exposure_s: 1.0, frames: 1, seed: 0, subtract_sky: true, ..instrument.clone() }
        };
        light(self) == light(other) && self.detector.mosaic == other.detector.mosaic
    }

    /// Refuses what no instrument is.
    ///
    /// # Errors
    /// If a number is out of its range; the error states what is allowed.
    pub fn check(&self) -> Result<()> {
        let positive = "a finite number above zero";
        let numbers = [
            ("aperture", self.aperture_m, 0.0, f64::MAX, "a length above zero, such as \"0.2 m\""),
            ("exposure", self.exposure_s, 0.0, 1e9, "a time above zero and up to 1e9 s, such as \"300 s\""),
            ("collecting_area", self.collecting_area_m2.unwrap_or(1.0), 0.0, f64::MAX, positive),
            ("pixel_scale", self.pixel_rad.unwrap_or(1.0), 0.0, std::f64::consts::PI, "an angle above zero, such as \"0.4 arcsec\""),
        ];
        for (what, value, above, most, wanted) in numbers {
            if !(value > above && value <= most && value.is_finite()) {
                return Err(Error::out_of_range(what, value, wanted));
            }
        }
        if !(0.0..1.0).contains(&self.obstruction) {
            return Err(Error::out_of_range("obstruction", self.obstruction, "a fraction of the aperture, at least 0 and below 1"));
        }
        if !(self.throughput > 0.0 && self.throughput <= 1.0) {
            return Err(Error::out_of_range("throughput", self.throughput, "a fraction above 0 and up to 1"));
        }
        if !(1..=MAX_FRAMES).contains(&self.frames) {
            return Err(Error::out_of_range("frames", self.frames, format!("between 1 and {MAX_FRAMES}")));
        }
        self.sky.check()?;
        self.detector.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vega in V sends about 1000 photons a second, square centimetre and angstrom (Bessell 1979: 995.5): 1 m² through a band of a width.
    #[test]
    fn vega_is_a_thousand_photons() {
        use spectra::passband::Passband;
        use spectra::sed::{MagnitudeSystem, zero_point};
        let band = Passband::by_name("johnson-V").unwrap();
        let whole = Instrument { collecting_area_m2: Some(1.0), ..Instrument::of_aperture(1.0) };
        let electrons = whole.electrons(band.pivot().0) * zero_point(&band, MagnitudeSystem::Vega).unwrap();
        let each = electrons / (1e4 * band.integrate(|l| band.pivot().0 / l) * 1e4);
        assert!((each / 995.5 - 1.0).abs() < 0.03, "{each}");
        // A ring with half of its diameter in the way has three quarters of the disc.
        let ring = Instrument { obstruction: 0.5, ..Instrument::of_aperture(2.0) };
        assert!((ring.area_m2() - 0.75 * std::f64::consts::PI).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_instrument_is_refused() {
        let plain = || Instrument::of_aperture(0.2);
        assert!(plain().check().is_ok());
        let detector = Detector::default();
        for (wrong, word) in [
            (Instrument { exposure_s: -3.0, ..plain() }, "exposure"),
            (Instrument { exposure_s: f64::NAN, ..plain() }, "exposure"),
            (Instrument { aperture_m: 0.0, ..plain() }, "aperture"),
            (Instrument { obstruction: 1.0, ..plain() }, "obstruction"),
            (Instrument { throughput: 1.5, ..plain() }, "throughput"),
            (Instrument { frames: 0, ..plain() }, "frames"),
            (Instrument { pixel_rad: Some(-1.0), ..plain() }, "pixel_scale"),
            (Instrument { detector: Detector { gain: 0.0, ..detector.clone() }, ..plain() }, "gain"),
            (Instrument { detector: Detector { read_noise: -1.0, ..detector.clone() }, ..plain() }, "read_noise"),
            (Instrument { detector: Detector { read_noise: 5.0, ..detector.clone() }, ..plain() }, "at least 30 ADU"),
            (Instrument { detector: Detector { bits: 40, ..detector.clone() }, ..plain() }, "bits"),
            (Instrument { sky: Sky::even(f64::NAN), ..plain() }, "sky"),
        ] {
            let message = wrong.check().unwrap_err().to_string();
            assert!(message.contains(word), "{word}: {message}");
        }
    }
}
