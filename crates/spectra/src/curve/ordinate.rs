//! The second column of a curve: its quantity, its unit, and what that unit means.
//!
//! A flux density per frequency becomes one per wavelength by F_λ ∝ F_ν/λ², one of photons by F_λ ∝ N_λ/λ.

use super::cell::base_name;
use super::columns::Column;

/// The quantity of a curve's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ordinate {
    /// Throughput of a filter, 0 to 1.
    Throughput,
    /// Flux density of a star per wavelength, of which the shape counts alone.
    FluxDensity,
    /// Strength of emission per nm.
    StrengthPerNm,
    /// Albedo, 0 to 1.
    Albedo,
    /// Mean cosine of scattering angles, −1 to 1.
    MeanCosine,
}

/// Factor of a column's values, by the power of the wavelength that goes with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    size: f64,
    power: i32,
    words: &'static str,
}

impl Scale {
    const ONE: Self = Self { size: 1.0, power: 0, words: "" };

    /// The factor of a value at a wavelength \[µm\].
    pub fn factor(&self, lambda_um: f64) -> f64 {
        self.size * lambda_um.powi(self.power)
    }

    /// The conversion in words, behind the column's name.
    pub fn words(&self) -> String {
        if self.words.is_empty() { String::new() } else { format!(" ({})", self.words) }
    }
}

impl Ordinate {
    /// The name of the quantity in messages.
    pub fn name(self) -> &'static str {
        match self {
            Ordinate::Throughput => "throughput",
            Ordinate::FluxDensity => "flux",
            Ordinate::StrengthPerNm => "strength",
            Ordinate::Albedo => "albedo",
            Ordinate::MeanCosine => "mean cosine",
        }
    }

    /// True if files call the quantity by this name, in small letters.
    pub(super) fn is_named(self, name: &str) -> bool {
        let names: &[&str] = match self {
            Ordinate::Throughput => {
                &["throughput", "transmission", "transmittance", "response", "trans", "sensitivity", "efficiency", "t", "r"]
            }
            Ordinate::FluxDensity => &["flux", "flam", "f_lambda", "flux_density", "flambda", "l_lambda", "radiance", "intensity"],
            Ordinate::StrengthPerNm => &["strength", "emissivity", "intensity", "flux"],
            Ordinate::Albedo => &["albedo", "omega", "single_scattering_albedo"],
            Ordinate::MeanCosine => &["g", "mean_cosine", "asymmetry", "cos", "<cos>"],
        };
        names.contains(&name)
    }

    /// The factor that makes the quantity of a column's values.
    ///
    /// # Errors
    /// If the column states a unit that the quantity cannot have.
    pub fn scale(self, column: &Column) -> Result<Scale, String> {
        let bracket = column.name.split_once(['[', '(']).map(|(_, rest)| rest.trim_end_matches([']', ')']).trim());
        let stated = column.unit.as_deref().map(str::trim).or(bracket).filter(|unit| !unit.is_empty());
        let name = base_name(&column.name);
        let is_percent = |text: &str| ["%", "percent", "pct", "per cent"].contains(&text.to_lowercase().as_str());
        let named_percent = name.split(|c: char| c.is_whitespace() || c == '_').any(is_percent) || name.starts_with('%');
        let unit = stated.unwrap_or(if named_percent { "%" } else { "" });
        let plain =
            ["", "1", "-", "--", "dimensionless", "unitless", "none", "null", "adimensional"].contains(&unit.to_lowercase().as_str());
        match self {
            Ordinate::Throughput | Ordinate::Albedo | Ordinate::MeanCosine => {
                let electrons = ["electron/photon", "e-/photon", "e/photon", "electron / photon", "e- / photon", "electron/ph", "e-/ph"];
                if is_percent(unit) {
                    Ok(Scale { size: 0.01, power: 0, words: "percent" })
                } else if plain || (self == Ordinate::Throughput && electrons.contains(&unit.to_lowercase().as_str())) || !is_unit_like(unit) {
                    Ok(Scale::ONE)
                } else {
                    Err(format!("a {} in \"{unit}\" is unsupported; use a fraction or percent", self.name()))
                }
            }
            Ordinate::FluxDensity if plain => flux_by_name(&name),
            Ordinate::FluxDensity => flux_density(unit).ok_or_else(|| {
                format!("unknown unit \"{unit}\" of a flux density; use one such as erg/s/cm2/angstrom, W/m2/um, FLAM, Jy, FNU, photons/s/cm2/angstrom or PHOTLAM")
            }),
            Ordinate::StrengthPerNm => match unit.to_lowercase().replace(' ', "").as_str() {
                _ if plain => Ok(Scale::ONE),
                "/nm" | "1/nm" | "nm-1" | "nm^-1" => Ok(Scale::ONE),
                "/um" | "1/um" | "um-1" | "um^-1" => Ok(Scale { size: 1e-3, power: 0, words: "per um" }),
                "/angstrom" | "1/angstrom" | "angstrom-1" | "/a" | "1/a" | "a-1" => Ok(Scale { size: 10.0, power: 0, words: "per angstrom" }),
                _ => Err(format!("a strength in \"{unit}\" is unsupported; use per nm, um or angstrom, times the key scale")),
            },
        }
    }
}

