//! Options and output of `barnard render --backend path`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::bail;
use barnard::Error;
use barnard::backend::path::{self, Film};
use barnard::control::Control;
use barnard::image::Image;
use barnard::properties::Value;
use barnard::scene::Scene;
use barnard_files::Change;
use barnard_files::formats::check_replaceable;
use clap::Args;

use crate::progress;
use crate::source::change;

/// Settings of the path tracer.
#[derive(Args)]
pub struct Referee {
    /// Paths per pixel and band, for --backend path (default: 64)
    #[arg(long, value_name = "N")]
    samples: Option<i64>,
    /// Relative standard error of the worst band at which --backend path stops, such as 0.01
    #[arg(long, value_name = "X")]
    target_error: Option<f64>,
    /// State file (.npz) of --backend path: resumed if it exists, written at the end and
    /// at Ctrl-C
    #[arg(long, value_name = "FILE")]
    state: Option<PathBuf>,
    /// Seed of --backend path (default: 1)
    #[arg(long, value_name = "N")]
    seed: Option<i64>,
}

impl Referee {
    /// True if any of the settings was given.
    pub fn is_asked(&self) -> bool {
        self.samples.is_some() || self.target_error.is_some() || self.seed.is_some() || self.state.is_some()
    }

    /// True if sums of paths are kept for a later run.
    pub fn keeps_sums(&self) -> bool {
        self.state.is_some()
    }

    /// The flags that stand for keys of the scene, as changes of those keys.
    pub fn changes(&self) -> Vec<Change> {
        let flags = [
            change("method.path.samples", self.samples.map(Value::Integer)),
            change("method.path.target_error", self.target_error.map(Value::Number)),
            change("method.path.seed", self.seed.map(Value::Integer)),
        ];
        flags.into_iter().flatten().collect()
    }

    fn check_state(&self) -> anyhow::Result<()> {
        let Some(state) = &self.state else { return Ok(()) };
        if state.extension().is_none_or(|e| !e.eq_ignore_ascii_case("npz")) {
            bail!("--state {}: the file name must end with .npz", state.display());
        }
        Ok(check_replaceable(state)?)
    }

    /// Follows paths until enough is known, or Ctrl-C: what is done until then is kept.
    pub fn render(&self, scene: &Scene, memory_limit: u64) -> anyhow::Result<Image> {
        self.check_state()?;
        let options = scene.method.backends.path;
        path::check_memory(scene, memory_limit)?;
        let note = progress::Note::default();
        let control = progress::control_with(&note)?;
        let (start, bands) = (Instant::now(), scene.bands.len());
        let mut film = match self.state.as_ref().filter(|path| path.exists()) {
            Some(path) => barnard_files::film::load(path, scene, &options, memory_limit)?,
            None => Film::default(),
        };
        let before = film.samples;
        if before > 0 {
            say!("resuming at {before} paths per pixel");
        }
        let worst = |film: &Film| (0..bands).map(|b| film.relative_error(b, bands)).fold(0.0, f64::max);
        let traced = path::trace(scene, &options, &mut film, &control, &mut |film| note.set(format!("error {:.2e}", worst(film))));
        match traced {
            Err(Error::Interrupted) if film.samples > 0 => {
                complain!("stopped after {} of {} paths per pixel; the state is saved", film.samples, options.samples)
            }
            traced => traced?,
        }
        let seconds = start.elapsed().as_secs_f64();
        if let Some(path) = &self.state {
            barnard_files::film::save(path, scene, &options, &film)?;
            say!("wrote {}", path.display());
        }
        let paths = (film.samples - before) as f64 * film.estimates.len() as f64;
        say!(
            "{} x {} px, {bands} bands, {} paths per pixel, {seconds:.2} s, {:.2e} paths/s, at most {} bounces, seed {}",
            scene.camera.width,
            scene.camera.height,
            film.samples,
            paths / seconds,
            scene.method.bounces,
            options.seed
        );
        for (band, passband) in scene.bands.iter().enumerate() {
            say!("{}: standard error {:.2e} (rms over pixels, relative to the band's)", passband.name(), film.relative_error(band, bands));
        }
        if let Some(target) = options.target_error.filter(|t| worst(&film) > *t) {
            complain!("warning: the error {:.2e} exceeds the requested {target:.2e}; increase --samples", worst(&film));
        }
        if film.bad > 0 {
            complain!("warning: {} paths were not finite and were skipped", film.bad);
        }
        Ok(path::image(scene, &film, &options, &Control::default())?)
    }
}
