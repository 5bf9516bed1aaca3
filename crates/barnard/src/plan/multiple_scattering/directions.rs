//! Directions of discrete ordinates: the six faces of a cube, each cut into cells of equal angles along both slopes (u,
//! v).
//!
//!   Ω(u, v) = atan(u v/√(1 + u² + v²))
//!
//! is the solid angle of a rectangle of slopes from the middle of a face. Directions stand in the middles of the cells,
//! all slopes scaled by one factor near one, so that ⟨d_x⁴⟩ = 1/5 as on a sphere. Odd moments vanish and ⟨d_i d_j⟩ =
//! δ_ij/3 as they do for all that has the symmetry of a cube; so harmonics up to degree two are orthonormal. All
//! directions of a face cross the planes of the grid along one axis: in a sweep, a plane depends on the one before
//! alone. Faces of many directions come in parts, so that what a sweep keeps of a plane stays near the processor.

use glam::DVec3;
use spectra::constants::SPHERE;

/// A face of the cube, or a part of it: directions whose largest component is along `axis`.
#[derive(Debug)]
pub struct Face {
    /// The axis that the face is across.
    pub axis: usize,
    /// True if light goes up along the axis.
    pub up: bool,
    /// The directions through the face.
    pub directions: Vec<Direction>,
}

/// One direction of light, with its solid angle.
#[derive(Debug, Clone, Copy)]
pub struct Direction {
    /// The direction in which light goes, of length one.
    pub towards: DVec3,
    /// Solid angle that it stands for [sr].
    pub weight: f64,
}

/// The axes in a plane across `axis`: along its rows, and from row to row.
pub fn across(axis: usize) -> (usize, usize) {
    [(1, 2), (0, 2), (0, 1)][axis]
}

/// Most directions of a part of a face.
pub const TOGETHER: usize = 9;
/// Directions that are mirror images of each other in the two axes of a face, but for those on an axis.
const MIRRORED: usize = 4;

/// Six faces of `edge` × `edge` directions, in as few parts as may be, which do not part mirror images.
pub fn faces(edge: usize) -> Vec<Face> {
    let cut = Cut { edge };
    let scale = cut.fitted_scale();
    let together = if edge * edge <= TOGETHER { edge * edge } else { TOGETHER / MIRRORED * MIRRORED };
    let face = |f: usize| {
        let (axis, up) = (f / 2, [true, false][f % 2]);
        let directions: Vec<Direction> = cut.cells().map(|cell| cut.direction(cell, scale, axis, up)).collect();
        directions.chunks(together).map(|part| Face { axis, up, directions: part.to_vec() }).collect::<Vec<_>>()
    };
    (0..6).flat_map(face).collect()
}

/// A face that is cut into `edge` × `edge` cells of equal angles along both slopes.
struct Cut {
    edge: usize,
}

impl Cut {
    /// The cells, mirror images side by side.
    fn cells(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let edge = self.edge;
        let mut cells: Vec<(usize, usize)> = (0..edge * edge).map(|i| (i % edge, i / edge)).collect();
        let from_edge = |i: usize| i.min(edge - 1 - i);
        cells.sort_by_key(|(i, j)| (from_edge(*j), from_edge(*i)));
        cells.into_iter()
    }

    /// The slope after a given number of cells.
    fn slope(&self, part: f64) -> f64 {
        (std::f64::consts::FRAC_PI_4 * (2.0 * part / self.edge as f64 - 1.0)).tan()
    }

    /// The slopes (u, v) of a cell's middle, scaled.
    fn middle(&self, (i, j): (usize, usize), scale: f64) -> (f64, f64) {
        (scale * self.slope(i as f64 + 0.5), scale * self.slope(j as f64 + 0.5))
    }

    /// The solid angle of a cell \[sr\].
    fn weight(&self, (i, j): (usize, usize)) -> f64 {
        let along = |i: usize| (self.slope(i as f64), self.slope(i as f64 + 1.0));
        let (u, v) = (along(i), along(j));
        solid_angle(u.1, v.1) - solid_angle(u.0, v.1) - solid_angle(u.1, v.0) + solid_angle(u.0, v.0)
    }

    /// ⟨d_x⁴⟩ over the directions of all faces whose slopes are scaled.
    fn fourth_moment(&self, scale: f64) -> f64 {
        let fourth = |(u, v): (f64, f64)| (1.0 + u.powi(4) + v.powi(4)) / 3.0 / (1.0 + u * u + v * v).powi(2);
        self.cells().map(|cell| self.weight(cell) * fourth(self.middle(cell, scale))).sum::<f64>() * 6.0 / SPHERE
    }

    /// The scale of slopes whose fourth moment is that of a sphere, by halving.
    fn fitted_scale(&self) -> f64 {
        let (mut narrow, mut wide) = (0.8, 1.2);
        for _ in 0..60 {
            let middle = 0.5 * (narrow + wide);
            *if self.fourth_moment(middle) > 0.2 { &mut narrow } else { &mut wide } = middle;
        }
        narrow
    }

    fn direction(&self, cell: (usize, usize), scale: f64, axis: usize, up: bool) -> Direction {
        let (column, row) = across(axis);
        let mut towards = [0.0; 3];
        towards[axis] = if up { 1.0 } else { -1.0 };
        (towards[column], towards[row]) = self.middle(cell, scale);
        Direction { towards: DVec3::from(towards).normalize(), weight: self.weight(cell) }
    }
}

/// The solid angle of slopes between 0 and `u`, 0 and `v` [sr].
fn solid_angle(u: f64, v: f64) -> f64 {
    (u * v / (1.0 + u * u + v * v).sqrt()).atan()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ w f over the directions is ∫ f dΩ for all f up to the fourth power.
    #[test]
    fn directions_integrate() {
        for edge in [2, 3, 4, 6] {
            let sum =
                |f: &dyn Fn(DVec3) -> f64| faces(edge).iter().flat_map(|f| &f.directions).map(|d| d.weight * f(d.towards)).sum::<f64>();
            assert!((sum(&|_| 1.0) / SPHERE - 1.0).abs() < 1e-12);
            assert!(sum(&|d| d.x).abs() < 1e-12 && sum(&|d| d.x * d.y * d.z).abs() < 1e-12 && sum(&|d| d.x * d.y).abs() < 1e-12);
            assert!((sum(&|d| d.z * d.z) * 3.0 / SPHERE - 1.0).abs() < 1e-12);
            let fourth = sum(&|d| d.x.powi(4)) * 5.0 / SPHERE - 1.0;
            assert!(fourth.abs() < 1e-9, "{edge}: {fourth}");
            let mixed = sum(&|d| d.x * d.x * d.y * d.y) * 15.0 / SPHERE - 1.0;
            assert!(mixed.abs() < 1e-9, "{edge}: {mixed}");
        }
    }
}
