//! A cloud in three dimensions, and stars in it.

use glam::DVec3;
use spectra::constants::PARSEC;

use crate::atoms::{ELEMENTS, Element};
use crate::balance::{Accuracy, Diffuse, Gas};
use crate::error::IonisationError;
use crate::light::IonisingLight;
pub use crate::quantity::Quantity;

/// Centimetres in a parsec.
pub const PARSEC_CM: f64 = 100.0 * PARSEC;
/// The densest gas that is taken as such \[cm⁻³\].
const DENSEST: f32 = 1e12;

/// A density on a grid of voxels.
#[derive(Debug, Clone)]
pub struct Cloud<'a> {
    /// Voxels along x, y and z.
    pub dims: [usize; 3],
    /// The lowest corner \[pc\].
    pub low: DVec3,
    /// The edges of a voxel \[pc\].
    pub voxel: DVec3,
    /// Nuclei of hydrogen, x fastest \[cm⁻³\].
    pub hydrogen: &'a [f32],
    /// Nuclei of each element for one of hydrogen.
    pub abundances: [f64; ELEMENTS],
    /// Dust absorption cross-section of ionising light per hydrogen nucleus \[cm²\].
    pub dust_cm2: f64,
}

/// A star: its place \[pc\], and its light in nodes that all stars have in common ([`IonisingLight::several`]).
#[derive(Debug, Clone, Copy)]
pub struct Star<'a> {
    /// Position \[pc\].
    pub place: DVec3,
    /// Ionising part of its light.
    pub light: &'a IonisingLight,
}

/// Settings of the solver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Treatment of diffuse light.
    pub diffuse: Diffuse,
    /// A temperature that all gas is held at \[K\], in place of the one at which heating and cooling are in balance.
    pub isothermal: Option<f64>,
    /// How exact beams are.
    pub accuracy: Accuracy,
    /// Convergence threshold with several stars: the part of all ions of hydrogen that a pass moves \[1\].
    pub change: f64,
    /// Passes at most; of several stars two are made at least.
    pub passes: usize,
    /// Bytes that may be taken.
    pub memory_limit: u64,
}

impl Default for Settings {
    fn default() -> Self {
        let (diffuse, accuracy) = (Diffuse::default(), Accuracy::FAST);
        Self { diffuse, isothermal: None, accuracy, change: 4e-3, passes: 30, memory_limit: 4 << 30 }
    }
}

/// Ionised cloud.
#[derive(Debug, Clone, Default)]
pub struct Ionised {
    /// By quantity its mean in each voxel.
    pub quantities: Vec<Vec<f32>>,
    /// The passes that were made.
    pub passes: usize,
    /// Change in the last pass, relative to all hydrogen ions \[1\].
    pub change: f64,
    /// By star, the part of its ionising photons that leaves the cloud; one for a star that has none \[1\].
    pub escaped: Vec<f64>,
    /// The steps that beams made in the last pass.
    pub steps: u64,
    /// Of those, in how many the gas did not settle.
    pub unsettled: u64,
    /// Device that traced light through the gas: the processor or a graphics device.
    pub by: String,
}

/// Hears how much of how much work is done, and says whether it is to go on.
pub type Watch<'a> = &'a (dyn Fn(u64, u64) -> bool + Sync);

impl Cloud<'_> {
    /// The gas of a voxel.
    pub(crate) fn gas(&self, voxel: usize, settings: &Settings) -> Gas {
        let gas = Gas::new(f64::from(self.hydrogen[voxel]), self.abundances);
        Gas { dust_cm2: self.dust_cm2, isothermal: settings.isothermal, ..gas }
    }

    /// Refuses what cannot be solved.
    pub(crate) fn check(&self, stars: &[Star], settings: &Settings, quantities: usize) -> Result<(), IonisationError> {
        let cells = self.dims.iter().try_fold(1usize, |cells, edge| cells.checked_mul(*edge));
        if cells != Some(self.hydrogen.len()) || self.hydrogen.is_empty() {
            return Err(IonisationError::Length { found: self.hydrogen.len(), dims: self.dims });
        }
        if !(self.voxel.is_finite() && self.voxel.min_element() > 0.0 && self.low.is_finite()) {
            return Err(IonisationError::Voxel(self.voxel));
        }
        if let Some(i) = self.hydrogen.iter().position(|n| !(0.0..=DENSEST).contains(n)) {
            return Err(IonisationError::Density { voxel: place_of(self.dims, i), value: self.hydrogen[i] });
        }
        for (element, value) in Element::ALL.into_iter().zip(self.abundances) {
            let allowed = match element {
                Element::Hydrogen => 1.0..=1.0,
                Element::Helium => 0.0..=10.0,
                _ => 0.0..=0.1,
            };
            if !allowed.contains(&value) {
                return Err(IonisationError::Abundance { element: element.symbol(), value });
            }
        }
        if !(0.0..f64::INFINITY).contains(&self.dust_cm2) {
            return Err(IonisationError::Dust(self.dust_cm2));
        }
        for (number, star) in stars.iter().enumerate() {
            if !star.place.is_finite() {
                return Err(IonisationError::Place { star: number, place: star.place });
            }
            if star.light.energies_ev != stars[0].light.energies_ev {
                return Err(IonisationError::Nodes(number));
            }
        }
        let nodes = stars.first().map_or(0, |star| star.light.energies_ev.len());
        let (cells, bytes) = (self.hydrogen.len(), Self::bytes(self.hydrogen.len(), stars.len(), nodes, quantities));
        if bytes > settings.memory_limit {
            return Err(IonisationError::Memory { stars: stars.len(), cells, bytes, limit: settings.memory_limit });
        }
        Ok(())
    }

    /// The highest corner \[pc\].
    pub(crate) fn high(&self) -> DVec3 {
        self.low + self.voxel * DVec3::from(self.dims.map(|n| n as f64))
    }
}

/// Means over blocks of a given number of voxels along each edge, and how many blocks there are; beyond the last voxel of an edge there
/// is nothing.
pub fn block_means(dims: [usize; 3], values: &[f32], block: usize) -> ([usize; 3], Vec<f32>) {
    let blocks = dims.map(|n| n.div_ceil(block));
    let (mut means, part) = (vec![0.0; blocks.iter().product()], 1.0 / block.pow(3) as f32);
    values.iter().enumerate().for_each(|(i, value)| means[block_of(dims, blocks, block, i)] += part * value);
    (blocks, means)
}

/// Position of a cell along x, y and z.
pub(crate) fn place_of([nx, ny, _]: [usize; 3], cell: usize) -> [usize; 3] {
    [cell % nx, cell / nx % ny, cell / (nx * ny)]
}

/// The block that a voxel is in.
pub(crate) fn block_of(dims: [usize; 3], blocks: [usize; 3], block: usize, voxel: usize) -> usize {
    let [x, y, z] = place_of(dims, voxel).map(|place| place / block);
    (z * blocks[1] + y) * blocks[0] + x
}
