//! Spectra that leave a column of growing density.

use barnard::control::Control;
use spectra::basis::{Basis, Criterion, Domain};
use spectra::rule::Settings;
use spectra::sed::BlackBody;
use spectra::spectrum::Shape;
use spectra::units::Temperature;

use crate::page::{short, table};
use crate::rules::{Run, sized};
use crate::{Axis, Chapter, Figure, Findings, Result, Series};

pub(super) const CHAPTER: Chapter = Chapter {
    name: "density",
    title: "4. Growing density and dark cores",
    question: "How accurate is each method for the light behind a column of growing density, relative to the unattenuated and to the attenuated light?",
    run,
};

const METHODS: [(&str, Option<usize>); 7] = [
    ("midpoint", Some(30)),
    ("gauss_legendre", Some(8)),
    ("projection", Some(3)),
    ("projection", Some(5)),
    ("band_quadrature", Some(2)),
    ("band_quadrature", Some(4)),
    ("lookup", None),
];
const DEEPEST: f64 = 30.0;
const SHOWN: [f64; 3] = [1.0, 5.0, 20.0];

/// Spectra behind a column: the black body itself, and with its transmission projected.
fn spectra() -> Result<Figure> {
    let domain = Domain::new((0.3, 1.0), |l| 0.55 / l, |_| 1.0)?;
    let star = BlackBody(Temperature(10000.0));
    let lambda = |i: usize| 0.3 + 0.7 * (i as f64 + 0.5) / 160.0;
    let peak = (0..160).map(|i| star.at(lambda(i))).fold(0.0, f64::max);
    let bases = [3, 5].map(|n| Basis::optimal(&domain, DEEPEST, n, Criterion::Mean));
    let mut series = Vec::new();
    for a in SHOWN {
        let curve =
            |value: &dyn Fn(f64) -> f64| (0..160).map(|i| (lambda(i), star.at(lambda(i)) / peak * value(0.55 / lambda(i)))).collect();
        series.push(Series { name: format!("a = {a}"), points: curve(&|k| (-a * k).exp()) });
        for basis in bases.iter().flatten() {
            let q = basis.coordinates(a);
            let value = |k: f64| basis.elements(k).iter().zip(&q).map(|(e, q)| e * q).sum::<f64>();
            series.push(Series { name: format!("a = {a}, {} elements", basis.size()), points: curve(&value) });
        }
    }
    Ok(Figure {
        name: "density_spectra".into(),
        title: "A black body of 10 000 K behind columns of depth 1, 5, 20; lines are interrupted where a projection is negative".into(),
        x: Axis::linear("wavelength [µm]"),
        y: Axis::log("spectrum, parts of its peak without dust"),
        series,
    })
}

fn run(control: &Control) -> Result<Findings> {
    let run = Run::passband("johnson-V", &[10000.0])?;
    let measure = &run.sources[0].measure;
    let (mut absolute, mut relative, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for (name, count) in METHODS {
        control.check()?;
        let settings = count.map_or_else(Settings::default, sized);
        let rule = run.solve(name, &settings, DEEPEST)?;
        let error = |a: f64| (rule.evaluate(0, a) - measure.at(a)).abs();
        let label = count.map_or(name.to_owned(), |n| format!("{name} {n}"));
        let along: Vec<f64> = (0..=150).map(|i| DEEPEST * f64::from(i) / 150.0).collect();
        absolute.push(Series { name: label.clone(), points: along.iter().map(|a| (*a, error(*a) / measure.total())).collect() });
        relative.push(Series { name: label.clone(), points: along.iter().map(|a| (*a, error(*a) / measure.at(*a))).collect() });
        let negative = along.iter().filter(|a| rule.evaluate(0, **a) < 0.0).count();
        let worst = absolute.last().map_or(0.0, |s| s.points.iter().map(|p| p.1).fold(0.0, f64::max));
        let at = |a: f64| short(error(a) / measure.at(a));
        rows.push(vec![
            label,
            short(worst),
            at(1.0),
            at(5.0),
            at(10.0),
            at(20.0),
            at(30.0),
            format!("{:.0} %", 100.0 * negative as f64 / along.len() as f64),
        ]);
    }
    let left = SHOWN.map(|a| format!("{} at a = {a}", short(measure.at(a) / measure.total())));
    let text = format!(
        "A star of 10 000 K through Johnson V behind dust, rules made for depths up to {DEEPEST}. Of the light, what is left is {}.\n\n{}\
         The errors relative to what is left at depths 1 to 30 are the dark cores: a method that is right to 1e-3 of F(0) may be wrong by all of the light in them. The last column says at how \
         many of the depths the light came out negative; the nodes family cannot go below zero, projection can, and the renderer counts and reports it.\n",
        left.join(", "),
        table(&["method", "largest error, of F(0)", "of F(a): a = 1", "5", "10", "20", "30", "negative at"], &rows)
    );
    let x = Axis::linear("a [optical depth at V]");
    let figures = vec![
        spectra()?,
        Figure {
            name: "density_absolute".into(),
            title: "Error relative to the unattenuated light".into(),
            x: x.clone(),
            y: Axis::log("error / F(0)"),
            series: absolute,
        },
        Figure {
            name: "density_relative".into(),
            title: "Error relative to the attenuated light".into(),
            x,
            y: Axis::log("error / F(a)"),
            series: relative,
        },
    ];
    Ok(Findings { figures, text, ..Findings::default() })
}
