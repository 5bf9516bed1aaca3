//! Back ends: the ways to turn a scene into an image.
//!
//! Each implements [`Backend`]: it names itself, says why it cannot do a [`Job`], and brings [`Radiance`]. The fast
//! ones read the job's plan, the exact ones the scene itself. A [`Registry`] holds those that a program has:
//! [`BACKENDS`], and what other crates bring.

pub mod cpu;
mod describe;
mod finish;
pub mod path;
pub mod reference;

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use spectra::SpectraError;

pub use describe::describe;
pub use finish::{draw, extended, finished};

pub use crate::stats::RenderStats;

use crate::control::Control;
use crate::error::Result;
use crate::image::{Image, Samples};
use crate::plan::ordinates::Sweeper;
use crate::plan::{Options, Plan};
use crate::scene::Scene;

/// What is to be rendered: a scene, what it may take, and its plan once somebody asked for it.
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
    /// Those of [`Scene::check`].
    pub fn new(scene: &'a Scene, options: &'a Options) -> Result<Self> {
        scene.check()?;
        Ok(Self { scene, options, plan: OnceLock::new() })
    }

    /// A scene whose plan is there already.
    pub fn planned(scene: &'a Scene, options: &'a Options, plan: &'a Plan) -> Self {
        Self { scene, options, plan: OnceLock::from(Cow::Borrowed(plan)) }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// What it may take.
    pub fn options(&self) -> &'a Options {
        self.options
    }

    /// Its plan; the first to ask waits for it.
    ///
    /// # Errors
    /// Those of [`Plan::new`].
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
    /// The radiances.
    pub samples: Samples,
    /// What was found beside them.
    pub stats: RenderStats,
}

impl Radiance {
    /// In single precision.
    pub fn single(data: Vec<f32>, stats: RenderStats) -> Self {
        Self { samples: Samples::Single(data), stats }
    }
}

/// A way to render.
pub trait Backend {
    /// Its name, as the picture's header says it.
    fn name(&self) -> String;

    /// Why it cannot do a job, and what would be right; nothing where it can.
    ///
    /// # Errors
    /// Where the job cannot be planned at all.
    fn unable(&self, job: &Job, control: &Control) -> Result<Option<String>>;

    /// Takes up a job before its light is asked for, as after an edit; asking for light does so otherwise.
    ///
    /// # Errors
    /// Where the job cannot be planned or taken.
    fn prepare(&mut self, job: &Job, control: &Control) -> Result<()> {
        job.plan(control).map(drop)
    }

    /// The light of a job.
    ///
    /// # Errors
    /// Where it cannot be done, or the user wishes to stop.
    fn radiance(&mut self, job: &Job, control: &Control) -> Result<Radiance>;

    /// The picture: stars are drawn over the light, errors and origin are told.
    ///
    /// # Errors
    /// Where values are no numbers, or there are too many stars.
    fn finish(&self, job: &Job, radiance: Radiance) -> Result<Image> {
        finished(job.scene(), job.plan(&Control::default())?, radiance, &self.name())
    }

    /// Both in one go.
    ///
    /// # Errors
    /// Those of [`radiance`](Self::radiance) and [`finish`](Self::finish).
    fn render(&mut self, job: &Job, control: &Control) -> Result<(Image, RenderStats)> {
        let radiance = self.radiance(job, control)?;
        let stats = radiance.stats;
        Ok((self.finish(job, radiance)?, stats))
    }

    /// What sweeps light that is scattered more than once beside the processor, where there is something.
    fn sweeper(&self) -> Option<Arc<dyn Sweeper>> {
        None
    }

    /// What a device of its own worked for the last light \[s\]; none where there is no such device, or it does not
    /// tell.
    fn device_seconds(&self) -> Option<f64> {
        None
    }

    /// What went wrong on the way to the last light, in words, though there is light.
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
    /// Where there is no such star, or the place is none.
    fn move_star(&mut self, _star: usize, _place: DVec3) -> Result<Option<f64>> {
        Ok(None)
    }
}

/// Whether a back end renders on a graphics device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceUse {
    /// On the processor alone.
    Never,
    /// On any device, be it software.
    Always,
    /// On a real one where there is one, otherwise on the processor.
    IfReal,
}

/// One row of the catalogue.
#[derive(Debug, Clone, Copy)]
pub struct BackendEntry {
    /// Its name on the command line.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Whether it reads the job's plan, and not the scene itself.
    pub planned: bool,
    /// Whether it renders on a graphics device, for programs that have one open.
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
    /// Those of this crate.
    fn default() -> Self {
        Self(BACKENDS.to_vec())
    }
}

impl Registry {
    /// The same with others behind.
    #[must_use]
    pub fn with(mut self, entries: &[BackendEntry]) -> Self {
        self.0.extend_from_slice(entries);
        self
    }

    /// All rows.
    pub fn entries(&self) -> &[BackendEntry] {
        &self.0
    }

    /// The row called `name`.
    ///
    /// # Errors
    /// Where there is none.
    pub fn named(&self, name: &str) -> Result<&BackendEntry> {
        let known: Vec<&str> = self.0.iter().map(|b| b.name).collect();
        Ok(self.0.iter().find(|b| b.name == name).ok_or_else(|| SpectraError::unknown("back end", name, &known))?)
    }
}
