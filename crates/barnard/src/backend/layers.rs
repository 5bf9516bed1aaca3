//! Pictures with layers: the light of a job part by part, and how far it comes from.
//!
//! The picture is the sum of its parts as they are rendered, so that the sum of all layers of light is the picture, bit by
//! bit but for the rounding of sums. Plans stay whole: each part is marched with the rules, steps and star depths of all.

use super::{Backend, Job, PartsBy, Radiance, RenderStats};
use crate::backend::cpu;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::image::{Image, Layer, LayerContent, Samples};
use crate::light::Part;
use crate::scene::Scene;

/// The picture of one eye with the layers that its scene's output asks for.
pub(super) fn layered<B: Backend + ?Sized>(backend: &mut B, job: &Job, control: &Control) -> Result<(Image, RenderStats)> {
    let choice = job.scene().output.layers;
    // Light takes most of the time.
    let (of_light, of_distances) = (control.part(0.0, 0.8), control.part(0.8, 1.0));
    let (mut image, stats) = if choice.light { in_parts(backend, job, &of_light)? } else { whole(backend, job, &of_light)? };
    if choice.depth || choice.tau {
        let cpu::Distances { depth, tau } = cpu::distances(job.plan(control)?, &of_distances)?;
        let measured = [(choice.depth, "depth", LayerContent::Depth, depth), (choice.tau, "tau", LayerContent::OpticalDepth, tau)];
        let asked = measured.into_iter().filter(|(asked, ..)| *asked);
        image.layers.extend(asked.map(|(_, name, content, values)| Layer { name: name.into(), content, samples: Samples::Single(values) }));
    }
    Ok((image, stats))
}

fn whole<B: Backend + ?Sized>(backend: &mut B, job: &Job, control: &Control) -> Result<(Image, RenderStats)> {
    let radiance = backend.radiance(job, control)?;
    let stats = radiance.stats;
    Ok((backend.finish(job, radiance, control)?, stats))
}

/// The picture whose light is rendered part by part, each a layer.
fn in_parts<B: Backend + ?Sized>(backend: &mut B, job: &Job, control: &Control) -> Result<(Image, RenderStats)> {
    let scene = job.scene();
    let parts_by = backend.parts_by();
    if parts_by == PartsBy::Nothing {
        let alternative = "use cpu, gpu or reference, or remove \"light\" from layers";
        return Err(Error::unsupported("layers of light", format!("back end {}", backend.name()), alternative));
    }
    let parts = Part::of(scene);
    let extended: Vec<Part> = parts.iter().copied().filter(|part| *part != Part::Stars).collect();
    let mut layers = Vec::new();
    let mut sum: Option<Radiance> = None;
    for (i, part) in extended.iter().enumerate() {
        let share = |i: usize| i as f64 / extended.len() as f64;
        let control = control.part(share(i), share(i + 1));
        let own = match parts_by {
            PartsBy::Plan => {
                let plan = job.plan(&control)?.only(|other| other == *part);
                backend.radiance(&Job::planned(scene, job.options(), &plan)?, &control)?
            }
            _ => backend.radiance(&Job::new(&part.alone(scene), job.options())?, &control)?,
        };
        layers.push(Layer { name: name(*part, scene, &layers), content: LayerContent::Light, samples: own.samples.clone() });
        match &mut sum {
            Some(sum) => {
                sum.samples.add_all(&own.samples);
                sum.stats = sum.stats.and(own.stats);
            }
            None => sum = Some(own),
        }
    }
    let radiance = match sum {
        Some(sum) => sum,
        // Nothing but points.
        None => backend.radiance(job, control)?,
    };
    let stats = radiance.stats;
    if parts.contains(&Part::Stars) {
        let dark = Radiance { samples: radiance.samples.zeroed(), stats };
        let samples = backend.finish(job, dark, control)?.samples;
        layers.push(Layer { name: name(Part::Stars, scene, &layers), content: LayerContent::Light, samples });
    }
    let image = backend.finish(job, radiance, control)?;
    Ok((Image { layers, ..image }, stats))
}

/// The name of a part's layer, as channels of files have them: no two are the same, and none holds a dot or a blank.
fn name(part: Part, scene: &Scene, others: &[Layer]) -> String {
    let own = match part {
        Part::Scattered => "scattered".into(),
        Part::Emission { species } => {
            let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
            format!("emission.{}", scene.emission[species].name.chars().map(plain).collect::<String>())
        }
        Part::Background => "background".into(),
        Part::Stars => "stars".into(),
    };
    let mut names = std::iter::once(own.clone()).chain((2..).map(|i| format!("{own}_{i}")));
    names.find(|name| others.iter().all(|layer| layer.name != *name)).unwrap_or(own)
}
