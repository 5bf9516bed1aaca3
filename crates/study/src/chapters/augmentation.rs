//! Fit of one exponential by a growing basis, and behaviour beyond its range.

use barnard::control::Control;
use spectra::basis::{Basis, Criterion, Domain};

use crate::page::{short, table};
use crate::{Axis, Chapter, Figure, Findings, Result, Series};

pub(super) const CHAPTER: Chapter = Chapter {
    name: "augmentation",
    title: "3. Basis augmentation and range",
    question: "How does the projection of e^(−a k) converge with the size of the basis? What happens for larger arguments, and at longer wavelengths?",
    run,
};

/// A huge argument: e^(−a k) is 1e−96 at 1 µm.
const HUGE: f64 = 400.0;
/// The argument whose exponential is shown.
const SHOWN: f64 = 6.0;
const RANGES: [f64; 3] = [20.0, 60.0, 200.0];
/// Arguments at which bases of different ranges are compared.
const ARGUMENTS: i32 = 200;
const SIZES: [usize; 3] = [3, 5, 7];

fn basis(domain_um: (f64, f64), range: f64, size: usize) -> Result<(Domain, Basis)> {
    let domain = Domain::new(domain_um, |l| 0.55 / l, |_| 1.0)?;
    let basis = Basis::optimal(&domain, range, size, Criterion::Mean)?;
    Ok((domain, basis))
}

/// The curves e^(−a k) and its projections over λ.
fn curves(name: &str, title: String, ends: (f64, f64), a: f64, range: f64) -> Result<Figure> {
    let lambda = |i: usize| ends.0 + (ends.1 - ends.0) * (i as f64 + 0.5) / 120.0;
    let mut series =
        vec![Series { name: "e^(-a k)".into(), points: (0..120).map(|i| (lambda(i), (-a * 0.55 / lambda(i)).exp())).collect() }];
    for size in [1, 2, 3, 4] {
        let (_, basis) = basis(ends, range, size)?;
        let q = basis.coordinates(a);
        let value = |l: f64| basis.elements(0.55 / l).iter().zip(&q).map(|(e, q)| e * q).sum::<f64>();
        series.push(Series {
            name: format!("{size} element{}", if size == 1 { "" } else { "s" }),
            points: (0..120).map(|i| (lambda(i), value(lambda(i)))).collect(),
        });
    }
    Ok(Figure { name: name.into(), title, x: Axis::linear("wavelength [µm]"), y: Axis::linear("transmission"), series })
}

/// A basis of one size for one range, with its errors; unless stated as relative, they are relative to ‖1‖.
struct MeasuredBasis {
    range: f64,
    size: usize,
    basis: Basis,
    /// ‖1‖.
    norm: f64,
    /// The mean error over the shortest of the ranges.
    shortest: f64,
    /// The error at twice the range.
    beyond: f64,
    /// The relative errors at the end of the range, and at [`HUGE`].
    at_end: f64,
    far: f64,
}

/// Columns of the table.
const HEAD: [&str; 7] = [
    "range",
    "elements",
    "mean error in the range",
    "mean error up to 20",
    "error at twice the range",
    "relative error at its end",
    "relative error at a = 400",
];

impl MeasuredBasis {
    fn new(domain_um: (f64, f64), range: f64, size: usize) -> Result<Self> {
        let (domain, basis) = basis(domain_um, range, size)?;
        let norm = domain.exponential(0.0).norm();
        let relative = |a: f64| basis.error(a) / domain.exponential(a).norm();
        let mean = (0..ARGUMENTS).map(|i| basis.error(RANGES[0] * f64::from(i) / f64::from(ARGUMENTS))).sum::<f64>();
        let shortest = mean / f64::from(ARGUMENTS) / norm;
        let (beyond, at_end, far) = (basis.error(2.0 * range) / norm, relative(range), relative(HUGE));
        Ok(Self { range, size, norm, shortest, beyond, at_end, far, basis })
    }

    fn row(&self) -> Vec<String> {
        let errors = [self.basis.mean_error(), self.shortest, self.beyond, self.at_end, self.far].map(short);
        [format!("{}", self.range), format!("{}", self.size)].into_iter().chain(errors).collect()
    }

    /// The error over the argument.
    fn series(&self) -> Series {
        let point = |i: i32| 10f64.powf(-1.0 + 5.0 * f64::from(i) / 100.0);
        Series {
            name: format!("{} elements, range {}", self.size, self.range),
            points: (0..=100).map(|i| (point(i), self.basis.error(point(i)) / self.norm)).collect(),
        }
    }
}

fn run(control: &Control) -> Result<Findings> {
    let visible = (0.3, 1.0);
    let mut figures = vec![
        curves(
            "augmentation",
            format!("e^(-a k), a = {SHOWN}, and its projections on growing bases, D = [0.3, 1 µm]"),
            visible,
            SHOWN,
            20.0,
        )?,
        curves("augmentation_infrared", "The same for a = 30 on D = [1, 10 µm]".into(), (1.0, 10.0), 30.0, 100.0)?,
    ];
    let mut measured = Vec::new();
    for range in RANGES {
        control.check()?;
        measured.extend(SIZES.iter().filter_map(|size| MeasuredBasis::new(visible, range, *size).ok()));
    }
    let five: Vec<&MeasuredBasis> = measured.iter().filter(|m| m.size == 5).collect();
    let series = five.iter().map(|m| m.series()).collect();
    figures.push(Figure {
        name: "augmentation_range".into(),
        title: "Error over the argument for bases of three ranges, D = [0.3, 1 µm]".into(),
        x: Axis::log("a [optical depth at V]"),
        y: Axis::log("error, parts of the norm of 1"),
        series,
    });
    let rows: Vec<Vec<String>> = measured.iter().map(MeasuredBasis::row).collect();
    let beyond = measured.iter().map(|m| m.beyond).fold(0.0, f64::max);
    let at_end = |choose: fn(f64, f64) -> f64| measured.iter().map(|m| m.at_end).reduce(choose).unwrap_or(f64::NAN);
    let text = format!(
        "D = [0.3, 1 µm], k = 0.55 µm/λ; errors as parts of ‖1‖, relative ones as parts of ‖e^(−a k)‖ itself.\n\n{}\
         At twice its range a basis is wrong by at most {} of ‖1‖, since there is hardly light left; but at the range's own end {} to {} of the light that is left is wrong (one: nothing of it is \
         found). With five elements the mean error up to {} of the basis made for {} is {:.2} times that of the one made for {}. The renderer makes its basis for the depths that the scene reaches, or for `range`; what \
         lies beyond is held at the table's end and shows in the certificate.\n",
        table(&HEAD, &rows),
        short(beyond),
        short(at_end(f64::min)),
        short(at_end(f64::max)),
        RANGES[0],
        RANGES[2],
        five.last().zip(five.first()).map_or(f64::NAN, |(long, short)| long.shortest / short.shortest),
        RANGES[0]
    );
    Ok(Findings { figures, text, ..Findings::default() })
}
