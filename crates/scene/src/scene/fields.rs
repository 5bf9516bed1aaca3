//! The named fields of a scene, and expressions of them.

use std::cell::{Cell, OnceCell};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use spectra::SpectraError;
use spectra::fingerprint::{Digest, Fingerprint};
use spectra::units::Velocity;

use super::Loader;
use super::species::Motion;
use crate::error::{Error, Result};
use crate::field::{self, Expression, Field};
use crate::properties::{Formula, Key, KeyRow, Kind, KindRow, OrDefault, Part, Required, Section, Texts, chosen};

const FORMULA: Key<Formula, Required> = Key::formula(
    "formula",
    "expression of other fields, such as \"cloud * (1 - hole)\"; the order is free, and they may be expressions themselves",
)
.required();

/// A field that other fields make.
const EXPRESSION: KindRow =
    KindRow { name: "expression", summary: "expression of other fields, shared by several densities", keys: &[FORMULA.row] };

/// Velocity of gas.
pub(super) const VELOCITY: Key<Texts> = Key::texts(
    "velocity",
    "velocity along x, y and z in km/s, three expressions such as [\"20*x\", \"20*y\", \"20*z\"]; lines are Doppler-shifted as seen from the scene's camera",
)
.otherwise("at rest")
.example("[\"0\", \"0\", \"20*z\"]")
    .affects(&[Part::Space, Part::Spectra]);

/// Resolution of the velocity.
pub(super) const VELOCITY_STEP: Key<Velocity, OrDefault> =
    Key::quantity::<Velocity>("velocity_step", "velocity resolution; use half of a channel or less")
        .positive()
        .default("10 km/s")
        .needs("velocity")
        .affects(&[Part::Space, Part::Spectra]);

/// The density of dust or gas, in any table that has one.
const DENSITY: Key<Formula> = Key::formula("density", "density");

/// All kinds of field that a scene may name.
pub(super) fn kinds() -> Vec<KindRow> {
    field::KINDS.iter().map(Kind::row).chain([EXPRESSION]).collect()
}

/// Expressions that may have names, fields that one may be made of in all, and expressions within each other.
const MOST_EXPRESSIONS: usize = 256;
const MOST_FIELDS: usize = 1000;
const DEEPEST: usize = 32;

/// Fields within a field.
#[derive(Debug, Clone, Copy)]
struct MadeOf {
    fields: usize,
    depth: usize,
}

impl Default for MadeOf {
    fn default() -> Self {
        Self { fields: 1, depth: 0 }
    }
}

/// A named field. One that was made once before is made again when it is asked for: expressions on grids do not need the fields that they
/// were made of.
struct NamedField<'a> {
    section: Section<'a>,
    /// Fingerprint by which the loader knows it.
    content: Fingerprint,
    made: OnceCell<Arc<dyn Field>>,
}

impl NamedField<'_> {
    fn is_expression(&self) -> bool {
        self.section.kind() == Some(EXPRESSION.name)
    }
}

/// Rejects invalid names of fields, invalid formulas and unknown fields in them, before fields are made, which may take long.
fn check_formulas(root: &Section) -> Result<()> {
    let fields = root.named_tables("field")?;
    fields.iter().try_for_each(|(name, section)| field::check_name(name).map_err(|e| section.error("name", e)))?;
    let known: Vec<&str> = fields.iter().map(|(name, _)| *name).collect();
    let check = |section: &Section, key: &KeyRow, formula: &str| {
        let names = Expression::names(formula).map_err(|message| section.error(key, message))?;
        match names.iter().find(|name| !known.contains(&name.as_str())) {
            Some(name) => Err(section.error(key, SpectraError::unknown("field", name, &known).to_string())),
            None => Ok(()),
        }
    };
    let kinds = kinds();
    for (_, section) in &fields {
        chosen("field", &kinds, |kind| (kind.name, kind.keys), &[], section)?;
    }
    let is_expression = |section: &Section| section.kind() == Some(EXPRESSION.name);
    let expressions: Vec<&Section> = fields.iter().map(|(_, section)| section).filter(|section| is_expression(section)).collect();
    if expressions.len() > MOST_EXPRESSIONS {
        return Err(
            expressions[0].error("kind", format!("{} fields are expressions; at most {MOST_EXPRESSIONS} are supported", expressions.len()))
        );
    }
    for section in expressions {
        check(section, &FORMULA, section.read(&FORMULA)?)?;
    }
    let tables = [root.table("dust")?, root.table("gas")?].into_iter().flatten().chain(root.tables("emission")?);
    for section in tables {
        let velocities = section.read(&VELOCITY)?.unwrap_or_default();
        section.stated(&DENSITY)?.map_or(Ok(()), |formula| check(&section, &DENSITY, formula))?;
        velocities.iter().try_for_each(|formula| check(&section, &VELOCITY, formula))?;
    }
    Ok(())
}

