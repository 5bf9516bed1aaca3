//! Wavelengths in air and in vacuum.
//!
//! λ_vac = n λ_air, n − 1 = 8.06051e-5 + 2.480990e-2/(132.274 − s²) + 1.74557e-4/(39.32957 − s²), s = 1/λ_vac \[µm⁻¹\]
//!
//! Standard air of 15 °C and 1 atm: Peck & Reeder 1972 (J. Opt. Soc. Am. 62, 958), which NIST's Atomic Spectra Database
//! uses as well. Valid from 0.185 to 1.7 µm and smooth beyond; line lists give wavelengths below 0.2 µm in vacuum.

/// The shortest wavelength that lists give in air \[µm\].
pub const SHORTEST_IN_AIR_UM: f64 = 0.2;

/// The refractive index of standard air at a vacuum wavelength \[µm\].
pub fn index(vacuum_um: f64) -> f64 {
    let s2 = vacuum_um.powi(-2);
    1.0 + 8.060_51e-5 + 2.480_990e-2 / (132.274 - s2) + 1.745_57e-4 / (39.329_57 - s2)
}

/// The vacuum wavelength of an air wavelength, both \[µm\]; wavelengths below 0.2 µm are in vacuum already.
pub fn vacuum_um(air_um: f64) -> f64 {
    if air_um < SHORTEST_IN_AIR_UM {
        return air_um;
    }
    // The index changes by 1e-8 between both wavelengths: two turns suffice.
    (0..3).fold(air_um, |vacuum, _| air_um * index(vacuum))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hα, Hβ and [O III] 5007 in air and in vacuum by NIST's Atomic Spectra Database: 6562.79 and 6564.61 Å, 4861.35 and
    /// 4862.71 Å, 5006.843 and 5008.240 Å.
    #[test]
    fn lines_have_their_vacuum_wavelengths() {
        for (air, vacuum) in [(0.656_279, 0.656_461), (0.486_135, 0.486_271), (0.500_684_3, 0.500_824_0)] {
            assert!((vacuum_um(air) - vacuum).abs() < 1.5e-6, "{air}: {}", vacuum_um(air));
            assert!((air - vacuum).abs() > 1e-4);
        }
        assert_eq!(vacuum_um(0.1216), 0.1216);
    }
}
