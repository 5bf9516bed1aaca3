//! Which scene, and what the command line changes of it.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, bail};
use barnard::Control;
use barnard::cache::Cache;
use barnard::plan::Options;
use barnard::properties::Value;
use barnard::scene::{Loader, Scene};
use barnard_files::{Change, SceneFile};
use clap::Args;
use serde_json::json;

use crate::backends::tracer;
use crate::progress;

/// The scene and its overrides.
#[derive(Args)]
pub struct SceneArgs {
    /// The scene file (TOML; see docs/scene-format.md)
    #[arg(required_unless_present = "builtin", conflicts_with = "builtin")]
    pub scene: Option<PathBuf>,
    /// Built-in scene instead of a file (see `barnard list scenes`)
    #[arg(long, value_name = "NAME")]
    pub builtin: Option<String>,
    /// Spectral method (see `barnard list methods`)
    #[arg(long, value_name = "NAME")]
    pub method: Option<String>,
    /// Allowed error, such as 1e-3 (default: the scene's; reference: 1e-5)
    #[arg(long, value_name = "X")]
    pub accuracy: Option<f64>,
    /// Fixed number of samples per ray, for comparisons
    #[arg(long, value_name = "N")]
    pub steps: Option<i64>,
    /// Fixed number of nodes, intervals, elements or samples of the method, for comparisons
    #[arg(long, value_name = "N")]
    pub count: Option<i64>,
    /// Largest number of scatterings of starlight, 1000 for all (default: the scene's)
    #[arg(long, value_name = "N")]
    pub bounces: Option<i64>,
    /// Use [bookmark.NAME] of the scene instead of its camera
    #[arg(long, value_name = "NAME")]
    pub bookmark: Option<String>,
    /// Size of the image, such as 1920x1080
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<(usize, usize)>,
    /// Part of the image to render, in pixels from the upper left corner, such as 512,0,256,256
    #[arg(long, value_name = "COLUMN,ROW,WIDTH,HEIGHT", value_parser = parse_crop)]
    pub crop: Option<[usize; 4]>,
    /// Override a scene key, such as 'star[0].temperature=9000 K' (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Change>,
    /// Number of threads (default: all cores)
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Memory limit of one array, grid or image [GiB]
    #[arg(long, value_name = "GIB", default_value_t = 16.0)]
    pub memory: f64,
}

/// The cache of the user, unless `--no-cache` was given.
pub fn cache() -> anyhow::Result<Option<Arc<dyn Cache>>> {
    let is_off = crate::IS_WITHOUT_CACHE.load(std::sync::atomic::Ordering::Relaxed);
    Ok(if is_off { None } else { barnard_files::cache::of_user()? })
}

/// The limit that --memory says [bytes].
pub fn memory_limit(gib: f64) -> anyhow::Result<u64> {
    if !(gib > 0.0 && gib < 1e6) {
        bail!("--memory {gib} is out of range; give a number of GiB such as 8");
    }
    Ok((gib * f64::from(1u32 << 30)) as u64)
}

/// A change of a key by a flag, if given.
pub fn change(key: &str, value: Option<Value>) -> Option<Change> {
    value.map(|value| Change { key: key.to_owned(), value })
}

fn parse_crop(text: &str) -> Result<[usize; 4], String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|t| t.trim().parse().ok()).collect();
    let four = numbers.and_then(|numbers| numbers.try_into().ok());
    four.ok_or_else(|| "a crop must be column,row,width,height in whole numbers, such as 512,0,256,256".into())
}

fn parse_size(text: &str) -> Result<(usize, usize), String> {
    let wrong = || format!("a size must be two whole numbers from 1 to {}, such as 1920x1080", barnard::camera::MAX_EDGE);
    let (w, h) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
    let edge = |t: &str| t.trim().parse().ok().filter(|n| (1..=barnard::camera::MAX_EDGE).contains(n)).ok_or_else(wrong);
    Ok((edge(w)?, edge(h)?))
}

impl SceneArgs {
    /// The limit of memory [bytes].
    pub fn memory_limit(&self) -> anyhow::Result<u64> {
        memory_limit(self.memory)
    }

    /// Loads the scene and applies the overrides; starts the threads.
    pub fn load(&self) -> anyhow::Result<(Scene, Options)> {
        self.load_for("cpu")
    }

    /// Variant for a back end: where that is a device, it has the light of several stars go through gas.
    pub fn load_for(&self, backend: &str) -> anyhow::Result<(Scene, Options)> {
        self.load_with(backend, Vec::new())
    }

    /// Variant with changes of more keys.
    pub fn load_with(&self, backend: &str, more: Vec<Change>) -> anyhow::Result<(Scene, Options)> {
        let (file, options) = self.open_with(backend, more)?;
        Ok((self.adjusted(file.scene, options.memory_limit, &Control::default())?, options))
    }

