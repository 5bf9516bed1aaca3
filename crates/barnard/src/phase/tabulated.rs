//! A phase function from a table.
//!
//! CSV: cos θ ascending from −1 to 1, then one column of p for each wavelength; a line `# wavelength_um: 0.44, 0.55` names them (one column needs none).
//! Linear in cos θ and λ; each column is normalised to ∫ p dΩ = 1.

use std::sync::Arc;

use spectra::table::{Table, rows};

use super::{Phase, PhaseKind};
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
struct Tabulated {
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

impl Phase for Tabulated {
    fn at(&self, cosine: f64, lambda_um: f64) -> f64 {
        let last = self.lambda_um.len() - 1;
        let i = self.lambda_um.partition_point(|l| *l <= lambda_um);
        if i == 0 || last == 0 {
            return self.columns[0].at(cosine);
        }
        if i > last {
            return self.columns[last].at(cosine);
        }
        let t = (lambda_um - self.lambda_um[i - 1]) / (self.lambda_um[i] - self.lambda_um[i - 1]);
        (1.0 - t) * self.columns[i - 1].at(cosine) + t * self.columns[i].at(cosine)
    }
    fn is_spectral(&self) -> bool {
        self.columns.len() > 1
    }
}
