//! What the places of things decide: density, star depths, empty space.

use std::sync::Arc;

use glam::DVec3;

use super::bake::{Fineness, OWN, baked};
use super::many_lights::{self, ManyLights};
use super::volume::{Channel, MAX_CHANNELS, Volume, scaled};
use super::{Bricks, Settings, Spatial, star_depth};
use crate::camera::Camera;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Fbm, Field, Grid, Lattice, column};
use crate::geometry::{Bounds, Ray};
use crate::memory;
use crate::scene::Scene;

/// Depth at V that no light of any wavelength comes through, from an eye through all dust to a star.
const DEEPEST: f64 = 10.0 * star_depth::OPAQUE;
/// Depth at V of a star's own voxel of which no visible light comes out: e^(−80) is below the smallest f32 beside 1.
const SWALLOWED: f64 = 80.0;

/// Density and star depths, sampled.
#[derive(Debug, Clone)]
pub struct SpatialPlan {
    /// Everything the march reads.
    pub volumes: Vec<Volume>,
    /// Dust alone, σ at V [pc⁻¹], for exact depths.
    pub dust: Option<Arc<Grid>>,
    /// The noise that the dust is, and σ at V of one [pc⁻¹], for back ends that evaluate it at every sample.
    pub cloud: Option<(Fbm, f64)>,
    /// Bricks of each volume's lattice: zero where nothing absorbs, scatters or glows.
    pub bricks: Vec<Bricks>,
    /// Places of the stars \[pc\].
    pub stars: Vec<DVec3>,
    /// Those whose light is gathered, where some are.
    pub many_lights: Option<Arc<ManyLights>>,
    /// Numbers of the others, which have depths in volumes of their own.
    marched: Vec<usize>,
    /// Star depth voxels along a voxel of dust.
    pub star_factor: usize,
    /// Largest star depth at a place with dust \[1\].
    pub star_depth: f64,
    /// The spatial error that the pilot rays measured.
    pub spatial: Option<Spatial>,
    /// The smallest box around everything that absorbs, scatters or glows.
    pub occupied: Option<Bounds>,
    emission: Vec<Grid>,
    /// The densities that were sampled: dust, then gas.
    densities: Vec<Arc<dyn Field>>,
    /// σ at V of a density of one [pc⁻¹].
    sigma_v_per_pc: f64,
    bake: Option<usize>,
    /// How finely functions were asked to be sampled.
    fineness: Fineness,
}

/// The densities of a scene: dust, then gas.
fn densities(scene: &Scene) -> impl Iterator<Item = &Arc<dyn Field>> {
    scene.dust.iter().map(|d| &d.density).chain(scene.emission.iter().map(|e| &e.density))
}

fn sigma_v_per_pc(scene: &Scene) -> f64 {
    scene.dust.as_ref().map_or(0.0, |d| d.sigma_v_per_pc)
}

/// The noise that the dust of a scene is, and σ at V of one [pc⁻¹].
fn cloud(scene: &Scene) -> Option<(Fbm, f64)> {
    scene.dust.as_ref().and_then(|d| d.density.fbm().map(|fbm| (fbm.clone(), d.sigma_v_per_pc)))
}

/// The smallest box around what is not empty.
fn occupied<'a>(grids: impl Iterator<Item = &'a Grid>, bricks: &[Bricks]) -> Option<Bounds> {
    grids.zip(bricks).filter_map(|(g, b)| b.occupied(&g.lattice.bounds)).reduce(|a, b| a.union(&b))
}

impl SpatialPlan {
    /// Samples densities and bakes star depths at the dust's own resolution.
    pub(crate) fn new(scene: &Scene, settings: &Settings, control: &Control) -> Result<Self> {
        Self::sampled(scene, settings, OWN, control)
    }

    /// The same with no more than `most` voxels along an edge: functions are sampled so, voxels of grids merged.
    pub(crate) fn coarse(scene: &Scene, settings: &Settings, most: usize, control: &Control) -> Result<Self> {
        Self::sampled(scene, settings, Fineness { most, ..OWN }, control)
    }

