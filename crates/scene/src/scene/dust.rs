//! The `[dust]` table.

use std::sync::Arc;

use spectra::extinction::Extinction;
use spectra::units::{ExtinctionCoefficient, ExtinctionPerColumn, ExtinctionPerMass, Quantity};

use super::albedo::{self, Albedo};
use super::{Fields, Loader};
use crate::error::{Error, Result};
use crate::field::{Field, IntoField, grams_per_h};
use crate::phase::{self, IntoPhase, Isotropic, Phase};
use crate::properties::{Key, Section};

/// Extinction coefficient at V per unit of density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    per_pc: f64,
}

impl Scale {
    /// Optical depth at V for each parsec [pc⁻¹].
    pub fn per_pc(sigma: f64) -> Self {
        Self { per_pc: sigma }
    }

    /// Extinction A_V for each parsec [mag pc⁻¹].
    pub fn mag_per_pc(extinction: f64) -> Self {
        Self::unit(extinction, ExtinctionCoefficient::unit_size("mag/pc"))
    }

    /// Extinction A_V for each column of hydrogen [mag cm²], the density being hydrogen nuclei per cm³.
    pub fn mag_cm2(extinction: f64) -> Self {
        Self::unit(extinction, ExtinctionPerColumn::unit_size("mag cm2"))
    }

    fn unit(value: f64, size: Option<f64>) -> Self {
        Self { per_pc: value * size.unwrap_or(f64::NAN) }
    }
}

/// Dust: where it is, and what it does to light.
#[derive(Debug, Clone)]
pub struct Dust {
    /// The density, in a unit of its own.
    pub density: Arc<dyn Field>,
    /// Extinction coefficient at V for density 1 [pc⁻¹].
    pub sigma_v_per_pc: f64,
    /// The extinction law k(λ), relative to V.
    pub extinction: Arc<Extinction>,
    /// The albedo ω(λ).
    pub albedo: Albedo,
    /// The phase function p(cos θ, λ).
    pub phase: Arc<dyn Phase>,
}

impl Dust {
    /// Dust of a `density`, a field in a unit of its own, of which one has the extinction `scale`. Its albedo is that of
    /// the [grains](Extinction::grains) of the law, and it scatters evenly, unless the methods below say otherwise.
    pub fn new(density: impl IntoField, extinction: impl Into<Arc<Extinction>>, scale: Scale) -> Self {
        let extinction = extinction.into();
        let albedo = Albedo::of_law(&extinction);
        Self { density: density.into_field(), sigma_v_per_pc: scale.per_pc, extinction, albedo, phase: Arc::new(Isotropic) }
    }

    /// The part of its extinction that scatters, 0 to 1: a number, or a table over λ \[µm\].
    #[must_use]
    pub fn albedo(self, albedo: impl Into<Albedo>) -> Self {
        Self { albedo: albedo.into(), ..self }
    }

    /// Copy of the dust, which spreads scattered light over angle like this.
    #[must_use]
    pub fn phase(self, phase: impl IntoPhase) -> Self {
        Self { phase: phase.into_phase(), ..self }
    }

    /// Refuses numbers that no dust has.
    pub(super) fn check(&self) -> Result<()> {
        if !(self.sigma_v_per_pc >= 0.0 && self.sigma_v_per_pc.is_finite()) {
            return Err(Error::out_of_range("scale", self.sigma_v_per_pc, "a finite extinction of at least zero"));
        }
        self.albedo.check(&self.extinction.name)
    }
}

pub(super) const KEYS: &[Key] = &[
    Key::required("density", "expression", "density, an expression of fields such as \"cloud\" or \"n_H * (1 - x_ion)\""),
    Key::required(
        "scale",
        "extinction",
        "extinction at density 1: per length (A_V of \"2 mag/pc\", depth of \"4 /pc\"), or for a density in cm-3 per hydrogen column (\"5.32e-22 mag cm2\") or mass column (\"200 cm2/g\", with mass_per_h)",
    ),
    Key::optional(
        "mass_per_h",
        "number",
        "required for a scale per mass",
        "mass per hydrogen nucleus in hydrogen masses, for a scale per gram: 1.4 for all of the gas",
    ),
    Key::optional("law", "text", "draine03_rv31", "extinction law").of("laws"),
    Key::optional("r_v", "number", "3.1", "A(V)/E(B-V), for laws with this parameter"),
    Key::optional(
        "albedo",
        "number or table",
        "albedo of the law's grains",
        "scattered fraction of extinction; Milky Way laws without grains use Draine 2003 of the nearest R_V",
    ),
    Key::optional("phase", "table", "isotropic", "angular distribution of scattered light"),
];

pub(super) fn build(section: &Section, loader: &Loader, fields: &Fields) -> Result<Dust> {
    let keys: Vec<&str> = KEYS.iter().map(|k| k.name).collect();
    section.check_keys(&keys)?;
    let law = section.text("law")?.unwrap_or("draine03_rv31");
    let extinction = section.wrap("law", Extinction::with_r_v(law, section.number("r_v", 0.0..=100.0)?))?;
    let albedo = albedo::build(section, &loader.inputs, &extinction)?;
    let phase = section.table("phase")?.map(|s| phase::build(&s, &loader.inputs, &extinction)).transpose()?;
    Ok(Dust {
        density: fields.expression(section, "density")?,
        sigma_v_per_pc: scale(section)?,
        extinction: Arc::new(extinction),
        albedo,
        phase: phase.unwrap_or_else(|| Arc::new(Isotropic)),
    })
}

/// The unit tells whether extinction is per length or per column of hydrogen.
fn scale(section: &Section) -> Result<f64> {
    let text = section.need_text("scale")?;
    let grams = grams_per_h(section)?;
    let coefficient = match ExtinctionPerMass::parse(text) {
        Ok(per_mass) => {
            let missing = "is per mass; add mass_per_h = 1.4, the gas mass per hydrogen nucleus in hydrogen masses";
            per_mass.0 * grams.ok_or_else(|| section.error("scale", missing))?
        }
        Err(_) => {
            section.refuse(&["mass_per_h"], "a scale in cm2/g")?;
            ExtinctionCoefficient::parse(text).map(|c| c.0).or_else(|first| {
                let per_column = ExtinctionPerColumn::parse(text).map(|c| c.0);
                per_column
                    .map_err(|_| section.error("scale", format!("{first}; for a density in cm-3, write it like \"5.32e-22 mag cm2\"")))
            })?
        }
    };
    if coefficient < 0.0 {
        return Err(section.error("scale", "extinction cannot be negative"));
    }
    Ok(coefficient)
}
