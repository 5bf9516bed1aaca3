//! Curves through keyframes: values that change smoothly from moment to moment.
//!
//! Between two keys a value is the cubic with the keys' values and tangents m (Hermite), with h = t₁ − t₀ and u = (t − t₀)/h:
//!
//!   v(t) = (2u³ − 3u² + 1) v₀ + (u³ − 2u² + u) h m₀ + (3u² − 2u³) v₁ + (u³ − u²) h m₁
//!
//! | interpolation | tangents |
//! |---|---|
//! | `catmull_rom` | of the parabola through a key and both its neighbours; at the ends those that leave no curvature there |
//! | `bezier` | those of the parabola, flat at extremes and never so steep that a value goes beyond its keys (Fritsch & Carlson 1980, SIAM J. Numer. Anal. 17, 238) |
//! | `linear`, `step` | none |
//!
//! Before the first key and behind the last one values stay as they are there.

use crate::properties::Choices;

/// Interpolation between keyframes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Interpolation {
    /// Smoothly through all keys, beyond them where that is smoother.
    CatmullRom,
    /// Smoothly through all keys, never beyond them: as by handles of Bézier curves that are clamped.
    Bezier,
    /// In straight lines.
    Linear,
    /// Not at all: a value holds until the next key.
    Step,
}

/// All interpolations, with summaries.
pub const INTERPOLATIONS: [(&str, &str); 4] = [
    ("catmull_rom", "smooth through all keys, may exceed their values"),
    ("bezier", "smooth through all keys, never exceeds their values"),
    ("linear", "linear between keys"),
    ("step", "constant until the next key"),
];

impl Choices for Interpolation {
    const ROWS: &'static [(&'static str, Self)] = &[
        (INTERPOLATIONS[0].0, Self::CatmullRom),
        (INTERPOLATIONS[1].0, Self::Bezier),
        (INTERPOLATIONS[2].0, Self::Linear),
        (INTERPOLATIONS[3].0, Self::Step),
    ];
}

/// Vectors at ascending times, and what lies between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    times: Vec<f64>,
    /// Components of the vectors, key × component.
    values: Vec<f64>,
    /// Their changes with time, key × component; none where the curve has corners or jumps.
    tangents: Option<Vec<f64>>,
    dims: usize,
    interpolation: Interpolation,
}

impl Curve {
    /// The curve through the vectors `values`, key × component, at ascending `times` \[s\].
    pub fn new(times: Vec<f64>, values: Vec<f64>, interpolation: Interpolation) -> Self {
        let dims = values.len() / times.len().max(1);
        let component = |c: usize| (0..times.len()).map(|key| values[key * dims + c]).collect::<Vec<f64>>();
        let smooth = matches!(interpolation, Interpolation::CatmullRom | Interpolation::Bezier) && times.len() > 1;
        let tangents = smooth.then(|| {
            let of_component: Vec<Vec<f64>> = (0..dims).map(|c| tangents(&times, &component(c), interpolation)).collect();
            (0..times.len()).flat_map(|key| of_component.iter().map(move |m| m[key])).collect()
        });
        Self { times, values, tangents, dims, interpolation }
    }

    /// The times of its keys \[s\].
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The vector at a moment \[s\].
    pub fn at(&self, time: f64) -> Vec<f64> {
        let values_of = |key: usize| &self.values[key * self.dims..(key + 1) * self.dims];
        // The key before, where there is one.
        let after = self.times.partition_point(|t| *t <= time);
        let last = self.times.len() - 1;
        if after == 0 || after > last {
            return values_of(if after == 0 { 0 } else { last }).to_vec();
        }
        let (from, to) = (after - 1, after);
        let h = self.times[to] - self.times[from];
        let u = (time - self.times[from]) / h;
        let tangent = |key: usize, c: usize| self.tangents.as_ref().map_or(0.0, |m| h * m[key * self.dims + c]);
        let between = |c: usize| {
            let (a, b) = (values_of(from)[c], values_of(to)[c]);
            match self.interpolation {
                Interpolation::Step => a,
                Interpolation::Linear => a + u * (b - a),
                Interpolation::CatmullRom | Interpolation::Bezier => {
                    let (u2, u3) = (u * u, u * u * u);
                    let along = (u3 - 2.0 * u2 + u) * tangent(from, c) + (u3 - u2) * tangent(to, c);
                    a + (3.0 * u2 - 2.0 * u3) * (b - a) + along
                }
            }
        };
        (0..self.dims).map(between).collect()
    }
}

