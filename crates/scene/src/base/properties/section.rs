//! Sections: typed access to the keys of a table, with errors that state place, key and remedy.

use spectra::error::nearest;
use spectra::fingerprint::Fingerprint;

use super::key::{KIND, KeyRow, Relation};
use super::{Place, Table, Value};
use crate::error::{Error, Result};

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

    /// Fingerprint of the table's content.
    pub fn fingerprint(&self) -> Fingerprint {
        self.table.fingerprint()
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
    /// As [`check`](Self::check).
    pub fn check_kind(&self, rows: &[KeyRow]) -> Result<()> {
        self.check_rows(&[KIND], rows.iter())
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
        match row.relation {
            Relation::Needs(partner) | Relation::RequiredWith(partner) if self.has(row) && !self.has(partner) => {
                Err(self.ignored(row, partner))
            }
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
        let given = keys.iter().find(|key| self.has(**key));
        given.map_or(Ok(()), |key| Err(self.ignored(key, partner)))
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
    /// The error of `result`, with the place of `key` where it has none.
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

    /// The error that a key has no effect without `partner`.
    fn ignored(&self, key: &KeyRow, partner: &str) -> Error {
        self.error(key, format!("\"{}\" requires {partner} and would be ignored here; remove it", key.name))
    }

    /// The kind of the table, if stated.
    pub fn kind(&self) -> Option<&'a str> {
        match self.table.get(KIND).map(|property| &property.value) {
            Some(Value::Text(kind)) => Some(kind),
            _ => None,
        }
    }

    pub(super) fn child(&self, key: String, table: &'a Table) -> Section<'a> {
        let path = if self.path.is_empty() { key } else { format!("{}.{key}", self.path) };
        Section::new(table, path)
    }
}
