//! A transfer in numbers, as the shader reads it: eight terms, the planes of each face, and the beams through them.

use barnard::plan::ordinates::{Beam, EightLanes, Face, SweepCells, Transfer, across, beam};
use bytemuck::{Pod, Zeroable};

/// Numbers of a beam before its harmonics.
pub const HEAD: usize = 7;
/// The fields are those of `ordinates.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct TermNumbers {
    pub k: EightLanes,
    pub around: EightLanes,
    pub factor: EightLanes,
    pub cells: u32,
    pub glows: u32,
    pub least: f32,
    pub nothing: u32,
}

/// The fields are those of `ordinates.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneNumbers {
    pub first: u32,
    pub before: u32,
    pub column: u32,
    pub row: u32,
    pub columns: u32,
    pub rows: u32,
    pub beams: u32,
    pub half: u32,
}

/// Numbers for the shader: of eight terms, and of each plane of each face.
pub struct SweepNumbers {
    pub terms: TermNumbers,
    pub planes: Vec<PlaneNumbers>,
}

/// The faces of the first order, then those of all others.
pub fn faces<'a>(transfer: &Transfer<'a>) -> impl Iterator<Item = &'a Face> {
    transfer.faces.into_iter().flatten()
}

/// Most directions of a face.
pub fn beams_of(transfer: &Transfer) -> usize {
    faces(transfer).map(|face| face.directions.len()).max().unwrap_or(0)
}

/// The planes of a face, in the order of the sweep; its beams start at number `beams` of all.
pub fn planes(cells: &SweepCells, face: &Face, beams: usize) -> Vec<PlaneNumbers> {
    let dims = cells.lattice.dims;
    let strides = [1, dims[0], dims[0] * dims[1]];
    let (column, row) = across(face.axis);
    let count = dims[face.axis];
    let at = |step: usize| (if face.up { step } else { count - 1 - step }) * strides[face.axis];
    let plane = |step: usize| PlaneNumbers {
        first: at(step) as u32,
        before: at(step.saturating_sub(1)) as u32,
        column: strides[column] as u32,
        row: strides[row] as u32,
        columns: dims[column] as u32,
        rows: dims[row] as u32,
        beams: beams as u32,
        half: (step % 2) as u32 + if step == 0 { 2 } else { 0 },
    };
    (0..count).map(plane).collect()
}

/// The beams of a face as the shader reads them, and as many of nothing as make up `room`: their heads, then each
/// harmonic of all of them, and each quadrature weight.
pub fn beams(cells: &SweepCells, face: &Face, room: usize, harmonics: usize) -> Vec<f32> {
    let packed: Vec<Beam> = face.directions.iter().map(|d| beam(cells, face, d)).collect();
    let of_all = |numbers: &dyn Fn(&Beam) -> f32| packed.iter().map(numbers).chain(std::iter::repeat(0.0)).take(room).collect::<Vec<f32>>();
    let head = |beam: &Beam| beam.shift.map(|shift| shift as f32).into_iter().chain([beam.length_pc]).chain(beam.weights);
    let mut beams: Vec<f32> = packed.iter().flat_map(head).collect();
    beams.resize(room * HEAD, 0.0);
    (0..harmonics).for_each(|h| beams.extend(of_all(&|beam| beam.harmonics[h])));
    (0..harmonics).for_each(|h| beams.extend(of_all(&|beam| beam.quadrature[h])));
    beams
}