/// The named fields of a scene.
pub struct Fields<'a> {
    named: BTreeMap<String, NamedField<'a>>,
    loader: &'a Loader,
    /// Fingerprint of all of them.
    content: Fingerprint,
    /// The names of those that are made roughly.
    rough: BTreeSet<String>,
    /// How many fields each expression is made of in all, those of its fields included, and how deep it is nested; others are of
    /// themselves.
    made_of: BTreeMap<String, MadeOf>,
    /// True if one of those was asked for.
    uses_rough: Cell<bool>,
}

impl<'a> Fields<'a> {
    pub(super) fn new(root: &Section<'a>, loader: &'a Loader) -> Result<Self> {
        let mut fields = Self {
            named: BTreeMap::new(),
            loader,
            content: Digest::new("fields").finish(),
            rough: BTreeSet::new(),
            made_of: BTreeMap::new(),
            uses_rough: Cell::new(false),
        };
        check_formulas(root)?;
        let (kinds, mut expressions) = (kinds(), BTreeMap::new());
        for (name, section) in root.named_tables("field")? {
            let kind = chosen("field", &kinds, |kind| (kind.name, kind.keys), &[], &section)?;
            if kind.name == EXPRESSION.name {
                let needs = Expression::names(section.read(&FORMULA)?).unwrap_or_default();
                expressions.insert(name, (section, needs));
                continue;
            }
            let content = section.fingerprint();
            fields.extend(name, content);
            if loader.makes_roughly(content, field::takes_long(&section)) {
                fields.rough.insert(name.to_owned());
            }
            fields.add(name, section, content)?;
        }
        fields.add_expressions(expressions)?;
        Ok(fields)
    }

    /// Adds a field, which is made at once if it is new; returns whether it is a grid.
    fn add(&mut self, name: &str, section: Section<'a>, content: Fingerprint) -> Result<bool> {
        let entry = NamedField { section, content, made: OnceCell::new() };
        let is_grid = match self.loader.is_grid(content) {
            Some(is_grid) => {
                // What somebody holds is held from now on.
                if let Some(field) = self.loader.known_field(content) {
                    entry.made.get_or_init(|| field);
                }
                is_grid
            }
            None => {
                let field = self.make(&entry)?;
                let is_grid = field.grid().is_some();
                self.loader.remember(content, is_grid);
                entry.made.get_or_init(|| field);
                is_grid
            }
        };
        self.named.insert(name.to_owned(), entry);
        Ok(is_grid)
    }

    /// Makes a named field; the loader may hold it.
    fn make(&self, entry: &NamedField) -> Result<Arc<dyn Field>> {
        let NamedField { section, content, .. } = entry;
        match entry.is_expression() {
            true => self.made(section, &FORMULA, *content),
            false => self.loader.long_field(*content, field::takes_long(section), |inputs| field::build(section, inputs)),
        }
    }

