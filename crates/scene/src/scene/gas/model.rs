//! Gas of a scene: its density and composition, from which stars derive its glow.

use std::sync::Arc;

use ionisation::atoms::ELEMENTS;
use ionisation::balance::{Accuracy, Diffuse, Gas as Matter, GasState};
use ionisation::cloud::Quantity;
use ionisation::error::IonisationError;
use spectra::fingerprint::{Digest, Fingerprint};
use spectra::nebular::recombination_continuum;
use spectra::passband::Passband;
use spectra::spectrum::Spectrum;
use spectra::units::{NumberDensity, Temperature, Velocity};

use super::solution::{Solution, Solved, Solver};
use super::species::Species;
use super::{ABUNDANCE_SETS, DUST_ABSORPTION, GasCloud, IonisedGas, IonisingStar, TEMPERATURE, VOXELS, VoxelGas};
use crate::cache::PAIRS;
use crate::error::{Error, Result};
use crate::field::{Field, Grid, IntoField, Lattice, fingerprint};
use crate::memory;
use crate::scene::{Emission, Motion, Star, star};

/// Stars that ionise a gas at most.
const MOST_STARS: usize = 64;
/// Voxels along the longest edge of a function that does not say how many.
pub(super) const VOXELS_OF_FUNCTION: usize = 96;
/// Number of quantities tabulated in addition to the species.
const BESIDE: usize = 4;
/// A species with less than this part of the light in every passband is left out.
const DARK: f64 = 1e-3;
/// Voxels along the longest edge for a first look.
const ROUGH: usize = 48;

/// Gas that the stars of a scene ionise, as `[gas]` states it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Gas {
    /// Density of hydrogen nuclei \[cm⁻³\].
    pub density: Arc<dyn Field>,
    /// Nuclei of H, He, C, N, O, Ne, Mg, Si and S per hydrogen nucleus.
    pub abundances: [f64; ELEMENTS],
    /// Voxels along the longest edge; `None` for those of a grid, otherwise 96.
    pub voxels: Option<usize>,
    /// Dust absorption cross section for ionising light per hydrogen nucleus \[cm²\].
    pub dust_cm2: f64,
    /// Fixed electron temperature; `None` for thermal equilibrium.
    pub temperature: Option<Temperature>,
    /// Treatment of recombination light.
    pub diffuse: Diffuse,
    /// Turbulent full width at half maximum of the lines.
    pub doppler_fwhm: Velocity,
    /// Velocity, which shifts the lines; `None` for gas at rest.
    pub motion: Option<Motion>,
}

/// Fingerprint of what the glow of a gas depends on beside the gas.
pub(in crate::scene) fn sources(stars: &[Star], bands: &[Passband]) -> Fingerprint {
    let mut digest = Digest::new("sources");
    digest.part(star::fingerprint(stars));
    for band in bands {
        digest.part(band.fingerprint());
    }
    digest.finish()
}

impl Gas {
    /// Gas of a density of hydrogen nuclei \[cm⁻³\] with Orion's abundances, in thermal equilibrium, without dust or turbulence.
    pub fn new(density: impl IntoField) -> Self {
        Self {
            density: density.into_field(),
            abundances: ABUNDANCE_SETS[0].values,
            voxels: None,
            dust_cm2: 0.0,
            temperature: None,
            diffuse: Diffuse::Outward,
            doppler_fwhm: Velocity(0.0),
            motion: None,
        }
    }

    /// Copy of the gas on voxels, this many along the longest edge.
    #[must_use]
    pub fn with_voxels(self, voxels: usize) -> Self {
        Self { voxels: Some(voxels), ..self }
    }

    /// Copy of the gas with other abundances: nuclei of H, He, C, N, O, Ne, Mg, Si and S per hydrogen nucleus.
    #[must_use]
    pub fn with_abundances(self, abundances: [f64; ELEMENTS]) -> Self {
        Self { abundances, ..self }
    }

    /// Copy of the gas at a fixed electron temperature.
    #[must_use]
    pub fn with_temperature(self, temperature: Temperature) -> Self {
        Self { temperature: Some(temperature), ..self }
    }

