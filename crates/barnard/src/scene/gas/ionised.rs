//! What stars have made of a gas.

use std::sync::Arc;

use spectra::spectrum::Spectrum;

use super::cloud::GasCloud;
use crate::field::Field;

/// A species of a gas: its name, its density, and the emission coefficient of density 1 \[W m⁻³ sr⁻¹ µm⁻¹, lines W m⁻³ sr⁻¹\].
pub type Glow = (String, Arc<dyn Field>, Spectrum);

/// The part of a star's photons that leaves the cloud which is told.
const ESCAPED: f64 = 0.005;
/// The part of steps that did not settle which is told.
const UNSETTLED: f64 = 1e-4;

/// What the stars make of a `[gas]` table.
#[derive(Debug)]
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
    /// Who had light go through it: the processor or a device.
    pub by: String,
    /// The part of steps in which the gas did not settle.
    pub unsettled: f64,
    /// Whether it was solved on few voxels, for a first look.
    pub is_rough: bool,
    /// Its species: one for each line that is seen, or some that always shine together, and one for the continuum.
    pub(in crate::scene) species: Vec<Glow>,
}

impl IonisedGas {
    /// What is to be known of it, in sentences.
    pub fn told(&self) -> Vec<String> {
        let (Some(temperature), Some(electrons)) = (self.temperature, self.electrons) else {
            return vec!["no star ionises it: none has photons above 13.6 eV, or no gas is near".into()];
        };
        let mut told = vec![format!("{temperature:.0} K and {electrons:.3e} electrons per cm3 where it is ionised")];
        for (star, escaped) in self.cloud.stars.iter().zip(&self.escaped).filter(|(_, escaped)| **escaped > ESCAPED) {
            told.push(format!("{:.0} % of the ionising photons of {} leave the cloud, or miss it", 100.0 * escaped, star.name));
        }
        if self.passes > 1 {
            told.push(format!("{} passes on {}; the last of them moved {:.1e} of its ions", self.passes, self.by, self.change));
        }
        if self.unsettled > UNSETTLED {
            told.push(format!("in {:.2} % of the steps of beams the gas did not settle", 100.0 * self.unsettled));
        }
        told
    }
}
