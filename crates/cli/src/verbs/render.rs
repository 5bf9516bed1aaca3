//! `barnard render`

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::bail;
use barnard::backend::cpu::Findings;
use barnard::backend::{BACKENDS, cpu, reference};
use barnard::control::Control;
use barnard::formats::{check_writable, save};
use barnard::image::Image;
use barnard::plan::ordinates::Sweeper;
use barnard::plan::{Options, Plan};
use barnard::scene::Scene;
use barnard_gpu::{Gpu, Ordinates, Tuning};
use clap::{Args, ValueEnum};

use crate::progress;
use crate::source::SceneArgs;
use crate::verbs::referee::Referee;

/// Renders a scene.
///
/// Examples:
///   barnard render --builtin pillars -o pillars.png
///   barnard render my.toml -o my.fits --accuracy 1e-4
///   barnard render my.toml -o truth.npy --backend reference --size 64x64
///   barnard render my.toml -o many.exr --backend path --target-error 0.01 --samples 100000
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Render {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where to: .exr, .fits, .npy (radiance) or .png (picture); as often as there are files to write
    #[arg(short, long, value_name = "OUT", required = true)]
    output: Vec<PathBuf>,
    /// What renders
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
    backend: Backend,
    #[command(flatten)]
    referee: Referee,
    /// Evaluate dust that is one field of kind "fbm" at every sample of a ray, on the GPU, instead of sampling it to a grid
    #[arg(long)]
    on_the_fly: bool,
}

/// The rows of the back ends.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Backend {
    /// f32, SIMD, all cores
    Cpu,
    /// f32 on a graphics processor
    Gpu,
    /// gpu where there is a real one, otherwise cpu
    Auto,
    /// f64, paths of light by chance: any number of bounces, with standard errors
    Path,
    /// f64, adaptive, exact: slow
    Reference,
}

impl Render {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        debug_assert_eq!(BACKENDS.len(), Backend::value_variants().len());
        for path in &self.output {
            check_writable(path)?;
        }
        if self.on_the_fly && !matches!(self.backend, Backend::Gpu) {
            bail!("--on-the-fly belongs to --backend gpu; the reference evaluates fields as they are, cpu samples them");
        }
        if self.referee.is_asked() && self.backend != Backend::Path {
            bail!("--samples, --target-error, --seed and --state belong to --backend path");
        }
        let (scene, options) = self.scene.load()?;
        for path in &self.output {
            let same = |file: &&PathBuf| file.canonicalize().is_ok_and(|f| path.canonicalize().is_ok_and(|p| p == f));
            if let Some(input) = scene.files.iter().find(same) {
                bail!("{}: is read by the scene ({}); choose another name for the output", path.display(), input.display());
            }
        }
        let image = match self.backend {
            Backend::Cpu | Backend::Gpu | Backend::Auto => self.planned(&scene, &options)?,
            Backend::Path => self.on_path(&scene, options.memory_limit)?,
            Backend::Reference => self.on_reference(&scene)?,
        };
        for path in &self.output {
            save(&image, &scene.display, path)?;
            say!("wrote {}", path.display());
        }
        if self.output.iter().any(|path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))) {
            let tone = scene.display.tone(&image);
            let what = if scene.display.balance { "of the balanced bands" } else { "W m-2 sr-1" };
            say!("picture: black {:.3e}, white {:.3e} {what}", tone.black, tone.white);
        }
        Ok(ExitCode::SUCCESS)
    }

    fn on_path(&self, scene: &Scene, memory_limit: u64) -> anyhow::Result<Image> {
        let scene_args = &self.scene;
        if scene_args.method.is_some() || scene_args.steps.is_some() || scene_args.count.is_some() || scene_args.accuracy.is_some() {
            bail!("--method, --count, --steps and --accuracy belong to the other back ends; path takes --samples and --target-error");
        }
        self.referee.render(scene, memory_limit)
    }

    fn on_reference(&self, scene: &Scene) -> anyhow::Result<Image> {
        if self.scene.method.is_some() || self.scene.steps.is_some() || self.scene.count.is_some() {
            bail!("--method, --count and --steps belong to the other back ends; the reference is adaptive and takes --accuracy alone");
        }
        let control = progress::control()?;
        let start = Instant::now();
        let accuracy = self.scene.accuracy.unwrap_or(reference::DEFAULT_ACCURACY);
        let image = reference::render(scene, accuracy, &control)?;
        let seconds = start.elapsed().as_secs_f64();
        let rays = scene.camera.width * scene.camera.height * scene.camera.supersampling.pow(2);
        say!(
            "{} x {}, {} bands, {seconds:.2} s, {:.0} rays/s, accuracy {accuracy:e} of each pixel",
            image.width,
            image.height,
            image.bands.len(),
            rays as f64 / seconds
        );
        Ok(image)
    }
}

