//! The table of `barnard bench`: every method on one scene in one run, time beside error; where light scatters more
//! than once, the methods that know that, beside the path tracer.

use std::sync::Arc;
use std::time::Instant;

use spectra::rule::RULES;

use barnard::backend::{Backend, Job, Renderer, path};
use barnard::control::Control;
use barnard::error::{Error, Result};
use barnard::image::{Image, worst};
use barnard::plan::{Options, Planned, Planner, Stepping, TALK_STEPS, sample_functions};
use barnard::scene::{Method, Scene};

use crate::backends;

/// One method's row of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodRow {
    /// The name of the method.
    pub name: String,
    /// Exponentials a sample and star.
    pub terms: usize,
    /// Median time of a frame \[s\].
    pub seconds: f64,
    /// Median time of the device for a frame, all threads of a processor together \[s\]; NaN where it does not tell.
    pub device_seconds: f64,
    /// Relative rms error of the worst band against the reference, or against paths where light may scatter more than once.
    pub error: Option<f64>,
}

/// A bench: the scene that is timed, and how.
#[derive(Debug, Clone)]
pub struct Bench<'a> {
    /// The number of frames of each method.
    pub frames: usize,
    /// Pixels along an edge of the image on which errors are measured; none are where it is zero.
    pub error_size: usize,
    /// The methods, by name; all where it is none.
    pub methods: Option<&'a [String]>,
    /// Resource limits of plans.
    pub options: &'a Options,
}

/// Times each method that `backend` does on `scene`; `visit` receives each row as it comes.
///
/// # Errors
/// If the scene cannot be planned or rendered, and on interruption by the user.
pub fn table(backend: &mut dyn Backend, scene: Scene, bench: &Bench, control: &Control, mut visit: impl FnMut(MethodRow)) -> Result<()> {
    // Errors are those of transport: functions are sampled first, the same for all.
    let scene = sample_functions(&scene, bench.options)?;
    let full = (scene.camera.width, scene.camera.height);
    let small = scene.camera.clone().with_size(bench.error_size.max(1), bench.error_size.max(1));
    let scene = scene.with_camera(small);
    let truth = (bench.error_size > 0).then(|| BenchTruth::new(&scene, control)).transpose()?;
    let mut run = MethodRun { backend, scene, bench, full, truth, control };
    let done = run.contest(&mut visit)?;
    if let Some((plan, error)) = &done.default {
        run.paths(*error).into_iter().for_each(&mut visit);
        run.bakes(plan, &mut visit)?;
        run.edits(plan, &mut visit)?;
    }
    match done.baseline {
        Some(baseline) => run.matched(baseline, &mut visit),
        None => Ok(()),
    }
}

/// The figures that a contest of all methods is compared with.
struct Contest {
    /// The default's plan, and its error where errors are measured.
    default: Option<(Planned, Option<f64>)>,
    /// The error of the double integration of the talk.
    baseline: Option<f64>,
}

/// One run that makes the table.
struct MethodRun<'a> {
    backend: &'a mut dyn Backend,
    /// The scene in the pixels on which errors are measured.
    scene: Scene,
    bench: &'a Bench<'a>,
    /// Pixels of the frames that are timed.
    full: (usize, usize),
    truth: Option<BenchTruth>,
    control: &'a Control,
}