/// The conversion that the name of a flux column without a unit asks for, in small letters.
fn flux_by_name(name: &str) -> Result<Scale, String> {
    let plain: String = name.chars().filter(|c| c.is_alphanumeric()).collect();
    let has = |known: &[&str]| known.contains(&plain.as_str());
    if name.split(|c: char| !c.is_alphanumeric()).any(|word| ["mag", "mags", "abmag", "stmag", "magnitude"].contains(&word)) {
        return Err("magnitudes are not a flux density; convert them first".into());
    }
    if has(&["fnu", "fluxnu", "lnu", "fν", "flux_nu"]) {
        return Ok(PER_FREQUENCY);
    }
    if has(&["lambdaflambda", "lamflam", "lambdaf", "nufnu", "nulnu", "lambdallambda", "νfν", "λfλ"]) {
        return Ok(Scale { size: 1.0, power: -1, words: "lambda F_lambda, converted to F_lambda" });
    }
    Ok(if has(&["photlam", "photons", "photonflux"]) { PHOTONS } else { Scale::ONE })
}

/// True if words in brackets behind a dimensionless column may be a unit, not a remark such as "total system".
fn is_unit_like(text: &str) -> bool {
    let symbols = flux_symbols(text);
    !symbols.is_empty() && symbols.iter().all(|(symbol, _)| SYMBOLS.contains(&symbol.as_str()))
}

/// Symbols of units that flux densities and responses are written in, in small letters.
const SYMBOLS: [&str; 36] = [
    "erg",
    "ergs",
    "j",
    "w",
    "kw",
    "mw",
    "lsun",
    "s",
    "sec",
    "h",
    "cm",
    "m",
    "mm",
    "um",
    "nm",
    "micron",
    "angstrom",
    "angstroms",
    "å",
    "a",
    "aa",
    "hz",
    "ghz",
    "thz",
    "jy",
    "mjy",
    "ujy",
    "kjy",
    "sr",
    "ph",
    "photon",
    "photons",
    "arcsec",
    "ev",
    "mag",
    "abmag",
];

/// The symbols of a compound unit with their exponents: "erg/s/cm2/A", "erg s-1 cm^-2 A**-1", "erg/(s cm2 A)".
pub fn unit_symbols(text: &str) -> Vec<(String, i32)> {
    let mut symbols: Vec<(String, i32)> = Vec::new();
    let text =
        text.replace("**", "^").replace("Å", "angstrom").replace(['µ', 'μ'], "u").replace('⁻', "-").replace('²', "2").replace('¹', "1");
    let (mut sign, mut inside) = (1, false);
    let mut word = String::new();
    let push = |word: &mut String, sign: i32, symbols: &mut Vec<(String, i32)>| {
        let end = word.find(|c: char| !c.is_alphabetic()).unwrap_or(word.len());
        let power = word[end..].trim_start_matches('^').trim_matches(['(', ')']);
        let power = if power.is_empty() { Some(1) } else { power.parse().ok() };
        if end > 0 {
            symbols.push((word[..end].to_owned(), sign * power.unwrap_or(0)));
        }
        word.clear();
    };
    for c in text.chars() {
        match c {
            '/' | ' ' | '*' | '.' | '(' | ')' => {
                push(&mut word, sign, &mut symbols);
                match c {
                    '/' => sign = -1,
                    '(' => inside = true,
                    ')' => inside = false,
                    _ if !inside => sign = 1,
                    _ => {}
                }
            }
            c => word.push(c),
        }
    }
    push(&mut word, sign, &mut symbols);
    symbols
}

