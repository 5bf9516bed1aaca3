//! Sections: typed access to the keys of a table, with errors that state place, key and remedy.

use spectra::error::nearest;

use super::key::{KeyRow, Relation};
use super::typed::{Key, Presence, Required};
use super::values::{Entry, NamedTables, Position, SubTable, Tables, Text, ValueRef, ValueType};
use super::{Place, Table, Value};
use crate::error::{Error, Result};
use crate::geometry::Bounds;

/// The key that selects the kind of a table.
pub const KIND: Key<Text, Required> = Key::new("kind", "kind of the table").required();

/// Name of a key.
pub trait Named {
    /// The name as scenes write it.
    fn name(&self) -> &str;
}

impl Named for str {
    fn name(&self) -> &str {
        self
    }
}

impl Named for KeyRow {
    fn name(&self) -> &str {
        self.name
    }
}

impl<T, P> Named for Key<T, P> {
    fn name(&self) -> &str {
        self.row.name
    }
}

/// One table of a scene, with its full name.
#[derive(Clone)]
pub struct Section<'a> {
    table: &'a Table,
    path: String,
}

impl<'a> Section<'a> {
    /// The section that is the whole tree.
    pub fn root(table: &'a Table) -> Self {
        Self::new(table, "")
    }

    /// The table `table`, called `path`.
    pub fn new(table: &'a Table, path: impl Into<String>) -> Self {
        Self { table, path: path.into() }
    }

