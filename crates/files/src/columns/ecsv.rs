//! ECSV, the text format of astropy: columns as in any text, with names and units in a header of comments.
//!
//! Source: Astropy Proposal for Enhancement 6 (APE6).

use spectra::Result;
use spectra::curve::Columns;

/// The beginning of every ECSV file.
pub const MAGIC: &str = "# %ECSV";

/// Reads columns and the units that the header states for them.
///
/// # Errors
/// If the rows are no columns of numbers.
pub fn parse(name: &str, text: &str) -> Result<Columns> {
    let mut columns = Columns::parse(name, text)?;
    for (field, unit) in units(text) {
        if let Some(column) = columns.columns.iter_mut().find(|column| column.name == field) {
            column.unit = Some(unit);
        }
    }
    // The header names columns by itself: none of its lines is one of them.
    columns.comments.clear();
    Ok(columns)
}

/// Names and units of the entries under "datatype:", each in one line or in several.
pub fn units(text: &str) -> Vec<(String, String)> {
    let mut entries: Vec<Vec<(String, String)>> = Vec::new();
    for line in text.lines().map_while(|line| line.strip_prefix('#')) {
        let line = line.trim();
        let is_new = line.starts_with("- ");
        let inner = line.trim_start_matches("- ").trim_start_matches('{').trim_end_matches('}');
        let pairs = inner.split(", ").filter_map(|pair| pair.split_once(": "));
        let unquoted = |text: &str| text.trim().trim_matches(['\'', '"']).to_owned();
        let pairs: Vec<(String, String)> = pairs.map(|(key, value)| (unquoted(key), unquoted(value))).collect();
        match entries.last_mut().filter(|_| !is_new) {
            Some(last) => last.extend(pairs),
            None => entries.push(pairs),
        }
    }
    let value = |entry: &[(String, String)], key: &str| entry.iter().find(|(known, _)| known == key).map(|(_, value)| value.clone());
    entries.iter().filter_map(|entry| Some((value(entry, "name")?, value(entry, "unit")?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_in_both_styles() {
        let flow = "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: wave, unit: Angstrom, datatype: float64}\n# - {name: t, datatype: float64}\n# schema: astropy-2.0\nwave t\n5000 0.5\n6000 0.8\n";
        let block = "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n# - name: wave\n#   unit: um\n#   datatype: float64\n# - name: t\n#   datatype: float64\nwave,t\n0.5,0.5\n0.6,0.8\n";
        for (text, unit, first) in [(flow, "Angstrom", 5000.0), (block, "um", 0.5)] {
            let columns = parse("t.ecsv", text).unwrap();
            assert_eq!((columns.columns[0].unit.as_deref(), columns.columns[1].unit.as_deref()), (Some(unit), None));
            assert_eq!((columns.rows.len(), columns.rows[0].1[0]), (2, first));
        }
    }
}
