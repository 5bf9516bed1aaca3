//! Solved gas as means over voxels, and means over several moments.

use std::sync::Arc;

use rayon::prelude::*;

use super::front::Fronts;
use super::ionised::IonisedGas;
use crate::error::Result;
use crate::field::{Grid, Lattice};
use crate::scene::species::Emission;
use crate::scene::star::{self, Star};

/// Solved gas as means over voxels, before its fronts are placed.
#[derive(Debug, Clone)]
pub(in crate::scene) struct VoxelGas {
    /// Ionised state; its species are those of `light`, without densities.
    pub gas: IonisedGas,
    /// Density of each species by voxel.
    pub light: Vec<Vec<f32>>,
    /// Ionised fraction of hydrogen by voxel \[1\].
    pub ionised: Vec<f32>,
}

impl VoxelGas {
    /// The gas between this one and a later one, at a fraction of the way \[1\]: each species in proportion. Its notes are those of
    /// this one.
    pub fn mixed(mut self, later: &Self, fraction: f64) -> Self {
        let blend = |earlier: &mut [f32], later: Option<&Vec<f32>>| {
            let earlier = earlier.par_iter_mut();
            match later {
                Some(later) => earlier.zip(later).for_each(|(value, other)| *value += fraction as f32 * (other - *value)),
                None => earlier.for_each(|value| *value *= (1.0 - fraction) as f32),
            }
        };
        blend(&mut self.ionised, Some(&later.ionised));
        let number = |species: &[Emission], name: &str| species.iter().position(|known| known.name == name);
        for (species, light) in self.gas.species.iter().zip(&mut self.light) {
            blend(light, number(&later.gas.species, &species.name).map(|number| &later.light[number]));
        }
        for (species, light) in later.gas.species.iter().zip(&later.light) {
            if number(&self.gas.species, &species.name).is_none() {
                self.gas.species.push(species.clone());
                self.light.push(light.par_iter().map(|value| fraction as f32 * value).collect());
            }
        }
        self
    }

    /// The gas with densities that end at its fronts.
    pub fn with_fronts(self) -> IonisedGas {
        let Self { mut gas, light, ionised } = self;
        let fronts = Fronts::new(&gas.cloud.lattice, ionised);
        gas.species.iter_mut().zip(light).for_each(|(species, light)| species.density = Arc::new(fronts.shaded(light)));
        gas
    }

    /// Placeholder for the densities of `gas`.
    pub fn unknown(lattice: &Lattice) -> Arc<Grid> {
        Arc::new(Grid::from_lattice(Lattice { dims: [1; 3], bounds: lattice.bounds }, vec![0.0]))
    }
}

/// Mean of the gas over the stars of several moments. Equal stars in a row are solved once.
pub(in crate::scene) fn mean(moments: &[&[Star]], solve: impl Fn(&[Star]) -> Result<VoxelGas>) -> Result<VoxelGas> {
    let mut mean = solve(moments[0])?;
    let mut latest: Option<VoxelGas> = None;
    for (number, pair) in moments.windows(2).enumerate() {
        if star::fingerprint(pair[0]) != star::fingerprint(pair[1]) {
            latest = Some(solve(pair[1])?);
        }
        // Stars that have not changed yet are those of the first moment, of which the mean consists.
        if let Some(latest) = &latest {
            mean = mean.mixed(latest, 1.0 / (number as f64 + 2.0));
        }
    }
    Ok(mean)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use spectra::passband::Passband;

    use super::*;
    use crate::control::Control;
    use crate::fixtures;
    use crate::scene::Gas;
    use crate::scene::gas::Solver;

    /// A mixture has each species in proportion, also those that one of both lacks.
    #[test]
    fn mixtures_are_in_proportion() {
        let bands = [Passband::by_name("hst-wfc3-f502n").unwrap(), Passband::by_name("hst-wfc3-f656n").unwrap()];
        let solve = |kelvin: f64| {
            let stars = [fixtures::star(kelvin, 1e4, DVec3::ZERO)];
            let solver = Solver { is_rough: false, memory_limit: 1 << 30, tracer: None, cache: None, control: &Control::default() };
            Gas::new(fixtures::ball(1.0)).with_voxels(8).ionised_by(&stars, &bands, &solver).unwrap()
        };
        let (cold, hot) = (solve(15_000.0), solve(60_000.0));
        let names = |gas: &VoxelGas| gas.gas.species.iter().map(|species| species.name.clone()).collect::<Vec<_>>();
        let light = |gas: &VoxelGas, name: &str, voxel: usize| {
            names(gas).iter().position(|known| known == name).map_or(0.0, |number| gas.light[number][voxel])
        };
        assert_ne!(names(&cold), names(&hot));
        let mixed = cold.clone().mixed(&hot, 0.25);
        for name in [names(&cold), names(&hot)].concat() {
            for voxel in 0..512 {
                let wanted = 0.75 * light(&cold, &name, voxel) + 0.25 * light(&hot, &name, voxel);
                assert!((light(&mixed, &name, voxel) - wanted).abs() <= 1e-6 * wanted, "{name} {voxel}");
            }
        }
        let ionised = |gas: &VoxelGas| gas.ionised.iter().sum::<f32>();
        assert!((ionised(&mixed) - 0.75 * ionised(&cold) - 0.25 * ionised(&hot)).abs() < 1e-2 && ionised(&hot) > ionised(&cold));
    }
}
