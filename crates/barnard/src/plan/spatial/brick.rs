//! The space of a brick: what a march reads of a part of a volume that nobody holds as a whole.

use std::ops::Range;
use std::sync::Arc;

use super::{Bricks, Channel, SpatialPlan, Volume};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Field, Grid, Lattice};
use crate::memory;
use crate::plan::{Options, star_depths};
use crate::scene::Scene;
use crate::volume::MAX_CHANNELS;

/// Values at the voxels of a brick and its halo; each has depth × height × width values, x running fastest.
#[derive(Debug, Clone, Default)]
pub struct BrickFields {
    /// The extinction σ at V [pc⁻¹]; nothing where there is no dust.
    pub dust: Option<Vec<f32>>,
    /// The optical depth at V from each star at voxel centres, as sweeps make it \[1\]; none where there is no dust.
    pub star_depths: Vec<Vec<f32>>,
    /// The density of each glowing species, in its own unit.
    pub gas: Vec<Vec<f32>>,
}

/// The densities of a scene at the voxel centres of a lattice: σ of dust at V [pc⁻¹] where there is dust, then each
/// glowing species in its own unit; each depth × height × width values, x running fastest.
///
/// # Errors
/// If they would take more memory than allowed, or are no densities, and on interruption by the user.
pub fn densities(scene: &Scene, lattice: &Lattice, options: &Options, control: &Control) -> Result<Vec<Grid>> {
    let dust = scene.dust.iter().map(|dust| (&dust.density, dust.sigma_v_per_pc, "dust"));
    let fields: Vec<_> = dust.chain(scene.species().iter().map(|gas| (&gas.density, 1.0, &*gas.name))).collect();
    memory::check("densities of a brick", 4 * (fields.len() * lattice.cells()) as u64, options.memory_limit)?;
    let sampled = |(field, factor, name): (&Arc<dyn Field>, f64, &str)| {
        let means = field.grid().filter(|grid| grid.front().is_some()).map(Grid::voxel_means);
        let field = means.as_ref().map_or(&**field, |means| means as &dyn Field);
        let grid = Grid::filled(lattice.clone(), |places, values| {
            field.sample(places, values);
            values.iter_mut().for_each(|value| *value *= factor);
        });
        control.check()?;
        grid.check(name).map(|()| grid)
    };
    fields.into_iter().map(sampled).collect()
}

impl SpatialPlan {
    /// The space of some voxels along x, y and z of a whole that is marched from end to end, with stars and all else of
    /// this one.
    ///
    /// # Errors
    /// If a field has another number of values, there are more or fewer fields than this space has, or volumes would
    /// take more memory than allowed.
    pub(crate) fn brick(&self, whole: &Lattice, voxels: &[Range<usize>; 3], fields: BrickFields, memory_limit: u64) -> Result<Self> {
        let stored_part = &whole.part(voxels);
        let BrickFields { dust, star_depths: depths, gas } = fields;
        let counts = (usize::from(dust.is_some()), depths.len(), gas.len());
        let stars = if self.dust.is_some() { self.marched.len() } else { 0 };
        let wanted = (usize::from(self.dust.is_some()), stars, self.emission.len());
        if counts != wanted {
            let named = |(dust, depths, gas)| format!("{dust} of dust, {depths} of star depths, {gas} of gas");
            return Err(Error::mismatch("fields of a brick", named(wanted), named(counts)));
        }
        let bytes = self.precision.bytes() * ((wanted.0 + wanted.1 + wanted.2) * stored_part.cells()) as u64;
        memory::check("volumes of a brick", bytes, memory_limit)?;
        let grid = |what: &'static str, data: Vec<f32>| match data.len() == stored_part.cells() {
            true => Ok(Grid::from_lattice(stored_part.clone(), data)),
            false => Err(Error::mismatch(what, format!("{} values, one per voxel", stored_part.cells()), data.len())),
        };
        let dust = dust.map(|data| grid("dust of a brick", data)).transpose()?;
        let depths = depths.into_iter().map(|data| grid("star depths of a brick", data)).collect::<Result<Vec<_>>>()?;
        let emission = gas.into_iter().map(|data| grid("gas of a brick", data)).collect::<Result<Vec<_>>>()?;
        let mut channels: Vec<(Channel, &Grid)> = dust.iter().map(|dust| (Channel::Dust, dust)).collect();
        channels.extend(self.marched.iter().zip(&depths).map(|(star, grid)| (Channel::StarDepth(*star), grid)));
        channels.extend(emission.iter().enumerate().map(|(species, grid)| (Channel::Emission(species), grid)));
        let volume = |chunk: &[(Channel, &Grid)]| {
            let volume = Volume::with_precision(stored_part, chunk.iter().map(|c| c.0).collect(), self.precision);
            let mut volume = volume.part_of(whole, voxels.each_ref().map(|range| range.start));
            for (slot, (channel, grid)) in chunk.iter().enumerate() {
                volume.fill(slot, grid);
                if matches!(channel, Channel::StarDepth(_)) {
                    star_depths::settle(&mut volume, slot);
                }
            }
            volume
        };
        let volumes = channels.chunks(MAX_CHANNELS).map(volume).map(Arc::new).collect();
        drop(channels);
        Ok(Self {
            volumes,
            bricks: dust.iter().chain(&emission).map(Bricks::new).collect(),
            dust: dust.map(Arc::new),
            emission,
            voxels: vec![whole.voxel_pc()],
            star_factor: 1,
            occupied: Some(whole.bounds),
            ..self.clone()
        })
    }
}
