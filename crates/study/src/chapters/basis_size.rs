//! Error of a basis as a function of its size.

use barnard::control::Control;
use spectra::basis::{Basis, Criterion, Domain, MAX_SIZE, best_linear_error};

use crate::page::{short, table};
use crate::{Axis, Chapter, Figure, Findings, Result, Series};

pub(super) const CHAPTER: Chapter = Chapter {
    name: "basis_size",
    title: "2. Error against basis size",
    question: "How much does each exponential of the basis gain, for several wavelength domains D, in the norm of the error and its square? How close is the best linear basis?",
    run,
};

const DOMAINS: [(&str, (f64, f64)); 4] =
    [("[0, 1 µm]", (0.0, 1.0)), ("[0.4, 0.7 µm]", (0.4, 0.7)), ("[0.3, 1 µm]", (0.3, 1.0)), ("[1, 10 µm]", (1.0, 10.0))];
/// The largest argument, an optical depth at V.
const RANGE: f64 = 20.0;
/// A gain below this is the end of the fall, where rounding is all that is left.
const STALLED: f64 = 1.05;
/// The part by which a claim may be missed and still hold roughly.
const ROUGHLY: f64 = 0.1;

fn run(control: &Control) -> Result<Findings> {
    let (mut norm, mut best, mut rows, mut gains) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (name, ends) in DOMAINS {
        control.check()?;
        let domain = Domain::new(ends, |l| 0.55 / l, |_| 1.0)?;
        let bases: Vec<Basis> = (1..=MAX_SIZE).map_while(|n| Basis::optimal(&domain, RANGE, n, Criterion::Mean).ok()).collect();
        let points = |quantity: &dyn Fn(&Basis) -> f64| bases.iter().map(|b| (b.size() as f64, quantity(b))).collect::<Vec<(f64, f64)>>();
        norm.push(Series { name: name.into(), points: points(&Basis::mean_error) });
        best.push(Series { name: format!("{name}, exponentials"), points: points(&Basis::rms_error) });
        best.push(Series { name: format!("{name}, best linear"), points: points(&|b| best_linear_error(&domain, RANGE, b.size())) });
        let errors: Vec<f64> = bases.iter().map(Basis::mean_error).collect();
        let ratios: Vec<f64> = errors.windows(2).map(|pair| pair[0] / pair[1]).filter(|r| *r > STALLED).collect();
        let (low, high) = ratios.iter().take(5).fold((f64::MAX, 0.0f64), |(l, h), r| (l.min(*r), h.max(*r)));
        gains.push((low, high));
        let row = [
            name.to_owned(),
            errors.get(2).map_or("-".into(), |e| short(*e)),
            errors.get(4).map_or("-".into(), |e| short(*e)),
            format!("{low:.1} to {high:.1}"),
            format!("{:.0} to {:.0}", low * low, high * high),
            bases.get(4).map_or("-".into(), |b| short(b.condition())),
            bases.get(4).map_or("-".into(), |b| short(b.rms_error() / best_linear_error(&domain, RANGE, 5))),
        ];
        rows.push(row.to_vec());
    }
    let head = [
        "D",
        "mean error, 3",
        "mean error, 5",
        "÷ an element (norm)",
        "÷ an element (square)",
        "condition of 5 raw exponentials",
        "5 against the best linear",
    ];
    let text = format!(
        "Mean over 0 ≤ a ≤ {RANGE} of ‖e^(−a k) − projection‖/‖1‖, k = 0.55 µm/λ, exponents by Nelder–Mead on Barrès & Neyret's criterion. The gain is that of the second to sixth element; gains below {STALLED}, where rounding ends the fall, are left out.\n\n{}\
         {} No basis of exponentials can beat the singular vectors; the last column says how near the optimised exponentials come. Raw exponentials lose as many digits \
         as their condition has: coordinates here are those of the orthonormal elements.\n",
        table(&head, &rows),
        verdict(&gains)
    );
    let axis = Axis::linear("elements");
    let figures = vec![
        Figure {
            name: "basis_size".into(),
            title: "Mean error against basis size".into(),
            x: axis.clone(),
            y: Axis::log("mean error, parts of the norm of 1"),
            series: norm,
        },
        Figure {
            name: "basis_best".into(),
            title: "Root mean square error: optimal exponentials and the best linear basis (SVD)".into(),
            x: axis,
            y: Axis::log("rms error, parts of the norm of 1"),
            series: best,
        },
    ];
    Ok(Findings { figures, text, ..Findings::default() })
}

/// Barrès & Neyret's gains of an element on its own domain and in the visible, beside what was found.
fn verdict(gains: &[(f64, f64)]) -> String {
    let claim = |what: &str, (low, high): (f64, f64), talk: (f64, f64)| {
        let within = |room: f64| low >= (1.0 - room) * talk.0 && high <= (1.0 + room) * talk.1;
        let holds = match () {
            () if within(0.0) => "holds".to_owned(),
            () if within(ROUGHLY) => format!("holds within {:.0} %", 100.0 * ROUGHLY),
            () if low <= talk.1 && high >= talk.0 => "holds in part".to_owned(),
            () => "does not hold".to_owned(),
        };
        format!("Barrès & Neyret's ÷ {} to ÷ {} an element {what} {holds}: {low:.1} to {high:.1}.", talk.0, talk.1)
    };
    let square = (gains[0].0.powi(2), gains[0].1.powi(2));
    [
        claim("in the visible", gains[1], (8.0, 13.0)),
        claim("on D = [0, 1 µm], in the norm,", gains[0], (2.0, 3.0)),
        claim("there in its square", square, (7.0, 10.0)),
    ]
    .join(" ")
}
