//! Renders in one call.

use crate::backend::cpu::Cpu;
use crate::backend::{Backend, Job};
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

/// Renders like [`render`], while `control` hears of progress and can stop the work.
///
/// # Errors
/// Errors of [`render`], and [`Interrupted`](crate::Error::Interrupted).
pub fn render_with(scene: &Scene, options: &Options, control: &Control) -> Result<Image> {
    Ok(Cpu.render(&Job::new(scene, options)?, control)?.0)
}
