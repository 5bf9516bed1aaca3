//! How fast each method's integral converges.

use barnard::control::Control;
use spectra::quadrature::{gauss_legendre, integrate};

use crate::page::{short, table};
use crate::rules::{Run, sized};
use crate::{Axis, Chapter, Figure, Findings, Result, Series};

pub(super) const CHAPTER: Chapter = Chapter {
    name: "convergence",
    title: "1. Convergence on one integral",
    question: "Barrès & Neyret's example f(x) = ((x−1)(x−.2)(x−.5)(x−.7)·x·100 + 1)·e^(−.1/x) over [0, 1]: how many evaluations, elements or nodes for which error?",
    run,
};

fn polynomial(x: f64) -> f64 {
    (x - 1.0) * (x - 0.2) * (x - 0.5) * (x - 0.7) * x * 100.0 + 1.0
}

/// The depth at which e^(−a k) with k = .55/x is e^(−.1/x).
const DEPTH: f64 = 0.1 / 0.55;
/// The largest argument that projection and band quadrature are made for.
const RANGE: f64 = 1.0;

fn f(x: f64) -> f64 {
    if x > 0.0 { polynomial(x) * (-0.1 / x).exp() } else { 0.0 }
}

fn midpoint(n: usize) -> f64 {
    (0..n).map(|i| f((i as f64 + 0.5) / n as f64)).sum::<f64>() / n as f64
}

/// `n` points, an odd number.
fn simpson(n: usize) -> f64 {
    let panels = n - 1;
    let weight = |i: usize| if i == 0 || i == panels { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
    (0..n).map(|i| weight(i) * f(i as f64 / panels as f64)).sum::<f64>() / (3 * panels) as f64
}

fn legendre(n: usize) -> f64 {
    gauss_legendre(n).iter().map(|(x, w)| 0.5 * w * f(0.5 + 0.5 * x)).sum()
}

fn run(control: &Control) -> Result<Findings> {
    let truth = integrate(f, 0.0, 1.0, 1e-14);
    let counts = [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24, 32, 48, 64, 96, 128];
    let error = |value: f64| (value / truth - 1.0).abs();
    let run = Run::interval((0.0, 1.0), polynomial, |x| 0.55 / x.max(1e-300));
    let mut series = vec![
        Series { name: "midpoint".into(), points: counts.map(|n| (n as f64, error(midpoint(n)))).to_vec() },
        Series {
            name: "Simpson".into(),
            points: counts.iter().filter(|n| **n > 2).map(|n| n | 1).map(|n| (n as f64, error(simpson(n)))).collect(),
        },
        Series { name: "Gauss-Legendre".into(), points: counts.map(|n| (n as f64, error(legendre(n)))).to_vec() },
    ];
    for name in ["projection", "band_quadrature"] {
        let mut points = Vec::new();
        for n in 1..=8 {
            control.check()?;
            // Elements that rounding can no longer tell apart end the growth.
            let Ok(rule) = run.solve(name, &sized(n), RANGE) else { break };
            points.push((n as f64, error(rule.evaluate(0, DEPTH))));
        }
        series.push(Series { name: name.into(), points });
    }
    let at = |s: &Series, n: f64| s.points.iter().find(|p| p.0 >= n).map_or(f64::NAN, |p| p.1);
    let rows: Vec<Vec<String>> = series
        .iter()
        .map(|s| std::iter::once(s.name.clone()).chain([3.0, 5.0, 8.0, 16.0, 32.0].map(|n| short(at(s, n)))).collect())
        .collect();
    let text = format!(
        "Relative error with 3, 5, 8, 16 and 32 evaluations (Simpson: the next odd number), against adaptive Gauss–Kronrod quadrature, {truth:.9}. Projection and band quadrature are made for \
         arguments up to a = {RANGE}, the example's own is a = {DEPTH:.3}; their integrals of the polynomial are exact.\n\n{}{}",
        table(&["method", "3", "5", "8", "16", "32"], &rows),
        verdict(at(&series[3], 5.0), at(&series[4], 5.0))
    );
    let figure = Figure {
        name: "convergence".into(),
        title: "Error of one spectral integral".into(),
        x: Axis::log("evaluations, elements or nodes"),
        y: Axis::log("relative error"),
        series,
    };
    Ok(Findings { figures: vec![figure], text, ..Findings::default() })
}

/// Says which of the two is ahead on an interval that touches zero, where k has no bound and no passband ever is.
fn verdict(projection: f64, band_quadrature: f64) -> String {
    let (ahead, behind, times) = match projection < band_quadrature {
        true => ("projection", "band quadrature", band_quadrature / projection),
        false => ("band quadrature", "projection", projection / band_quadrature),
    };
    format!(
        "With five, {ahead} is {times:.0} times as exact as {behind}: on an interval that touches λ = 0, k has no bound. Chapter 7 compares them on real passbands.\n"
    )
}
