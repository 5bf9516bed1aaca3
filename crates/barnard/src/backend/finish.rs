//! Conversion of marched light to a picture.

use super::{Radiance, describe};
use crate::control::Control;
use crate::error::Result;
use crate::geometry::Ray;
use crate::image::{Image, PointSource, Samples};
use crate::keywords;
use crate::plan::Plan;
use crate::points::{self, Sources};
use crate::scene::Scene;

/// A picture of the extended light in `radiance`: stars are drawn, errors and origin are told.
///
/// # Errors
/// If values are no numbers, or the star field has too many stars, and on interruption by the user.
pub fn finished(scene: &Scene, plan: &Plan, mut radiance: Radiance, backend: &str, control: &Control) -> Result<Image> {
    let points = draw(plan.sources, scene, plan, control, |i, value| radiance.samples.add(i, value))?;
    Ok(Image { points, ..told(scene, plan, radiance, backend)? })
}

/// A picture of all light: errors and origin are told.
///
/// # Errors
/// If values are no numbers.
pub(super) fn told(scene: &Scene, plan: &Plan, radiance: Radiance, backend: &str) -> Result<Image> {
    let Radiance { samples, stats } = radiance;
    let mut image = describe(scene, &plan.camera, samples);
    image.check()?;
    for (b, band) in image.bands.iter_mut().enumerate() {
        band.certificate = plan.certificate(b, &stats);
        band.keywords.extend(plan.band_keywords(b, &stats));
    }
    image.keywords.push(keywords::text("BACKEND", backend, "device of the ray march"));
    image.keywords.extend(plan.keywords(&stats));
    image.notes.push(("backend".into(), backend.into()));
    image.notes.push(("method".into(), plan.spectral.method.into()));
    image.notes.extend(plan.notes());
    image.notes.extend(stats.negative_note());
    Ok(image)
}

/// A picture of the extended light alone, bands × height × width [W m⁻² sr⁻¹], for a look that passes by.
///
/// # Errors
/// If values are no numbers.
pub fn extended(scene: &Scene, plan: &Plan, samples: Samples) -> Result<Image> {
    let image = describe(scene, &plan.camera, samples);
    image.check()?;
    Ok(image)
}

/// Draws unresolved sources as the plan's camera sees them: `add` hears of places in bands × height × width, and
/// radiances [W m⁻² sr⁻¹].
///
/// # Errors
/// If the star field has too many stars, and on interruption by the user.
pub fn draw(sources: Sources, scene: &Scene, plan: &Plan, control: &Control, add: impl FnMut(usize, f64)) -> Result<Vec<PointSource>> {
    let far = end_of_space(plan);
    let depth = |_: usize, ray: &Ray, length: f64| plan.space.depth(ray.origin, ray.at(length.min(far)));
    draw_behind(sources, scene, plan, depth, control, add)
}

/// A distance from the camera behind which nothing absorbs \[pc\].
pub(crate) fn end_of_space(plan: &Plan) -> f64 {
    2.0 * plan.space.occupied.map_or(0.0, |b| b.size().length() + (0.5 * (b.low + b.high) - plan.camera.position).length())
}

/// Draws unresolved sources behind depths that `depth` tells: of a source by its number, on so much of a ray \[pc\].
pub(super) fn draw_behind(
    sources: Sources,
    scene: &Scene,
    plan: &Plan,
    depth: impl Fn(usize, &Ray, f64) -> f64 + Sync,
    control: &Control,
    add: impl FnMut(usize, f64),
) -> Result<Vec<PointSource>> {
    let fluxes = |number: usize, light: usize, ray: &Ray, length: f64| {
        let depth = depth(number, ray, length);
        plan.spectral.bands.iter().map(|band| band.rule.evaluate(light, depth)).collect()
    };
    points::draw(sources, scene, &plan.camera, &plan.lights, fluxes, control, add)
}