impl MethodRun<'_> {
    fn plan(&self, method: Method) -> Result<Planned> {
        Planner::new(self.bench.options).plan(self.scene.clone().with_method(method), None, self.control)
    }

    /// The plan in the pixels of the frames that are timed.
    fn full(&self, plan: &Planned) -> Planned {
        plan.clone().with_size(self.full.0, self.full.1)
    }

    fn is_able(&self, plan: &Planned) -> Result<bool> {
        Ok(self.backend.unsupported(&Job::from(plan), self.control)?.is_none())
    }

    /// The error of a plan's picture, where errors are measured.
    fn error(&mut self, plan: &Planned) -> Result<Option<f64>> {
        let Some(truth) = &self.truth else { return Ok(None) };
        let (image, _) = Renderer::new(self.backend).render(plan, self.control)?;
        Ok(Some(truth.error(&image)))
    }

    fn time(&mut self, name: String, plan: &Planned, error: Option<f64>) -> Result<MethodRow> {
        let plan = self.full(plan);
        let job = Job::from(&plan);
        if let Some(device) = self.backend.device() {
            device.prepare(&job, self.control)?;
        }
        let (seconds, device_seconds) = medians(self.bench.frames, || {
            if let Some(device) = self.backend.device() {
                device.warm_up(WARM_UP, self.control)?;
            }
            clocked(|| {
                let before = processor_seconds();
                self.backend.radiance(&job, self.control)?;
                let device = self.backend.device().filter(|device| device.fallback().is_none());
                Ok(device.map_or_else(|| processor_seconds() - before, |device| device.seconds().unwrap_or(f64::NAN)))
            })
        })?;
        Ok(MethodRow { name, terms: plan.spectral().terms(), seconds, device_seconds, error })
    }

    /// Times every method in turn.
    fn contest(&mut self, visit: &mut impl FnMut(MethodRow)) -> Result<Contest> {
        let mut contest = Contest { default: None, baseline: None };
        for (name, method) in contestants(&self.scene.method)? {
            if self.bench.methods.is_some_and(|asked| !asked.iter().any(|m| m == method.entry.name)) {
                continue;
            }
            // A closed form holds for one law, and many know one bounce: where they do not do it, their row is left
            // out.
            let closed = method.entry.rule.name == "analytic";
            let plan = match self.plan(method) {
                Err(Error::Spectra(_)) if closed => continue,
                Err(Error::OneBounce(..)) => continue,
                plan => plan?,
            };
            if !self.is_able(&plan)? {
                continue;
            }
            let error = self.error(&plan)?;
            contest.baseline = error.filter(|_| plan.star_march().is_some());
            let row = self.time(name, &plan, error)?;
            if row.name == RULES[0].name {
                contest.default = Some((plan, error));
            }
            visit(row);
        }
        Ok(contest)
    }

    /// The row of what paths would take to reach the default's error.
    fn paths(&self, error: Option<f64>) -> Option<MethodRow> {
        let (error, measured) = (error?, (self.bench.error_size * self.bench.error_size) as f64);
        let seconds = self.truth.as_ref()?.seconds_to(error)? * (self.full.0 * self.full.1) as f64 / measured;
        Some(MethodRow { name: "path, to the default's error".into(), terms: 0, seconds, device_seconds: f64::NAN, error: Some(error) })
    }

    /// Light that is scattered more than once, by the processor and by what the back end has.
    fn bakes(&mut self, plan: &Planned, visit: &mut impl FnMut(MethodRow)) -> Result<()> {
        let swept = plan.scattered_field().is_some() && plan.bounces() > 1;
        for sweeper in [None].into_iter().chain(self.backend.sweeper().map(Some)).filter(|_| swept) {
            let mut on: Arc<str> = "".into();
            let options = self.bench.options.clone().with_sweeper(sweeper);
            let (seconds, device_seconds) = timed(self.bench.frames.min(BAKES), || {
                let made = plan.scattered_again(&options, self.control)?;
                on = made.map_or_else(|| "".into(), |made| made.report.swept_by);
                Ok(f64::NAN)
            })?;
            let name = format!("bake of many bounces, {on}");
            visit(MethodRow { name, terms: plan.spectral().terms(), seconds, device_seconds, error: None });
        }
        Ok(())
    }

    /// Times what an edit of a spectrum uploads, and the depths of a star that has moved, where a device keeps them.
    fn edits(&mut self, plan: &Planned, visit: &mut impl FnMut(MethodRow)) -> Result<()> {
        let plan = self.full(plan);
        let job = Job::from(&plan);
        let Some(device) = self.backend.device() else { return Ok(()) };
        device.prepare(&job, self.control)?;
        if device.fallback().is_some() {
            return Ok(());
        }
        let row = |name: &str, (seconds, device_seconds)| MethodRow { name: name.into(), terms: 0, seconds, device_seconds, error: None };
        visit(row("upload after a spectrum edit", timed(self.bench.frames, || device.prepare(&job, self.control).map(|()| f64::NAN))?));
        if let Some(number) = plan.space().marched().first() {
            let place = plan.space().stars[*number];
            let sweep = || {
                device.warm_up(WARM_UP, self.control)?;
                clocked(|| {
                    let is_moved = device.move_star(*number, place)?;
                    Ok(device.seconds().filter(|_| is_moved).unwrap_or(f64::NAN))
                })
            };
            visit(row("star depths of one star", medians(self.bench.frames, sweep)?));
        }
        Ok(())
    }

    /// The default at the error of the baseline.
    fn matched(&mut self, baseline: f64, visit: &mut impl FnMut(MethodRow)) -> Result<()> {
        let loose = loose(&self.scene.method)?;
        let name = loose.entry.name;
        let mut plan = self.plan(loose)?;
        let mut matched = None;
        for steps in MATCHING_STEPS {
            plan = plan.with_stepping(Stepping::Fixed(steps));
            match self.error(&plan)? {
                Some(error) if error <= baseline => matched = Some((steps, error)),
                _ => break,
            }
        }
        if let Some((steps, error)) = matched {
            let plan = plan.with_stepping(Stepping::Fixed(steps));
            visit(self.time(format!("{name}, {LOOSE}, N = {steps}"), &plan, Some(error))?);
        }
        Ok(())
    }
}

/// The picture that methods are held to.
struct BenchTruth {
    image: Image,
    /// Relative rms of what chance has left in each band.
    noise: Vec<f64>,
    /// Seconds that paths took; none where there were no paths.
    paths: Option<f64>,
}

/// Paths of each pixel, where they are the truth.
const PATHS: u64 = 1024;

