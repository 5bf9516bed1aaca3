//! The `[[star]]` tables, and the spectra that stars and backgrounds choose.

use std::sync::Arc;

use glam::DVec3;
use spectra::curve::Ordinate;
use spectra::extinction::Extinction;
use spectra::fingerprint::{Digest, Fingerprint};
use spectra::passband::{Passband, family};
use spectra::sed::{self, Foreground, MagnitudeSystem, PowerLaw, Scale, StarShape};
use spectra::spectrum::Spectrum;
use spectra::units::{Length, Luminosity, Magnitude, SpectralLuminosity, Temperature, Wavelength};

use crate::curve::{self, COLUMN, UNIT};
use crate::data::Inputs;
use crate::error::{Error, Result};
use crate::properties::{
    Choice, Choices, Flag, Key, KeyRow, Kind, Number, OrDefault, Part, Path, Position, Required, Section, Text, build_kind_with,
};

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

/// Fingerprint of positions and spectra of stars.
pub(super) fn fingerprint(stars: &[Star]) -> Fingerprint {
    let mut digest = Digest::new("stars");
    for star in stars {
        digest.numbers(&star.position.to_array()).part(star.spectrum.fingerprint());
    }
    digest.finish()
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
    pub fn with_position(self, position: DVec3) -> Self {
        Self { position, ..self }
    }

    /// Copy of the star under another name.
    #[must_use]
    pub fn with_name(self, name: impl Into<String>) -> Self {
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

// Black bodies of these temperatures emit a finite number at every wavelength that a passband may have.
const TEMPERATURE: Key<Temperature, Required> =
    Key::quantity::<Temperature>("temperature", "effective temperature").range(1.0..=1e9).required();
const TYPE: Key<Text, Required> =
    Key::text("type", "spectral type in the catalogue `stars`, such as \"O9.5V\" or \"K0 III\"").required().of("stars");
const OF_ATMOSPHERE: Key<Temperature, Required> =
    Key::quantity::<Temperature>("temperature", "effective temperature, 10000 to 50000 K").positive().required();
const LOG_G: Key<Number, OrDefault> =
    Key::number("log_g", "surface gravity, log10 of cm s-2; hotter stars require higher values").range(-1.0..=9.0).default(4.5);
const EXPONENT: Key<Number, Required> = Key::number("exponent", "exponent in wavelength").range(-50.0..=50.0).required().example("-2.0");
const REFERENCE: Key<Wavelength, OrDefault> =
    Key::quantity::<Wavelength>("reference", "wavelength of strength 1").positive().default("550 nm");
const FILE: Key<Path, Required> = Key::path("file", "text, ECSV, VOTable or FITS table of wavelength and flux density").required();
/// Noun of the group of keys that set the brightness.
const SCALE: &str = "scale";

const NAME: Key<Text> = Key::text("name", "its name").otherwise("star N");
const POSITION: Key<Position, Required> = Key::position("position", "where it is").required().affects(&[Part::Stars]);
const VISIBLE: Key<Flag, OrDefault> = Key::flag("visible", "draw the star itself as an unresolved source").default(true);
const LUMINOSITY: Key<Luminosity> = Key::quantity::<Luminosity>("luminosity", "bolometric luminosity").positive().one_of(SCALE);
const RADIUS: Key<Length> =
    Key::quantity::<Length>("radius", "radius, for black bodies and atmospheres, such as \"9.9 Rsun\"").positive().one_of(SCALE);
const SPECTRAL_LUMINOSITY: Key<SpectralLuminosity> =
    Key::quantity::<SpectralLuminosity>("spectral_luminosity", "luminosity per wavelength at `wavelength`").positive().one_of(SCALE);
const WAVELENGTH: Key<Wavelength, OrDefault> = Key::quantity::<Wavelength>("wavelength", "wavelength of spectral_luminosity")
    .positive()
    .default("550 nm")
    .needs("spectral_luminosity");
const MAGNITUDE: Key<Magnitude> =
    Key::quantity::<Magnitude>("magnitude", "apparent magnitude in `magnitude_band` at `distance`, dimmed by `extinction`").one_of(SCALE);
const EXTINCTION: Key<Magnitude, OrDefault> =
    Key::quantity::<Magnitude>("extinction", "A_V between the star and the observer of its magnitude; it is removed")
        .not_negative()
        .default("0 mag")
        .needs("magnitude");
const EXTINCTION_LAW: Key<Text, OrDefault> = Key::text("extinction_law", "extinction law of that dust, with R_V = 3.1 where it applies")
    .default("gordon23")
    .of("laws")
    .needs("extinction");
const MAGNITUDE_BAND: Key<Text, OrDefault> =
    Key::text("magnitude_band", "an embedded passband").default("johnson-V").of("passbands").needs("magnitude");
const DISTANCE: Key<Length> =
    Key::quantity::<Length>("distance", "distance of the observer of the magnitude").positive().required_with("magnitude");
pub(super) const MAGNITUDE_SYSTEM: Key<Choice<MagnitudeSystem>> = Key::choice("magnitude_system", "zero point of magnitudes")
    .otherwise("vega; required for passbands without conventional Vega magnitudes");

impl Choices for MagnitudeSystem {
    const ROWS: &'static [(&'static str, Self)] = &[("vega", Self::Vega), ("ab", Self::Ab)];
}

