//! Where pictures are made: plans that are kept, marches at several sizes, colours.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use barnard::backend::cpu::{self, Findings};
use barnard::camera::Camera;
use barnard::control::Control;
use barnard::image::{Image, Tone};
use barnard::plan::{Options, Plan};
use barnard::points::Sources;
use barnard::scene::Scene;
use barnard::{Error, Result};
use barnard_gpu::{Gpu, GpuError, Renderer, Tuning};
use eframe::egui::Color32;

use crate::comparison::AMPLIFIED;
use crate::engine::{Order, Quality, View};

/// What the rays of a picture may take while things move, and together with its plan; rays get at least the last of them [s].
const MOVING: f64 = 0.06;
const FRAME: f64 = 0.085;
const RAYS: f64 = 0.02;
/// Rays a second before any was measured.
const FIRST_RATE: f64 = 4e4;
/// How many times fewer pixels each way the next finer picture has not.
const FINER: f64 = 3.0;
/// Fewest pixels along an edge.
const LEAST: f64 = 24.0;

/// A picture and what is known of it.
#[derive(Clone)]
pub struct Picture {
    /// Radiances of all bands.
    pub image: Arc<Image>,
    /// The scene it shows, with the camera it was seen by.
    pub scene: Arc<Scene>,
    /// The plan that made it.
    pub plan: Plan,
    /// What was found on the way.
    pub findings: Findings,
    /// How it is shown.
    pub tone: Tone,
    /// Its colours, height × width.
    pub colours: Arc<Vec<Color32>>,
    /// Stars over a picture that has none, in pixels of the window: column, row, colour.
    pub sparks: Vec<(usize, usize, Color32)>,
    /// How bright the pixels of each band are.
    pub histograms: Vec<Histogram>,
    /// How long its parts took.
    pub times: Times,
    /// What marched the rays.
    pub backend: String,
}

/// How long the parts of a picture took [s].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Times {
    /// The plan; zero where it was still there.
    pub plan: f64,
    /// Rays.
    pub march: f64,
    /// Stars and certificates.
    pub stars: f64,
    /// Colours and histograms.
    pub colours: f64,
}

impl Times {
    /// All of it [s].
    pub fn all(&self) -> f64 {
        self.plan + self.march + self.stars + self.colours
    }
}

/// Pixels of a band by the logarithm of their radiance.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// log₁₀ of radiance at both ends [W m⁻² sr⁻¹].
    pub range: (f64, f64),
    /// Pixels in equal steps between them.
    pub counts: Vec<u32>,
}

/// Steps of a histogram, the decades it spans, the part of the pixels that its range is made for, and the decades above them.
const BINS: usize = 96;
const DECADES: f64 = 6.0;
const MANY: f64 = 0.99;
const ABOVE: f64 = 1.0;

impl Histogram {
    /// Of one band.
    pub fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        // Stars are few and far brighter than all else: the range is that of the many.
        let mut bright: Vec<f64> = values.clone().filter(|v| v.is_finite() && *v > 0.0).collect();
        let many = (bright.len() as f64 * MANY) as usize;
        let high = if bright.is_empty() { 0.0 } else { bright.select_nth_unstable_by(many, f64::total_cmp).1.log10() + ABOVE };
        let range = (high - DECADES, high);
        let mut counts = vec![0; BINS];
        for value in values.filter(|v| *v > 0.0) {
            let bin = (value.log10() - range.0) / DECADES * BINS as f64;
            if bin >= 0.0 {
                counts[(bin as usize).min(BINS - 1)] += 1;
            }
        }
        Self { range, counts }
    }
}

/// What is kept of one view between orders.
#[derive(Default)]
struct Stand<'g> {
    glance: Option<(Arc<str>, Plan)>,
    quick: Marcher<'g>,
    slow: Marcher<'g>,
    last: Option<Last>,
}

/// The last picture.
struct Last {
    physics: Arc<str>,
    camera: Camera,
    quality: Quality,
    picture: Picture,
}

