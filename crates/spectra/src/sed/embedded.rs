//! Stellar spectra that ship: the library of Pickles 1998, interpolated between its types, and Vega.

use std::sync::{Arc, OnceLock};

use super::spectral_type::SpectralType;
use crate::embedded::embedded_columns;
use crate::error::{Result, SpectraError};
use crate::table::Table;

const PICKLES: &str = include_str!("../../data/stars/pickles.csv");

/// Reads a table once: a scene may have thousands of stars.
pub(super) fn once<T>(cell: &'static OnceLock<T>, read: impl FnOnce() -> Result<T>) -> Result<&'static T> {
    match cell.get() {
        Some(known) => Ok(known),
        None => {
            let known = read()?;
            Ok(cell.get_or_init(|| known))
        }
    }
}

/// The names of the library's spectra, in the order of the table's columns.
pub fn star_names() -> impl Iterator<Item = &'static str> {
    let head = PICKLES.lines().find(|line| line.starts_with("wavelength_nm,")).unwrap_or("");
    head.split(',').skip(1)
}

/// Library entry of a spectrum, in words.
pub fn star_summary(name: &str) -> String {
    let Some(wanted) = SpectralType::parse(name) else { return String::new() };
    let metals = match wanted.metals {
        'r' => ", metal-rich",
        'w' => ", metal-weak",
        _ => "",
    };
    format!("{} {}{metals}, Pickles 1998, 0.115 to 2.5 um", wanted.letter(), wanted.roman())
}

/// The library: type and spectrum of each column.
fn library() -> Result<&'static [(SpectralType, Arc<Table>)]> {
    static LIBRARY: OnceLock<Vec<(SpectralType, Arc<Table>)>> = OnceLock::new();
    let read = || {
        let names: Vec<&str> = star_names().collect();
        let columns = embedded_columns("pickles", PICKLES, names.len() + 1)?;
        let lambda_um: Vec<f64> = columns[0].iter().map(|nm| nm * 1e-3).collect();
        let star = |(name, flux): (&&str, &Vec<f64>)| {
            let nearest =
                SpectralType::parse(name).ok_or_else(|| SpectraError::table("pickles", format!("\"{name}\" is not a spectral type")))?;
            Ok((nearest, Arc::new(Table::new(name, lambda_um.clone(), flux.clone())?)))
        };
        names.iter().zip(&columns[1..]).map(star).collect()
    };
    Ok(once(&LIBRARY, read)?)
}

/// The most subclasses that two types may lie apart from which a third is interpolated.
const WIDEST: f64 = 10.0;

/// The spectrum of a star of type `name`, F_λ relative to 0.5556 µm \[1\]: of the library of Pickles 1998, or linear
/// between the two nearest types of the same luminosity class, at most ten subclasses apart.
///
/// # Errors
/// If `name` is no type, or one beyond the library's.
pub fn star(name: &str) -> Result<Arc<Table>> {
    let wanted = SpectralType::parse(name).ok_or_else(|| {
        SpectraError::SpectralType(format!(
            "\"{name}\" is no spectral type; one has a letter of OBAFGKM, a subclass and a luminosity class, such as B3V, M2 Iab or K0III (catalogue \"stars\")"
        ))
    })?;
    let mut nearest: Vec<&(SpectralType, Arc<Table>)> =
        library()?.iter().filter(|(t, _)| t.luminosity == wanted.luminosity && t.metals == wanted.metals).collect();
    nearest.sort_by(|a, b| a.0.subclass.total_cmp(&b.0.subclass));
    let above = nearest.partition_point(|(t, _)| t.subclass < wanted.subclass);
    let neighbours = (above.checked_sub(1).and_then(|i| nearest.get(i)), nearest.get(above));
    match neighbours {
        (_, Some((t, spectrum))) if t.subclass == wanted.subclass => Ok(spectrum.clone()),
        (Some((low, a)), Some((high, b))) if high.subclass - low.subclass <= WIDEST => {
            let share = (wanted.subclass - low.subclass) / (high.subclass - low.subclass);
            let flux = a.y().iter().zip(b.y()).map(|(a, b)| a + share * (b - a)).collect();
            Ok(Arc::new(Table::new(name, a.x().to_vec(), flux)?))
        }
        _ => {
            if let (Some((low, _)), Some((high, _))) = neighbours {
                return Err(SpectraError::SpectralType(format!(
                    "the library has no type of luminosity class {} between {} and {}, too sparse for \"{name}\"; use another class (catalogue \"stars\")",
                    wanted.roman(),
                    low.letter(),
                    high.letter()
                )));
            }
            let ends = nearest.first().zip(nearest.last()).map(|(a, b)| format!("from {} to {}", a.0.letter(), b.0.letter()));
            Err(SpectraError::SpectralType(format!(
                "the library has luminosity class {} {}, which does not include \"{name}\"; use a black body, or another class (catalogue \"stars\")",
                wanted.roman(),
                ends.unwrap_or_else(|| "not with these metals".into())
            )))
        }
    }
}

/// Vega's flux at the Earth, CALSPEC alpha_lyr_stis_011 [W m⁻² µm⁻¹].
///
/// # Errors
/// If the embedded table is broken, which a test rules out.
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
        assert_eq!(star_names().count(), 131);
        for name in star_names() {
            let spectrum = star(name).unwrap();
            // Cool giants have a band head there, which the library's average smooths.
            let cool = SpectralType::parse(name).unwrap().subclass >= 65.0;
            assert!((spectrum.at(0.5556) - 1.0).abs() < if cool { 0.5 } else { 0.06 }, "{name}: {}", spectrum.at(0.5556));
            assert!(star_summary(name).contains("Pickles"), "{name}");
        }
    }

    /// Types between those of the library lie between their neighbours; any case is read; what lies beyond is refused
    /// with what there is.
    #[test]
    fn types_are_interpolated() {
        let at = |name: &str| star(name).unwrap().at(0.4);
        assert_eq!(at("B3V"), at("b3v"));
        let (b1, b2, b3) = (at("B1V"), at("B2V"), at("B3V"));
        assert!((b2 / (0.5 * (b1 + b3)) - 1.0).abs() < 1e-12 && b1 > b2 && b2 > b3);
        assert!((at("B2.5 V") / (0.25 * b1 + 0.75 * b3) - 1.0).abs() < 1e-12);
        let beyond = star("O3V").unwrap_err().to_string();
        assert!(beyond.contains("from O5 to M6") && beyond.contains("O3V"), "{beyond}");
        let none = star("B3").unwrap_err().to_string();
        assert!(none.contains("luminosity class") && none.contains("M2 Iab") && star("M2 Iab").is_ok(), "{none}");
        let far = star("A0II").unwrap_err().to_string();
        assert!(far.contains("between B5 and F0"), "{far}");
    }

    /// Vega at 0.5556 µm: 3.44e-9 erg s⁻¹ cm⁻² Å⁻¹ (Bohlin, Gordon & Tremblay 2014).
    #[test]
    fn vega_is_absolute() {
        assert!((vega().unwrap().at(0.5556) / 3.44e-8 - 1.0).abs() < 0.02);
    }
}
