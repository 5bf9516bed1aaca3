//! Gas on voxels, and the stars that ionise it.

use glam::DVec3;
use ionisation::atoms::{ELEMENTS, EmissionLine, LineTable};
use ionisation::balance::{Accuracy, Diffuse};
use ionisation::cloud::{Cloud, Ionised, Quantity, Settings, Star as Source, block_means};
use ionisation::error::IonisationError;
use ionisation::light::{IonisingLight, Photons};
use ionisation::tracer::RayTracer;
use spectra::constants::{ELECTRONVOLT, PLANCK, SPEED_OF_LIGHT};

use super::Star;
use crate::control::{Control, Stage};
use crate::field::Lattice;
use crate::geometry::Bounds;

/// Photons of a star, in parts of those of all, with which it is left out.
const FAINTEST: f64 = 1e-6;
/// Energies at which a star's photons are looked at \[eV\], before it is known whether it has any.
const LOOKED_AT: [f64; 8] = [14.0, 16.0, 19.0, 23.0, 28.0, 36.0, 50.0, 80.0];
/// The energy of a photon of 1 µm \[eV\].
const EV_UM: f64 = 1e6 * PLANCK * SPEED_OF_LIGHT / ELECTRONVOLT;

/// A star that has ionising photons.
#[derive(Debug, Clone)]
pub struct IonisingStar {
    /// Name in the scene.
    pub name: String,
    /// Position \[pc\].
    pub position: DVec3,
    /// Ionising light at nodes shared by all stars.
    pub light: IonisingLight,
}

impl IonisingStar {
    /// Those of some stars that have ionising photons.
    pub fn of(stars: &[Star]) -> Vec<Self> {
        let most = |star: &Star| LOOKED_AT.into_iter().map(photons(star)).fold(0.0, f64::max);
        let all: f64 = stars.iter().map(most).sum();
        let stars: Vec<&Star> = stars.iter().filter(|star| most(star) > FAINTEST * all).collect();
        let spectra: Vec<_> = stars.iter().map(|star| photons(star)).collect();
        let known: Vec<Photons> = spectra.iter().map(|spectrum| spectrum as Photons).collect();
        let lights = IonisingLight::several(&known);
        stars.into_iter().zip(lights).map(|(star, light)| Self { name: star.name.clone(), position: star.position, light }).collect()
    }
}

/// A star's photons at an energy in eV \[s⁻¹ eV⁻¹\].
fn photons(star: &Star) -> impl Fn(f64) -> f64 + use<'_> {
    |energy| {
        let per_um = star.spectrum.continuum(EV_UM / energy);
        // |dλ/dE| = λ/E.
        per_um * EV_UM / (energy * energy) / (energy * ELECTRONVOLT)
    }
}

/// Gas on voxels, and the stars that ionise it.
#[derive(Debug, Clone)]
pub struct GasCloud {
    /// The voxels.
    pub lattice: Lattice,
    /// Nuclei of hydrogen in each, x fastest \[cm⁻³\].
    pub hydrogen: Vec<f32>,
    /// Nuclei of H, He, C, N, O, Ne, Mg, Si and S for one of hydrogen.
    pub abundances: [f64; ELEMENTS],
    /// Dust absorption cross-section of ionising light per hydrogen nucleus \[cm²\].
    pub dust_cm2: f64,
    /// A temperature that all of it is held at \[K\], in place of the one at which heating and cooling are in balance.
    pub isothermal: Option<f64>,
    /// Treatment of diffuse light.
    pub diffuse: Diffuse,
    /// The stars that have ionising photons.
    pub stars: Vec<IonisingStar>,
    /// Bytes that may be taken.
    pub memory_limit: u64,
}

impl GasCloud {
    /// Bytes for solving it and storing a number of quantities.
    pub fn bytes(&self, quantities: usize) -> u64 {
        let nodes = self.stars.first().map_or(0, |star| star.light.energies_ev.len());
        Cloud::bytes(self.lattice.cells(), self.stars.len(), nodes, quantities)
    }

    /// Variant on means of blocks of voxels, so that its longest edge has at most a number.
    #[must_use]
    pub fn coarser(self, edge: usize) -> Self {
        let [nx, ny, nz] = self.lattice.dims;
        let block = nx.max(ny).max(nz).div_ceil(edge);
        if block < 2 {
            return self;
        }
        let (dims, hydrogen) = block_means(self.lattice.dims, &self.hydrogen, block);
        let high = self.lattice.bounds.low + self.lattice.voxel_pc() * DVec3::from(dims.map(|n| (n * block) as f64));
        let lattice = Lattice { dims, bounds: Bounds { high, ..self.lattice.bounds } };
        Self { lattice, hydrogen, ..self }
    }

    /// Electrons for one nucleus of hydrogen at most: two of helium, five of each metal.
    pub fn electrons(&self) -> f64 {
        let [hydrogen, helium, metals @ ..] = self.abundances;
        hydrogen + 2.0 * helium + 5.0 * metals.iter().sum::<f64>()
    }

    /// The densest of its voxels \[cm⁻³\].
    pub fn densest(&self) -> f64 {
        self.hydrogen.iter().fold(0.0f32, |most, n| most.max(*n)).into()
    }

    /// The most that a line of a table can send out of it \[erg cm⁻³ s⁻¹\].
    pub fn most(&self, table: &LineTable, line: &EmissionLine) -> f64 {
        let densest = self.densest();
        self.electrons() * densest * densest * self.abundances[line.element as usize] * table.brightest(line)
    }

    /// Ionised state: the mean of each quantity in each voxel, and what there is to tell. Light of several stars goes
    /// through it by a `tracer`, or on the processor.
    ///
    /// # Errors
    /// If the gas or the stars are none that there can be, or take more memory than is allowed, or `control` stopped it.
    pub fn ionised(
        &self,
        quantities: &[Quantity],
        accuracy: Accuracy,
        tracer: Option<&dyn RayTracer>,
        control: &Control,
    ) -> Result<Ionised, IonisationError> {
        let sources: Vec<Source> = self.stars.iter().map(|star| Source { place: star.position, light: &star.light }).collect();
        let Lattice { dims, bounds } = self.lattice;
        let (voxel, hydrogen) = (self.lattice.voxel_pc(), &self.hydrogen[..]);
        let cloud = Cloud { dims, low: bounds.low, voxel, hydrogen, abundances: self.abundances, dust_cm2: self.dust_cm2 };
        let (diffuse, isothermal, memory_limit) = (self.diffuse, self.isothermal, self.memory_limit);
        let settings = Settings { diffuse, isothermal, accuracy, memory_limit, ..Settings::default() };
        let watch = |done: u64, all: u64| {
            control.report(Stage::Gas, done, all);
            !control.interrupted()
        };
        cloud.ionised_by(tracer, &sources, &settings, quantities, &watch)
    }
}
