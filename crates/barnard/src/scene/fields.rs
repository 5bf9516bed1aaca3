//! The named fields of a scene, and expressions of them.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
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

/// Expressions that may have names, fields that one may be made of in all, and expressions within each other.
const MOST_EXPRESSIONS: usize = 256;
const MOST_FIELDS: usize = 1000;
const DEEPEST: usize = 32;

/// What a field is made of.
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

/// The named fields of a scene.
pub struct Fields {
    named: BTreeMap<String, Arc<dyn Field>>,
    /// What the scene says about all of them together.
    said: String,
    /// The names of those that are made roughly.
    rough: BTreeSet<String>,
    /// How many fields each expression is made of in all, those of its fields included, and how deep it is nested; others are of
    /// themselves.
    made_of: BTreeMap<String, MadeOf>,
    /// Whether one of those was asked for.
    uses_rough: Cell<bool>,
}

impl Fields {
    pub(super) fn new(root: &Section, loader: &Loader) -> Result<Self> {
        let mut fields = Self {
            named: BTreeMap::new(),
            said: String::new(),
            rough: BTreeSet::new(),
            made_of: BTreeMap::new(),
            uses_rough: Cell::new(false),
        };
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
            if is_rough {
                fields.rough.insert(name.to_owned());
            }
        }
        if let Some((section, _)) = expressions.values().next().filter(|_| expressions.len() > MOST_EXPRESSIONS) {
            let count = expressions.len();
            return Err(section.error("kind", format!("{count} fields are expressions, at most {MOST_EXPRESSIONS} may be")));
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
                if let Some((section, needs)) = left.remove(name) {
                    let (field, is_rough) = self.made(&section, "formula", loader)?;
                    self.check_nested(name, &needs, &field, &section)?;
                    if is_rough {
                        self.rough.insert(name.to_owned());
                    }
                    self.named.insert(name.to_owned(), field);
                    self.said += &format!("[{name}] {}", section.said());
                }
            }
        }
        Ok(())
    }

    /// Refuses an expression that is not zero outside of its fields' boxes, which no box of its own would say, and those of so
    /// many fields within each other that none could be evaluated.
    fn check_nested(&mut self, name: &str, needs: &[String], field: &Arc<dyn Field>, section: &Section) -> Result<()> {
        if Expression::is_endless(section.need_text("formula")?) {
            let message = "it is not zero outside of the boxes of its fields, where it would be cut: write it where it is used, as in \"cloud * (1 - hole)\"";
            return Err(section.error("formula", message));
        }
        // A grid is read as it is, whatever it was made of.
        let of = |need: &String| self.made_of.get(need).copied().unwrap_or_default();
        let all = needs.iter().map(of).fold(MadeOf { fields: 0, depth: 0 }, |all, own| MadeOf {
            fields: all.fields.saturating_add(own.fields),
            depth: all.depth.max(own.depth + 1),
        });
        if field.grid().is_none() {
            if all.fields > MOST_FIELDS || all.depth > DEEPEST {
                let MadeOf { fields, depth } = all;
                let message =
                    format!("it is made of {fields} fields, {depth} expressions deep: at most {MOST_FIELDS} and {DEEPEST} are evaluated");
                return Err(section.error("formula", message));
            }
            self.made_of.insert(name.to_owned(), all);
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

    /// A formula under `key` that holds in all of space, of the fields or of none.
    ///
    /// # Errors
    /// Where it is no expression of fields that there are.
    pub(super) fn everywhere(&self, section: &Section, key: &str, formula: &str) -> Result<Arc<dyn Field>> {
        let made = Expression::everywhere(formula, |name| self.named(name));
        Ok(Arc::new(made.map_err(|message| section.error(key, message))?))
    }

    fn named(&self, name: &str) -> std::result::Result<Arc<dyn Field>, String> {
        self.named.get(name).cloned().ok_or_else(|| {
            let known: Vec<&str> = self.named.keys().map(String::as_str).collect();
            SpectraError::unknown("field", name, &known).to_string()
        })
    }

    /// The same, and whether it is made roughly.
    fn made(&self, section: &Section, key: &str, loader: &Loader) -> Result<(Arc<dyn Field>, bool)> {
        let formula = section.need_text(key)?;
        let lookup = |name: &str| self.named(name);
        let said = format!("{formula} of {}", self.said);
        let is_long = !self.rough.is_empty() && Expression::names(formula).is_ok_and(|names| names.iter().any(|n| self.rough.contains(n)));
        loader.long_field(&said, is_long, |inputs| {
            let expression = Expression::parse(formula, lookup).map_err(|e| section.error(key, e))?;
            let field = section.wrap(key, expression.into_field(inputs.memory_limit, &loader.control))?;
            if let Some(grid) = field.grid() {
                section.wrap(key, grid.check(formula))?;
            }
            Ok(field)
        })
    }
}
