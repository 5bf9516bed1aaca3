//! A phase function from a table.
//!
//! CSV: cos θ ascending from −1 to 1, then one column of p for each wavelength; a line `# wavelength_um: 0.44, 0.55` names them (one column needs none).
//! Linear in cos θ and λ; each column is normalised to ∫ p dΩ = 1.

use std::sync::Arc;

use spectra::table::{Table, rows};

use super::{Phase, PhaseKind};
use crate::counter::Counter;
use crate::error::Result;
use crate::scene::{Key, Section};

pub(super) const KIND: PhaseKind = PhaseKind {
    name: "tabulated",
    summary: "from a CSV of cos theta and p for one or more wavelengths",
    keys: &[Key::required("file", "path", "the CSV")],
    build: |section, loader, _| {
        let file = section.need_text("file")?;
        Ok(Arc::new(parse(section, file, &section.wrap("file", loader.read_text(file))?)?))
    },
};

#[derive(Debug)]
pub(super) struct Tabulated {
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
    let fits = lambda_um.windows(2).all(|w| w[0] < w[1]) && rows.iter().all(|r| r.len() == lambda_um.len() + 1);
    let ends = (rows[0][0] + 1.0).abs() < 1e-6 && (rows[rows.len() - 1][0] - 1.0).abs() < 1e-6;
    if !fits || !ends {
        let message = format!("{file}: needs cos theta from -1 to 1 and one column for each of {} ascending wavelengths", lambda_um.len());
        return Err(section.error("file", message));
    }
    let column = |c: usize| {
        let table = section.wrap("file", Table::new(file, rows.iter().map(|r| r[0]).collect(), rows.iter().map(|r| r[c + 1]).collect()))?;
        let (x, y) = (table.x(), table.y());
        let sum: f64 = (1..x.len()).map(|i| 0.5 * (x[i] - x[i - 1]) * (y[i] + y[i - 1])).sum();
        if y.iter().any(|p| *p < 0.0) || sum <= 0.0 {
            return Err(section.error("file", format!("{file}: a phase function is not negative and not zero everywhere")));
        }
        Ok(table.scaled(1.0, 1.0 / (2.0 * std::f64::consts::PI * sum)))
    };
    let columns = (0..lambda_um.len()).map(column).collect::<Result<Vec<Table>>>()?;
    Ok(Tabulated { lambda_um, columns })
}

impl Tabulated {
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
        let column = if random.next() < t { high } else { low };
        let (x, y) = (column.x(), column.y());
        let mut left = random.next() / (2.0 * std::f64::consts::PI);
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
    let column = |p: [f64; 3]| {
        let table = Table::new("test", vec![-1.0, 0.2, 1.0], p.to_vec()).unwrap();
        let sum = 0.6 * (p[0] + p[1]) + 0.4 * (p[1] + p[2]);
        table.scaled(1.0, 1.0 / (2.0 * std::f64::consts::PI * sum))
    };
    Tabulated { lambda_um: vec![0.4, 0.65], columns: vec![column([0.1, 0.5, 4.0]), column([2.0, 1.0, 0.0])] }
}
