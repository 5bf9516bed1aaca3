//! The referee: an unbiased path tracer in f64, for any number of bounces.
//!
//! It reads the scene's physics itself and shares none of the plan's approximations. Each pixel's paths are drawn from
//! generators of their own, by seed, pixel and number, so that pictures are the same on any number of threads. `tracer`
//! is the transport, `medium` the flights through dust by `majorant` bounds, `sampled_wavelengths` the wavelengths; the `film` keeps
//! means with their standard errors, a program may keep it for a later run. Visible stars and the star field are
//! points, drawn as `reference` draws them.

mod film;
mod majorant;
mod medium;
mod sampled_wavelengths;
mod tracer;

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

pub use film::{Estimate, Film};

use super::finish::drawn_exactly;
use super::{Backend, BackendEntry, DeviceUse, Input, Job, Radiance, RenderStats};
use crate::backend::seen_detail::SeenDetail;
use crate::control::{Control, Stage};
use crate::error::{Error, Result};
use crate::image::{Image, PathReport, Report, Samples};
use crate::light::lights;
use crate::memory;
use crate::random::Counter;
pub use crate::scene::PathOptions as Options;
use crate::scene::{REFERENCE_ACCURACY, Scene};
use tracer::Tracer;

/// The row of this back end in the catalogue.
pub const ENTRY: BackendEntry = BackendEntry {
    name: "path",
    summary: "f64, unbiased Monte Carlo path tracer: ground truth with any number of bounces and standard errors",
    planned: false,
    device: DeviceUse::Never,
    open: |scene| Ok(Box::new(PathTracer::new(scene.method.backends.path))),
};

/// The path tracer, and what its paths have brought so far.
#[derive(Debug, Clone, Default)]
pub struct PathTracer {
    /// Sampling options of the path tracer.
    pub options: Options,
    /// Sums of paths: of a run before, or none.
    pub film: Film,
    /// Light of the first paths of the film's scene, once it was rendered: another scene begins anew.
    first_paths: Option<Vec<f64>>,
}

impl PathTracer {
    /// A tracer whose film begins anew.
    pub fn new(options: Options) -> Self {
        Self { options, ..Self::default() }
    }
}

impl Backend for PathTracer {
    fn name(&self) -> String {
        ENTRY.name.into()
    }

    fn input(&self) -> Input {
        Input::Scene { accuracy: REFERENCE_ACCURACY }
    }

    fn unsupported(&self, job: &Job, _: &Control) -> Result<Option<String>> {
        Ok(check(job.scene()).err().map(|error| error.to_string()))
    }

    fn radiance(&mut self, job: &Job, control: &Control) -> Result<Radiance> {
        check_memory(job.scene(), job.options().memory_limit)?;
        let scene = job.scene();
        check(scene)?;
        let lights = lights(scene)?;
        let detail = SeenDetail::of(scene, job.options(), control)?;
        let tracer = Tracer::new(scene, &lights, detail.as_ref(), self.options.first..=scene.method.bounces, control)?;
        let first = first_by(&tracer, scene, &self.options);
        if self.first_paths.replace(first.clone()).is_some_and(|before| before != first) {
            self.film = Film::default();
        }
        trace_by(&tracer, scene, &self.options, &mut self.film, control, &mut |_| ())?;
        Ok(light(scene, &self.film, &self.options))
    }
}

/// Refuses what paths do not tell apart.
fn check(scene: &Scene) -> Result<()> {
    if !scene.output.layers.light {
        return Ok(());
    }
    let alternative = "use cpu, gpu or reference, or remove \"light\" from layers";
    Err(Error::unsupported("layers of light", "back end path", alternative))
}

/// The light that `film` holds, with its standard errors.
fn light(scene: &Scene, film: &Film, options: &Options) -> Radiance {
    let values = |value: fn(&Estimate) -> f64| Samples::Double(film.estimates.iter().map(value).collect());
    let error = |estimate: &Estimate| Some(estimate.error()).filter(|error| error.is_finite()).unwrap_or(0.0);
    let report = Report {
        method: Some("unbiased path tracer".into()),
        bounces: Some(scene.method.bounces),
        paths: Some(PathReport { per_pixel: film.samples, seed: options.seed, skipped: film.bad }),
        ..Report::default()
    };
    let stats = RenderStats::of_rays(film.samples * film.estimates.len() as u64);
    Radiance { errors: Some(values(error)), report, ..Radiance::new(values(|estimate| estimate.mean), stats) }
}

/// Refuses a picture whose sums, those of a pass beside them and the picture itself take more memory than allowed.
///
/// # Errors
/// If it does.
pub fn check_memory(scene: &Scene, limit: u64) -> Result<()> {
    let values = (scene.camera.width * scene.camera.height * scene.bands.len()) as u64;
    memory::check("the sums of paths", values.saturating_mul(96), limit)
}

/// Paths of each pixel that are finished together.
const PASS: u64 = 8;

/// Adds paths to `film` until the options are met; passes that are finished stay when `control` interrupts. `tell`
/// receives the film after each.
///
/// # Errors
/// If a density has no bound, and [`Interrupted`](crate::Error::Interrupted).
pub fn trace(scene: &Scene, options: &Options, film: &mut Film, control: &Control, tell: &mut dyn FnMut(&Film)) -> Result<()> {
    scene.check()?;
    let lights = lights(scene)?;
    let detail = SeenDetail::of(scene, &crate::plan::Options::default(), control)?;
    let tracer = Tracer::new(scene, &lights, detail.as_ref(), options.first..=scene.method.bounces, control)?;
    trace_by(&tracer, scene, options, film, control, tell)
}

