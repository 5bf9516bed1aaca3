//! Curves over wavelength as users' files hold them: filters, spectra, albedos, mean cosines.
//!
//! The policy of every reader holds here: a unit that is stated is understood or refused, one that is missing must be
//! unambiguous or is rejected, and a note states what was inferred ([`SpectralCurve::note`]).
//!
//! Air wavelengths (a column that says "air") become vacuum wavelengths by [`crate::air`].

mod axis_unit;
mod cell;
mod columns;
mod header;
mod ordinate;

pub use axis_unit::{AxisQuantity, AxisUnit};
pub use columns::{Column, Columns};
pub use ordinate::{Ordinate, unit_symbols};

use crate::error::{Result, SpectraError};
use crate::table::Table;
use cell::base_name;
use header::{WavelengthAxis, word};

/// Wavelengths of real filters and spectra \[µm\]: the Lyman limit to the far end of JWST's instruments.
const PLAUSIBLE_UM: [f64; 2] = [0.09, 30.0];
/// Wavelengths of any light that a file may state \[µm\]: hard X-rays to metre waves.
const POSSIBLE_UM: [f64; 2] = [1e-5, 1e7];
/// The units that files without one are in.
const USUAL_UNITS: [&str; 3] = ["angstrom", "nm", "um"];

/// Reading options of a curve in columns.
#[derive(Debug, Clone, Copy)]
pub struct CurveOptions<'a> {
    /// The quantity of the second column.
    pub ordinate: Ordinate,
    /// The unit of the spectral axis, where the user states it.
    pub unit: Option<&'a str>,
    /// The name or the number, from one, of the column to read, where the user states it.
    pub column: Option<&'a str>,
}

impl CurveOptions<'_> {
    /// Unit and column as the file states them.
    pub fn of_file(ordinate: Ordinate) -> Self {
        Self { ordinate, unit: None, column: None }
    }
}

/// A curve over wavelength, and how its file was understood.
#[derive(Debug, Clone)]
pub struct SpectralCurve {
    /// The curve over vacuum wavelength \[µm\].
    pub table: Table,
    /// The unit of the file's spectral axis.
    pub unit: AxisUnit,
    /// True if the unit was inferred from the range of the numbers.
    pub is_inferred: bool,
    /// Interpretation of the file, in one line.
    pub note: String,
    /// True if the detector counts photons, where the file says so.
    pub counts_photons: Option<bool>,
}

impl SpectralCurve {
    /// Reads a curve from text; `name` is the file's name in messages.
    ///
    /// # Errors
    /// If the text holds no such columns, or a unit is unknown, missing or ambiguous.
    pub fn parse(name: &str, text: &str, options: CurveOptions) -> Result<Self> {
        Self::from_columns(name, &Columns::parse(name, text)?, options)
    }

    /// Makes a curve of columns; `name` is the file's name in messages.
    ///
    /// # Errors
    /// If the columns are no such curve, or a unit is unknown, missing or ambiguous.
    pub fn from_columns(name: &str, columns: &Columns, options: CurveOptions) -> Result<Self> {
        let refuse = |reason: String| SpectraError::table(name, reason);
        let axis = WavelengthAxis::of(name, columns)?;
        let (unit, origin) = unit(name, columns, &axis, options.unit)?;
        let ordinate = ordinate_column(name, columns, &axis, options)?;
        let head = columns.columns.get(ordinate).cloned().unwrap_or_default();
        let scale = options.ordinate.scale(&head).map_err(|reason| refuse(format!("column {}: {reason}", shown(&head, ordinate))))?;
        let mut samples = Vec::with_capacity(columns.rows.len());
        for (line, row) in &columns.rows {
            let (number, value) = (row[axis.column], row[ordinate]);
            let lambda_um = unit.wavelength_um(number);
            if !(lambda_um.is_finite() && lambda_um > 0.0 && number > 0.0) {
                return Err(refuse(format!("line {line}: {number} {} is out of range; a wavelength must be above zero", unit.name)));
            }
            if !value.is_finite() {
                return Err(refuse(format!("line {line}: column {} has {value}; it must be finite", shown(&head, ordinate))));
            }
            let lambda_um = if axis.is_air { crate::air::vacuum_um(lambda_um) } else { lambda_um };
            samples.push((*line, lambda_um, value * scale.factor(lambda_um)));
        }
        if samples.len() > 1 && samples[0].1 > samples[samples.len() - 1].1 {
            samples.reverse();
        }
        if let Some(pair) = samples.windows(2).find(|pair| pair[1].1 <= pair[0].1) {
            let (line, order) = (pair[0].0.max(pair[1].0), if pair[0].1 == pair[1].1 { "repeats a wavelength" } else { "is out of order" });
            return Err(refuse(format!("line {line} {order}; wavelengths must strictly ascend or descend")));
        }
        let (x, y) = samples.iter().map(|(_, lambda_um, value)| (*lambda_um, *value)).unzip();
        let table = Table::new(name, x, y)?;
        let (low, high) = table.range();
        if low < POSSIBLE_UM[0] || high > POSSIBLE_UM[1] {
            let quantity = word(unit.quantity());
            return Err(refuse(format!(
                "its {quantity} in {} corresponds to wavelengths of {low:.3e} to {high:.3e} um; correct the unit",
                unit.name
            )));
        }
        let air = if axis.is_air { " in air, converted to vacuum" } else { "" };
        let note = format!(
            "{} rows {}; {} in {}{air} ({origin}), {:.2} to {:.2} nm; column {}{}",
            columns.rows.len(),
            columns.dialect,
            word(unit.quantity()),
            unit.name,
            low * 1e3,
            high * 1e3,
            shown(&head, ordinate),
            scale.words(),
        );
        Ok(Self { table, is_inferred: origin == UnitOrigin::Range, unit, note, counts_photons: columns.counts_photons })
    }
}

