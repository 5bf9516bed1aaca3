//! Error against time over real filters.

use barnard::control::Control;
use barnard::plan::Planned;

use super::complexity::power;
use super::scene::{Contender, Run as Frame, error};
use crate::page::{short, table};
use crate::rules::{Run, sized};
use crate::{Axis, Chapter, Figure, Findings, Result, Series};

pub(super) const CHAPTER: Chapter = Chapter {
    name: "filters",
    title: "7. Which method when: error against time on real filters",
    question: "For each method and size: the largest spectral error over six black bodies of 3000 to 40 000 K and all depths up to 0.1, 1, 10, 30, and the time of a frame.",
    run,
};

const FILTERS: [&str; 9] =
    ["johnson-B", "johnson-V", "cousins-R", "sdss2010-g", "sdss2010-r", "sdss2010-i", "hst-wfc3-f502n", "hst-wfc3-f656n", "hst-wfc3-f673n"];
const TEMPERATURES: [f64; 6] = [3000.0, 5000.0, 8000.0, 12000.0, 20000.0, 40000.0];
const DEPTHS: [f64; 4] = [0.1, 1.0, 10.0, 30.0];
/// Methods with the sizes that are tried.
const METHODS: [(&str, &[usize]); 6] = [
    ("band_quadrature", &[1, 2, 3, 4, 5, 6]),
    ("projection", &[1, 2, 3, 4, 5, 6]),
    ("gauss_legendre", &[2, 4, 8, 16, 32]),
    ("midpoint", &[4, 8, 15, 30, 60]),
    ("sampled", &[1, 4, 16]),
    ("preintegrated", &[4, 16, 64]),
];
/// The methods without a size.
const SINGLE: [&str; 2] = ["lookup", "analytic"];
/// Elements of the projections that the default is compared with.
const SIZES: [usize; 4] = [2, 3, 4, 5];
/// Filters and depths of which figures are drawn.
const SHOWN: ([&str; 3], [f64; 2]) = (["johnson-B", "sdss2010-g", "hst-wfc3-f656n"], [1.0, 30.0]);
/// The filter and depth of the summary, and the error that is wanted there.
const SUMMARY: (&str, f64) = ("johnson-B", 10.0);
const WANTED: f64 = 1e-3;
/// Frames of each method, and the factor between two frames that count as equally long.
const ROUNDS: usize = 9;
const EQUAL: f64 = 1.05;
const EDGE: usize = 160;
const BAKE: usize = 64;

/// A method of one size: seconds a frame through one filter.
struct Timed {
    name: &'static str,
    count: Option<usize>,
    seconds: f64,
}

fn contenders() -> Vec<(&'static str, Option<usize>)> {
    let counts_of = |(name, counts): &(&'static str, &'static [usize])| counts.iter().map(|n| (*name, Some(*n))).collect::<Vec<_>>();
    METHODS.iter().flat_map(counts_of).chain(SINGLE.map(|name| (name, None))).collect()
}

