//! Densities as grids: grids as they are, functions sampled.

use std::sync::Arc;

use crate::control::Control;
use crate::error::Result;
use crate::field::{Field, Grid, Lattice};
use crate::memory;
use crate::plan::Options;
use crate::scene::{Method, Scene};

/// The most voxels along an edge of a function without a stated resolution.
pub const MAX_BAKE: usize = 256;
/// Fewest voxels along the longest edge of a sampled function.
pub const MIN_BAKE: usize = 32;

/// The resolution at which functions are sampled, in voxels along the longest edge, or merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BakeResolution {
    /// The number that the scene's method states.
    pub fixed: Option<usize>,
    /// The least number of voxels.
    pub least: usize,
    /// The largest number of voxels; those of grids are merged to no more.
    pub most: usize,
}

impl BakeResolution {
    /// The resolution that a method states, otherwise that of each function's finest structure.
    pub fn of(method: &Method) -> Self {
        Self { fixed: method.bake, least: MIN_BAKE, most: usize::MAX }
    }
}

/// The scene with grids in place of functions, so that every back end sees the same samples.
///
/// # Errors
/// If samples would take more memory than allowed, or are no densities.
pub fn sample_functions(scene: &Scene, options: &Options) -> Result<Scene> {
    let grids = sampled_densities(scene, options, &Control::default())?;
    let mut spec = scene.as_lights();
    let densities = spec.dust.iter_mut().map(|dust| &mut dust.density).chain(spec.emission.iter_mut().map(|gas| &mut gas.density));
    densities.zip(grids).for_each(|(density, grid)| *density = Arc::new(grid));
    spec.build()
}

/// The densities of a scene in their order, grids as they are, functions as plans sample them.
///
/// # Errors
/// Errors of [`sample_functions`], and on interruption by the user.
pub fn sampled_densities(scene: &Scene, options: &Options, control: &Control) -> Result<Vec<Grid>> {
    let dust = scene.dust.iter().map(|dust| ("dust", &dust.density));
    let all = dust.chain(scene.species().iter().map(|gas| (&*gas.name, &gas.density)));
    all.map(|(name, density)| baked(density, 1.0, name, options, BakeResolution::of(&scene.method), control)).collect()
}

/// Voxels along the longest edge of a function's box.
fn edge(field: &Arc<dyn Field>, resolution: BakeResolution) -> usize {
    let finest = (field.bounds().size().max_element() / field.feature_pc()).ceil() as usize;
    resolution.fixed.unwrap_or(finest.clamp(MIN_BAKE, MAX_BAKE).max(resolution.least)).min(resolution.most)
}

/// The field as a grid, sampled if it is a function.
pub(in crate::plan) fn baked(
    field: &Arc<dyn Field>,
    factor: f64,
    what: &str,
    options: &Options,
    resolution: BakeResolution,
    control: &Control,
) -> Result<Grid> {
    if let Some(grid) = field.grid() {
        let longest = grid.lattice().dims.into_iter().max().unwrap_or(1);
        let merged = longest.div_ceil(resolution.most.max(1));
        let scaled = if merged > 1 { grid.merged(merged, factor) } else { grid.scaled(factor) };
        scaled.check(what)?;
        return Ok(scaled);
    }
    let lattice = Lattice::along(field.bounds(), edge(field, resolution));
    memory::check(&format!("{what}, sampled"), 4 * lattice.cells() as u64, options.memory_limit)?;
    let grid = Grid::from_function(field, lattice, factor, options.cache.as_deref(), control)?;
    grid.check(what)?;
    Ok(grid)
}
