//! Conversion of light to images: stars are drawn, errors and origin stated.

use super::{Radiance, describe, reference};
use crate::control::Control;
use crate::error::Result;
use crate::geometry::Ray;
use crate::image::{Band, Image, PointSource, Report, Samples};
use crate::plan::{Plan, Planned};
use crate::points::{self, Sources};
use crate::scene::Scene;

/// An image of the extended light in `radiance` with the stars of a plan.
///
/// # Errors
/// Radiances that are not finite, a star field with too many stars, and interruption by the user.
pub(super) fn finished(planned: &Planned, mut radiance: Radiance, backend: &str, control: &Control) -> Result<Image> {
    let points = draw(planned.sources, planned, control, |i, value| radiance.samples.add(i, value))?;
    Ok(Image { points, ..stated(planned, radiance, backend)? })
}

/// An image of all light, with the errors that a plan states.
///
/// # Errors
/// Radiances that are not finite.
pub(super) fn stated(planned: &Planned, radiance: Radiance, backend: &str) -> Result<Image> {
    let mut image = described(planned, radiance.samples)?;
    image.report = planned.report(backend, &radiance.stats);
    image.report.notes.extend(radiance.report.notes);
    Ok(image)
}

/// An image of the extended light in `radiance` with the stars of the scene behind exact depths, of `accuracy`.
///
/// # Errors
/// A star field with too many stars, and interruption by the user.
pub(super) fn drawn_exactly(scene: &Scene, accuracy: f64, radiance: Radiance, backend: &str, control: &Control) -> Result<Image> {
    let Radiance { mut samples, errors, report, .. } = radiance;
    let points = reference::draw_points(scene, accuracy, control, |i, value| samples.add(i, value))?;
    let mut image = describe(scene, &scene.camera, samples);
    if let Some(errors) = errors {
        image.samples.append(errors);
        let bands: Vec<Band> = image.bands.iter().map(|band| Band { keywords: Vec::new(), ..band.of_errors() }).collect();
        image.bands.extend(bands);
    }
    Ok(Image { points, report: Report { backend: Some(backend.to_owned()), ..report }, ..image })
}

/// An image of the extended light alone, bands × height × width [W m⁻² sr⁻¹], of which nothing is stated.
///
/// # Errors
/// Radiances that are not finite.
pub fn described(planned: &Planned, samples: Samples) -> Result<Image> {
    let image = describe(planned.scene(), &planned.camera, samples);
    image.check()?;
    Ok(image)
}

/// Draws unresolved sources as the plan's camera sees them: `add` receives indices in bands × height × width, and
/// radiances [W m⁻² sr⁻¹].
///
/// # Errors
/// If the star field has too many stars, and on interruption by the user.
pub fn draw(sources: Sources, planned: &Planned, control: &Control, add: impl FnMut(usize, f64)) -> Result<Vec<PointSource>> {
    let far = end_of_space(planned);
    let depth = |_: usize, ray: &Ray, length: f64| planned.space.depth(ray.origin, ray.at(length.min(far)));
    draw_behind(sources, planned, depth, control, add)
}

/// A distance from the camera behind which nothing absorbs \[pc\].
pub(crate) fn end_of_space(plan: &Plan) -> f64 {
    2.0 * plan.space.occupied.map_or(0.0, |b| b.size().length() + (0.5 * (b.low + b.high) - plan.camera.position).length())
}

/// Draws unresolved sources behind depths: `depth(source, length)` on a length of the ray \[pc\].
pub(super) fn draw_behind(
    sources: Sources,
    planned: &Planned,
    depth: impl Fn(usize, &Ray, f64) -> f64 + Sync,
    control: &Control,
    add: impl FnMut(usize, f64),
) -> Result<Vec<PointSource>> {
    let fluxes = |number: usize, light: usize, ray: &Ray, length: f64| {
        let depth = depth(number, ray, length);
        planned.spectral.bands.iter().map(|band| band.rule.evaluate(light, depth)).collect()
    };
    points::draw(sources, planned.scene(), &planned.camera, &planned.lights, fluxes, control, add)
}
