//! `barnard observe`

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, bail};
use barnard::backend::{Job, Renderer};
use barnard::image::{Image, LayerChoice};
use barnard::instrument::{Exposures, Flag, Instrument, MAX_FRAMES, preset};
use barnard::scene::Scene;
use barnard::spectra::units::{Time, short};
use barnard_files::SaveImage;
use barnard_files::formats::{check_replaceable, check_writable, numbered, save_frame};
use clap::Args;

use crate::backends::{names, registry};
use crate::json::{self, json_of_image};
use crate::source::SceneArgs;
use crate::{outputs, progress};

/// Simulates an observation with the scene's instrument: frames of counts, and a master with errors and a mask.
///
/// Examples:
///   barnard observe my.toml -o master.fits
///   barnard observe my.toml -o master.fits --raw 'raw_%03d.fits' --exposure "600 s" --number 8
///   barnard observe my.toml -o seen.png --preset hst-wfc3-uvis
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Observe {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output file of the master: .fits (with errors and mask), .exr, .npy, .png, .tif or .jpg; repeatable
    #[arg(short, long, value_name = "OUT")]
    output: Vec<PathBuf>,
    /// Output files of the frames, as raw_%03d.fits or raw_###.fits
    #[arg(long, value_name = "PATTERN")]
    raw: Option<PathBuf>,
    /// Instrument instead of the scene's (see `barnard list instruments`)
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Override the exposure of a frame, such as "300 s"
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    exposure: Option<Time>,
    /// Override the number of frames
    #[arg(long, value_name = "N")]
    number: Option<usize>,
    /// Override the seed of the noise
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Back end
    #[arg(long, value_name = "NAME", default_value = "cpu", value_parser = names(false))]
    backend: String,
    /// Print files and report as JSON on standard output, other lines on standard error
    #[arg(long)]
    json: bool,
}

impl Observe {
    pub fn run(self) -> anyhow::Result<ExitCode> {
        if self.output.is_empty() && self.raw.is_none() {
            bail!("an output is required; add -o master.fits, or --raw 'raw_%03d.fits'");
        }
        outputs::take_stdout(self.json);
        self.output.iter().try_for_each(|path| check_writable(path))?;
        if let Some(pattern) = &self.raw {
            check_replaceable(&frame_file(pattern, 1)?)?;
        }
        let (scene, options) = self.scene.load_for(&self.backend)?;
        let instrument = Arc::new(self.instrument(&scene)?);
        instrument.check()?;
        // Layers say what a picture is made of, and that is not what is recorded.
        let control = progress::control()?;
        let scene = scene.with_layers(LayerChoice::default());
        let scene = scene.edited_within(options.memory_limit, &control, |spec| spec.instrument = Some(instrument.clone()))?;
        let raw: Vec<PathBuf> = match &self.raw {
            Some(pattern) => (1..=instrument.frames).map(|number| frame_file(pattern, number as i64)).collect::<anyhow::Result<_>>()?,
            None => Vec::new(),
        };
        if let Some(both) = self.output.iter().find(|path| raw.contains(path)) {
            bail!("{}: the master is also a frame of --raw; rename it", both.display());
        }
        crate::verbs::refuse_inputs(&scene, &[&self.output[..], &raw].concat())?;
        Exposures::check(&instrument, &scene.camera, scene.observation, &scene.bands)?;
        let start = Instant::now();
        let mut backend = (registry().by_name(&self.backend)?.open)(&scene)?;
        let (image, _) = Renderer::new(&mut *backend).render(Job::new(&scene, &options)?, &control)?;
        let rendered = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let exposures = Exposures::new(instrument, &image, &scene.bands, &control)?;
        for (number, path) in raw.iter().enumerate() {
            control.check()?;
            save_frame(path, &exposures.frame(number))?;
            say!("wrote {}", path.display());
        }
        let master = exposures.master(&control)?;
        let [width, height] = exposures.size();
        say!(
            "{width} x {height} px, {} frames of {} s with {}, render {rendered:.2} s, exposures {:.2} s",
            exposures.instrument().frames,
            short(exposures.instrument().exposure_s),
            exposures.instrument().name,
            start.elapsed().as_secs_f64()
        );
        tell(&exposures, &master);
        for path in &self.output {
            master.save(path, &scene.save_options().without_glare())?;
            say!("wrote {}", path.display());
        }
        if self.json {
            let files: Vec<String> = raw.iter().chain(&self.output).map(|path| path.display().to_string()).collect();
            json::print(&json_of_image(&master, &files, rendered + start.elapsed().as_secs_f64()));
        }
        Ok(ExitCode::SUCCESS)
    }

    /// The scene's instrument with what the command line changes of it.
    fn instrument(&self, scene: &Scene) -> anyhow::Result<Instrument> {
        let mut instrument = match (&self.preset, &scene.instrument) {
            (Some(name), _) => preset(name).context("--preset")?,
            (None, Some(stated)) => Instrument::clone(stated),
            (None, None) => bail!(
                "the scene has no instrument; add [instrument] with preset = \"hst-wfc3-uvis\", or --preset (see `barnard list instruments`)"
            ),
        };
        if let Some(exposure) = self.exposure {
            instrument.exposure_s = exposure.0;
        }
        if let Some(number) = self.number {
            if !(1..=MAX_FRAMES).contains(&number) {
                bail!("--number {number} is out of range; give a number of frames from 1 to {MAX_FRAMES}");
            }
            instrument.frames = number;
        }
        instrument.seed = self.seed.unwrap_or(instrument.seed);
        Ok(instrument)
    }
}

/// The file of a frame.
fn frame_file(pattern: &Path, number: i64) -> anyhow::Result<PathBuf> {
    let is_fits = pattern.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("fits"));
    match numbered(pattern, number).filter(|_| is_fits) {
        Some(file) => Ok(file),
        None => bail!("--raw {}: frames are FITS files with a number in the name, such as raw_%03d.fits", pattern.display()),
    }
}

/// Recorded data of each band.
fn tell(exposures: &Exposures, master: &Image) {
    let pixels = master.width * master.height;
    let mask = &master.layers[0].samples;
    for (number, band) in master.radiances().enumerate() {
        let mut rates: Vec<f64> = (0..pixels).map(|pixel| exposures.source(number, pixel)).collect();
        let median = *rates.select_nth_unstable_by(pixels / 2, f64::total_cmp).1;
        let flagged = |flag: Flag| (0..pixels).filter(|i| mask.at(number * pixels + i) as u8 & flag as u8 != 0).count();
        say!(
            "{}: {} e/s of the picture (median) and {} e/s of the sky per pixel; {} pixels saturated, {} with frames rejected, {} bad",
            master.bands[band].name,
            short(rounded(median)),
            short(rounded(exposures.sky(number, (master.height / 2) * master.width + master.width / 2))),
            flagged(Flag::Saturated),
            flagged(Flag::Rejected),
            flagged(Flag::Bad)
        );
    }
}

/// Three digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