/// The source of the unit of a spectral axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum UnitOrigin {
    Key,
    File,
    Range,
}

impl std::fmt::Display for UnitOrigin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            UnitOrigin::Key => "by the key unit",
            UnitOrigin::File => "stated in the file",
            UnitOrigin::Range => "inferred: the file has no unit, and only this one puts all rows between 90 nm and 30 um",
        })
    }
}

/// The unit of the spectral axis: the key's, the file's, or the only one that its numbers allow.
fn unit(name: &str, columns: &Columns, axis: &WavelengthAxis, key: Option<&str>) -> Result<(AxisUnit, UnitOrigin)> {
    let refuse = |reason: String| SpectraError::table(name, reason);
    const REMEDY: &str = "add unit = \"angstrom\", \"nm\" or \"um\" to the scene";
    if let Some(key) = key {
        let wanted = AxisUnit::parse(key).ok_or_else(|| {
            refuse(format!("unit = \"{key}\" is not a unit of wavelength, wavenumber, frequency or photon energy; {REMEDY}"))
        })?;
        return match &axis.unit {
            Some(unit_here) if !unit_here.is(&wanted) => {
                Err(refuse(format!("the file has {}, the key unit {}; correct one of them", unit_here.name, wanted.name)))
            }
            _ => Ok((wanted, UnitOrigin::Key)),
        };
    }
    if let Some(unit_here) = &axis.unit {
        return Ok((unit_here.clone(), UnitOrigin::File));
    }
    let numbers = || columns.rows.iter().map(|(_, row)| row[axis.column]);
    let (low, high) = numbers().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let plausible = |unit: &AxisUnit| numbers().all(|v| (PLAUSIBLE_UM[0]..=PLAUSIBLE_UM[1]).contains(&unit.wavelength_um(v)));
    let fitting: Vec<AxisUnit> = USUAL_UNITS.iter().filter_map(|unit| AxisUnit::parse(unit)).filter(plausible).collect();
    let [only] = &fitting[..] else {
        let which = match fitting.len() {
            0 => "which is an optical wavelength in none".to_owned(),
            _ => format!("which may be {}", fitting.iter().map(|unit| unit.name.as_str()).collect::<Vec<_>>().join(" or ")),
        };
        return Err(refuse(format!("has no unit of wavelength, and its first column ranges from {low} to {high}, {which}; {REMEDY}")));
    };
    if let Some((line, other)) = axis.contradiction(columns, only) {
        return Err(refuse(format!(
            "has no unit of wavelength at a column; its numbers look like {}, but the comment in line {line} mentions {}; {REMEDY}",
            only.name, other.name
        )));
    }
    Ok((only.clone(), UnitOrigin::Range))
}

/// The number of the column that holds the curve.
fn ordinate_column(name: &str, columns: &Columns, axis: &WavelengthAxis, options: CurveOptions) -> Result<usize> {
    let refuse = |reason: String| SpectraError::table(name, reason);
    let heads = &columns.columns;
    let listed = || (0..heads.len()).filter(|i| *i != axis.column).map(|i| shown(&heads[i], i)).collect::<Vec<_>>().join(", ");
    if let Some(wanted) = options.column {
        let by_name = heads.iter().position(|head| base_name(&head.name).eq_ignore_ascii_case(wanted.trim()) || head.name == wanted);
        let by_number = wanted.trim().parse::<usize>().ok().and_then(|number| number.checked_sub(1)).filter(|i| *i < heads.len());
        let found = by_name.or(by_number).filter(|i| *i != axis.column);
        return found.ok_or_else(|| refuse(format!("has no column \"{wanted}\" of values; it has {}", listed())));
    }
    let others: Vec<usize> = (0..heads.len()).filter(|i| *i != axis.column).collect();
    if let [only] = others[..] {
        return Ok(only);
    }
    let named: Vec<usize> = others.iter().copied().filter(|i| options.ordinate.is_named(&base_name(&heads[*i].name))).collect();
    match named[..] {
        [only] => Ok(only),
        _ => {
            let line = columns.rows.first().map_or(1, |(line, _)| *line);
            Err(refuse(format!(
                "line {line}: rows have {} numbers, a {} curve needs two; select a column with column = \"NAME\" or column = \"2\" out of {}",
                heads.len(),
                options.ordinate.name(),
                listed()
            )))
        }
    }
}

/// The name of a column in messages: its own, or its number from one.
fn shown(head: &Column, index: usize) -> String {
    if head.name.is_empty() { format!("{}", index + 1) } else { format!("\"{}\"", head.name) }
}

#[cfg(test)]
mod tests;
