//! The device as a back end: [`OnDevice`] renders on it or says why not, [`Auto`] takes it where it is a real one that
//! does the job.

use std::sync::Arc;

use barnard::Error;
use barnard::backend::cpu::{self, Cpu};
use barnard::backend::{Backend, BackendEntry, Device, DeviceUse, Job, Pending, Radiance};
use barnard::control::Control;
use barnard::plan::Plan;
use barnard::plan::ordinates::Sweeper;
use glam::DVec3;
use web_time::Instant;

use crate::device::{Gpu, adapters};
use crate::error::{GpuError, Result};
use crate::layout::ShaderLayout;
use crate::march::DeviceMarch;
use crate::ordinates::Ordinates;
use crate::tuning::Tuning;

/// The rows of this crate.
pub const BACKENDS: &[BackendEntry] = &[
    BackendEntry {
        name: "gpu",
        summary: "f32 on a graphics processor (Vulkan, Metal, DirectX 12), reads only the plan; all methods but random wavelengths",
        planned: true,
        device: DeviceUse::Always,
        open: |scene| Ok(Box::new(OnDevice::open(Tuning::of(scene))?)),
    },
    BackendEntry {
        name: "auto",
        summary: "gpu if a real device supports the method, otherwise cpu; prints the choice and the reason",
        planned: true,
        device: DeviceUse::IfReal,
        open: |scene| Ok(Box::new(Auto::new(Tuning::of(scene)))),
    },
];

/// Why no device can render this plan; none where one can, as far as its limits go.
pub fn unable(plan: &Plan, tuning: Tuning) -> Option<GpuError> {
    ShaderLayout::new(plan, Vec::new(), tuning.on_the_fly).err()
}

/// A device, and the plan that stays on it from picture to picture.
pub struct OnDevice {
    gpu: Gpu,
    tuning: Tuning,
    renderer: Option<DeviceMarch>,
    /// The plan that was taken up last.
    taken: Option<Plan>,
    /// The time that the device worked for the last picture [s].
    seconds: Option<f64>,
    /// Opens a device in place of one that gave up.
    reopen: Box<dyn FnMut() -> Result<Gpu> + Send>,
    /// Why it gave up for good, once it did: the processor takes its place.
    lost: Option<String>,
    /// Warnings, in words.
    warnings: Vec<String>,
}

impl OnDevice {
    /// The best adapter of this machine.
    ///
    /// # Errors
    /// If there is none, or it does not open.
    pub fn open(tuning: Tuning) -> Result<Self> {
        Ok(Self::new(Gpu::open()?, tuning))
    }

    /// A device that is open.
    pub fn new(gpu: Gpu, tuning: Tuning) -> Self {
        let reopen = Box::new(Gpu::open);
        Self { gpu, tuning, renderer: None, taken: None, seconds: None, reopen, lost: None, warnings: Vec::new() }
    }

    /// The device that it renders on.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Copy of the back end, where `reopen` opens another device in place of one that gave up.
    #[must_use]
    pub fn reopened_by(self, reopen: impl FnMut() -> Result<Gpu> + Send + 'static) -> Self {
        Self { reopen: Box::new(reopen), ..self }
    }

    /// Puts a plan onto the device, as little of it as has changed.
    /// Where that fails, nothing stays there.
    fn take(&mut self, plan: &Plan) -> Result<()> {
        self.taken = None;
        let renderer = match self.renderer.take() {
            Some(mut renderer) => renderer.update(plan).map(|()| renderer)?,
            None => DeviceMarch::new(&self.gpu, plan, self.tuning)?,
        };
        (self.renderer, self.taken) = (Some(renderer), Some(plan.clone()));
        Ok(())
    }

    async fn march(&mut self, plan: &Plan, control: &Control) -> Result<Radiance> {
        if self.taken.as_ref().is_none_or(|taken| !taken.is(plan)) {
            self.take(plan)?;
        }
        let renderer = self.renderer.as_mut().ok_or(GpuError::NoAdapter)?;
        let (data, stats) = renderer.radiance_async(control).await?;
        self.seconds = renderer.seconds();
        Ok(Radiance::single(data, stats))
    }

    /// Marches once; a device that gives up is opened once more, and has given up for good where it does not open.
    async fn march_again(&mut self, plan: &Plan, control: &Control) -> Result<Radiance> {
        match self.march(plan, control).await {
            Err(GpuError::Lost(why)) => {
                self.warnings.push(format!("the device failed: {why}"));
                (self.renderer, self.taken) = (None, None);
                self.gpu = (self.reopen)().map_err(|_| GpuError::Lost(why))?;
                self.march(plan, control).await
            }
            done => done,
        }
    }

    /// Light of a job: by the device, or by the processor once the device is lost.
    async fn found(&mut self, job: &Job<'_>, control: &Control) -> barnard::Result<Radiance> {
        let plan = job.plan(control)?;
        if self.lost.is_none() {
            match self.march_again(plan, control).await {
                Err(GpuError::Lost(why)) => {
                    self.warnings.push(format!("the device failed: {why}"));
                    self.lost = Some(why);
                }
                done => {
                    let mut radiance = done?;
                    if self.tuning.on_the_fly {
                        let words = "noise at every sample; star depths and empty space as sampled";
                        radiance.report.notes.push(("density".into(), words.into()));
                    }
                    return Ok(radiance);
                }
            }
        }
        let (data, stats) = cpu::radiance(plan, control)?;
        Ok(Radiance::single(data, stats))
    }
}

impl Backend for OnDevice {
    fn name(&self) -> String {
        if self.lost.is_some() { "cpu".into() } else { self.gpu.name() }
    }