impl Render {
    /// By a back end that reads a plan.
    fn planned(&self, scene: &Scene, options: &Options) -> anyhow::Result<Image> {
        let control = progress::control()?;
        let start = Instant::now();
        let plan = Plan::new(scene, &Options { sweeper: self.sweeper(options), ..options.clone() }, &control)?;
        let planned = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let (image, findings) = match self.backend {
            Backend::Gpu => self.on_gpu(scene, &plan, &control)?,
            Backend::Auto => match self.why_not_gpu(&plan) {
                None => self.on_gpu(scene, &plan, &control)?,
                Some(why) => {
                    say!("auto: on the cpu, {why}");
                    cpu::render(scene, &plan, &control)?
                }
            },
            _ => cpu::render(scene, &plan, &control)?,
        };
        let seconds = start.elapsed().as_secs_f64();
        say!(
            "{} x {}, {} bands, plan {planned:.2} s, render {seconds:.2} s, {:.2e} rays/s, {} ({} terms a sample)",
            image.width,
            image.height,
            image.bands.len(),
            findings.rays as f64 / seconds,
            plan.spectral.method,
            plan.spectral.terms()
        );
        for (band, name) in image.bands.iter().enumerate().map(|(b, band)| (b, &band.name)) {
            say!("{name}: {}", plan.worst_certificate(band, &findings));
        }
        for (key, value) in plan.notes().into_iter().chain(findings.negative_note()) {
            say!("{key}: {value}");
        }
        crate::verbs::warn_of_accuracy(&plan);
        Ok(image)
    }

    /// What sweeps light that is scattered more than once: the device that marches, if it is one.
    fn sweeper(&self, options: &Options) -> Option<Arc<dyn Sweeper>> {
        let asked = options.method.bounces > 1 && matches!(self.backend, Backend::Gpu | Backend::Auto);
        asked.then(|| Ordinates::if_faster(&Gpu::open().ok()?)).flatten()
    }

    /// Why `auto` does not take the GPU.
    fn why_not_gpu(&self, plan: &Plan) -> Option<String> {
        let Some(best) = barnard_gpu::adapters().into_iter().next() else { return Some("no graphics adapter was found".into()) };
        if !best.real {
            return Some(format!("the only graphics adapter is software ({})", best.name));
        }
        barnard_gpu::unable(plan, self.tuning()).map(|e| e.to_string())
    }

    /// On the best adapter, as long as it does not give up.
    fn on_gpu(&self, scene: &Scene, plan: &Plan, control: &Control) -> anyhow::Result<(Image, Findings)> {
        let open = || {
            let gpu = Gpu::open()?;
            say!("{}", gpu.name());
            Ok(gpu)
        };
        Ok(barnard_gpu::render_surely(open, scene, plan, (self.tuning(), control), |words| complain!("warning: {words}"))?)
    }

    fn tuning(&self) -> Tuning {
        Tuning { on_the_fly: self.on_the_fly, ..Tuning::default() }
    }
}
