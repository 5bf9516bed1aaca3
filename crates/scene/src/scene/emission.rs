//! The `[[emission]]` tables: gas that glows.

use std::sync::Arc;

use spectra::curve::Ordinate;
use spectra::nebular::{ion_lines, line_list, recombination_continuum};
use spectra::sed::PowerLaw;
use spectra::spectrum::{Line, Spectrum};
use spectra::units::{Emissivity, NumberDensity, Temperature, Velocity, Wavelength};

use super::species::Emission;
use super::{Fields, Loader, fields};
use crate::curve::{self, COLUMN, UNIT};
use crate::data::Inputs;
use crate::error::Result;
use crate::properties::{Formula, Key, KeyRow, Kind, Number, OrDefault, Part, Path, Required, Section, Tables, Text, build_kind_with};

const SCALE: Key<Emissivity, Required> =
    Key::quantity::<Emissivity>("scale", "emission coefficient at density 1 and spectral strength 1, such as \"1e-25 W/m3/sr\"")
        .positive()
        .required();

const LINES: Key<Tables, Required> =
    Key::tables("lines", "{ wavelength = \"656.46 nm\", strength = 3 }, wavelength in vacuum, strength integrated over the line")
        .required()
        .example("[{ wavelength = \"656.28 nm\", strength = 1.0 }]");
const WAVELENGTH: Key<Wavelength, Required> =
    Key::quantity::<Wavelength>("wavelength", "wavelength of the line in vacuum").positive().required();
const STRENGTH: Key<Number, Required> = Key::number("strength", "strength, integrated over the line").not_negative().required();
const LINE: &[KeyRow] = &[WAVELENGTH.row, STRENGTH.row];
const CONTINUUM: Key<Number, OrDefault> = Key::number("continuum", "strength per nm at `continuum_at`").not_negative().default(0.0);
const CONTINUUM_AT: Key<Wavelength, OrDefault> =
    Key::quantity::<Wavelength>("continuum_at", "wavelength of that strength").positive().default("550 nm").needs("continuum");
const CONTINUUM_EXPONENT: Key<Number, OrDefault> =
    Key::number("continuum_exponent", "exponent of the continuum in wavelength").range(-50.0..=50.0).default(0.0).needs("continuum");
const ION: Key<Text, Required> =
    Key::text("ion", "name in the catalogue `ions`, such as \"H1\", \"O3\", \"N2\", \"S2\"").required().of("ions");
const TEMPERATURE: Key<Temperature, Required> =
    Key::quantity::<Temperature>("temperature", "electron temperature, 5000 to 20000 K").positive().required();
const ELECTRON_DENSITY: Key<NumberDensity, Required> =
    Key::quantity::<NumberDensity>("electron_density", "electron density for collisional de-excitation, 10 to 1e5 cm-3")
        .positive()
        .required();
const ABUNDANCE: Key<Number, OrDefault> = Key::number("abundance", "n_ion / n_H").range(0.0..=1e3).default(1.0);
const OF_CONTINUUM: Key<Temperature, Required> =
    Key::quantity::<Temperature>("temperature", "electron temperature, 6000 to 15000 K").positive().required();
const DENSITY_OF_CONTINUUM: Key<NumberDensity, Required> =
    Key::quantity::<NumberDensity>("electron_density", "100 to 1e4 cm-3").positive().required();
const LIST: Key<Text, Required> = Key::text("list", "name in the catalogue `line-lists`").required().of("line-lists");
const FILE: Key<Path, Required> = Key::path("file", "text, ECSV, VOTable or FITS table of wavelength and strength per nm").required();
const NAME: Key<Text> = Key::text("name", "its name").otherwise("emission N");
const DENSITY: Key<Formula, Required> =
    Key::formula("density", "density, an expression of fields such as \"n_H^2 * x_ion^2\"").required().affects(&[Part::Space]);
const DOPPLER_FWHM: Key<Velocity, OrDefault> = doppler_fwhm("full width at half maximum of the lines").default("0 km/s");

