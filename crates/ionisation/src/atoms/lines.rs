//! Lines: emissivities over temperature and electron density.
//!
//! Between temperatures ln(ε √T) is taken as linear in 1/T, which is exact for two levels; between densities 1/ε is
//! linear in n_e, which is so as well.

use spectra::air::vacuum_um;
use spectra::embedded::with_provenance;

use super::Element;

/// A line, and its emissivity.
#[derive(Debug, Clone)]
pub struct EmissionLine {
    /// The element of the ion that electrons excite, or that recombines.
    pub element: Element,
    /// The charge of that ion.
    pub charge: usize,
    /// A name, as "\[OIII\]5007".
    pub label: String,
    /// The wavelength in vacuum \[µm\].
    pub wavelength_um: f64,
    /// ln(ε √T) by density, then temperature.
    values: Vec<f64>,
}

/// Lines over one grid of temperatures and densities.
#[derive(Debug)]
pub struct LineTable {
    /// 1/T \[K⁻¹\], falling; n_e \[cm⁻³\].
    inverse: Vec<f64>,
    densities: Vec<f64>,
    /// The lines.
    pub lines: Vec<EmissionLine>,
}

/// A place in a table: the nodes beside it, and the parts of the second ones.
#[derive(Debug, Clone, Copy)]
pub struct Conditions {
    temperature: [usize; 2],
    warmer: f64,
    density: [usize; 2],
    denser: f64,
    scale: f64,
}

impl LineTable {
    /// Reads a table whose lines are those of ions; the ions that excite them have a charge higher by that number.
    pub(super) fn read(name: &str, text: &str, higher: usize) -> Self {
        let body = with_provenance(name, text).expect("embedded");
        let mut rows = body.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect::<Vec<_>>());
        let header = rows.next().expect("embedded");
        let nodes: Vec<(f64, f64)> = header[3..]
            .iter()
            .map(|cell| {
                let (t, n) = cell.strip_prefix('T').and_then(|rest| rest.split_once("_n")).expect("embedded");
                (t.parse().expect("embedded"), n.parse().expect("embedded"))
            })
            .collect();
        let temperatures = nodes.iter().take_while(|(_, n)| *n == nodes[0].1).count();
        let line = |cells: Vec<&str>| {
            let value =
                |(cell, (t, _)): (&&str, &(f64, f64))| ((cell.parse::<f64>().expect("embedded") * t.sqrt()).max(f64::MIN_POSITIVE)).ln();
            let ions = || Element::ALL.into_iter().flat_map(|element| (0..=element.nucleus()).map(move |charge| (element, charge)));
            let (element, charge) = ions().find(|(element, charge)| element.ion(*charge) == cells[0]).expect("embedded");
            EmissionLine {
                element,
                charge: charge + higher,
                label: cells[1].to_owned(),
                wavelength_um: vacuum_um(1e-4 * cells[2].parse::<f64>().expect("embedded")),
                values: cells[3..].iter().zip(&nodes).map(value).collect(),
            }
        };
        Self {
            inverse: nodes[..temperatures].iter().map(|(t, _)| 1.0 / t).collect(),
            densities: nodes.iter().step_by(temperatures).map(|(_, n)| 10f64.powf(*n)).collect(),
            lines: rows.map(line).collect(),
        }
    }

    /// The place of a temperature \[K\] and an electron density \[cm⁻³\], at the border where they are outside.
    pub fn conditions(&self, temperature: f64, electrons: f64) -> Conditions {
        let last = self.inverse.len() - 1;
        let inverse = (1.0 / temperature).clamp(self.inverse[last], self.inverse[0]);
        let t = self.inverse.partition_point(|v| *v > inverse).clamp(1, last);
        let last = self.densities.len() - 1;
        let electrons = electrons.clamp(self.densities[0], self.densities[last]);
        let n = self.densities.partition_point(|v| *v < electrons).clamp(1, last);
        Conditions {
            temperature: [t - 1, t],
            warmer: (inverse - self.inverse[t - 1]) / (self.inverse[t] - self.inverse[t - 1]),
            density: [n - 1, n],
            denser: (electrons - self.densities[n - 1]) / (self.densities[n] - self.densities[n - 1]),
            scale: inverse.sqrt(),
        }
    }

    /// The largest emissivity of a line in thin gas of 1000 to 30 000 K, per electron and ion \[erg cm³ s⁻¹\].
    pub fn brightest(&self, line: &EmissionLine) -> f64 {
        (1..=30).map(|t| self.emissivity(line, &self.conditions(1000.0 * f64::from(t), 1.0))).fold(0.0, f64::max)
    }

    /// The emissivity of a line per electron and ion \[erg cm³ s⁻¹\].
    pub fn emissivity(&self, line: &EmissionLine, at: &Conditions) -> f64 {
        let temperatures = self.inverse.len();
        let populations = |density: usize| {
            let [a, b] = at.temperature.map(|t| line.values[density * temperatures + t]);
            (a + at.warmer * (b - a)).exp()
        };
        let [a, b] = at.density.map(populations);
        at.scale / ((1.0 - at.denser) / a + at.denser / b)
    }
}
