//! What the places of things decide: density, star depths, empty space.

use std::sync::Arc;

use glam::DVec3;

use super::volume::{Channel, MAX_CHANNELS, Volume, scaled};
use super::{Bricks, Options, Spatial, star_depth};
use crate::camera::Camera;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Fbm, Field, Grid, Lattice};
use crate::formats::check_memory;
use crate::geometry::Bounds;
use crate::scene::Scene;

/// The most voxels along an edge of a function that is sampled without being told how finely.
const MAX_BAKE: usize = 256;
const MIN_BAKE: usize = 32;

/// Density and star depths, sampled.
#[derive(Debug, Clone)]
pub struct Space {
    /// Everything the march reads.
    pub volumes: Vec<Volume>,
    /// Dust alone, σ at V [pc⁻¹], for exact depths.
    pub dust: Option<Arc<Grid>>,
    /// The noise that the dust is, and σ at V of one [pc⁻¹], for back ends that evaluate it at every sample.
    pub cloud: Option<(Fbm, f64)>,
    /// Bricks of each volume's lattice: zero where nothing absorbs, scatters or glows.
    pub bricks: Vec<Bricks>,
    /// Places of the stars [pc].
    pub stars: Vec<DVec3>,
    /// Star depth voxels along a voxel of dust.
    pub star_factor: usize,
    /// Largest star depth at a place with dust [1].
    pub star_depth: f64,
    /// The spatial error that the pilot rays measured.
    pub spatial: Option<Spatial>,
    /// The smallest box around everything that absorbs, scatters or glows.
    pub occupied: Option<Bounds>,
    emission: Vec<Grid>,
}

/// Puts grids in the place of functions, so that every back end sees the same samples.
pub fn sample_functions(scene: &mut Scene, options: &Options) -> Result<()> {
    if let Some(dust) = &mut scene.dust {
        dust.density = Arc::new(baked(&dust.density, 1.0, "dust", options)?);
    }
    for gas in &mut scene.emission {
        gas.density = Arc::new(baked(&gas.density, 1.0, &gas.name, options)?);
    }
    Ok(())
}

/// The field as a grid, sampled if it is a function.
fn baked(field: &Arc<dyn Field>, factor: f64, what: &str, options: &Options) -> Result<Grid> {
    if let Some(grid) = field.grid() {
        check_memory(&format!("the plan's copy of {what}"), 4 * grid.lattice.cells() as u64, options.memory_limit)?;
        let scaled = scaled(grid, factor);
        scaled.check(what)?;
        return Ok(scaled);
    }
    let size = field.bounds().size();
    let finest = (size.max_element() / field.feature_pc()).ceil() as usize;
    let edge = options.method.bake.unwrap_or(finest.clamp(MIN_BAKE, MAX_BAKE)) as f64;
    let dims = <[f64; 3]>::from(size / size.max_element() * edge).map(|n| (n.round() as usize).max(2));
    let lattice = Lattice { dims, bounds: field.bounds() };
    check_memory(&format!("{what}, sampled"), 4 * lattice.cells() as u64, options.memory_limit)?;
    let grid = Grid::sampled(lattice, |p| factor * field.at(p));
    grid.check(what)?;
    Ok(grid)
}

impl Space {
    /// Samples densities and bakes star depths at the dust's own resolution.
    pub fn new(scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        let dust = scene.dust.as_ref().map(|d| baked(&d.density, d.sigma_v_per_pc, "dust", options)).transpose()?;
        let emission = scene.emission.iter().map(|e| baked(&e.density, 1.0, &e.name, options)).collect::<Result<Vec<_>>>()?;
        let grids = || dust.iter().chain(&emission);
        let bricks: Vec<Bricks> = grids().map(Bricks::new).collect();
        let occupied = grids().zip(&bricks).filter_map(|(g, b)| b.occupied(&g.lattice.bounds)).reduce(|a, b| a.union(&b));
        let mut space = Self {
            volumes: Vec::new(),
            bricks,
            occupied,
            dust: dust.map(Arc::new),
            cloud: scene.dust.as_ref().and_then(|d| d.density.fbm().map(|fbm| (fbm.clone(), d.sigma_v_per_pc))),
            stars: scene.stars.iter().map(|s| s.position).collect(),
            star_factor: 0,
            star_depth: 0.0,
            spatial: None,
            emission,
        };
        space.refine_stars(1, options, control)?;
        Ok(space)
    }

    /// Bakes star depths anew with `factor` voxels along one of dust.
    pub fn refine_stars(&mut self, factor: usize, options: &Options, control: &Control) -> Result<()> {
        self.star_factor = factor;
        self.lay_out(factor, self.stars.len(), options, control)?;
        self.star_depth = self.deepest();
        Ok(())
    }

