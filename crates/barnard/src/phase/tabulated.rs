//! A phase function from a table.
//!
//! CSV: cos θ ascending from −1 to 1, then one column of p for each wavelength; a line `# wavelength_um: 0.44, 0.55`
//! names them (one column needs none). Linear in cos θ and λ; each column is normalised to ∫ p dΩ = 1.

use std::sync::Arc;

use spectra::table::{Table, rows};

use super::{Phase, PhaseKind};
use crate::error::{Error, Result};
use crate::properties::{Key, Section};
use crate::random::Counter;

pub(super) const KIND: PhaseKind = PhaseKind {
    name: "tabulated",
    summary: "from a CSV of cos theta and p for one or more wavelengths",
    keys: &[Key::required("file", "path", "the CSV")],
    build: |section, inputs, _| {
        let file = section.need_text("file")?;
        Ok(Arc::new(parse(section, file, &section.wrap("file", inputs.text(file))?)?))
    },
};

/// A phase function from a table.
#[derive(Debug, Clone)]
pub struct Tabulated {
    lambda_um: Vec<f64>,
    columns: Vec<Table>,
}

fn parse(section: &Section, file: &str, text: &str) -> Result<Tabulated> {
    let rows = section.wrap("file", rows(file, text, 2))?;
    let named = text.lines().find_map(|l| l.trim().strip_prefix("# wavelength_um:"));
    let lambda_um: Vec<f64> = match named {
        Some(list) => list.split(',').filter_map(|v| v.trim().parse().ok()).collect(),
        None => vec![0.55],
    };
    let cosines = rows.iter().map(|r| r[0]).collect();
    let values = (1..=rows[0].len() - 1).map(|c| rows.iter().map(|r| r.get(c).copied().unwrap_or(f64::NAN)).collect());
    let widest = rows.iter().map(Vec::len).max().unwrap_or(0);
    if widest != rows[0].len() {
        return Err(section.error("file", format!("{file}: has rows of {widest} and of {} columns", rows[0].len())));
    }
    section.wrap("file", Tabulated::new(file, lambda_um, cosines, values.collect()))
}

impl Tabulated {
    /// A phase function of these values at ascending `cosines` from −1 to 1, for each of the ascending wavelengths \[µm\] one column, as long as
    /// `cosines`; only their shape counts. `name` stands in messages.
    ///
    /// # Errors
    /// Where lengths or ends are others, or values are negative or zero everywhere.
    pub fn new(name: &str, lambda_um: Vec<f64>, cosines: Vec<f64>, values: Vec<Vec<f64>>) -> Result<Self> {
        let ascending = lambda_um.windows(2).all(|w| w[0] < w[1]) && !lambda_um.is_empty() && lambda_um.len() == values.len();
        let near = |end: Option<&f64>, wanted: f64| end.is_some_and(|end| (end - wanted).abs() < 1e-6);
        if !ascending || !near(cosines.first(), -1.0) || !near(cosines.last(), 1.0) {
            let wanted = format!("cos theta from -1 to 1 and one column for each of {} ascending wavelengths", lambda_um.len());
            return Err(Error::value("table of a phase function", name, wanted));
        }
        let column = |values: Vec<f64>| {
            let table = Table::new(name, cosines.clone(), values)?;
            let (x, y) = (table.x(), table.y());
            let sum: f64 = (1..x.len()).map(|i| 0.5 * (x[i] - x[i - 1]) * (y[i] + y[i - 1])).sum();
            if y.iter().any(|p| *p < 0.0) || sum.is_nan() || sum <= 0.0 {
                return Err(Error::value("table of a phase function", name, "one whose values are not negative and not zero everywhere"));
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
            let (step, own) = (x[i] - x[i - 1], 0.5 * (x[i] - x[i - 1]) * (y[i] + y[i - 1]));
            if left < own {
                // The density rises evenly: the root of y d + slope d²/2 = left.
                let slope = (y[i] - y[i - 1]) / step;
                let root = (y[i - 1] * y[i - 1] + 2.0 * slope * left).max(0.0).sqrt();
                return x[i - 1] + (2.0 * left / (y[i - 1] + root)).clamp(0.0, step);
            }
            left -= own;
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
