//! Directions in units of the grid, as sweeps follow them from plane to plane.

use super::cells::SweepCells;
use super::directions::{Direction, Face, across};
use super::harmonics::{COUNT, harmonics};

/// A direction in units of the grid.
#[derive(Debug)]
pub struct Beam {
    /// Cells, along a row and from row to row, to the first of the four that it comes from.
    pub shift: [isize; 2],
    /// Bilinear weights of the four.
    pub weights: [f32; 4],
    /// The way from plane to plane along the direction \[pc\].
    pub length_pc: f32,
    /// The harmonics Y_lm of the direction.
    pub harmonics: [f32; COUNT],
    /// The quadrature weights Y_lm dΩ, by which radiance adds to the moments.
    pub quadrature: [f32; COUNT],
}

/// A direction of a face between planes of cells.
pub fn beam(cells: &SweepCells, face: &Face, direction: &Direction) -> Beam {
    let (column, row) = across(face.axis);
    let edge = cells.lattice.voxel_pc();
    let along = direction.towards[face.axis].abs();
    // Where light comes from, one plane before.
    let back = |axis: usize| -direction.towards[axis] / along * edge[face.axis] / edge[axis];
    let (u, v) = (back(column), back(row));
    let (fu, fv) = ((u - u.floor()) as f32, (v - v.floor()) as f32);
    let y = harmonics(direction.towards);
    Beam {
        shift: [u.floor() as isize, v.floor() as isize],
        weights: [(1.0 - fu) * (1.0 - fv), fu * (1.0 - fv), (1.0 - fu) * fv, fu * fv],
        length_pc: (edge[face.axis] / along) as f32,
        harmonics: y.map(|y| y as f32),
        quadrature: y.map(|y| (y * direction.weight) as f32),
    }
}
