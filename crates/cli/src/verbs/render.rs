//! `barnard render`

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Instant;

use anyhow::bail;
use barnard::backend::reference::Reference;
use barnard::backend::{Backend, Job, RenderStats};
use barnard::composite::joined;
use barnard::control::Control;
use barnard::image::{Image, LayerChoice};
use barnard::plan::{Options, Plan};
use barnard::points;
use barnard::properties::Value;
use barnard::scene::Scene;
use barnard_files::Change;
use barnard_files::formats::check_writable;
use clap::Args;

use crate::backends::{names, registry};
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
        for path in self.output.iter().filter(|path| !path.to_string_lossy().contains('%')) {
            match outputs::standard(path)? {
                Some(_) => outputs::IS_PICTURE.store(true, Ordering::Relaxed),
                None => check_writable(path)?,
            }
        }
        let (scene, options) = self.scene.load_with(&self.backend, self.changes())?;
        outputs::check(&self.output, &scene.camera)?;
        let scene = outputs::layered(scene, self.layers, &self.output, options.memory_limit)?;
        crate::verbs::refuse_inputs(&scene, &self.output)?;
        let (image, error) = match self.backend.as_str() {
            // It prints the errors of its paths itself.
            "path" => (self.on_path(&scene, &options)?, None),
            "reference" => self.on_reference(&scene, &options)?,
            _ => self.planned(&scene, options)?,
        };
        points::catalogue_note(&scene, &scene.camera).iter().for_each(|note| say!("catalogue: {note}"));
        let files = self.output.iter().map(|path| outputs::save(&image, path, &scene.camera)).collect::<anyhow::Result<Vec<_>>>()?;
        if let Some(error) = error {
            let (width, height, bands) = (image.width, image.height, counted(image.bands.len(), "band"));
            say!("{width} x {height} px, {bands}, {:.1} s; relative error: {error}", start.elapsed().as_secs_f64());
        }
        files.iter().flatten().for_each(|file| say!("wrote {}", file.display()));
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
        options.sweeper = backend.sweeper().filter(|_| file.scene.method.bounces > 1);
        let identity = format!("{}{}", barnard_files::toml::text(file.tree()), self.scene.overrides());
        let mut march = |scene: &Scene, plan: &Plan, control: &Control| {
            let done = backend.render(&Job::planned(scene, &options, plan)?, control);
            for words in backend.warnings() {
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
        let [left, right] = eyes.map(|camera| self.referee.render(&Scene { camera, ..scene.clone() }, options.memory_limit));
        Ok(joined(stereo.arrangement, left?, &right?)?)
    }

    /// An image with its relative error in words.
    fn on_reference(&self, scene: &Scene, options: &Options) -> anyhow::Result<(Image, Option<String>)> {
        if self.scene.method.is_some() || self.scene.steps.is_some() || self.scene.count.is_some() {
            bail!("--method, --count and --steps are not supported by --backend reference, which is adaptive; use --accuracy");
        }
        let control = progress::control()?;
        let start = Instant::now();
        let accuracy = scene.method.backends.reference_accuracy;
        let (image, stats) = Reference { accuracy }.render(&Job::new(scene, options)?, &control)?;
        detail!("{:.0} rays/s", stats.rays as f64 / start.elapsed().as_secs_f64());
        Ok((image, Some(format!("{accuracy:e} of each pixel"))))
    }

    /// Renders by a back end that reads a plan: an image with its relative error in words.
    fn planned(&self, scene: &Scene, mut options: Options) -> anyhow::Result<(Image, Option<String>)> {
        let control = progress::control()?;
        let mut backend = self.open(scene)?;
        options.sweeper = backend.sweeper().filter(|_| scene.method.bounces > 1);
        let start = Instant::now();
        let plan = Plan::new(scene, &options, &control)?;
        let planned = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let (image, stats) = rendered(&mut *backend, &Job::planned(scene, &options, &plan)?, &control)?;
        let seconds = start.elapsed().as_secs_f64();
        detail!(
            "plan {planned:.2} s, render {seconds:.2} s, {:.2e} rays/s, method {} ({} per sample)",
            stats.rays as f64 / seconds,
            plan.spectral().method,
            counted(plan.spectral().terms(), "term")
        );
        for (band, name) in image.bands.iter().enumerate().map(|(b, band)| (b, &band.name)) {
            detail!("{name}: {}", plan.worst_certificate(band, &stats));
        }
        plan.notes().iter().for_each(|(key, value)| detail!("{key}: {value}"));
        stats.negative_note().iter().for_each(|(key, value)| say!("{key}: {value}"));
        crate::verbs::warn_of_accuracy(&plan);
        let more = if IS_VERBOSE.load(Ordering::Relaxed) { "" } else { " (details: --verbose)" };
        Ok((image, Some(format!("{}{more}", plan.error_summary(&stats)))))
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

/// Renders, and tells who did it where it is not the processor.
fn rendered(backend: &mut dyn Backend, job: &Job, control: &Control) -> anyhow::Result<(Image, RenderStats)> {
    let done = backend.render(job, control);
    for words in backend.warnings() {
        complain!("warning: {words}");
    }
    let done = done?;
    if let Some(why) = backend.instead() {
        say!("on the cpu: {why}");
    } else if backend.device_seconds().is_some() {
        say!("{}", backend.name());
    }
    Ok(done)
}
