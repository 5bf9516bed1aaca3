//! Back ends: the ways to turn a scene into an image.
//!
//! A [`Backend`] has a name, states which [jobs](Job) it does not support, and finds their [`Radiance`]. Fast back ends read the
//! job's plan, exact ones its scene. A [`Renderer`] makes finished images of the light of any of them. A [`Registry`] lists the back
//! ends of a program: [`BACKENDS`], and those of other crates.

pub mod cpu;
mod describe;
mod device;
mod finish;
mod job;
pub mod path;
pub mod reference;
mod renderer;
mod seen_detail;

use std::pin::Pin;
use std::sync::Arc;

use spectra::SpectraError;

pub use describe::{describe, left_out};
pub use device::Device;
pub(crate) use finish::end_of_space;
pub use finish::{described, draw};
pub use job::Job;
pub use renderer::Renderer;

pub use crate::stats::RenderStats;

use crate::control::Control;
use crate::error::Result;
use crate::image::{Report, Samples};
use crate::plan::ordinates::Sweeper;
use crate::scene::Scene;

/// Light that a back end found, without the stars that are seen as points.
#[derive(Debug, Clone)]
pub struct Radiance {
    /// Radiances, bands × height × width [W m⁻² sr⁻¹].
    pub samples: Samples,
    /// Their standard errors, where the back end knows them.
    pub errors: Option<Samples>,
    /// Measurements of the march.
    pub stats: RenderStats,
    /// Statements of the back end beside those of a plan.
    pub report: Report,
}

impl Radiance {
    /// Light of which nothing is stated beside its plan.
    pub fn new(samples: Samples, stats: RenderStats) -> Self {
        Self { samples, errors: None, stats, report: Report::default() }
    }

    /// Light in single precision.
    pub fn single(data: Vec<f32>, stats: RenderStats) -> Self {
        Self::new(Samples::Single(data), stats)
    }
}

/// Parts of a job that a back end needs.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Input {
    /// The plan.
    Plan,
    /// The scene itself; visible stars are drawn behind depths of this relative accuracy \[1\].
    Scene {
        /// Accuracy of the stars' fluxes.
        accuracy: f64,
    },
}

/// Light that is being computed.
pub type Pending<'a> = Pin<Box<dyn Future<Output = Result<Radiance>> + 'a>>;

/// Method to find the light of a [`Job`].
///
/// # Examples
/// A back end that returns the same radiance everywhere; a [`Renderer`] adds header, stars and layers:
///
/// ```
/// use barnard::Result;
/// use barnard::backend::{Backend, Job, Radiance, RenderStats, Renderer};
/// use barnard::prelude::*;
///
/// struct Uniform(f32);
///
/// impl Backend for Uniform {
///     fn name(&self) -> String {
///         "uniform".into()
///     }
///     fn radiance(&mut self, job: &Job, _control: &Control) -> Result<Radiance> {
///         let scene = job.scene();
///         let values = scene.bands.len() * scene.camera.width * scene.camera.height;
///         Ok(Radiance::single(vec![self.0; values], RenderStats::of_rays(0)))
///     }
/// }
///
/// let scene = SceneSpec::new(Camera::look_at(dvec3(0.0, 0.0, 5.0), DVec3::ZERO).with_size(8, 8)).with_bands(passband::set("johnson")?).build()?;
/// let options = Options::default();
/// let (image, _) = Renderer::new(&mut Uniform(2.0)).render(Job::new(&scene, &options)?, &Control::default())?;
/// assert!(image.band(0).all(|v| v == 2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Backend: Send {
    /// The name in headers of images, with the device.
    fn name(&self) -> String;

    /// Parts of a job that this back end needs.
    fn input(&self) -> Input {
        Input::Plan
    }

    /// The first feature of a job that it does not support, and an alternative; `None` if it supports the job.
    ///
    /// # Errors
    /// If the job cannot be planned at all.
    fn unsupported(&self, _job: &Job, _control: &Control) -> Result<Option<String>> {
        Ok(None)
    }

    /// The light of a job.
    ///
    /// # Errors
    /// If the job cannot be planned or is not supported, and on interruption by the user.
    fn radiance(&mut self, job: &Job, control: &Control) -> Result<Radiance>;

    /// Variant of [`radiance`](Self::radiance) for callers that must not block. Back ends on the processor are done at once.
    fn radiance_async<'a>(&'a mut self, job: &'a Job, control: &'a Control) -> Pending<'a> {
        Box::pin(std::future::ready(self.radiance(job, control)))
    }

    /// The graphics device that it renders on.
    fn device(&mut self) -> Option<&mut dyn Device> {
        None
    }

    /// A faster device for multiple scattering than the processor, where there is one.
    fn sweeper(&mut self) -> Option<Arc<dyn Sweeper>> {
        self.device()?.sweeper()
    }
}

/// Use of a graphics device by a back end.
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
    /// Makes one with its default settings.
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
