//! Light of ionised gas: line emissivities, line lists and the recombination continuum.
//!
//! j = ε(T, n_e) n_e n_ion / 4π
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | ε | emissivity | erg cm³ s⁻¹ (per Å for the continuum) |
//! | n_e, n_ion | densities | cm⁻³ |
//! | j | emission coefficient | W m⁻³ sr⁻¹ (µm⁻¹) for n_e n_ion = 1 cm⁻⁶ |
//!
//! ln ε is interpolated linearly in T and log n_e; valid for 5000 to 20000 K, 10 to 10⁵ cm⁻³ (lines) and 6000 to 15000
//! K, 10² to 10⁴ cm⁻³ (continuum). Tables: PyNeb 1.1.32 (Luridiana, Morisset & Shaw 2015, A&A 573, A42), H I and He II
//! case B of Storey & Hummer 1995, series up to Humphreys'. They list wavelengths in air; spectra have them in vacuum, as
//! filters do. The continuum's table ends at 5 µm and goes on in [closed form](crate::hydrogen_continuum) to 1 mm. Left out:
//! He I and He II continua beyond He⁺/H⁺ = 0.1.

use std::sync::Arc;

use crate::air::vacuum_um;
use crate::constants::SPHERE;
use crate::embedded::{rows, with_provenance};
use crate::error::{Result, SpectraError};
use crate::hydrogen_continuum;
use crate::spectrum::{Line, Spectrum};
use crate::table::Table;
use crate::units::{NumberDensity, Temperature};

const EMISSIVITIES: &str = include_str!("../data/nebular/line_emissivities.csv");
const CONTINUUM: &str = include_str!("../data/nebular/continuum.csv");

/// 1 erg s⁻¹ cm⁻³ = 0.1 W m⁻³, over the whole sphere.
const W_PER_M3_SR: f64 = 0.1 / SPHERE;

/// A list of lines with relative strengths.
#[derive(Debug, Clone, Copy)]
pub struct LineListEntry {
    /// The name in scenes.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    text: &'static str,
}

/// Embedded line lists, strengths relative to Hβ = 1.
pub const LINE_LISTS: &[LineListEntry] = &[
    LineListEntry {
        name: "diffuse_hii",
        summary: "one-zone H II region, 8000 K, 100 cm-3, relative to H-beta",
        text: include_str!("../data/nebular/lines_diffuse_hii.csv"),
    },
    LineListEntry {
        name: "orion_like",
        summary: "one-zone Orion-like H II region, 8500 K, 6000 cm-3, relative to H-beta",
        text: include_str!("../data/nebular/lines_orion_like.csv"),
    },
    LineListEntry {
        name: "planetary_high_excitation",
        summary: "one-zone planetary nebula, 12000 K, 3000 cm-3, relative to H-beta",
        text: include_str!("../data/nebular/lines_pn_high_exc.csv"),
    },
];

/// The lines of the list called `name`, Hβ = 1.
///
/// # Errors
/// If there is no such list.
pub fn line_list(name: &str) -> Result<Spectrum> {
    let known: Vec<&str> = LINE_LISTS.iter().map(|l| l.name).collect();
    let entry = LINE_LISTS.iter().find(|l| l.name == name).ok_or_else(|| SpectraError::unknown("line list", name, &known))?;
    let lines = labelled_rows(name, entry.text)?
        .into_iter()
        .map(|(_, _, v)| Line { lambda_um: vacuum_um(v[0] * 1e-4), strength: v[1] / 100.0 })
        .collect();
    Ok(Spectrum::of_lines(lines))
}

/// Reads rows of "ion,label,numbers…".
fn labelled_rows(name: &str, text: &'static str) -> Result<Vec<(&'static str, &'static str, Vec<f64>)>> {
    let body = with_provenance(name, text)?;
    let lines = body.lines().filter(|l| !l.starts_with('#') && !l.starts_with("ion,"));
    lines
        .map(|line| {
            let mut cells = line.split(',');
            let (ion, label) = (cells.next().unwrap_or(""), cells.next().unwrap_or(""));
            let numbers: std::result::Result<Vec<f64>, _> = cells.map(str::parse).collect();
            numbers.map(|n| (ion, label, n)).map_err(|_| SpectraError::table(name, format!("not a row of line data: {line}")))
        })
        .collect()
}

