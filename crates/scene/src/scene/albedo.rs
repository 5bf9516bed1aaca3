//! Albedos: the part of extinction that is scattering, ω(λ).

use std::sync::Arc;

use spectra::curve::Ordinate;
use spectra::extinction::Extinction;
use spectra::table::Table;
use spectra::units::Wavelength;

use crate::curve::{self, COLUMN, UNIT};
use crate::data::Inputs;
use crate::error::{Error, Result};
use crate::properties::{
    Entry, Key, Kind, Number, OrDefault, Path, Range, Required, Section, SubTable, Type, Value, ValueRef, ValueType, build_kind,
};

/// The part of extinction that is scattering, ω(λ) \[1\].
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Albedo {
    /// An albedo that is the same at every wavelength.
    Constant(f64),
    /// value + slope (λ − at)/0.1 µm, cut to [0, 1].
    Linear {
        /// The albedo at `at_um` \[1\].
        value: f64,
        /// The growth of the albedo for each 0.1 µm \[1\].
        slope: f64,
        /// The wavelength at which the albedo is `value` \[µm\].
        at_um: f64,
    },
    /// A table over λ \[µm\].
    Table(Arc<Table>),
    /// That of a model of grains, by its name: the law's own, or the one that goes with a law of extinction alone.
    Grains {
        /// The name of the model.
        model: &'static str,
        /// Its albedo over λ \[µm\].
        albedo: Arc<Table>,
    },
    /// Unknown: dust of a law without a model of grains, before it is stated. [`Scene::check`](super::Scene::check)
    /// refuses it.
    Unknown,
}

impl From<f64> for Albedo {
    fn from(value: f64) -> Self {
        Albedo::Constant(value)
    }
}

impl From<Table> for Albedo {
    fn from(table: Table) -> Self {
        Albedo::Table(Arc::new(table))
    }
}

impl Albedo {
    /// The albedo ω at the wavelength λ \[µm\].
    pub fn at(&self, lambda_um: f64) -> f64 {
        match self {
            Albedo::Constant(v) => *v,
            Albedo::Linear { value, slope, at_um } => (value + slope * (lambda_um - at_um) / 0.1).clamp(0.0, 1.0),
            Albedo::Table(table) | Albedo::Grains { albedo: table, .. } => table.at(lambda_um),
            Albedo::Unknown => f64::NAN,
        }
    }

    /// An albedo of `value` at the wavelength `at`, which grows by `slope` for each 0.1 µm and is cut to 0 to 1.
    ///
    /// # Errors
    /// If the value lies outside of 0 to 1, the slope is no number, or the wavelength is not above zero.
    pub fn linear(value: f64, slope: f64, at: Wavelength) -> Result<Self> {
        let albedo = Albedo::Linear { value, slope, at_um: at.0 };
        albedo.check("")?;
        Ok(albedo)
    }

    /// The albedo of the [grains](Extinction::grains) that go with an extinction law.
    pub fn of_law(extinction: &Extinction) -> Self {
        extinction.grains().map_or(Albedo::Unknown, |grains| Albedo::Grains { model: grains.name, albedo: Arc::new(grains.albedo) })
    }

    /// Note, as key and text, on an albedo that is a default: the extinction law has none, so that of a grain model is used.
    pub fn note(&self, law: &str) -> Option<(String, String)> {
        match self {
            Albedo::Grains { model, .. } if *model != law => {
                Some(("albedo".into(), format!("that of {model}, because none is given and law {law} defines extinction only")))
            }
            _ => None,
        }
    }

    /// Refuses values outside of 0 to 1, and albedos of which nothing is known; `law` stands in the message.
    pub(super) fn check(&self, law: &str) -> Result<()> {
        let sound = |v: &f64| (0.0..=1.0).contains(v);
        let wrong = match self {
            Albedo::Linear { slope, .. } if !slope.is_finite() => return Err(Error::out_of_range("slope of the albedo", slope, "finite")),
            Albedo::Linear { at_um, .. } if !(*at_um > 0.0 && at_um.is_finite()) => {
                return Err(Error::out_of_range("wavelength of the albedo", format!("{at_um} um"), "finite and above zero"));
            }
            Albedo::Constant(value) | Albedo::Linear { value, .. } => Some(value).filter(|v| !sound(v)),
            Albedo::Table(table) | Albedo::Grains { albedo: table, .. } => table.y().iter().find(|v| !sound(v)),
            Albedo::Unknown => {
                let remedy =
                    format!("extinction law \"{law}\" does not define one; set a value such as 0.6, or use a law such as draine03_rv31");
                return Err(Error::missing("albedo", remedy));
            }
        };
        wrong.map_or(Ok(()), |v| Err(Error::out_of_range("albedo", v, "between 0 and 1")))
    }
}

