//! The space of a brick: what a march reads of a part of a volume that nobody holds as a whole.

use std::ops::Range;
use std::sync::Arc;

use super::bake::{OWN, baked};
use super::{Bricks, Channel, SpatialPlan, Volume};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Grid, Lattice};
use crate::geometry::Bounds;
use crate::plan::{Options, Settings, star_depths};
use crate::scene::Scene;
use crate::volume::MAX_CHANNELS;

/// What stands at the voxels of a brick and its halo; each has depth × height × width values, x running fastest.
#[derive(Debug, Clone, Default)]
pub struct BrickFields {
    /// The extinction σ at V [pc⁻¹]; nothing where there is no dust.
    pub dust: Option<Vec<f32>>,
    /// The optical depth at V from each star at voxel centres, as sweeps make it \[1\]; none where there is no dust.
    pub star_depths: Vec<Vec<f32>>,
    /// The density of each glowing species, in its own unit.
    pub gas: Vec<Vec<f32>>,
}

/// The densities of a scene as a plan samples them: σ of dust at V [pc⁻¹] where there is dust, then each glowing
/// species in its own unit.
///
/// # Errors
/// Where samples would take more memory than allowed, or are no densities.
pub fn densities(scene: &Scene, options: &Options, control: &Control) -> Result<Vec<Grid>> {
    let settings = &Settings::of(scene, options);
    let dust = scene.dust.iter().map(|d| baked(&d.density, d.sigma_v_per_pc, "dust", settings, OWN, control));
    dust.chain(scene.emission.iter().map(|e| baked(&e.density, 1.0, &e.name, settings, OWN, control))).collect()
}

impl SpatialPlan {
    /// The space of some voxels along x, y and z of a whole that is occupied within `occupied`, with stars and all else
    /// of this one.
    ///
    /// # Errors
    /// Where a field has another number of values, or there are more or fewer fields than this space has.
    pub(crate) fn brick(&self, whole: &Lattice, occupied: Option<Bounds>, voxels: &[Range<usize>; 3], fields: BrickFields) -> Result<Self> {
        let held = &whole.part(voxels);
        let BrickFields { dust, star_depths: depths, gas } = fields;
        let counts = (usize::from(dust.is_some()), depths.len(), gas.len());
        let stars = if self.dust.is_some() { self.marched.len() } else { 0 };
        let wanted = (usize::from(self.dust.is_some()), stars, self.emission.len());
        if counts != wanted {
            let named = |(dust, depths, gas)| format!("{dust} of dust, {depths} of star depths, {gas} of gas");
            return Err(Error::value("fields of a brick", named(counts), named(wanted)));
        }
        let grid = |what: &'static str, data: Vec<f32>| match data.len() == held.cells() {
            true => Ok(Grid::of(held.clone(), data)),
            false => Err(Error::value(what, format!("{} values", data.len()), format!("{} values, as many as voxels", held.cells()))),
        };
        let dust = dust.map(|data| grid("dust of a brick", data)).transpose()?;
        let depths = depths.into_iter().map(|data| grid("star depths of a brick", data)).collect::<Result<Vec<_>>>()?;
        let emission = gas.into_iter().map(|data| grid("gas of a brick", data)).collect::<Result<Vec<_>>>()?;
        let mut channels: Vec<(Channel, &Grid)> = dust.iter().map(|dust| (Channel::Dust, dust)).collect();
        channels.extend(self.marched.iter().zip(&depths).map(|(star, grid)| (Channel::StarDepth(*star), grid)));
        channels.extend(emission.iter().enumerate().map(|(species, grid)| (Channel::Emission(species), grid)));
        let volume = |chunk: &[(Channel, &Grid)]| {
            let volume = Volume::with_precision(held, chunk.iter().map(|c| c.0).collect(), self.precision);
            let mut volume = volume.part_of(whole, voxels.each_ref().map(|own| own.start));
            for (slot, (channel, grid)) in chunk.iter().enumerate() {
                volume.fill(slot, grid);
                if matches!(channel, Channel::StarDepth(_)) {
                    star_depths::settle(&mut volume, slot);
                }
            }
            volume
        };
        let volumes = channels.chunks(MAX_CHANNELS).map(volume).collect();
        drop(channels);
        Ok(Self {
            volumes,
            bricks: dust.iter().chain(&emission).map(Bricks::new).collect(),
            dust: dust.map(Arc::new),
            emission,
            voxels: vec![whole.voxel_pc()],
            star_factor: 1,
            occupied,
            ..self.clone()
        })
    }
}