    /// The table that the section reads.
    pub fn properties(&self) -> &'a Table {
        self.table
    }

    /// The table's full name, such as "dust.phase".
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The last part of the name.
    pub fn name(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or(&self.path)
    }

    /// True if the table has `key`.
    pub fn has(&self, key: &(impl Named + ?Sized)) -> bool {
        self.table.get(key.name()).is_some()
    }

    /// Canonical text of the table, without comments.
    pub fn canonical(&self) -> String {
        self.table.to_string()
    }

    /// The value of a key: an option, the value, or the default, as the key declares.
    ///
    /// # Errors
    /// If a required key is missing, or a value has the wrong type or is out of range; place and remedy are stated.
    pub fn read<T: ValueType, P: Presence>(&self, key: &Key<T, P>) -> Result<P::Output<T::Value<'a>>> {
        self.stated(key)?.map_or_else(|| P::absent::<T>(self, &key.row), |value| Ok(P::present(value)))
    }

    /// The value of a key where it is required, whatever the key declares.
    ///
    /// # Errors
    /// If it is missing, and those of [`read`](Self::read).
    pub fn need<T: ValueType, P>(&self, key: &Key<T, P>) -> Result<T::Value<'a>> {
        self.stated(key)?.ok_or_else(|| self.missing(&key.row))
    }

    /// The value of a key if the table has it, whatever the key declares.
    ///
    /// # Errors
    /// Those of [`read`](Self::read), but for missing keys.
    pub fn stated<T: ValueType, P>(&self, key: &Key<T, P>) -> Result<Option<T::Value<'a>>> {
        let value = self.table.get(key.row.name).map(|property| ValueRef::Given(&property.value));
        value.map(|value| T::read(&Entry { section: self, key: &key.row, value })).transpose()
    }

    /// Checks names and relations of the keys: unknown ones, groups of which exactly one is required, keys without effect.
    ///
    /// # Errors
    /// If a check fails; the place, and for unknown keys the nearest known one, are stated.
    pub fn check(&self, rows: &[KeyRow]) -> Result<()> {
        self.check_rows(&[], rows.iter())
    }

    /// As [`check`](Self::check), for the keys of a kind.
    ///
    /// # Errors
    /// Those of [`check`](Self::check).
    pub fn check_kind(&self, rows: &[KeyRow]) -> Result<()> {
        self.check_rows(&[KIND.name], rows.iter())
    }

    /// As [`check`](Self::check), for keys of several rows and some names more.
    pub(super) fn check_rows<'r>(&self, more: &[&'r str], rows: impl Iterator<Item = &'r KeyRow> + Clone) -> Result<()> {
        let known = || more.iter().copied().chain(rows.clone().map(|row| row.name));
        if let Some((key, _)) = self.table.iter().find(|(key, _)| !known().any(|name| name == *key)) {
            let hint = nearest(key, known()).map(|near| format!(", did you mean \"{near}\"?")).unwrap_or_default();
            let known = known().collect::<Vec<_>>().join(", ");
            return Err(self.error(key, format!("unknown key \"{key}\"{hint}; known: {known}")));
        }
        rows.clone().try_for_each(|row| self.check_relation(row, rows.clone()))
    }

    fn check_relation<'r>(&self, row: &KeyRow, rows: impl Iterator<Item = &'r KeyRow>) -> Result<()> {
        let ignored =
            |partner: &str| Err(self.error(row, format!("\"{}\" requires {partner} and would be ignored here; remove it", row.name)));
        match row.relation {
            Relation::Needs(partner) | Relation::RequiredWith(partner) if self.has(row) && !self.has(partner) => ignored(partner),
            Relation::Excludes(other) if self.has(row) && self.has(other) => {
                Err(self.error(row, format!("{} and {other} exclude each other; remove one", row.name)))
            }
            Relation::RequiredWith(partner) if self.has(partner) && !self.has(row) => Err(self.missing(row)),
            Relation::OneOf(group) => {
                let members: Vec<&KeyRow> = rows.filter(|other| other.relation == row.relation).collect();
                let given: Vec<&&KeyRow> = members.iter().filter(|member| self.has(**member)).collect();
                if given.len() == 1 {
                    return Ok(());
                }
                let names = members.iter().map(|member| member.name).collect::<Vec<_>>().join(", ");
                let first = given.first().map_or(row, |member| **member);
                Err(self.error(first, format!("exactly one {group} is required, of {names}; found {}", given.len())))
            }
            _ => Ok(()),
        }
    }

    /// Refuses `keys` without effect here, since they go with `partner`.
    ///
    /// # Errors
    /// If one of them is there; its place is stated.
    pub fn refuse(&self, keys: &[&KeyRow], partner: &str) -> Result<()> {
        let Some(key) = keys.iter().find(|key| self.has(**key)) else { return Ok(()) };
        Err(self.error(*key, format!("\"{}\" requires {partner} and would be ignored here; remove it", key.name)))
    }

    /// The error `message` about `key`.
    pub fn error(&self, key: &(impl Named + ?Sized), message: impl Into<String>) -> Error {
        let key = key.name();
        let origin = self.table.get(key).and_then(|p| p.origin.as_ref()).or(self.table.origin()).cloned();
        Error::Scene { message: message.into(), place: Place { origin, path: self.path.clone(), key: key.to_owned() } }
    }

    /// Adds this key's place to an error from elsewhere.
    ///
    /// # Errors
    /// That of `result`, with the place of `key` where it has none.
    pub fn wrap<T, E: Into<Error>>(&self, key: &(impl Named + ?Sized), result: std::result::Result<T, E>) -> Result<T> {
        result.map_err(|e| match e.into() {
            placed @ (Error::Scene { .. } | Error::Memory { .. } | Error::Interrupted) => placed,
            other => self.error(key, other.to_string()),
        })
    }

    /// The error that a key is required.
    pub(super) fn missing(&self, key: &KeyRow) -> Error {
        self.error(key, format!("key \"{0}\" is required; write it like {0} = {1}", key.name, key.example_words()))
    }

    /// The kind of the table, if stated.
    pub fn kind(&self) -> Option<&'a str> {
        match self.table.get(KIND.name).map(|property| &property.value) {
            Some(Value::Text(kind)) => Some(kind),
            _ => None,
        }
    }

    /// A box between two corners.
    ///
    /// # Errors
    /// If a corner is missing or wrong, or the box is empty.
    pub fn bounds<P>(&self, low: &Key<Position, P>, high: &Key<Position, P>) -> Result<Bounds> {
        let bounds = Bounds { low: self.need(low)?, high: self.need(high)? };
        if !bounds.low.cmplt(bounds.high).all() {
            return Err(self.error(high, format!("{} must exceed {} along every axis", high.row.name, low.row.name)));
        }
        Ok(bounds)
    }

    /// The table called `key`, if any.
    ///
    /// # Errors
    /// If the value is not a table.
    pub fn table(&self, key: &'static str) -> Result<Option<Section<'a>>> {
        self.read(&Key::<SubTable>::new(key, ""))
    }

    /// The tables of the list `key`.
    ///
    /// # Errors
    /// If the value is not a list of tables.
    pub fn tables(&self, key: &'static str) -> Result<Vec<Section<'a>>> {
        Ok(self.read(&Key::<Tables>::new(key, ""))?.unwrap_or_default())
    }

    /// The named tables under `key`, as in `[field.dust]`.
    ///
    /// # Errors
    /// If one of the values is not a table.
    pub fn named_tables(&self, key: &'static str) -> Result<Vec<(&'a str, Section<'a>)>> {
        Ok(self.read(&Key::<NamedTables>::new(key, ""))?.unwrap_or_default())
    }

    pub(super) fn child(&self, key: String, table: &'a Table) -> Section<'a> {
        let path = if self.path.is_empty() { key } else { format!("{}.{key}", self.path) };
        Section::new(table, path)
    }
}