    fn unsupported(&self, job: &Job, control: &Control) -> barnard::Result<Option<String>> {
        Ok(unable(job.plan(control)?, self.tuning).map(|e| e.to_string()))
    }

    fn radiance(&mut self, job: &Job, control: &Control) -> barnard::Result<Radiance> {
        pollster::block_on(self.found(job, control))
    }

    fn radiance_async<'a>(&'a mut self, job: &'a Job, control: &'a Control) -> Pending<'a> {
        Box::pin(self.found(job, control))
    }

    fn device(&mut self) -> Option<&mut dyn Device> {
        Some(self)
    }
}

impl Device for OnDevice {
    fn prepare(&mut self, job: &Job, control: &Control) -> barnard::Result<()> {
        let plan = job.plan(control)?;
        if self.lost.is_some() { Ok(()) } else { Ok(self.take(plan)?) }
    }

    fn sweeper(&self) -> Option<Arc<dyn Sweeper>> {
        Ordinates::if_faster(&self.gpu)
    }

    fn seconds(&self) -> Option<f64> {
        self.seconds
    }

    fn warm_up(&mut self, seconds: f64, control: &Control) -> barnard::Result<()> {
        let start = Instant::now();
        while let Some(renderer) = self.renderer.as_mut().filter(|_| start.elapsed().as_secs_f64() < seconds) {
            renderer.refine(control)?;
        }
        Ok(())
    }

    fn move_star(&mut self, star: usize, position: DVec3) -> barnard::Result<bool> {
        let Some(renderer) = self.renderer.as_mut().filter(|renderer| renderer.can_move(star)) else { return Ok(false) };
        self.taken = None;
        self.seconds = renderer.move_star(star, position)?;
        Ok(true)
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    fn fallback(&self) -> Option<String> {
        self.lost.as_ref().map(|why| format!("the device failed: {why}"))
    }
}

/// The device where it is a real one that does the job, otherwise the processor.
pub struct Auto {
    device: std::result::Result<OnDevice, String>,
    processor: Cpu,
    /// Why the processor does the job at hand; none where the device does.
    instead: Option<String>,
}

impl Auto {
    /// Looks for a real device.
    pub fn new(tuning: Tuning) -> Self {
        Self::of(match adapters().into_iter().next() {
            None => Err("no graphics adapter was found".into()),
            Some(best) if !best.real => Err(format!("the only graphics adapter is software ({})", best.name)),
            Some(_) => OnDevice::open(tuning).map_err(|e| e.to_string()),
        })
    }

    /// A device that is open, whatever it is.
    pub fn on(device: OnDevice) -> Self {
        Self::of(Ok(device))
    }

    /// Chooses between a device, or why there is none, and the processor.
    fn of(device: std::result::Result<OnDevice, String>) -> Self {
        let instead = device.as_ref().err().cloned();
        Self { device, processor: Cpu, instead }
    }

    /// The back end that does the job at hand.
    fn chosen(&self) -> &dyn Backend {
        match &self.device {
            Ok(device) if self.instead.is_none() => device,
            _ => &self.processor,
        }
    }

    /// Chooses the back end that does this job from now on.
    fn choose(&mut self, job: &Job, control: &Control) -> barnard::Result<&mut dyn Backend> {
        if let Ok(device) = &self.device {
            self.instead = device.unsupported(job, control)?;
        }
        Ok(match &mut self.device {
            Ok(device) if self.instead.is_none() => device,
            _ => &mut self.processor,
        })
    }

    /// Light of a job. A device that cannot hold the job after all, whatever its limits said, leaves it to the processor.
    async fn found(&mut self, job: &Job<'_>, control: &Control) -> barnard::Result<Radiance> {
        match self.choose(job, control)?.radiance_async(job, control).await {
            Err(error @ Error::Device(_)) if self.instead.is_none() => {
                self.instead = Some(error.to_string());
                self.processor.radiance(job, control)
            }
            done => done,
        }
    }
}

impl Backend for Auto {
    fn name(&self) -> String {
        self.chosen().name()
    }

    fn radiance(&mut self, job: &Job, control: &Control) -> barnard::Result<Radiance> {
        pollster::block_on(self.found(job, control))
    }

    fn radiance_async<'a>(&'a mut self, job: &'a Job, control: &'a Control) -> Pending<'a> {
        Box::pin(self.found(job, control))
    }

    fn device(&mut self) -> Option<&mut dyn Device> {
        Some(self)
    }
}

impl Device for Auto {
    fn prepare(&mut self, job: &Job, control: &Control) -> barnard::Result<()> {
        match self.choose(job, control)?.device().map(|device| device.prepare(job, control)) {
            None | Some(Err(Error::Device(_))) => Ok(()),
            Some(done) => done,
        }
    }

    fn sweeper(&self) -> Option<Arc<dyn Sweeper>> {
        self.device.as_ref().ok().and_then(Device::sweeper)
    }

    fn seconds(&self) -> Option<f64> {
        self.device.as_ref().ok().and_then(Device::seconds)
    }

    fn warm_up(&mut self, seconds: f64, control: &Control) -> barnard::Result<()> {
        match &mut self.device {
            Ok(device) if self.instead.is_none() => device.warm_up(seconds, control),
            _ => Ok(()),
        }
    }

    fn move_star(&mut self, star: usize, position: DVec3) -> barnard::Result<bool> {
        match &mut self.device {
            Ok(device) if self.instead.is_none() => device.move_star(star, position),
            _ => Ok(false),
        }
    }

    fn warnings(&self) -> Vec<String> {
        self.device.as_ref().map_or_else(|_| Vec::new(), Device::warnings)
    }

    fn fallback(&self) -> Option<String> {
        self.instead.clone().or_else(|| self.device.as_ref().ok().and_then(Device::fallback))
    }
}
