//! The fall of starlight in voxels, where no star may stand in a pole.

use glam::DVec3;

/// Distance from a star, in voxel edges, within which 1/r² is averaged over a voxel, and by how many points along an
/// edge.
const CLOSE: f64 = 4.0;
const CLOSE_POINTS: usize = 6;

/// 1/r² of a voxel at `offset` from a star: its mean over the voxel where that is close [pc⁻²].
pub(in crate::plan) fn inverse_square_of_voxel(offset: DVec3, voxel: DVec3) -> f64 {
    let square = offset.length_squared();
    if square > (CLOSE * voxel.max_element()).powi(2) {
        return 1.0 / square;
    }
    let along = |i: usize| (i as f64 + 0.5) / CLOSE_POINTS as f64 - 0.5;
    let point = |i: usize| {
        let part = DVec3::new(along(i % CLOSE_POINTS), along(i / CLOSE_POINTS % CLOSE_POINTS), along(i / (CLOSE_POINTS * CLOSE_POINTS)));
        // A part of edge e around the star itself: ∫ dV/r² = 7.68 e.
        let nearest_squared = (voxel.min_element() / CLOSE_POINTS as f64).powi(2) / 7.68;
        1.0 / (offset + part * voxel).length_squared().max(nearest_squared)
    };
    let count = CLOSE_POINTS.pow(3);
    (0..count).map(point).sum::<f64>() / count as f64
}