    fn sampled(scene: &Scene, settings: &Settings, fineness: Fineness, control: &Control) -> Result<Self> {
        let dust = scene.dust.as_ref().map(|d| baked(&d.density, d.sigma_v_per_pc, "dust", settings, fineness)).transpose()?;
        let emission = scene.emission.iter().map(|e| baked(&e.density, 1.0, &e.name, settings, fineness)).collect::<Result<Vec<_>>>()?;
        let bricks: Vec<Bricks> = dust.iter().chain(&emission).map(Bricks::new).collect();
        let mut space = Self {
            volumes: Vec::new(),
            occupied: occupied(dust.iter().chain(&emission), &bricks),
            bricks,
            dust: dust.map(Arc::new),
            cloud: cloud(scene),
            stars: scene.stars.iter().map(|s| s.position).collect(),
            many_lights: None,
            marched: Vec::new(),
            star_factor: 0,
            star_depth: 0.0,
            spatial: None,
            emission,
            densities: densities(scene).cloned().collect(),
            sigma_v_per_pc: sigma_v_per_pc(scene),
            bake: settings.method.bake,
            fineness,
        };
        space.part_stars(&many_lights::members(scene, &settings.method), settings, control)?;
        space.refine_stars(1, settings, control)?;
        Ok(space)
    }

    /// Puts the stars `members` among the many lights.
    fn part_stars(&mut self, members: &[usize], settings: &Settings, control: &Control) -> Result<()> {
        let gathered = many_lights::mask(members, self.stars.len());
        self.marched = (0..self.stars.len()).filter(|star| !gathered[*star]).collect();
        self.many_lights = match &self.dust {
            Some(dust) if !members.is_empty() => {
                Some(Arc::new(ManyLights::new(self.many_lights.as_deref(), members, &self.stars, dust, settings, control)?))
            }
            _ => None,
        };
        Ok(())
    }

    /// The space of a scene that has the same densities as this one's; none where it has others. Stars that moved are
    /// swept anew, and all of them where dust has become more or less; the space itself where nothing of it changed.
    /// What pilots measured is forgotten where something did.
    pub(crate) fn follow(self: &Arc<Self>, scene: &Scene, settings: &Settings, control: &Control) -> Result<Option<Arc<Self>>> {
        let same = |(a, b): (&Arc<dyn Field>, &Arc<dyn Field>)| std::ptr::addr_eq(Arc::as_ptr(a), Arc::as_ptr(b));
        let known = densities(scene).count() == self.densities.len() && densities(scene).zip(&self.densities).all(same);
        if !known || scene.dust.is_some() != self.dust.is_some() || self.bake != settings.method.bake {
            return Ok(None);
        }
        let stars: Vec<DVec3> = scene.stars.iter().map(|s| s.position).collect();
        let members = many_lights::members(scene, &settings.method);
        // the gathered stars are those that it has now.
        let gathered = many_lights::mask(&members, stars.len());
        let parted =
            self.marched.len() + members.len() == stars.len() && self.marched.iter().all(|star| gathered.get(*star) == Some(&false));
        if parted && stars.len() == self.stars.len() && sigma_v_per_pc(scene) == self.sigma_v_per_pc {
            let moved: Vec<usize> = (0..stars.len()).filter(|s| stars[*s] != self.stars[*s]).collect();
            if moved.is_empty() {
                let led = self.many_lights.as_ref().and_then(|many_lights| many_lights.led_by(&members));
                return Ok(Some(match led {
                    Some(many_lights) => Arc::new(Self { many_lights: Some(Arc::new(many_lights)), ..(**self).clone() }),
                    None => self.clone(),
                }));
            }
            let mut space = Self { spatial: None, ..(**self).clone() };
            if self.dust.is_none() {
                // Without dust there are no depths.
                return Ok(Some(Arc::new(Self { stars, ..space })));
            }
            let (gathered, marched): (Vec<usize>, Vec<usize>) = moved.into_iter().partition(|star| gathered[*star]);
            for star in marched {
                space.move_star(star, stars[star], control)?;
            }
            if !gathered.is_empty() {
                space.stars = stars;
                space.part_stars(&members, settings, control)?;
                space.star_depth = space.deepest();
            }
            return Ok(Some(Arc::new(space)));
        }
        let (moved, ratio) = (!parted || stars != self.stars, sigma_v_per_pc(scene) / self.sigma_v_per_pc);
        let mut space = Self { stars, spatial: None, ..(**self).clone() };
        space.take_dust(scene, settings)?;
        if moved || !space.scale_depths(ratio) {
            space.part_stars(&members, settings, control)?;
            space.refine_stars(self.star_factor, settings, control)?;
        }
        Ok(Some(Arc::new(space)))
    }

