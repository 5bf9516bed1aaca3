//! The `[[star_table]]` tables: stars of a CSV, one a row.
//!
//! A row says what a `[[star]]` says, its columns being named like the keys: it becomes such a table, in the line of
//! its row, and is read by what reads `[[star]]`. So all kinds (but that of a file) and all scales are there, and
//! errors name file, line and key.

use std::sync::Arc;

use spectra::error::nearest;
use spectra::units::Length;

use super::{Loader, Star, star};
use crate::data::{InputNote, Inputs, TextTable};
use crate::error::{Error, Result};
use crate::properties::{
    Flag, KIND, Key, KeyRow, OrDefault, Origin, Path, Place, Property, Relation, Required, Section, Table, Text, Texts, Type, Value,
    ValueType,
};

const FILE: Key<Path, Required> = Key::path("file", "CSV file with a header and one star per row").required();
const COLUMNS: Key<Texts> = Key::texts("columns", "columns to read in addition to x, y and z").otherwise("all keys of [[star]]");
const VISIBLE: Key<Flag, OrDefault> = Key::flag("visible", "draw the stars themselves").default(true);
const MAGNITUDE_BAND: Key<Text, OrDefault> =
    Key::text("magnitude_band", "embedded passband of a magnitude column").default("johnson-V").of("passbands");
const DISTANCE: Key<Length> =
    Key::quantity::<Length>("distance", "distance of the observer of the magnitudes").positive().required_for("magnitudes");

/// Keys of its own, and those of `[[star]]` that are most often the same for all of its stars; the others may stand
/// here too.
pub(super) const KEYS: &[KeyRow] = &[FILE.row, COLUMNS.row, VISIBLE.row, MAGNITUDE_BAND.row, DISTANCE.row, star::MAGNITUDE_SYSTEM.row];

/// Most stars of a table: of more, frames grow with the stars.
pub const MAX_ROWS: usize = 20_000;

/// The columns that hold a place.
const PLACE: [&str; 3] = ["x", "y", "z"];
/// The unit of a key where neither column nor cell says one.
const UNITS: [(&str, &str); 5] =
    [("temperature", "K"), ("luminosity", "Lsun"), ("radius", "Rsun"), ("magnitude", "mag"), ("distance", "pc")];
/// The unit of places where their columns do not say one.
const PLACE_UNIT: &str = "pc";

/// A column that is read.
struct StarColumn {
    /// The number of the column in a row.
    index: usize,
    name: String,
    unit: Option<String>,
    /// Type of its key's value.
    value: Type,
}

/// The kind of spectrum that no row can have: its `file` would be the table's.
const OF_FILE: &str = "file";

/// The kind of spectrum as a column.
const KIND_KEY: Key<Text> = Key::text(KIND, "kind of the spectrum");

/// All keys that a row may set.
fn keys() -> impl Iterator<Item = &'static KeyRow> {
    let kinds = star::SPECTRA.iter().filter(|kind| kind.name != OF_FILE);
    [&KIND_KEY.row].into_iter().chain(star::KEYS).chain(kinds.flat_map(|kind| kind.keys)).filter(|key| key.name != "position")
}

pub(super) fn build(section: &Section, inputs: &Inputs) -> Result<Vec<Star>> {
    let rows: Vec<KeyRow> =
        [&FILE.row, &COLUMNS.row].into_iter().chain(keys()).map(|row| KeyRow { relation: Relation::Free, ..*row }).collect();
    section.check(&rows)?;
    if section.kind() == Some(OF_FILE) {
        return Err(section.error(KIND, "star tables do not support spectra from files; write such a star as [[star]]"));
    }
    let file = section.read(&FILE)?;
    let table = section.wrap(&FILE, inputs.table(file, MAX_ROWS))?;
    let rows = TableRows { section, file: inputs.label(file).into() };
    let columns = rows.columns(&table)?;
    let constant = rows.constant(&columns);
    let star = |(number, (line, cells)): (usize, &(usize, Vec<String>))| {
        let row = rows.row(cells, &columns, &constant, NumberedRow { number, line: *line })?;
        star::build(&Section::new(&row, format!("{ROWS}.{number}")), inputs)
    };
    let stars = (1..).zip(&table.rows).map(star).collect::<Result<Vec<Star>>>()?;
    inputs.note(columns_note(file, &columns, stars.len()));
    Ok(stars)
}

