//! The volumes of a spatial plan: which channels stand together, and what they hold.

use std::sync::Arc;

use super::SpatialPlan;
use crate::control::Control;
use crate::error::Result;
use crate::field::{Grid, Lattice};
use crate::memory;
use crate::plan::star_depths::{self, Progress};
use crate::plan::{ManyLights, Options, many_lights};
use crate::scene::Scene;
use crate::scene::Sparsity;
use crate::volume::{Channel, ChannelMut, MAX_CHANNELS, Pages, Volume};

/// The longest segment of a ray, where none was asked for [voxels].
const LONGEST_SEGMENT: f64 = 2.0;
/// Volumes that take less are not looked through for empty pages \[bytes\].
const LARGE: u64 = 64 << 20;
/// The part of a volume's memory that pages may take to be worth it \[1\].
const WORTHWHILE: f64 = 0.75;

impl SpatialPlan {
    /// Puts the stars `members` among the many lights.
    pub(super) fn part_stars(&mut self, members: &[usize], options: &Options, control: &Control) -> Result<()> {
        let gathered = many_lights::mask(members, self.stars.len());
        self.marched = (0..self.stars.len()).filter(|star| !gathered[*star]).collect();
        self.many_lights = match &self.dust {
            Some(dust) if !members.is_empty() => {
                Some(Arc::new(ManyLights::new(self.many_lights.as_deref(), members, &self.stars, dust, options, control)?))
            }
            _ => None,
        };
        Ok(())
    }

    /// Bakes star depths anew with `factor` voxels along one of dust.
    pub(crate) fn refine_stars(&mut self, factor: usize, scene: &Scene, options: &Options, control: &Control) -> Result<()> {
        self.star_factor = factor;
        self.lay_out(factor, &self.marched.clone(), scene, options, control)?;
        self.star_depth = self.deepest();
        Ok(())
    }

    /// The largest star depth at a place with dust [1].
    pub(super) fn deepest(&self) -> f64 {
        let parts = |v: &Volume| {
            let stars = v.channels.iter().enumerate().filter(|(_, c)| matches!(c, Channel::StarDepth(_)));
            stars.map(|(slot, _)| f64::from(star_depths::deepest(v, slot, &self.bricks[0]))).fold(0.0, f64::max)
        };
        let many_lights = self.many_lights.as_ref().map_or(0.0, |many_lights| many_lights.deepest(&self.bricks[0]));
        self.volumes.iter().map(|v| parts(v)).fold(many_lights, f64::max)
    }

    /// Lets go of the star depths, once something else holds the light.
    pub(crate) fn forget_star_depths(&mut self, scene: &Scene, options: &Options, control: &Control) -> Result<()> {
        self.lay_out(1, &[], scene, options, control)
    }

    /// Volumes of dust, the depths of a given number of stars, and gas: what has one lattice stands together.
    pub(super) fn lay_out(&mut self, factor: usize, stars: &[usize], scene: &Scene, options: &Options, control: &Control) -> Result<()> {
        let mut parts: Vec<(Lattice, Channel)> = Vec::new();
        if let Some(dust) = &self.dust {
            parts.push((dust.lattice().clone(), Channel::Dust));
            let lattice = dust.lattice().refined(factor);
            parts.extend(stars.iter().map(|star| (lattice.clone(), Channel::StarDepth(*star))));
        }
        parts.extend(self.emission.iter().enumerate().map(|(species, grid)| (grid.lattice().clone(), Channel::Emission(species))));
        parts.extend(self.front().map(|front| (front.lattice().clone(), Channel::Front)));
        self.volumes.clear();
        let mut volumes: Vec<Volume> = Vec::new();
        while let Some((lattice, _)) = parts.first().cloned() {
            let (alike, others): (Vec<_>, Vec<_>) = parts.into_iter().partition(|p| p.0 == lattice);
            let channels: Vec<Channel> = alike.into_iter().map(|p| p.1).collect();
            let pages = self.pages(&lattice, &channels, scene.method.steps);
            let bytes = self.precision.bytes() * (channels.len() * pages.voxels()) as u64;
            let depths = channels.iter().filter(|channel| matches!(channel, Channel::StarDepth(_))).count();
            let what = format!("volumes of {} fields and of the depths of {depths} stars", channels.len() - depths);
            memory::check(&what, bytes, options.memory_limit)?;
            let volume = |chunk: &[Channel]| Volume::with_pages(&lattice, chunk.to_vec(), self.precision, pages.clone());
            volumes.extend(channels.chunks(MAX_CHANNELS).map(volume));
            parts = others;
        }
        for volume in &mut volumes {
            for slot in 0..volume.channels.len() {
                self.fill(volume, slot, control)?;
            }
        }
        self.volumes = volumes.into_iter().map(Arc::new).collect();
        Ok(())
    }