fn run(control: &Control) -> Result<Findings> {
    // The time of a march does not depend on the filter, but that of the closed form, which falls back to f64 where a
    // narrow filter makes it cancel.
    let frame = Frame::new(1, Some("johnson-V"), BAKE, EDGE)?;
    let mut plans = Vec::new();
    for (name, count) in contenders() {
        control.check()?;
        plans.push((Timed { name, count, seconds: f64::INFINITY }, frame.plan(&Contender::new(name, count), control)?));
    }
    // One frame of each in turn, so that a busy minute of the machine strikes all alike; the shortest counts.
    for _ in 0..ROUNDS {
        for (timed, plan) in &mut plans {
            timed.seconds = timed.seconds.min(frame.once(plan, control)?);
        }
    }
    let (times, plans): (Vec<Timed>, Vec<Planned>) = plans.into_iter().unzip();
    let noise = noise(&frame, &times, plans, control)?;
    let mut measured = Vec::new();
    for filter in FILTERS {
        control.check()?;
        let run = Run::passband(filter, &TEMPERATURES)?;
        measured.extend(DEPTHS.map(|depth| MeasuredFilter::new(&run, filter, depth, &times)));
    }
    let rows: Vec<Vec<String>> = measured.iter().map(MeasuredFilter::row).collect();
    let ratios: Vec<f64> = measured.iter().flat_map(|m| m.at_equal_time().into_iter().flatten()).collect();
    let same_size: Vec<f64> = measured.iter().flat_map(MeasuredFilter::at_equal_size).collect();
    let summary = measured.iter().filter(|m| (m.filter, m.depth) == SUMMARY).flat_map(MeasuredFilter::needed).collect::<Vec<_>>();
    let figures =
        measured.iter().filter(|m| SHOWN.0.contains(&m.filter) && SHOWN.1.contains(&m.depth)).map(MeasuredFilter::figure).collect();
    let (least, better) = (sorted(&ratios).first().copied().unwrap_or(f64::NAN), ratios.iter().filter(|r| **r >= 10.0).count());
    let time_rows: Vec<Vec<String>> =
        times.iter().map(|t| vec![t.name.to_owned(), t.count.map_or("-".into(), |n| n.to_string()), short(t.seconds)]).collect();
    let text = format!(
        "Times are of Barrès & Neyret's scene, one star, one filter, {EDGE} × {EDGE} pixels, N = 100. Errors are the certificates of the rules, made for each filter and depth alone (projection's D is the filter's \
         own support, which favours it).\n\n{}### The default and projection at equal time\n\nError of projection with 2 to 5 elements over that of the best band quadrature that takes no longer (within {:.0} %; the shortest of {ROUNDS} frames each, in turn); 0 where none does, - where there is no such basis.\n\n{}\
         At least 10 times as exact as projection in {better} of {} comparisons; the least is {}. {} The frames of 1 to 4 nodes or elements differ by {:.0} % at most, which is noise on a shared machine as well; with as many nodes as elements, which is no timing, the least is {}, the median {}.\n\n{noise}### What 1e-3 costs\n\nOn {} up to depth {}: the smallest size tried whose error is at most {WANTED:.0e}, and its frame time relative to the default's.\n\n{}{}",
        table(&["method", "size", "frame [s]"], &time_rows),
        100.0 * (EQUAL - 1.0),
        table(&["filter", "depth up to", "2 elements", "3", "4", "5"], &rows),
        ratios.len(),
        short(least),
        if better == ratios.len() && better > 0 {
            "Ten times on every filter and depth holds."
        } else {
            "Ten times on every filter and depth does not hold: the rows above say where."
        },
        100.0 * (spread(&times) - 1.0),
        short(sorted(&same_size)[0]),
        short(sorted(&same_size)[same_size.len() / 2]),
        SUMMARY.0,
        SUMMARY.1,
        table(&["method", "size", "largest error / F(0)", "frame, relative to the default"], &summary),
        WHEN
    );
    Ok(Findings { figures, text, ..Findings::default() })
}

/// One filter up to one depth: what methods cost there, and how far off they are.
struct MeasuredFilter<'a> {
    filter: &'static str,
    depth: f64,
    times: &'a [Timed],
    /// The largest spectral error of each; none where the method has no rule for the filter.
    errors: Vec<Option<f64>>,
}

impl<'a> MeasuredFilter<'a> {
    fn new(run: &Run, filter: &'static str, depth: f64, times: &'a [Timed]) -> Self {
        let error = |t: &Timed| {
            let settings = t.count.map_or_else(Default::default, sized);
            run.solve(t.name, &settings, depth).map(|rule| rule.worst()).ok()
        };
        Self { filter, depth, times, errors: times.iter().map(error).collect() }
    }

    /// Time and error of each size of a method.
    fn points(&self, name: &str) -> Vec<(f64, f64)> {
        let points = self.times.iter().zip(&self.errors).filter(|(t, _)| t.name == name);
        points.filter_map(|(t, e)| e.map(|e| (t.seconds, e))).collect()
    }

    /// Time and error of one size.
    fn of_size(&self, name: &str, n: usize) -> Option<(f64, f64)> {
        let (timed, error) = self.times.iter().zip(&self.errors).find(|(t, _)| t.name == name && t.count == Some(n))?;
        error.map(|e| (timed.seconds, e))
    }

    /// The error of each projection over that of the best default that takes no longer; zero where there is no such
    /// default, none where there is no such projection.
    fn at_equal_time(&self) -> [Option<f64>; 4] {
        let ours = self.points("band_quadrature");
        let ratio = |(time, error): (f64, f64)| {
            let best = ours.iter().filter(|(t, _)| *t <= time * EQUAL).map(|p| p.1).fold(f64::INFINITY, f64::min);
            error / best
        };
        SIZES.map(|n| self.of_size("projection", n).map(ratio))
    }

