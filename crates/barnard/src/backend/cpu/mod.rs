//! The fast picture on the processor: f32, sixteen rays at a time, all cores, and the same bits on any number of
//! threads.
//!
//! A tile of 4 × 4 rays is one packet (`march`); packets share nothing, so the order in which threads take them does
//! not matter.

mod borders;
pub mod bricks;
mod context;
#[doc(hidden)]
mod detail;
mod double_integration;
mod light_sums;
mod march;
mod near_field;
mod phase_rows;
mod plates;
mod propagation;
mod segment;
mod shading;
mod state;
mod tables;
mod terms;

use rayon::prelude::*;

use super::{Backend, BackendEntry, DeviceUse, Job, Radiance, RenderStats};
use crate::camera::Camera;
use crate::control::{Control, Stage};
use crate::error::Result;
use crate::geometry::Ray;
use crate::light::LightPart;
use crate::packet::LANES;
use crate::plan::{Plan, Planned};
use march::March;
pub(crate) use plates::{Combined, combined};
#[doc(hidden)]
pub use segment::EVEN_FRONT;
use tables::Tables;

/// Rays along each edge of a packet's tile.
const TILE: usize = 4;

/// The row of this back end in the catalogue.
pub const ENTRY: BackendEntry = BackendEntry {
    name: "cpu",
    summary: "f32, SIMD, all cores; the same bits on any number of threads",
    planned: true,
    device: DeviceUse::Never,
    open: |_| Ok(Box::new(Cpu)),
};

/// The processor: all cores, sixteen rays at a time.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cpu;

impl Backend for Cpu {
    fn name(&self) -> String {
        ENTRY.name.into()
    }

    fn radiance(&mut self, job: &Job, control: &Control) -> Result<Radiance> {
        let (data, stats) = radiance(job.plan(control)?, control)?;
        Ok(Radiance::single(data, stats))
    }
}

/// The extended light of a plan, without stars that are seen as points: bands × height × width [W m⁻² sr⁻¹].
///
/// # Errors
/// On interruption by the user.
pub fn radiance(plan: &Plan, control: &Control) -> Result<(Vec<f32>, RenderStats)> {
    let tables = Tables::new(plan);
    let march = March::new(plan, &tables, None);
    let (data, depth) = marched(&plan.camera, plan.spectral.bands.len(), |(rays, numbers)| march.packet(rays, numbers), control)?;
    let negative = data.iter().filter(|v| **v < 0.0).count() as u64;
    Ok((data, stats_of(plan, depth, negative)))
}

/// Measurements of a march of all rays of a plan.
fn stats_of(plan: &Plan, depth: f32, negative: u64) -> RenderStats {
    let tiles = |pixels: usize| (pixels * plan.camera.supersampling).div_ceil(TILE);
    let rays = (tiles(plan.camera.width) * tiles(plan.camera.height) * LANES) as u64;
    RenderStats { depth: f64::from(depth), rays, storage: plan.storage(), negative }
}

/// Origin distance of the light and the optical depth in front of it.
#[derive(Debug)]
pub struct Distances {
    /// The light of dust and gas in all bands, times its distance [pc W m⁻² sr⁻¹] and as it is [W m⁻² sr⁻¹], 2 × height × width.
    pub depth: Vec<f32>,
    /// The optical depth at V, and the part of light at V that is taken \[1\], 2 × height × width.
    pub tau: Vec<f32>,
}

/// Measures how far the light of a plan comes from: rays are followed to the end of the dust.
///
/// # Errors
/// On interruption by the user.
pub fn distances(plan: &Planned, control: &Control) -> Result<Distances> {
    let plan = &plan.only(|part| part != LightPart::Background);
    let tables = Tables::new(plan);
    let march = March::new(plan, &tables, None).measuring();
    let (mut depth, _) = marched(&plan.camera, 4, |(rays, numbers)| (march.distances(rays, numbers), 0.0), control)?;
    let tau = depth.split_off(depth.len() / 2);
    Ok(Distances { depth, tau })
}

/// The rays of a packet, and their numbers in the image.
type RayPacket<'a> = (&'a [Ray; LANES], &'a [u64; LANES]);

/// What `packet` finds on the rays of a camera, channel × lane, as an image of channels × height × width; and the largest of
/// its other results.
fn marched(
    camera: &Camera,
    channels: usize,
    packet: impl Fn(RayPacket) -> (Vec<f32>, f32) + Sync,
    control: &Control,
) -> Result<(Vec<f32>, f32)> {
    let s = camera.supersampling;
    let (width, height) = (camera.width, camera.height);
    let columns = (width * s).div_ceil(TILE);
    let done = std::sync::atomic::AtomicU64::new(0);
    // Rows of pixels that hold whole tiles, channel by channel: TILE · s rows of rays, TILE rows of pixels.
    let mut data = vec![0.0; channels * width * height];
    let mut strips: Vec<Vec<&mut [f32]>> = (0..height.div_ceil(TILE)).map(|_| Vec::new()).collect();
    for channel in data.chunks_exact_mut(width * height) {
        channel.chunks_mut(TILE * width).zip(&mut strips).for_each(|(part, strip)| strip.push(part));
    }
    let strip = |(strip, mut pixels): (usize, Vec<&mut [f32]>)| -> Result<f32> {
        control.check()?;
        let first = strip * TILE;
        let strip_rows = TILE.min(height - first);
        let mut deepest = 0.0f32;
        let share = 1.0 / (s * s) as f32;
        for tile_row in 0..s {
            for tile in 0..columns {
                let place = |lane: usize| ((tile * TILE + lane % TILE), (first * s + tile_row * TILE + lane / TILE));
                let places: [(usize, usize); LANES] = std::array::from_fn(place);
                let middle = |(x, y)| ((x as f64 + 0.5) / s as f64, (y as f64 + 0.5) / s as f64);
                let ray = |(x, y): (usize, usize)| {
                    let (column, row) = middle((x.min(width * s - 1), y.min(height * s - 1)));
                    camera.ray(column, row)
                };
                let seen = places.map(middle).map(|(column, row)| camera.sees(column, row));
                if !seen.contains(&true) {
                    continue;
                }
                let (found, depth) = packet((&places.map(ray), &places.map(|(x, y)| (y * width * s + x) as u64)));
                deepest = deepest.max(depth);
                for (lane, (x, y)) in places.into_iter().enumerate() {
                    if x < width * s && y < (first + strip_rows) * s && seen[lane] {
                        let (column, row) = (x / s, y / s - first);
                        for channel in 0..channels {
                            pixels[channel][row * width + column] += share * found[channel * LANES + lane];
                        }
                    }
                }
            }
        }
        let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        control.report(Stage::Rays, count, height.div_ceil(TILE) as u64);
        Ok(deepest)
    };
    let depth = strips.into_par_iter().enumerate().map(strip).try_reduce(|| 0.0, |a, b| Ok(a.max(b)))?;
    Ok((data, depth))
}
