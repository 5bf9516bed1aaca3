//! Render thread: plans that are kept, marches at several sizes, colours.

mod opener;

use std::sync::Arc;
use web_time::Instant;

use barnard::backend::{self, Backend, BackendEntry, Job, Radiance, Renderer};
use barnard::cache::Cache;
use barnard::camera::Camera;
use barnard::control::Control;
use barnard::plan::{Options, Planned, Planner, Quality};
use barnard::plates::{Reach, binds_dust};
use barnard::scene::Scene;
use barnard::{Error, Plates, Result};
use spectra::fingerprint::Fingerprint;

use crate::exposure::Exposure;
use crate::order::{Order, Refinement, View};
use crate::picture::{Picture, Times};
pub use opener::LentDevice;
use opener::Opener;

/// The time that a picture may take while things move [s].
struct MotionPace {
    /// The time for rays and colours [s]: at most, and at least whatever the plan takes.
    rays: (f64, f64),
    /// The time for the plan with them.
    all: f64,
}

const ON_PROCESSOR: MotionPace = MotionPace { rays: (0.06, 0.02), all: 0.085 };
const ON_DEVICE: MotionPace = MotionPace { rays: (0.03, 0.01), all: 0.04 };
/// Pixels a second before any was measured.
const FIRST_RATE: f64 = 4e4;
/// The factor by which the next finer picture has more pixels each way.
const FINER: f64 = 3.0;
/// Part of the memory that a plan may take to be kept.
const KEPT: u64 = 4;
/// Fewest pixels along an edge.
const LEAST: f64 = 24.0;
/// The amounts of dust that plates serve where they can, as parts of the scene's.
const DUST: (f64, f64) = (0.5, 2.0);
/// Most lights of scenes that plates are made of unasked where light scatters again, and most stars where it does not.
const PLATED_LIGHTS: usize = 3;
const PLATED_STARS: usize = 12;

/// State of one view between orders.
#[derive(Default)]
struct Stand {
    preview: Option<(Fingerprint, Planned)>,
    /// The back ends of previews and of settled pictures: each keeps its own plan on a device.
    quick: Option<Box<dyn Backend>>,
    slow: Option<Box<dyn Backend>>,
    /// The last settled plan, of which the next one takes what still holds.
    settled: Option<Planned>,
    /// The last settled picture light by light, for spectra that change.
    plates: Option<Plates>,
    last: Option<Last>,
    exposure: Exposure,
}

/// The last picture of a view.
struct Last {
    physics: Fingerprint,
    recorded: bool,
    camera: Camera,
    quality: Refinement,
    picture: Picture,
}

impl Last {
    fn is_of(&self, view: &View) -> bool {
        self.physics == view.physics && self.recorded == view.recorded
    }
}

/// The workshop of pictures: what is kept of all views.
pub struct Studio {
    opener: Opener,
    /// Cache of results between runs, if any.
    cache: Option<Arc<dyn Cache>>,
    /// Stops a first look when the window closes.
    closing: Control,
    stands: Vec<Stand>,
    /// True if plates of settled pictures are made while nothing else is to be done.
    keeps_plates: bool,
    /// Pixels a second of quick plans, marched and coloured.
    rate: f64,
    /// Time of the last preview without its rays: plan and stars [s].
    fixed: f64,
}

impl Studio {
    /// A studio with a back end and a cache between runs, if any; `closing` stops all that it does.
    pub fn new(backend: BackendEntry, cache: Option<Arc<dyn Cache>>, closing: Control) -> Self {
        Self {
            opener: Opener { backend, device: None },
            cache,
            closing,
            stands: Vec::new(),
            keeps_plates: true,
            rate: FIRST_RATE,
            fixed: 0.0,
        }
    }

    /// Variant that keeps no plates of settled pictures: orders end with the picture.
    #[must_use]
    pub fn without_plates(mut self) -> Self {
        self.keeps_plates = false;
        self
    }

