//! Many bounces by the plan's field, beside those of the path tracer.

use std::time::Instant;

use barnard::backend::path;
use barnard::control::Control;
use barnard::image::ScatteringError;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planned, Planner};
use barnard::scene::{MANY_BOUNCES, Scene};

use crate::figure::white;
use crate::page::{short, table};
use crate::{Chapter, Findings, Picture, Result, backends};

pub(super) const CHAPTER: Chapter = Chapter {
    name: "bounces",
    title: "1. Multiple scattering",
    question: "How accurate is multiple scattering, solved once on cells and marched as volumes (eqs. 22 and 23), compared with the path tracer, and how long does it take? Albedo 0.8, Henyey & Greenstein's \
               phase function, Johnson V, depths through the middle of the cloud at V; limits are 5 % up to a depth of 3, 15 % up to 30, and twice the time per frame.",
    run,
};

/// A cloud: its name, its fields, its density, and the scale that makes its deepest ray one of depth 1 at V.
struct BounceCloud {
    name: &'static str,
    fields: &'static str,
    density: &'static str,
    scale: f64,
}

const CLOUDS: [BounceCloud; 3] = [
    BounceCloud { name: "sphere", fields: "[field.ball]\nkind = \"sphere\"\nradius = \"1 pc\"\n", density: "ball", scale: 0.5 },
    BounceCloud {
        name: "fBm cloud",
        fields: "[field.cloud]\nkind = \"fbm\"\nseed = 11\nradius = \"1 pc\"\nscale = \"0.8 pc\"\noctaves = 5\noffset = 0.2\n",
        density: "cloud",
        scale: 1.07,
    },
    BounceCloud {
        name: "turbulent cloud, simulated, 128³",
        fields: "[field.n_H]\nkind = \"grid\"\nfile = \"volumes/turbulent_cloud_128.npz\"\naxes = \"xyz\"\nfactor = 2\nlow = \"-1 -1 -1 pc\"\nhigh = \"1 1 1 pc\"\n\
                 [field.ball]\nkind = \"sphere\"\nradius = \"0.95 pc\"\n",
        density: "n_H * ball",
        scale: 0.000386,
    },
];

/// A depth, the star's place that goes with it, and the error that is asked.
struct BounceCase {
    depth: f64,
    star: &'static str,
    asked: f64,
}

/// The cases: in clouds of depth 30 a star is outside, since paths from the eye do not find one that is buried so deep.
const CASES: [BounceCase; 2] =
    [BounceCase { depth: 3.0, star: "0.25 0.15 0.35", asked: 0.05 }, BounceCase { depth: 30.0, star: "0.3 0.5 1.35", asked: 0.15 }];
/// Mean cosines of the phase function.
const MEAN_COSINES: [f64; 2] = [0.0, 0.7];
/// Pixels an edge of what is compared, and how many times larger they are shown; paths of each.
const COMPARED: usize = 48;
const SHOWN: usize = 5;
const PATHS: u64 = 1600;
/// Pixels an edge of frames that are timed, and how many of each kind.
const TIMED: usize = 192;
const ROUNDS: usize = 5;
/// The factor by which differences are shown brighter.
const AMPLIFIED: f64 = 4.0;

fn scene(cloud: &BounceCloud, case: &BounceCase, g: f64) -> Result<Scene> {
    let text = format!(
        "bands = [\"johnson-V\"]\n[camera]\nkind = \"perspective\"\nposition = \"0.6 0.4 6 pc\"\nfield_of_view = \"24 deg\"\nsize = [{COMPARED}, {COMPARED}]\n\
         {}[dust]\ndensity = \"{}\"\nscale = \"{} /pc\"\nlaw = \"ccm89\"\nalbedo = 0.8\nphase = {{ kind = \"henyey_greenstein\", g = {g} }}\n\
         [[star]]\nkind = \"blackbody\"\nposition = \"{} pc\"\ntemperature = \"15000 K\"\nluminosity = \"1000 Lsun\"\nvisible = false\n\
         [method]\naccuracy = 0.003\nbake = 96\nbounces = {MANY_BOUNCES}\n",
        cloud.fields,
        cloud.density,
        cloud.scale * case.depth,
        case.star
    );
    Ok(barnard_files::parse("validation.toml", cloud.name, text, &barnard_files::builtin::loader(DEFAULT_LIMIT))?)
}

/// The pictures and times of one scene.
struct BounceRun {
    once: Vec<f64>,
    many: Vec<f64>,
    /// Light that scattered at least twice, by paths, and its standard errors.
    paths: Vec<f64>,
    errors: Vec<f64>,
    /// Seconds of: paths, the plan with and without the field, a frame with and without.
    path_seconds: f64,
    planned: (f64, f64),
    frames: (f64, f64),
    plan: Planned,
}