    /// The pages of a volume, which needs those where there is something of its channels: all in one
    /// where little is empty, or nothing may be left out.
    fn pages(&self, lattice: &Lattice, channels: &[Channel], steps: Option<usize>) -> Pages {
        let whole = Pages::whole(Volume::zeroed(lattice, Vec::new()).lattice.dims);
        let is_large = self.precision.bytes() * (channels.len() * whole.voxels()) as u64 >= LARGE;
        // Noise that is evaluated at every sample is elsewhere than its samples.
        if self.cloud.is_some() || self.sparsity == Sparsity::Never || self.sparsity == Sparsity::Auto && !is_large {
            return whole;
        }
        let grid = |channel: &Channel| match channel {
            Channel::Emission(species) => self.emission.get(*species),
            Channel::Front => None,
            _ => self.dust.as_deref(),
        };
        let mut grids: Vec<&Grid> = channels.iter().filter_map(grid).collect();
        grids.dedup_by(|a, b| std::ptr::eq(*a, *b));
        // A segment of a ray that meets dust may end beside it, where the depth from a star is still asked for.
        let finest = self.voxels.iter().map(|voxel| voxel.max_element()).fold(f64::INFINITY, f64::min);
        let longest_pc = match steps {
            Some(steps) => self.occupied.map_or(0.0, |bounds| bounds.size().length()) / steps as f64,
            None => LONGEST_SEGMENT * finest,
        };
        let pages = Volume::pages_with(lattice, &grids, longest_pc.max(finest));
        let is_worthwhile = self.sparsity == Sparsity::Always || pages.voxels() as f64 <= WORTHWHILE * whole.voxels() as f64;
        if is_worthwhile { pages } else { whole }
    }

    /// Puts into a channel what it is to hold.
    pub(super) fn fill(&self, volume: &mut Volume, slot: usize, control: &Control) -> Result<()> {
        match (volume.channels[slot], &self.dust) {
            (Channel::Emission(species), _) => volume.fill(slot, &self.emission[species]),
            (Channel::Front, _) => self.front().into_iter().for_each(|front| volume.fill(slot, front)),
            (Channel::Dust, Some(dust)) => volume.fill(slot, dust),
            (Channel::StarDepth(star), Some(dust)) => {
                let cells = volume.inner.cells() as u64;
                let before = self.marched.iter().take_while(|s| **s != star).count() as u64;
                let progress = Progress { done: before * cells, all: self.marched.len() as u64 * cells };
                star_depths::bake(dust, self.stars[star], ChannelMut { volume, slot }, progress, control)?;
            }
            (Channel::Dust | Channel::StarDepth(_), None) | (Channel::Light(_) | Channel::MultipleScattering(_), _) => {}
        }
        Ok(())
    }

    /// The bytes of star depths of `factor` voxels along one of dust.
    pub fn star_bytes(&self, factor: usize) -> u64 {
        let cells = self.dust.as_ref().map_or(0, |d| d.lattice().cells() as u64);
        let stored_share = self.marched.first().and_then(|star| self.star_channel(*star)).map_or(1.0, |(volume, _)| volume.stored_share());
        let bytes = self.precision.bytes() * cells.saturating_mul(factor.pow(3) as u64).saturating_mul(self.marched.len() as u64);
        (stored_share * bytes as f64) as u64
    }

    /// The bytes that all grids take.
    pub fn bytes(&self) -> u64 {
        // What the scene holds as well is not the plan's.
        let is_own = |grid: &&Grid| !self.densities.iter().filter_map(|field| field.grid()).any(|of_scene| of_scene.shares(grid));
        let held_bytes: u64 = self.dust.iter().map(|d| &**d).chain(&self.emission).filter(is_own).map(Grid::bytes).sum();
        let many_lights = self.many_lights.as_ref().map_or(0, |many_lights| many_lights.bytes());
        self.volumes.iter().map(|volume| volume.bytes()).sum::<u64>() + held_bytes + many_lights
    }
}
