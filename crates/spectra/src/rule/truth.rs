//! Wavelengths for the `reference`: panels of the passband, each with the Gauss rule of the response over λ, halved
//! until every integral stands still.
//!
//! Nothing here knows of k as a variable, of nodes that sources share or of depths that a scene reaches. On a panel the
//! weight of the rule is R dλ alone: a measured curve is dozens to hundreds of straight lines, over which spectra and
//! extinction are smooth, and a rule that had to see each of its corners would cost the reference a wavelength for
//! every one. What a panel must come to is the plain sum over all pieces between corners.

use crate::passband::Passband;
use crate::quadrature::gauss_of_measure;

/// Gauss points of a panel.
const ORDER: usize = 6;
/// The part of the allowed error that one panel may have: there are a dozen or two.
const PANEL_SHARE: f64 = 0.05;

/// Points λ \[µm\] and weights R dλ \[µm\] that integrate R(λ) f(λ) for every f of `integrand` to `accuracy` of its own
/// magnitude.
///
/// `integrand` gives the values of all f at a wavelength; `breaks_um` are the places where they are not smooth.
pub fn truth_points(band: &Passband, breaks_um: &[f64], integrand: impl Fn(f64) -> Vec<f64>, accuracy: f64) -> Vec<(f64, f64)> {
    let fine: Vec<(f64, f64)> =
        band.samples(breaks_um).iter().map(|(l, w)| (*l, w * band.response(*l))).filter(|(_, w)| *w > 0.0).collect();
    let values: Vec<Vec<f64>> = fine.iter().map(|(l, _)| integrand(*l)).collect();
    let count = values.first().map_or(0, Vec::len);
    let sum = |range: std::ops::Range<usize>| {
        let mut sum = vec![0.0; count];
        for i in range {
            values[i].iter().zip(&mut sum).for_each(|(v, s)| *s += fine[i].1 * v);
        }
        sum
    };
    // Every integral is judged by its own magnitude, deep ones included.
    let total = sum(0..fine.len());
    let mut points = Vec::new();
    let mut pending = Vec::from([(0, fine.len())]);
    while let Some((start, end)) = pending.pop() {
        let panel = start..end;
        if panel.len() <= ORDER {
            points.extend_from_slice(&fine[panel]);
            continue;
        }
        let (lambda, mass): (Vec<f64>, Vec<f64>) = fine[panel.clone()].iter().copied().unzip();
        let rule = gauss_of_measure(&lambda, &mass, ORDER);
        let mut found = vec![0.0; count];
        for (l, w) in &rule {
            integrand(*l).iter().zip(&mut found).for_each(|(v, s)| *s += w * v);
        }
        let truth = sum(panel.clone());
        let wrong = |((found, truth), total): ((&f64, &f64), &f64)| (found - truth).abs() > PANEL_SHARE * accuracy * total.abs();
        if found.iter().zip(&truth).zip(&total).any(wrong) {
            let middle = (start + end) / 2;
            pending.extend([(start, middle), (middle, end)]);
        } else {
            points.extend(rule);
        }
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}