/// All views.
pub struct Studio<'g> {
    gpu: Option<&'g Gpu>,
    stands: Vec<Stand<'g>>,
    /// Rays a second of quick plans.
    rate: f64,
    /// What the last quick plan took [s].
    planned: f64,
}

impl<'g> Studio<'g> {
    /// On `gpu` as long as it does.
    pub fn new(gpu: Option<&'g Gpu>) -> Self {
        Self { gpu, stands: Vec::new(), rate: FIRST_RATE, planned: 0.0 }
    }

    /// Makes what is asked for, from coarse to fine; `show` hears of every stage. A picture that is only shown in another way is coloured anew, no more.
    ///
    /// # Errors
    /// Where a scene cannot be planned, and where `control` stops what is finer than a first look.
    pub fn serve(&mut self, order: &Order, control: &Control, show: &mut dyn FnMut(Quality, Vec<Picture>)) -> Result<()> {
        let show = &mut |quality, mut pictures: Vec<Picture>| {
            if let ([own, other], true) = (&mut pictures[..], order.difference) {
                other.colours = Arc::new(own.difference(other));
            }
            show(quality, pictures);
        };
        self.stands.truncate(order.views.len());
        self.stands.resize_with(order.views.len(), Stand::default);
        let mut reached = self.shown_again(order, show);
        let full = (order.camera.width as f64, order.camera.height as f64);
        let budget = (FRAME - self.planned).clamp(RAYS, MOVING);
        let mut scale = (full.0 * full.1 * order.views.len() as f64 / (self.rate * budget)).sqrt().max(1.0);
        if reached.is_none() {
            let quality = stage(scale);
            show(quality, self.glances(order, scale, &Control::default())?);
            reached = Some(quality);
        }
        if order.moving {
            return Ok(());
        }
        while reached < Some(Quality::Full) {
            scale = (scale / FINER).max(1.0);
            let quality = stage(scale);
            show(quality, self.glances(order, scale, control)?);
            reached = Some(quality);
        }
        if reached < Some(Quality::Settled) {
            let pictures = order.views.iter().enumerate().map(|(i, view)| self.settled(i, view, order, control)).collect::<Result<_>>()?;
            show(Quality::Settled, pictures);
        }
        Ok(())
    }

    /// Colours the last pictures anew, where they show what is asked for; returns how far they had come.
    fn shown_again(&mut self, order: &Order, show: &mut dyn FnMut(Quality, Vec<Picture>)) -> Option<Quality> {
        let same = |(stand, view): (&Stand, &View)| {
            let last = stand.last.as_ref().filter(|last| last.physics == view.physics && last.camera == order.camera)?;
            (last.picture.image.width == order.camera.width).then_some(last.quality)
        };
        let qualities: Option<Vec<Quality>> = self.stands.iter().zip(&order.views).map(same).collect();
        let quality = qualities?.into_iter().min()?;
        let coloured = |(stand, view): (&mut Stand, &View)| {
            let picture = &mut stand.last.as_mut()?.picture;
            let (start, display) = (Instant::now(), view.scene.display.clone());
            picture.tone = display.tone(&picture.image);
            picture.colour(start);
            picture.scene = Arc::new(Scene { display, ..(*picture.scene).clone() });
            if !picture.sparks.is_empty() {
                picture.sparks = sparks(picture, &order.camera).unwrap_or_default();
            }
            Some(picture.clone())
        };
        let pictures: Option<Vec<Picture>> = self.stands.iter_mut().zip(&order.views).map(coloured).collect();
        show(quality, pictures?);
        Some(quality)
    }

    /// Quick pictures of all views with `scale` times fewer pixels each way.
    fn glances(&mut self, order: &Order, scale: f64, control: &Control) -> Result<Vec<Picture>> {
        order.views.iter().enumerate().map(|(i, view)| self.glance(i, view, order, scale, control)).collect()
    }

