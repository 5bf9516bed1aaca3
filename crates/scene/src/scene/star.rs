//! The `[[star]]` tables, and the spectra that stars and backgrounds choose.

use std::sync::Arc;

use glam::DVec3;
use spectra::curve::Ordinate;
use spectra::extinction::Extinction;
use spectra::passband::{Passband, family};
use spectra::sed::{self, Foreground, MagnitudeSystem, PowerLaw, Scale, StarShape};
use spectra::spectrum::Spectrum;
use spectra::units::{Length, Luminosity, Magnitude, SpectralLuminosity, Temperature, Wavelength};

use crate::curve::{self, COLUMN, UNIT};
use crate::data::Inputs;
use crate::error::{Error, Result};
use crate::properties::{Key, Kind, Section, build_kind_with};

/// A star: a point that shines.
#[derive(Debug, Clone)]
pub struct Star {
    /// The name in certificates.
    pub name: String,
    /// The place of the star \[pc\].
    pub position: DVec3,
    /// The spectral luminosity L_λ [W µm⁻¹].
    pub spectrum: Spectrum,
    /// True if the star itself is drawn.
    pub visible: bool,
}

/// Fingerprint of the stars' ionising light, as a text.
pub(super) fn said(stars: &[Star]) -> String {
    // Samples from 2 to 100 nm tell one spectrum from another.
    let of = |star: &Star| {
        let light: Vec<String> = (0..40).map(|i| format!("{:e}", star.spectrum.continuum(0.002 * 1.1f64.powi(i)))).collect();
        format!("{} {}", star.position, light.join(" "))
    };
    stars.iter().map(of).collect::<Vec<_>>().join("; ")
}

impl Star {
    /// A star of specific luminosity `spectrum` [W µm⁻¹], at the origin; a visible point of light unless it is
    /// [hidden](Self::hidden).
    pub fn new(spectrum: Spectrum) -> Self {
        Self { name: "star".into(), position: DVec3::ZERO, spectrum, visible: true }
    }

    /// A black body of an effective temperature and a bolometric luminosity.
    pub fn blackbody(temperature: Temperature, luminosity: Luminosity) -> Self {
        Self::new(sed::blackbody(temperature, luminosity))
    }

    /// A star of the shape of a spectrum, as bright as `scale` says.
    ///
    /// # Errors
    /// If shape and scale do not go together, such as the radius of a power law.
    pub fn scaled(shape: StarShape, scale: &Scale) -> Result<Self> {
        Ok(Self::new(sed::scaled(shape, scale)?))
    }

    /// Copy of the star at another place \[pc\].
    #[must_use]
    pub fn at(self, position: DVec3) -> Self {
        Self { position, ..self }
    }

    /// Copy of the star under another name.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Copy of the star, whose light is seen on dust alone.
    #[must_use]
    pub fn hidden(self) -> Self {
        Self { visible: false, ..self }
    }

    /// Refuses numbers that no star has.
    pub(super) fn check(&self) -> Result<()> {
        if !self.position.is_finite() {
            return Err(Error::out_of_range("position", self.position, "finite"));
        }
        if !self.spectrum.is_light() {
            return Err(Error::out_of_range(
                "spectrum",
                format!("not finite for {}", self.name),
                "finite; temperature and luminosity must be above zero",
            ));
        }
        Ok(())
    }
}

/// Temperatures of black bodies whose light has a number at every wavelength that a passband may have [K].
const TEMPERATURES: std::ops::RangeInclusive<f64> = 1.0..=1e9;

