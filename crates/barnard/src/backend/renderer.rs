//! Finished images from the light of back ends: eyes, stars, layers and statements.
//!
//! An image with layers is the sum of its parts as they are rendered: the sum of all layers of light is the image, bit by bit but for
//! the rounding of sums. Plans stay whole: each part is marched with the rules, steps and star depths of all.

use super::finish::{drawn_exactly, finished};
use super::{Backend, Input, Job, Radiance, RenderStats, cpu};
use crate::composite::joined;
use crate::control::Control;
use crate::error::Result;
use crate::image::{Image, Layer, LayerContent, Samples};
use crate::light::LightPart;
use crate::scene::Scene;

/// Renders finished images by a back end.
pub struct Renderer<'a> {
    backend: &'a mut dyn Backend,
}

impl<'a> Renderer<'a> {
    /// A renderer by a back end.
    pub fn new(backend: &'a mut dyn Backend) -> Self {
        Self { backend }
    }

    /// Renders a job: both eyes of a stereo camera, with the layers that the scene's output requests.
    ///
    /// # Errors
    /// Errors of the back end and of [`finish`](Self::finish); layers that the back end does not support.
    pub fn render<'j>(&mut self, job: impl Into<Job<'j>>, control: &Control) -> Result<(Image, RenderStats)> {
        let job = job.into();
        let camera = &job.scene().camera;
        let (Some(stereo), Some([left, right])) = (camera.stereo, camera.eyes()) else { return layered(self, &job, control) };
        let mut of_eye = |eye, control: &Control| layered(self, &job.seen_by(eye, control)?, control);
        let (left, stats) = of_eye(left, &control.part(0.0, 0.5))?;
        let (right, more) = of_eye(right, &control.part(0.5, 1.0))?;
        Ok((joined(stereo.arrangement, left, &right)?, stats.and(more)))
    }

    /// The image of one eye without layers.
    fn whole(&mut self, job: &Job, control: &Control) -> Result<(Image, RenderStats)> {
        let radiance = self.backend.radiance(job, control)?;
        let stats = radiance.stats;
        Ok((self.finish(job, radiance, control)?, stats))
    }

    /// The image of a job's light: with stars drawn, errors and origin stated.
    ///
    /// # Errors
    /// Radiances that are not finite, a star field with too many stars, and interruption by the user.
    pub fn finish(&self, job: &Job, radiance: Radiance, control: &Control) -> Result<Image> {
        match self.backend.input() {
            Input::Plan => finished(job.plan(control)?, radiance, &self.backend.name(), control),
            Input::Scene { accuracy } => drawn_exactly(job.scene(), accuracy, radiance, &self.backend.name(), control),
        }
    }
}

/// The picture of one eye with the layers that its scene's output asks for.
fn layered(renderer: &mut Renderer, job: &Job, control: &Control) -> Result<(Image, RenderStats)> {
    let choice = job.scene().output.layers;
    // Light takes most of the time.
    let share = if choice.depth || choice.tau { 0.8 } else { 1.0 };
    let (of_light, of_distances) = (control.part(0.0, share), control.part(share, 1.0));
    let (mut image, stats) = if choice.light { in_parts(renderer, job, &of_light)? } else { renderer.whole(job, &of_light)? };
    if choice.depth || choice.tau {
        let cpu::Distances { depth, tau } = cpu::distances(job.plan(control)?, &of_distances)?;
        let measured = [(choice.depth, "depth", LayerContent::Depth, depth), (choice.tau, "tau", LayerContent::OpticalDepth, tau)];
        let asked = measured.into_iter().filter(|(asked, ..)| *asked);
        image.layers.extend(asked.map(|(_, name, content, values)| Layer { name: name.into(), content, samples: Samples::Single(values) }));
    }
    Ok((image, stats))
}

/// The picture whose light is rendered part by part, each a layer.
fn in_parts(renderer: &mut Renderer, job: &Job, control: &Control) -> Result<(Image, RenderStats)> {
    let scene = job.scene();
    let parts = LightPart::of(scene);
    let extended: Vec<LightPart> = parts.iter().copied().filter(|part| *part != LightPart::Stars).collect();
    let mut layers = Vec::new();
    let mut sum: Option<Radiance> = None;
    for (i, part) in extended.iter().enumerate() {
        let share = |i: usize| i as f64 / extended.len() as f64;
        let control = control.part(share(i), share(i + 1));
        let of_part = match renderer.backend.input() {
            Input::Plan => Job::of(job.plan(&control)?.only(|other| other == *part), job.options()),
            Input::Scene { .. } => Job::new(part.alone(scene)?, job.options())?,
        };
        let part_radiance = renderer.backend.radiance(&of_part, &control)?;
        layers.push(Layer { name: name(*part, scene, &layers), content: LayerContent::Light, samples: part_radiance.samples.clone() });
        match &mut sum {
            Some(sum) => {
                sum.samples.add_all(&part_radiance.samples);
                sum.stats = sum.stats.and(part_radiance.stats);
            }
            None => sum = Some(part_radiance),
        }
    }
    let radiance = match sum {
        Some(sum) => sum,
        // Nothing but points.
        None => renderer.backend.radiance(job, control)?,
    };
    let stats = radiance.stats;
    if parts.contains(&LightPart::Stars) {
        let dark = Radiance { samples: radiance.samples.zeroed(), ..radiance.clone() };
        let samples = renderer.finish(job, dark, control)?.samples;
        layers.push(Layer { name: name(LightPart::Stars, scene, &layers), content: LayerContent::Light, samples });
    }
    let image = renderer.finish(job, radiance, control)?;
    Ok((Image { layers, ..image }, stats))
}

/// The name of a part's layer, as channels of files have them: no two are the same, and none holds a dot or a blank.
fn name(part: LightPart, scene: &Scene, others: &[Layer]) -> String {
    let plain_name = match part {
        LightPart::Scattered => "scattered".into(),
        LightPart::Emission { species } => {
            let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
            format!("emission.{}", scene.species()[species].name.chars().map(plain).collect::<String>())
        }
        LightPart::Background => "background".into(),
        LightPart::Stars => "stars".into(),
    };
    let mut names = std::iter::once(plain_name.clone()).chain((2..).map(|i| format!("{plain_name}_{i}")));
    names.find(|name| others.iter().all(|layer| layer.name != *name)).unwrap_or(plain_name)
}