/// The ions that the emissivity table holds, such as "H1" (lines of H⁺ recombining) and "O3" ([O III]).
pub fn ions() -> Vec<&'static str> {
    let mut ions: Vec<&str> = Vec::new();
    for (ion, _, _) in labelled_rows("line_emissivities", EMISSIVITIES).unwrap_or_default() {
        if !ions.contains(&ion) {
            ions.push(ion);
        }
    }
    ions
}

/// The lines of `ion` at T and n_e [W m⁻³ sr⁻¹ for n_e n_ion = 1 cm⁻⁶].
///
/// # Errors
/// If there is no such ion, or T or n_e lie outside of its table.
pub fn ion_lines(ion: &str, temperature: Temperature, electrons: NumberDensity) -> Result<Spectrum> {
    let all = labelled_rows("line_emissivities", EMISSIVITIES)?;
    if !all.iter().any(|(i, _, _)| *i == ion) {
        return Err(SpectraError::unknown("ion", ion, &ions()));
    }
    let header = EMISSIVITIES.lines().find(|l| l.starts_with("ion,")).unwrap_or_default();
    let grid = NebularGrid::from_header("line emissivities", header.split(',').skip(3))?;
    let weights = grid.weights(temperature, electrons)?;
    let lines = all
        .iter()
        .filter(|(i, _, _)| *i == ion)
        .map(|(_, _, v)| Line { lambda_um: vacuum_um(v[0] * 1e-4), strength: W_PER_M3_SR * logarithmic_mean(&weights, &v[1..]) })
        .collect();
    Ok(Spectrum::of_lines(lines))
}

/// The recombination continuum of hydrogen at T and n_e [W m⁻³ sr⁻¹ µm⁻¹ for n_e n_H⁺ = 1 cm⁻⁶].
///
/// # Errors
/// If T or n_e lie outside of the table.
pub fn recombination_continuum(temperature: Temperature, electrons: NumberDensity) -> Result<Spectrum> {
    let body = with_provenance("continuum", CONTINUUM)?;
    let header = body.lines().find(|l| l.starts_with("wavelength_nm,")).unwrap_or_default();
    let grid = NebularGrid::from_header("recombination continuum", header.split(',').skip(1))?;
    let weights = grid.weights(temperature, electrons)?;
    let rows = rows("continuum", body, 11)?;
    // Per ångström to per µm: 10⁴.
    let scale = W_PER_M3_SR * 1e4;
    let value = |r: &Vec<f64>| scale * logarithmic_mean(&weights, &r[1..]);
    let (mut lambda, mut values): (Vec<f64>, Vec<f64>) = rows.iter().map(|r| (r[0] * 1e-3, value(r))).unzip();
    let (Some(end), Some(level)) = (lambda.last().copied(), values.last().copied()) else {
        return Err(SpectraError::table("continuum", "has no rows"));
    };
    // The form goes on at the height of the table, which has helium in it.
    let form =
        |lambda: f64| level * hydrogen_continuum::emissivity(temperature.0, lambda) / hydrogen_continuum::emissivity(temperature.0, end);
    for lambda_um in beyond(end) {
        lambda.push(lambda_um);
        values.push(form(lambda_um));
    }
    let table = Table::new("continuum", lambda, values)?;
    Ok(Spectrum::continuous(1.0, Arc::new(table)))
}

/// Where the continuum ends \[µm\], and how far apart its wavelengths are behind the table, as parts of each.
const FARTHEST_UM: f64 = 1000.0;
const APART: f64 = 0.01;