impl BounceRun {
    fn new(scene: &Scene, control: &Control) -> Result<Self> {
        let start = Instant::now();
        let tracer = backends::paths(scene, path::Options::default().with_first(2).with_samples(PATHS), control)?;
        let path_seconds = start.elapsed().as_secs_f64();
        let (paths, errors) = tracer.film.estimates.iter().map(|e| (e.mean, e.error())).unzip();
        let planned = |bounces: usize| -> Result<(Planned, f64)> {
            let scene = scene.clone().with_method(barnard::scene::Method { bounces, ..scene.method.clone() });
            let start = Instant::now();
            Ok((Planner::new(&Options::default()).plan(&scene, None, control)?, start.elapsed().as_secs_f64()))
        };
        let ((once, once_planned), (plan, many_planned)) = (planned(1)?, planned(MANY_BOUNCES)?);
        let large = |plan: &Planned| plan.clone().with_size(TIMED, TIMED);
        let (large_once, large_many) = (large(&once), large(&plan));
        let mut frames = (f64::INFINITY, f64::INFINITY);
        for _ in 0..ROUNDS {
            for (plan, shortest) in [(&large_once, &mut frames.1), (&large_many, &mut frames.0)] {
                let start = Instant::now();
                backends::light(plan, control)?;
                *shortest = shortest.min(start.elapsed().as_secs_f64());
            }
        }
        Ok(Self {
            once: backends::values(&once, control)?,
            many: backends::values(&plan, control)?,
            paths,
            errors,
            path_seconds,
            planned: (many_planned, once_planned),
            frames,
            plan,
        })
    }

    /// The sum of a value over the pixels.
    fn sum(&self, value: impl Fn(usize) -> f64) -> f64 {
        (0..self.once.len()).map(value).sum()
    }

    fn truth(&self, i: usize) -> f64 {
        self.once[i] + self.paths[i]
    }

    /// The rms of the truth.
    fn power(&self) -> f64 {
        self.sum(|i| self.truth(i).powi(2)).sqrt()
    }

    /// Rms error, what chance adds to it taken off.
    fn wrong(&self) -> f64 {
        self.sum(|i| (self.many[i] - self.truth(i)).powi(2) - self.errors[i].powi(2)).max(0.0).sqrt()
    }

    /// Relative rms error of all light.
    fn error(&self) -> f64 {
        self.wrong() / self.power()
    }

    /// Relative rms error of light that has scattered more than once.
    fn error_of_many(&self) -> f64 {
        self.wrong() / self.sum(|i| self.paths[i].powi(2)).sqrt()
    }

    fn errors_in_words(&self, asked: f64) -> Vec<String> {
        let percent = |v: f64| format!("{:.1} %", 100.0 * v);
        let error_estimate = self.plan.scattered_field().as_ref().and_then(|d| d.report.error_estimate);
        let stated = |value: fn(&ScatteringError) -> f64| error_estimate.as_ref().map_or("unknown".into(), |d| percent(value(d)));
        vec![
            percent(self.share()),
            percent(self.error()),
            percent(self.noise()),
            percent(asked),
            if self.error() <= asked { "yes" } else { "no" }.into(),
            format!("{:.3}", self.total()),
            percent(self.error_of_many()),
            stated(|d| d.spatial),
            stated(|d| d.angular),
        ]
    }

    fn costs_in_words(&self) -> Vec<String> {
        let (by_paths, by_field) = self.equal_error();
        let field = self.plan.scattered_field().as_ref().map_or_else(String::new, |d| {
            let [x, y, z] = d.report.cells;
            format!("{x} × {y} × {z}, degree {}, {} orders, {} MiB", d.report.degree, d.report.sweeps, d.report.bytes >> 20)
        });
        let ratio = format!("{:.2}", self.frames.0 / self.frames.1);
        vec![field, short(self.planned.0), short(self.planned.1), ratio, short(by_paths), short(by_field)]
    }

    /// Relative rms of what chance has left in the truth.
    fn noise(&self) -> f64 {
        self.sum(|i| self.errors[i].powi(2)).sqrt() / self.power()
    }

    /// The part of light that has scattered more than once.
    fn share(&self) -> f64 {
        self.sum(|i| self.paths[i]) / self.sum(|i| self.truth(i))
    }

    /// Light of all pixels in that of the truth.
    fn total(&self) -> f64 {
        self.sum(|i| self.many[i]) / self.sum(|i| self.truth(i))
    }

