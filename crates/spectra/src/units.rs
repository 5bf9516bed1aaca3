//! Quantities that cannot be confused: newtypes that parse and print with their units.
//!
//! `"656.3 nm".parse::<Wavelength>()`; the value is kept in the house's internal unit (µm, pc, K, W …),
//! which each type names. A_λ = 1.0857 τ_λ is exactly why these are types and not floats.

use crate::constants::*;
use crate::error::SpectraError;
pub use crate::number::short;

/// A number with a unit: what it is called and in which units it may be written.
pub trait Quantity: Copy + Sized {
    /// The name of the quantity in messages.
    const NAME: &'static str;
    /// A value as it is well written.
    const EXAMPLE: &'static str;
    /// Unit names, the one for printing first, with their sizes in the internal unit.
    const UNITS: &'static [(&'static str, f64)];

    /// Makes the quantity of a number in the internal unit.
    fn from_internal(value: f64) -> Self;
    /// The number in the internal unit.
    fn internal(self) -> f64;

    /// Reads "NUMBER UNIT".
    ///
    /// # Errors
    /// If the text has no number, an unknown unit or none, or is not finite.
    fn parse(text: &str) -> Result<Self, SpectraError> {
        let (number, unit) = split(text.trim());
        let wrong = |reason: String| SpectraError::Quantity { text: text.to_owned(), quantity: Self::NAME, reason, example: Self::EXAMPLE };
        let value: f64 = number.parse().map_err(|_| wrong("it does not start with a number".into()))?;
        Self::in_unit(value, unit).map_err(|error| match error {
            SpectraError::Quantity { reason, .. } => wrong(reason),
            other => other,
        })
    }

    /// The quantity of a number in the unit called `unit`.
    ///
    /// # Errors
    /// If the unit is unknown or empty, or the number is not finite.
    fn in_unit(value: f64, unit: &str) -> Result<Self, SpectraError> {
        let wrong = |reason: String| SpectraError::Quantity {
            text: format!("{value} {unit}"),
            quantity: Self::NAME,
            reason,
            example: Self::EXAMPLE,
        };
        let size = Self::unit_size(unit).ok_or_else(|| {
            let known: Vec<&str> = Self::UNITS.iter().map(|(n, _)| *n).collect();
            let has = if unit.is_empty() { "it has no unit".to_owned() } else { format!("unknown unit \"{unit}\"") };
            wrong(format!("{has}, known: {}", known.join(", ")))
        })?;
        if !value.is_finite() {
            return Err(wrong("it is not a finite number".into()));
        }
        Ok(Self::from_internal(value * size))
    }

    /// The size of the unit called `name` in the internal unit.
    fn unit_size(name: &str) -> Option<f64> {
        let name = normalised(name);
        Self::UNITS.iter().find(|(n, _)| normalised(n) == name).map(|(_, size)| *size)
    }
}

/// Splits "656.3 nm" or "656.3nm" behind the number.
fn split(text: &str) -> (&str, &str) {
    let in_number = |(i, c): (usize, char)| {
        c.is_ascii_digit()
            || matches!(c, '.' | '+' | '-')
            || (matches!(c, 'e' | 'E') && text[i + 1..].starts_with(|d: char| d.is_ascii_digit() || d == '-' || d == '+') && i > 0)
    };
    let end = text.char_indices().find(|&ic| !in_number(ic)).map_or(text.len(), |(i, _)| i);
    let (number, unit) = text.split_at(end);
    (number, unit.trim())
}

/// Unit names without spaces, carets, brackets and Greek: "µm" and "um", "mag cm^2" and "mag cm2", "m^(-3)" and "m⁻³"
/// are one.
fn normalised(unit: &str) -> String {
    unit.chars()
        .filter(|c| !c.is_whitespace() && !"^*(){}".contains(*c))
        .map(|c| match c {
            'µ' | 'μ' => 'u',
            '²' => '2',
            '³' => '3',
            '⁻' | '−' => '-',
            'Å' => 'A',
            c => c,
        })
        .collect()
}

macro_rules! quantity {
    ($(#[$doc:meta])* $type:ident($name:literal, $example:literal) { $($unit:literal = $size:expr),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
        pub struct $type(pub f64);

        impl Quantity for $type {
            const NAME: &'static str = $name;
            const EXAMPLE: &'static str = $example;
            const UNITS: &'static [(&'static str, f64)] = &[$(($unit, $size)),+];
            fn from_internal(value: f64) -> Self { Self(value) }
            fn internal(self) -> f64 { self.0 }
        }

        impl std::str::FromStr for $type {
            type Err = SpectraError;
            fn from_str(text: &str) -> Result<Self, SpectraError> { Self::parse(text) }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                let (unit, size) = Self::UNITS[0];
                write!(f, "{} {unit}", short(rounded(self.0 / size)))
            }
        }
    };
}