pub(super) const KINDS: &[Kind<Spectrum>] = &[
    Kind {
        name: "lines",
        summary: "lines of given strengths, with or without a power-law continuum",
        keys: &[SCALE.row, LINES.row, CONTINUUM.row, CONTINUUM_AT.row, CONTINUUM_EXPONENT.row],
        build: lines,
    },
    Kind {
        name: "ion",
        summary: "all lines of an ion from its emissivities; the density is n_e n_H in cm-6",
        keys: &[ION.row, TEMPERATURE.row, ELECTRON_DENSITY.row, ABUNDANCE.row],
        build: |section, _| {
            let (t, n) = (section.read(&TEMPERATURE)?, section.read(&ELECTRON_DENSITY)?);
            let lines = section.wrap(&ION, ion_lines(section.read(&ION)?, t, n))?;
            Ok(lines.scaled(section.read(&ABUNDANCE)?))
        },
    },
    Kind {
        name: "recombination",
        summary: "hydrogen continuum (free-bound, free-free, two-photon); the density is n_e n_H+ in cm-6",
        keys: &[OF_CONTINUUM.row, DENSITY_OF_CONTINUUM.row],
        build: |section, _| {
            let (t, n) = (section.read(&OF_CONTINUUM)?, section.read(&DENSITY_OF_CONTINUUM)?);
            section.wrap(&OF_CONTINUUM, recombination_continuum(t, n))
        },
    },
    Kind {
        name: "line_list",
        summary: "a model nebula's lines relative to H-beta",
        keys: &[SCALE.row, LIST.row],
        build: |section, _| {
            let scale = section.read(&SCALE)?;
            Ok(section.wrap(&LIST, line_list(section.read(&LIST)?))?.scaled(scale.0))
        },
    },
    Kind {
        name: "file",
        summary: "a tabulated spectrum",
        keys: &[SCALE.row, FILE.row, UNIT.row, COLUMN.row],
        build: |section, inputs| {
            let table = curve::read(section, &FILE, Ordinate::StrengthPerNm, inputs)?.table;
            let per_um = 1e3 * section.read(&SCALE)?.0;
            Ok(Spectrum::continuous(per_um, Arc::new(table)))
        },
    },
];

/// The keys that every species takes.
pub(super) const KEYS: &[KeyRow] = &[NAME.row, DENSITY.row, DOPPLER_FWHM.row, fields::VELOCITY.row, fields::VELOCITY_STEP.row];

pub(super) fn build(section: &Section, loader: &Loader, fields: &Fields) -> Result<Emission> {
    let mut spectrum = build_kind_with("emission", KINDS, KEYS, section, &loader.inputs)?;
    let fwhm = section.read(&DOPPLER_FWHM)?;
    if fwhm.0 > 0.0 {
        spectrum = spectrum.broadened(fwhm);
    }
    if let Some(lambda) = spectrum.first_negative_um() {
        return Err(section.error("kind", format!("the spectrum is negative at {:.2} nm; it must be at least zero", lambda * 1e3)));
    }
    Ok(Emission {
        name: section.read(&NAME)?.map_or_else(|| format!("emission {}", section.name()), str::to_owned),
        density: fields.expression(section, &DENSITY)?,
        spectrum,
        motion: fields.motion(section)?,
    })
}

/// The key of the width of lines; widths stay below a tenth of the speed of light.
pub(super) const fn doppler_fwhm(summary: &'static str) -> Key<Velocity> {
    Key::quantity::<Velocity>("doppler_fwhm", summary).not_negative().below(1e-4 * spectra::constants::SPEED_OF_LIGHT)
}

fn lines(section: &Section, _: &Inputs) -> Result<Spectrum> {
    let scale = section.read(&SCALE)?.0;
    let mut lines = Vec::new();
    for line in section.read(&LINES)? {
        line.check(LINE)?;
        lines.push(Line { lambda_um: line.read(&WAVELENGTH)?.0, strength: line.read(&STRENGTH)? * scale });
    }
    let spectrum = Spectrum::of_lines(lines);
    let Some(level) = section.stated(&CONTINUUM)? else { return Ok(spectrum) };
    let reference = section.read(&CONTINUUM_AT)?;
    let exponent = section.read(&CONTINUUM_EXPONENT)?;
    // Per nm to per µm: 10³.
    Ok(spectrum.plus(Spectrum::continuous(1e3 * level * scale, Arc::new(PowerLaw { reference, exponent }))))
}
