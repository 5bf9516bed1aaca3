//! Spatial plan: density, star depths, empty space.

pub(in crate::plan) mod bake;
mod brick;
mod layout;
mod update;

pub use bake::{sample_functions, sampled_densities};
pub use brick::{BrickFields, densities};

use std::sync::Arc;

use glam::DVec3;

use crate::blocks::Storage;
use crate::camera::Camera;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Fbm, Field, Grid, column};
use crate::geometry::{Bounds, Ray};
use crate::image::SpatialError;
use crate::plan::many_lights;
use crate::plan::many_lights::ManyLights;
use crate::plan::spatial::bake::{BakeResolution, baked};
use crate::plan::{Options, star_depths};
use crate::scene::{Scene, Sparsity};
use crate::stored::Precision;
use crate::volume::{Bricks, Channel, Volume};

/// Depth at V that no light of any wavelength comes through, from an eye through all dust to a star.
const DEEPEST: f64 = 10.0 * star_depths::OPAQUE;
/// Depth at V of a star's own voxel of which no visible light comes out: e^(−80) is below the smallest f32 beside 1.
const SWALLOWED: f64 = 80.0;

/// Density and star depths, sampled.
#[derive(Debug, Clone)]
pub struct SpatialPlan {
    /// The volumes that the march reads; spaces that differ in other things share them.
    pub volumes: Vec<Arc<Volume>>,
    /// Dust alone, σ at V [pc⁻¹], for exact depths.
    pub dust: Option<Arc<Grid>>,
    /// The noise that the dust is, and σ at V of one [pc⁻¹], for back ends that evaluate it at every sample.
    pub cloud: Option<(Fbm, f64)>,
    /// The bricks of each grid, the dust first, then the gas of each species: zero where nothing absorbs, scatters or glows.
    pub bricks: Vec<Bricks>,
    /// Places of the stars \[pc\].
    pub stars: Vec<DVec3>,
    /// The stars whose light is gathered, where some are.
    pub many_lights: Option<Arc<ManyLights>>,
    /// Numbers of the others, which have depths in volumes of their own.
    marched: Vec<usize>,
    /// Star depth voxels along a voxel of dust.
    pub star_factor: usize,
    /// Largest star depth at a place with dust \[1\].
    pub star_depth: f64,
    /// The spatial error that the pilot rays measured.
    pub spatial: Option<SpatialError>,
    /// The smallest box around everything that absorbs, scatters or glows.
    pub occupied: Option<Bounds>,
    emission: Vec<Grid>,
    /// Edges of the voxels of all grids \[pc\], each kind once.
    voxels: Vec<DVec3>,
    /// The densities that were sampled: dust, then gas.
    densities: Vec<Arc<dyn Field>>,
    /// The extinction σ at V of a density of one [pc⁻¹].
    sigma_v_per_pc: f64,
    /// How volumes are stored.
    pub precision: Precision,
    /// True if pages of them that are empty are left out.
    sparsity: Sparsity,
    /// The resolution that was asked for functions.
    resolution: BakeResolution,
}

fn sigma_v_per_pc(scene: &Scene) -> f64 {
    scene.dust.as_ref().map_or(0.0, |d| d.sigma_v_per_pc)
}

/// The noise that the dust of a scene is, and σ at V of one [pc⁻¹].
fn cloud(scene: &Scene) -> Option<(Fbm, f64)> {
    scene.dust.as_ref().and_then(|d| d.density.fbm().map(|fbm| (fbm.clone(), d.sigma_v_per_pc)))
}

/// Edges of the voxels of some grids \[pc\], each kind once.
fn voxels<'a>(grids: impl Iterator<Item = &'a Grid>) -> Vec<DVec3> {
    let mut voxels: Vec<DVec3> = grids.map(|g| g.lattice().voxel_pc()).collect();
    voxels.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).unwrap_or(std::cmp::Ordering::Equal));
    voxels.dedup();
    voxels
}

/// The smallest box around what is not empty.
fn occupied<'a>(grids: impl Iterator<Item = &'a Grid>, bricks: &[Bricks]) -> Option<Bounds> {
    grids.zip(bricks).filter_map(|(g, b)| b.occupied(&g.lattice().bounds)).reduce(|a, b| a.union(&b))
}

impl SpatialPlan {
    /// Samples densities and bakes star depths at the dust's own resolution.
    pub(crate) fn new(scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        Self::sampled(scene, options, BakeResolution::of(&scene.method), control)
    }

    /// Copy of the scene with no more than `most` voxels along an edge: functions are sampled so, voxels of grids merged.
    pub(crate) fn coarse(scene: &Scene, options: &Options, most: usize, control: &Control) -> Result<Self> {
        Self::sampled(scene, options, BakeResolution { most, ..BakeResolution::of(&scene.method) }, control)
    }