const VALUE: Key<Number, Required> = value("the albedo");
const VALUE_AT: Key<Number, Required> = value("albedo at the wavelength `at`");
const SLOPE: Key<Number, OrDefault> = Key::number("slope", "change per 100 nm").range(-1.0..=1.0).default(0.0);
const AT: Key<Wavelength, OrDefault> = Key::quantity::<Wavelength>("at", "wavelength of the value").positive().default("550 nm");
const FILE: Key<Path, Required> = Key::path("file", "text, ECSV, VOTable or FITS table of wavelength and albedo").required();

/// All kinds of albedo that a scene may name.
pub(super) const KINDS: &[Kind<Albedo>] = &[
    Kind {
        name: "constant",
        summary: "constant over wavelength; short form: albedo = 0.6",
        keys: &[VALUE.row],
        build: |section, _| Ok(Albedo::Constant(section.read(&VALUE)?)),
    },
    Kind {
        name: "linear",
        summary: "value + slope (lambda - at)/100 nm, clipped to 0 to 1",
        keys: &[VALUE_AT.row, SLOPE.row, AT.row],
        build: |section, _| {
            Ok(Albedo::Linear { value: section.read(&VALUE_AT)?, slope: section.read(&SLOPE)?, at_um: section.read(&AT)?.0 })
        },
    },
    Kind {
        name: "file",
        summary: "from a file of wavelength and albedo",
        keys: &[FILE.row, UNIT.row, COLUMN.row],
        build: |section, inputs| {
            let file = section.read(&FILE)?;
            let table = curve::read(section, &FILE, Ordinate::Albedo, inputs)?.table;
            if table.y().iter().any(|v| !(0.0..=1.0).contains(v)) {
                return Err(section.error(&FILE, format!("{file} has albedos outside of 0 to 1")));
            }
            Ok(table.into())
        },
    },
];

const fn value(summary: &'static str) -> Key<Number, Required> {
    Key::number("value", summary).range(0.0..=1.0).required().example("0.6")
}

/// The albedo of `[dust]`: a number, or a table of its own.
pub(super) const ALBEDO: Key<NumberOrTable> = Key::<NumberOrTable>::new(
    "albedo",
    "scattered fraction of extinction; Milky Way laws without grains use Draine 2003 of the nearest R_V",
)
.otherwise("albedo of the law's grains")
.example("0.6");

/// A number from 0 to 1, or a table.
pub(super) enum NumberOrTable {}

impl ValueType for NumberOrTable {
    const TYPE: Type = Type::Other("number or table");
    const RANGE: Range = Range { low: 0.0, high: 1.0, ..Range::ALL };
    type Value<'a> = NumberOr<Section<'a>>;
    fn read<'a>(entry: &Entry<'a, '_>) -> Result<Self::Value<'a>> {
        match entry.value {
            ValueRef::Given(Value::Table(_)) => SubTable::read(entry).map(NumberOr::Other),
            _ => Number::read(entry).map(NumberOr::Number),
        }
    }
}

/// A number or something else.
pub(super) enum NumberOr<T> {
    Number(f64),
    Other(T),
}

/// A number, a table, or the law's own.
pub(super) fn build(dust: &Section, inputs: &Inputs, extinction: &Extinction) -> Result<Albedo> {
    match dust.read(&ALBEDO)? {
        Some(NumberOr::Number(albedo)) => Ok(Albedo::Constant(albedo)),
        Some(NumberOr::Other(section)) => build_kind("albedo", KINDS, &section, inputs),
        None => match Albedo::of_law(extinction) {
            Albedo::Unknown => {
                let message = "does not define an albedo; write albedo = 0.6, or use a law such as draine03_rv31";
                Err(dust.error(&ALBEDO, format!("law \"{}\" {message}", extinction.name)))
            }
            albedo => Ok(albedo),
        },
    }
}