    /// Reads the scene for a back end, with its camera as the file has it; starts the threads.
    pub fn open_for(&self, backend: &str) -> anyhow::Result<(SceneFile, Options)> {
        self.open_with(backend, Vec::new())
    }

    /// Variant with changes of more keys.
    pub fn open_with(&self, backend: &str, more: Vec<Change>) -> anyhow::Result<(SceneFile, Options)> {
        if let Some(threads) = self.threads {
            if !(1..=4096).contains(&threads) {
                bail!("--threads {threads} is out of range; give a number from 1 to 4096");
            }
            rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().context("cannot start the threads")?;
        }
        let changes: Vec<Change> = self.changes(backend).into_iter().chain(more).collect();
        let memory_limit = self.memory_limit()?;
        let control = progress::control()?;
        let cache = cache()?;
        let prepared = |loader: &Loader| loader.under(&control).traced_by(tracer(backend)).with_cache(cache.clone());
        let file = match (&self.scene, &self.builtin) {
            (_, Some(name)) => barnard_files::builtin::open_with(name, &changes, memory_limit, prepared)?,
            // "-" is the standard input, as other programs have it.
            (Some(path), None) if path.as_os_str() == "-" => {
                barnard_files::open_with("/dev/stdin".as_ref(), &changes, memory_limit, prepared)?
            }
            (Some(path), None) => barnard_files::open_with(path, &changes, memory_limit, prepared)?,
            (None, None) => bail!("a scene is required; give a file, or --builtin NAME"),
        };
        control.check()?;
        for input in file.scene.inputs.iter().filter(|input| input.is_inferred) {
            complain!("note: {}: {}", input.file, input.text);
        }
        Ok((file, Options::within(memory_limit).with_cache(cache)))
    }

    /// The flags that stand for keys of the scene, as changes of those keys.
    fn changes(&self, backend: &str) -> Vec<Change> {
        let accuracy = if backend == "reference" { "method.reference.accuracy" } else { "method.accuracy" };
        let flags = [
            change("method.name", self.method.clone().map(Value::Text)),
            change(accuracy, self.accuracy.map(Value::Number)),
            change("method.steps", self.steps.map(Value::Integer)),
            change("method.count", self.count.map(Value::Integer)),
            change("method.bounces", self.bounces.map(Value::Integer)),
        ];
        self.set.iter().cloned().chain(flags.into_iter().flatten()).collect()
    }

    /// The flags that change a scene after it was read, with their values; null for those that are absent.
    fn flags(&self) -> [(&'static str, serde_json::Value); 3] {
        [("--bookmark", json!(self.bookmark)), ("--size", json!(self.size)), ("--crop", json!(self.crop))]
    }

    /// Refuses flags that change a scene that was read, where it is read again: `--set` changes its text.
    pub fn refuse_overrides(&self, why: &str) -> anyhow::Result<()> {
        match self.flags().iter().find(|(_, value)| !value.is_null()) {
            Some((flag, _)) => bail!("{flag}: {why}; change scene keys instead, such as --set \"camera.size=[640, 480]\""),
            None => Ok(()),
        }
    }

    /// The overrides that are no keys of the scene, in words.
    pub fn overrides(&self) -> String {
        json!(self.flags().map(|(_, value)| value)).to_string()
    }

    /// A scene with the overrides.
    pub fn adjusted(&self, scene: Scene, memory_limit: u64, control: &Control) -> anyhow::Result<Scene> {
        let mut scene = self.uncropped(scene, memory_limit, control)?;
        if let Some([column, row, width, height]) = self.crop {
            let camera = scene.camera.clone().crop(column, row, width, height)?;
            scene = scene.with_camera(camera);
        }
        scene.check_image(memory_limit)?;
        Ok(scene)
    }

    /// A scene with the overrides but for the crop.
    pub fn uncropped(&self, scene: Scene, memory_limit: u64, control: &Control) -> anyhow::Result<Scene> {
        let mut camera = scene.camera.clone();
        if let Some(name) = &self.bookmark {
            let names: Vec<&str> = scene.bookmarks.keys().map(String::as_str).collect();
            camera = match scene.bookmarks.get(name) {
                Some(camera) => camera.clone(),
                None if names.is_empty() => {
                    bail!("--bookmark {name}: the scene has no bookmarks; add [bookmark.{name}], or set one in the explorer")
                }
                None => bail!("--bookmark {name}: unknown bookmark; known: {}", names.join(", ")),
            };
        }
        if let Some((width, height)) = self.size {
            camera = camera.with_size(width, height);
        }
        Ok(scene.edited_within(memory_limit, control, |spec| spec.camera = camera)?)
    }
}
