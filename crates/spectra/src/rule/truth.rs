//! Wavelengths for the `reference`: adaptive bisection of (G7, K15) panels in λ, until every F(a) stands still.
//!
//! Nothing here knows of k as a variable, of Gauss rules for weights or of shared nodes: it is plain integration over λ.

use crate::extinction::ExtinctionLaw;
use crate::passband::Passband;
use crate::quadrature::kronrod_points;
use crate::spectrum::Spectrum;

/// Optical depths at which the integrals must have converged, as fractions of the largest.
const DEPTHS: [f64; 6] = [0.0, 0.3, 1.0, 3.0, 10.0, 30.0];
const MAX_LEVEL: usize = 12;
const START_PANELS: usize = 12;
/// The part of the allowed error that one panel may have: there are some dozens.
const PANEL_SHARE: f64 = 0.05;

/// Points λ [µm] and weights dλ [µm] that integrate every continuum of `spectra` through `band` to `accuracy` of its total, at any depth.
pub fn truth_points(band: &Passband, spectra: &[&Spectrum], law: &dyn ExtinctionLaw, accuracy: f64) -> Vec<(f64, f64)> {
    let breaks: Vec<f64> = spectra.iter().flat_map(|s| s.breakpoints_um()).collect();
    let pieces = band.pieces(&breaks);
    let stride = pieces.len().div_ceil(START_PANELS).max(1);
    let mut ends: Vec<f64> = pieces.iter().copied().step_by(stride).collect();
    if ends.last() != pieces.last() {
        ends.extend(pieces.last());
    }
    let integrand = |lambda: f64| -> Vec<f64> {
        let (response, k) = (band.response(lambda), law.k(lambda));
        let depth = |s: &&Spectrum| {
            let w = response * s.continuum(lambda);
            DEPTHS.map(|a| w * (-a * k).exp())
        };
        spectra.iter().flat_map(depth).collect()
    };
    let panel = |a: f64, b: f64| {
        let count = spectra.len() * DEPTHS.len();
        kronrod_points(a, b).fold((vec![0.0; count], vec![0.0; count]), |(mut kronrod, mut gauss), (x, wk, wg)| {
            for (i, y) in integrand(x).iter().enumerate() {
                kronrod[i] += wk * y;
                gauss[i] += wg * y;
            }
            (kronrod, gauss)
        })
    };
    // Every integral is judged by its own magnitude, deep ones included.
    let mut scale = vec![f64::MIN_POSITIVE; spectra.len() * DEPTHS.len()];
    for p in ends.windows(2) {
        panel(p[0], p[1]).0.iter().zip(&mut scale).for_each(|(v, s)| *s += v);
    }
    let mut pending: Vec<(f64, f64, usize)> = ends.windows(2).map(|p| (p[0], p[1], 0)).collect();
    let mut points = Vec::new();
    while let Some((a, b, level)) = pending.pop() {
        let (kronrod, gauss) = panel(a, b);
        let error = kronrod.iter().zip(&gauss).zip(&scale).map(|((k, g), s)| (k - g).abs() / s).fold(0.0, f64::max);
        if error <= PANEL_SHARE * accuracy || level >= MAX_LEVEL {
            points.extend(kronrod_points(a, b).map(|(x, w, _)| (x, w)));
        } else {
            let middle = 0.5 * (a + b);
            pending.extend([(a, middle, level + 1), (middle, b, level + 1)]);
        }
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}
