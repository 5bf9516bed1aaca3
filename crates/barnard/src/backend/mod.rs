//! Back ends: the ways to turn a scene into an image.
//!
//! Each implements [`Backend`]: it names itself, says why it cannot do a [`Job`], and brings [`Radiance`]. The fast
//! ones read the job's plan, the exact ones the scene itself. A [`Registry`] holds those that a program has:
//! [`BACKENDS`], and what other crates bring.

pub mod cpu;
mod describe;
mod finish;
mod layers;
pub mod path;
pub mod reference;
mod seen_detail;

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use spectra::SpectraError;

pub use describe::{describe, left_out};
pub(crate) use finish::end_of_space;
pub use finish::{draw, extended, finished};

pub use crate::stats::RenderStats;

use crate::camera::Camera;
use crate::composite::joined;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::image::{Image, Samples};
use crate::plan::ordinates::Sweeper;
use crate::plan::{Options, Plan};
use crate::scene::{Part, Scene};

/// Parts of a scene that its plan fixes, for any method and camera.
const FIXED: [Part; 4] = [Part::Space, Part::Stars, Part::Spectra, Part::Amount];

/// A render to be done: a scene, what it may take, and its plan once a back end asked for it.
#[derive(Debug)]
pub struct Job<'a> {
    scene: &'a Scene,
    options: &'a Options,
    plan: OnceLock<Cow<'a, Plan>>,
}

impl<'a> Job<'a> {
    /// A scene that is planned when a back end asks for its plan.
    ///
    /// # Errors
    /// Errors of [`Scene::check`].
    pub fn new(scene: &'a Scene, options: &'a Options) -> Result<Self> {
        scene.check()?;
        Ok(Self { scene, options, plan: OnceLock::new() })
    }

    /// A scene whose plan is there already.
    ///
    /// # Errors
    /// If the plan was made of other densities, lights, passbands or dust.
    pub fn planned(scene: &'a Scene, options: &'a Options, plan: &'a Plan) -> Result<Self> {
        let differing: Vec<String> =
            plan.parts.differing(&scene.parts()).iter().filter(|part| FIXED.contains(part)).map(Part::to_string).collect();
        if !differing.is_empty() {
            let problem = format!("the scene differs from that of its plan ({})", differing.join(", "));
            return Err(Error::conflict(problem, "make a new plan"));
        }
        Ok(Self { scene, options, plan: OnceLock::from(Cow::Borrowed(plan)) })
    }

    /// The scene to be rendered.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// Options of the render.
    pub fn options(&self) -> &'a Options {
        self.options
    }

    /// The plan of the scene, made for the first who asks.
    ///
    /// # Errors
    /// Errors of [`Plan::new`].
    pub fn plan(&self, control: &Control) -> Result<&Plan> {
        if let Some(plan) = self.plan.get() {
            return Ok(plan);
        }
        let plan = Plan::new(self.scene, self.options, control)?;
        Ok(self.plan.get_or_init(|| Cow::Owned(plan)))
    }
}

/// Light that a back end found: bands × height × width [W m⁻² sr⁻¹], without the stars that are seen as points.
#[derive(Debug, Clone)]
pub struct Radiance {
    /// The radiances, bands × height × width.
    pub samples: Samples,
    /// Measurements of the march.
    pub stats: RenderStats,
}

impl Radiance {
    /// Light in single precision.
    pub fn single(data: Vec<f32>, stats: RenderStats) -> Self {
        Self { samples: Samples::Single(data), stats }
    }
}

/// Rendering of one part of a job's light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PartsBy {
    /// By a plan of which that part shines alone.
    Plan,
    /// By a scene that has no other lights.
    Scene,
    /// Not at all.
    Nothing,
}