    /// Puts a star elsewhere [pc] and sweeps its depths alone anew.
    ///
    /// # Errors
    /// Where there is no such star, its depths are not kept, or the place is none.
    pub fn move_star(&mut self, star: usize, place: DVec3, control: &Control) -> Result<()> {
        if !place.is_finite() {
            return Err(Error::Render(format!("{place} pc is no place for a star: coordinates are numbers")));
        }
        let slot_in = |v: &Volume| v.channels.iter().position(|c| *c == Channel::StarDepth(star));
        let Some((i, slot)) = self.volumes.iter().enumerate().find_map(|(i, v)| slot_in(v).map(|slot| (i, slot))) else {
            let count = self.stars.len();
            return Err(Error::Render(format!("star number {star} of {count} has no depths to sweep; make a new plan")));
        };
        let before = std::mem::replace(&mut self.stars[star], place);
        let mut volume = self.volumes.swap_remove(i);
        let done = self.fill(&mut volume, slot, control);
        if done.is_err() {
            // Somebody stopped it half way: the star goes back, without being asked again.
            self.stars[star] = before;
            self.fill(&mut volume, slot, &Control::default())?;
        }
        self.volumes.push(volume);
        let last = self.volumes.len() - 1;
        self.volumes.swap(i, last);
        self.star_depth = self.deepest();
        done
    }

    /// The largest star depth at a place with dust [1].
    fn deepest(&self) -> f64 {
        let of = |v: &Volume| {
            let stars = v.channels.iter().enumerate().filter(|(_, c)| matches!(c, Channel::StarDepth(_)));
            stars.map(|(slot, _)| f64::from(star_depth::deepest(v, slot, &self.bricks[0]))).fold(0.0, f64::max)
        };
        self.volumes.iter().map(of).fold(0.0, f64::max)
    }

    /// Lets go of the star depths, once something else holds the light.
    pub fn forget_star_depths(&mut self, options: &Options, control: &Control) -> Result<()> {
        self.lay_out(1, 0, options, control)
    }

    /// Boxes of volumes that end within the occupied one.
    pub fn inner_boxes(&self) -> Vec<Bounds> {
        let mut inner: Vec<Bounds> = Vec::new();
        for volume in &self.volumes {
            let bounds = volume.inner.bounds;
            if !self.occupied.is_none_or(|o| bounds.union(&o) == bounds) && !inner.contains(&bounds) {
                inner.push(bounds);
            }
        }
        inner
    }

    /// The volume and channel of a star's depths.
    pub fn star_channel(&self, star: usize) -> Option<(&Volume, usize)> {
        self.volumes.iter().find_map(|v| v.channels.iter().position(|c| *c == Channel::StarDepth(star)).map(|slot| (v, slot)))
    }

    /// Volumes of dust, the depths of so many stars, and gas: what has one lattice stands together.
    fn lay_out(&mut self, factor: usize, stars: usize, options: &Options, control: &Control) -> Result<()> {
        let mut parts: Vec<(Lattice, Channel)> = Vec::new();
        if let Some(dust) = &self.dust {
            parts.push((dust.lattice.clone(), Channel::Dust));
            let lattice = dust.lattice.refined(factor);
            check_memory(&format!("star depths of {stars} stars"), 4 * stars as u64 * lattice.cells() as u64, options.memory_limit)?;
            parts.extend((0..stars).map(|star| (lattice.clone(), Channel::StarDepth(star))));
        }
        parts.extend(self.emission.iter().enumerate().map(|(species, grid)| (grid.lattice.clone(), Channel::Emission(species))));
        self.volumes.clear();
        while let Some((lattice, _)) = parts.first().cloned() {
            let (own, others): (Vec<_>, Vec<_>) = parts.into_iter().partition(|p| p.0 == lattice);
            let channels: Vec<Channel> = own.into_iter().map(|p| p.1).collect();
            self.volumes.extend(channels.chunks(MAX_CHANNELS).map(|chunk| Volume::zeroed(&lattice, chunk.to_vec())));
            parts = others;
        }
        let mut volumes = std::mem::take(&mut self.volumes);
        for volume in &mut volumes {
            for slot in 0..volume.channels.len() {
                self.fill(volume, slot, control)?;
            }
        }
        self.volumes = volumes;
        Ok(())
    }

    /// Puts into a channel what it is to hold.
    fn fill(&self, volume: &mut Volume, slot: usize, control: &Control) -> Result<()> {
        match (volume.channels[slot], &self.dust) {
            (Channel::Emission(species), _) => volume.fill(slot, &self.emission[species]),
            (Channel::Dust, Some(dust)) => volume.fill(slot, dust),
            (Channel::StarDepth(star), Some(dust)) => {
                let cells = volume.inner.cells() as u64;
                let share = (star as u64 * cells, self.stars.len() as u64 * cells);
                star_depth::bake(dust, self.stars[star], volume, slot, share, control)?;
            }
            (Channel::Dust | Channel::StarDepth(_), None) | (Channel::Light(_), _) => {}
        }
        Ok(())
    }

    /// The finest voxel edge [pc].
    pub fn voxel_pc(&self) -> f64 {
        let grids = self.dust.iter().map(|d| &**d).chain(&self.emission);
        grids.map(|g| g.lattice.voxel_pc().min_element()).fold(f64::INFINITY, f64::min)
    }

