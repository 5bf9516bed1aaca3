//! Sampled functions of one variable, and the CSV text they are read from.
//!
//! Embedded data carry their provenance in `# key: value` lines and do not load without it.

use crate::error::{Result, SpectraError};

/// A piecewise linear function given by samples with ascending abscissae.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    x: Vec<f64>,
    y: Vec<f64>,
}

/// The most samples a user's table may have: far past any real curve, small enough to hold.
pub const MAX_SAMPLES: usize = 1_000_000;

impl Table {
    /// A table of samples; `x` must be strictly ascending, all finite, at least two.
    ///
    /// # Errors
    /// Where they are not, or the columns have different lengths.
    pub fn new(name: &str, x: Vec<f64>, y: Vec<f64>) -> Result<Self> {
        if x.len() < 2 || x.len() != y.len() {
            return Err(SpectraError::table(name, format!("needs at least two rows of two numbers, has {}", x.len())));
        }
        if let Some(i) = (0..x.len()).find(|&i| !x[i].is_finite() || !y[i].is_finite()) {
            return Err(SpectraError::table(name, format!("row {} is not finite: {}, {}", i + 1, x[i], y[i])));
        }
        if let Some(i) = (1..x.len()).find(|&i| x[i] <= x[i - 1]) {
            return Err(SpectraError::table(name, format!("abscissae must ascend, row {} has {} after {}", i + 1, x[i], x[i - 1])));
        }
        Ok(Self { x, y })
    }

    /// The value at `x`, linear between samples; the border values outside.
    pub fn at(&self, x: f64) -> f64 {
        let i = self.x.partition_point(|&v| v <= x);
        if i == 0 {
            return self.y[0];
        }
        if i == self.x.len() {
            return self.y[i - 1];
        }
        let t = (x - self.x[i - 1]) / (self.x[i] - self.x[i - 1]);
        self.y[i - 1] + t * (self.y[i] - self.y[i - 1])
    }

    /// The value at `x`, zero outside of the samples.
    pub fn at_or_zero(&self, x: f64) -> f64 {
        let (low, high) = self.range();
        if x < low || x > high { 0.0 } else { self.at(x) }
    }

    /// The first and the last abscissa.
    pub fn range(&self) -> (f64, f64) {
        (self.x[0], self.x[self.x.len() - 1])
    }

    /// The abscissae.
    pub fn x(&self) -> &[f64] {
        &self.x
    }

    /// The ordinates.
    pub fn y(&self) -> &[f64] {
        &self.y
    }

    /// The same function with both axes scaled.
    pub fn scaled(&self, x_factor: f64, y_factor: f64) -> Self {
        Self { x: self.x.iter().map(|v| v * x_factor).collect(), y: self.y.iter().map(|v| v * y_factor).collect() }
    }
}

/// Rows of numbers out of CSV text: `#` lines and one line of column names are skipped.
///
/// `columns` is the least number of columns; errors name `name` and the line.
///
/// # Errors
/// Where a line holds something else, with its number.
pub fn rows(name: &str, text: &str, columns: usize) -> Result<Vec<Vec<f64>>> {
    let mut rows = Vec::new();
    let mut header_seen = false;
    let mut width = None;
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let cells: Vec<&str> = line.split([',', ';', '\t']).flat_map(|c| c.split_whitespace()).collect();
        let values: std::result::Result<Vec<f64>, _> = cells.iter().map(|c| c.parse::<f64>()).collect();
        match values {
            Ok(values) if values.len() >= columns => {
                let expected = *width.get_or_insert(values.len());
                if values.len() > expected {
                    let reason = format!(
                        "line {} has {} numbers, those before it {expected}; numbers have a decimal point",
                        number + 1,
                        values.len()
                    );
                    return Err(SpectraError::table(name, reason));
                }
                rows.push(values);
            }
            Ok(values) => {
                let reason = format!("line {} has {} numbers, {columns} are needed", number + 1, values.len());
                return Err(SpectraError::table(name, reason));
            }
            Err(_) if rows.is_empty() && !header_seen => {
                header_seen = true;
                width = Some(line.split([',', ';', '\t']).count()).filter(|n| *n > 1);
            }
            Err(_) => {
                return Err(SpectraError::table(name, format!("line {} is not a row of numbers: \"{}\"", number + 1, clipped(line))));
            }
        }
        if rows.len() > MAX_SAMPLES {
            return Err(SpectraError::table(name, format!("has more than {MAX_SAMPLES} rows")));
        }
    }
    if rows.is_empty() {
        return Err(SpectraError::table(name, format!("holds no rows of {columns} numbers")));
    }
    Ok(rows)
}

fn clipped(line: &str) -> String {
    line.chars().take(60).collect()
}

/// A two-column CSV whose abscissa is a wavelength; the header may name its unit (`nm`, `um`, `angstrom`), nm
/// otherwise.
///
/// Returns a table over wavelength \[µm\].
///
/// # Errors
/// Where the text is no such table, or its unit is not known.
pub fn spectrum_from_csv(name: &str, text: &str) -> Result<Table> {
    let rows = rows(name, text, 2)?;
    let to_um = wavelength_unit(name, text)?;
    let (x, y) = rows.iter().map(|r| (r[0] * to_um, r[1])).unzip();
    Table::new(name, x, y)
}