    /// Copy of the gas with dust that absorbs ionising light, by its cross section per hydrogen nucleus \[cm²\].
    #[must_use]
    pub fn with_dust_absorption(self, dust_cm2: f64) -> Self {
        Self { dust_cm2, ..self }
    }

    /// Copy of the gas in motion.
    #[must_use]
    pub fn with_motion(self, motion: Motion) -> Self {
        Self { motion: Some(motion), ..self }
    }

    /// Fingerprint of all that its state depends on beside the stars and passbands.
    pub(in crate::scene) fn fingerprint(&self) -> Fingerprint {
        let Self { density, abundances, voxels, dust_cm2, temperature, diffuse, doppler_fwhm, motion } = self;
        let mut digest = Digest::new("gas");
        digest.part(fingerprint(&**density)).numbers(abundances).plain(voxels).number(*dust_cm2);
        digest.plain(temperature).plain(diffuse).plain(doppler_fwhm);
        Motion::content(motion.as_ref(), &mut digest);
        digest.finish()
    }

    /// Refuses what no scene file may state.
    fn check(&self) -> Result<()> {
        self.voxels.map_or(Ok(()), |voxels| VOXELS.check(voxels as f64))?;
        DUST_ABSORPTION.check(self.dust_cm2)?;
        self.temperature.map_or(Ok(()), |temperature| TEMPERATURE.check(temperature.0))?;
        if self.abundances[0] == 1.0 && self.abundances.iter().all(|abundance| *abundance >= 0.0 && abundance.is_finite()) {
            return Ok(());
        }
        Err(Error::conflict("the abundances of the gas are out of range", "give 1 for hydrogen and at least 0 for the others"))
    }

    /// The edge of its smallest voxel \[pc\].
    pub(in crate::scene) fn voxel_pc(&self) -> f64 {
        match (self.density.grid(), self.voxels) {
            (Some(grid), None) => grid.lattice().voxel_pc().min_element(),
            (_, voxels) => self.density.bounds().size().max_element() / voxels.unwrap_or(VOXELS_OF_FUNCTION) as f64,
        }
    }

    /// The gas on voxels with the stars that ionise it.
    fn cloud(&self, stars: &[Star], solver: &Solver) -> Result<GasCloud> {
        let Self { density, voxels, abundances, dust_cm2, diffuse, .. } = self;
        let stars = IonisingStar::of(stars);
        if stars.len() > MOST_STARS {
            let problem = format!("{} stars ionise the gas, at most {MOST_STARS} are supported", stars.len());
            return Err(Error::conflict(problem, "remove faint stars or merge some"));
        }
        // For a first look a grid is taken as it is, to be made coarser, and a function is not asked at more places than needed.
        let is_native = |grid: &&Grid| solver.is_rough || voxels.is_none_or(|voxels| grid.lattice().dims.into_iter().max() == Some(voxels));
        let voxels = voxels.unwrap_or(VOXELS_OF_FUNCTION).min(if solver.is_rough { ROUGH } else { usize::MAX });
        let grid = density.grid().filter(is_native);
        let lattice = grid.map_or_else(|| Lattice::along(density.bounds(), voxels), |grid| grid.lattice().clone());
        let mut cloud = GasCloud {
            lattice,
            hydrogen: Vec::new(),
            abundances: *abundances,
            dust_cm2: *dust_cm2,
            isothermal: self.temperature.map(|temperature| temperature.0),
            diffuse: *diffuse,
            stars,
            memory_limit: solver.memory_limit,
        };
        memory::check("gas ionised by the stars", cloud.bytes(BESIDE), solver.memory_limit)?;
        cloud.hydrogen = match grid {
            Some(grid) => grid.values().into_owned(),
            None => Grid::from_function(density, cloud.lattice.clone(), 1.0, solver.cache, solver.control)?.values().into_owned(),
        };
        Ok(cloud)
    }

    /// A species of the gas, which moves as the gas does.
    fn species(&self, name: String, density: Arc<dyn Field>, spectrum: Spectrum) -> Emission {
        Emission { name, density, spectrum, motion: self.motion.clone() }
    }