/// Wavelengths behind the table \[µm\], both sides of each edge of a level among them.
fn beyond(end_um: f64) -> Vec<f64> {
    let count = ((FARTHEST_UM / end_um).ln() / APART).ceil() as u32;
    let even = (1..=count).map(|i| end_um * (FARTHEST_UM / end_um).powf(f64::from(i) / f64::from(count)));
    let edges = (1..).map(hydrogen_continuum::edge_um).take_while(|edge| *edge < FARTHEST_UM).filter(|edge| *edge > end_um);
    let mut all: Vec<f64> = even.chain(edges.flat_map(|edge| [edge * (1.0 - 1e-7), edge * (1.0 + 1e-7)])).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// The mean exp Σ w ln v, where the weights are at most four.
fn logarithmic_mean(weights: &[(usize, f64)], values: &[f64]) -> f64 {
    weights.iter().map(|(i, w)| w * values[*i].max(1e-60).ln()).sum::<f64>().exp()
}

/// Columns "T8000_n2": temperature and log₁₀ density of each.
struct NebularGrid {
    what: &'static str,
    temperatures: Vec<f64>,
    log_densities: Vec<f64>,
    columns: Vec<(f64, f64)>,
}

impl NebularGrid {
    fn from_header<'a>(what: &'static str, names: impl Iterator<Item = &'a str>) -> Result<Self> {
        let parse = |name: &str| {
            let (t, n) = name.trim().strip_prefix('T')?.split_once("_n")?;
            Some((t.parse::<f64>().ok()?, n.parse::<f64>().ok()?))
        };
        let columns: Option<Vec<(f64, f64)>> = names.map(parse).collect();
        let columns = columns.ok_or_else(|| SpectraError::table(what, "column names must be like T8000_n2"))?;
        let ascending = |values: Vec<f64>| {
            let mut v = values;
            v.sort_by(f64::total_cmp);
            v.dedup();
            v
        };
        Ok(Self {
            what,
            temperatures: ascending(columns.iter().map(|c| c.0).collect()),
            log_densities: ascending(columns.iter().map(|c| c.1).collect()),
            columns,
        })
    }

    /// Bilinear weights of the four columns around (T, n_e).
    fn weights(&self, temperature: Temperature, electrons: NumberDensity) -> Result<Vec<(usize, f64)>> {
        let t = bracket(&self.temperatures, temperature.0)
            .ok_or_else(|| self.outside("temperature [K]", temperature.0, &self.temperatures, |v| v))?;
        let n = bracket(&self.log_densities, electrons.0.log10())
            .ok_or_else(|| self.outside("electron density [cm-3]", electrons.0, &self.log_densities, |v| 10f64.powf(v)))?;
        let column = |t: f64, n: f64| self.columns.iter().position(|c| *c == (t, n)).unwrap_or(0);
        Ok(t.iter().flat_map(|(tv, tw)| n.iter().map(move |(nv, nw)| (*tv, *nv, tw * nw))).map(|(t, n, w)| (column(t, n), w)).collect())
    }

    fn outside(&self, axis: &str, value: f64, nodes: &[f64], unit: impl Fn(f64) -> f64) -> SpectraError {
        SpectraError::Range { what: format!("{axis} of {}", self.what), value, low: unit(nodes[0]), high: unit(nodes[nodes.len() - 1]) }
    }
}