/// Twelve significant digits: enough for any input, few enough to hide the conversion's last bit.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

const CM: f64 = 0.01 / PARSEC;

quantity! {
    /// A wavelength in vacuum or air, as its source states \[µm\].
    Wavelength("wavelength", "656.3 nm") { "nm" = 1e-3, "um" = 1.0, "angstrom" = 1e-4, "A" = 1e-4, "AA" = 1e-4, "mm" = 1e3, "m" = 1e6 }
}
quantity! {
    /// A length or distance \[pc\].
    Length("length", "0.4 pc") {
        "pc" = 1.0, "kpc" = 1e3, "Mpc" = 1e6, "ly" = LIGHT_YEAR / PARSEC, "lyr" = LIGHT_YEAR / PARSEC, "au" = ASTRONOMICAL_UNIT / PARSEC, "AU" = ASTRONOMICAL_UNIT / PARSEC,
        "m" = 1.0 / PARSEC, "km" = 1e3 / PARSEC, "cm" = CM, "mm" = 0.1 * CM, "um" = 1e-4 * CM, "Rsun" = SOLAR_RADIUS / PARSEC
    }
}
quantity! {
    /// A temperature \[K\].
    Temperature("temperature", "39000 K") { "K" = 1.0, "kK" = 1e3 }
}
quantity! {
    /// A bolometric luminosity \[W\].
    Luminosity("luminosity", "2e5 Lsun") { "Lsun" = SOLAR_LUMINOSITY, "W" = 1.0, "erg/s" = 1e-7 }
}
quantity! {
    /// A luminosity per wavelength [W µm⁻¹].
    SpectralLuminosity("spectral luminosity", "1e29 W/nm") { "W/um" = 1.0, "W/nm" = 1e3, "W/m" = 1e-6, "erg/s/angstrom" = 1e-3, "Lsun/um" = SOLAR_LUMINOSITY }
}
quantity! {
    /// A magnitude or an extinction in magnitudes (mag).
    Magnitude("magnitude", "5 mag") { "mag" = 1.0, "mmag" = 1e-3 }
}
quantity! {
    /// An angle \[rad\].
    Angle("angle", "32 deg") {
        "deg" = std::f64::consts::PI / 180.0, "rad" = 1.0, "arcmin" = std::f64::consts::PI / 10_800.0,
        "arcsec" = std::f64::consts::PI / 648_000.0, "mas" = std::f64::consts::PI / 648e6
    }
}
quantity! {
    /// An extinction coefficient at V [pc⁻¹]; written as optical depth or magnitudes (A_V) per length.
    ExtinctionCoefficient("extinction per length", "2 mag/pc") {
        "/pc" = 1.0, "1/pc" = 1.0, "pc-1" = 1.0, "mag/pc" = 1.0 / MAGNITUDES_PER_DEPTH, "mag/kpc" = 1e-3 / MAGNITUDES_PER_DEPTH,
        "/kpc" = 1e-3, "/cm" = 1.0 / CM, "/m" = PARSEC, "mag/cm" = 1.0 / (CM * MAGNITUDES_PER_DEPTH)
    }
}
quantity! {
    /// An amount of memory \[bytes\].
    MemorySize("memory size", "512 MiB") {
        "MiB" = 1_048_576.0, "GiB" = 1_073_741_824.0, "KiB" = 1024.0, "B" = 1.0, "kB" = 1e3, "MB" = 1e6, "GB" = 1e9
    }
}
quantity! {
    /// Extinction at V per column of hydrogen, times one cm⁻³ [pc⁻¹ cm³]: the dust-to-gas ratio in A_V/N_H or
    /// cross-section a nucleon.
    ExtinctionPerColumn("extinction per hydrogen column", "5.32e-22 mag cm2") {
        "mag cm2" = 1.0 / (CM * MAGNITUDES_PER_DEPTH), "cm2" = 1.0 / CM, "m2" = 1e4 / CM
    }
}
quantity! {
    /// A number density [cm⁻³].
    NumberDensity("number density", "600 cm-3") { "cm-3" = 1.0, "/cm3" = 1.0, "1/cm3" = 1.0, "m-3" = 1e-6, "/m3" = 1e-6, "1/m3" = 1e-6, "pc-3" = CM * CM * CM }
}
quantity! {
    /// A mass density [g cm⁻³].
    MassDensity("mass density", "2.3e-21 g/cm3") {
        "g/cm3" = 1.0, "g cm-3" = 1.0, "kg/m3" = 1e-3, "kg m-3" = 1e-3, "Msun/pc3" = SOLAR_MASS * 1e3 * CM * CM * CM, "Msun pc-3" = SOLAR_MASS * 1e3 * CM * CM * CM
    }
}
quantity! {
    /// Extinction at V per column of mass, times one g cm⁻³ \[pc⁻¹ g⁻¹ cm³\]: the opacity of dust and gas together.
    ExtinctionPerMass("extinction per mass", "200 cm2/g") { "cm2/g" = 1.0 / CM, "m2/kg" = 10.0 / CM, "mag cm2/g" = 1.0 / (CM * MAGNITUDES_PER_DEPTH) }
}
quantity! {
    /// A velocity [km s⁻¹].
    Velocity("velocity", "20 km/s") { "km/s" = 1.0, "m/s" = 1e-3 }
}
quantity! {
    /// A time \[s\].
    Time("time", "2.5 s") {
        "s" = 1.0, "ms" = 1e-3, "min" = 60.0, "h" = 3600.0, "d" = 86_400.0, "day" = 86_400.0, "yr" = JULIAN_YEAR, "kyr" = 1e3 * JULIAN_YEAR, "Myr" = 1e6 * JULIAN_YEAR
    }
}
quantity! {
    /// A radiance per wavelength [W m⁻² sr⁻¹ µm⁻¹].
    SpectralRadiance("spectral radiance", "1e-7 W/m2/sr/um") {
        "W/m2/sr/um" = 1.0, "W/m2/sr/nm" = 1e3, "erg/s/cm2/sr/angstrom" = 10.0, "erg/s/cm2/sr/um" = 1e-3
    }
}
quantity! {
    /// A volume emission coefficient [W m⁻³ sr⁻¹].
    Emissivity("emission coefficient", "1e-25 W/m3/sr") { "W/m3/sr" = 1.0, "erg/s/cm3/sr" = 0.1, "W/m2/sr/pc" = 1.0 / PARSEC }
}
quantity! {
    /// A density of objects on the sky [sr⁻¹].
    SkyDensity("density on the sky", "2000 /deg2") { "/deg2" = 3_282.806_350_011_744, "/arcmin2" = 3_282.806_350_011_744 * 3600.0, "/sr" = 1.0 }
}