const PER_WAVELENGTH: Scale = Scale::ONE;
const PER_FREQUENCY: Scale = Scale { size: 1.0, power: -2, words: "per frequency, converted to per wavelength" };
const PHOTONS: Scale = Scale { size: 1.0, power: -1, words: "photons, converted to energy" };

/// Symbols in small letters.
fn flux_symbols(text: &str) -> Vec<(String, i32)> {
    unit_symbols(text).into_iter().map(|(symbol, power)| (symbol.to_lowercase(), power)).collect()
}

/// The conversion of a flux density to one per wavelength; only its shape is kept.
fn flux_density(unit: &str) -> Option<Scale> {
    match unit.to_lowercase().as_str() {
        "flam" => return Some(PER_WAVELENGTH),
        "fnu" => return Some(PER_FREQUENCY),
        "photlam" => return Some(PHOTONS),
        "photnu" => return Some(Scale { power: -3, ..PHOTONS }),
        _ => {}
    }
    let symbols = flux_symbols(unit);
    if symbols.is_empty() || symbols.iter().any(|(symbol, power)| !SYMBOLS.contains(&symbol.as_str()) || *power == 0) {
        return None;
    }
    let power = |names: &[&str]| symbols.iter().filter(|(symbol, _)| names.contains(&symbol.as_str())).map(|(_, power)| power).sum::<i32>();
    let energy = power(&["erg", "ergs", "j", "w", "kw", "mw", "lsun", "ev"]);
    let photons = power(&["ph", "photon", "photons"]);
    let length = power(&["angstrom", "angstroms", "å", "a", "aa", "nm", "um", "micron", "mm"]);
    let frequency = power(&["hz", "ghz", "thz"]);
    let jansky = power(&["jy", "mjy", "ujy", "kjy"]);
    // W m-3 is a flux density per metre of wavelength.
    let cubic = power(&["m"]) == -3 || power(&["cm"]) == -3;
    match (energy, photons, length, frequency, jansky) {
        (1, 0, -1, 0, 0) => Some(PER_WAVELENGTH),
        (1, 0, 0, 0, 0) if cubic => Some(PER_WAVELENGTH),
        (1, 0, 0, -1, 0) | (0, 0, 0, 0, 1) => Some(PER_FREQUENCY),
        (0, 1, -1, 0, 0) => Some(PHOTONS),
        (0, 1, 0, -1, 0) => Some(Scale { power: -3, ..PHOTONS }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flux_densities_become_per_wavelength() {
        for (unit, power) in [
            ("erg/s/cm2/A", 0),
            ("erg s-1 cm-2 Angstrom-1", 0),
            ("erg/(s cm^2 Å)", 0),
            ("W m-2 um-1", 0),
            ("W/m2/nm", 0),
            ("W m-3", 0),
            ("FLAM", 0),
            ("Jy", -2),
            ("mJy", -2),
            ("erg/s/cm2/Hz", -2),
            ("fnu", -2),
            ("photon/s/cm2/A", -1),
            ("PHOTLAM", -1),
            ("ph s**-1 cm**-2 nm**-1", -1),
        ] {
            assert_eq!(flux_density(unit).map(|scale| scale.power), Some(power), "{unit}");
        }
        for unit in ["mag", "abmag", "furlong", "erg", "counts", "W/m2", "Jy/Hz"] {
            assert_eq!(flux_density(unit), None, "{unit}");
        }
    }
}
