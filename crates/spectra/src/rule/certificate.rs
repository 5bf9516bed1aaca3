//! The stated error of a rule: sup over 0 ≤ a ≤ a_max of |F̂(a) − F(a)|, eq. (4) of docs/method.md.
//!
//! Both functions are sums of exponentials in a, smooth on the scale 1/k: the error is sampled densely, close to zero
//! logarithmically, and every neighbourhood of a largest sample is searched again, finer, three times. The bound is
//! stated five percent larger than what was found. Arithmetic comes on top: [`Certificate::rounded`].

use super::Measure;
use crate::exponential::attenuated;

/// Largest errors over the reachable depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    /// |F̂ − F| / F(0) \[1\].
    pub absolute: f64,
    /// |F̂ − F| / F(a) \[1\].
    pub relative: f64,
    /// The largest optical depth for which it holds \[1\].
    pub depth: f64,
}

/// Relative errors that arithmetic makes where light is marched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rounding {
    /// The error of an optical depth, also by the precision that densities are kept in \[1\].
    pub depth: f64,
    /// The error of the light behind that depth \[1\].
    pub light: f64,
}

const SAMPLES: usize = 192;
const MARGIN: f64 = 1.05;

impl Certificate {
    /// The error of `approximation` against `measure` up to `depth`.
    pub fn measured(measure: &Measure, approximation: impl Fn(f64) -> f64, depth: f64) -> Self {
        Truth::new(measure, depth).certificate(approximation)
    }

    /// The error of `approximation`(a) against F(`before` + a), as parts of F(0) and F(`before` + a), for a up to
    /// `depth`.
    pub fn behind(measure: &Measure, approximation: impl Fn(f64) -> f64, before: f64, depth: f64) -> Self {
        let total = measure.total();
        if total == 0.0 {
            return Self { absolute: 0.0, relative: 0.0, depth };
        }
        let error = |a: f64| errors(approximation(a), measure.at(before + a), total);
        Self::with_margin(suprema(error, depth), depth)
    }

    fn with_margin([absolute, relative]: [f64; 2], depth: f64) -> Self {
        // Of sums in double precision; `rounded` adds that of a march in single precision.
        let floor = 1e-14;
        Self { absolute: MARGIN * absolute + floor, relative: MARGIN * relative + floor, depth }
    }

    /// Variant with what arithmetic adds where light is marched with `rounding`: a relative error of the depth changes
    /// F(a) by a |F′(a)|, one of the light by F(a), or by the `size` of the terms that add up to it, where they cancel.
    pub fn rounded(self, measure: &Measure, rounding: Rounding, size: impl Fn(f64) -> f64) -> Self {
        let measure = measure.condensed(self.depth);
        let total = measure.total();
        if total == 0.0 {
            return self;
        }
        let slopes: Vec<f64> = measure.k.iter().zip(&measure.mass).map(|(k, mass)| k * mass).collect();
        let error = |a: f64| {
            let (light, change) = (measure.at(a), a * attenuated(&measure.k, &slopes, a));
            let error = rounding.depth * change + rounding.light * size(a).max(light);
            [error / total, error / light.max(f64::MIN_POSITIVE)]
        };
        let [absolute, relative] = suprema(error, self.depth);
        Self { absolute: self.absolute + absolute, relative: self.relative + relative, depth: self.depth }
    }

    /// The larger of both errors.
    pub fn or_worse(self, other: Self) -> Self {
        Self {
            absolute: self.absolute.max(other.absolute),
            relative: self.relative.max(other.relative),
            depth: self.depth.min(other.depth),
        }
    }
}

/// F(a) over the reachable depths, sampled once for the certificates of several rules.
pub struct Truth {
    measure: Measure,
    depth: f64,
    points: Vec<f64>,
    values: Vec<f64>,
}

impl Truth {
    /// F of `measure` for depths up to `depth`.
    pub fn new(measure: &Measure, depth: f64) -> Self {
        let (measure, points) = (measure.condensed(depth), points(depth));
        let values = points.iter().map(|a| measure.at(*a)).collect();
        Self { measure, depth, points, values }
    }

    /// The error of `approximation`(a) against F(a).
    pub fn certificate(&self, approximation: impl Fn(f64) -> f64) -> Certificate {
        let Self { measure, depth, points, values } = self;
        let total = measure.total();
        if total == 0.0 {
            return Certificate { absolute: 0.0, relative: 0.0, depth: *depth };
        }
        let sampled = points.iter().zip(values).map(|(a, truth)| errors(approximation(*a), *truth, total)).collect::<Vec<_>>();
        let error = |a: f64| errors(approximation(a), measure.at(a), total);
        Certificate::with_margin(refined_both(error, points, &sampled), *depth)
    }
}

/// Errors relative to F(0) and to F(a).
fn errors(approximation: f64, truth: f64, total: f64) -> [f64; 2] {
    let difference = (approximation - truth).abs();
    [difference / total, difference / truth.max(f64::MIN_POSITIVE)]
}

/// Depths at which errors are sampled first.
fn points(depth: f64) -> Vec<f64> {
    let mut points: Vec<f64> = (0..=SAMPLES).map(|i| depth * i as f64 / SAMPLES as f64).collect();
    points.extend((0..=SAMPLES / 2).map(|i| depth * 10f64.powf(-5.0 * i as f64 / (SAMPLES / 2) as f64)));
    points.sort_by(f64::total_cmp);
    points
}

/// The suprema of two functions over [0, depth].
fn suprema(f: impl Fn(f64) -> [f64; 2], depth: f64) -> [f64; 2] {
    let points = points(depth);
    let values: Vec<[f64; 2]> = points.iter().map(|a| f(*a)).collect();
    refined_both(f, &points, &values)
}

/// The suprema of two functions, which have `values` at ascending `points`.
fn refined_both(f: impl Fn(f64) -> [f64; 2], points: &[f64], values: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|which| {
        let values: Vec<f64> = values.iter().map(|both| both[which]).collect();
        refined(|a| f(a)[which], points, &values)
    })
}

/// The supremum of f, which has `values` at ascending `points`: the neighbourhood of the largest is searched again twice.
fn refined(f: impl Fn(f64) -> f64, points: &[f64], values: &[f64]) -> f64 {
    let (mut points, mut values) = (points.to_vec(), values.to_vec());
    let mut best = 0.0;
    for again in (0..3).rev() {
        let i = (0..values.len()).max_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap_or(0);
        best = f64::max(best, values[i]);
        if again > 0 {
            let (low, high) = (points[i.saturating_sub(1)], points[(i + 1).min(points.len() - 1)]);
            points = (0..=16).map(|j| low + (high - low) * j as f64 / 16.0).collect();
            values = points.iter().map(|a| f(*a)).collect();
        }
    }
    best
}