    /// The error of each projection over that of the default of as many nodes as elements.
    fn at_equal_size(&self) -> Vec<f64> {
        let pair = |n: usize| Some(self.of_size("projection", n)?.1 / self.of_size("band_quadrature", n)?.1);
        SIZES.into_iter().filter_map(pair).collect()
    }

    fn row(&self) -> Vec<String> {
        let ratios = self.at_equal_time().map(|r| r.map_or("-".into(), short));
        [self.filter.to_owned(), format!("{}", self.depth)].into_iter().chain(ratios).collect()
    }

    fn figure(&self) -> Figure {
        let series = names().map(|name| Series { name: name.into(), points: self.points(name) }).filter(|s| !s.points.is_empty());
        Figure {
            name: format!("filters_{}_{}", self.filter, self.depth),
            title: format!("{}, depths up to {}: spectral error against time of a frame", self.filter, self.depth),
            x: Axis::log("frame [s]"),
            y: Axis::log("largest error / F(0)"),
            series: series.collect(),
        }
    }

    /// For each method, the size and time that it takes to keep [`WANTED`].
    fn needed(&self) -> Vec<Vec<String>> {
        let outcomes = |name: &'static str| self.times.iter().zip(&self.errors).filter(move |(t, _)| t.name == name);
        let good = |name: &'static str| outcomes(name).find(|(_, e)| e.is_some_and(|e| e <= WANTED));
        let default = good("band_quadrature").map_or(f64::NAN, |(t, _)| t.seconds);
        let row = |name: &'static str| match good(name) {
            Some((t, e)) => {
                let size = t.count.map_or("-".into(), |n| n.to_string());
                vec![name.to_owned(), size, e.map_or("-".into(), short), format!("{:.1}", t.seconds / default)]
            }
            None => {
                let best = outcomes(name).filter_map(|(_, e)| *e).fold(f64::NAN, f64::min);
                vec![name.to_owned(), "none tried".into(), short(best), "-".into()]
            }
        };
        names().map(row).collect()
    }
}

/// The names of all methods.
fn names() -> impl Iterator<Item = &'static str> {
    METHODS.iter().map(|m| m.0).chain(SINGLE)
}

/// The longest over the shortest frame of few nodes or elements.
fn spread(times: &[Timed]) -> f64 {
    let few = |t: &&Timed| ["band_quadrature", "projection"].contains(&t.name) && t.count.is_some_and(|n| n <= 4);
    let (low, high) = times.iter().filter(few).fold((f64::MAX, 0.0f64), |(low, high), t| (low.min(t.seconds), high.max(t.seconds)));
    high / low
}

/// The error of `sampled` in a picture: a relative rms, beside the same march with many nodes.
fn noise(frame: &Frame, times: &[Timed], plans: Vec<Planned>, control: &Control) -> Result<String> {
    let (mut samples, mut exact) = (Vec::new(), None);
    for (timed, plan) in times.iter().zip(plans) {
        match (timed.name, timed.count) {
            ("sampled", Some(count)) => samples.push((count, frame.image(plan, control)?)),
            ("band_quadrature", Some(_)) => exact = Some(plan),
            _ => {}
        }
    }
    let Some(exact) = exact else { return Ok(String::new()) };
    let exact = frame.image(exact, control)?;
    let rows = samples.iter().map(|(count, image)| vec![count.to_string(), short(error(image, &exact))]).collect::<Vec<_>>();
    let points: Vec<(f64, f64)> = samples.iter().map(|(count, image)| (*count as f64, error(image, &exact))).collect();
    Ok(format!(
        "### The noise of `sampled`\n\nIts certificate is a bound for every ray. In the picture through Johnson V its relative rms error, which is noise, is this; it falls with the power {:.2} of the wavelengths a \
         ray (independent draws: -0.5; stratified ones fall faster).\n\n{}",
        power(&points),
        table(&["wavelengths a ray", "relative rms"], &rows)
    ))
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// Our reading of the tables.
const WHEN: &str = "### Which to use\n\n\
    - `band_quadrature`: always, except for the following cases.\n\
    - `lookup`: one light per filter and isotropic scattering, at any accuracy for one table read.\n\
    - `projection`: for comparison with Barrès & Neyret.\n\
    - `propagation`: very many stars whose neighbourhoods do not matter.\n\
    - `sampled`: when bias is worse than noise.\n\
    - `midpoint`, `gauss_legendre`, `preintegrated`, `analytic`: for comparison.\n";
