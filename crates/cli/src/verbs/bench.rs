//! `barnard bench`

use std::process::ExitCode;

use barnard::bench::{Row, table};
use clap::Args;

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
    /// As JSON, for programs
    #[arg(long)]
    json: bool,
}

impl Bench {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let (scene, options) = self.scene.load()?;
        let (frames, error_size, control) = (self.frames.clamp(1, 1000), self.error_size.min(1024), progress::control()?);
        if self.json {
            let mut list = Vec::new();
            table(scene, &options, frames, error_size, &control, |row| list.push(json(&row)))?;
            say!("{}", serde_json::to_string_pretty(&list)?);
            return Ok(ExitCode::SUCCESS);
        }
        say!("{:34} {:>6} {:>10} {:>10} {:>8} {:>10}", "method", "terms", "frame [s]", "CPU [s]", "ratio", "error");
        let mut first = None;
        table(scene, &options, frames, error_size, &control, |row| {
            let first = *first.get_or_insert(row.seconds);
            let error = row.error.map_or("-".into(), |e| format!("{e:.2e}"));
            say!(
                "{:34} {:>6} {:>10.4} {:>10.4} {:>8.3} {:>10}",
                row.name,
                row.terms,
                row.seconds,
                row.cpu_seconds,
                row.seconds / first,
                error
            );
        })?;
        Ok(ExitCode::SUCCESS)
    }
}

fn json(row: &Row) -> serde_json::Value {
    serde_json::json!({ "method": row.name, "terms": row.terms, "seconds": row.seconds, "cpu_seconds": row.cpu_seconds, "relative_rmse": row.error })
}
