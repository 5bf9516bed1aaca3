//! The `[[emission]]` tables: gas that glows.

use std::sync::Arc;

use spectra::curve::Ordinate;
use spectra::nebular::{ion_lines, line_list, recombination_continuum};
use spectra::sed::PowerLaw;
use spectra::spectrum::{Line, Spectrum};
use spectra::units::{Emissivity, NumberDensity, Temperature, Velocity, Wavelength};

use super::{Fields, Loader, motion};
use crate::curve::{self, COLUMN, UNIT};
use crate::data::Inputs;
use crate::error::{Error, Result};
use crate::field::{Field, IntoField};
use crate::properties::{Key, Kind, Section, build_kind_with};

/// One species of glowing gas.
#[derive(Debug, Clone)]
pub struct Emission {
    /// The name in certificates.
    pub name: String,
    /// The density of the species, in a unit of its own.
    pub density: Arc<dyn Field>,
    /// Emission coefficient of density 1 [W m⁻³ sr⁻¹ µm⁻¹, lines W m⁻³ sr⁻¹].
    pub spectrum: Spectrum,
}

impl Emission {
    /// Gas of a `density`, a field in a unit of its own, of which one has the emission coefficient `spectrum` [W m⁻³
    /// sr⁻¹ µm⁻¹, lines W m⁻³ sr⁻¹].
    pub fn new(density: impl IntoField, spectrum: Spectrum) -> Self {
        Self { name: "emission".into(), density: density.into_field(), spectrum }
    }

    /// Copy of the species under another name.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Refuses spectra that no gas has.
    pub(super) fn check(&self) -> Result<()> {
        if let Some(lambda) = self.spectrum.first_negative_um() {
            return Err(Error::out_of_range("spectrum", format!("negative at {:.2} nm", lambda * 1e3), "at least zero"));
        }
        if !self.spectrum.is_light() {
            return Err(Error::out_of_range("spectrum", format!("not finite for {}", self.name), "finite"));
        }
        Ok(())
    }
}

const SCALE: Key =
    Key::required("scale", "emission coefficient", "emission coefficient at density 1 and spectral strength 1, such as \"1e-25 W/m3/sr\"");

pub(super) const KINDS: &[Kind<Spectrum>] = &[
    Kind {
        name: "lines",
        summary: "lines of given strengths, with or without a power-law continuum",
        keys: &[
            SCALE,
            Key::required(
                "lines",
                "list of tables",
                "{ wavelength = \"656.46 nm\", strength = 3 }, wavelength in vacuum, strength integrated over the line",
            ),
            Key::optional("continuum", "number", "0", "strength per nm at `continuum_at`"),
            Key::optional("continuum_at", "wavelength", "550 nm", "wavelength of that strength"),
            Key::optional("continuum_exponent", "number", "0", "exponent of the continuum in wavelength"),
        ],
        build: lines,
    },
    Kind {
        name: "ion",
        summary: "all lines of an ion from its emissivities; the density is n_e n_H in cm-6",
        keys: &[
            Key::required("ion", "text", "name in the catalogue `ions`, such as \"H1\", \"O3\", \"N2\", \"S2\"").of("ions"),
            Key::required("temperature", "temperature", "electron temperature, 5000 to 20000 K"),
            Key::required("electron_density", "number density", "electron density for collisional de-excitation, 10 to 1e5 cm-3"),
            Key::optional("abundance", "number", "1", "n_ion / n_H"),
        ],
        build: |section, _| {
            let (t, n) = conditions(section)?;
            let lines = section.wrap("ion", ion_lines(section.need_text("ion")?, t, n))?;
            Ok(lines.scaled(section.number("abundance", 0.0..=1e3)?.unwrap_or(1.0)))
        },
    },
    Kind {
        name: "recombination",
        summary: "hydrogen continuum (free-bound, free-free, two-photon); the density is n_e n_H+ in cm-6",
        keys: &[
            Key::required("temperature", "temperature", "electron temperature, 6000 to 15000 K"),
            Key::required("electron_density", "number density", "100 to 1e4 cm-3"),
        ],
        build: |section, _| {
            let (t, n) = conditions(section)?;
            section.wrap("temperature", recombination_continuum(t, n))
        },
    },
    Kind {
        name: "line_list",
        summary: "a model nebula's lines relative to H-beta",
        keys: &[SCALE, Key::required("list", "text", "name in the catalogue `line-lists`").of("line-lists")],
        build: |section, _| {
            let scale = section.need_positive::<Emissivity>("scale")?;
            Ok(section.wrap("list", line_list(section.need_text("list")?))?.scaled(scale.0))
        },
    },
    Kind {
        name: "file",
        summary: "a tabulated spectrum",
        keys: &[SCALE, Key::required("file", "path", "text, ECSV, VOTable or FITS table of wavelength and strength per nm"), UNIT, COLUMN],
        build: |section, inputs| {
            let table = curve::read(section, "file", Ordinate::StrengthPerNm, inputs)?.table;
            let per_um = 1e3 * section.need_positive::<Emissivity>("scale")?.0;
            Ok(Spectrum::continuous(per_um, Arc::new(table)))
        },
    },
];