    fn glance(&mut self, i: usize, view: &View, order: &Order, scale: f64, control: &Control) -> Result<Picture> {
        let camera = reduced(&order.camera, scale);
        let scene = seen(&view.scene, &camera);
        let (gpu, stand) = (self.gpu, &mut self.stands[i]);
        let start = Instant::now();
        let known = stand.glance.as_ref().filter(|(physics, _)| *physics == view.physics);
        if known.is_none() {
            let options = Options { method: scene.method.clone(), memory_limit: order.memory_limit };
            let plan = Plan::glance(stand.glance.as_ref().map(|(_, plan)| plan), &scene, &options, &Control::default())?;
            stand.glance = Some((view.physics.clone(), plan));
        }
        let Some((_, plan)) = &mut stand.glance else { return Err(Error::Interrupted) };
        plan.camera = camera;
        let planned = start.elapsed().as_secs_f64();
        self.planned = planned;
        let (data, findings, marched, backend) = stand.quick.radiance(gpu, plan, control)?;
        self.rate = (camera_rays(plan) / marched.max(1e-6)).max(1.0);
        let start = Instant::now();
        let times = Times { plan: planned, march: marched, stars: 0.0, colours: 0.0 };
        let image = cpu::extended(&scene, data)?;
        let mut picture = Picture::new(image, scene, plan.clone(), findings, times, backend);
        picture.sparks = sparks(&picture, &order.camera)?;
        picture.times.stars = start.elapsed().as_secs_f64() - picture.times.colours;
        stand.keep(view, &order.camera, stage(scale), &picture);
        Ok(picture)
    }

    /// The picture that `barnard render` writes.
    fn settled(&mut self, i: usize, view: &View, order: &Order, control: &Control) -> Result<Picture> {
        let scene = seen(&view.scene, &order.camera);
        let stand = &mut self.stands[i];
        let start = Instant::now();
        let options = Options { method: scene.method.clone(), memory_limit: order.memory_limit };
        let plan = Plan::new(&scene, &options, control)?;
        let planned = start.elapsed().as_secs_f64();
        let (data, findings, marched, backend) = stand.slow.radiance(self.gpu, &plan, control)?;
        let start = Instant::now();
        let image = cpu::finished(&scene, &plan, data, findings, &backend)?;
        let times = Times { plan: planned, march: marched, stars: start.elapsed().as_secs_f64(), colours: 0.0 };
        let picture = Picture::new(image, scene, plan, findings, times, backend);
        stand.keep(view, &order.camera, Quality::Settled, &picture);
        Ok(picture)
    }
}

impl Stand<'_> {
    fn keep(&mut self, view: &View, camera: &Camera, quality: Quality, picture: &Picture) {
        self.last = Some(Last { physics: view.physics.clone(), camera: camera.clone(), quality, picture: picture.clone() });
    }
}

/// The scene's stars over a quick picture, in the pixels of the window.
fn sparks(picture: &Picture, camera: &Camera) -> Result<Vec<(usize, usize, Color32)>> {
    let plan = Plan { camera: camera.clone(), ..picture.plan.clone() };
    let (bands, size) = (picture.image.bands.len(), camera.width * camera.height);
    let mut lit: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    cpu::draw(Sources::Stars, &picture.scene, &plan, |i, value| {
        lit.entry(i % size).or_insert_with(|| vec![0.0; bands])[i / size] += value;
    })?;
    let spark = |(pixel, light): (usize, Vec<f64>)| {
        let (column, row) = (pixel % camera.width, pixel / camera.width);
        let image = &picture.image;
        let below = |b: usize| image.at(b, row * image.height / camera.height, column * image.width / camera.width);
        (column, row, colour(picture.tone.colour((0..bands).map(|b| below(b) + light[b]))))
    };
    Ok(lit.into_iter().map(spark).collect())
}

/// How far a quick picture with `scale` times fewer pixels each way has come.
fn stage(scale: f64) -> Quality {
    if scale > 1.0 { Quality::Coarse } else { Quality::Full }
}

fn camera_rays(plan: &Plan) -> f64 {
    (plan.camera.width * plan.camera.height) as f64
}

/// The same view with fewer pixels.
fn reduced(camera: &Camera, scale: f64) -> Camera {
    let edge = |n: usize| ((n as f64 / scale).round().max(LEAST) as usize).min(n);
    Camera { width: edge(camera.width), height: edge(camera.height), ..camera.clone() }
}