quantity! {
    /// An area \[m²\].
    Area("area", "4.5 m2") { "m2" = 1.0, "cm2" = 1e-4 }
}
quantity! {
    /// A charge, as a number of electrons (e).
    Charge("charge", "3.1 e") { "e" = 1.0, "electron" = 1.0, "ke" = 1e3 }
}
quantity! {
    /// A charge that a pixel gathers in a time [e s⁻¹].
    DarkCurrent("dark current", "0.002 e/s") { "e/s" = 1.0, "electron/s" = 1.0, "e/h" = 1.0 / 3600.0 }
}
quantity! {
    /// The charge of a count [e ADU⁻¹].
    Gain("gain", "1.5 e/ADU") { "e/ADU" = 1.0, "electron/adu" = 1.0 }
}
quantity! {
    /// A number that a converter gives (ADU).
    Counts("counts", "500 ADU") { "ADU" = 1.0, "adu" = 1.0 }
}
quantity! {
    /// A rate of hits on an area [cm⁻² s⁻¹].
    HitRate("rate of hits", "1.2 /cm2/s") { "/cm2/s" = 1.0, "cm-2 s-1" = 1.0, "/cm2/min" = 1.0 / 60.0 }
}

/// Notation of a quantity.
#[derive(Debug, Clone, Copy)]
pub struct QuantityRow {
    /// The name of the quantity.
    pub name: &'static str,
    /// A value as it is well written.
    pub example: &'static str,
    /// Unit names, the one for printing first, with their sizes in the internal unit.
    pub units: &'static [(&'static str, f64)],
}

impl QuantityRow {
    /// The row of a quantity.
    pub const fn of<Q: Quantity>() -> Self {
        Self { name: Q::NAME, example: Q::EXAMPLE, units: Q::UNITS }
    }

    /// The size of the unit called `name` in the internal unit.
    pub fn unit_size(&self, name: &str) -> Option<f64> {
        let name = normalised(name);
        self.units.iter().find(|(unit, _)| normalised(unit) == name).map(|(_, size)| *size)
    }