/// Renderer from a [`Job`] to its light and a finished picture.
///
/// # Examples
/// A back end that returns the same radiance everywhere, with the header, stars and layers of all others:
///
/// ```
/// use barnard::Result;
/// use barnard::backend::{Backend, Job, Radiance};
/// use barnard::prelude::*;
///
/// struct Uniform(f32);
///
/// impl Backend for Uniform {
///     fn name(&self) -> String {
///         "uniform".into()
///     }
///     fn unable(&self, _job: &Job, _control: &Control) -> Result<Option<String>> {
///         Ok(None)
///     }
///     fn radiance(&mut self, job: &Job, _control: &Control) -> Result<Radiance> {
///         let (scene, mut light) = (job.scene(), Vec::new());
///         light.resize(scene.bands.len() * scene.camera.width * scene.camera.height, self.0);
///         Ok(Radiance::single(light, barnard::backend::RenderStats::of_rays(0)))
///     }
/// }
///
/// let scene = Scene::new(Camera::look_at(dvec3(0.0, 0.0, 5.0), DVec3::ZERO).size(8, 8)).bands(passband::set("johnson")?);
/// let options = Options::default();
/// let (image, _) = Uniform(2.0).render(&Job::new(&scene, &options)?, &Control::default())?;
/// assert!(image.band(0).all(|v| v == 2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Backend: Send {
    /// The name that the picture's header gives as its maker.
    fn name(&self) -> String;

    /// Why it cannot do a job, and what would be right; nothing where it can.
    ///
    /// # Errors
    /// If the job cannot be planned at all.
    fn unable(&self, job: &Job, control: &Control) -> Result<Option<String>>;

    /// How it renders a part of a job's light alone.
    fn parts_by(&self) -> PartsBy {
        PartsBy::Plan
    }

    /// Takes up a job before its light is asked for, as after an edit; asking for light does so otherwise.
    ///
    /// # Errors
    /// If the job cannot be planned or taken.
    fn prepare(&mut self, _job: &Job, _control: &Control) -> Result<()> {
        Ok(())
    }

    /// The light of a job.
    ///
    /// # Errors
    /// If it cannot be done, or on interruption by the user.
    fn radiance(&mut self, job: &Job, control: &Control) -> Result<Radiance>;

    /// The picture: stars are drawn over the light, errors and origin are told.
    ///
    /// # Errors
    /// If values are no numbers, or there are too many stars, and on interruption by the user.
    fn finish(&self, job: &Job, radiance: Radiance, control: &Control) -> Result<Image> {
        finished(job.scene(), job.plan(control)?, radiance, &self.name(), control)
    }

    /// Renders and finishes in one go; both eyes, where the scene's camera has two.
    ///
    /// # Errors
    /// Errors of [`radiance`](Self::radiance) and [`finish`](Self::finish).
    fn render(&mut self, job: &Job, control: &Control) -> Result<(Image, RenderStats)> {
        let camera = &job.scene().camera;
        let (Some(stereo), Some(eyes)) = (camera.stereo, camera.eyes()) else { return self.picture(job, control) };
        let mut of_eye = |eye: Camera, control: &Control| {
            let scene = Scene { camera: eye, ..job.scene().clone() };
            match job.plan.get() {
                Some(plan) => {
                    let mut plan = (**plan).clone();
                    plan.look_from(scene.camera.clone(), control)?;
                    self.picture(&Job::planned(&scene, job.options(), &plan)?, control)
                }
                None => self.picture(&Job::new(&scene, job.options())?, control),
            }
        };
        let [left, right] = eyes;
        let ((left, stats), (right, more)) = (of_eye(left, &control.part(0.0, 0.5))?, of_eye(right, &control.part(0.5, 1.0))?);
        Ok((joined(stereo.arrangement, left, &right)?, stats.and(more)))
    }

    /// The picture of one eye, with the layers that the scene's output asks for.
    ///
    /// # Errors
    /// Errors of [`render`](Self::render).
    fn picture(&mut self, job: &Job, control: &Control) -> Result<(Image, RenderStats)> {
        if job.scene().output.layers.is_any() {
            return layers::layered(self, job, control);
        }
        let radiance = self.radiance(job, control)?;
        let stats = radiance.stats;
        Ok((self.finish(job, radiance, control)?, stats))
    }

    /// The device that sweeps light of more than one scattering in place of the processor, where this back end has one.
    fn sweeper(&self) -> Option<Arc<dyn Sweeper>> {
        None
    }

    /// The time that a device of its own took for the last light \[s\]: NaN where the device does not tell, none where
    /// there is no device.
    fn device_seconds(&self) -> Option<f64> {
        None
    }

    /// Keeps a device of its own busy with what it has for so long \[s\], so that it is timed as fast as it is under load.
    ///
    /// # Errors
    /// If the device gives up, or on interruption by the user.
    fn warm_up(&mut self, _seconds: f64, _control: &Control) -> Result<()> {
        Ok(())
    }

    /// Warnings of the last render, in words.
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }

    /// Why the processor did the last job in place of a device that was hoped for; nothing where the device did, or
    /// there is none.
    fn instead(&self) -> Option<String> {
        None
    }

    /// Puts a star of the job that was taken up last elsewhere \[pc\], where that can be done without a new plan: what
    /// the device worked for it \[s\], NaN where it does not tell; none where it cannot be done.
    ///
    /// # Errors
    /// If there is no such star, or the place is none.
    fn move_star(&mut self, _star: usize, _place: DVec3) -> Result<Option<f64>> {
        Ok(None)
    }
}

/// True if a back end renders on a graphics device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceUse {
    /// The back end renders on the processor alone.
    Never,
    /// The back end renders on any device, be it software.
    Always,
    /// The back end renders on a real device where there is one, otherwise on the processor.
    IfReal,
}

/// One row of the catalogue of back ends.
#[derive(Debug, Clone, Copy)]
pub struct BackendEntry {
    /// The name by which a person asks for it.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// True if it reads the job's plan, and not the scene itself.
    pub planned: bool,
    /// True if it renders on a graphics device, for programs that have one open.
    pub device: DeviceUse,
    /// Makes one, with what it is set to where nothing is said.
    pub open: fn(&Scene) -> Result<Box<dyn Backend>>,
}

/// The back ends of this crate; the first is the default.
pub const BACKENDS: &[BackendEntry] = &[cpu::ENTRY, path::ENTRY, reference::ENTRY];

/// The back ends that a program has, by name.
#[derive(Debug, Clone)]
pub struct Registry(Vec<BackendEntry>);

impl Default for Registry {
    /// The back ends of this crate alone.
    fn default() -> Self {
        Self(BACKENDS.to_vec())
    }
}

impl Registry {
    /// Copy of the registry with more rows at its end.
    #[must_use]
    pub fn with(mut self, entries: &[BackendEntry]) -> Self {
        self.0.extend_from_slice(entries);
        self
    }

    /// All rows, in the order in which they are listed.
    pub fn entries(&self) -> &[BackendEntry] {
        &self.0
    }

    /// The row called `name`.
    ///
    /// # Errors
    /// If there is none.
    pub fn by_name(&self, name: &str) -> Result<&BackendEntry> {
        let known: Vec<&str> = self.0.iter().map(|b| b.name).collect();
        Ok(self.0.iter().find(|b| b.name == name).ok_or_else(|| SpectraError::unknown("back end", name, &known))?)
    }
}
