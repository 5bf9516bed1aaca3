//! Units of spectral axes, in all spellings that files use, and their conversion to wavelength.
//!
//! λ = v s for lengths, 1/(v s) for wavenumbers, c/(v s) for frequencies, hc/(v s) for photon energies, where v is the
//! number in the file and s the size of its unit.

use crate::constants::{ELECTRONVOLT, PLANCK, SPEED_OF_LIGHT};

/// A unit of wavelength, wavenumber, frequency or photon energy.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisUnit {
    /// The standard spelling.
    pub name: String,
    quantity: AxisQuantity,
    size: f64,
}

/// The quantity on a spectral axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum AxisQuantity {
    /// Wavelength \[µm\].
    Wavelength,
    /// Wavenumber \[µm⁻¹\].
    Wavenumber,
    /// Frequency \[Hz\].
    Frequency,
    /// Photon energy \[eV\].
    Energy,
}

use AxisQuantity::{Energy, Frequency, Wavelength, Wavenumber};

/// Standard name, quantity, size in the quantity's unit, and further spellings in small letters.
const UNITS: &[(&str, AxisQuantity, f64, &[&str])] = &[
    (
        "angstrom",
        Wavelength,
        1e-4,
        &["angstroms", "angstroem", "angstroems", "ångström", "ångströms", "ångstrom", "ångstroms", "angström", "å", "aa", "ang", "angs"],
    ),
    ("nm", Wavelength, 1e-3, &["nanometer", "nanometers", "nanometre", "nanometres", "nanom"]),
    ("um", Wavelength, 1.0, &["micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres", "mu", "u", "mic", "mum"]),
    ("mm", Wavelength, 1e3, &["millimeter", "millimeters", "millimetre", "millimetres"]),
    ("cm", Wavelength, 1e4, &["centimeter", "centimeters", "centimetre", "centimetres"]),
    ("m", Wavelength, 1e6, &["meter", "meters", "metre", "metres"]),
    ("pm", Wavelength, 1e-6, &["picometer", "picometers", "picometre", "picometres"]),
    ("cm-1", Wavenumber, 1e-4, &["1/cm", "/cm", "kayser", "kaysers"]),
    ("um-1", Wavenumber, 1.0, &["1/um", "/um", "1/micron", "micron-1"]),
    ("m-1", Wavenumber, 1e-6, &["1/m", "/m"]),
    ("Hz", Frequency, 1.0, &["hertz", "s-1", "1/s"]),
    ("kHz", Frequency, 1e3, &[]),
    ("GHz", Frequency, 1e9, &["gigahertz"]),
    ("THz", Frequency, 1e12, &["terahertz"]),
    ("PHz", Frequency, 1e15, &[]),
    ("eV", Energy, 1.0, &["electronvolt", "electronvolts"]),
    ("keV", Energy, 1e3, &[]),
    ("Ryd", Energy, 13.605_693_122_994, &["ry", "rydberg", "rydbergs"]),
];

impl AxisUnit {
    /// The unit that a text spells, such as "Å", "Angstroem", "0.1 nm", "10^-10 m", "cm⁻¹" or "THz".
    ///
    /// Upper and lower case are one, except where prefixes differ by case: "A", "mm" and "m" are read as they are
    /// written, "M", "MM", "Mm" and "a" are none.
    pub fn parse(text: &str) -> Option<Self> {
        let text = plain(text);
        let (factor, unit) = factor(&text)?;
        let lower = unit.to_lowercase();
        let ambiguous = ["M", "MM", "Mm", "mM", "a", "PM", "Pm", "U"].contains(&unit.as_str());
        let row =
            if unit == "A" { UNITS.first() } else { UNITS.iter().find(|row| row.0.to_lowercase() == lower || row.3.contains(&&*lower)) };
        let (name, quantity, size, _) = row.filter(|_| !ambiguous)?;
        let name = if factor == 1.0 { (*name).to_owned() } else { format!("{factor} {name}") };
        Some(Self { name, quantity: *quantity, size: factor * size })
    }