impl BenchTruth {
    /// The truth by the reference, or by paths where light may scatter more than once.
    fn new(scene: &Scene, control: &Control) -> Result<Self> {
        let (bands, bounces) = (scene.bands.len(), scene.method.bounces);
        if bounces == 1 {
            let image = backends::reference(scene, control)?;
            return Ok(Self { image, noise: vec![0.0; bands], paths: None });
        }
        let start = Instant::now();
        let tracer = backends::paths(scene, path::Options::default().with_samples(PATHS), control)?;
        let image = path::image(scene, &tracer.film, &tracer.options, control)?;
        let paths = Some(start.elapsed().as_secs_f64());
        let power = |band: usize| image.band(band).map(|v| v * v).sum::<f64>();
        let noise = (0..bands).map(|b| (power(bands + b) / power(b).max(f64::MIN_POSITIVE)).sqrt()).collect();
        Ok(Self { image, noise, paths })
    }

    /// Relative rms of the worst band, what chance adds taken off; at least its resolution, the
    /// square root of the deviation of its square over a given number of pixels.
    fn error(&self, image: &Image) -> f64 {
        let expected = (2.0 / (self.image.width * self.image.height) as f64).sqrt();
        let of_band = |(b, noise): (usize, &f64)| {
            let chance = noise * noise;
            (image.relative_rmse(b, &self.image, b).powi(2) - chance).max(expected * chance).sqrt()
        };
        worst(self.noise.iter().enumerate().map(of_band))
    }

    /// Seconds in which paths come to an error, for a picture of this size.
    fn seconds_to(&self, error: f64) -> Option<f64> {
        let noise = worst(self.noise.iter().copied());
        self.paths.filter(|_| error > 0.0).map(|seconds| seconds * (noise / error).powi(2))
    }
}

/// An accuracy at which the default's error is about that of Barrès & Neyret's double integration: speed at equal
/// error.
const LOOSE: f64 = 5e-3;
/// Samples a ray that are tried, from many to few, for the error of the double integration.
const MATCHING_STEPS: [usize; 12] = [100, 80, 64, 50, 40, 32, 28, 24, 20, 16, 14, 12];

/// The default rule at [`LOOSE`].
fn loose(method: &Method) -> Result<Method> {
    Ok(Method { accuracy: LOOSE, ..method.clone().with_name(RULES[0].name)? })
}

/// The plain RGB march first, then every rule by accuracy, the default with the N of the talk, and at last its double
/// integration.
fn contestants(method: &Method) -> Result<Vec<(String, Method)>> {
    let mut list = Vec::new();
    for rule in RULES.iter().rev() {
        list.push((rule.name.to_owned(), method.clone().with_name(rule.name)?));
    }
    let loose = loose(method)?;
    list.push((format!("{}, accuracy {LOOSE}", loose.entry.name), loose));
    for name in ["fixed_wavelength", "band_quadrature", "projection", "midpoint", "double_integration"] {
        let fixed = Method { steps: Some(TALK_STEPS), ..method.clone().with_name(name)? };
        list.push((format!("{name}, N = {TALK_STEPS}"), fixed));
    }
    Ok(list)
}

/// Warm-up time of a device before each timed frame \[s\]: one that has idled begins with slow clocks.
const WARM_UP: f64 = 0.1;
/// Most bakes of light that is scattered more than once.
const BAKES: usize = 3;
/// A first frame that takes longer says enough by itself [s].
const LONG: f64 = 5.0;

/// Median seconds of `work`, and of what it says of its device, after one warm-up; of the warm-up itself where that
/// takes long.
///
/// # Errors
/// Errors of `work`.
pub fn timed(frames: usize, mut work: impl FnMut() -> Result<f64>) -> Result<(f64, f64)> {
    medians(frames, || clocked(&mut work))
}

/// The seconds of some work, and those of the device that it gives.
fn clocked(work: impl FnOnce() -> Result<f64>) -> Result<(f64, f64)> {
    let start = Instant::now();
    let device = work()?;
    Ok((start.elapsed().as_secs_f64(), device))
}

/// The medians of what is clocked, after once that does not count, or that once where it takes long.
fn medians(frames: usize, mut once: impl FnMut() -> Result<(f64, f64)>) -> Result<(f64, f64)> {
    let first = once()?;
    if first.0 > LONG || frames == 0 {
        return Ok(first);
    }
    let (wall, device): (Vec<f64>, Vec<f64>) = (0..frames).map(|_| once()).collect::<Result<Vec<_>>>()?.into_iter().unzip();
    let median = |mut v: Vec<f64>| {
        v.sort_by(f64::total_cmp);
        v[v.len() / 2]
    };
    Ok((median(wall), median(device)))
}

/// Processor time of this process so far [s]; on Linux from its statistics, NaN elsewhere.
fn processor_seconds() -> f64 {
    // Fields 14 and 15 behind the command's name: user and system time in ticks of 10 ms (Linux fixes USER_HZ at 100).
    let read = || -> Option<f64> {
        let text = std::fs::read_to_string("/proc/self/stat").ok()?;
        let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
        Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
    };
    read().unwrap_or(f64::NAN)
}