/// All shapes of spectra that a star may have.
pub(super) const SPECTRA: &[Kind<StarShape>] = &[
    Kind {
        name: "blackbody",
        summary: "Planck function of a temperature",
        keys: &[TEMPERATURE.row],
        build: |section, _| Ok(StarShape::BlackBody(section.read(&TEMPERATURE)?)),
    },
    Kind {
        name: "stellar",
        summary: "spectrum of a spectral type (library of Pickles 1998, interpolated between types)",
        keys: &[TYPE.row],
        build: |section, _| Ok(StarShape::Table(section.wrap(&TYPE, sed::star(section.read(&TYPE)?))?)),
    },
    Kind {
        name: "atmosphere",
        summary: "model atmosphere of a hot star (Kurucz 1993, 10000 to 50000 K)",
        keys: &[OF_ATMOSPHERE.row, LOG_G.row],
        build: |section, _| {
            let temperature = section.read(&OF_ATMOSPHERE)?;
            let log_g = section.read(&LOG_G)?;
            let key = if section.has(&LOG_G) { &LOG_G.row } else { &OF_ATMOSPHERE.row };
            Ok(StarShape::Surface(temperature, section.wrap(key, sed::atmosphere(temperature, log_g))?))
        },
    },
    Kind {
        name: "power_law",
        summary: "(lambda/reference)^exponent",
        keys: &[EXPONENT.row, REFERENCE.row],
        build: |section, _| {
            let exponent = section.read(&EXPONENT)?;
            let reference = section.read(&REFERENCE)?;
            Ok(StarShape::Other(Arc::new(PowerLaw { reference, exponent })))
        },
    },
    Kind {
        name: "file",
        summary: "from a file of wavelength and flux",
        keys: &[FILE.row, UNIT.row, COLUMN.row],
        build: |section, inputs| {
            let file = section.read(&FILE)?;
            let table = curve::read(section, &FILE, Ordinate::FluxDensity, inputs)?.table;
            if let Some(i) = table.y().iter().position(|f| *f < 0.0) {
                return Err(
                    section.error(&FILE, format!("{file}: the flux is negative at {:.4} um; it must be at least zero", table.x()[i]))
                );
            }
            Ok(StarShape::Table(Arc::new(table)))
        },
    },
];

/// The keys that every star takes.
pub(super) const KEYS: &[KeyRow] = &[
    NAME.row,
    POSITION.row,
    VISIBLE.row,
    LUMINOSITY.row,
    RADIUS.row,
    SPECTRAL_LUMINOSITY.row,
    WAVELENGTH.row,
    MAGNITUDE.row,
    EXTINCTION.row,
    EXTINCTION_LAW.row,
    MAGNITUDE_BAND.row,
    DISTANCE.row,
    MAGNITUDE_SYSTEM.needs("magnitude").row,
];

pub(super) fn build(section: &Section, inputs: &Inputs) -> Result<Star> {
    let shape = build_kind_with("spectrum", SPECTRA, KEYS, section, inputs)?;
    let spectrum = section.wrap("kind", sed::scaled(shape, &scale(section)?))?;
    Ok(Star {
        name: section.read(&NAME)?.unwrap_or(section.name()).to_owned(),
        position: section.read(&POSITION)?,
        spectrum,
        visible: section.read(&VISIBLE)?,
    })
}

/// The brightness, by the key that the table has.
fn scale(section: &Section) -> Result<Scale> {
    if let Some(luminosity) = section.read(&LUMINOSITY)? {
        return Ok(Scale::Luminosity(luminosity));
    }
    if let Some(radius) = section.read(&RADIUS)? {
        return Ok(Scale::Radius(radius));
    }
    if let Some(luminosity) = section.read(&SPECTRAL_LUMINOSITY)? {
        return Ok(Scale::SpectralLuminosity(luminosity, section.read(&WAVELENGTH)?));
    }
    let band = section.wrap(&MAGNITUDE_BAND, Passband::by_name(section.read(&MAGNITUDE_BAND)?))?;
    let system = magnitude_system(section, &[&band])?;
    Ok(Scale::Magnitude(section.need(&MAGNITUDE)?, Box::new(band), section.need(&DISTANCE)?, system, foreground(section)?))
}

/// The zero point of magnitudes in these passbands. It must be stated where the convention is not Vega's.
pub(super) fn magnitude_system(section: &Section, bands: &[&Passband]) -> Result<MagnitudeSystem> {
    if let Some(system) = section.read(&MAGNITUDE_SYSTEM)? {
        return Ok(system);
    }
    match bands.iter().find(|band| family(band.name()).is_some_and(|family| !family.is_vega)) {
        Some(band) => {
            let message =
                format!("magnitudes in {} are not Vega magnitudes by convention; write magnitude_system = \"ab\" or \"vega\"", band.name());
            Err(section.error(&MAGNITUDE_SYSTEM, message))
        }
        None => Ok(MagnitudeSystem::Vega),
    }
}

/// The dust that an observed magnitude was seen through.
fn foreground(section: &Section) -> Result<Option<Foreground>> {
    let Some(extinction) = section.stated(&EXTINCTION)? else { return Ok(None) };
    let law = section.read(&EXTINCTION_LAW)?;
    Ok(Some(Foreground { extinction, law: Arc::new(section.wrap(&EXTINCTION_LAW, Extinction::by_name(law))?) }))
}