    /// The space of a scene that has the same densities and as much dust, as it is before pilots choose how finely;
    /// none otherwise.
    pub(crate) fn again(self: &Arc<Self>, scene: &Scene, settings: &Settings, control: &Control) -> Result<Option<Self>> {
        if sigma_v_per_pc(scene) != self.sigma_v_per_pc || self.fineness != OWN {
            return Ok(None);
        }
        let Some(followed) = self.follow(scene, settings, control)? else { return Ok(None) };
        let mut own = Self { spatial: None, ..Arc::unwrap_or_clone(followed) };
        if own.star_factor != 1 {
            own.refine_stars(1, settings, control)?;
        }
        Ok(Some(own))
    }

    /// Multiplies all star depths and puts the dust of now into its volume; false, and nothing done, where depths were
    /// or would be cut.
    fn scale_depths(&mut self, ratio: f64) -> bool {
        let depths = |v: &Volume| (0..v.channels.len()).filter(|c| matches!(v.channels[*c], Channel::StarDepth(_))).collect::<Vec<_>>();
        let largest = |v: &Volume| {
            depths(v).into_iter().flat_map(|c| v.data.iter().skip(c).step_by(v.channels.len())).fold(0.0f32, |m, d| m.max(d.abs()))
        };
        let deepest = f64::from(self.volumes.iter().map(largest).fold(0.0, f32::max));
        let Some(dust) =
            self.dust.clone().filter(|_| ratio.is_finite() && ratio > 0.0 && deepest * ratio.max(1.0) < 0.99 * star_depth::OPAQUE)
        else {
            return false;
        };
        if let Some(many_lights) = &self.many_lights {
            let Some(scaled) = many_lights.scaled(ratio, &dust) else { return false };
            self.many_lights = Some(Arc::new(scaled));
        }
        for volume in &mut self.volumes {
            let (channels, depths) = (volume.channels.len(), depths(volume));
            for values in volume.data.chunks_exact_mut(channels) {
                depths.iter().for_each(|c| values[*c] *= ratio as f32);
            }
            if let Some(slot) = volume.channels.iter().position(|c| *c == Channel::Dust) {
                volume.fill(slot, &dust);
            }
        }
        self.star_depth *= ratio;
        true
    }

    /// Samples the dust of `scene` in place of this one's.
    fn take_dust(&mut self, scene: &Scene, settings: &Settings) -> Result<()> {
        let Some(dust) = scene.dust.as_ref().filter(|d| d.sigma_v_per_pc != self.sigma_v_per_pc) else { return Ok(()) };
        let before = self.dust.as_deref().filter(|_| self.sigma_v_per_pc > 0.0);
        let grid = match before {
            Some(grid) => scaled(grid, dust.sigma_v_per_pc / self.sigma_v_per_pc),
            None => baked(&dust.density, dust.sigma_v_per_pc, "dust", settings, self.fineness)?,
        };
        grid.check("dust")?;
        self.bricks[0] = Bricks::new(&grid);
        self.dust = Some(Arc::new(grid));
        self.cloud = cloud(scene);
        self.sigma_v_per_pc = dust.sigma_v_per_pc;
        self.occupied = occupied(self.dust.as_deref().into_iter().chain(&self.emission), &self.bricks);
        Ok(())
    }

    /// Whether a density is a function, of which the march has samples alone.
    pub fn is_sampled(&self) -> bool {
        self.densities.iter().any(|field| field.grid().is_none())
    }

    /// Whether the dust is a function.
    pub fn depth_is_sampled(&self) -> bool {
        self.dust.is_some() && self.densities.first().is_some_and(|field| field.grid().is_none())
    }

    /// Whether a density is a function that jumps.
    pub fn has_edges(&self) -> bool {
        self.densities.iter().any(|field| field.has_edges())
    }

    /// Voxels along the longest edge of the function that is sampled most coarsely; none where nothing is sampled.
    pub fn sampled_edge(&self) -> Option<usize> {
        let grids = self.dust.iter().map(|d| &**d).chain(&self.emission);
        let sampled = grids.zip(&self.densities).filter(|(_, field)| field.grid().is_none());
        sampled.filter_map(|(grid, _)| grid.lattice.dims.into_iter().max()).min()
    }

    /// The fields themselves at a place: σ at V [pc⁻¹], and the densities of glowing species.
    pub fn fields_at(&self, p: DVec3) -> (f64, impl Iterator<Item = f64> + '_) {
        let mut values = self.densities.iter().map(move |field| field.at(p));
        let sigma = if self.dust.is_some() { values.next().unwrap_or(0.0) * self.sigma_v_per_pc } else { 0.0 };
        (sigma, values)
    }

