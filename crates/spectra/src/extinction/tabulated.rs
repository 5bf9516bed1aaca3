//! Dust models as tables: extinction, albedo and mean cosine from one file.
//!
//! k(λ) = C_ext(λ)/C_ext(0.55 µm), linear in λ between rows.
//!
//! Source: Weingartner & Draine 2001 (ApJ 548, 296), Draine 2003 (ARA&A 41, 241); the files say which.

use super::{ExtinctionLaw, LawEntry, Maker};
use crate::constants::V_WAVELENGTH_UM;
use crate::embedded::embedded_columns;
use crate::error::Result;
use crate::fingerprint::Digest;
use crate::table::Table;

macro_rules! draine {
    ($const:ident, $name:literal, $summary:literal) => {
        pub(super) const $const: LawEntry = LawEntry {
            name: $name,
            summary: $summary,
            maker: Maker::Fixed(|| Ok(Box::new(DustTable::embedded($name, include_str!(concat!("../../data/dust/", $name, ".csv")))?))),
        };
    };
}

draine!(DRAINE_RV31, "draine03_rv31", "Draine 2003 Milky Way R_V = 3.1, with albedo and mean cosine; 0.03 um to 1 mm");
draine!(DRAINE_RV40, "draine03_rv40", "Draine 2003 Milky Way R_V = 4.0, with albedo and mean cosine; 0.03 um to 1 mm");
draine!(DRAINE_RV55, "draine03_rv55", "Draine 2003 Milky Way R_V = 5.5, with albedo and mean cosine; 0.03 um to 1 mm");
draine!(LMC, "wd01_lmc", "Weingartner & Draine 2001 average of the Large Magellanic Cloud, with albedo and mean cosine");
draine!(SMC, "wd01_smc", "Weingartner & Draine 2001 bar of the Small Magellanic Cloud, with albedo and mean cosine");

/// Draine's models of the Milky Way, with their R_V \[1\].
const MILKY_WAY: [(f64, LawEntry); 3] = [(3.1, DRAINE_RV31), (4.0, DRAINE_RV40), (5.5, DRAINE_RV55)];

/// The model of the Milky Way whose R_V is nearest to `r_v`: its name and its extinction law.
pub(super) fn nearest_in_the_milky_way(r_v: f64) -> LawEntry {
    let away = |known: f64| (known - r_v).abs();
    MILKY_WAY.iter().fold(MILKY_WAY[0], |best, row| if away(row.0) < away(best.0) { *row } else { best }).1
}

/// A dust model over wavelength.
#[derive(Debug, Clone)]
pub struct DustTable {
    /// The catalogue's name of the model.
    pub name: &'static str,
    extinction: Table,
    /// Albedo ω(λ) \[1\] over λ \[µm\].
    pub albedo: Table,
    /// Mean cosine of the phase function g(λ) \[1\] over λ \[µm\].
    pub mean_cosine: Table,
    /// Extinction cross-section per H nucleon at 0.55 µm \[cm²\].
    pub cross_section_v_cm2: f64,
}

impl DustTable {
    fn embedded(name: &'static str, text: &str) -> Result<Self> {
        let columns = embedded_columns(name, text, 4)?;
        let cross_section = Table::new(name, columns[0].clone(), columns[3].clone())?;
        let cross_section_v_cm2 = cross_section.at(V_WAVELENGTH_UM);
        Ok(Self {
            name,
            extinction: cross_section.scaled(1.0, 1.0 / cross_section_v_cm2),
            albedo: Table::new(name, columns[0].clone(), columns[1].clone())?,
            mean_cosine: Table::new(name, columns[0].clone(), columns[2].clone())?,
            cross_section_v_cm2,
        })
    }
}

impl ExtinctionLaw for DustTable {
    fn content(&self, digest: &mut Digest) {
        [&self.extinction, &self.albedo, &self.mean_cosine].iter().for_each(|table| table.add_to(digest));
    }
    fn k(&self, lambda_um: f64) -> f64 {
        self.extinction.at(lambda_um)
    }
    fn range_um(&self) -> (f64, f64) {
        self.extinction.range()
    }
    fn breakpoints_um(&self) -> Vec<f64> {
        self.extinction.x().to_vec()
    }
    fn dust_table(&self) -> Option<&DustTable> {
        Some(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draine 2003, table 4: at V (0.547 µm) C_ext/H = 4.896e-22 cm², albedo 0.673, ⟨cos⟩ 0.538.
    #[test]
    fn printed_values_at_v() {
        let table = DustTable::embedded("draine03_rv31", include_str!("../../data/dust/draine03_rv31.csv")).unwrap();
        assert!((table.k(0.547) * table.cross_section_v_cm2 / 4.896e-22 - 1.0).abs() < 2e-3);
        assert!((table.albedo.at(0.547) - 0.673).abs() < 1e-3);
        assert!((table.mean_cosine.at(0.547) - 0.538).abs() < 1e-3);
    }
}
