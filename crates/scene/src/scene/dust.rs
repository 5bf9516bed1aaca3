//! The `[dust]` table.

use std::sync::Arc;

use spectra::extinction::Extinction;
use spectra::units::{ExtinctionCoefficient, ExtinctionPerColumn, ExtinctionPerMass, Quantity, QuantityRow};

use super::albedo::{self, ALBEDO, Albedo};
use super::{Fields, Loader};
use crate::error::{Error, Result};
use crate::field::{Field, IntoField, grams_per_h, mass_per_h};
use crate::phase::{self, IntoPhase, Isotropic, Phase};
use crate::properties::{Entry, Formula, Key, KeyRow, Number, OrDefault, Part, Required, Section, SubTable, Text, Type, ValueType};

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
    pub fn with_albedo(self, albedo: impl Into<Albedo>) -> Self {
        Self { albedo: albedo.into(), ..self }
    }

    /// Copy of the dust, which spreads scattered light over angle like this.
    #[must_use]
    pub fn with_phase(self, phase: impl IntoPhase) -> Self {
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

const DENSITY: Key<Formula, Required> =
    Key::formula("density", "density, an expression of fields such as \"cloud\" or \"n_H * (1 - x_ion)\"")
        .required()
        .affects(&[Part::Space]);
const SCALE: Key<ExtinctionScale, Required> = Key::<ExtinctionScale>::new(
    "scale",
    "extinction at density 1: per length (A_V of \"2 mag/pc\", depth of \"4 /pc\"), or for a density in cm-3 per hydrogen column (\"5.32e-22 mag cm2\") or mass column (\"200 cm2/g\", with mass_per_h)",
)
.not_negative()
.required()
.affects(&[Part::Amount]);
const MASS_PER_H: Key<Number> = mass_per_h("mass per hydrogen nucleus in hydrogen masses, for a scale per gram: 1.4 for all of the gas")
    .required_for("a scale per mass")
    .affects(&[Part::Amount]);
const LAW: Key<Text, OrDefault> = Key::text("law", "extinction law").default("draine03_rv31").of("laws");
const R_V: Key<Number, OrDefault> = Key::number("r_v", "A(V)/E(B-V), for laws with this parameter").range(0.0..=100.0).default(3.1);
const PHASE: Key<SubTable> = Key::table("phase", "angular distribution of scattered light").otherwise("isotropic");

pub(super) const KEYS: &[KeyRow] = &[DENSITY.row, SCALE.row, MASS_PER_H.row, LAW.row, R_V.row, ALBEDO.row, PHASE.row];

pub(super) fn build(section: &Section, loader: &Loader, fields: &Fields) -> Result<Dust> {
    section.check(KEYS)?;
    let law = section.read(&LAW)?;
    let extinction = section.wrap(&LAW, Extinction::with_r_v(law, section.stated(&R_V)?))?;
    let albedo = albedo::build(section, &loader.inputs, &extinction)?;
    let phase = section.read(&PHASE)?.map(|s| phase::build(&s, &loader.inputs, &extinction)).transpose()?;
    Ok(Dust {
        density: fields.expression(section, &DENSITY)?,
        sigma_v_per_pc: scale(section)?,
        extinction: Arc::new(extinction),
        albedo,
        phase: phase.unwrap_or_else(|| Arc::new(Isotropic)),
    })
}

/// Extinction at V at density 1.
enum ExtinctionValue {
    /// Per length [pc⁻¹], or per hydrogen column for a density in cm⁻³ [pc⁻¹ cm³].
    PerVolume(f64),
    /// Per column of mass.
    PerMass(ExtinctionPerMass),
}

/// Quantity that sets the extinction: its unit determines which.
enum ExtinctionScale {}

impl ValueType for ExtinctionScale {
    const TYPE: Type = Type::Quantity(
        "extinction",
        &[QuantityRow::of::<ExtinctionCoefficient>(), QuantityRow::of::<ExtinctionPerColumn>(), QuantityRow::of::<ExtinctionPerMass>()],
    );
    type Value<'a> = ExtinctionValue;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<ExtinctionValue> {
        if let Ok(per_mass) = ExtinctionPerMass::read(entry) {
            return Ok(ExtinctionValue::PerMass(per_mass));
        }
        if let Ok(per_column) = ExtinctionPerColumn::read(entry) {
            return Ok(ExtinctionValue::PerVolume(per_column.0));
        }
        let remedy = "for a density in cm-3, write it like \"5.32e-22 mag cm2\"";
        ExtinctionCoefficient::read(entry).map(|coefficient| ExtinctionValue::PerVolume(coefficient.0)).map_err(|error| match error {
            Error::Scene { message, .. } => entry.error(format!("{message}; {remedy}")),
            other => other,
        })
    }
}

/// The extinction coefficient at density 1 [pc⁻¹].
fn scale(section: &Section) -> Result<f64> {
    let grams = section.read(&MASS_PER_H)?.map(grams_per_h);
    match section.read(&SCALE)? {
        ExtinctionValue::PerMass(per_mass) => {
            let missing = "is per mass; add mass_per_h = 1.4, the gas mass per hydrogen nucleus in hydrogen masses";
            Ok(per_mass.0 * grams.ok_or_else(|| section.error(&SCALE, missing))?)
        }
        ExtinctionValue::PerVolume(coefficient) => section.refuse(&[&MASS_PER_H.row], "a scale in cm2/g").map(|()| coefficient),
    }
}
