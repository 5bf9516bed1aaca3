//! `barnard render`

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use anyhow::bail;
use barnard::backend::reference::Reference;
use barnard::backend::{Backend, Job, RenderStats, Renderer};
use barnard::composite::joined;
use barnard::control::Control;
use barnard::image::{Image, LayerChoice, Report};
use barnard::plan::ordinates::Sweeper;
use barnard::plan::{Options, Planned, Planner};
use barnard::points;
use barnard::properties::Value;
use barnard::scene::Scene;
use barnard_files::Change;
use barnard_files::formats::check_writable;
use clap::Args;

use crate::backends::{names, registry};
use crate::json::{self, json_of_image};
use crate::source::{SceneArgs, change};
use crate::verbs::frames::{FrameArgs, Shoot};
use crate::verbs::referee::Referee;
use crate::{IS_VERBOSE, counted, outputs, progress};

/// Renders a scene.
///
/// Examples:
///   barnard render --builtin pillars -o pillars.png
///   barnard render my.toml -o my.fits --accuracy 1e-4
///   barnard render my.toml -o truth.npy --backend reference --size 64x64
///   barnard render my.toml -o many.exr --backend path --target-error 0.01 --samples 100000
///   barnard render my.toml -o layers.exr --layers all
///   barnard render flight.toml -o frames/flight_%06d.exr --frames all --shard 1/4
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Render {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output file: .exr, .fits, .npy (radiance), .png, .tif or .jpg (picture); repeatable
    #[arg(short, long, value_name = "OUT", required = true)]
    output: Vec<PathBuf>,
    /// Back end
    #[arg(long, value_name = "NAME", default_value = "cpu", value_parser = names(false))]
    backend: String,
    #[command(flatten)]
    frames: FrameArgs,
    /// Override the layers of .exr and .fits files: light, depth, tau, all or none
    #[arg(long, value_name = "LAYERS", value_parser = outputs::parse_layers)]
    layers: Option<LayerChoice>,
    #[command(flatten)]
    referee: Referee,
    /// Evaluate dust of a single field of kind "fbm" at every sample on the GPU, instead of sampling it to a
    /// grid
    #[arg(long)]
    on_the_fly: bool,
    /// Print files and report as JSON on standard output, other lines on standard error
    #[arg(long, conflicts_with = "frames")]
    json: bool,
}