/// The scene from there.
fn seen(scene: &Scene, camera: &Camera) -> Arc<Scene> {
    Arc::new(Scene { camera: camera.clone(), ..scene.clone() })
}

impl Picture {
    fn new(image: Image, scene: Arc<Scene>, plan: Plan, findings: Findings, times: Times, backend: String) -> Self {
        let start = Instant::now();
        let tone = scene.display.tone(&image);
        let mut picture = Self {
            image: Arc::new(image),
            plan,
            findings,
            tone,
            colours: Arc::default(),
            sparks: Vec::new(),
            histograms: Vec::new(),
            times,
            backend,
            scene,
        };
        picture.colour(start);
        picture
    }

    /// Colours of what `other` differs from this, amplified; both as this one is shown.
    fn difference(&self, other: &Self) -> Vec<Color32> {
        let (own, other) = (self.tone.picture(&self.image), self.tone.picture(&other.image));
        let one = |(a, b): (&[f64; 3], &[f64; 3])| colour(std::array::from_fn(|i| (f64::from(AMPLIFIED) * (a[i] - b[i]).abs()).min(1.0)));
        own.iter().zip(&other).map(one).collect()
    }

    /// Shows the radiances by the tone, which was begun at `start`.
    fn colour(&mut self, start: Instant) {
        self.colours = Arc::new(self.tone.bytes(&self.image).into_iter().map(|[r, g, b]| Color32::from_rgb(r, g, b)).collect());
        let image = &self.image;
        self.histograms = (0..image.bands.len())
            .map(|b| Histogram::of((0..image.width * image.height).map(move |i| image.samples.at(b * image.width * image.height + i))))
            .collect();
        self.times.colours = start.elapsed().as_secs_f64();
    }
}

fn colour(p: [f64; 3]) -> Color32 {
    let [r, g, b] = p.map(|v| (v * 255.0 + 0.5) as u8);
    Color32::from_rgb(r, g, b)
}

/// What marches the rays of one kind of plan; it stays on the device between pictures.
#[derive(Default)]
struct Marcher<'g> {
    renderer: Option<Renderer<'g>>,
    /// Why the device is not asked any more.
    given_up: Option<String>,
}

impl<'g> Marcher<'g> {
    /// Radiances, what was found, seconds, and what did it.
    fn radiance(&mut self, gpu: Option<&'g Gpu>, plan: &Plan, control: &Control) -> Result<(Vec<f32>, Findings, f64, String)> {
        let start = Instant::now();
        let mut why = self.given_up.clone();
        if let Some(gpu) = gpu.filter(|_| self.given_up.is_none()) {
            match self.on(gpu, plan, control) {
                Ok((data, findings)) => {
                    return Ok((data, findings, start.elapsed().as_secs_f64(), format!("gpu: {} ({})", gpu.adapter.name, gpu.adapter.api)));
                }
                Err(GpuError::Render(Error::Interrupted)) => return Err(Error::Interrupted),
                Err(error) => {
                    self.renderer = None;
                    why = Some(error.to_string());
                    if matches!(error, GpuError::Lost(_)) {
                        self.given_up.clone_from(&why);
                    }
                }
            }
        }
        let start = Instant::now();
        let (data, findings) = cpu::radiance(plan, control)?;
        let backend = why.map_or_else(|| "cpu".to_owned(), |why| format!("cpu, since {why}"));
        Ok((data, findings, start.elapsed().as_secs_f64(), backend))
    }

