//! A phase function from a table.
//!
//! A text of cos θ from −1 to 1, or of θ where the header states degrees or radians, then one column of p for each
//! wavelength; a line `# wavelength_um: 0.44, 0.55` names them (one column needs none). Linear in cos θ and λ; each
//! column is normalised to ∫ p dΩ = 1.

use std::sync::Arc;

use spectra::SpectraError;
use spectra::curve::{AxisQuantity, AxisUnit, Columns};
use spectra::fingerprint::Digest;
use spectra::table::Table;

use super::{Phase, PhaseKind};
use crate::data::{InputNote, Inputs};
use crate::error::{Error, Result};
use crate::properties::{Key, Path, Required, Section};
use crate::random::Counter;

const FILE: Key<Path, Required> = Key::path("file", "the CSV").required();

pub(super) const KIND: PhaseKind = PhaseKind {
    name: "tabulated",
    summary: "from a CSV of cos theta and p for one or more wavelengths",
    keys: &[FILE.row],
    build: |section, inputs, _| Ok(Arc::new(read(section, inputs)?)),
};

/// Reads the phase function of the file that a section names.
pub(crate) fn read(section: &Section, inputs: &Inputs) -> Result<Tabulated> {
    let file = section.read(&FILE)?;
    let columns = section.wrap(&FILE, inputs.columns(file))?;
    let (table, note) = section.wrap(&FILE, parse(file, &columns))?;
    inputs.note(InputNote { file: file.into(), text: format!("phase function: {note}"), is_inferred: false });
    Ok(table)
}

/// A phase function from a table.
#[derive(Debug, Clone)]
pub struct Tabulated {
    lambda_um: Vec<f64>,
    columns: Vec<Table>,
}

/// The quantity of the first column.
#[derive(Clone, Copy, PartialEq)]
enum AngleUnit {
    Cosine,
    Degrees,
    Radians,
}

impl AngleUnit {
    /// The quantity that a header names; cosines where it names none.
    fn of(header: &str, unit: Option<&str>) -> Option<Self> {
        let text = format!("{header} {}", unit.unwrap_or("")).to_lowercase();
        let words: Vec<&str> = text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
        let has = |known: &[&str]| words.iter().any(|word| known.contains(word));
        let is_angle = has(&["theta", "angle", "angles", "θ"]) && !has(&["cos", "cosine", "cosines"]);
        match (has(&["deg", "degree", "degrees"]), has(&["rad", "radian", "radians"])) {
            (true, false) => Some(Self::Degrees),
            (false, true) => Some(Self::Radians),
            (false, false) if !is_angle => Some(Self::Cosine),
            _ => None,
        }
    }

    fn cosine(self, number: f64) -> f64 {
        match self {
            Self::Cosine => number,
            Self::Degrees => number.to_radians().cos(),
            Self::Radians => number.cos(),
        }
    }
}

/// Makes a phase function of columns; also how they were understood, in one line.
fn parse(file: &str, columns: &Columns) -> std::result::Result<(Tabulated, String), Error> {
    let wrong = |reason: String| SpectraError::table(file, reason);
    let head = columns.columns.first().cloned().unwrap_or_default();
    let angle = AngleUnit::of(&head.name, head.unit.as_deref()).ok_or_else(|| {
        wrong(format!("the first column \"{}\" is an angle without a unit; write \"theta [deg]\", or use cosines", head.name))
    })?;
    let mut rows: Vec<&Vec<f64>> = columns.rows.iter().map(|(_, row)| row).collect();
    let ends = |rows: &[&Vec<f64>]| [rows[0][0], rows[rows.len() - 1][0]].map(|number| angle.cosine(number));
    let [first, last] = ends(&rows);
    if first > last {
        rows.reverse();
    }
    let lambda_um = wavelengths_um(columns).map_err(wrong)?;
    let cosines: Vec<f64> = rows.iter().map(|row| angle.cosine(row[0])).collect();
    let values = (1..columns.columns.len()).map(|c| rows.iter().map(|row| row[c]).collect()).collect();
    let words = match angle {
        AngleUnit::Cosine => "cosines",
        AngleUnit::Degrees => "degrees",
        AngleUnit::Radians => "radians",
    };
    let note = format!("{} rows of {words}, wavelengths {lambda_um:?} um", rows.len());
    Ok((Tabulated::new(file, lambda_um, cosines, values)?, note))
}