/// The changes of one component at its keys.
fn tangents(times: &[f64], values: &[f64], interpolation: Interpolation) -> Vec<f64> {
    let last = times.len() - 1;
    let gap = |i: usize| times[i + 1] - times[i];
    let slope = |i: usize| (values[i + 1] - values[i]) / gap(i);
    let inner = |i: usize| (slope(i - 1) * gap(i) + slope(i) * gap(i - 1)) / (gap(i - 1) + gap(i));
    let mut m = vec![0.0; times.len()];
    (1..last).for_each(|i| m[i] = inner(i));
    // No curvature at the ends.
    m[0] = if last > 1 { 1.5 * slope(0) - 0.5 * m[1] } else { slope(0) };
    m[last] = if last > 1 { 1.5 * slope(last - 1) - 0.5 * m[last - 1] } else { slope(0) };
    if interpolation == Interpolation::Bezier {
        for i in 0..=last {
            let beside = [i.checked_sub(1).map(slope), (i < last).then(|| slope(i))];
            let turns = matches!(beside, [Some(before), Some(after)] if before * after <= 0.0);
            // Three times a secant's slope is the steepest with which a cubic keeps between its ends.
            let steepest = beside.into_iter().flatten().fold(f64::INFINITY, |least, s| least.min(3.0 * s.abs()));
            m[i] = if turns { 0.0 } else { m[i].clamp(-steepest, steepest) };
        }
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMOOTH: [Interpolation; 2] = [Interpolation::CatmullRom, Interpolation::Bezier];

    /// Every interpolation meets its keys, holds beyond them, and a straight line stays one, at uneven times.
    #[test]
    fn keys_are_met() {
        let times = vec![0.0, 1.0, 1.5, 4.0];
        for (name, interpolation) in Interpolation::ROWS {
            let curve = Curve::new(times.clone(), vec![3.0, -1.0, 5.0, 2.0, 4.0, 2.5, 9.0, 0.0], *interpolation);
            assert_eq!(curve.at(1.0), [5.0, 2.0], "{name}");
            assert_eq!((curve.at(-7.0), curve.at(9.0)), (vec![3.0, -1.0], vec![9.0, 0.0]), "{name}");
            let line = Curve::new(times.clone(), times.iter().map(|t| 2.0 - 3.0 * t).collect(), *interpolation);
            let (constant, straight) = (line.at(3.0)[0] == line.at(1.5)[0], (line.at(3.0)[0] + 7.0).abs() < 1e-12);
            assert!(if *interpolation == Interpolation::Step { constant } else { straight }, "{name}");
        }
    }

    /// A parabola through keys is followed exactly by Catmull-Rom between inner keys, and by nothing straight.
    #[test]
    fn parabolas_are_followed() {
        let times = vec![0.0, 0.7, 2.0, 2.5, 4.0];
        let squares = |interpolation| Curve::new(times.clone(), times.iter().map(|t| t * t).collect(), interpolation).at(1.3)[0];
        assert!((squares(Interpolation::CatmullRom) - 1.69).abs() < 1e-12);
        assert!((squares(Interpolation::Linear) - 1.69).abs() > 0.1);
    }

    /// Smooth curves have no corner at a key; Bézier curves stay between their keys, where Catmull-Rom goes beyond.
    #[test]
    fn smooth_curves_have_no_corners() {
        let (times, values) = (vec![0.0, 1.0, 3.0, 3.5, 6.0], vec![0.0, 1.0, 1.0, 4.0, 0.0]);
        for interpolation in SMOOTH {
            let curve = Curve::new(times.clone(), values.clone(), interpolation);
            for key in [1.0, 3.0, 3.5] {
                let e = 1e-6;
                let (before, after) = (curve.at(key)[0] - curve.at(key - e)[0], curve.at(key + e)[0] - curve.at(key)[0]);
                assert!((before - after).abs() < 1e-10, "{interpolation:?} {key}");
            }
            let beyond = (0..=600).map(|i| curve.at(0.01 * f64::from(i))[0]).fold(0.0, |most: f64, v| most.max(v - 4.0).max(-v));
            assert_eq!(beyond <= 1e-12, interpolation == Interpolation::Bezier, "{interpolation:?} {beyond}");
        }
        let flat = Curve::new(times, values, Interpolation::Bezier);
        assert!((0..=20).all(|i| flat.at(1.0 + 0.1 * f64::from(i)) == [1.0]));
    }
}
