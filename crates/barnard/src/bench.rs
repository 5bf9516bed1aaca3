//! The table of `barnard bench`: every method on one scene in one run, time beside error.

use std::time::Instant;

use crate::backend::{cpu, reference};
use crate::control::Control;
use crate::error::Result;
use crate::plan::{Options, Plan, sample_functions};
use crate::scene::{Method, Scene};

/// One method's row.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The method.
    pub name: String,
    /// Exponentials a sample and star.
    pub terms: usize,
    /// Median time of a frame [s].
    pub seconds: f64,
    /// Median processor time of a frame, all threads [s]; NaN where the system does not tell.
    pub cpu_seconds: f64,
    /// Relative rms error of the worst band against the reference.
    pub error: Option<f64>,
}

/// Times each method on `scene`, `visit` hearing each row as it comes; errors on an image of `error_size` pixels an edge, none if that is zero.
pub fn table(
    mut scene: Scene,
    options: &Options,
    frames: usize,
    error_size: usize,
    control: &Control,
    mut visit: impl FnMut(Row),
) -> Result<()> {
    // Errors are those of transport: functions are sampled first, the same for all.
    sample_functions(&mut scene, options)?;
    let size = (scene.camera.width, scene.camera.height);
    let truth = if error_size > 0 {
        (scene.camera.width, scene.camera.height) = (error_size, error_size);
        Some(reference::render(&scene, reference::DEFAULT_ACCURACY, control)?)
    } else {
        None
    };
    for contestant in contestants(&options.method)? {
        let options = Options { method: contestant.method, ..options.clone() };
        (scene.camera.width, scene.camera.height) = (error_size.max(1), error_size.max(1));
        let small = Plan { star_march: contestant.star_march, ..Plan::new(&scene, &options, control)? };
        let error = match &truth {
            Some(truth) => {
                let image = cpu::render(&scene, &small, control)?.0;
                Some((0..truth.bands.len()).map(|b| image.relative_rmse(b, truth, b)).fold(0.0, f64::max))
            }
            None => None,
        };
        (scene.camera.width, scene.camera.height) = size;
        let plan = Plan { camera: scene.camera.clone(), ..small };
        // The deck's double integration takes minutes a frame: one frame says enough.
        let frames = if contestant.star_march.is_some() { 0 } else { frames };
        let (seconds, cpu_seconds) = timed(frames, || cpu::radiance(&plan, control).map(drop))?;
        visit(Row { name: contestant.name, terms: plan.spectral.terms(), seconds, cpu_seconds, error });
    }
    Ok(())
}

/// One line of the table to be.
struct Contestant {
    name: String,
    method: Method,
    star_march: Option<usize>,
}

/// An accuracy at which the default's error is about that of the deck's double integration: speed at equal error.
const LOOSE: f64 = 5e-3;
/// Samples a ray of the deck.
const DECK_STEPS: usize = 100;

/// The plain RGB march first, then every rule by accuracy, the default with the deck's N, and the deck's double integration.
fn contestants(method: &Method) -> Result<Vec<Contestant>> {
    let mut list = Vec::new();
    for rule in spectra::rule::RULES.iter().rev() {
        list.push(Contestant { name: rule.name.to_owned(), method: method.clone().with_name(rule.name)?, star_march: None });
    }
    let loose = Method { accuracy: LOOSE, ..method.clone().with_name(spectra::rule::RULES[0].name)? };
    let half = Method { steps: Some(DECK_STEPS / 2), ..loose.clone() };
    list.push(Contestant { name: format!("{}, accuracy {LOOSE}", loose.name), method: loose, star_march: None });
    list.push(Contestant { name: format!("{}, {LOOSE}, N = {}", half.name, DECK_STEPS / 2), method: half, star_march: None });
    let fixed = |name: &str| -> Result<Method> { Ok(Method { steps: Some(DECK_STEPS), ..method.clone().with_name(name)? }) };
    for rule in ["fixed_wavelength", "band_quadrature", "newton"] {
        list.push(Contestant { name: format!("{rule}, N = {DECK_STEPS}"), method: fixed(rule)?, star_march: None });
    }
    let name = format!("double integration, N = {DECK_STEPS}");
    list.push(Contestant { name, method: fixed("newton")?, star_march: Some(DECK_STEPS) });
    Ok(list)
}

/// Median seconds and processor seconds of `work`, after one warm-up; of the warm-up itself where `frames` is zero.
pub fn timed(frames: usize, mut work: impl FnMut() -> Result<()>) -> Result<(f64, f64)> {
    if frames > 0 {
        work()?;
    }
    let (mut wall, mut cpu) = (Vec::new(), Vec::new());
    for _ in 0..frames.max(1) {
        let (start, before) = (Instant::now(), processor_seconds());
        work()?;
        wall.push(start.elapsed().as_secs_f64());
        cpu.push(processor_seconds() - before);
    }
    let median = |mut v: Vec<f64>| {
        v.sort_by(f64::total_cmp);
        v[v.len() / 2]
    };
    Ok((median(wall), median(cpu)))
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
