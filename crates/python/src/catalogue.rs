//! Rows: what scenes may hold, and the names that they choose from.

use barnard::properties::Key;
use barnard::scene::schema::TABLES;
use barnard_cli::backends::registry;
use barnard_files::builtin;
use barnard_files::catalogue::{CATALOGUES, Catalogue};
use pyo3::prelude::*;

use crate::error::raised;

/// A key: name, what its value is, default or none where it is required, what it means.
type KeyRow = (&'static str, &'static str, Option<&'static str>, &'static str);

fn keys(keys: &'static [Key]) -> Vec<KeyRow> {
    keys.iter().map(|key| (key.name, key.kind, key.default, key.summary)).collect()
}

/// A kind of a table: name, what it is, its keys.
type KindRow = (&'static str, &'static str, Vec<KeyRow>);

/// A table of a scene: path, what it is, keys whatever the kind, kinds.
type TableRow = (&'static str, &'static str, Vec<KeyRow>, Vec<KindRow>);

/// All tables of a scene.
#[pyfunction]
pub fn schema() -> Vec<TableRow> {
    let kinds = |table: &barnard::scene::schema::TableRow| {
        (table.kinds)().into_iter().map(|kind| (kind.name, kind.summary, keys(kind.keys))).collect()
    };
    TABLES.iter().map(|table| (table.path, table.text, keys(table.keys), kinds(table))).collect()
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
    Ok((Catalogue::named(name).map_err(|error| raised(py, error))?.rows)())
}

/// The text of a built-in scene.
#[pyfunction]
pub fn builtin_text(py: Python, name: &str) -> PyResult<&'static str> {
    Ok(builtin::entry(name).map_err(|error| raised(py, error))?.text)
}
