//! Stellar spectra that ship: ten of Pickles 1998, and Vega.

use std::sync::{Arc, OnceLock};

use crate::error::{Result, SpectraError};
use crate::table::{Table, embedded_columns};

/// One row of the catalogue.
#[derive(Debug, Clone, Copy)]
pub struct StarEntry {
    /// Its name in scenes.
    pub name: &'static str,
    /// One line: what it is, its source.
    pub summary: &'static str,
}

/// Embedded stellar spectra, in the order of the table's columns.
pub const STARS: &[StarEntry] = &[
    StarEntry { name: "o5v", summary: "O5 V, Pickles 1998, 0.115 to 2.5 um" },
    StarEntry { name: "o9v", summary: "O9 V, Pickles 1998, 0.115 to 2.5 um" },
    StarEntry { name: "b0v", summary: "B0 V, Pickles 1998, 0.115 to 2.5 um" },
    StarEntry { name: "b3v", summary: "B3 V, Pickles 1998, 0.115 to 2.5 um" },
    StarEntry { name: "b8v", summary: "B8 V, Pickles 1998, 0.115 to 2.5 um" },
    StarEntry { name: "a0v", summary: "A0 V, Pickles 1998, 0.115 to 2.5 um" },
    StarEntry { name: "f5v", summary: "F5 V, Pickles 1998, 0.115 to 2.5 um" },
    StarEntry { name: "g2v", summary: "G2 V, Pickles 1998, 0.115 to 2.5 um" },
    StarEntry { name: "k0iii", summary: "K0 III, Pickles 1998, 0.115 to 2.5 um" },
    StarEntry { name: "m2v", summary: "M2 V, Pickles 1998, 0.115 to 2.5 um" },
];

/// What is read once: a scene may have thousands of stars.
fn once<T>(kept: &'static OnceLock<T>, read: impl FnOnce() -> Result<T>) -> Result<&'static T> {
    match kept.get() {
        Some(known) => Ok(known),
        None => {
            let known = read()?;
            Ok(kept.get_or_init(|| known))
        }
    }
}

/// The spectrum of the star called `name`, F_λ relative to 0.5556 µm [1].
pub fn star(name: &str) -> Result<Arc<Table>> {
    let known: Vec<&str> = STARS.iter().map(|s| s.name).collect();
    let column = known.iter().position(|n| *n == name).ok_or_else(|| SpectraError::unknown("stellar spectrum", name, &known))?;
    static SPECTRA: OnceLock<Vec<Arc<Table>>> = OnceLock::new();
    let spectra = once(&SPECTRA, || {
        let columns = embedded_columns("pickles", include_str!("../../data/stars/pickles.csv"), STARS.len() + 1)?;
        let lambda_um: Vec<f64> = columns[0].iter().map(|nm| nm * 1e-3).collect();
        // The library leaves unobserved ultraviolet at zero or a little below: no light.
        let spectrum = |(name, flux): (&&str, &Vec<f64>)| {
            Ok(Arc::new(Table::new(name, lambda_um.clone(), flux.iter().map(|f| f.max(0.0)).collect())?))
        };
        known.iter().zip(&columns[1..]).map(spectrum).collect()
    })?;
    Ok(spectra[column].clone())
}

/// Vega's flux at the Earth, CALSPEC alpha_lyr_stis_011 [W m⁻² µm⁻¹].
pub fn vega() -> Result<&'static Table> {
    static VEGA: OnceLock<Table> = OnceLock::new();
    once(&VEGA, || {
        let columns = embedded_columns("vega", include_str!("../../data/stars/vega.csv"), 2)?;
        // 1 erg s⁻¹ cm⁻² Å⁻¹ = 10 W m⁻² µm⁻¹
        Ok(Table::new("vega", columns[0].clone(), columns[1].clone())?.scaled(1e-3, 10.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_star_is_one_at_5556_angstrom() {
        for entry in STARS {
            let spectrum = star(entry.name).unwrap();
            assert!((spectrum.at(0.5556) - 1.0).abs() < 0.06, "{}: {}", entry.name, spectrum.at(0.5556));
        }
    }

    /// Vega at 0.5556 µm: 3.44e-9 erg s⁻¹ cm⁻² Å⁻¹ (Bohlin, Gordon & Tremblay 2014).
    #[test]
    fn vega_is_absolute() {
        assert!((vega().unwrap().at(0.5556) / 3.44e-8 - 1.0).abs() < 0.02);
    }
}
