//! Rows: what scenes may hold, and the names that they choose from.

use barnard::properties::{KeyRow, Part, Type};
use barnard::scene::schema::TABLES;
use barnard_cli::backends::registry;
use barnard_files::builtin;
use barnard_files::catalogue::{CATALOGUES, Catalogue};
use pyo3::prelude::*;
use spectra::units::{Length, Quantity};

use crate::error::raised;

/// A key of a table.
#[derive(IntoPyObject)]
pub struct Key {
    name: &'static str,
    summary: &'static str,
    /// Type in words, and with range or choices.
    value: String,
    words: String,
    /// Quantities that the value is one of.
    quantities: Vec<&'static str>,
    /// Texts that the value is one of.
    choices: Vec<&'static str>,
    is_required: bool,
    /// Default, or what determines it, in words.
    default: Option<String>,
    /// Condition under which it is required, in words.
    condition: Option<String>,
    /// Names of the parts of the scene that it changes.
    parts: Vec<String>,
}

fn keys(keys: &'static [KeyRow], parts: &'static [Part]) -> Vec<Key> {
    let key = |key: &KeyRow| Key {
        name: key.name,
        summary: key.summary,
        value: key.value.to_string(),
        words: key.type_words(),
        quantities: match key.value {
            Type::Quantity(_, rows) => rows.iter().map(|row| row.name).collect(),
            Type::Quantities(row) => vec![row.name],
            Type::Position => vec![Length::NAME],
            _ => Vec::new(),
        },
        choices: key.value.choices(),
        is_required: key.is_required(),
        default: key.default_words(),
        condition: key.condition(),
        parts: key.parts.unwrap_or(parts).iter().map(Part::to_string).collect(),
    };
    keys.iter().map(key).collect()
}

/// A kind of a table: name, what it is, its keys.
type KindRow = (&'static str, &'static str, Vec<Key>);

/// A table of a scene: path, what it is, keys whatever the kind, kinds.
type TableRow = (&'static str, &'static str, Vec<Key>, Vec<KindRow>);

/// All tables of a scene.
#[pyfunction]
pub fn schema() -> Vec<TableRow> {
    let kinds = |table: &barnard::scene::schema::TableRow| {
        (table.kinds)().into_iter().map(|kind| (kind.name, kind.summary, keys(kind.keys, table.parts))).collect()
    };
    TABLES.iter().map(|table| (table.path, table.text, keys(table.keys, table.parts), kinds(table))).collect()
}

/// A quantity: name, units with their sizes, an example.
type QuantityRow = (&'static str, Vec<(&'static str, f64)>, &'static str);

/// All quantities.
#[pyfunction]
pub fn quantities() -> Vec<QuantityRow> {
    spectra::units::QUANTITIES.iter().map(|q| (q.name, q.units.to_vec(), q.example)).collect()
}

/// Names of the catalogues, each with what it holds.
#[pyfunction]
pub fn catalogues() -> Vec<(&'static str, &'static str)> {
    CATALOGUES.iter().map(|catalogue| (catalogue.name, catalogue.summary)).collect()
}

/// The rows of a catalogue: name and what it is.
#[pyfunction]
pub fn catalogue(py: Python, name: &str) -> PyResult<Vec<(String, String)>> {
    if name == "backends" {
        return Ok(registry().entries().iter().map(|row| (row.name.to_owned(), row.summary.to_owned())).collect());
    }
    Ok((Catalogue::by_name(name).map_err(|error| raised(py, error))?.rows)())
}

/// The text of a built-in scene.
#[pyfunction]
pub fn builtin_text(py: Python, name: &str) -> PyResult<&'static str> {
    Ok(builtin::entry(name).map_err(|error| raised(py, error))?.text)
}