fn trace_by(
    tracer: &Tracer,
    scene: &Scene,
    options: &Options,
    film: &mut Film,
    control: &Control,
    tell: &mut dyn FnMut(&Film),
) -> Result<()> {
    let (camera, bands) = (&scene.camera, scene.bands.len());
    let size = camera.width * camera.height;
    if film.estimates.len() != bands * size {
        *film = Film::new(bands * size);
    }
    while film.samples < options.samples && !is_met(film, bands, options) {
        let pass = (film.samples..options.samples.min(film.samples + PASS)).collect::<Vec<_>>();
        let (done, bad) = (AtomicU64::new(0), AtomicU64::new(0));
        let mut estimates = film.estimates.clone();
        // A pixel of all bands is one piece of work; bands stand apart in the film.
        let pixel = |i: usize| -> Result<Vec<Estimate>> {
            control.check()?;
            let mut estimates: Vec<Estimate> = (0..bands).map(|b| film.estimates[b * size + i]).collect();
            for s in &pass {
                follow(tracer, scene, options.seed, i, *s, |band, radiance| {
                    if radiance.is_finite() {
                        estimates[band].add(radiance);
                    } else {
                        bad.fetch_add(1, Ordering::Relaxed);
                    }
                });
            }
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            if count % camera.width as u64 == 0 {
                control.report(
                    Stage::Rays,
                    film.samples * size as u64 + count * pass.len() as u64,
                    options.samples.saturating_mul(size as u64),
                );
            }
            Ok(estimates)
        };
        let pixels: Vec<Vec<Estimate>> = (0..size).into_par_iter().map(pixel).collect::<Result<_>>()?;
        for (i, estimate) in pixels.into_iter().enumerate() {
            estimate.into_iter().enumerate().for_each(|(b, e)| estimates[b * size + i] = e);
        }
        *film = Film { estimates, samples: film.samples + pass.len() as u64, bad: film.bad + bad.into_inner() };
        tell(film);
    }
    Ok(())
}

/// Path number `number` of a pixel in every band: `brings` receives bands and radiances.
fn follow(tracer: &Tracer, scene: &Scene, seed: u64, pixel: usize, number: u64, mut brings: impl FnMut(usize, f64)) {
    let camera = &scene.camera;
    let mut random = Counter::nested(seed, pixel as u64, number);
    let supersampling = camera.supersampling;
    // By chance, so that no number of paths prefers a part of the pixel.
    let parts = supersampling * supersampling;
    let part = if parts > 1 { ((random.uniform() * parts as f64) as usize).min(parts - 1) } else { 0 };
    let place = |at: usize, part: usize| at as f64 + (part as f64 + 0.5) / supersampling as f64;
    let (column, row) = (place(pixel % camera.width, part % supersampling), place(pixel / camera.width, part / supersampling));
    if !camera.sees(column, row) {
        return;
    }
    let ray = camera.ray(column, row);
    for band in 0..scene.bands.len() {
        brings(band, tracer.radiance(ray, band, &mut random));
    }
}

/// Pixels whose first paths are compared.
const CHECKED: usize = 64;

/// Light of the first paths of some pixels, bands × pixels. These numbers are the same where scene, camera, bands,
/// bounces and seed are: a film that is kept for a later run is recognised by them.
///
/// # Errors
/// Errors of [`trace`].
pub fn first_paths(scene: &Scene, options: &Options) -> Result<Vec<f64>> {
    scene.check()?;
    let lights = lights(scene)?;
    let control = &Control::default();
    let detail = SeenDetail::of(scene, &crate::plan::Options::default(), control)?;
    let tracer = Tracer::new(scene, &lights, detail.as_ref(), options.first..=scene.method.bounces, control)?;
    Ok(first_by(&tracer, scene, options))
}

fn first_by(tracer: &Tracer, scene: &Scene, options: &Options) -> Vec<f64> {
    let size = scene.camera.width * scene.camera.height;
    let count = CHECKED.min(size);
    let mut first = vec![0.0; scene.bands.len() * count];
    for i in 0..count {
        // Places all over the picture.
        let pixel = (Counter::new(CHECKED as u64, i as u64).uniform() * size as f64) as usize;
        follow(tracer, scene, options.seed, pixel.min(size - 1), 0, |band, radiance| first[band * count + i] = radiance);
    }
    first
}

fn is_met(film: &Film, bands: usize, options: &Options) -> bool {
    options.target_error.is_some_and(|target| film.samples > 0 && (0..bands).all(|b| film.relative_error(b, bands) <= target))
}

/// The image that `film` holds, its bands followed by their standard errors, with stars as `reference` draws them.
///
/// # Errors
/// A star field with too many stars, and interruption by the user.
pub fn image(scene: &Scene, film: &Film, options: &Options, control: &Control) -> Result<Image> {
    drawn_exactly(scene, REFERENCE_ACCURACY, light(scene, film, options), ENTRY.name, control)
}
