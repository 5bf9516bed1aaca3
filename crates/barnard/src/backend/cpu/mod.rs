//! The fast picture on the processor: f32, sixteen rays at a time, all cores, and the same bits on any number of threads.
//!
//! A tile of 4 × 4 rays is one packet (`march`); packets share nothing, so the order in which threads take them does not matter.

mod borders;
mod double_integration;
mod march;
mod neighbours;
mod propagation;
mod segment;
mod tables;
mod terms;

use rayon::prelude::*;

use crate::control::{Control, Stage};
use crate::error::Result;
use crate::geometry::Ray;
use crate::image::{Image, Samples};
use crate::keywords;
use crate::packet::LANES;
use crate::plan::{Plan, SINGLE, describe};
use crate::points::{self, Sources};
use crate::scene::Scene;
use march::March;
use tables::Tables;

/// Rays along each edge of a packet's tile.
const TILE: usize = 4;

/// What a render found beside the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Findings {
    /// The largest optical depth, eye to sample to star, that was met [1].
    pub depth: f64,
    /// Rays that were marched.
    pub rays: u64,
    /// Largest relative error of a density as the march keeps it: [`SINGLE`] or [`HALF`](crate::plan::HALF).
    pub storage: f64,
    /// Values below zero, which a projection can make where little light is left.
    pub negative: u64,
}

impl Findings {
    /// The values below zero in words, where there are any.
    pub fn negative_note(&self) -> Option<(String, String)> {
        (self.negative > 0).then(|| ("negative values".into(), format!("{} pixels of all bands together, left as they are", self.negative)))
    }
}

/// Band radiances of the extended light alone, bands × height × width [W m⁻² sr⁻¹], and what was found.
pub fn radiance(plan: &Plan, control: &Control) -> Result<(Vec<f32>, Findings)> {
    let camera = &plan.camera;
    let s = camera.supersampling;
    let (width, height) = (camera.width, camera.height);
    let (columns, rows) = ((width * s).div_ceil(TILE), (height * s).div_ceil(TILE));
    let tables = Tables::new(plan);
    let march = March::new(plan, &tables);
    let bands = plan.spectral.bands.len();
    let done = std::sync::atomic::AtomicU64::new(0);
    // Rows of pixels that hold whole tiles, band by band: TILE · s rows of rays, TILE rows of pixels.
    let mut data = vec![0.0; bands * width * height];
    let mut strips: Vec<Vec<&mut [f32]>> = (0..height.div_ceil(TILE)).map(|_| Vec::new()).collect();
    for band in data.chunks_exact_mut(width * height) {
        band.chunks_mut(TILE * width).zip(&mut strips).for_each(|(part, strip)| strip.push(part));
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
                let ray = |lane: usize| -> Ray {
                    let (x, y) = place(lane);
                    camera.ray((x.min(width * s - 1) as f64 + 0.5) / s as f64, (y.min(height * s - 1) as f64 + 0.5) / s as f64)
                };
                let number = |lane: usize| {
                    let (x, y) = place(lane);
                    (y * width * s + x) as u64
                };
                let (radiance, depth) = march.packet(&std::array::from_fn(ray), &std::array::from_fn(number));
                deepest = deepest.max(depth);
                for lane in 0..LANES {
                    let (x, y) = place(lane);
                    if x < width * s && y < (first + strip_rows) * s {
                        let (column, row) = (x / s, y / s - first);
                        for band in 0..bands {
                            pixels[band][row * width + column] += share * radiance[band * LANES + lane];
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
    let negative = data.iter().filter(|v| **v < 0.0).count() as u64;
    Ok((data, Findings { depth: f64::from(depth), rays: (columns * rows * LANES) as u64, storage: SINGLE, negative }))
}

/// Renders the plan of `scene`.
pub fn render(scene: &Scene, plan: &Plan, control: &Control) -> Result<(Image, Findings)> {
    let (data, findings) = radiance(plan, control)?;
    Ok((finished(scene, plan, data, findings, "cpu")?, findings))
}

/// A picture of the extended light in `data` [W m⁻² sr⁻¹], bands × height × width: stars are drawn, errors and origin are told.
pub fn finished(scene: &Scene, plan: &Plan, mut data: Vec<f32>, findings: Findings, backend: &str) -> Result<Image> {
    draw(Sources::All, scene, plan, |i, value| data[i] += value as f32)?;
    let mut image = describe(scene, Samples::Single(data));
    image.check()?;
    for (b, band) in image.bands.iter_mut().enumerate() {
        band.certificate = plan.certificate(b, &findings);
        band.keywords.extend(plan.band_keywords(b, &findings));
    }
    image.keywords.push(keywords::text("BACKEND", backend, "what marched the rays"));
    image.keywords.extend(plan.keywords(&findings));
    image.notes.push(("backend".into(), backend.into()));
    image.notes.push(("method".into(), plan.spectral.method.into()));
    image.notes.extend(plan.notes());
    image.notes.extend(findings.negative_note());
    Ok(image)
}

/// A picture of the extended light in `data` alone, for a look that passes by.
pub fn extended(scene: &Scene, data: Vec<f32>) -> Result<Image> {
    let image = describe(scene, Samples::Single(data));
    image.check()?;
    Ok(image)
}

/// Draws unresolved sources as the plan's camera sees them: `add` hears of places in bands × height × width, and radiances [W m⁻² sr⁻¹].
pub fn draw(sources: Sources, scene: &Scene, plan: &Plan, add: impl FnMut(usize, f64)) -> Result<()> {
    let far = 2.0 * plan.space.occupied.map_or(0.0, |b| b.size().length() + (0.5 * (b.low + b.high) - plan.camera.position).length());
    let depth = |ray: &Ray, length: f64| plan.space.depth(ray.origin, ray.at(length.min(far)));
    let flux = |light: usize, band: usize, depth: f64| plan.spectral.bands[band].rule.evaluate(light, depth);
    points::draw(sources, (scene, &plan.camera), &plan.lights, depth, flux, add)
}
