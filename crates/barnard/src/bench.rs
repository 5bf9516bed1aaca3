//! The table of `barnard bench`: every method on one scene in one run, time beside error; where light scatters more than once, the methods that know that, beside the path tracer.

use std::sync::Arc;
use std::time::Instant;

use spectra::rule::RULES;

use crate::backend::cpu::{self, Findings};
use crate::backend::{path, reference};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::image::{Image, worst};
use crate::plan::ordinates::Sweeper;
use crate::plan::{DECK_STEPS, Diffuse, Fineness, Options, Plan, Stepping, sample_functions};
use crate::scene::{Method, Scene};

/// What is timed: a back end that takes a plan and makes frames of it.
pub trait Frames {
    /// Takes a plan; false where this back end does not do its method.
    fn take(&mut self, plan: &Plan) -> Result<bool>;

    /// Band radiances of the plan that was taken last [W m⁻² sr⁻¹], and what was found.
    fn frame(&mut self, control: &Control) -> Result<(Vec<f32>, Findings)>;

    /// What sweeps light that is scattered more than once beside the processor.
    fn sweeper(&self) -> Option<Arc<dyn Sweeper>> {
        None
    }

    /// Other times that matter here, for the plan that was taken last: what is timed, median seconds, and those of the device.
    fn others(&mut self, _plan: &Plan, _frames: usize) -> Result<Vec<(String, f64, f64)>> {
        Ok(Vec::new())
    }

    /// Seconds that the device has worked so far, all threads of a processor together; NaN where it does not tell.
    fn device_seconds(&self) -> f64;
}

/// The processor's frames.
#[derive(Debug, Default)]
pub struct OnCpu(Option<Plan>);

impl Frames for OnCpu {
    fn take(&mut self, plan: &Plan) -> Result<bool> {
        self.0 = Some(plan.clone());
        Ok(true)
    }

    fn frame(&mut self, control: &Control) -> Result<(Vec<f32>, Findings)> {
        let plan = self.0.as_ref().ok_or_else(|| Error::Render("no plan was taken".into()))?;
        cpu::radiance(plan, control)
    }

    fn device_seconds(&self) -> f64 {
        processor_seconds()
    }
}

/// One method's row.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The method.
    pub name: String,
    /// Exponentials a sample and star.
    pub terms: usize,
    /// Median time of a frame [s].
    pub seconds: f64,
    /// Median time of the device for a frame, all threads of a processor together [s]; NaN where it does not tell.
    pub device_seconds: f64,
    /// Relative rms error of the worst band against the reference.
    pub error: Option<f64>,
}

/// Times each of `methods`, or all, that `backend` does on `scene`, `visit` hearing each row as it comes; errors on an image of `error_size` pixels an edge, none if that is zero.
pub fn table(
    backend: &mut dyn Frames,
    mut scene: Scene,
    options: &Options,
    (frames, error_size): (usize, usize),
    control: &Control,
    methods: Option<&[String]>,
    mut visit: impl FnMut(Row),
) -> Result<()> {
    // Errors are those of transport: functions are sampled first, the same for all.
    sample_functions(&mut scene, options)?;
    let full = scene.camera.clone();
    (scene.camera.width, scene.camera.height) = (error_size.max(1), error_size.max(1));
    let truth = (error_size > 0).then(|| Truth::new(&scene, options.method.bounces, control)).transpose()?;
    let plan_of = |method: Method| Plan::new(&scene, &Options { method, ..options.clone() }, control);
    // None where the back end does not do the method.
    let error_of = |backend: &mut dyn Frames, plan: &Plan| -> Result<Option<Option<f64>>> {
        if !backend.take(plan)? {
            return Ok(None);
        }
        let Some(truth) = &truth else { return Ok(Some(None)) };
        let (data, findings) = backend.frame(control)?;
        let image = cpu::finished(&scene, plan, data, findings, "")?;
        Ok(Some(Some(truth.error(&image))))
    };
    let time = |backend: &mut dyn Frames, name: String, plan: Plan, error: Option<f64>| -> Result<Row> {
        let plan = Plan { camera: full.clone(), ..plan };
        backend.take(&plan)?;
        let (seconds, device_seconds) = timed(frames, || {
            let before = backend.device_seconds();
            backend.frame(control)?;
            Ok(backend.device_seconds() - before)
        })?;
        Ok(Row { name, terms: plan.spectral.terms(), seconds, device_seconds, error })
    };
    let mut deck = None;
    let mut default = None;
    for (name, method) in contestants(&options.method)? {
        if methods.is_some_and(|asked| !asked.iter().any(|m| m == method.entry.name)) {
            continue;
        }
        // A closed form holds for one law, and many know one bounce: where they do not do it, their row is left out.
        let closed = method.entry.rule.name == "analytic";
        let plan = match plan_of(method) {
            Err(Error::Spectra(_)) if closed => continue,
            Err(Error::OneBounce(..)) => continue,
            plan => plan?,
        };
        let Some(error) = error_of(backend, &plan)? else { continue };
        deck = error.filter(|_| plan.star_march.is_some());
        if name == RULES[0].name {
            default = Some((Plan { camera: full.clone(), ..plan.clone() }, error));
        }
        visit(time(backend, name, plan, error)?);
    }
    if let Some((plan, error)) = &default {
        if let Some((seconds, error)) = truth.as_ref().zip(*error).and_then(|(truth, error)| Some((truth.seconds_to(error)?, error))) {
            let seconds = seconds * (full.width * full.height) as f64 / (error_size * error_size) as f64;
            visit(Row { name: "path, to the default's error".into(), terms: 0, seconds, device_seconds: f64::NAN, error: Some(error) });
        }
        let swept = plan.diffuse.is_some() && options.method.bounces > 1;
        for sweeper in [None].into_iter().chain(backend.sweeper().map(Some)).filter(|_| swept) {
            let mut on: Arc<str> = "".into();
            let options = Options { sweeper, ..options.clone() };
            let (seconds, device_seconds) = timed(frames.min(BAKES), || {
                let fineness = (&options, Fineness::FULL);
                let made = Diffuse::new(&scene, &plan.lights, &plan.spectral, &plan.space, fineness, None, control)?;
                on = made.map_or_else(|| "".into(), |made| made.found.swept_by);
                Ok(f64::NAN)
            })?;
            // The kind of device, or all words where it gave up.
            let on = if on.starts_with("cpu (") { &on[..] } else { on.split(':').next().unwrap_or_default() };
            visit(Row { name: format!("bake of many bounces, {on}"), terms: plan.spectral.terms(), seconds, device_seconds, error: None });
        }
        backend.take(plan)?;
        for (name, seconds, device_seconds) in backend.others(plan, frames)? {
            visit(Row { name, terms: 0, seconds, device_seconds, error: None });
        }
    }
    let Some(deck) = deck else { return Ok(()) };
    let loose = loose(&options.method)?;
    let mut plan = plan_of(loose.clone())?;
    let mut matched = None;
    for steps in MATCHING_STEPS {
        plan.stepping = Stepping::Fixed(steps);
        match error_of(backend, &plan)?.flatten() {
            Some(error) if error <= deck => matched = Some((steps, error)),
            _ => break,
        }
    }
    if let Some((steps, error)) = matched {
        plan.stepping = Stepping::Fixed(steps);
        visit(time(backend, format!("{}, {LOOSE}, N = {steps}", loose.entry.name), plan, Some(error))?);
    }
    Ok(())
}

