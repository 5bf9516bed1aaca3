//! Names of columns, and the units of spectral axes that they state.

use super::axis_unit::{AxisQuantity, AxisUnit};

/// Words for the quantity of a spectral axis, in small letters.
const QUANTITIES: [(AxisQuantity, &[&str]); 4] = [
    (
        AxisQuantity::Wavelength,
        &[
            "wavelength",
            "wavelengths",
            "wavelen",
            "wave",
            "wav",
            "wl",
            "wvl",
            "wvlen",
            "lambda",
            "lamda",
            "lam",
            "λ",
            "w",
            "wellenlaenge",
            "wellenlänge",
        ],
    ),
    (AxisQuantity::Wavenumber, &["wavenumber", "wavenumbers", "wavn"]),
    (AxisQuantity::Frequency, &["frequency", "freq", "nu", "ν"]),
    (AxisQuantity::Energy, &["energy", "photon energy"]),
];

/// Words that stand next to a unit and say nothing of it.
const FILLERS: [&str; 9] = ["in", "of", "the", "vac", "vacuum", "air", "rest", "unit", "units"];

/// A header cell as it concerns a spectral axis.
pub struct Cell {
    /// The quantity that its words name.
    pub quantity: Option<AxisQuantity>,
    /// Words that may each be a unit.
    pub units: Vec<String>,
    /// True if those words can be nothing else, since they stand in brackets or next to the quantity.
    pub is_tied: bool,
    /// True if it states wavelengths in air.
    pub is_air: bool,
}

/// True if a name is that of a spectral axis.
pub fn names_axis(cell: &str) -> bool {
    Cell::of(cell).quantity.is_some()
}

/// The name of a column without the unit in brackets behind it.
pub fn base_name(cell: &str) -> String {
    cell.split(['[', '(']).next().unwrap_or("").trim().to_lowercase()
}

impl Cell {
    /// Takes a name apart.
    pub fn of(cell: &str) -> Self {
        let cell = cell.trim();
        let bracket = cell.split_once(['[', '(', '{']).map(|(name, rest)| (name, rest.trim_end_matches([']', ')', '}'])));
        let (name, inside) = bracket.map_or((cell, None), |(name, rest)| (name, Some(rest)));
        let mut quantity = None;
        let mut rest = Vec::new();
        let mut is_air = false;
        for word in name.split(|c: char| c.is_whitespace() || "_/,:;".contains(c)).filter(|word| !word.is_empty()) {
            let lower = word.to_lowercase();
            is_air |= lower == "air";
            if let Some((found, _)) = QUANTITIES.iter().find(|(_, words)| words.contains(&lower.as_str())) {
                quantity = quantity.or(Some(*found));
            } else if let Some((found, unit)) = glued(word).filter(|_| quantity.is_none()) {
                quantity = Some(found);
                rest.push(unit.to_owned());
            } else if !FILLERS.contains(&lower.as_str()) {
                rest.push(word.to_owned());
            }
        }
        let outside = Some(rest.join(" ")).filter(|unit| !unit.is_empty());
        if let Some(inside) = inside {
            let parts: Vec<&str> = inside.split([',', ';']).map(str::trim).collect();
            is_air |= parts.iter().any(|part| part.eq_ignore_ascii_case("air"));
            let unit = parts.into_iter().find(|part| !FILLERS.contains(&part.to_lowercase().as_str()));
            let mut units: Vec<String> = unit.into_iter().map(str::to_owned).collect();
            let is_tied = quantity.is_some() || units.iter().any(|unit| AxisUnit::parse(unit).is_some());
            units.extend(outside.filter(|unit| AxisUnit::parse(unit).is_some()));
            return Self { quantity, units, is_tied, is_air };
        }
        // A name such as "A" or "m" alone is a label, not a unit.
        let units =
            outside.into_iter().filter(|unit| quantity.is_some() || unit.chars().count() > 1 || unit == "Å" || unit == "µ").collect();
        Self { quantity, is_tied: quantity.is_some(), units, is_air }
    }
}

/// Splits "wavelengthnm" or "lambdaUm" behind the quantity.
fn glued(word: &str) -> Option<(AxisQuantity, &str)> {
    let lower = word.to_lowercase();
    let starts = QUANTITIES.iter().flat_map(|(quantity, words)| words.iter().map(move |start| (*quantity, *start)));
    starts
        .filter(|(_, start)| start.chars().count() > 2 && lower.starts_with(start) && word.is_char_boundary(start.len()))
        .map(|(quantity, start)| (quantity, &word[start.len()..]))
        .find(|(_, unit)| unit.chars().count() > 1 && AxisUnit::parse(unit).is_some())
}
