//! Ionised state of a gas.

use std::sync::Arc;

use rayon::prelude::*;

use super::cloud::GasCloud;
use crate::field::{Field, Grid};
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
    /// The gas between this one and a later one, at a part of the way \[1\]: each species in proportion. Its notes are those of this one.
    pub(in crate::scene) fn mixed(&self, later: &Self, part: f64) -> Self {
        let mut species = Vec::new();
        let scaled = |density: &Arc<dyn Field>, factor: f64| -> Vec<f32> {
            let values = density.grid().map(|grid| grid.values().into_owned()).unwrap_or_default();
            values.into_par_iter().map(|value| (f64::from(value) * factor) as f32).collect()
        };
        let mut add = |emission: &Emission, values: Vec<f32>| {
            species.push(Emission { density: Arc::new(Grid::from_lattice(self.cloud.lattice.clone(), values)), ..emission.clone() });
        };
        for earlier in &self.species {
            let mut values = scaled(&earlier.density, 1.0 - part);
            if let Some(other) = later.species.iter().find(|other| other.name == earlier.name) {
                values.par_iter_mut().zip(scaled(&other.density, part)).for_each(|(value, other)| *value += other);
            }
            add(earlier, values);
        }
        for new in later.species.iter().filter(|new| self.species.iter().all(|known| known.name != new.name)) {
            add(new, scaled(&new.density, part));
        }
        Self { species, ..self.clone() }
    }

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

/// The cubic B-spline of values at their own voxels: each is shared with its neighbours, by 1/6, 2/3 and 1/6 along each axis; their sum
/// stays. Skins of ionised gas are thinner than voxels: read between voxels as they are, they would be rows of cubes.
pub(super) fn softened(dims: [usize; 3], mut values: Vec<f32>) -> Vec<f32> {
    let [nx, ny, nz] = dims;
    let mut shared = vec![0.0; values.len()];
    // What would leave at an edge stays in the last voxel.
    let around = |i: usize, count: usize| (i.saturating_sub(1), (i + 1).min(count - 1));
    let mean = |before: f32, here: f32, after: f32| (before + after + 4.0 * here) / 6.0;
    for axis in 0..3 {
        shared.par_chunks_exact_mut(nx).enumerate().for_each(|(number, out)| {
            let (y, z) = (number % ny, number / ny);
            let row = |y: usize, z: usize| &values[(z * ny + y) * nx..][..nx];
            let here = row(y, z);
            let (before, after) = match axis {
                0 => {
                    for (x, out) in out.iter_mut().enumerate() {
                        let (before, after) = around(x, nx);
                        *out = mean(here[before], here[x], here[after]);
                    }
                    return;
                }
                1 => {
                    let (before, after) = around(y, ny);
                    (row(before, z), row(after, z))
                }
                _ => {
                    let (before, after) = around(z, nz);
                    (row(y, before), row(y, after))
                }
            };
            let rows = before.iter().zip(here).zip(after);
            out.iter_mut().zip(rows).for_each(|(out, ((before, here), after))| *out = mean(*before, *here, *after));
        });
        std::mem::swap(&mut values, &mut shared);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The light of a voxel goes to its neighbours, by the product of three rows of weights, and none is lost, at corners either.
    #[test]
    fn softening_keeps_all_light() {
        let dims = [4, 3, 5];
        for (voxel, expected) in [(17, 8.0 / 27.0), (0, 125.0 / 216.0)] {
            let mut values = vec![0.0; 60];
            values[voxel] = 8.0;
            let soft = softened(dims, values);
            assert!(
                (soft.iter().sum::<f32>() - 8.0).abs() < 1e-5 && (soft[voxel] / 8.0 - expected).abs() < 1e-6,
                "{voxel}: {}",
                soft[voxel]
            );
        }
        assert!(softened(dims, vec![3.0; 60]).iter().all(|v| (v - 3.0).abs() < 1e-6));
    }
}