    /// [Levels](Exposure::levels) of the first view; `asked` counts the requests for other ones.
    pub fn levels(&self, asked: u64) -> Option<Vec<f64>> {
        self.stands.first()?.exposure.levels(asked)
    }

    /// Shows the first view by levels of another studio with the same scene, or measures them anew.
    pub fn take_levels(&mut self, asked: u64, scene: &Scene, levels: Option<&[f64]>) {
        if self.stands.is_empty() {
            self.stands.push(Stand::default());
        }
        self.stands[0].exposure.take_levels(asked, scene, levels);
    }

    /// Has pictures rendered on a device from now on.
    pub fn take(&mut self, device: LentDevice) {
        self.opener.device = Some(device);
        self.stands.iter_mut().for_each(|stand| (stand.quick, stand.slow) = (None, None));
    }

    /// True if pictures are rendered on a device.
    pub fn has_device(&self) -> bool {
        self.opener.device.is_some()
    }

    fn options(&self, memory_limit: u64) -> Options {
        Options::within(memory_limit).with_sweeper(self.opener.device.as_ref().and_then(|device| device.sweeper.clone()))
    }

    /// Renders requests from coarse to fine; `show` receives every stage. A picture that is only shown in
    /// another way is coloured anew, no more.
    ///
    /// # Errors
    /// If a scene cannot be planned, and if `control` stops what is finer than a first look.
    pub fn serve(&mut self, order: &Order, control: &Control, show: &mut dyn FnMut(Refinement, Vec<Picture>)) -> Result<()> {
        pollster::block_on(self.serve_async(order, control, show))
    }

    /// Variant of [`serve`](Self::serve) for callers that must not block.
    ///
    /// # Errors
    /// Errors of [`serve`](Self::serve).
    pub async fn serve_async(&mut self, order: &Order, control: &Control, show: &mut dyn FnMut(Refinement, Vec<Picture>)) -> Result<()> {
        let show = &mut |quality, mut pictures: Vec<Picture>| {
            if let ([ours, other], true) = (&mut pictures[..], order.difference) {
                other.colours = Arc::new(ours.difference(other));
            }
            show(quality, pictures);
        };
        self.stands.truncate(order.views.len());
        self.stands.resize_with(order.views.len(), Stand::default);
        let mut reached = self.shown_again(order, show);
        let asked = pixels(&order.camera) * order.views.len() as f64;
        let pace = if self.has_device() { ON_DEVICE } else { ON_PROCESSOR };
        let budget = (pace.all - self.fixed).clamp(pace.rays.1, pace.rays.0);
        let mut scale = (asked / (self.rate * budget)).sqrt().max(1.0);
        if reached.is_none()
            && let Some(pictures) = self.exposed(order)?
        {
            show(Refinement::Exposed, pictures);
            reached = Some(Refinement::Exposed);
        }
        if reached.is_none() {
            let quality = stage(scale);
            show(quality, self.previews(order, scale, &self.closing.clone()).await?);
            reached = Some(quality);
        }
        if order.moving {
            return Ok(());
        }
        while reached < Some(Refinement::Full) {
            scale = (scale / FINER).max(1.0);
            let quality = stage(scale);
            show(quality, self.previews(order, scale, control).await?);
            reached = Some(quality);
        }
        if !order.settles {
            return Ok(());
        }
        if reached < Some(Refinement::Settled) {
            let (pictures, failure) = self.all_settled(order, control).await?;
            show(Refinement::Settled, pictures);
            if let Some(failure) = failure {
                return Err(failure);
            }
        }
        if self.keeps_plates { self.keep_plates(order, control) } else { Ok(()) }
    }