    /// Number of glowing species.
    pub fn species(&self) -> usize {
        self.emission.len()
    }

    /// Exact optical depth at V between two places [1].
    pub fn depth(&self, a: DVec3, b: DVec3) -> f64 {
        self.dust.as_ref().map_or(0.0, |d| d.column(a, b, 2.0 * star_depth::OPAQUE))
    }

    /// The largest optical depth, eye to sample to star, that the camera's rays reach: exact on 1024 of them, a quarter more for those between.
    pub fn reach(&self, camera: &Camera) -> f64 {
        const EDGE: usize = 32;
        let Some(dust) = &self.dust else { return 0.1 };
        let along = |n: usize, i: usize| n as f64 * (i as f64 + 0.5) / EDGE as f64;
        let depth = |i: usize| {
            let ray = camera.ray(along(camera.width, i % EDGE), along(camera.height, i / EDGE));
            dust.bounds().clip(&ray).map_or(0.0, |(near, far)| self.depth(ray.at(near), ray.at(far)))
        };
        let view = (0..EDGE * EDGE).map(depth).fold(0.0, f64::max);
        (1.25 * view + self.star_depth).clamp(0.1, 2.0 * star_depth::OPAQUE)
    }

    /// Bytes of star depths of `factor` voxels along one of dust.
    pub fn star_bytes(&self, factor: usize) -> u64 {
        let cells = self.dust.as_ref().map_or(0, |d| d.lattice.cells() as u64);
        4 * cells.saturating_mul(factor.pow(3) as u64).saturating_mul(self.stars.len() as u64)
    }

    /// Bytes of all grids.
    pub fn bytes(&self) -> u64 {
        let own = self.dust.iter().map(|d| d.data.len()).sum::<usize>() + self.emission.iter().map(|e| e.data.len()).sum::<usize>();
        self.volumes.iter().map(Volume::bytes).sum::<u64>() + 4 * own as u64
    }

    /// Refuses a star whose own cell already swallows all of its light.
    pub fn check_stars(&self, scene: &Scene) -> Result<()> {
        let Some(dust) = &self.dust else { return Ok(()) };
        let edge = dust.lattice.voxel_pc().max_element();
        for star in &scene.stars {
            let own = dust.at(star.position) * edge;
            if own > star_depth::OPAQUE {
                return Err(Error::Render(format!(
                    "{} lies in a cell of optical depth {own:.1} a voxel: none of its light gets out; move the star, or carve a hole such as density = \"cloud * step((x-X)^2+(y-Y)^2+(z-Z)^2, R^2)\"",
                    star.name
                )));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Plan;
    use crate::scene::{DEFAULT_MEMORY, Loader};

    fn plan(place: &str) -> Plan {
        let text = format!(
            "bands = [\"johnson-V\"]\n[camera]\nkind = \"perspective\"\nposition = \"0 0 4 pc\"\nfield_of_view = \"30 deg\"\nsize = [4, 4]\n\
             [field.ball]\nkind = \"fbm\"\nradius = \"1 pc\"\n[dust]\ndensity = \"ball\"\nscale = \"4 /pc\"\nlaw = \"ccm89\"\nalbedo = 0.5\n\
             [[star]]\nkind = \"blackbody\"\nposition = \"0.1 0 0 pc\"\ntemperature = \"9000 K\"\nluminosity = \"1 Lsun\"\n\
             [[star]]\nkind = \"blackbody\"\nposition = \"{place} pc\"\ntemperature = \"4000 K\"\nluminosity = \"1 Lsun\"\n[method]\nbake = 20\n"
        );
        let scene = Scene::parse("test.toml", "test", text, &Loader::in_folder(".", DEFAULT_MEMORY)).unwrap();
        let options = Options { method: scene.method.clone(), memory_limit: DEFAULT_MEMORY };
        Plan::sampled(&scene, &options, 20, &Control::default()).unwrap()
    }

    /// A moved star has the depths of a plan that was made with it there, bit by bit; who holds the space of before keeps it; a stopped move changes nothing.
    #[test]
    fn a_star_moves() {
        let data = |plan: &Plan| plan.space.volumes.iter().map(|v| v.data.clone()).collect::<Vec<_>>();
        let (first, there) = (plan("-0.3 0.4 0.2"), plan("0.5 0.1 -0.3"));
        let mut moved = first.clone();
        moved.move_star(1, DVec3::new(0.5, 0.1, -0.3), &Control::default()).unwrap();
        assert!(data(&moved) == data(&there) && moved.space.star_depth == there.space.star_depth);
        assert!(data(&first) != data(&there) && data(&first) == data(&plan("-0.3 0.4 0.2")));
        let stop = Control::default();
        stop.interrupt();
        let mut stopped = first.clone();
        assert!(stopped.move_star(1, DVec3::ZERO, &stop).is_err());
        assert!(data(&stopped) == data(&first) && stopped.space.stars == first.space.stars);
        assert!(stopped.move_star(2, DVec3::ZERO, &Control::default()).is_err());
        assert!(stopped.move_star(1, DVec3::NAN, &Control::default()).is_err());
    }
}
