//! Instruments that there are.

use std::sync::Arc;

use spectra::SpectraError;

use super::psf::{Airy, Gaussian, Moffat};
use super::{Brightness, Detector, Filters, Instrument, Sky};
use crate::image::optics;
use crate::observation::RadianceUnit;

/// One row of the presets.
pub struct Preset {
    /// The name in scenes.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// Source of the numbers.
    pub source: &'static str,
    /// Makes it.
    pub make: fn() -> Instrument,
}

/// Families of filters.
const AMATEUR: [Filters; 1] = [Filters::all("amateur-")];
const UBVRI: [Filters; 4] = [Filters::all("johnson-"), Filters::all("cousins-"), Filters::all("bessell-"), Filters::all("sdss2010-")];
const LSST: [Filters; 1] = [Filters::all("lsst2023-")];

const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;

/// All presets.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "refractor-0.2m-duo",
        summary: "amateur refractor, 0.2 m, f/8, with a colour sensor (Sony IMX571) and a filter of [O III] and H-alpha, 3 nm each; bands = \"hoo-3nm\"",
        source: "sensor: ZWO, ASI2600MC Pro at gain 0 (0.76 e/ADU, 50 ke, 3.3 e, 3.76 um, dark at 0 C); assumed: 3 arcsec seeing, 0.6 of all light \
                 recorded beside the filter, a suburban sky of 20 mag (Vega), red pixels to see H-alpha alone and the others [O III]",
        make: || {
            let mosaic = ["amateur-ha-3nm", "amateur-oiii-3nm", "amateur-oiii-3nm", "amateur-oiii-3nm"].map(str::to_owned);
            Instrument {
                throughput: 0.6,
                psf: vec![Arc::new(Airy::default()), Arc::new(Moffat { fwhm_rad: 3.0 * ARCSEC, ..Moffat::default() })],
                filters: &AMATEUR,
                pixel_rad: Some(3.76e-6 / 1.6),
                sky: Sky { system: RadianceUnit::Vega, ..Sky::even(20.0) },
                detector: Detector {
                    dark_current: 0.003,
                    read_noise: 3.3,
                    gain: 0.76,
                    bias: 500.0,
                    full_well: 5e4,
                    pixel_um: 3.76,
                    // Secondary muons at sea level, one a minute and square centimetre (Particle Data Group 2022, 30.3.1).
                    cosmic_rays: 1.0 / 60.0,
                    mosaic: Some(mosaic),
                    ..Detector::default()
                },
                exposure_s: 300.0,
                frames: 24,
                ..Instrument::of_aperture(0.2)
            }
        },
    },
    Preset {
        name: "lco-1m-sinistro",
        summary: "1 m telescope of Las Cumbres Observatory with a Sinistro camera; passbands of Johnson, Cousins or Bessell",
        source: "camera: lco.global/observatory/instruments/sinistro (0.389 arcsec, 15 um, 7.8 e, 0.002 e/s, 110 ke); sky: Patat 2003, A&A 400, \
                 1183, Table 4 (dark, zenith; Vega); assumed: 2 e/ADU, of which 16 bits hold the well, 1.5 arcsec seeing, an obstruction of 0.4, 0.5 of all light recorded at the passband's peak",
        make: || Instrument {
            obstruction: 0.4,
            throughput: 0.5,
            psf: vec![Arc::new(Airy::default()), Arc::new(Moffat { fwhm_rad: 1.5 * ARCSEC, ..Moffat::default() })],
            filters: &UBVRI,
            pixel_rad: Some(0.389 * ARCSEC),
            sky: Sky {
                system: RadianceUnit::Vega,
                brightness: Brightness::ByName(&[
                    ("johnson-U", 22.28),
                    ("johnson-B", 22.64),
                    ("johnson-V", 21.61),
                    ("cousins-R", 20.87),
                    ("cousins-I", 19.71),
                    ("bessell-U", 22.28),
                    ("bessell-B", 22.64),
                    ("bessell-V", 21.61),
                    ("bessell-R", 20.87),
                    ("bessell-I", 19.71),
                ]),
            },
            detector: Detector {
                dark_current: 0.002,
                read_noise: 7.8,
                full_well: 1.1e5,
                bias: 1000.0,
                pixel_um: 15.0,
                cosmic_rays: 1.0 / 60.0,
                gain: 2.0,
                ..Detector::default()
            },
            exposure_s: 300.0,
            frames: 6,
            ..Instrument::of_aperture(1.0)
        },
    },
    Preset {
        name: "hst-wfc3-uvis",
        summary: "Hubble, Wide Field Camera 3, UVIS; passbands hst-wfc3-f200lp to f953n",
        source: "WFC3 Instrument Handbook, Table 5.1 (15 um, 0.040 arcsec, 11 e/h, 3.1 e, 1.55 e/DN, 63 to 72 ke); area of the whole mirror, since passbands \
                 hold its obstruction; sky: average zodiacal light of V = 22.7; assumed: 1.2 hits of cosmic rays /cm2/s, charge diffusion \
                 and jitter of 0.04 arcsec",
        make: || Instrument {
            obstruction: 0.33,
            collecting_area_m2: Some(4.5239),
            psf: vec![
                Arc::new(Airy { optics: optics::by_name("hubble").ok(), ..Airy::default() }),
                Arc::new(Gaussian { fwhm_rad: 0.04 * ARCSEC, ..Gaussian::default() }),
            ],
            filters: &[Filters { family: "hst-wfc3-", um: (0.19, 0.97) }],
            pixel_rad: Some(0.040 * ARCSEC),
            sky: Sky::zodiacal(22.7),
            detector: Detector {
                dark_current: 11.0 / 3600.0,
                read_noise: 3.1,
                gain: 1.55,
                bias: 2500.0,
                full_well: 68_000.0,
                pixel_um: 15.0,
                cosmic_rays: 1.2,
                ..Detector::default()
            },
            exposure_s: 600.0,
            frames: 4,
            ..Instrument::of_aperture(2.4)
        },
    },
    Preset {
        name: "jwst-nircam-short",
        summary: "Webb, NIRCam, short wavelengths: passbands jwst-nircam-f070w to f212n",
        source: "JWST User Documentation, NIRCam Detector Performance (0.031 arcsec, 18 um, 2.05 e/ADU, 15.8 e of a pair of reads, 0.0019 e/s, 105.8 ke); area of \
                 25.4 m2; sky: zodiacal light of V = 22.7; assumed: 5 hits of cosmic rays /cm2/s",
        make: || webb(0.031, 2.05, 15.8, 0.0019, 105_800.0, &SHORT),
    },
    Preset {
        name: "jwst-nircam-long",
        summary: "Webb, NIRCam, long wavelengths: passbands jwst-nircam-f250m to f480m",
        source: "JWST User Documentation, NIRCam Detector Performance (0.063 arcsec, 18 um, 1.82 e/ADU, 13.3 e of a pair of reads, 0.034 e/s, 83.3 ke); area of \
                 25.4 m2; sky: zodiacal light of V = 22.7; assumed: 5 hits of cosmic rays /cm2/s",
        make: || webb(0.063, 1.82, 13.3, 0.034, 83_300.0, &LONG),
    },
    Preset {
        name: "rubin-lsstcam",
        summary: "Rubin Observatory, LSSTCam: passbands lsst2023-u to y",
        source: "Rubin SMTN-002 (0.2 arcsec, an effective aperture of 6.423 m, 8.8 e, 0.2 e/s); Ivezic et al. 2019, ApJ 873, 111 (mirror 8.4 m, seeing 0.67 arcsec at \
                 500 nm, sky by band in Table 2; AB), full well 100 ke; assumed: 1.6 e/ADU",
        make: || Instrument {
            obstruction: 0.61,
            collecting_area_m2: Some(32.40),
            psf: vec![
                Arc::new(Airy { vanes: 4, vane_width: 0.005, ..Airy::default() }),
                Arc::new(Moffat { fwhm_rad: 0.67 * ARCSEC, ..Moffat::default() }),
            ],
            filters: &LSST,
            pixel_rad: Some(0.2 * ARCSEC),
            sky: Sky {
                system: RadianceUnit::Ab,
                brightness: Brightness::ByName(&[
                    ("lsst2023-u", 22.99),
                    ("lsst2023-g", 22.26),
                    ("lsst2023-r", 21.20),
                    ("lsst2023-i", 20.48),
                    ("lsst2023-z", 19.60),
                    ("lsst2023-y", 18.61),
                ]),
            },
            detector: Detector {
                dark_current: 0.2,
                read_noise: 8.8,
                gain: 1.6,
                bias: 1000.0,
                full_well: 1e5,
                pixel_um: 10.0,
                cosmic_rays: 1.0 / 60.0,
                ..Detector::default()
            },
            exposure_s: 30.0,
            frames: 10,
            ..Instrument::of_aperture(8.36)
        },
    },
];