    /// Distances along a ray at which a function jumps or begins \[pc\].
    pub fn crossings(&self, ray: &Ray) -> Vec<f64> {
        let mut crossings = Vec::new();
        for field in self.densities.iter().filter(|field| field.grid().is_none()) {
            crossings.extend(field.bounds().clip(ray).into_iter().flat_map(|(a, b)| [a, b]));
            field.crossings(ray, &mut crossings);
        }
        crossings
    }

    /// By how much the optical depth at V between two places of the dust itself is larger than that of its samples \[1\];
    /// zero where dust is a grid.
    pub fn depth_beyond_samples(&self, a: DVec3, b: DVec3) -> f64 {
        match self.densities.first().filter(|field| self.dust.is_some() && field.grid().is_none()) {
            Some(field) => self.sigma_v_per_pc * column(&**field, a, b) - self.depth(a, b),
            None => 0.0,
        }
    }

    /// A space whose fields are this one's samples, for exact walks through them.
    pub fn of_samples(&self) -> Self {
        let own = |grid: &Grid| Arc::new(grid.clone()) as Arc<dyn Field>;
        let densities = self.dust.iter().map(|dust| dust.clone() as Arc<dyn Field>).chain(self.emission.iter().map(own)).collect();
        Self { densities, sigma_v_per_pc: 1.0, ..self.clone() }
    }

    /// The same space with functions sampled to at least `edge` voxels along their longest edge; none where that would
    /// take more memory than allowed.
    pub(crate) fn resampled(&self, scene: &Scene, edge: usize, settings: &Settings, control: &Control) -> Result<Option<Self>> {
        match Self::sampled(scene, settings, Fineness { least: edge, ..self.fineness }, control) {
            // Which samples another plan of the same scene begins with does not hang on what this one needed.
            Ok(space) => Ok(Some(Self { fineness: self.fineness, ..space })),
            Err(Error::Memory { .. }) => Ok(None),
            Err(other) => Err(other),
        }
    }

    /// Bakes star depths anew with `factor` voxels along one of dust.
    pub(crate) fn refine_stars(&mut self, factor: usize, settings: &Settings, control: &Control) -> Result<()> {
        self.star_factor = factor;
        self.lay_out(factor, &self.marched.clone(), settings, control)?;
        self.star_depth = self.deepest();
        Ok(())
    }

    /// Puts a star elsewhere \[pc\] and sweeps its depths alone anew.
    ///
    /// # Errors
    /// Where there is no such star, its depths are not kept, or the place is none.
    pub fn move_star(&mut self, star: usize, place: DVec3, control: &Control) -> Result<()> {
        if !place.is_finite() {
            return Err(Error::Star(format!("{place} pc is no place for a star: coordinates are numbers")));
        }
        let slot_in = |v: &Volume| v.channels.iter().position(|c| *c == Channel::StarDepth(star));
        let Some((i, slot)) = self.volumes.iter().enumerate().find_map(|(i, v)| slot_in(v).map(|slot| (i, slot))) else {
            let count = self.stars.len();
            return Err(Error::Star(format!("star number {star} of {count} has no depths of its own to sweep; make a new plan")));
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
        let gathered = self.many_lights.as_ref().map_or(0.0, |many_lights| many_lights.deepest(&self.bricks[0]));
        self.volumes.iter().map(of).fold(gathered, f64::max)
    }

    /// Lets go of the star depths, once something else holds the light.
    pub(crate) fn forget_star_depths(&mut self, settings: &Settings, control: &Control) -> Result<()> {
        self.lay_out(1, &[], settings, control)
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
    fn lay_out(&mut self, factor: usize, stars: &[usize], settings: &Settings, control: &Control) -> Result<()> {
        let mut parts: Vec<(Lattice, Channel)> = Vec::new();
        if let Some(dust) = &self.dust {
            parts.push((dust.lattice.clone(), Channel::Dust));
            let lattice = dust.lattice.refined(factor);
            let count = stars.len();
            memory::check(&format!("star depths of {count} stars"), 4 * count as u64 * lattice.cells() as u64, settings.memory_limit)?;
            parts.extend(stars.iter().map(|star| (lattice.clone(), Channel::StarDepth(*star))));
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
                let before = self.marched.iter().take_while(|s| **s != star).count() as u64;
                let share = (before * cells, self.marched.len() as u64 * cells);
                star_depth::bake(dust, self.stars[star], volume, slot, share, control)?;
            }
            (Channel::Dust | Channel::StarDepth(_), None) | (Channel::Light(_) | Channel::MultipleScattering(_), _) => {}
        }
        Ok(())
    }

    /// The finest voxel edge \[pc\].
    pub fn voxel_pc(&self) -> f64 {
        let grids = self.dust.iter().map(|d| &**d).chain(&self.emission);
        grids.map(|g| g.lattice.voxel_pc().min_element()).fold(f64::INFINITY, f64::min)
    }

    /// The finest voxel edge along a direction of length one \[pc\]: that of cubes, and the distance between walls of
    /// longer voxels.
    pub fn voxel_along(&self, direction: DVec3) -> f64 {
        let shortest = self.voxel_pc();
        let along = self.voxels().iter().map(|voxel| 1.0 / (direction / *voxel).length()).fold(f64::INFINITY, f64::min);
        // Cubes have one edge, whatever rounding says.
        if along < shortest * (1.0 + 1e-9) { shortest } else { along }
    }

    /// Edges of the voxels of all grids \[pc\], each kind once.
    pub fn voxels(&self) -> Vec<DVec3> {
        let mut voxels: Vec<DVec3> = self.dust.iter().map(|d| &**d).chain(&self.emission).map(|g| g.lattice.voxel_pc()).collect();
        voxels.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap_or(std::cmp::Ordering::Equal));
        voxels.dedup();
        voxels
    }