    /// Final pictures of all views. One that cannot be recorded is shown as it is, with the reason.
    async fn all_settled(&mut self, order: &Order, control: &Control) -> Result<(Vec<Picture>, Option<Error>)> {
        let mut pictures: Vec<Picture> = Vec::new();
        let mut failure = None;
        for (i, view) in order.views.iter().enumerate() {
            let picture = match pictures.first().filter(|_| view.recorded) {
                None => self.settled(i, view, order, control).await?,
                Some(picture) => match picture.recorded(&view.scene, None, control) {
                    Ok(recorded) => recorded,
                    Err(Error::Interrupted) => return Err(Error::Interrupted),
                    Err(error) => {
                        failure = Some(error);
                        picture.clone()
                    }
                },
            };
            if view.recorded {
                self.stands[i].keep(view, &order.camera, Refinement::Settled, &picture);
            }
            pictures.push(picture);
        }
        Ok((pictures, failure))
    }

    /// Pictures by plates, where all views have some that serve.
    fn exposed(&mut self, order: &Order) -> Result<Option<Vec<Picture>>> {
        let mut pictures: Vec<Picture> = Vec::new();
        for (i, view) in order.views.iter().enumerate() {
            let picture = match pictures.first().filter(|_| view.recorded) {
                None => match self.expose(i, view, order)? {
                    Some(picture) => picture,
                    None => return Ok(None),
                },
                Some(record) => record.clone(),
            };
            self.stands[i].keep(view, &order.camera, Refinement::Exposed, &picture);
            pictures.push(picture);
        }
        Ok(Some(pictures))
    }

    /// The picture of a view by its plates; none where they are of another geometry or other wavelengths.
    fn expose(&mut self, i: usize, view: &View, order: &Order) -> Result<Option<Picture>> {
        let scene = seen(&view.scene, &order.camera);
        let (options, closing) = (self.options(order.memory_limit), self.closing.clone());
        let stand = &mut self.stands[i];
        let start = Instant::now();
        let pictured = |plates: &Plates| plates.pictured(&scene, &plates.mixture(&scene)?, &closing);
        let Some(Ok(image)) = stand.plates.as_ref().map(pictured) else { return Ok(None) };
        let exposed = start.elapsed().as_secs_f64();
        let plan = stand.previewed(view, &scene, &options, &closing)?.clone();
        let times = Times { march: exposed, plan: start.elapsed().as_secs_f64() - exposed, ..Times::default() };
        let tone = stand.exposure.tone(order.exposure, &scene.display, &image, false);
        Ok(Some(Picture::new(image, scene, tone, plan, times, "plates".into())))
    }

    /// Makes plates of settled views while nothing else is to be done, where there are none that serve.
    fn keep_plates(&mut self, order: &Order, control: &Control) -> Result<()> {
        for (i, view) in order.views.iter().enumerate().filter(|(_, view)| !view.recorded) {
            let scene = seen(&view.scene, &order.camera);
            let (options, stand) = (self.options(order.memory_limit / KEPT), &mut self.stands[i]);
            // Light that scatters again takes a march of each light.
            let lights = scene.stars.len() + scene.species().len() + usize::from(scene.background.spectrum.is_some());
            let quick = if scene.method.bounces == 1 { scene.stars.len() <= PLATED_STARS } else { lights <= PLATED_LIGHTS };
            if !quick || stand.plates.as_ref().is_some_and(|plates| plates.mixture(&scene).is_ok()) {
                continue;
            }
            stand.plates = None;
            let dust = if binds_dust(&scene) { Reach::default().dust } else { DUST };
            let made = |dust| Plates::new(&scene, Reach { dust, ..Reach::default() }, stand.settled.as_ref(), &options, control);
            // Where other amounts take too much, its own may not.
            let plates = match made(dust) {
                Err(error) if !matches!(error, Error::Interrupted) && dust != Reach::default().dust => made(Reach::default().dust),
                plates => plates,
            };
            match plates {
                Ok(plates) => stand.plates = Some(plates),
                Err(Error::Interrupted) => return Err(Error::Interrupted),
                // There is no room, or no plates are made of such a scene: pictures are made without.
                Err(_) => {}
            }
        }
        Ok(())
    }

