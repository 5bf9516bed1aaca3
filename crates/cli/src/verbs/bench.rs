//! `barnard bench`

use std::process::ExitCode;

use barnard::backend::DeviceUse;
use barnard_study::bench::{self, MethodRow, table};
use clap::Args;

use crate::backends::{names, registry};
use crate::progress;
use crate::source::SceneArgs;

/// Times the methods on one scene, with their errors relative to the reference.
///
/// Times are medians over frames after one warm-up. Compare ratios, because machines are noisy.
#[derive(Args)]
pub struct Bench {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames per method
    #[arg(long, default_value_t = 5)]
    frames: usize,
    /// Edge of the small image for errors relative to the reference; 0 skips the errors
    #[arg(long, default_value_t = 48)]
    error_size: usize,
    /// Methods, such as band_quadrature,midpoint (default: all)
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    methods: Option<Vec<String>>,
    /// Back end; unsupported methods are skipped
    #[arg(long, value_name = "NAME", default_value = "cpu", value_parser = names(true))]
    backend: String,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl Bench {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let (scene, options) = self.scene.load_for(&self.backend)?;
        let scene = scene.for_files(false, false, options.memory_limit)?;
        let entry = *registry().by_name(&self.backend)?;
        let mut backend = (entry.open)(&scene)?;
        let on_device = entry.device != DeviceUse::Never;
        let device = if on_device { "GPU" } else { "CPU" };
        if !self.json && on_device {
            say!("{}; device time by timestamps, without the copy to main memory", backend.name());
        }
        // A name of before is that of now.
        let now = |name: &String| Ok(scene.method.clone().with_name(name)?.entry.name.to_owned());
        let methods = self.methods.as_ref().map(|names| names.iter().map(now).collect::<anyhow::Result<Vec<String>>>()).transpose()?;
        let (frames, error_size) = (self.frames.clamp(1, 1000), self.error_size.min(1024));
        let bench = bench::Bench { frames, error_size, methods: methods.as_deref(), options: &options };
        let (backend, control) = (&mut *backend, progress::control()?);
        if self.json {
            let mut list = Vec::new();
            let key = format!("{}_seconds", device.to_lowercase());
            table(backend, scene, &bench, &control, |row| list.push(json(&row, &key)))?;
            crate::json::print(&list.into());
            return Ok(ExitCode::SUCCESS);
        }
        say!("{:34} {:>6} {:>10} {:>10} {:>8} {:>10}", "method", "terms", "frame [s]", format!("{device} [s]"), "ratio", "error");
        let mut first = None;
        table(backend, scene, &bench, &control, |row| {
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

fn json(row: &MethodRow, key: &str) -> serde_json::Value {
    serde_json::json!({ "method": row.name, "terms": row.terms, "seconds": row.seconds, key: row.device_seconds, "relative_rmse": row.error })
}
