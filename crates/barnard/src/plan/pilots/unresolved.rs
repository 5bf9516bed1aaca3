//! Error of stars seen through sampled dust functions.

use rayon::prelude::*;

use crate::control::Control;
use crate::error::Result;
use crate::image::UnresolvedStars;
use crate::light::Light;
use crate::plan::{SpatialPlan, SpectralPlan};
use crate::points::{self, Point, Sources};
use crate::scene::Scene;

/// Most stars that are asked.
const ASKED: usize = 64;
/// A star of which less than this is left is compared with this part of its light without dust.
const MIN_LEFT: f64 = 1e-3;

/// Fluxes through the dust itself beside those through its samples, of stars that are taken evenly from those in view;
/// none where dust is a grid or there are no stars.
pub fn error(
    scene: &Scene,
    space: &SpatialPlan,
    spectral: &SpectralPlan,
    lights: &[Light],
    control: &Control,
) -> Result<Option<UnresolvedStars>> {
    let Some(occupied) = space.occupied.filter(|_| space.depth_is_sampled()) else { return Ok(None) };
    let camera = &scene.camera;
    let points = points::points(Sources::All, scene, camera, lights)?;
    let asked: Vec<&Point> = points.iter().step_by(points.len().div_ceil(ASKED).max(1)).collect();
    if asked.is_empty() {
        return Ok(None);
    }
    let far = occupied.size().length() + (0.5 * (occupied.low + occupied.high) - camera.position).length();
    let depths = |point: &&Point| {
        control.check()?;
        let ray = point.ray(camera);
        let end = ray.at(point.length.min(far));
        let sampled = space.depth(ray.origin, end);
        Ok((point.light, sampled, (sampled + space.depth_beyond_samples(ray.origin, end)).max(0.0)))
    };
    let depths: Vec<(usize, f64, f64)> = asked.par_iter().map(depths).collect::<Result<_>>()?;
    let of_band = |band: &crate::plan::BandPlan| {
        let off = |(light, sampled, truly): &(usize, f64, f64)| {
            let [bare, sampled, truly] = [0.0, *sampled, *truly].map(|depth| band.rule.evaluate(*light, depth));
            if bare > 0.0 { ((sampled - truly) / truly.max(MIN_LEFT * bare)).powi(2) } else { 0.0 }
        };
        (depths.iter().map(off).sum::<f64>() / depths.len() as f64).sqrt()
    };
    let error = spectral.bands.iter().map(of_band).fold(0.0, f64::max);
    Ok(Some(UnresolvedStars { error, stars: asked.len() }))
}