    fn sampled(scene: &Scene, options: &Options, resolution: BakeResolution, control: &Control) -> Result<Self> {
        let dust = scene.dust.as_ref().map(|d| baked(&d.density, d.sigma_v_per_pc, "dust", options, resolution, control)).transpose()?;
        let emission =
            scene.species().iter().map(|e| baked(&e.density, 1.0, &e.name, options, resolution, control)).collect::<Result<Vec<_>>>()?;
        let bricks: Vec<Bricks> = dust.iter().chain(&emission).map(Bricks::new).collect();
        let mut space = Self {
            volumes: Vec::new(),
            occupied: occupied(dust.iter().chain(&emission), &bricks),
            voxels: voxels(dust.iter().chain(&emission)),
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
            densities: scene.densities().cloned().collect(),
            sigma_v_per_pc: sigma_v_per_pc(scene),
            precision: scene.method.volumes,
            sparsity: scene.method.sparse,
            resolution,
        };
        space.part_stars(&many_lights::members(scene), options, control)?;
        space.refine_stars(1, scene, options, control)?;
        Ok(space)
    }

    /// Storage precision of the least exact grid in the densities.
    pub fn grid_storage(&self) -> Storage {
        self.densities.iter().map(|field| field.storage()).max().unwrap_or_default()
    }

    /// True if a density is a function, of which the march has samples alone.
    pub fn is_sampled(&self) -> bool {
        self.densities.iter().any(|field| field.grid().is_none())
    }

    /// True if the dust is a function, of which the march has samples alone.
    pub fn depth_is_sampled(&self) -> bool {
        self.density().is_some_and(|field| field.grid().is_none())
    }

    /// True if a density is a function that jumps.
    pub fn has_edges(&self) -> bool {
        self.densities.iter().any(|field| field.has_edges())
    }

    /// Voxels along the longest edge of the function that is sampled most coarsely; none where nothing is sampled.
    pub fn sampled_edge(&self) -> Option<usize> {
        let grids = self.dust.iter().map(|d| &**d).chain(&self.emission);
        let sampled = grids.zip(&self.densities).filter(|(_, field)| field.grid().is_none());
        sampled.filter_map(|(grid, _)| grid.lattice().dims.into_iter().max()).min()
    }

    /// σ at V [pc⁻¹] at a place, of the field itself.
    pub fn sigma_at(&self, p: DVec3) -> f64 {
        self.density().map_or(0.0, |field| field.at(p) * self.sigma_v_per_pc)
    }

    /// σ at V [pc⁻¹] at many places, of the field itself.
    pub fn dust_at(&self, places: &[DVec3]) -> Vec<f64> {
        let mut values = vec![0.0; places.len()];
        if let Some(field) = self.density() {
            field.sample(places, &mut values);
            values.iter_mut().for_each(|value| *value *= self.sigma_v_per_pc);
        }
        values
    }

    /// The density of a glowing species at many places, of the field itself.
    pub fn gas_at(&self, species: usize, places: &[DVec3]) -> Vec<f64> {
        let mut values = vec![0.0; places.len()];
        self.densities[usize::from(self.dust.is_some()) + species].sample(places, &mut values);
        values
    }

    /// The density of dust itself, where there is dust.
    fn density(&self) -> Option<&dyn Field> {
        self.dust.as_ref().and_then(|_| self.densities.first()).map(|field| &**field)
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

    /// The optical depth at V between two places through the dust itself, less that through its samples \[1\]; zero
    /// where dust is a grid.
    pub fn depth_beyond_samples(&self, a: DVec3, b: DVec3) -> f64 {
        match self.density().filter(|field| field.grid().is_none()) {
            Some(field) => self.sigma_v_per_pc * column(field, a, b) - self.depth(a, b),
            None => 0.0,
        }
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
        self.volumes.iter().map(|v| &**v).find_map(|v| v.channels.iter().position(|c| *c == Channel::StarDepth(star)).map(|slot| (v, slot)))
    }

    /// The finest voxel edge \[pc\].
    pub fn voxel_pc(&self) -> f64 {
        self.voxels.iter().map(|voxel| voxel.min_element()).fold(f64::INFINITY, f64::min)
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
    pub fn voxels(&self) -> &[DVec3] {
        &self.voxels
    }

    /// Densities of glowing species, each in its own unit.
    pub fn gas(&self) -> &[Grid] {
        &self.emission
    }

    /// Values u of the front at which gas ends \[1\]; all species that have a front share it.
    pub fn front(&self) -> Option<&Grid> {
        self.emission.iter().find_map(Grid::front)
    }

    /// The number of glowing species.
    pub fn species(&self) -> usize {
        self.emission.len()
    }

    /// The optical depth at V between two places, exact through the samples of the dust, cut where nothing is left \[1\].
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

    /// Numbers of the stars that have depths in volumes of their own.
    pub fn marched(&self) -> &[usize] {
        &self.marched
    }

    /// Refuses a star whose own cell already swallows all of its light.
    ///
    /// # Errors
    /// If there is one, with its name.
    pub fn check_stars(&self, scene: &Scene) -> Result<()> {
        let Some(dust) = &self.dust else { return Ok(()) };
        let edge = dust.lattice().voxel_pc().max_element();
        for star in &scene.stars {
            let depth_of_voxel = dust.at(star.position) * edge;
            if depth_of_voxel > SWALLOWED {
                return Err(Error::Star(format!(
                    "{} is in a voxel of optical depth {depth_of_voxel:.1}, so none of its light escapes; move the star, or carve a hole such as density = \"cloud * step((x-X)^2+(y-Y)^2+(z-Z)^2, R^2)\"",
                    star.name
                )));
            }
        }
        Ok(())
    }
}