/// The keys that every species takes.
pub(super) const KEYS: &[Key] = &[
    Key::optional("name", "text", "emission N", "its name"),
    Key::required("density", "expression", "density, an expression of fields such as \"n_H^2 * x_ion^2\""),
    Key::optional("doppler_fwhm", "velocity", "0 km/s", "full width at half maximum of the lines"),
    motion::VELOCITY,
    motion::STEP,
];

pub(super) fn build(section: &Section, loader: &Loader, fields: &Fields) -> Result<Emission> {
    let mut spectrum = build_kind_with("emission", KINDS, KEYS, section, &loader.inputs)?;
    if let Some(fwhm) = doppler_fwhm(section)? {
        spectrum = spectrum.broadened(fwhm);
    }
    if let Some(lambda) = spectrum.first_negative_um() {
        return Err(section.error("kind", format!("the spectrum is negative at {:.2} nm; it must be at least zero", lambda * 1e3)));
    }
    Ok(Emission {
        name: section.text("name")?.map_or_else(|| format!("emission {}", section.name()), str::to_owned),
        density: fields.expression(section, "density")?,
        spectrum,
    })
}

/// The width of lines that a table says; none where it says none.
pub(super) fn doppler_fwhm(section: &Section) -> Result<Option<Velocity>> {
    let said = section.quantity::<Velocity>("doppler_fwhm")?.filter(|v| v.0 != 0.0);
    match said.filter(|fwhm| !(0.0..1e-4 * spectra::constants::SPEED_OF_LIGHT).contains(&fwhm.0)) {
        Some(fwhm) => Err(section.error(
            "doppler_fwhm",
            format!("{fwhm} is out of range; a line width must be at least zero and below a tenth of the speed of light"),
        )),
        None => Ok(said),
    }
}

fn conditions(section: &Section) -> Result<(Temperature, NumberDensity)> {
    Ok((section.need_positive("temperature")?, section.need_positive("electron_density")?))
}

fn lines(section: &Section, _: &Inputs) -> Result<Spectrum> {
    let scale = section.need_positive::<Emissivity>("scale")?.0;
    let mut lines = Vec::new();
    for line in section.tables("lines")? {
        line.check_keys(&["wavelength", "strength"])?;
        let strength = line.number("strength", 0.0..=f64::MAX)?;
        let strength = strength.ok_or_else(|| line.error("strength", "key \"strength\" is required; write it like strength = 3"))?;
        lines.push(Line { lambda_um: line.need_positive::<Wavelength>("wavelength")?.0, strength: strength * scale });
    }
    let spectrum = Spectrum::of_lines(lines);
    let Some(level) = section.number("continuum", 0.0..=f64::MAX)? else { return Ok(spectrum) };
    let reference = section.positive::<Wavelength>("continuum_at")?.unwrap_or(Wavelength(0.55));
    let exponent = section.number("continuum_exponent", -50.0..=50.0)?.unwrap_or(0.0);
    // Per nm to per µm: 10³.
    Ok(spectrum.plus(Spectrum::continuous(1e3 * level * scale, Arc::new(PowerLaw { reference, exponent }))))
}
