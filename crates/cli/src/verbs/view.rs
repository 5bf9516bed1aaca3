//! `barnard view`

use std::path::PathBuf;
use std::process::ExitCode;

use barnard_viewer::Origin;
use barnard_viewer::{Start, ViewerError, open};
use clap::Args;

use crate::backends::{names, registry};

/// Opens the explorer: fly through a scene and edit it interactively.
///
/// Examples:
///   barnard view
///   barnard view my.toml
///   barnard view --builtin pillars
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct View {
    /// The scene file (TOML; see docs/scene-format.md)
    #[arg(conflicts_with = "builtin")]
    scene: Option<PathBuf>,
    /// Built-in scene instead of a file (see `barnard list scenes`)
    #[arg(long, value_name = "NAME")]
    builtin: Option<String>,
    /// Back end
    #[arg(long, value_name = "NAME", default_value = "auto", value_parser = names(true))]
    backend: String,
    /// Memory limit of one array, grid or image [GiB]
    #[arg(long, value_name = "GIB", default_value_t = 16.0)]
    memory: f64,
    /// Print timings: first picture, previews per second during changes, time to the final picture,
    /// and redraws of the window
    #[arg(long)]
    timings: bool,
}

impl View {
    /// The explorer with the first built-in scene, or what was not saved last time.
    pub fn plain() -> Self {
        Self { scene: None, builtin: None, backend: "auto".into(), memory: 16.0, timings: false }
    }

    /// True if there is a screen to open a window on.
    pub fn is_possible() -> bool {
        let named = |name: &str| std::env::var_os(name).is_some_and(|v| !v.is_empty());
        cfg!(any(target_os = "macos", target_os = "windows")) || named("DISPLAY") || named("WAYLAND_DISPLAY")
    }

    pub fn run(self) -> anyhow::Result<ExitCode> {
        let scene = match (self.scene, self.builtin) {
            (Some(path), _) => Some(Origin::at(path)),
            (None, Some(name)) => Some(Origin::Builtin(barnard_files::builtin::entry(&name)?.name)),
            (None, None) => None,
        };
        let backend = *registry().by_name(&self.backend)?;
        let (memory_limit, cache) = (crate::source::memory_limit(self.memory)?, crate::source::cache()?);
        let start = Start { scene, backend, memory_limit, cache, timings: self.timings };
        open(start).map_err(|e| match e {
            ViewerError::Scene(error) => anyhow::Error::from(error),
            other => other.into(),
        })?;
        Ok(ExitCode::SUCCESS)
    }
}