    /// Colours the last pictures anew, where they show what is asked for; returns how far they had come.
    fn shown_again(&mut self, order: &Order, show: &mut dyn FnMut(Refinement, Vec<Picture>)) -> Option<Refinement> {
        let same = |(stand, view): (&Stand, &View)| {
            let last = stand.last.as_ref().filter(|last| last.is_of(view) && last.camera == order.camera)?;
            Some(last.quality)
        };
        let qualities: Option<Vec<Refinement>> = self.stands.iter().zip(&order.views).map(same).collect();
        let quality = qualities?.into_iter().min()?;
        let (mut first, closing): (Option<Picture>, _) = (None, self.closing.clone());
        let coloured = |(stand, view): (&mut Stand, &View)| {
            let last = stand.last.as_mut()?;
            if let (true, Some(record)) = (view.recorded, &first) {
                // Noise of other exposures is drawn in no time, and while they are chosen.
                let picture = if quality == Refinement::Settled {
                    record.recorded(&view.scene, Some(&last.picture), &closing).ok()?
                } else {
                    record.clone()
                };
                last.picture = picture.clone();
                return Some(picture);
            }
            let display = &view.scene.display;
            let tone = stand.exposure.tone(order.exposure, display, &last.picture.image, last.quality == Refinement::Settled);
            last.picture.show(display, tone);
            match last.quality {
                Refinement::Exposed | Refinement::Settled if order.moving => {}
                Refinement::Exposed | Refinement::Settled => last.picture.spread(),
                _ => last.picture.spark(&order.camera).ok()?,
            }
            first.get_or_insert_with(|| last.picture.clone());
            Some(last.picture.clone())
        };
        let pictures: Option<Vec<Picture>> = self.stands.iter_mut().zip(&order.views).map(coloured).collect();
        show(quality, pictures?);
        Some(quality)
    }

    /// Quick pictures of all views with `scale` times fewer pixels each way.
    async fn previews(&mut self, order: &Order, scale: f64, control: &Control) -> Result<Vec<Picture>> {
        let mut pictures: Vec<Picture> = Vec::new();
        for (i, view) in order.views.iter().enumerate() {
            let picture = match pictures.first().filter(|_| view.recorded) {
                None => self.preview(i, view, order, scale, control).await?,
                Some(picture) => {
                    let picture_now = picture.clone();
                    self.stands[i].keep(view, &order.camera, stage(scale), &picture_now);
                    picture_now
                }
            };
            pictures.push(picture);
        }
        Ok(pictures)
    }

    async fn preview(&mut self, i: usize, view: &View, order: &Order, scale: f64, control: &Control) -> Result<Picture> {
        let camera = reduced(&order.camera, scale);
        let scene = seen(&view.scene, &camera);
        let options = self.options(order.memory_limit);
        let stand = &mut self.stands[i];
        let start = Instant::now();
        let plan = stand.previewed(view, &scene, &options, control)?.clone();
        let planned = start.elapsed().as_secs_f64();
        let backend = self.opener.backend_in(&mut stand.quick, &scene)?;
        let Rendered { light, seconds, by } = rendered(backend, &Job::from(&plan), control).await?;
        let times = Times { plan: planned, march: seconds, stars: 0.0, colours: 0.0 };
        let image = backend::described(&plan, light.samples)?;
        let tone = stand.exposure.tone(order.exposure, &scene.display, &image, false);
        let asked = pixels(plan.camera());
        let mut picture = Picture::new(image, scene, tone, plan, times, by);
        picture.spark(&order.camera)?;
        self.fixed = planned + picture.times.stars;
        self.rate = (asked / (picture.times.all() - self.fixed).max(1e-6)).max(1.0);
        stand.keep(view, &order.camera, stage(scale), &picture);
        Ok(picture)
    }

