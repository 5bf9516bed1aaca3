//! Stars without number: gathered light beside that of stars one by one, and of the path tracer.

use std::time::Instant;

use barnard::backend::path;
use barnard::control::Control;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planned, Planner};
use barnard::scene::Scene;

use crate::figure::white;
use crate::page::{short, table};
use crate::{Chapter, Findings, Picture, Result, backends};

pub(super) const CHAPTER: Chapter = Chapter {
    name: "stars",
    title: "2. Many stars",
    question: "How long do a thousand stars with a thousand spectra take, and how accurate is their light, aggregated in cells beyond the neighbourhood of each (eq. 24)? An fBm cloud of depth 3, sampled to 128³, albedo 0.7, \
               Henyey & Greenstein's phase function with g = 0.6, one bounce, Johnson V, 160 samples per ray; black bodies of 3000 to 30 000 K whose luminosities span three decades. The limit is 1.3 times the frame of one star.",
    run,
};

const COUNTS: [usize; 4] = [1, 10, 100, 1000];
/// So many stars are also marched individually.
const ONE_BY_ONE: usize = 100;
/// Pixels an edge of what is compared, paths of each, and pixels an edge of what is timed and shown.
const COMPARED: usize = 48;
const PATHS: u64 = 800;
const TIMED: usize = 768;
const SHOWN: usize = 192;
const ROUNDS: usize = 3;
const AMPLIFIED: f64 = 4.0;

/// Golden and silver parts of one: numbers that look like chance.
fn part(i: usize, step: f64) -> f64 {
    (step * (i + 1) as f64).fract()
}

fn scene(stars: usize, exact: Option<usize>) -> Result<Scene> {
    let star = |i: usize| {
        let [x, y, z] = [0.618_033_99, 0.414_213_56, 0.732_050_81].map(|step| 1.5 * part(i, step) - 0.75);
        let (temperature, power) = (3000.0 + 27_000.0 * part(i, 0.236_067_98), 3.0 * part(i, 0.302_775_64));
        format!(
            "[[star]]\nkind = \"blackbody\"\nvisible = false\nposition = \"{x:.5} {y:.5} {z:.5} pc\"\ntemperature = \"{temperature:.0} K\"\nluminosity = \"{:.3} Lsun\"\n",
            10f64.powf(power)
        )
    };
    let text = format!(
        "bands = [\"johnson-V\"]\n[camera]\nkind = \"perspective\"\nposition = \"0.6 0.4 6 pc\"\nfield_of_view = \"21 deg\"\nsize = [{COMPARED}, {COMPARED}]\n\
         [field.cloud]\nkind = \"fbm\"\nseed = 11\nradius = \"1 pc\"\nscale = \"0.8 pc\"\noctaves = 5\noffset = 0.2\n\
         [dust]\ndensity = \"cloud\"\nscale = \"3.21 /pc\"\nlaw = \"ccm89\"\nalbedo = 0.7\nphase = {{ kind = \"henyey_greenstein\", g = 0.6 }}\n{}\
         [method]\naccuracy = 0.01\ncount = 2\nsteps = 160\nbake = 128\n{}",
        (0..stars).map(star).collect::<String>(),
        exact.map_or(String::new(), |n| format!("exact_stars = {n}\n"))
    );
    let scene = barnard_files::parse("validation.toml", "stars", text, &barnard_files::builtin::loader(DEFAULT_LIMIT))?;
    // A ray that all but hits a star sees the dust of one voxel: paths must have the same.
    let options = Options::within(DEFAULT_LIMIT);
    Ok(barnard::plan::sample_functions(&scene, &options)?)
}

/// A plan, and what it took [s].
fn planned(scene: &Scene, control: &Control) -> Result<(Planned, f64)> {
    let options = Options::within(DEFAULT_LIMIT);
    let start = Instant::now();
    let plan = Planner::new(&options).plan(scene, None, control)?;
    Ok((plan, start.elapsed().as_secs_f64()))
}

fn of_size(plan: &Planned, edge: usize) -> Planned {
    plan.clone().with_size(edge, edge)
}

/// Seconds of a frame of each plan of scenes like `scene`, `edge` pixels an edge, the shortest of some in turn.
fn frames(plans: [&Planned; 2], edge: usize, control: &Control) -> Result<[f64; 2]> {
    let large = plans.map(|plan| of_size(plan, edge));
    let mut shortest = [f64::INFINITY; 2];
    for _ in 0..ROUNDS {
        for (plan, shortest) in large.iter().zip(&mut shortest) {
            let start = Instant::now();
            backends::light(plan, control)?;
            *shortest = shortest.min(start.elapsed().as_secs_f64());
        }
    }
    Ok(shortest)
}

/// Relative rms difference from a truth, what chance adds to it taken off, and what that is.
fn error(ours: &[f64], film: &path::Film) -> (f64, f64) {
    let sum = |value: &dyn Fn(usize) -> f64| (0..ours.len()).map(value).sum::<f64>();
    let estimate = |i: usize| (film.estimates[i].mean, film.estimates[i].error());
    let power = sum(&|i| estimate(i).0.powi(2));
    let (wrong, chance) = (sum(&|i| (ours[i] - estimate(i).0).powi(2)), sum(&|i| estimate(i).1.powi(2)));
    (((wrong - chance).max(0.0) / power).sqrt(), (chance / power).sqrt())
}