/// Units of wavelength as headers write them, in µm.
const HEADER_UNITS: [(&str, f64); 14] = [
    ("nm", 1e-3),
    ("nanometer", 1e-3),
    ("nanometers", 1e-3),
    ("nanometre", 1e-3),
    ("um", 1.0),
    ("µm", 1.0),
    ("μm", 1.0),
    ("micron", 1.0),
    ("microns", 1.0),
    ("micrometer", 1.0),
    ("angstrom", 1e-4),
    ("angstroms", 1e-4),
    ("å", 1e-4),
    ("aa", 1e-4),
];

/// The size in µm of the unit that the header names beside the wavelength; nm where it names none.
fn wavelength_unit(name: &str, text: &str) -> Result<f64> {
    let header = text.lines().map(str::trim).take_while(|l| l.is_empty() || l.starts_with('#') || l.parse_first().is_none());
    let header = header.collect::<Vec<_>>().join(" ").to_lowercase();
    let words: Vec<&str> = header.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).collect();
    if let Some((_, size)) = words.iter().find_map(|w| HEADER_UNITS.iter().find(|u| u.0 == *w)) {
        return Ok(*size);
    }
    let refuse = |what: String| Err(SpectraError::table(name, format!("{what}; the first column is a wavelength in nm, um or angstrom")));
    if let Some(word) = words.iter().find(|w| ["hz", "ghz", "thz", "ev", "kev", "frequency", "wavenumber", "energy"].contains(w)) {
        return refuse(format!("the header speaks of \"{word}\""));
    }
    // "wavelength_furlong", "lambda [furlong]": a word that is tied to the wavelength is meant as its unit.
    let tied = ["wavelength_", "wavelength [", "wavelength (", "wavelength[", "wavelength(", "lambda_", "lambda [", "lambda ("];
    if let Some(rest) = tied.iter().find_map(|t| header.split_once(t).map(|(_, rest)| rest)) {
        let unit: String = rest.chars().take_while(|c| c.is_alphanumeric()).collect();
        return refuse(format!("unknown unit of wavelength \"{unit}\" in the header"));
    }
    Ok(1e-3)
}

trait ParseFirst {
    fn parse_first(&self) -> Option<f64>;
}

impl ParseFirst for str {
    fn parse_first(&self) -> Option<f64> {
        self.split([',', ';', '\t', ' ']).next()?.trim().parse().ok()
    }
}

/// The provenance that every embedded data file must state.
pub const PROVENANCE: [&str; 5] = ["source", "reference", "licence", "date", "columns"];

/// Checks that an embedded file states where it comes from; gives the body back.
///
/// # Errors
/// Where source, reference, licence, date or columns are missing.
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
/// Where its provenance is missing or a row is broken.
pub fn embedded_columns(name: &str, text: &str, columns: usize) -> Result<Vec<Vec<f64>>> {
    let rows = rows(name, with_provenance(name, text)?, columns)?;
    Ok((0..columns).map(|c| rows.iter().map(|r| r[c]).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolates_and_clamps() {
        let table = Table::new("t", vec![1.0, 2.0, 4.0], vec![0.0, 10.0, 20.0]).unwrap();
        assert_eq!(table.at(1.5), 5.0);
        assert_eq!(table.at(3.0), 15.0);
        assert_eq!(table.at(9.0), 20.0);
        assert_eq!(table.at_or_zero(9.0), 0.0);
    }

    #[test]
    fn bad_tables_are_refused() {
        assert!(Table::new("t", vec![1.0], vec![1.0]).is_err());
        assert!(Table::new("t", vec![1.0, 1.0], vec![1.0, 1.0]).is_err());
        assert!(Table::new("t", vec![1.0, f64::NAN], vec![1.0, 1.0]).is_err());
        assert!(rows("t", "a,b\n1,2\nx,y\n", 2).unwrap_err().to_string().contains("line 3"));
        assert!(rows("t", "1\n", 2).is_err());
        assert!(rows("t", "", 2).is_err());
        assert!(with_provenance("t", "# source: somewhere\n1,2\n").is_err());
    }

    #[test]
    fn the_header_names_the_unit() {
        for (text, expected) in [
            ("wavelength_nm,t\n500,1\n600,1\n", 0.5),
            ("# wavelength [um], t\n0.5,1\n0.6,1\n", 0.5),
            ("wavelength (angstrom),t\n5000,1\n6000,1\n", 0.5),
            ("500,1\n600,1\n", 0.5),
        ] {
            assert!((spectrum_from_csv("t", text).unwrap().range().0 - expected).abs() < 1e-12, "{text}");
        }
        assert!((spectrum_from_csv("t", "Wavelength (Å),T\n5000,1\n6000,1\n").unwrap().range().0 - 0.5).abs() < 1e-12);
        assert!((spectrum_from_csv("t", "lambda [μm],T\n0.5,1\n0.6,1\n").unwrap().range().0 - 0.5).abs() < 1e-12);
        for text in ["wavelength_furlong,t\n5,1\n6,1\n", "frequency_Hz,t\n5,1\n6,1\n", "a,b\n500,5;0,5\n600,5;0,6\n"] {
            assert!(spectrum_from_csv("t", text).is_err(), "{text}");
        }
    }
}