    /// Makes fields of others, each after those that it needs.
    fn add_expressions(&mut self, mut left: BTreeMap<&str, (Section<'a>, Vec<String>)>) -> Result<()> {
        while !left.is_empty() {
            // What is no field at all is complained of when the expression is made.
            let waits = |needs: &[String]| needs.iter().any(|name| left.contains_key(name.as_str()));
            let ready: Vec<&str> = left.iter().filter(|(_, (_, needs))| !waits(needs)).map(|(name, _)| *name).collect();
            if ready.is_empty() {
                let names: Vec<&str> = left.keys().copied().collect();
                let (section, _) = &left[names[0]];
                let message = format!("the fields {} depend on each other; break the cycle", names.join(", "));
                return Err(section.error(&FORMULA, message));
            }
            for name in ready {
                if let Some((section, needs)) = left.remove(name) {
                    let content = self.of_formula(section.read(&FORMULA)?);
                    if self.makes_roughly(&needs, content) {
                        self.rough.insert(name.to_owned());
                    }
                    let is_grid = self.add(name, section.clone(), content)?;
                    self.check_nested(name, &needs, is_grid, &section)?;
                    self.extend(name, section.fingerprint());
                }
            }
        }
        Ok(())
    }

    /// Refuses an expression that is not zero outside of its fields' boxes, which no box of its own would say, and those of so
    /// many fields within each other that none could be evaluated.
    fn check_nested(&mut self, name: &str, needs: &[String], is_grid: bool, section: &Section) -> Result<()> {
        if Expression::is_endless(section.read(&FORMULA)?) {
            let message = "it is not zero outside of the boxes of its fields, where it would be truncated; write it where it is used, as in \"cloud * (1 - hole)\"";
            return Err(section.error(&FORMULA, message));
        }
        // A grid is read as it is, whatever it was made of.
        let known = |need: &String| self.made_of.get(need).copied().unwrap_or_default();
        let all = needs.iter().map(known).fold(MadeOf { fields: 0, depth: 0 }, |all, need| MadeOf {
            fields: all.fields.saturating_add(need.fields),
            depth: all.depth.max(need.depth + 1),
        });
        if !is_grid {
            if all.fields > MOST_FIELDS || all.depth > DEEPEST {
                let MadeOf { fields, depth } = all;
                let message =
                    format!("it uses {fields} fields and nests {depth} expressions; at most {MOST_FIELDS} and {DEEPEST} are supported");
                return Err(section.error(&FORMULA, message));
            }
            self.made_of.insert(name.to_owned(), all);
        }
        Ok(())
    }

    /// Fingerprint of all of them.
    pub(super) fn fingerprint(&self) -> Fingerprint {
        self.content
    }

    fn extend(&mut self, name: &str, content: Fingerprint) {
        self.content = Digest::new("fields").part(self.content).text(name).part(content).finish();
    }

    /// True if a field was asked for that is made roughly.
    pub(super) fn are_rough(&self) -> bool {
        self.uses_rough.get()
    }

    /// The field that the expression under `key` is.
    ///
    /// # Errors
    /// If it is no expression of fields that there are, or what it gives is no density.
    pub fn expression(&self, section: &Section, key: &Key<Formula, Required>) -> Result<Arc<dyn Field>> {
        let formula = section.read(key)?;
        let content = self.of_formula(formula);
        let is_rough = self.makes_roughly(&Expression::names(formula).unwrap_or_default(), content);
        let field = self.made(section, key, content)?;
        self.uses_rough.set(self.uses_rough.get() | is_rough);
        Ok(field)
    }

    /// Velocity of the gas of a table, whose components are expressions that hold in all of space.
    ///
    /// # Errors
    /// If a component is no expression of known fields.
    pub(super) fn motion(&self, section: &Section) -> Result<Option<Motion>> {
        let Some(formulas) = section.read(&VELOCITY)? else { return Ok(None) };
        let [x, y, z] = formulas[..] else {
            return Err(section.error(&VELOCITY, "a velocity must have three components, such as [\"0\", \"0\", \"20*z\"] in km/s"));
        };
        let component = |formula: &str| -> Result<Arc<dyn Field>> {
            let made = Expression::everywhere(formula, |name| self.named(name));
            Ok(Arc::new(made.map_err(|message| self.wrong(section, &VELOCITY.row, message))?))
        };
        Ok(Some(Motion::new([component(x)?, component(y)?, component(z)?], section.read(&VELOCITY_STEP)?)))
    }

    fn named(&self, name: &str) -> std::result::Result<Arc<dyn Field>, String> {
        let entry = self.named.get(name).ok_or_else(|| {
            let known: Vec<&str> = self.named.keys().map(String::as_str).collect();
            SpectraError::unknown("field", name, &known).to_string()
        })?;
        if let Some(field) = entry.made.get() {
            return Ok(field.clone());
        }
        let field = self.make(entry).map_err(|error| error.to_string())?;
        Ok(entry.made.get_or_init(|| field).clone())
    }

    /// Error of a formula, or its interruption.
    fn wrong(&self, section: &Section, key: &KeyRow, message: String) -> Error {
        if self.loader.control.interrupted() { Error::Interrupted } else { section.error(key, message) }
    }

    /// Fingerprint by which the loader knows an expression of the fields so far.
    fn of_formula(&self, formula: &str) -> Fingerprint {
        Digest::new("expression").text(formula).part(self.content).finish()
    }

    /// True if an expression of some fields is made roughly, since one of them is.
    fn makes_roughly(&self, names: &[String], content: Fingerprint) -> bool {
        self.loader.makes_roughly(content, names.iter().any(|name| self.rough.contains(name)))
    }

    /// The field that the expression under `key` is, which the loader knows by a fingerprint.
    fn made(&self, section: &Section, key: &Key<Formula, Required>, content: Fingerprint) -> Result<Arc<dyn Field>> {
        let formula = section.read(key)?;
        let lookup = |name: &str| self.named(name);
        let is_long = Expression::names(formula).is_ok_and(|names| names.iter().any(|name| self.rough.contains(name)));
        self.loader.long_field(content, is_long, |inputs| {
            let expression = Expression::parse(formula, lookup).map_err(|message| self.wrong(section, key, message))?;
            let field = section.wrap(key, expression.into_field(inputs.memory_limit, inputs.cache.as_deref(), &self.loader.control))?;
            if let Some(grid) = field.grid() {
                section.wrap(key, grid.check(formula))?;
            }
            Ok(field)
        })
    }
}