    /// Densities of glowing species, each in its own unit.
    pub fn gas(&self) -> &[Grid] {
        &self.emission
    }

    /// Number of glowing species.
    pub fn species(&self) -> usize {
        self.emission.len()
    }

    /// Exact optical depth at V between two places \[1\].
    pub fn depth(&self, a: DVec3, b: DVec3) -> f64 {
        self.dust.as_ref().map_or(0.0, |d| d.column(a, b, DEEPEST))
    }

    /// The largest optical depth, eye to sample to star, that the camera's rays reach: exact on 1024 of them, a quarter
    /// more for those between.
    pub fn reach(&self, camera: &Camera) -> f64 {
        const EDGE: usize = 32;
        let Some(dust) = &self.dust else { return 0.1 };
        let along = |n: usize, i: usize| n as f64 * (i as f64 + 0.5) / EDGE as f64;
        let depth = |i: usize| {
            let ray = camera.ray(along(camera.width, i % EDGE), along(camera.height, i / EDGE));
            dust.bounds().clip(&ray).map_or(0.0, |(near, far)| self.depth(ray.at(near), ray.at(far)))
        };
        let view = (0..EDGE * EDGE).map(depth).fold(0.0, f64::max);
        (1.25 * view + self.star_depth).clamp(0.1, DEEPEST)
    }

    /// Bytes of star depths of `factor` voxels along one of dust.
    pub fn star_bytes(&self, factor: usize) -> u64 {
        let cells = self.dust.as_ref().map_or(0, |d| d.lattice.cells() as u64);
        4 * cells.saturating_mul(factor.pow(3) as u64).saturating_mul(self.marched.len() as u64)
    }

    /// Numbers of the stars that have depths in volumes of their own.
    pub fn marched(&self) -> &[usize] {
        &self.marched
    }

    /// Bytes of all grids.
    pub fn bytes(&self) -> u64 {
        let own = self.dust.iter().map(|d| d.data.len()).sum::<usize>() + self.emission.iter().map(|e| e.data.len()).sum::<usize>();
        let gathered = self.many_lights.as_ref().map_or(0, |many_lights| many_lights.bytes());
        self.volumes.iter().map(Volume::bytes).sum::<u64>() + 4 * own as u64 + gathered
    }