/// All shapes of spectra that a star may have.
pub(super) const SPECTRA: &[Kind<StarShape>] = &[
    Kind {
        name: "blackbody",
        summary: "Planck function of a temperature",
        keys: &[Key::required("temperature", "temperature", "effective temperature")],
        build: |section, _| {
            let temperature = section.need_positive::<Temperature>("temperature")?;
            if !TEMPERATURES.contains(&temperature.0) {
                let message =
                    format!("{temperature} is out of range; it must be between {:e} and {:e} K", TEMPERATURES.start(), TEMPERATURES.end());
                return Err(section.error("temperature", message));
            }
            Ok(StarShape::BlackBody(temperature))
        },
    },
    Kind {
        name: "stellar",
        summary: "spectrum of a spectral type (library of Pickles 1998, interpolated between types)",
        keys: &[Key::required("type", "text", "spectral type in the catalogue `stars`, such as \"O9.5V\" or \"K0 III\"").of("stars")],
        build: |section, _| Ok(StarShape::Table(section.wrap("type", sed::star(section.need_text("type")?))?)),
    },
    Kind {
        name: "atmosphere",
        summary: "model atmosphere of a hot star (Kurucz 1993, 10000 to 50000 K)",
        keys: &[
            Key::required("temperature", "temperature", "effective temperature, 10000 to 50000 K"),
            Key::optional("log_g", "number", "4.5", "surface gravity, log10 of cm s-2; hotter stars require higher values"),
        ],
        build: |section, _| {
            let temperature = section.need_positive::<Temperature>("temperature")?;
            let log_g = section.number("log_g", -1.0..=9.0)?.unwrap_or(4.5);
            let key = if section.has("log_g") { "log_g" } else { "temperature" };
            Ok(StarShape::Surface(temperature, section.wrap(key, sed::atmosphere(temperature, log_g))?))
        },
    },
    Kind {
        name: "power_law",
        summary: "(lambda/reference)^exponent",
        keys: &[
            Key::required("exponent", "number", "exponent in wavelength"),
            Key::optional("reference", "wavelength", "550 nm", "wavelength of strength 1"),
        ],
        build: |section, _| {
            let exponent = section.number("exponent", -50.0..=50.0)?;
            let exponent =
                exponent.ok_or_else(|| section.error("exponent", "key \"exponent\" is required; write it like exponent = -2"))?;
            let reference = section.positive::<Wavelength>("reference")?.unwrap_or(Wavelength(0.55));
            Ok(StarShape::Other(Arc::new(PowerLaw { reference, exponent })))
        },
    },
    Kind {
        name: "file",
        summary: "from a file of wavelength and flux",
        keys: &[Key::required("file", "path", "text, ECSV, VOTable or FITS table of wavelength and flux density"), UNIT, COLUMN],
        build: |section, inputs| {
            let file = section.need_text("file")?;
            let table = curve::read(section, "file", Ordinate::FluxDensity, inputs)?.table;
            if let Some(i) = table.y().iter().position(|f| *f < 0.0) {
                return Err(
                    section.error("file", format!("{file}: the flux is negative at {:.4} um; it must be at least zero", table.x()[i]))
                );
            }
            Ok(StarShape::Table(Arc::new(table)))
        },
    },
];

/// The keys that every star takes.
pub(super) const KEYS: &[Key] = &[
    Key::optional("name", "text", "star N", "its name"),
    Key::required("position", "position", "where it is"),
    Key::optional("visible", "boolean", "true", "draw the star itself as an unresolved source"),
    Key::optional("luminosity", "luminosity", "exactly one scale is required", "bolometric luminosity"),
    Key::optional("radius", "length", "exactly one scale is required", "radius, for black bodies and atmospheres, such as \"9.9 Rsun\""),
    Key::optional(
        "spectral_luminosity",
        "spectral luminosity",
        "exactly one scale is required",
        "luminosity per wavelength at `wavelength`",
    ),
    Key::optional("wavelength", "wavelength", "550 nm", "wavelength of spectral_luminosity"),
    Key::optional(
        "magnitude",
        "magnitude",
        "exactly one scale is required",
        "apparent magnitude in `magnitude_band` at `distance`, dimmed by `extinction`",
    ),
    Key::optional("extinction", "magnitude", "0", "A_V between the star and the observer of its magnitude; it is removed"),
    Key::optional("extinction_law", "text", "gordon23", "extinction law of that dust, with R_V = 3.1 where it applies").of("laws"),
    Key::optional("magnitude_band", "text", "johnson-V", "an embedded passband").of("passbands"),
    Key::optional("distance", "length", "needed with magnitude", "distance of the observer of the magnitude"),
    Key::optional("magnitude_system", "text", "vega; required for passbands without conventional Vega magnitudes", "vega or ab"),
];