/// What methods are held to.
struct Truth {
    image: Image,
    /// Relative rms of what chance has left in each band.
    noise: Vec<f64>,
    /// Seconds that paths took; none where there were no paths.
    paths: Option<f64>,
}

/// Paths of each pixel, where they are the truth.
const PATHS: u64 = 1024;

impl Truth {
    /// By the reference, or by paths where light may scatter more than once.
    fn new(scene: &Scene, bounces: usize, control: &Control) -> Result<Self> {
        let bands = scene.bands.len();
        if bounces == 1 {
            let image = reference::render(scene, reference::DEFAULT_ACCURACY, control)?;
            return Ok(Self { image, noise: vec![0.0; bands], paths: None });
        }
        let options = path::Options { bounces, samples: PATHS, ..path::Options::default() };
        let (mut film, start) = (path::Film::default(), Instant::now());
        path::trace(scene, &options, &mut film, control, &mut |_| ())?;
        let image = path::image(scene, &film, &options)?;
        let paths = Some(start.elapsed().as_secs_f64());
        let power = |band: usize| image.band(band).map(|v| v * v).sum::<f64>();
        let noise = (0..bands).map(|b| (power(bands + b) / power(b).max(f64::MIN_POSITIVE)).sqrt()).collect();
        Ok(Self { image, noise, paths })
    }

    /// Relative rms of the worst band, what chance adds taken off; not less than what can be told beside that, the square root of the deviation of its square over so many pixels.
    fn error(&self, image: &Image) -> f64 {
        let told = (2.0 / (self.image.width * self.image.height) as f64).sqrt();
        let of_band = |(b, noise): (usize, &f64)| {
            let chance = noise * noise;
            (image.relative_rmse(b, &self.image, b).powi(2) - chance).max(told * chance).sqrt()
        };
        worst(self.noise.iter().enumerate().map(of_band))
    }

    /// Seconds in which paths come to an error, for a picture of this size.
    fn seconds_to(&self, error: f64) -> Option<f64> {
        let noise = worst(self.noise.iter().copied());
        self.paths.filter(|_| error > 0.0).map(|seconds| seconds * (noise / error).powi(2))
    }
}

/// An accuracy at which the default's error is about that of the deck's double integration: speed at equal error.
const LOOSE: f64 = 5e-3;
/// Samples a ray that are tried, from many to few, for the error of the double integration.
const MATCHING_STEPS: [usize; 12] = [100, 80, 64, 50, 40, 32, 28, 24, 20, 16, 14, 12];

/// The default rule at [`LOOSE`].
fn loose(method: &Method) -> Result<Method> {
    Ok(Method { accuracy: LOOSE, ..method.clone().with_name(RULES[0].name)? })
}

/// The plain RGB march first, then every rule by accuracy, the default with the deck's N, and at last the deck's double integration.
fn contestants(method: &Method) -> Result<Vec<(String, Method)>> {
    let mut list = Vec::new();
    for rule in RULES.iter().rev() {
        list.push((rule.name.to_owned(), method.clone().with_name(rule.name)?));
    }
    let loose = loose(method)?;
    list.push((format!("{}, accuracy {LOOSE}", loose.entry.name), loose));
    for name in ["fixed_wavelength", "band_quadrature", "projection", "newton", "double_integration"] {
        let fixed = Method { steps: Some(DECK_STEPS), ..method.clone().with_name(name)? };
        list.push((format!("{name}, N = {DECK_STEPS}"), fixed));
    }
    Ok(list)
}

/// Most bakes of light that is scattered more than once.
const BAKES: usize = 3;
/// A first frame that takes longer says enough by itself [s].
const LONG: f64 = 5.0;

/// Median seconds of `work`, and of what it says of its device, after one warm-up; of the warm-up itself where that takes long.
pub fn timed(frames: usize, mut work: impl FnMut() -> Result<f64>) -> Result<(f64, f64)> {
    let mut once = || -> Result<(f64, f64)> {
        let start = Instant::now();
        let device = work()?;
        Ok((start.elapsed().as_secs_f64(), device))
    };
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