    /// Seconds in which the path tracer would come to the same error, and the plan and a frame of as many pixels do.
    fn equal_error(&self) -> (f64, f64) {
        let frame = self.frames.0 * (COMPARED as f64 / TIMED as f64).powi(2);
        (self.path_seconds * (self.noise() / self.error()).powi(2), self.planned.0 + frame)
    }
}

fn run(control: &Control) -> Result<Findings> {
    let mut findings = Findings::default();
    let (mut errors, mut costs) = (Vec::new(), Vec::new());
    let (mut worst, mut slowest) = ([0.0f64; 2], 0.0f64);
    for cloud in &CLOUDS {
        for (case, worst) in CASES.iter().zip(&mut worst) {
            let mut rows = Vec::new();
            for g in MEAN_COSINES {
                control.check()?;
                let run = BounceRun::new(&scene(cloud, case, g)?, control)?;
                let (error, ratio) = (run.error(), run.frames.0 / run.frames.1);
                (*worst, slowest) = (worst.max(error), slowest.max(ratio));
                let name = [cloud.name.to_owned(), short(case.depth), short(g)];
                errors.push(name.iter().cloned().chain(run.errors_in_words(case.asked)).collect());
                costs.push(name.into_iter().chain(run.costs_in_words()).collect());
                rows.push(run);
            }
            let words = format!("{}, depth {}", cloud.name, short(case.depth));
            findings.pictures.push(montage(&format!("bounces_{}", findings.pictures.len() + 1), &words, &rows));
        }
    }
    let head = ["cloud", "depth", "g"];
    let with = |more: &[&'static str]| head.iter().chain(more).copied().collect::<Vec<_>>();
    let head = with(&[
        "multiply scattered light",
        "error",
        "noise of the truth",
        "limit",
        "met",
        "light of all pixels",
        "error multiply scattered light",
        "spatial, stated",
        "angular, stated",
    ]);
    findings.text += &table(&head, &errors);
    findings.text += &format!(
        "The worst error is {:.1} % up to a depth of 3, {:.1} % up to 30. Errors are relative rms over the pixels, of all light, corrected for noise. Single scattering is that of the \
         plan in both pictures; the path tracer adds multiple scattering. The last columns are the stated errors. In clouds of depth 30 the star is outside, because paths rarely reach an embedded one.\n\n",
        100.0 * worst[0],
        100.0 * worst[1]
    );
    let head = with(&[
        "field",
        "plan [s]",
        "plan of one bounce [s]",
        "frame, relative to one bounce",
        "paths to the same error [s]",
        "plan and frame [s]",
    ]);
    findings.text += &table(&head, &costs);
    findings.text += &format!(
        "Frames of {TIMED} × {TIMED} pixels on the processor, the shortest of {ROUNDS} of each kind in turn: the longest takes {slowest:.2} times that of one bounce. The time of paths is that of {PATHS} a pixel, \
         scaled by the square of its noise over the error, for {COMPARED} × {COMPARED} pixels and the light of two scatterings and more alone; a further frame costs paths as much again, the plan nothing.\n"
    );
    Ok(findings)
}

/// A montage with a row for each mean cosine: one bounce, many, those of the path tracer, and the difference.
fn montage(name: &str, words: &str, runs: &[BounceRun]) -> Picture {
    let (columns, rows) = (4 * COMPARED, runs.len() * COMPARED);
    let (width, height) = (columns * SHOWN, rows * SHOWN);
    let whites: Vec<f64> = runs.iter().map(|run| white((0..run.once.len()).map(|i| run.truth(i)).collect())).collect();
    let pixel = |at: usize| {
        let (x, y) = (at % width / SHOWN, at / width / SHOWN);
        let (run, panel) = (y / COMPARED, x / COMPARED);
        let (t, i) = (&runs[run], y % COMPARED * COMPARED + x % COMPARED);
        let light = match panel {
            0 => t.once[i],
            1 => t.many[i],
            2 => t.truth(i),
            _ => AMPLIFIED * (t.many[i] - t.truth(i)).abs(),
        };
        [(light / whites[run]).clamp(0.0, 1.0).powf(1.0 / 2.2); 3]
    };
    let cosines: Vec<String> = MEAN_COSINES.iter().map(|g| format!("g = {g}")).collect();
    Picture {
        name: name.to_owned(),
        title: format!("{words}, above to below {}: one bounce, many bounces, path tracer, |difference| × {AMPLIFIED}", cosines.join(", ")),
        size: (width, height),
        pixels: (0..width * height).map(pixel).collect(),
    }
}