pub(super) fn build(section: &Section, inputs: &Inputs) -> Result<Star> {
    let shape = build_kind_with("spectrum", SPECTRA, KEYS, section, inputs)?;
    let spectrum = section.wrap("kind", sed::scaled(shape, &scale(section)?))?;
    Ok(Star {
        name: section.text("name")?.unwrap_or(section.name()).to_owned(),
        position: section.need_position("position")?,
        spectrum,
        visible: section.flag("visible")?.unwrap_or(true),
    })
}

/// Exactly one of the four ways to say how bright.
fn scale(section: &Section) -> Result<Scale> {
    const WAYS: [&str; 4] = ["luminosity", "radius", "spectral_luminosity", "magnitude"];
    let given: Vec<&str> = WAYS.into_iter().filter(|w| section.has(w)).collect();
    let [way] = given[..] else {
        let message = format!("a star requires exactly one of {}; this one has {}", WAYS.join(", "), given.len());
        return Err(section.error(given.first().unwrap_or(&"luminosity"), message));
    };
    if way != "spectral_luminosity" {
        section.refuse(&["wavelength"], "spectral_luminosity")?;
    }
    if way != "magnitude" {
        section.refuse(&["magnitude_band", "distance", "magnitude_system", "extinction"], "magnitude")?;
    }
    if !section.has("extinction") {
        section.refuse(&["extinction_law"], "extinction")?;
    }
    Ok(match way {
        "luminosity" => Scale::Luminosity(section.need_positive::<Luminosity>(way)?),
        "radius" => Scale::Radius(section.need_positive::<Length>(way)?),
        "spectral_luminosity" => {
            let at = section.positive::<Wavelength>("wavelength")?.unwrap_or(Wavelength(0.55));
            Scale::SpectralLuminosity(section.need_positive::<SpectralLuminosity>(way)?, at)
        }
        _ => {
            let band = section.text("magnitude_band")?.unwrap_or("johnson-V");
            let band = section.wrap("magnitude_band", Passband::named(band))?;
            let system = magnitude_system(section, &[&band])?;
            let distance = section.need_positive::<Length>("distance")?;
            Scale::Magnitude(section.need::<Magnitude>(way)?, Box::new(band), distance, system, foreground(section)?)
        }
    })
}

/// The zero point of magnitudes in these passbands. It must be stated where the convention is not Vega's.
pub(super) fn magnitude_system(section: &Section, bands: &[&Passband]) -> Result<MagnitudeSystem> {
    match section.choice("magnitude_system", &["vega", "ab"])? {
        Some("ab") => return Ok(MagnitudeSystem::Ab),
        Some(_) => return Ok(MagnitudeSystem::Vega),
        None => {}
    }
    match bands.iter().find(|band| family(band.name()).is_some_and(|family| !family.is_vega)) {
        Some(band) => {
            let message =
                format!("magnitudes in {} are not Vega magnitudes by convention; write magnitude_system = \"ab\" or \"vega\"", band.name());
            Err(section.error("magnitude_system", message))
        }
        None => Ok(MagnitudeSystem::Vega),
    }
}

/// The dust that an observed magnitude was seen through.
fn foreground(section: &Section) -> Result<Option<Foreground>> {
    if !section.has("extinction") {
        return Ok(None);
    }
    let extinction = section.need::<Magnitude>("extinction")?;
    if extinction.0 < 0.0 {
        return Err(section.error("extinction", "an extinction must be at least 0 mag"));
    }
    let law = section.text("extinction_law")?.unwrap_or("gordon23");
    Ok(Some(Foreground { extinction, law: Arc::new(section.wrap("extinction_law", Extinction::named(law))?) }))
}