/// The wavelengths that a comment such as "# wavelength_um: 0.44, 0.55" names; 0.55 µm for a single column without one.
fn wavelengths_um(columns: &Columns) -> std::result::Result<Vec<f64>, String> {
    let named = columns.comments.iter().filter_map(|(line, text)| Some((line, text.split_once(':')?)));
    let mut lists = named.filter(|(_, (key, _))| key.trim().to_lowercase().starts_with("wavelength"));
    let Some((line, (key, list))) = lists.next() else { return Ok(vec![0.55]) };
    let unit = key.trim()["wavelength".len()..].trim_matches(|c: char| c.is_whitespace() || "_[]()".contains(c));
    let unit = AxisUnit::parse(unit).filter(|unit| unit.quantity() == AxisQuantity::Wavelength);
    let unit = unit.ok_or_else(|| format!("line {line} has no known unit of wavelength; write it like \"# wavelength_um: 0.44, 0.55\""))?;
    let number = |text: &str| text.trim().parse::<f64>().map(|number| unit.wavelength_um(number));
    list.split(',').map(|text| number(text).map_err(|_| format!("line {line}: \"{}\" is not a wavelength", text.trim()))).collect()
}

impl Tabulated {
    /// A phase function of these values at ascending `cosines` from −1 to 1, for each of the ascending wavelengths \[µm\] one column, as long as
    /// `cosines`; only their shape counts. `name` stands in messages.
    ///
    /// # Errors
    /// If lengths or ends are others, or values are negative or zero everywhere.
    pub fn new(name: &str, lambda_um: Vec<f64>, cosines: Vec<f64>, values: Vec<Vec<f64>>) -> Result<Self> {
        let ascending = lambda_um.windows(2).all(|w| w[0] < w[1]) && !lambda_um.is_empty() && lambda_um.len() == values.len();
        let near = |end: Option<&f64>, wanted: f64| end.is_some_and(|end| (end - wanted).abs() < 1e-6);
        if !ascending || !near(cosines.first(), -1.0) || !near(cosines.last(), 1.0) {
            let expected = format!("cos theta from -1 to 1 and one column for each of {} ascending wavelengths", lambda_um.len());
            return Err(Error::mismatch("table of a phase function", expected, format!("other columns in {name}")));
        }
        let column = |values: Vec<f64>| {
            let table = Table::new(name, cosines.clone(), values)?;
            let (x, y) = (table.x(), table.y());
            let sum: f64 = (1..x.len()).map(|i| 0.5 * (x[i] - x[i - 1]) * (y[i] + y[i - 1])).sum();
            if y.iter().any(|p| *p < 0.0) || sum.is_nan() || sum <= 0.0 {
                return Err(Error::out_of_range(
                    "table of a phase function",
                    format!("negative, or zero everywhere, in {name}"),
                    "at least zero",
                ));
            }
            Ok(table.scaled(1.0, 1.0 / (2.0 * std::f64::consts::PI * sum)))
        };
        let columns = values.into_iter().map(column).collect::<Result<Vec<Table>>>()?;
        Ok(Self { lambda_um, columns })
    }

    /// The columns around a wavelength, and how much of the second.
    fn around(&self, lambda_um: f64) -> (&Table, &Table, f64) {
        let last = self.lambda_um.len() - 1;
        let i = self.lambda_um.partition_point(|l| *l <= lambda_um).clamp(1, last.max(1));
        let (low, high) = (i - 1, i.min(last));
        let gap = self.lambda_um[high] - self.lambda_um[low];
        let t = if gap > 0.0 { ((lambda_um - self.lambda_um[low]) / gap).clamp(0.0, 1.0) } else { 0.0 };
        (&self.columns[low], &self.columns[high], t)
    }
}

impl Phase for Tabulated {
    fn content(&self, digest: &mut Digest) {
        self.columns.iter().for_each(|column| column.add_to(digest));
        digest.numbers(&self.lambda_um);
    }
    fn at(&self, cosine: f64, lambda_um: f64) -> f64 {
        let (low, high, t) = self.around(lambda_um);
        (1.0 - t) * low.at(cosine) + t * high.at(cosine)
    }
    fn sample(&self, lambda_um: f64, random: &mut Counter) -> f64 {
        let (low, high, t) = self.around(lambda_um);
        let column = if random.uniform() < t { high } else { low };
        let (x, y) = (column.x(), column.y());
        let mut left = random.uniform() / (2.0 * std::f64::consts::PI);
        for i in 1..x.len() {
            let (step, area) = (x[i] - x[i - 1], 0.5 * (x[i] - x[i - 1]) * (y[i] + y[i - 1]));
            if left < area {
                // The density rises evenly: the root of y d + slope d²/2 = left.
                let slope = (y[i] - y[i - 1]) / step;
                let root = (y[i - 1] * y[i - 1] + 2.0 * slope * left).max(0.0).sqrt();
                return x[i - 1] + (2.0 * left / (y[i - 1] + root)).clamp(0.0, step);
            }
            left -= area;
        }
        1.0
    }
    fn is_spectral(&self) -> bool {
        self.columns.len() > 1
    }
}

/// Two wavelengths, one thrown forward and one backward.
#[cfg(test)]
pub(super) fn two_columns() -> Tabulated {
    let columns = vec![vec![0.1, 0.5, 4.0], vec![2.0, 1.0, 0.0]];
    Tabulated::new("test", vec![0.4, 0.65], vec![-1.0, 0.2, 1.0], columns).unwrap()
}