    fn on(&mut self, gpu: &'g Gpu, plan: &Plan, control: &Control) -> barnard_gpu::Result<(Vec<f32>, Findings)> {
        match &mut self.renderer {
            Some(renderer) => renderer.update(plan)?,
            None => self.renderer = Some(Renderer::new(gpu, plan, Tuning::default())?),
        }
        match &mut self.renderer {
            Some(renderer) => renderer.radiance(control),
            None => Err(GpuError::NoAdapter),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Document;
    use crate::edit::Edit;
    use crate::flight::Flight;

    fn order(document: &Document, size: (usize, usize), moving: bool) -> Order {
        let view = View { scene: document.scene().clone(), physics: document.physics().clone() };
        Order { views: vec![view], camera: Flight::of(document.scene()).seen(size), moving, difference: false, memory_limit: 1 << 32 }
    }

    fn served(studio: &mut Studio, order: &Order) -> Vec<(Quality, Picture)> {
        let mut shown = Vec::new();
        studio
            .serve(order, &Control::default(), &mut |quality, pictures| shown.extend(pictures.into_iter().map(|p| (quality, p))))
            .unwrap();
        shown
    }

    /// The settled picture is that of `barnard render`, pixel by pixel; the quick ones on the way look like it.
    #[test]
    fn pictures_settle_to_what_is_rendered() {
        let document = Document::builtin("deck", 1 << 32).unwrap();
        let order = order(&document, (60, 40), false);
        let shown = served(&mut Studio::new(None), &order);
        let (quality, last) = shown.last().unwrap();
        assert_eq!(*quality, Quality::Settled);
        let scene = seen(document.scene(), &order.camera);
        let plan = Plan::new(&scene, &Options { method: scene.method.clone(), memory_limit: 1 << 32 }, &Control::default()).unwrap();
        let rendered = cpu::render(&scene, &plan, &Control::default()).unwrap().0;
        assert!(*last.image == rendered);
        let (_, full) = shown.iter().rev().find(|(q, _)| *q == Quality::Full).unwrap();
        for band in 0..3 {
            let difference = full.image.relative_rmse(band, &rendered, band);
            assert!((1e-6..0.15).contains(&difference), "band {band}: {difference}");
        }
    }

    /// Another stretch colours the picture anew and marches nothing; another temperature marches, and keeps what places decided.
    #[test]
    fn what_has_not_changed_stays() {
        let mut document = Document::builtin("deck", 1 << 32).unwrap();
        let mut studio = Studio::new(None);
        let first = served(&mut studio, &order(&document, (40, 30), true));
        document.apply(Edit::set("display", "stretch", "linear")).unwrap();
        let shown = served(&mut studio, &order(&document, (40, 30), true));
        assert!(shown.len() == 1 && Arc::ptr_eq(&shown[0].1.image, &first.last().unwrap().1.image));
        assert!(shown[0].1.colours != first.last().unwrap().1.colours);
        document.apply(Edit::set("star.0", "temperature", "4000 K")).unwrap();
        let hotter = served(&mut studio, &order(&document, (40, 30), true));
        assert!(Arc::ptr_eq(&hotter[0].1.plan.space, &first[0].1.plan.space) && hotter[0].1.image != first[0].1.image);
    }

    /// On a device, the picture is that of the processor to the accuracy that both are planned for.
    #[test]
    fn devices_make_the_same_pictures() {
        let Ok(gpu) = Gpu::open() else {
            assert!(std::env::var_os("CI").is_none(), "no graphics adapter");
            eprintln!("SKIPPED devices_make_the_same_pictures: no graphics adapter");
            return;
        };
        let document = Document::builtin("deck", 1 << 32).unwrap();
        let order = order(&document, (48, 32), false);
        let last = |studio: &mut Studio| served(studio, &order).pop().unwrap().1;
        let (device, processor) = (last(&mut Studio::new(Some(&gpu))), last(&mut Studio::new(None)));
        assert!(device.backend.starts_with("gpu: ") && processor.backend == "cpu", "{}", device.backend);
        for band in 0..3 {
            let difference = device.image.relative_rmse(band, &processor.image, band);
            assert!((1e-9..1e-3).contains(&difference), "band {band}: {difference}");
        }
    }

    #[test]
    fn histograms_count_pixels() {
        let histogram = Histogram::of([0.0, 1e-3, 1e-3, 1e-9, 1.0, f64::NAN].into_iter());
        assert_eq!(histogram.range, (-5.0, 1.0));
        assert_eq!(histogram.counts.iter().sum::<u32>(), 3);
        assert_eq!((histogram.counts[BINS / 3], histogram.counts[BINS * 5 / 6]), (2, 1));
    }
}
