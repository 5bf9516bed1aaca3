//! Ionised state of a gas.

use super::cloud::GasCloud;
use crate::scene::species::Emission;

/// Share of a star's photons leaving the cloud above which a note reports it.
const ESCAPED: f64 = 0.005;
/// Share of unconverged steps above which a note reports it.
const UNSETTLED: f64 = 1e-4;

/// Ionised state of a `[gas]` table.
#[derive(Debug, Clone)]
pub struct IonisedGas {
    /// The gas, and the stars that ionise it.
    pub cloud: GasCloud,
    /// Its electron temperature, weighted by n_p n_e \[K\]; nothing where no gas is ionised.
    pub temperature: Option<f64>,
    /// The density of electrons, weighted by the same \[cm⁻³\].
    pub electrons: Option<f64>,
    /// By star, the part of its ionising photons that leaves the cloud.
    pub escaped: Vec<f64>,
    /// The passes that several stars took, and the part of all ions of hydrogen that the last of them moved.
    pub passes: usize,
    /// See [`passes`](Self::passes).
    pub change: f64,
    /// Device that traced the light: the processor or a graphics device.
    pub by: String,
    /// The part of steps in which the gas did not settle.
    pub unsettled: f64,
    /// True if it was solved on few voxels, for a first look.
    pub is_rough: bool,
    /// Its species: one for each line that is seen, or some that always shine together, and one for the continuum.
    pub(in crate::scene) species: Vec<Emission>,
}

impl IonisedGas {
    /// Notes in sentences.
    pub fn notes(&self) -> Vec<String> {
        let (Some(temperature), Some(electrons)) = (self.temperature, self.electrons) else {
            return vec!["not ionised: no star has photons above 13.6 eV, or no gas is near".into()];
        };
        let mut notes = vec![format!("{temperature:.0} K and {electrons:.3e} electrons per cm3 in the ionised gas")];
        for (star, escaped) in self.cloud.stars.iter().zip(&self.escaped).filter(|(_, escaped)| **escaped > ESCAPED) {
            notes.push(format!("{:.0} % of the ionising photons of {} leave or miss the cloud", 100.0 * escaped, star.name));
        }
        if self.passes > 1 {
            notes.push(format!("{} passes on {}; the last changed {:.1e} of the ions", self.passes, self.by, self.change));
        }
        if self.unsettled > UNSETTLED {
            notes.push(format!("the gas did not converge in {:.2} % of the beam steps", 100.0 * self.unsettled));
        }
        notes
    }
}