    /// The picture that `barnard render` writes.
    async fn settled(&mut self, i: usize, view: &View, order: &Order, control: &Control) -> Result<Picture> {
        let scene = seen(&view.scene, &order.camera);
        let options = self.options(order.memory_limit).with_cache(self.cache.clone());
        let stand = &mut self.stands[i];
        let start = Instant::now();
        let plan = Planner::new(&options).plan(scene.clone(), stand.settled.as_ref(), control)?;
        // What is kept stands beside the next one: no more than a part of the room.
        stand.settled = Some(plan.clone()).filter(|plan| plan.bytes() < order.memory_limit / KEPT);
        let planned = start.elapsed().as_secs_f64();
        let job = Job::from(&plan);
        let backend = self.opener.backend_in(&mut stand.slow, &scene)?;
        let Rendered { light, seconds, by } = rendered(backend, &job, control).await?;
        let start = Instant::now();
        let image = Renderer::new(backend).finish(&job, light, control)?;
        let times = Times { plan: planned, march: seconds, stars: start.elapsed().as_secs_f64(), colours: 0.0 };
        let tone = stand.exposure.tone(order.exposure, &scene.display, &image, true);
        let mut picture = Picture::new(image, scene, tone, plan, times, by);
        picture.spread();
        stand.keep(view, &order.camera, Refinement::Settled, &picture);
        Ok(picture)
    }
}

impl Stand {
    /// The preview's plan of a view, seen by its scene's camera.
    fn previewed(&mut self, view: &View, scene: &Arc<Scene>, options: &Options, control: &Control) -> Result<&Planned> {
        if self.preview.as_ref().is_none_or(|(physics, _)| *physics != view.physics) {
            let plan = Planner::new(options).with_quality(Quality::Preview).plan(
                scene.clone(),
                self.preview.as_ref().map(|(_, plan)| plan),
                control,
            )?;
            self.preview = Some((view.physics, plan));
        }
        let Some((_, plan)) = &mut self.preview else { return Err(Error::Interrupted) };
        *plan = plan.with_scene(scene.clone(), control)?;
        Ok(plan)
    }

    fn keep(&mut self, view: &View, camera: &Camera, quality: Refinement, picture: &Picture) {
        self.last =
            Some(Last { physics: view.physics, recorded: view.recorded, camera: camera.clone(), quality, picture: picture.clone() });
    }
}

/// The quality of a quick picture with `scale` times fewer pixels each way.
fn stage(scale: f64) -> Refinement {
    if scale > 1.0 { Refinement::Coarse } else { Refinement::Full }
}

fn pixels(camera: &Camera) -> f64 {
    (camera.width * camera.height) as f64
}

/// The camera of the same view with fewer pixels.
fn reduced(camera: &Camera, scale: f64) -> Camera {
    let edge = |n: usize| ((n as f64 / scale).round().max(LEAST) as usize).min(n);
    Camera { width: edge(camera.width), height: edge(camera.height), ..camera.clone() }
}

/// The scene as `camera` sees it.
fn seen(scene: &Scene, camera: &Camera) -> Arc<Scene> {
    Arc::new(scene.clone().with_camera(camera.clone()))
}

/// Light that a back end found, in how long, and what found it.
struct Rendered {
    light: Radiance,
    seconds: f64,
    by: String,
}

/// The light of a job by a back end of one kind of plan, whose tables stay where it has them.
async fn rendered(backend: &mut dyn Backend, job: &Job<'_>, control: &Control) -> Result<Rendered> {
    let start = Instant::now();
    let light = backend.radiance_async(job, control).await?;
    let by = match backend.device().and_then(|device| device.fallback()) {
        None => backend.name(),
        Some(why) => format!("{}, since {why}", backend.name()),
    };
    Ok(Rendered { light, seconds: start.elapsed().as_secs_f64(), by })
}

#[cfg(test)]
mod tests;
