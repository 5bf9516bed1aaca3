//! `barnard bench`

use std::process::ExitCode;
use std::sync::Arc;

use barnard::Error;
use barnard::backend::cpu::Findings;
use barnard::bench::{Frames, OnCpu, Row, table, timed};
use barnard::control::Control;
use barnard::plan::Plan;
use barnard::plan::ordinates::Sweeper;
use barnard_gpu::{Gpu, GpuError, Ordinates, Renderer, Tuning};
use clap::{Args, ValueEnum};

use crate::progress;
use crate::source::SceneArgs;

/// Times the methods on one scene in one run, with their errors against the reference.
///
/// Times are medians over frames after one warm-up; machines are noisy, so the ratios are what counts.
#[derive(Args)]
pub struct Bench {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames for each method
    #[arg(long, default_value_t = 5)]
    frames: usize,
    /// Edge of the small image whose error is measured against the reference; 0 leaves the errors out
    #[arg(long, default_value_t = 48)]
    error_size: usize,
    /// Which methods, such as band_quadrature,newton; all if not given
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    methods: Option<Vec<String>>,
    /// What renders; methods that it does not do are left out
    #[arg(long, value_enum, default_value_t = Device::Cpu)]
    backend: Device,
    /// As JSON, for programs
    #[arg(long)]
    json: bool,
}

/// Back ends that read a plan.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Device {
    /// f32, SIMD, all cores
    Cpu,
    /// f32 on a graphics processor
    Gpu,
}

/// A device's frames.
struct OnGpu<'a> {
    gpu: &'a Gpu,
    renderer: Option<Renderer<'a>>,
    seconds: f64,
}

impl Frames for OnGpu<'_> {
    fn take(&mut self, plan: &Plan) -> barnard::Result<bool> {
        if barnard_gpu::unable(plan, Tuning::default()).is_some() {
            return Ok(false);
        }
        match &mut self.renderer {
            Some(renderer) => renderer.update(plan).map_err(told)?,
            None => self.renderer = Some(Renderer::new(self.gpu, plan, Tuning::default()).map_err(told)?),
        }
        Ok(true)
    }

    fn frame(&mut self, control: &Control) -> barnard::Result<(Vec<f32>, Findings)> {
        let renderer = self.renderer.as_mut().ok_or_else(|| Error::Render("no plan was taken".into()))?;
        let frame = renderer.radiance(control).map_err(told)?;
        self.seconds += renderer.seconds().unwrap_or(f64::NAN);
        Ok(frame)
    }

    fn sweeper(&self) -> Option<Arc<dyn Sweeper>> {
        Some(Arc::new(Ordinates::new(self.gpu.clone())))
    }

    /// What an edit of a spectrum uploads, and the depths of a star that has moved.
    fn others(&mut self, plan: &Plan, frames: usize) -> barnard::Result<Vec<(String, f64, f64)>> {
        let Some(renderer) = &mut self.renderer else { return Ok(Vec::new()) };
        let (seconds, device) = timed(frames, || renderer.update(plan).map(|()| f64::NAN).map_err(told))?;
        let mut rows = vec![("upload after a spectrum edit".to_owned(), seconds, device)];
        if let Some(number) = plan.space.marched().first() {
            let star = &plan.space.stars[*number];
            let sweep = || renderer.move_star(*number, *star).map(|s| s.unwrap_or(f64::NAN)).map_err(told);
            let (seconds, device) = timed(frames, sweep)?;
            rows.push(("star depths of one star".to_owned(), seconds, device));
        }
        Ok(rows)
    }

    fn device_seconds(&self) -> f64 {
        self.seconds
    }
}

fn told(error: GpuError) -> Error {
    match error {
        GpuError::Render(error) => error,
        other => Error::Render(other.to_string()),
    }
}

impl Bench {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        match self.backend {
            Device::Cpu => self.by(&mut OnCpu::default(), "CPU"),
            Device::Gpu => {
                let gpu = Gpu::open()?;
                if !self.json {
                    say!("{}; its own time by timestamps, without the way back of the picture", gpu.name());
                }
                self.by(&mut OnGpu { gpu: &gpu, renderer: None, seconds: 0.0 }, "GPU")
            }
        }
    }

    fn by(self, backend: &mut dyn Frames, device: &str) -> anyhow::Result<ExitCode> {
        let (scene, options) = self.scene.load()?;
        let methods = self.methods.as_deref();
        for name in methods.into_iter().flatten() {
            options.method.clone().with_name(name)?;
        }
        let (sizes, control) = ((self.frames.clamp(1, 1000), self.error_size.min(1024)), progress::control()?);
        if self.json {
            let mut list = Vec::new();
            let key = format!("{}_seconds", device.to_lowercase());
            table(backend, scene, &options, sizes, &control, methods, |row| list.push(json(&row, &key)))?;
            say!("{}", serde_json::to_string_pretty(&list)?);
            return Ok(ExitCode::SUCCESS);
        }
        say!("{:34} {:>6} {:>10} {:>10} {:>8} {:>10}", "method", "terms", "frame [s]", format!("{device} [s]"), "ratio", "error");
        let mut first = None;
        table(backend, scene, &options, sizes, &control, methods, |row| {
            let first = *first.get_or_insert(row.seconds);
            let error = row.error.map_or("-".into(), |e| format!("{e:.2e}"));
            say!(
                "{:34} {:>6} {:>10.4} {:>10.4} {:>8.3} {:>10}",
                row.name,
                row.terms,
                row.seconds,
                row.device_seconds,
                row.seconds / first,
                error
            );
        })?;
        Ok(ExitCode::SUCCESS)
    }
}

fn json(row: &Row, key: &str) -> serde_json::Value {
    serde_json::json!({ "method": row.name, "terms": row.terms, "seconds": row.seconds, key: row.device_seconds, "relative_rmse": row.error })
}
