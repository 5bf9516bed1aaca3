//! Hydrogen, and ions with one electron: recombination, its heat, and collisions.
//!
//! Sources: Hummer 1994, MNRAS 268, 109 (recombination, free-free); CHIANTI 11 (excitation); Voronov 1997, ADNDT 65, 1
//! (ionisation by electrons).

use spectra::embedded::embedded_columns;

use super::{BOLTZMANN_EV, ERG_PER_EV, HYDROGEN_EV};

const RECOMBINATION: &str = include_str!("../../data/hydrogen_recombination.csv");
const COLLISIONS: &str = include_str!("../../data/hydrogen_collisions.csv");
/// Energies of the levels 2 and 3 above the ground \[eV\].
const EXCITED_EV: [f64; 2] = [10.199, 12.088];

/// Tabulated recombination, multiplied by √T.
#[derive(Debug, Clone, Copy)]
enum RecombinationColumn {
    ToGround = 1,
    ToExcited = 2,
    CoolingToGround = 3,
    CoolingToExcited = 4,
    FreeFree = 5,
}

/// Rates of hydrogen.
#[derive(Debug)]
pub struct Hydrogen {
    /// log₁₀ T, and six columns.
    recombination: Vec<Vec<f64>>,
    /// T, and effective collision strengths to 2s, 2p, 3s, 3p, 3d.
    collisions: Vec<Vec<f64>>,
}

impl Hydrogen {
    pub(super) fn read() -> Self {
        Self {
            recombination: embedded_columns("recombination of hydrogen", RECOMBINATION, 7).expect("embedded"),
            collisions: embedded_columns("collisions of hydrogen", COLLISIONS, 6).expect("embedded"),
        }
    }

    /// Recombination to the ground level of a nucleus of charge `z` that has no electron \[cm³ s⁻¹\], at a temperature in K.
    pub fn to_ground(&self, temperature: f64, z: f64) -> f64 {
        z * self.of(RecombinationColumn::ToGround, temperature / (z * z))
    }

    /// Recombination to all levels but the ground (case B) of a nucleus of charge `z` that has no electron \[cm³ s⁻¹\].
    pub fn case_b(&self, temperature: f64, z: f64) -> f64 {
        z * self.of(RecombinationColumn::ToExcited, temperature / (z * z))
    }

    /// The kinetic energy that case B takes from electrons of density one and such nuclei of density one
    /// \[erg cm³ s⁻¹\].
    pub fn case_b_cooling(&self, temperature: f64, z: f64) -> f64 {
        z * self.of(RecombinationColumn::CoolingToExcited, temperature / (z * z)) * BOLTZMANN_EV * ERG_PER_EV * temperature
    }

    /// Kinetic energy loss by recombination to the ground level of a nucleus of charge `z`, per electron and nucleus \[erg cm³ s⁻¹\].
    pub fn to_ground_cooling(&self, temperature: f64, z: f64) -> f64 {
        z * self.of(RecombinationColumn::CoolingToGround, temperature / (z * z)) * BOLTZMANN_EV * ERG_PER_EV * temperature
    }

    /// Energy of bremsstrahlung beside ions of charge `z` \[erg cm³ s⁻¹\].
    pub fn free_free(&self, temperature: f64, z: f64) -> f64 {
        z * self.of(RecombinationColumn::FreeFree, temperature / (z * z)) * BOLTZMANN_EV * ERG_PER_EV * temperature
    }

    /// Energy of the lines that electrons excite in H⁰ \[erg cm³ s⁻¹\].
    pub fn excitation(&self, temperature: f64) -> f64 {
        let strength = |column: usize| interpolated(&self.collisions[0], &self.collisions[column], temperature);
        let to = |level: usize, columns: std::ops::Range<usize>| {
            let energy = EXCITED_EV[level];
            columns.map(strength).sum::<f64>() * (-energy / (BOLTZMANN_EV * temperature)).exp() * energy * ERG_PER_EV
        };
        // 8.629e-6 g₁⁻¹ T^(−1/2) Υ, g₁ = 2: Osterbrock & Ferland 2006, (3.20).
        8.629e-6 / 2.0 / temperature.sqrt() * (to(0, 1..3) + to(1, 3..6))
    }

    /// Ionisation of H⁰ by electrons \[cm³ s⁻¹\].
    pub fn collisional(&self, temperature: f64) -> f64 {
        let u = HYDROGEN_EV / (BOLTZMANN_EV * temperature);
        2.91e-8 * u.powf(0.39) * (-u).exp() / (0.232 + u)
    }

    fn of(&self, column: RecombinationColumn, temperature: f64) -> f64 {
        interpolated(&self.recombination[0], &self.recombination[column as usize], temperature.log10()) / temperature.sqrt()
    }
}

/// The cubic through the four samples around a place, those at the end outside of them.
fn interpolated(x: &[f64], y: &[f64], at: f64) -> f64 {
    let at = at.clamp(x[0], x[x.len() - 1]);
    let first = x.partition_point(|v| *v <= at).saturating_sub(2).min(x.len() - 4);
    let (x, y) = (&x[first..first + 4], &y[first..first + 4]);
    let weight = |i: usize| (0..4).filter(|j| *j != i).map(|j| (at - x[j]) / (x[i] - x[j])).product::<f64>();
    (0..4).map(|i| y[i] * weight(i)).sum()
}
