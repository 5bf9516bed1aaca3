//! How time grows.

use barnard::control::Control;

use super::scene::{Contender, Run};
use crate::page::{short, table};
use crate::{Axis, Chapter, Figure, Findings, Result, Series};

pub(super) const CHAPTER: Chapter = Chapter {
    name: "complexity",
    title: "8. Complexity",
    question: "Time of a frame against samples N, wavelengths M, elements C_B, degree and lights L, as a fitted power, compared with Barrès & Neyret's formulas.",
    run,
};

const EDGE: usize = 96;
const BAKE: usize = 64;

/// One quantity that grows, and what grows with it.
struct Growth {
    what: &'static str,
    /// Barrès & Neyret's formula, and the powers it gives.
    talk: Option<(&'static str, f64, f64)>,
    values: &'static [usize],
    contender: fn(usize) -> Contender,
    stars: fn(usize) -> usize,
}

const GROWTHS: &[Growth] = &[
    Growth {
        what: "double_integration over N",
        talk: Some(("N (M + N)", 1.0, 2.0)),
        values: &[25, 50, 100, 200],
        contender: |n| Contender { steps: n, ..Contender::new("double_integration", Some(30)) },
        stars: |_| 1,
    },
    Growth {
        what: "double_integration over M",
        talk: Some(("N (M + N)", 0.0, 1.0)),
        values: &[10, 20, 40, 80],
        contender: |m| Contender::new("double_integration", Some(m)),
        stars: |_| 1,
    },
    Growth {
        what: "midpoint over N",
        talk: Some(("N M", 1.0, 1.0)),
        values: &[50, 100, 200, 400],
        contender: |n| Contender { steps: n, ..Contender::new("midpoint", Some(30)) },
        stars: |_| 1,
    },
    Growth {
        what: "midpoint over M",
        talk: Some(("N M", 1.0, 1.0)),
        values: &[10, 20, 40, 80, 160],
        contender: |m| Contender::new("midpoint", Some(m)),
        stars: |_| 1,
    },
    Growth {
        what: "projection over N",
        talk: Some(("N C_B", 1.0, 1.0)),
        values: &[50, 100, 200, 400],
        contender: |n| Contender { steps: n, ..Contender::new("projection", Some(3)) },
        stars: |_| 1,
    },
    Growth {
        what: "projection over C_B",
        talk: Some(("N C_B", 1.0, 1.0)),
        values: &[1, 2, 3, 4, 5, 6, 8],
        contender: |c| Contender::new("projection", Some(c)),
        stars: |_| 1,
    },
    Growth {
        what: "analytic over degree + 1",
        talk: Some(("N (degree + 1)", 1.0, 1.0)),
        values: &[2, 3, 5, 7, 10],
        contender: |d| Contender { degree: d - 1, ..Contender::new("analytic", None) },
        stars: |_| 1,
    },
    Growth {
        what: "band_quadrature over nodes",
        talk: None,
        values: &[1, 2, 3, 4, 6, 8],
        contender: |n| Contender::new("band_quadrature", Some(n)),
        stars: |_| 1,
    },
    Growth {
        what: "band_quadrature over L",
        talk: None,
        values: &[1, 2, 4, 8, 16],
        contender: |_| Contender::new("band_quadrature", Some(2)),
        stars: |l| l,
    },
    Growth {
        what: "projection over L",
        talk: Some(("N C_B L", 1.0, 1.0)),
        values: &[1, 2, 4, 8, 16],
        contender: |_| Contender::new("projection", Some(4)),
        stars: |l| l,
    },
    Growth {
        what: "propagation over L",
        talk: Some(("independent", 0.0, 0.0)),
        values: &[1, 2, 4, 8, 16],
        contender: |_| Contender::new("propagation", Some(4)),
        stars: |l| l,
    },
    Growth {
        what: "propagation over C_B",
        talk: Some(("N C_B²", 2.0, 2.0)),
        values: &[2, 3, 4, 6, 8],
        contender: |c| Contender::new("propagation", Some(c)),
        stars: |_| 4,
    },
];

fn run(control: &Control) -> Result<Findings> {
    let (mut series, mut rows) = (Vec::new(), Vec::new());
    for growth in GROWTHS {
        let mut points = Vec::new();
        for value in growth.values {
            control.check()?;
            let run = Run::new((growth.stars)(*value), None, BAKE, EDGE)?;
            let plan = run.plan(&(growth.contender)(*value), control)?;
            points.push((*value as f64, run.seconds(&plan, control)?));
        }
        let listed: Vec<String> = points.iter().map(|(v, s)| format!("{v}: {}", short(*s))).collect();
        let power = power(&points);
        let (formula, beside) = growth.talk.map_or(("-".into(), "-".into()), |(formula, low, high)| {
            let expected = if low == high { format!("{low}") } else { format!("{low} to {high}") };
            let distance = if power < low { power - low } else { (power - high).max(0.0) };
            (format!("{formula}: {expected}"), format!("{distance:+.2}"))
        });
        rows.push(vec![growth.what.to_owned(), formula, format!("{power:.2}"), beside, listed.join(", ")]);
        series.push(Series { name: growth.what.into(), points });
    }
    let text = format!(
        "Barrès & Neyret's scene on {BAKE}³ voxels, {EDGE} × {EDGE} pixels; a power p means time ∝ quantity^p, by least squares in the logarithms; the next column is its distance from the formula. The constant time per sample (reading the volume) makes \
         powers smaller than those of the formulas, which count only spectral work. The closed form jumps where its polynomial cancels in f32 and \
         f64 takes over; a light field grows with the stars only until its polynomials span their spectra.\n\n{}",
        table(&["quantity", "Barrès & Neyret's formula: power", "fitted power", "outside by", "seconds a frame"], &rows)
    );
    let figure = Figure {
        name: "complexity".into(),
        title: "Time of a frame against what it depends on".into(),
        x: Axis::log("N, M, C_B, degree + 1, nodes or L"),
        y: Axis::log("frame [s]"),
        series,
    };
    Ok(Findings { figures: vec![figure], text, ..Findings::default() })
}

/// The slope of ln y over ln x.
pub(super) fn power(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs = || points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (mx, my) = logs().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (xy, xx) = logs().fold((0.0, 0.0), |(a, b), (x, y)| (a + (x - mx) * (y - my), b + (x - mx) * (x - mx)));
    xy / xx
}

#[cfg(test)]
mod tests {
    #[test]
    fn powers_are_found() {
        let points: Vec<(f64, f64)> = [1.0f64, 2.0, 5.0, 9.0].iter().map(|x| (*x, 3.0 * x.powf(1.5))).collect();
        assert!((super::power(&points) - 1.5).abs() < 1e-12);
    }
}