/// The two nodes around `value` with their linear weights.
fn bracket(nodes: &[f64], value: f64) -> Option<[(f64, f64); 2]> {
    let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
    if !(first..=last).contains(&value) {
        return None;
    }
    let i = nodes.partition_point(|n| *n <= value).clamp(1, nodes.len() - 1);
    let t = (value - nodes[i - 1]) / (nodes[i] - nodes[i - 1]);
    Some([(nodes[i - 1], 1.0 - t), (nodes[i], t)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The strength of a line by its wavelength in air.
    fn strength(spectrum: &Spectrum, nm: f64) -> f64 {
        spectrum.lines().iter().find(|l| (l.lambda_um - vacuum_um(nm * 1e-3)).abs() < 5e-5).unwrap().strength
    }

    /// Osterbrock & Ferland 2006, table 4.2 (case B, 10⁴ K, 100 cm⁻³): Hα/Hβ = 2.863, Hγ/Hβ = 0.468, 4π j_Hβ =
    /// 1.235e-25 n_e n_p; [O III] 5007/4959 = 2.98 and [N II] 6584/6548 = 2.94 are ratios of transition probabilities.
    #[test]
    fn case_b_and_forbidden_ratios() {
        let (t, n) = (Temperature(1e4), NumberDensity(100.0));
        let h = ion_lines("H1", t, n).unwrap();
        let hb = strength(&h, 486.138);
        assert!((strength(&h, 656.288) / hb - 2.863).abs() < 2e-3);
        assert!((strength(&h, 434.051) / hb - 0.468).abs() < 1e-3);
        assert!((hb * SPHERE / 0.1 / 1.235e-25 - 1.0).abs() < 2e-3);
        let o = ion_lines("O3", t, n).unwrap();
        assert!((strength(&o, 500.684) / strength(&o, 495.891) - 2.984).abs() < 5e-3);
        let nii = ion_lines("N2", t, n).unwrap();
        assert!((strength(&nii, 658.345) / strength(&nii, 654.805) - 2.942).abs() < 5e-3);
    }

    /// No line of the table is so faint at 10⁴ K that it is a transition between high levels, taken for the nebular one
    /// beside it.
    #[test]
    fn lines_are_those_of_nebulae() {
        let (t, n) = (Temperature(1e4), NumberDensity(1e4));
        for ion in ions() {
            let lines = ion_lines(ion, t, n).unwrap();
            assert!(lines.lines().iter().all(|line| line.strength * SPHERE / 0.1 > 1e-28), "{ion}");
        }
    }

    #[test]
    fn interpolation_lies_between_its_nodes() {
        let at = |t: f64| strength(&ion_lines("H1", Temperature(t), NumberDensity(316.0)).unwrap(), 656.288);
        assert!(at(8000.0) > at(8500.0) && at(8500.0) > at(9000.0));
    }

    #[test]
    fn outside_is_an_error() {
        assert!(ion_lines("H1", Temperature(4000.0), NumberDensity(100.0)).is_err());
        assert!(ion_lines("H1", Temperature(8000.0), NumberDensity(1e7)).is_err());
        assert!(ion_lines("X9", Temperature(8000.0), NumberDensity(100.0)).is_err());
        assert!(recombination_continuum(Temperature(5000.0), NumberDensity(100.0)).is_err());
    }

    #[test]
    fn every_list_has_hydrogen_beta_of_one() {
        for entry in LINE_LISTS {
            assert!((strength(&line_list(entry.name).unwrap(), 486.138) - 1.0).abs() < 1e-6, "{}", entry.name);
        }
    }

    /// Hα and [O III] are where NIST has them in vacuum: 656.461 and 500.824 nm.
    #[test]
    fn lines_are_in_vacuum() {
        let (t, n) = (Temperature(1e4), NumberDensity(100.0));
        for (ion, nm) in [("H1", 656.461), ("O3", 500.824)] {
            assert!(ion_lines(ion, t, n).unwrap().lines().iter().any(|line| (line.lambda_um * 1e3 - nm).abs() < 0.015), "{ion}");
        }
        assert!(line_list("orion_like").unwrap().lines().iter().any(|line| (line.lambda_um - 0.656_461).abs() < 1.5e-5));
    }

    /// Pfund and Humphreys series: Storey & Hummer 1995, case B at 10⁴ K and 10⁴ cm⁻³, Pfα/Hβ = 0.0245, Huα/Hβ = 0.0093, at 7.460 and
    /// 12.372 µm in vacuum.
    #[test]
    fn series_of_the_infrared() {
        let h = ion_lines("H1", Temperature(1e4), NumberDensity(1e4)).unwrap();
        let hb = strength(&h, 486.138);
        for (um, ratio) in [(7.4599, 0.0245), (12.3719, 0.0093)] {
            let line = h.lines().iter().find(|line| (line.lambda_um - um).abs() < 2e-3).unwrap();
            assert!((line.strength / hb / ratio - 1.0).abs() < 0.01, "{um}: {}", line.strength / hb);
        }
    }

    /// The closed form is what PyNeb has between 2 and 5 µm, where helium adds a tenth, and the continuum has no step at 5 µm.
    #[test]
    fn the_continuum_goes_on_in_closed_form() {
        for kelvin in [6000.0, 8000.0, 1e4, 1.2e4, 1.5e4] {
            let c = recombination_continuum(Temperature(kelvin), NumberDensity(100.0)).unwrap();
            for um in [2.0, 2.5, 3.0, 4.0, 4.9] {
                let form = W_PER_M3_SR * 1e4 * crate::hydrogen_continuum::emissivity(kelvin, um);
                let ratio = c.continuum(um) / form;
                assert!((1.0..1.16).contains(&ratio), "{kelvin} K, {um} um: {ratio}");
            }
            let (before, after) = (c.continuum(4.99), c.continuum(5.01));
            assert!((before / after - 1.0).abs() < 0.01 && c.continuum(25.0) > 0.0 && c.continuum(999.0) > 0.0);
            // Flat in frequency: falling as λ⁻² but for the Gaunt factor.
            let slope = (c.continuum(20.0) / c.continuum(10.0)).log2();
            assert!((-2.1..-1.6).contains(&slope), "{slope}");
        }
    }

    /// The Balmer jump: the continuum is brighter just below 364.6 nm than just above.
    #[test]
    fn balmer_jump() {
        let c = recombination_continuum(Temperature(1e4), NumberDensity(100.0)).unwrap();
        assert!(c.continuum(0.360) > 3.0 * c.continuum(0.372));
    }
}