/// The filters of both channels of NIRCam, which a mirror parts at 2.35 µm.
const SHORT: [Filters; 1] = [Filters { family: "jwst-nircam-", um: (0.5, 2.35) }];
const LONG: [Filters; 1] = [Filters { family: "jwst-nircam-", um: (2.35, 5.2) }];

/// One of the channels of NIRCam: pixel \[arcsec\], gain, read noise, dark current, full well, filters.
fn webb(pixel: f64, gain: f64, read_noise: f64, dark_current: f64, full_well: f64, filters: &'static [Filters]) -> Instrument {
    let detector =
        Detector { dark_current, read_noise, gain, full_well, bias: 1000.0, pixel_um: 18.0, cosmic_rays: 5.0, ..Detector::default() };
    Instrument {
        collecting_area_m2: Some(25.4),
        // The pupil is drawn in a circle of 6.6 m.
        psf: vec![Arc::new(Airy { optics: optics::by_name("webb").ok(), ..Airy::default() })],
        pixel_rad: Some(pixel * ARCSEC),
        filters,
        sky: Sky::zodiacal(22.7),
        detector,
        exposure_s: 300.0,
        frames: 4,
        ..Instrument::of_aperture(6.6)
    }
}

/// The preset called `name`.
///
/// # Errors
/// If there is none.
pub fn preset(name: &str) -> Result<Instrument, SpectraError> {
    let known: Vec<&str> = PRESETS.iter().map(|row| row.name).collect();
    let row = PRESETS.iter().find(|row| row.name == name).ok_or_else(|| SpectraError::unknown("instrument", name, &known))?;
    Ok(Instrument { name: row.name.to_owned(), ..(row.make)() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every preset is an instrument, and passbands that its sky and mosaic name are there.
    #[test]
    fn presets_are_instruments() {
        use spectra::passband::Passband;
        for row in PRESETS {
            let instrument = preset(row.name).unwrap();
            instrument.check().unwrap();
            let named = if let Brightness::ByName(named) = instrument.sky.brightness { named } else { &[] };
            for name in named.iter().map(|(name, _)| *name).chain(instrument.detector.mosaic.iter().flatten().map(String::as_str)) {
                assert!(Passband::by_name(name).is_ok(), "{}: {name}", row.name);
            }
            // A pupil whose name were misspelt would be a round one.
            for (telescope, optics) in [("hst", "hubble"), ("jwst", "webb")] {
                assert!(!row.name.starts_with(telescope) || instrument.psf[0].description().contains(optics), "{}", row.name);
            }
        }
        assert!(preset("hubble").map(|_| ()).unwrap_err().to_string().contains("hst-wfc3-uvis"));
    }

    /// Zero points of the handbooks, counts of a source of AB magnitude 0 to 25 in a second: WFC3 F606W 26.08 (Instrument Handbook, 9.3: an electron a
    /// second at 26.08 AB), Rubin r 28.36 (SMTN-002), both to 0.1 mag.
    #[test]
    fn zero_points_are_those_of_handbooks() {
        use spectra::passband::Passband;
        use spectra::sed::{MagnitudeSystem, zero_point};
        for (name, band, wanted) in [("hst-wfc3-uvis", "hst-wfc3-f606w", 26.08), ("rubin-lsstcam", "lsst2023-r", 28.36)] {
            let (instrument, band) = (preset(name).unwrap(), Passband::by_name(band).unwrap());
            let electrons = instrument.electrons(band.pivot().0) * zero_point(&band, MagnitudeSystem::Ab).unwrap();
            let zero = 2.5 * electrons.log10();
            assert!((zero - wanted).abs() < 0.1, "{name}: {zero}");
        }
    }
}