/// The columns that were read, with their units.
fn columns_note(file: &str, columns: &[StarColumn], count: usize) -> InputNote {
    let unit = |column: &StarColumn| {
        let usual = if PLACE.contains(&column.name.as_str()) {
            Some(PLACE_UNIT)
        } else {
            UNITS.iter().find(|(name, _)| *name == column.name).map(|(_, unit)| *unit)
        };
        match (&column.unit, usual) {
            (Some(unit), _) => format!("{} [{unit}]", column.name),
            (None, Some(usual)) => format!("{} [{usual}, by default]", column.name),
            (None, None) => column.name.clone(),
        }
    };
    let listed: Vec<String> = columns.iter().map(unit).collect();
    InputNote { file: file.to_owned(), text: format!("star table: {count} stars by {}", listed.join(", ")), is_inferred: false }
}

/// Name of a row in messages.
const ROWS: &str = "row";

/// A row's number among all, from 1, and its line.
#[derive(Clone, Copy)]
struct NumberedRow {
    number: usize,
    line: usize,
}

/// The rows of a table, on their way to be tables of properties.
struct TableRows<'a> {
    section: &'a Section<'a>,
    file: Arc<str>,
}

impl TableRows<'_> {
    fn origin(&self, line: usize) -> Option<Origin> {
        Some(Origin { source: self.file.clone(), line })
    }

    fn wrong(&self, line: usize, message: impl Into<String>) -> Error {
        Error::Scene { message: message.into(), place: Place { origin: self.origin(line), path: String::new(), key: ROWS.into() } }
    }

    /// The columns that are keys of a star.
    fn columns(&self, table: &TextTable) -> Result<Vec<StarColumn>> {
        let (head, line) = (&table.columns, table.line);
        let asked = self.section.read(&COLUMNS)?;
        let is_asked = |name: &str| PLACE.contains(&name) || asked.as_ref().is_none_or(|asked| asked.contains(&name));
        let mut columns: Vec<StarColumn> = Vec::new();
        for (index, cell) in head.iter().enumerate() {
            let (name, unit) = TextTable::parted(cell);
            if !is_asked(&name) {
                continue;
            }
            let place = PLACE.contains(&name.as_str()).then_some(<Length as ValueType>::TYPE);
            let Some(value) = place.or_else(|| keys().find(|key| key.name == name).map(|key| key.value)) else {
                let known = PLACE.into_iter().chain(keys().map(|key| key.name));
                // Catalogues have columns that mean nothing here; one that is misspelt does.
                if let Some(near) = nearest(&name, known).filter(|near| name.len() > 3 && near.len().abs_diff(name.len()) <= 1) {
                    return Err(self.wrong(line, format!("unknown column \"{name}\", did you mean \"{near}\"?")));
                }
                continue;
            };
            if columns.iter().any(|column| column.name == name) {
                return Err(self.wrong(line, format!("has two columns \"{name}\"")));
            }
            if self.section.has(name.as_str()) {
                let message = format!("\"{name}\" is also a column of {}; remove one", self.file);
                return Err(self.section.error(name.as_str(), message));
            }
            columns.push(StarColumn { index, name, unit: unit.map(str::to_owned), value });
        }
        let found = |name: &str| columns.iter().find(|column| column.name == name);
        if let Some(missing) = PLACE.into_iter().find(|name| found(name).is_none()) {
            let named: Vec<&str> = head.iter().map(String::as_str).collect();
            return Err(self
                .wrong(line, format!("has no column \"{missing}\" ({}); add x, y and z, with a unit like \"x [pc]\"", named.join(", "))));
        }
        if let Some(missing) = asked.iter().flatten().find(|name| found(name).is_none()) {
            return Err(self.section.error(&COLUMNS, format!("{} has no column \"{missing}\" of a star", self.file)));
        }
        let units: Vec<_> = PLACE.into_iter().filter_map(found).map(|column| &column.unit).collect();
        if units.iter().any(|unit| *unit != units[0]) {
            return Err(self.wrong(line, "has x, y and z in different units; use one"));
        }
        Ok(columns)
    }

    /// The properties that all stars share.
    fn constant(&self, columns: &[StarColumn]) -> Vec<(&'static str, Property)> {
        let properties = self.section.properties();
        let mut constant: Vec<_> = keys().filter_map(|key| Some((key.name, properties.get(key.name)?.clone()))).collect();
        constant.dedup_by_key(|(name, _)| *name);
        if !self.section.has(KIND) && columns.iter().all(|column| column.name != KIND) {
            let kind = if columns.iter().any(|column| column.name == "type") { "stellar" } else { "blackbody" };
            constant.push((KIND, Value::Text(kind.into()).into()));
        }
        constant
    }

    /// The properties of the star in one row.
    fn row(&self, cells: &[String], columns: &[StarColumn], constant: &[(&str, Property)], row: NumberedRow) -> Result<Table> {
        let cell = |column: &StarColumn| cells.get(column.index).map_or("", String::as_str);
        let mut place = Vec::new();
        for column in PLACE.into_iter().filter_map(|name| columns.iter().find(|column| column.name == name)) {
            let number = cell(column).parse::<f64>().ok().filter(|number| number.is_finite());
            let wrong = || {
                let (name, cell) = (&column.name, cell(column));
                self.wrong(row.line, format!("{name} = \"{cell}\" is not a number; write units in the column name, like \"{name} [pc]\""))
            };
            place.push(number.ok_or_else(wrong)?);
        }
        let unit = columns.iter().find(|column| column.name == PLACE[0]).and_then(|x| x.unit.as_deref());
        let same_line = |value| Property { value, origin: self.origin(row.line) };
        let mut table = Table::new(self.origin(row.line));
        table.insert("name", same_line(Value::Text(format!("{}[{}]", self.section.name(), row.number - 1))));
        for (key, property) in constant {
            table.insert(*key, same_line(property.value.clone()));
        }
        table.insert("position", same_line(Value::Quantity(place, unit.unwrap_or(PLACE_UNIT).to_owned())));
        // An empty cell says nothing.
        for column in columns.iter().filter(|column| !PLACE.contains(&column.name.as_str()) && !cell(column).is_empty()) {
            table.insert(column.name.clone(), same_line(column.value(cell(column))));
        }
        Ok(table)
    }
}

impl StarColumn {
    /// A cell as a value of a scene.
    fn value(&self, cell: &str) -> Value {
        match (self.value, cell.parse::<f64>()) {
            (Type::Number, Ok(number)) => Value::Number(number),
            (Type::Flag, _) if cell.eq_ignore_ascii_case("true") => Value::Flag(true),
            (Type::Flag, _) if cell.eq_ignore_ascii_case("false") => Value::Flag(false),
            (Type::Quantity(..), Ok(number)) => {
                let usual = UNITS.iter().find(|(name, _)| *name == self.name).map(|(_, unit)| *unit);
                Value::Quantity(vec![number], self.unit.as_deref().or(usual).unwrap_or("").to_owned())
            }
            _ => Value::Text(cell.to_owned()),
        }
    }
}

/// The stars of a scene: those of its own, then those of its tables.
pub(super) fn stars(root: &Section, loader: &Loader) -> Result<Vec<Star>> {
    let mut stars = root.tables("star")?.iter().map(|s| star::build(s, &loader.inputs)).collect::<Result<Vec<_>>>()?;
    for table in root.tables("star_table")? {
        stars.extend_from_slice(&loader.stars(table.fingerprint(), || build(&table, &loader.inputs))?);
    }
    Ok(stars)
}