    /// Ionised state of the gas, and the species that glow in some passbands.
    ///
    /// # Errors
    /// More than 64 ionising stars, more memory than is allowed, densities that are none, and interruption by the user.
    pub(in crate::scene) fn ionised_by(&self, stars: &[Star], bands: &[Passband], solver: &Solver) -> Result<VoxelGas> {
        self.check()?;
        let mut cloud = self.cloud(stars, solver)?;
        if solver.is_rough {
            cloud = cloud.coarser(ROUGH);
        }
        let species = Species::seen(bands);
        memory::check("gas ionised by the stars", cloud.bytes(species.len() + BESIDE), solver.memory_limit)?;
        let densest = cloud.densest();
        let functions: Vec<_> = species
            .iter()
            .map(|species| move |gas: &Matter, state: &GasState| state.emission(gas, species.table, species.lines[0]))
            .collect();
        let mut quantities: Vec<Quantity> = species
            .iter()
            .zip(&functions)
            .map(|(species, value)| Quantity { most: cloud.most(species.table, species.lines[0]), value })
            .collect();
        let pairs = |gas: &Matter, state: &GasState| state.pairs(gas);
        let most = cloud.electrons() * densest * densest;
        let warm = |gas: &Matter, state: &GasState| pairs(gas, state) * state.temperature;
        let thick = |gas: &Matter, state: &GasState| pairs(gas, state) * state.electrons;
        let ionised = |_: &Matter, state: &GasState| state.ionised();
        quantities.push(Quantity { most, value: &pairs });
        quantities.push(Quantity { most: 1.0, value: &ionised });
        quantities.push(Quantity { most: 6e4 * most, value: &warm });
        quantities.push(Quantity { most: cloud.electrons() * densest * most, value: &thick });
        let accuracy = if solver.is_rough { Accuracy::COARSE } else { Accuracy::FAST };
        let names = species.iter().map(Species::identifier).chain([PAIRS, "ionised"].map(str::to_owned)).collect::<Vec<_>>();
        let solution = Solution { cloud: &cloud, names: &names, pairs: species.len(), accuracy };
        let Solved { mut quantities, temperature, electrons, state } =
            solution.found(&quantities, solver).map_err(|error| match error {
                IonisationError::Stopped => Error::Interrupted,
                error => Error::conflict(error.to_string(), "change the density or the stars"),
            })?;
        let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
        let [ionised, pairs] = std::array::from_fn(|_| quantities.pop().unwrap_or_default());
        let through =
            |band: &Passband| species.iter().zip(&quantities).map(|(species, values)| species.through(band) * sum(values)).collect();
        let by_band: Vec<Vec<f64>> = bands.iter().map(through).collect();
        let is_bright = |i: usize| by_band.iter().any(|light| light[i] > DARK * light.iter().sum::<f64>());
        let unknown = VoxelGas::unknown(&cloud.lattice);
        let (mut glow, mut light) = (Vec::new(), Vec::new());
        for (_, (species, values)) in species.iter().zip(quantities).enumerate().filter(|(i, _)| is_bright(*i)) {
            let thermal = species.thermal_fwhm(temperature.unwrap_or_default());
            let spectrum = species.spectrum().broadened(thermal).broadened(self.doppler_fwhm);
            glow.push(self.species(species.name(), unknown.clone(), spectrum));
            light.push(values);
        }
        if let (Some(temperature), Some(electrons)) = (temperature, electrons) {
            let at = (Temperature(temperature.clamp(6000.0, 15_000.0)), NumberDensity(electrons.clamp(100.0, 1e4)));
            let spectrum = recombination_continuum(at.0, at.1)?;
            glow.push(self.species("hydrogen's continuum".into(), unknown, spectrum));
            light.push(pairs);
        }
        let unsettled = state.unsettled as f64 / state.steps.max(1) as f64;
        let (escaped, passes, change, by) = (state.escaped, state.passes, state.change, state.by);
        let gas =
            IonisedGas { cloud, temperature, electrons, escaped, passes, change, by, unsettled, is_rough: solver.is_rough, species: glow };
        Ok(VoxelGas { gas, light, ionised })
    }
}
