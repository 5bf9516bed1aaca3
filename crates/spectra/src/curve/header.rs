//! Units that headers and comments state for a spectral axis.

use super::axis_unit::{AxisQuantity, AxisUnit};
use super::cell::Cell;
use super::columns::Columns;
use crate::error::{Result, SpectraError};

/// The spectral axis of columns.
#[derive(Debug)]
pub struct WavelengthAxis {
    /// The number of its column.
    pub column: usize,
    /// Its unit, where the file states one.
    pub unit: Option<AxisUnit>,
    /// True if its wavelengths are stated to be in air.
    pub is_air: bool,
}

impl WavelengthAxis {
    /// Finds the spectral axis, and the unit that its column, its header or a comment states.
    pub fn of(name: &str, columns: &Columns) -> Result<Self> {
        let refuse = |reason: String| SpectraError::table(name, reason);
        let unknown = |unit: &str| {
            refuse(format!(
                "unknown unit \"{unit}\" of the spectral axis; known are angstrom, nm, um, mm, m, cm-1, um-1, Hz, GHz, THz, eV and keV in their usual spellings"
            ))
        };
        let named = columns.columns.iter().position(|column| Cell::of(&column.name).quantity.is_some());
        let column = named.unwrap_or(0);
        let head = &columns.columns[column];
        let mut cells = vec![Cell::of(&head.name)];
        cells.extend(comment_cells(columns, column));
        let is_air = cells.iter().any(|cell| cell.is_air);
        let quantity = cells.iter().find_map(|cell| cell.quantity);
        let mut unit = head
            .unit
            .as_deref()
            .filter(|unit| !unit.trim().is_empty())
            .map(|unit| AxisUnit::parse(unit).ok_or_else(|| unknown(unit)))
            .transpose()?;
        for (cell, words) in cells.iter().flat_map(|cell| cell.units.iter().map(move |words| (cell, words))) {
            match (AxisUnit::parse(words), &unit) {
                (Some(unit_here), Some(known)) if !unit_here.is(known) => {
                    return Err(refuse(format!(
                        "has both {} and {} for its spectral axis; correct one of them",
                        known.name, unit_here.name
                    )));
                }
                (Some(unit_here), _) => unit = Some(unit_here),
                (None, _) if cell.is_tied => return Err(unknown(words)),
                _ => {}
            }
        }
        match (quantity, &unit) {
            (Some(stated), Some(unit)) if unit.quantity() != stated => {
                Err(refuse(format!("has a {} in {}; correct the header", word(stated), unit.name)))
            }
            (Some(stated), None) if stated != AxisQuantity::Wavelength => {
                Err(refuse(format!("has a {} without a unit; add one such as \"{} [{}]\"", word(stated), word(stated), example(stated))))
            }
            _ => Ok(Self { column, unit, is_air }),
        }
    }

    /// A comment that mentions another unit of wavelength than the one inferred.
    pub fn contradiction(&self, columns: &Columns, inferred: &AxisUnit) -> Option<(usize, AxisUnit)> {
        let mentioned = |text: &str| {
            let words =
                text.split(|c: char| c.is_whitespace() || ",;:()[]=".contains(c)).filter(|word| word.chars().count() > 1 || *word == "Å");
            words.filter_map(AxisUnit::parse).find(|unit| ["angstrom", "nm", "um"].contains(&unit.name.as_str()))
        };
        let units = columns.comments.iter().filter_map(|(line, text)| Some((*line, mentioned(text)?)));
        units.into_iter().find(|(_, unit)| !unit.is(inferred))
    }
}

/// The name of a quantity in messages.
pub fn word(quantity: AxisQuantity) -> &'static str {
    match quantity {
        AxisQuantity::Wavelength => "wavelength",
        AxisQuantity::Wavenumber => "wavenumber",
        AxisQuantity::Frequency => "frequency",
        AxisQuantity::Energy => "photon energy",
    }
}

fn example(quantity: AxisQuantity) -> &'static str {
    match quantity {
        AxisQuantity::Wavelength => "nm",
        AxisQuantity::Wavenumber => "cm-1",
        AxisQuantity::Frequency => "THz",
        AxisQuantity::Energy => "eV",
    }
}

/// Comments that describe columns: "columns: a, b", "column 1: a", "wavelength unit: nm". Prose never states a unit.
fn comment_cells(columns: &Columns, column: usize) -> Vec<Cell> {
    let mut cells = Vec::new();
    for (_, comment) in &columns.comments {
        let Some((key, value)) = comment.split_once([':', '=']) else { continue };
        let (key, value) = (key.trim().to_lowercase(), value.trim());
        let is_column = [format!("column {}", column + 1), format!("col {}", column + 1), format!("col{}", column + 1)].contains(&key);
        if key == "columns" || key == "column names" {
            let list = value.split(',').nth(column).unwrap_or("");
            cells.push(Cell::of(list));
        } else if is_column {
            cells.push(Cell::of(value));
        } else if [
            "wavelength unit",
            "wavelength_unit",
            "wave unit",
            "waveunit",
            "unit of wavelength",
            "wavelength units",
            "x unit",
            "xunit",
        ]
        .contains(&key.as_str())
        {
            cells.push(Cell { quantity: None, units: vec![value.to_owned()], is_tied: true, is_air: false });
        }
    }
    let last = columns
        .last_comment(columns.columns.len())
        .and_then(|mut words| (column < words.len()).then(|| Cell::of(&words.swap_remove(column))));
    cells.extend(last.filter(|cell| cell.units.iter().any(|unit| AxisUnit::parse(unit).is_some())));
    cells
}
