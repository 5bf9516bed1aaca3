//! Albedos: the part of extinction that is scattering, ω(λ).

use std::sync::Arc;

use spectra::extinction::Extinction;
use spectra::table::{Table, spectrum_from_csv};
use spectra::units::Wavelength;

use super::{Key, Kind, Loader, Section, build_kind};
use crate::error::Result;

/// ω(λ) [1].
#[derive(Debug, Clone)]
pub enum Albedo {
    /// The same everywhere.
    Constant(f64),
    /// value + slope (λ − at)/0.1 µm, cut to [0, 1].
    Linear {
        /// At the wavelength `at`.
        value: f64,
        /// Per 0.1 µm.
        slope: f64,
        /// Wavelength of `value` [µm].
        at_um: f64,
    },
    /// Over λ [µm].
    Table(Arc<Table>),
}

impl Albedo {
    /// ω(λ) [1]; λ [µm].
    pub fn at(&self, lambda_um: f64) -> f64 {
        match self {
            Albedo::Constant(v) => *v,
            Albedo::Linear { value, slope, at_um } => (value + slope * (lambda_um - at_um) / 0.1).clamp(0.0, 1.0),
            Albedo::Table(table) => table.at(lambda_um),
        }
    }
}

/// All kinds of albedo.
pub(super) const KINDS: &[Kind<Albedo>] = &[
    Kind {
        name: "constant",
        summary: "the same at every wavelength; albedo = 0.6 is short for it",
        keys: &[Key::required("value", "number", "0 to 1")],
        build: |section, _| Ok(Albedo::Constant(need_number(section, "value")?)),
    },
    Kind {
        name: "linear",
        summary: "value + slope (lambda - at)/100 nm, cut to 0 to 1",
        keys: &[
            Key::required("value", "number", "albedo at the wavelength `at`, 0 to 1"),
            Key::optional("slope", "number", "0", "change per 100 nm"),
            Key::optional("at", "wavelength", "550 nm", "where the value holds"),
        ],
        build: |section, _| {
            Ok(Albedo::Linear {
                value: need_number(section, "value")?,
                slope: section.number("slope", -1.0..=1.0)?.unwrap_or(0.0),
                at_um: section.positive::<Wavelength>("at")?.map_or(0.55, |l| l.0),
            })
        },
    },
    Kind {
        name: "file",
        summary: "from a CSV of wavelength and albedo",
        keys: &[Key::required("file", "path", "the CSV; its header may name the unit, nm otherwise")],
        build: |section, loader| {
            let file = section.need_text("file")?;
            let table = section.wrap("file", spectrum_from_csv(file, &section.wrap("file", loader.read_text(file))?))?;
            if table.y().iter().any(|v| !(0.0..=1.0).contains(v)) {
                return Err(section.error("file", format!("{file} has albedos outside of 0 to 1")));
            }
            Ok(Albedo::Table(Arc::new(table)))
        },
    },
];

fn need_number(section: &Section, key: &str) -> Result<f64> {
    section.number(key, 0.0..=1.0)?.ok_or_else(|| section.error(key, format!("key \"{key}\" is missing; write it like {key} = 0.6")))
}

/// A number, a table, or the law's own.
pub(super) fn build(dust: &Section, loader: &Loader, extinction: &Extinction) -> Result<Albedo> {
    if !dust.has("albedo") {
        let own = extinction.dust_table().map(|t| Albedo::Table(Arc::new(t.albedo.clone())));
        return own.ok_or_else(|| {
            dust.error(
                "albedo",
                format!("law \"{}\" brings no albedo: write albedo = 0.6, or choose a law such as draine03_rv31", extinction.name),
            )
        });
    }
    if let Ok(Some(value)) = dust.number("albedo", 0.0..=1.0) {
        return Ok(Albedo::Constant(value));
    }
    match dust.table("albedo") {
        Ok(Some(section)) => build_kind("albedo", KINDS, &section, loader),
        _ => Err(dust.error("albedo", "an albedo is a number from 0 to 1, or a table with a kind")),
    }
}
