//! Free–free and free–bound light of hydrogen in the infrared, in closed form.
//!
//! ε_ν = ε_0 T^(−1/2) e^(−hν/kT) (g_ff + Σ_(n ≥ n_1) 2 θ/n³ e^(θ/n²) g_n),    θ = hν_1/kT
//!
//! g_ff = ln(e + exp(5.960 − (√3/π) ln(ν_9 T_4^(−3/2)))),    g_n = 1 − 0.3456 (λR)^(−1/3) (λR/n² − 1/2)
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | ε | emissivity for n_e n_H⁺ = 1 cm⁻⁶; ε_0 is 6.842e-38 | erg cm³ s⁻¹ Hz⁻¹ |
//! | T, T_4 | `kelvin`, in 10⁴ K | K |
//! | ν, ν_9 | frequency, in GHz | Hz |
//! | n_1 | the lowest level that such photons can free electrons from: λR ≤ n² | 1 |
//! | R, hν_1 | Rydberg's constant and energy | cm⁻¹, eV |
//!
//! Osterbrock & Ferland 2006, Astrophysics of Gaseous Nebulae, section 4.3 and appendix; g_ff of Draine 2011, Physics of the
//! Interstellar and Intergalactic Medium, eq. 10.9; g_n of Menzel & Pekeris 1935 as in Gray 2005, Observation and Analysis of
//! Stellar Photospheres, eq. 8.5. Valid from 2 µm to 1 mm for 5000 to 20 000 K.

/// ε_0 \[erg cm³ s⁻¹ Hz⁻¹ K^½\].
const SCALE: f64 = 6.842e-38;
/// h c/k \[µm K\].
const SECOND_UM_K: f64 = 14_387.768_8;
/// Rydberg's constant for hydrogen \[µm⁻¹\].
const RYDBERG_PER_UM: f64 = 10.967_758_34;
/// The speed of light \[µm s⁻¹\].
const LIGHT_UM_PER_S: f64 = 2.997_924_58e14;
/// Levels that are summed one by one; those above are an integral.
const LEVELS: u32 = 64;

/// The emissivity for each wavelength \[erg cm³ s⁻¹ Å⁻¹\] at a temperature \[K\] and a wavelength \[µm\].
pub fn emissivity(kelvin: f64, lambda_um: f64) -> f64 {
    let per_hz = SCALE / kelvin.sqrt()
        * (-SECOND_UM_K / (lambda_um * kelvin)).exp()
        * (free_free(kelvin, lambda_um) + free_bound(kelvin, lambda_um));
    // ε_λ = ε_ν c/λ², and 10⁴ Å are 1 µm.
    per_hz * LIGHT_UM_PER_S / lambda_um.powi(2) * 1e-4
}

/// The wavelength from which on light leaves level `n` alone \[µm\].
pub fn edge_um(n: u32) -> f64 {
    f64::from(n).powi(2) / RYDBERG_PER_UM
}

fn free_free(kelvin: f64, lambda_um: f64) -> f64 {
    let ghz = LIGHT_UM_PER_S / lambda_um * 1e-9;
    let slope = 3f64.sqrt() / std::f64::consts::PI;
    (std::f64::consts::E + (5.960 - slope * (ghz * (kelvin * 1e-4).powf(-1.5)).ln()).exp()).ln()
}

fn free_bound(kelvin: f64, lambda_um: f64) -> f64 {
    let theta = SECOND_UM_K * RYDBERG_PER_UM / kelvin;
    let reach = lambda_um * RYDBERG_PER_UM;
    let gaunt = |n: f64| 1.0 - 0.3456 * reach.powf(-1.0 / 3.0) * (reach / (n * n) - 0.5);
    let level = |n: f64| 2.0 * theta / n.powi(3) * (theta / (n * n)).exp() * gaunt(n);
    let first = (reach.sqrt() * (1.0 - 1e-12)).ceil() as u32;
    let last = first.max(1) + LEVELS;
    // Beyond, Σ 2 θ/n³ is θ/(n − ½)².
    let rest = theta / (f64::from(last) + 0.5).powi(2) * gaunt(f64::INFINITY);
    (first.max(1)..=last).map(|n| level(f64::from(n))).sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At radio frequencies the Gaunt factor is that of Osterbrock & Ferland 2006, eq. 4.22: √3/π (17.7 + ln(T^1.5/ν)).
    #[test]
    fn gaunt_factors_are_those_of_radio_astronomy() {
        for (kelvin, ghz) in [(1e4f64, 10.0f64), (8e3, 30.0), (1.2e4, 30.0)] {
            let radio = 3f64.sqrt() / std::f64::consts::PI * (17.7 + (kelvin.powf(1.5) / (ghz * 1e9)).ln());
            let found = free_free(kelvin, LIGHT_UM_PER_S / (ghz * 1e9));
            assert!((found / radio - 1.0).abs() < 0.02, "{kelvin} {ghz}: {found} {radio}");
        }
    }

    /// The sum over levels does not hang on where the integral takes over, and light grows by each level that can be freed.
    #[test]
    fn levels_are_summed_to_the_end() {
        let theta = SECOND_UM_K * RYDBERG_PER_UM / 1e4;
        let all: f64 = (8..200_000).map(|n| 2.0 * theta / f64::from(n).powi(3) * (theta / f64::from(n).powi(2)).exp()).sum();
        // At 5 µm from level 8 on, without the factors g_n, which are between 0.9 and 1.05 there.
        let found = free_bound(1e4, 5.0);
        assert!((found / all - 1.0).abs() < 0.1, "{found} {all}");
        for n in [8, 9, 12] {
            let (below, above) = (emissivity(1e4, edge_um(n) * 0.999_99), emissivity(1e4, edge_um(n) * 1.000_01));
            assert!(below > 1.005 * above, "{n}: {below} {above}");
        }
    }
}