    /// The quantity that the unit measures.
    pub fn quantity(&self) -> AxisQuantity {
        self.quantity
    }

    /// The wavelength of a number in this unit \[µm\].
    pub fn wavelength_um(&self, number: f64) -> f64 {
        let value = number * self.size;
        match self.quantity {
            Wavelength => value,
            Wavenumber => 1.0 / value,
            Frequency => 1e6 * SPEED_OF_LIGHT / value,
            Energy => 1e6 * PLANCK * SPEED_OF_LIGHT / (ELECTRONVOLT * value),
        }
    }

    /// True if two units are the same, however they are spelled.
    pub fn is(&self, other: &Self) -> bool {
        self.quantity == other.quantity && (self.size / other.size - 1.0).abs() < 1e-9
    }
}

/// A unit with ASCII signs: Greek letters, raised digits, carets and dots are replaced.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    for c in text.trim().trim_matches('.').chars() {
        match c {
            'µ' | 'μ' => plain.push('u'),
            '⁻' | '−' | '–' => plain.push('-'),
            '¹' => plain.push('1'),
            '⁰' => plain.push('0'),
            '^' | '{' | '}' | '(' | ')' => {}
            'Å' => plain.push('Å'),
            c => plain.push(c),
        }
    }
    plain.replace("**", "").replace("micro-", "micro")
}

/// Splits "0.1 nm", "1e-10 m" and "10-10 m" (ten to the power −10) into factor and unit.
fn factor(text: &str) -> Option<(f64, String)> {
    let Some((number, unit)) = text.split_once([' ', '*']).map(|(number, unit)| (number.trim(), unit.trim())) else {
        return Some((1.0, text.to_owned()));
    };
    let power = number.strip_prefix("10-").and_then(|power| power.parse::<i32>().ok()).map(|power| 10f64.powi(-power));
    let factor = power.or_else(|| number.parse().ok()).filter(|factor: &f64| factor.is_finite() && *factor > 0.0)?;
    Some((factor, unit.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One wavelength, 550 nm, in every unit: c, h and e of CODATA 2018 by hand.
    #[test]
    fn units_are_known_in_their_spellings() {
        for (unit, number) in [
            ("nm", 550.0),
            ("NM", 550.0),
            ("Nanometers", 550.0),
            ("A", 5500.0),
            ("Å", 5500.0),
            ("\u{212b}", 5500.0),
            ("AA", 5500.0),
            ("Ang", 5500.0),
            ("Angstroem", 5500.0),
            ("Ångström", 5500.0),
            ("ANGSTROMS", 5500.0),
            ("0.1 nm", 5500.0),
            ("1e-10 m", 5500.0),
            ("10^-10 m", 5500.0),
            ("10**-10 m", 5500.0),
            ("10⁻¹⁰ m", 5500.0),
            ("um", 0.55),
            ("µm", 0.55),
            ("μm", 0.55),
            ("µ", 0.55),
            ("mu", 0.55),
            ("Micrometers", 0.55),
            ("mic", 0.55),
            ("microns", 0.55),
            ("m", 5.5e-7),
            ("metre", 5.5e-7),
            ("mm", 5.5e-4),
            ("cm-1", 18_181.818_181_818),
            ("cm^-1", 18_181.818_181_818),
            ("cm⁻¹", 18_181.818_181_818),
            ("1/cm", 18_181.818_181_818),
            ("um-1", 1.818_181_818_2),
            ("THz", 545.077_196_363_6),
            ("Hz", 5.450_771_963_636e14),
            ("eV", 2.254_258_155),
            ("Ryd", 0.165684918),
        ] {
            let parsed = AxisUnit::parse(unit).unwrap_or_else(|| panic!("{unit}"));
            assert!((parsed.wavelength_um(number) / 0.55 - 1.0).abs() < 1e-8, "{unit}: {}", parsed.wavelength_um(number));
        }
        for unit in ["furlong", "M", "MM", "Mm", "a", "", "percent", "10 parsec", "-1 nm"] {
            assert_eq!(AxisUnit::parse(unit), None, "{unit}");
        }
    }
}