    /// A number in the internal unit, in words with the first unit.
    pub fn words(&self, internal: f64) -> String {
        let (unit, size) = self.units[0];
        format!("{} {unit}", short(rounded(internal / size)))
    }
}

/// All quantities.
pub const QUANTITIES: &[QuantityRow] = &[
    QuantityRow::of::<Wavelength>(),
    QuantityRow::of::<Length>(),
    QuantityRow::of::<Angle>(),
    QuantityRow::of::<Temperature>(),
    QuantityRow::of::<Velocity>(),
    QuantityRow::of::<Time>(),
    QuantityRow::of::<Luminosity>(),
    QuantityRow::of::<SpectralLuminosity>(),
    QuantityRow::of::<Magnitude>(),
    QuantityRow::of::<SpectralRadiance>(),
    QuantityRow::of::<ExtinctionCoefficient>(),
    QuantityRow::of::<ExtinctionPerColumn>(),
    QuantityRow::of::<ExtinctionPerMass>(),
    QuantityRow::of::<NumberDensity>(),
    QuantityRow::of::<MassDensity>(),
    QuantityRow::of::<Emissivity>(),
    QuantityRow::of::<SkyDensity>(),
    QuantityRow::of::<Area>(),
    QuantityRow::of::<Charge>(),
    QuantityRow::of::<DarkCurrent>(),
    QuantityRow::of::<Gain>(),
    QuantityRow::of::<Counts>(),
    QuantityRow::of::<HitRate>(),
    QuantityRow::of::<MemorySize>(),
];

/// Splits "656.3 nm" into its number and its unit; none where there is no number.
pub fn parts(text: &str) -> Option<(f64, &str)> {
    let (number, unit) = split(text.trim());
    Some((number.parse().ok()?, unit))
}

impl Luminosity {
    /// So many times the sun's.
    pub fn suns(number: f64) -> Self {
        Self(number * SOLAR_LUMINOSITY)
    }
}

impl Wavelength {
    /// The wavelength in nanometres.
    pub fn from_nm(nm: f64) -> Self {
        Self(nm * 1e-3)
    }
    /// The wavelength in nanometres \[nm\].
    pub fn nm(self) -> f64 {
        self.0 * 1e3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_and_prints() {
        assert!(("656.3 nm".parse::<Wavelength>().unwrap().0 - 0.6563).abs() < 1e-15);
        assert_eq!("656.3nm".parse::<Wavelength>().unwrap().to_string(), "656.3 nm");
        assert_eq!("6563 Å".parse::<Wavelength>().unwrap().to_string(), "656.3 nm");
        assert_eq!("39000 K".parse::<Temperature>().unwrap().to_string(), "39000 K");
        assert_eq!("0.4 pc".parse::<Length>().unwrap().to_string(), "0.4 pc");
        assert_eq!("1e250 pc".parse::<Length>().unwrap().to_string(), "1e250 pc");
        assert_eq!("5 mag".parse::<Magnitude>().unwrap().0, 5.0);
        assert_eq!("-1.5e2 mag".parse::<Magnitude>().unwrap().0, -150.0);
        assert!(("1e-25 erg/s/cm3/sr".parse::<Emissivity>().unwrap().0 - 1e-26).abs() < 1e-40);
    }

    /// A_V = 1.0857 τ (2.5 log₁₀ e), and N_H for A_V = 1 mag at 5.32e-22 mag cm² is 1.88e21 cm⁻².
    #[test]
    fn magnitudes_are_not_depths() {
        let coefficient = "1.0857362047581296 mag/pc".parse::<ExtinctionCoefficient>().unwrap();
        assert!((coefficient.0 - 1.0).abs() < 1e-12);
        let per_column = "5.32e-22 mag cm2".parse::<ExtinctionPerColumn>().unwrap();
        let column_per_pc_at_1cm3 = PARSEC * 100.0;
        assert!((per_column.0 * 1.085_736_204_758_129_6 / (5.32e-22 * column_per_pc_at_1cm3) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn errors_say_what_would_be_right() {
        let message = "32 pc".parse::<Angle>().unwrap_err().to_string();
        assert!(message.contains("unknown unit \"pc\"") && message.contains("32 deg"), "{message}");
        assert!("".parse::<Length>().is_err());
        assert!("12".parse::<Length>().unwrap_err().to_string().contains("no unit"));
        assert!("nan pc".parse::<Length>().is_err());
        assert!("1e999 pc".parse::<Length>().is_err());
    }
}