impl Render {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        let start = Instant::now();
        if self.on_the_fly && self.backend != "gpu" {
            bail!("--on-the-fly requires --backend gpu; the reference evaluates fields exactly, cpu samples them");
        }
        if self.referee.is_asked() && self.backend != "path" {
            bail!("--samples, --target-error, --seed and --state require --backend path");
        }
        if self.frames.is_asked() {
            return self.sequence();
        }
        outputs::take_stdout(self.json);
        for path in self.output.iter().filter(|path| !path.to_string_lossy().contains('%')) {
            match outputs::standard(path)? {
                Some(_) if self.json => bail!("-o {}: standard output is taken by --json; write a file", path.display()),
                Some(_) => outputs::take_stdout(true),
                None => check_writable(path)?,
            }
        }
        let (scene, options) = self.scene.load_with(&self.backend, self.changes())?;
        outputs::check(&self.output, &scene.camera)?;
        let scene = outputs::layered(scene, self.layers, &self.output, options.memory_limit)?;
        crate::verbs::refuse_inputs(&scene, &self.output)?;
        let image = match self.backend.as_str() {
            "path" => self.on_path(&scene, &options)?,
            "reference" => self.on_reference(&scene, &options)?,
            _ => self.planned(&scene, options)?,
        };
        points::catalogue_note(&scene, &scene.camera).iter().for_each(|note| say!("catalogue: {note}"));
        let files = self.output.iter().map(|path| outputs::save(&image, path, &scene)).collect::<anyhow::Result<Vec<_>>>()?;
        if let Some(error) = relative_error(&image.report) {
            let (width, height, bands) = (image.width, image.height, counted(image.bands.len(), "band"));
            say!("{width} x {height} px, {bands}, {:.1} s; relative error: {error}", start.elapsed().as_secs_f64());
        }
        files.iter().flatten().for_each(|file| say!("wrote {}", file.display()));
        if self.json {
            let files: Vec<String> = files.iter().flatten().map(|file| file.display().to_string()).collect();
            json::print(&json_of_image(&image, &files, start.elapsed().as_secs_f64()));
        }
        if self.output.iter().any(|path| outputs::writer_of(path).is_ok_and(|writer| writer.is_picture)) {
            let tone = scene.display.tone(&image);
            let what = if scene.display.balance { "of the balanced bands" } else { "W m-2 sr-1" };
            detail!("picture: black {:.3e}, white {:.3e} {what}", tone.black, tone.white);
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Renders frame after frame.
    fn sequence(&self) -> anyhow::Result<ExitCode> {
        if !registry().by_name(&self.backend)?.planned {
            bail!("--frames is not supported by --backend {}; use cpu or gpu", self.backend);
        }
        let (file, mut options) = self.scene.open_with(&self.backend, self.changes())?;
        let sequence = file.sequence()?;
        if self.scene.bookmark.is_some() && file.scene.timeline.as_ref().is_some_and(|timeline| timeline.moves_camera()) {
            bail!("--bookmark conflicts with the scene's camera path; remove one");
        }
        let mut backend = self.open(&file.scene)?;
        options.sweeper = sweeper(&mut *backend, &file.scene);
        let identity = format!("{}{}", barnard_files::toml::text(file.tree()), self.scene.overrides());
        let mut march = |plan: &Planned, control: &Control| {
            let done = Renderer::new(&mut *backend).render(plan, control);
            for words in backend.device().iter().flat_map(|device| device.warnings()) {
                complain!("warning: {words}");
            }
            Ok(done?.0)
        };
        self.frames.render(
            &Shoot { scene: &self.scene, sequence: &sequence, options: &options, outputs: &self.output, layers: self.layers, identity },
            &mut march,
        )?;
        Ok(ExitCode::SUCCESS)
    }

    fn on_path(&self, scene: &Scene, options: &Options) -> anyhow::Result<Image> {
        let scene_args = &self.scene;
        if scene_args.method.is_some() || scene_args.steps.is_some() || scene_args.count.is_some() || scene_args.accuracy.is_some() {
            bail!("--method, --count, --steps and --accuracy are not supported by --backend path; use --samples and --target-error");
        }
        if scene.output.layers.is_any() {
            bail!("layers are not supported by --backend path; use cpu, gpu or reference");
        }
        let (Some(stereo), Some(eyes)) = (scene.camera.stereo, scene.camera.eyes()) else {
            return self.referee.render(scene, options.memory_limit);
        };
        if self.referee.keeps_sums() {
            bail!("--state does not support stereo; remove [camera.stereo]");
        }
        let [left, right] = eyes.map(|camera| self.referee.render(&scene.clone().with_camera(camera), options.memory_limit));
        Ok(joined(stereo.arrangement, left?, &right?)?)
    }

    fn on_reference(&self, scene: &Scene, options: &Options) -> anyhow::Result<Image> {
        if self.scene.method.is_some() || self.scene.steps.is_some() || self.scene.count.is_some() {
            bail!("--method, --count and --steps are not supported by --backend reference, which is adaptive; use --accuracy");
        }
        let control = progress::control()?;
        let start = Instant::now();
        let accuracy = scene.method.backends.reference_accuracy;
        let (image, stats) = Renderer::new(&mut Reference { accuracy }).render(Job::new(scene, options)?, &control)?;
        detail!("{:.0} rays/s", stats.rays as f64 / start.elapsed().as_secs_f64());
        Ok(image)
    }

    /// Renders by a back end that reads a plan.
    fn planned(&self, scene: &Scene, mut options: Options) -> anyhow::Result<Image> {
        let control = progress::control()?;
        let mut backend = self.open(scene)?;
        options.sweeper = sweeper(&mut *backend, scene);
        let start = Instant::now();
        let plan = Planner::new(&options).plan(scene, None, &control)?;
        let planned = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let (image, stats) = rendered(&mut *backend, &plan, &control)?;
        let seconds = start.elapsed().as_secs_f64();
        detail!(
            "plan {planned:.2} s, render {seconds:.2} s, {:.2e} rays/s, method {} ({} per sample)",
            stats.rays as f64 / seconds,
            plan.spectral().method,
            counted(plan.spectral().terms(), "term")
        );
        for band in &image.bands {
            detail!("{}: {}", band.name, image.report.worst_words(&band.name));
        }
        image.report.statements().iter().for_each(|(topic, words)| detail!("{topic}: {words}"));
        if image.report.negative > 0 {
            say!("negative values: {} pixels over all bands, unchanged", image.report.negative);
        }
        crate::verbs::warn_of_accuracy(&image.report);
        Ok(image)
    }

    fn open(&self, scene: &Scene) -> anyhow::Result<Box<dyn Backend>> {
        Ok((registry().by_name(&self.backend)?.open)(scene)?)
    }

    /// The flags that stand for keys of the scene, as changes of those keys.
    fn changes(&self) -> Vec<Change> {
        let on_the_fly = change("method.gpu.on_the_fly", self.on_the_fly.then_some(Value::Flag(true)));
        self.referee.changes().into_iter().chain(on_the_fly).collect()
    }
}

/// Renders, and prints the device if it is not the processor.
fn rendered(backend: &mut dyn Backend, plan: &Planned, control: &Control) -> anyhow::Result<(Image, RenderStats)> {
    let done = Renderer::new(backend).render(plan, control);
    let name = backend.name();
    let Some(device) = backend.device() else { return Ok(done?) };
    for words in device.warnings() {
        complain!("warning: {words}");
    }
    let done = done?;
    match device.fallback() {
        Some(why) => say!("on the cpu: {why}"),
        None => say!("{name}"),
    }
    Ok(done)
}

/// The device for multiple scattering, where a scene has that.
fn sweeper(backend: &mut dyn Backend, scene: &Scene) -> Option<Arc<dyn Sweeper>> {
    (scene.method.bounces > 1).then(|| backend.sweeper()).flatten()
}

/// The relative error of an image in words; none where its back end has printed it.
fn relative_error(report: &Report) -> Option<String> {
    if report.paths.is_some() {
        return None;
    }
    let more = if IS_VERBOSE.load(Ordering::Relaxed) { "" } else { " (details: --verbose)" };
    match (report.spectral_error(), report.accuracy) {
        (None, Some(accuracy)) if report.steps.is_none() => Some(format!("{accuracy:e} of each pixel")),
        _ => Some(format!("{}{more}", report.summary())),
    }
}
