//! The named fields of a scene, and expressions of them.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::sync::Arc;

use spectra::SpectraError;

use super::Loader;
use crate::error::Result;
use crate::field::{self, Expression, Field};
use crate::properties::{Key, Kind, KindRow, Section, chosen};

/// A field that other fields make.
const EXPRESSION: KindRow = KindRow {
    name: "expression",
    summary: "an expression of other fields, for what several densities have in common",
    keys: &[Key::required(
        "formula",
        "expression",
        "of other fields, such as \"cloud * (1 - hole)\"; they may stand in any order, and be expressions themselves",
    )],
};

/// All kinds of field that a scene may name.
pub(super) fn kinds() -> Vec<KindRow> {
    field::KINDS.iter().map(Kind::row).chain([EXPRESSION]).collect()
}

/// The named fields of a scene.
pub struct Fields {
    named: BTreeMap<String, Arc<dyn Field>>,
    /// What the scene says about all of them together.
    said: String,
    /// Whether some of them are made roughly.
    has_rough: bool,
    /// Whether one of those was asked for.
    uses_rough: Cell<bool>,
}

impl Fields {
    pub(super) fn new(root: &Section, loader: &Loader) -> Result<Self> {
        let mut fields = Self { named: BTreeMap::new(), said: String::new(), has_rough: false, uses_rough: Cell::new(false) };
        let (kinds, mut expressions) = (kinds(), BTreeMap::new());
        for (name, section) in root.named_tables("field")? {
            field::check_name(name).map_err(|e| section.error("name", e))?;
            let kind = chosen("field", &kinds, |kind| (kind.name, kind.keys), &[], &section)?;
            if kind.name == EXPRESSION.name {
                let needs = Expression::names(section.need_text("formula")?).unwrap_or_default();
                expressions.insert(name, (section, needs));
                continue;
            }
            let said = section.said();
            let (field, is_rough) = loader.long_field(&said, field::takes_long(&section), |inputs| field::build(&section, inputs))?;
            fields.named.insert(name.to_owned(), field);
            fields.said += &format!("[{name}] {said}");
            fields.has_rough |= is_rough;
        }
        fields.add_expressions(expressions, loader)?;
        Ok(fields)
    }

    /// Makes fields of others, each after those that it needs.
    fn add_expressions(&mut self, mut left: BTreeMap<&str, (Section, Vec<String>)>, loader: &Loader) -> Result<()> {
        while !left.is_empty() {
            // What is no field at all is complained of when the expression is made.
            let waits = |needs: &[String]| needs.iter().any(|name| left.contains_key(name.as_str()));
            let ready: Vec<&str> = left.iter().filter(|(_, (_, needs))| !waits(needs)).map(|(name, _)| *name).collect();
            if ready.is_empty() {
                let names: Vec<&str> = left.keys().copied().collect();
                let (section, _) = &left[names[0]];
                let message = format!("the fields {} need each other: one of them must be made of others alone", names.join(", "));
                return Err(section.error("formula", message));
            }
            for name in ready {
                if let Some((section, _)) = left.remove(name) {
                    let (field, is_rough) = self.made(&section, "formula", loader)?;
                    self.has_rough |= is_rough;
                    self.named.insert(name.to_owned(), field);
                    self.said += &format!("[{name}] {}", section.said());
                }
            }
        }
        Ok(())
    }

    /// What the scene says about all of them together.
    pub(super) fn said(&self) -> &str {
        &self.said
    }

    /// Whether a field was asked for that is made roughly.
    pub(super) fn are_rough(&self) -> bool {
        self.uses_rough.get()
    }

    /// The field that the expression under `key` is.
    ///
    /// # Errors
    /// Where it is no expression of fields that there are, or what it gives is no density.
    pub fn expression(&self, section: &Section, key: &str, loader: &Loader) -> Result<Arc<dyn Field>> {
        let (field, is_rough) = self.made(section, key, loader)?;
        self.uses_rough.set(self.uses_rough.get() | is_rough);
        Ok(field)
    }

    /// The same, and whether it is made roughly.
    fn made(&self, section: &Section, key: &str, loader: &Loader) -> Result<(Arc<dyn Field>, bool)> {
        let formula = section.need_text(key)?;
        let lookup = |name: &str| {
            self.named.get(name).cloned().ok_or_else(|| {
                let known: Vec<&str> = self.named.keys().map(String::as_str).collect();
                SpectraError::unknown("field", name, &known).to_string()
            })
        };
        let said = format!("{formula} of {}", self.said);
        loader.long_field(&said, self.has_rough, |inputs| {
            let expression = Expression::parse(formula, lookup).map_err(|e| section.error(key, e))?;
            let field = section.wrap(key, expression.into_field(inputs.memory_limit, &loader.control))?;
            if let Some(grid) = field.grid() {
                section.wrap(key, grid.check(formula))?;
            }
            Ok(field)
        })
    }
}
