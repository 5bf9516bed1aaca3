//! Tables that are compiled in: their text, and the provenance without which they do not load, in `# key: value` lines.

use crate::curve::Columns;
use crate::error::{Result, SpectraError};

/// Rows of at least `columns` numbers out of text, as [`Columns::parse`] reads it; errors name `name` and the line.
///
/// # Errors
/// If the text holds no such rows.
pub fn rows(name: &str, text: &str, columns: usize) -> Result<Vec<Vec<f64>>> {
    let rows = Columns::parse(name, text)?.rows;
    match rows.iter().find(|(_, row)| row.len() < columns) {
        Some((line, row)) => Err(SpectraError::table(name, format!("line {line} has {} numbers, expected {columns}", row.len()))),
        None => Ok(rows.into_iter().map(|(_, row)| row).collect()),
    }
}

/// The provenance that every embedded data file must state.
pub const PROVENANCE: [&str; 5] = ["source", "reference", "licence", "date", "columns"];

/// Checks that an embedded file states where it comes from; gives the body back.
///
/// # Errors
/// If source, reference, licence, date or columns are missing.
pub fn with_provenance<'a>(name: &str, text: &'a str) -> Result<&'a str> {
    for key in PROVENANCE {
        let start = format!("# {key}: ");
        if !text.lines().any(|l| l.strip_prefix(&start).is_some_and(|v| !v.trim().is_empty())) {
            return Err(SpectraError::table(name, format!("has no \"# {key}:\" line")));
        }
    }
    Ok(text)
}

/// Columns of an embedded file, after the check of its provenance.
///
/// # Errors
/// If its provenance is missing or a row is broken.
pub fn embedded_columns(name: &str, text: &str, columns: usize) -> Result<Vec<Vec<f64>>> {
    let rows = rows(name, with_provenance(name, text)?, columns)?;
    Ok((0..columns).map(|c| rows.iter().map(|r| r[c]).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn broken_tables_are_refused() {
        assert!(rows("t", "1,2\n", 3).unwrap_err().to_string().contains("line 1"));
        assert!(with_provenance("t", "# source: somewhere\n1,2\n").is_err());
    }
}
