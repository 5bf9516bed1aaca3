//! A field along a ray as cubic pieces.
//!
//! Between the crossings that a grid states its trilinear values are cubic along the ray: four values inside of a piece
//! give it exactly. A function is cut until the cubic through four values meets it at three more.

use std::sync::OnceLock;

use crate::field::Field;
use crate::geometry::Ray;

/// Places inside of a piece where the field is asked: Chebyshev points of [0, 1], never on a border.
fn nodes() -> &'static [f64; 4] {
    static NODES: OnceLock<[f64; 4]> = OnceLock::new();
    NODES.get_or_init(|| [7.0, 5.0, 3.0, 1.0].map(|i: f64| 0.5 * (1.0 + (std::f64::consts::PI * i / 8.0).cos())))
}

/// c₀ + c₁ u + c₂ u² + c₃ u³ on [start, end], u = (t − start)/(end − start).
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    /// Distance of its start [pc].
    pub start: f64,
    /// Distance of its end [pc].
    pub end: f64,
    c: [f64; 4],
    /// ∫ of the field before it.
    before: f64,
}

impl Piece {
    fn through(start: f64, end: f64, values: [f64; 4]) -> Self {
        // Newton's divided differences, then nested multiplication into powers of u.
        let u = nodes();
        let mut d = values;
        for level in 1..4 {
            for i in (level..4).rev() {
                d[i] = (d[i] - d[i - 1]) / (u[i] - u[i - level]);
            }
        }
        let mut c = [d[3], 0.0, 0.0, 0.0];
        for i in (0..3).rev() {
            for j in (1..4).rev() {
                c[j] = c[j - 1] - u[i] * c[j];
            }
            c[0] = d[i] - u[i] * c[0];
        }
        Self { start, end, c, before: 0.0 }
    }

    fn u(&self, t: f64) -> f64 {
        (t - self.start) / (self.end - self.start)
    }

    /// The field at distance `t`.
    pub fn at(&self, t: f64) -> f64 {
        let u = self.u(t);
        self.c.iter().rev().fold(0.0, |sum, c| sum * u + c)
    }

    /// ∫ of the field from the ray's start to `t`.
    pub fn column(&self, t: f64) -> f64 {
        let u = self.u(t);
        let primitive = self.c.iter().enumerate().rev().fold(0.0, |sum, (i, c)| sum * u + c / (i + 1) as f64);
        self.before + (self.end - self.start) * u * primitive
    }
}

/// A field along a whole ray.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    pieces: Vec<Piece>,
}

/// Maximum number of bisections of a piece.
const MAX_LEVEL: usize = 14;

/// The pieces of a field along a ray as they are found.
struct PieceFit<'a> {
    field: &'a dyn Field,
    ray: &'a Ray,
    /// The tolerance relative to the largest value; none where one polynomial is exact.
    accuracy: Option<f64>,
    /// The largest value so far.
    largest: f64,
    pieces: Vec<Piece>,
}

impl PieceFit<'_> {
    /// The pieces from `start` to `end`, halved until they are accurate.
    fn add(&mut self, start: f64, end: f64, level: usize) {
        let value = |u: f64| self.field.at(self.ray.at(start + u * (end - start)));
        let values = nodes().map(value);
        let largest = values.iter().fold(self.largest, |m, v| m.max(v.abs()));
        let piece = Piece::through(start, end, values);
        let wrong = |tolerance: f64| [0.18, 0.5, 0.82].iter().any(|u| (piece.at(start + u * (end - start)) - value(*u)).abs() > tolerance);
        let halve = self.accuracy.is_some_and(|accuracy| level < MAX_LEVEL && wrong(accuracy * largest));
        self.largest = largest;
        if halve {
            let middle = 0.5 * (start + end);
            self.add(start, middle, level + 1);
            self.add(middle, end, level + 1);
        } else {
            self.pieces.push(piece);
        }
    }
}

impl Profile {
    /// `field` along `ray` up to `far`, to `accuracy` of its largest value.
    pub fn new(field: &dyn Field, ray: &Ray, far: f64, accuracy: f64) -> Self {
        let Some((near, exit)) = field.bounds().clip(ray) else { return Self::default() };
        let far = far.min(exit);
        if far <= near {
            return Self::default();
        }
        let mut ends = vec![near, far];
        field.crossings(ray, &mut ends);
        ends.retain(|t| (near..=far).contains(t));
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|a, b| (*a - *b).abs() <= 1e-13 * b.abs().max(1.0));
        let exact = field.grid().is_some_and(|grid| grid.front().is_none());
        let mut fit = PieceFit { field, ray, accuracy: (!exact).then_some(accuracy), largest: 0.0, pieces: Vec::new() };
        for pair in ends.windows(2) {
            let parts = if exact { 1 } else { ((pair[1] - pair[0]) / field.feature_pc()).ceil().clamp(1.0, 1e5) as usize };
            let at = |i: usize| pair[0] + (pair[1] - pair[0]) * i as f64 / parts as f64;
            (0..parts).for_each(|i| fit.add(at(i), at(i + 1), 0));
        }
        let mut profile = Self { pieces: fit.pieces };
        let mut before = 0.0;
        for piece in &mut profile.pieces {
            piece.before = before;
            before = piece.column(piece.end);
        }
        profile
    }

    /// The pieces, in order.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// ∫ of the field along the whole ray.
    pub fn total(&self) -> f64 {
        self.pieces.last().map_or(0.0, |p| p.column(p.end))
    }

    /// The piece around `t`, if any.
    fn piece(&self, t: f64) -> Option<&Piece> {
        let i = self.pieces.partition_point(|p| p.end < t);
        self.pieces.get(i).filter(|p| p.start <= t)
    }

    /// The field at distance `t`.
    pub fn at(&self, t: f64) -> f64 {
        self.piece(t).map_or(0.0, |p| p.at(t))
    }

    /// ∫ of the field up to distance `t`.
    pub fn column(&self, t: f64) -> f64 {
        let i = self.pieces.partition_point(|p| p.end < t);
        match self.pieces.get(i) {
            Some(p) => p.column(t.max(p.start)),
            None => self.total(),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::{Grid, Lattice};
    use crate::geometry::Bounds;

    #[test]
    fn cubics_are_reproduced() {
        let f = |u: f64| 1.0 - 2.0 * u + 3.0 * u * u - 0.5 * u * u * u;
        let piece = Piece::through(2.0, 5.0, nodes().map(f));
        for u in [0.0, 0.3, 1.0] {
            assert!((piece.at(2.0 + 3.0 * u) - f(u)).abs() < 1e-13);
            let primitive = u - u * u + u.powi(3) - 0.125 * u.powi(4);
            assert!((piece.column(2.0 + 3.0 * u) - 3.0 * primitive).abs() < 1e-13);
        }
    }

    #[test]
    fn grids_are_exact() {
        let lattice = Lattice { dims: [9, 7, 8], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let grid = Grid::sampled(lattice, |p| (4.0 * p.x + p.y).sin().abs() + p.z * p.z);
        let ray = Ray { origin: DVec3::new(-2.0, 0.3, -1.1), direction: DVec3::new(1.0, -0.13, 0.55).normalize() };
        let profile = Profile::new(&grid, &ray, f64::INFINITY, 1e-6);
        for i in 0..400 {
            let t = 0.01 * i as f64;
            assert!((profile.at(t) - grid.at(ray.at(t))).abs() < 1e-9 || profile.piece(t).is_none(), "{t}");
        }
        let exact = grid.column(ray.origin, ray.at(10.0), f64::INFINITY);
        assert!((profile.total() - exact).abs() < 1e-11);
    }
}
