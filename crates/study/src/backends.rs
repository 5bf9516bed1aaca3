//! The back ends that the study measures, by their names in the registry.

use barnard::backend::path::{self, PathTracer};
use barnard::backend::{Backend, Job, Radiance, Registry, Renderer};
use barnard::control::Control;
use barnard::error::Result;
use barnard::image::Image;
use barnard::plan::{Options, Planned};
use barnard::scene::Scene;

fn named(name: &str, scene: &Scene) -> Result<Box<dyn Backend>> {
    (Registry::default().by_name(name)?.open)(scene)
}

/// The light of a plan on the processor.
pub fn light(plan: &Planned, control: &Control) -> Result<Radiance> {
    named("cpu", plan.scene())?.radiance(&Job::from(plan), control)
}

/// The light of a plan on the processor, bands × height × width \[W m⁻² sr⁻¹\].
pub fn values(plan: &Planned, control: &Control) -> Result<Vec<f64>> {
    let samples = light(plan, control)?.samples;
    Ok((0..samples.len()).map(|i| samples.at(i)).collect())
}

/// The image of a plan on the processor.
pub fn picture(plan: &Planned, control: &Control) -> Result<Image> {
    Ok(Renderer::new(&mut *named("cpu", plan.scene())?).render(plan, control)?.0)
}

/// The picture of a scene by the reference, at its default accuracy.
pub fn reference(scene: &Scene, control: &Control) -> Result<Image> {
    let options = Options::default();
    Ok(Renderer::new(&mut *named("reference", scene)?).render(Job::new(scene, &options)?, control)?.0)
}

/// Result of the path tracer: their film holds means with standard errors.
pub fn paths(scene: &Scene, options: path::Options, control: &Control) -> Result<PathTracer> {
    let mut tracer = PathTracer::new(options);
    tracer.radiance(&Job::new(scene, &Options::default())?, control)?;
    Ok(tracer)
}