fn percent(v: f64) -> String {
    format!("{:.2} %", 100.0 * v)
}

/// A scene of a number of stars, its plan, and its frame time relative to that of one star.
struct StarRun {
    stars: usize,
    scene: Scene,
    plan: Planned,
    /// Seconds of the plan.
    planned: f64,
    /// The length of a frame, relative to one star.
    ratio: f64,
}

impl StarRun {
    fn new(stars: usize, one: &Planned, control: &Control) -> Result<Self> {
        control.check()?;
        let scene = scene(stars, None)?;
        let (plan, planned) = planned(&scene, control)?;
        let [alone, all] = frames([one, &plan], TIMED, control)?;
        Ok(Self { stars, scene, plan, planned, ratio: all / alone })
    }

    /// Cost of this run, and its error relative to the path tracer.
    fn against_paths(&self, control: &Control) -> Result<Vec<String>> {
        let options = path::Options::default().with_samples(PATHS);
        let tracer = backends::paths(&self.scene, options, control)?;
        let (wrong, chance) = error(&backends::values(&self.plan, control)?, &tracer.film);
        let gathered = self.plan.scattered_field().as_ref().and_then(|d| d.report.far_field);
        Ok(vec![
            self.stars.to_string(),
            self.plan.space().marched().len().to_string(),
            short(self.planned),
            format!("{:.2}", self.ratio),
            (self.plan.bytes() >> 20).to_string(),
            gathered.and_then(|g| g.error).map_or("none".into(), percent),
            percent(wrong),
            percent(chance),
        ])
    }

    /// Copy of the stars one by one, where there are some and not too many.
    fn one_by_one(&self, one: &Planned, control: &Control) -> Result<Option<OneByOne>> {
        if !(2..=ONE_BY_ONE).contains(&self.stars) {
            return Ok(None);
        }
        let (exact, planned) = planned(&scene(self.stars, Some(self.stars))?, control)?;
        let [alone, all] = frames([one, &exact], SHOWN, control)?;
        let shown = |plan: &Planned| backends::values(&of_size(plan, SHOWN), control);
        Ok(Some(OneByOne { gathered: shown(&self.plan)?, exact: shown(&exact)?, planned, ratio: all / alone }))
    }
}

/// Light of gathered stars and of the same stars one by one, with what the latter cost.
struct OneByOne {
    gathered: Vec<f64>,
    exact: Vec<f64>,
    planned: f64,
    ratio: f64,
}

impl OneByOne {
    fn in_words(&self) -> [String; 3] {
        let pairs = || self.gathered.iter().copied().zip(self.exact.iter().copied());
        [percent(barnard::image::relative_rms(pairs())), short(self.planned), format!("{:.2}", self.ratio)]
    }
}

const HEAD: [&str; 11] = [
    "stars",
    "marched individually",
    "plan [s]",
    "frame, relative to one star",
    "plan [MiB]",
    "stated error at places",
    "error against paths",
    "noise of those",
    "error against individual stars",
    "plan of those [s]",
    "frame of those, relative to one star",
];

fn run(control: &Control) -> Result<Findings> {
    let mut findings = Findings::default();
    let one = planned(&scene(1, None)?, control)?.0;
    let (mut rows, mut slowest) = (Vec::new(), 0.0f64);
    for stars in COUNTS {
        let run = StarRun::new(stars, &one, control)?;
        let mut row = run.against_paths(control)?;
        let exact = run.one_by_one(&one, control)?;
        row.extend(exact.as_ref().map_or_else(Default::default, OneByOne::in_words));
        if let Some(exact) = exact.filter(|_| stars == ONE_BY_ONE) {
            findings.pictures.push(montage(&exact));
        }
        slowest = slowest.max(run.ratio);
        rows.push(row);
    }
    findings.text += &table(&HEAD, &rows);
    findings.text += &format!(
        "Frames of {TIMED} × {TIMED} pixels on the processor, the shortest of {ROUNDS} of each kind in turn: with aggregated stars the longest takes {slowest:.2} times that of one star. Errors are relative rms over the pixels; what chance \
         adds to the difference from {PATHS} paths a pixel is taken off. Individual stars are the same plan with `exact_stars` as many as there are, which needs one volume each, in frames of {SHOWN} × {SHOWN}.\n"
    );
    Ok(findings)
}

/// Gathered stars, stars one by one, and the difference.
fn montage(OneByOne { gathered, exact, .. }: &OneByOne) -> Picture {
    let (width, height) = (3 * SHOWN, SHOWN);
    let white = white(exact.clone());
    let pixel = |at: usize| {
        let (x, y) = (at % width, at / width);
        let i = y * SHOWN + x % SHOWN;
        let light = match x / SHOWN {
            0 => gathered[i],
            1 => exact[i],
            _ => AMPLIFIED * (gathered[i] - exact[i]).abs(),
        };
        [(light / white).clamp(0.0, 1.0).powf(1.0 / 2.2); 3]
    };
    Picture {
        name: "stars_1".into(),
        title: format!("{ONE_BY_ONE} stars: aggregated, individual, |difference| × {AMPLIFIED}"),
        size: (width, height),
        pixels: (0..width * height).map(pixel).collect(),
    }
}