    /// Refuses a star whose own cell already swallows all of its light.
    ///
    /// # Errors
    /// Where there is one, with its name.
    pub fn check_stars(&self, scene: &Scene) -> Result<()> {
        let Some(dust) = &self.dust else { return Ok(()) };
        let edge = dust.lattice.voxel_pc().max_element();
        for star in &scene.stars {
            let own = dust.at(star.position) * edge;
            if own > SWALLOWED {
                return Err(Error::Star(format!(
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
    use crate::plan::{Options, Plan};
    use crate::test_scenes::{dust, on_axis, scene, star};

    const BEFORE: DVec3 = DVec3::new(-0.3, 0.4, 0.2);
    const THERE: DVec3 = DVec3::new(0.5, 0.1, -0.3);

    fn cloud() -> Arc<dyn Field> {
        Arc::new(Fbm::new(1))
    }

    /// A cloud and two stars, the second at `place`.
    fn pair(cloud: &Arc<dyn Field>, place: DVec3, scale: f64) -> Scene {
        let stars = [star(9000.0, 1.0, 0.1 * DVec3::X), star(4000.0, 1.0, place)];
        let camera = on_axis(4.0, 30.0, (4, 4));
        stars.into_iter().fold(scene(camera, 20).dust(dust(cloud.clone(), "ccm89", scale)), Scene::star)
    }

    fn settings(scene: &Scene) -> Settings {
        Settings::of(scene, &Options::default())
    }

    fn plan(place: DVec3) -> Plan {
        Plan::sampled(&pair(&cloud(), place, 4.0), &Options::default(), 20, &Control::default()).unwrap()
    }

    fn data(space: &SpatialPlan) -> Vec<Vec<f32>> {
        space.volumes.iter().map(|v| v.data.clone()).collect()
    }

    /// A space follows a scene that is read again: the same where nothing moved, with the bits of a new one where a
    /// star did, within rounding where there is more dust; not at all where the densities are others.
    #[test]
    fn spaces_follow_their_scenes() {
        let (cloud, control) = (cloud(), Control::default());
        let first = pair(&cloud, BEFORE, 4.0);
        let space = Arc::new(SpatialPlan::new(&first, &settings(&first), &control).unwrap());
        let follow = |scene: Scene| {
            let followed = space.follow(&scene, &settings(&scene), &control).unwrap();
            (followed, SpatialPlan::new(&scene, &settings(&scene), &control).unwrap())
        };
        let mut colder = first.clone();
        colder.stars[0] = star(5000.0, 1.0, first.stars[0].position);
        assert!(Arc::ptr_eq(&follow(colder).0.unwrap(), &space));
        let (moved, new) = follow(pair(&cloud, THERE, 4.0));
        assert!(data(&moved.unwrap()) == data(&new) && data(&space) != data(&new));
        let (denser, new) = follow(pair(&cloud, BEFORE, 7.0));
        let denser = denser.unwrap();
        let worst = data(&denser)
            .iter()
            .flatten()
            .zip(data(&new).iter().flatten())
            .map(|(a, b)| (a - b).abs() / (1e-3 + b.abs()))
            .fold(0.0, f32::max);
        assert!(
            worst < 1e-4
                && (denser.star_depth / new.star_depth - 1.0).abs() < 1e-5
                && (new.star_depth / space.star_depth - 1.75).abs() < 1e-4,
            "{worst}"
        );
        let mut hidden = first.clone();
        hidden.stars[0].visible = false;
        let (fewer, new) = follow(hidden);
        assert!(data(&fewer.unwrap()) == data(&new));
        let larger: Arc<dyn Field> = Arc::new(Fbm { radius: 1.1, ..Fbm::new(1) });
        assert!(follow(pair(&larger, BEFORE, 4.0)).0.is_none());
        let mut finer = first.clone();
        finer.method.bake = Some(22);
        assert!(follow(finer).0.is_none());
    }

    /// A moved star has the depths of a plan that was made with it there, bit by bit; who holds the space of before
    /// keeps it; a stopped move changes nothing.
    #[test]
    fn a_star_moves() {
        let data = |plan: &Plan| data(&plan.space);
        let (first, there) = (plan(BEFORE), plan(THERE));
        let mut moved = first.clone();
        moved.move_star(1, THERE, &Control::default()).unwrap();
        assert!(data(&moved) == data(&there) && moved.space.star_depth == there.space.star_depth);
        assert!(data(&first) != data(&there) && data(&first) == data(&plan(BEFORE)));
        let stop = Control::default();
        stop.interrupt();
        let mut stopped = first.clone();
        assert!(stopped.move_star(1, DVec3::ZERO, &stop).is_err());
        assert!(data(&stopped) == data(&first) && stopped.space.stars == first.space.stars);
        assert!(stopped.move_star(2, DVec3::ZERO, &Control::default()).is_err());
        assert!(stopped.move_star(1, DVec3::NAN, &Control::default()).is_err());
    }
}
