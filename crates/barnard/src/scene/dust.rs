//! The `[dust]` table.

use std::sync::Arc;

use spectra::extinction::Extinction;
use spectra::units::{ExtinctionCoefficient, ExtinctionPerColumn, Quantity};

use super::albedo::{self, Albedo};
use super::{Fields, Key, Loader, Section};
use crate::error::Result;
use crate::field::Field;
use crate::phase::{self, Phase};

/// Dust: where it is, and what it does to light.
#[derive(Debug, Clone)]
pub struct Dust {
    /// Its density, in a unit of its own.
    pub density: Arc<dyn Field>,
    /// Extinction coefficient at V for density 1 [pc⁻¹].
    pub sigma_v_per_pc: f64,
    /// k(λ).
    pub extinction: Arc<Extinction>,
    /// ω(λ).
    pub albedo: Albedo,
    /// p(cos θ, λ).
    pub phase: Arc<dyn Phase>,
}

pub(super) const KEYS: &[Key] = &[
    Key::required("density", "expression", "of the fields, such as \"cloud\" or \"n_H * (1 - x_ion)\""),
    Key::required(
        "scale",
        "extinction",
        "of density 1: per length (\"2 mag/pc\" of A_V, \"4 /pc\" of depth), or per column for a density in cm-3 (\"5.32e-22 mag cm2\")",
    ),
    Key::optional("law", "text", "draine03_rv31", "extinction law").of("laws"),
    Key::optional("r_v", "number", "3.1", "A(V)/E(B-V), for laws that take it"),
    Key::optional("albedo", "number or table", "the law's own", "part of extinction that scatters"),
    Key::optional("phase", "table", "isotropic", "spread of scattered light over angle"),
];

pub(super) fn build(section: &Section, loader: &Loader, fields: &Fields) -> Result<Dust> {
    let keys: Vec<&str> = KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let law = section.text("law")?.unwrap_or("draine03_rv31");
    let extinction = section.wrap("law", Extinction::named(law, section.number("r_v", 0.0..=100.0)?))?;
    let albedo = albedo::build(section, loader, &extinction)?;
    let phase = section.table("phase")?.map(|s| phase::build(&s, loader, &extinction)).transpose()?;
    Ok(Dust {
        density: fields.expression(section, "density", loader)?,
        sigma_v_per_pc: scale(section)?,
        extinction: Arc::new(extinction),
        albedo,
        phase: phase.unwrap_or_else(phase::isotropic),
    })
}

/// The unit tells whether extinction is per length or per column of hydrogen.
fn scale(section: &Section) -> Result<f64> {
    let text = section.need_text("scale")?;
    let coefficient = ExtinctionCoefficient::parse(text).map(|c| c.0).or_else(|first| {
        let per_column = ExtinctionPerColumn::parse(text).map(|c| c.0);
        per_column.map_err(|_| section.error("scale", format!("{first}; for a density in cm-3, write it like \"5.32e-22 mag cm2\"")))
    })?;
    if coefficient < 0.0 {
        return Err(section.error("scale", "extinction cannot be negative"));
    }
    Ok(coefficient)
}
