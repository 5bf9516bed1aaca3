//! Renders in one call.

use crate::backend::cpu::Cpu;
use crate::backend::reference::Reference;
use crate::backend::{Job, Renderer};
use crate::control::Control;
use crate::error::Result;
use crate::image::Image;
use crate::plan::Options;
use crate::scene::Scene;

/// Renders `scene` on all cores of the processor, by its own method to its own accuracy.
///
/// # Errors
/// Errors of [`Scene::check`], more memory than [`Options`] allow, and what the scene's method cannot do.
pub fn render(scene: &Scene, options: &Options) -> Result<Image> {
    render_with(scene, options, &Control::default())
}

/// Renders like [`render`], with progress and interruption by `control`.
///
/// # Errors
/// Errors of [`render`], and [`Interrupted`](crate::Error::Interrupted).
pub fn render_with(scene: &Scene, options: &Options, control: &Control) -> Result<Image> {
    Ok(Renderer::new(&mut Cpu).render(Job::new(scene, options)?, control)?.0)
}

/// Renders `scene` exactly, to `accuracy` of each pixel's radiance: slow, for light that scatters once.
///
/// # Errors
/// Errors of [`Scene::check`], if light scatters more than once, and on interruption by the user.
pub fn render_reference(scene: &Scene, accuracy: f64, control: &Control) -> Result<Image> {
    Ok(Renderer::new(&mut Reference { accuracy }).render(Job::new(scene, &Options::default())?, control)?.0)
}
