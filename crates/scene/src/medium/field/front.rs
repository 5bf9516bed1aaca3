//! Fronts: surfaces at which a density of a grid ends, placed more finely than its voxels.
//!
//! A grid with a front has the density ρ(p) = e(p) min(max(u(p), 0), 1), e and u trilinear. Where u rises by several units per voxel,
//! the density ends within a fraction of a voxel.

use glam::DVec3;
use rayon::prelude::*;

use super::lattice::trilinear;

/// Places per edge of an octant of a voxel at which its mean share is computed.
const PLACES: usize = 2;

/// Mean of min(max(u, 0), 1) over a way along which u is linear \[1\].
pub fn mean_share(from: f64, to: f64) -> f64 {
    let primitive = |u: f64| if u < 1.0 { 0.5 * u.max(0.0).powi(2) } else { u - 0.5 };
    let change = to - from;
    if change.abs() < 1e-6 { (0.5 * (from + to)).clamp(0.0, 1.0) } else { (primitive(to) - primitive(from)) / change }
}

/// Means of min(max(u, 0), 1) over voxels, x running fastest \[1\]: of the trilinear interpolant where u is between 0 and 1 all around, otherwise from several places in the voxel.
pub fn mean_shares(dims: [usize; 3], values: &[f32]) -> Vec<f32> {
    let (low, high) = (least_around(dims, values), largest_around(dims, values));
    // A trilinear interpolant has an eighth of each neighbour along an axis.
    let mut shares = filtered(dims, values.to_vec(), |before, here, after| 0.125 * (before + after) + 0.75 * here);
    shares.par_iter_mut().zip(low.par_iter().zip(&high)).enumerate().for_each(|(voxel, (share, (low, high)))| {
        if *low >= 1.0 {
            *share = 1.0;
        } else if *high <= 0.0 {
            *share = 0.0;
        } else if *low < 0.0 || *high > 1.0 {
            *share = mean_share_of_voxel(dims, values, voxel);
        }
    });
    shares
}

fn mean_share_of_voxel(dims: [usize; 3], values: &[f32], voxel: usize) -> f32 {
    let place = [voxel % dims[0], voxel / dims[0] % dims[1], voxel / (dims[0] * dims[1])];
    let sides: [[usize; 3]; 3] = std::array::from_fn(|axis| {
        let i = place[axis];
        [i.saturating_sub(1), i, (i + 1).min(dims[axis] - 1)]
    });
    let value = |x: usize, y: usize, z: usize| f64::from(values[(sides[2][z] * dims[1] + sides[1][y]) * dims[0] + sides[0][x]]);
    let mut sum = 0.0;
    for octant in 0..8 {
        let [x, y, z] = [octant & 1, octant >> 1 & 1, octant >> 2];
        let corners = std::array::from_fn(|i| value(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)));
        for place in 0..PLACES.pow(3) {
            // Within the octant of the voxel next to a corner of eight voxels, in voxels.
            let part = |i: usize, side: usize| 0.5 * ((i as f64 + 0.5) / PLACES as f64 + 1.0 - side as f64);
            let at = DVec3::new(part(place % PLACES, x), part(place / PLACES % PLACES, y), part(place / PLACES.pow(2), z));
            sum += trilinear(corners, at).clamp(0.0, 1.0);
        }
    }
    (sum / (8 * PLACES.pow(3)) as f64) as f32
}

/// Largest value of each voxel and its neighbours.
pub fn largest_around(dims: [usize; 3], values: &[f32]) -> Vec<f32> {
    filtered(dims, values.to_vec(), |before, here, after| before.max(here).max(after))
}

/// Smallest value of each voxel and its neighbours.
fn least_around(dims: [usize; 3], values: &[f32]) -> Vec<f32> {
    filtered(dims, values.to_vec(), |before, here, after| before.min(here).min(after))
}

/// Applies a filter of three voxels along each axis in turn; at faces of the box the voxel at the face stands for the next one.
pub fn filtered(dims: [usize; 3], mut values: Vec<f32>, filter: impl Fn(f32, f32, f32) -> f32 + Sync) -> Vec<f32> {
    let mut filled = vec![0.0; values.len()];
    for axis in 0..3 {
        along(dims, axis, &values, &mut filled, |out, before, here, after| *out = filter(before, here, after));
        std::mem::swap(&mut values, &mut filled);
    }
    values
}

/// Changes each value of `out` by three voxels along an axis: the one before, the voxel itself and the one after.
pub fn along(dims: [usize; 3], axis: usize, values: &[f32], out: &mut [f32], change: impl Fn(&mut f32, f32, f32, f32) + Sync) {
    let [nx, ny, nz] = dims;
    let around = |i: usize, count: usize| (i.saturating_sub(1), (i + 1).min(count - 1));
    out.par_chunks_exact_mut(nx).enumerate().for_each(|(number, out)| {
        let (y, z) = (number % ny, number / ny);
        let row = |y: usize, z: usize| &values[(z * ny + y) * nx..][..nx];
        let here = row(y, z);
        let (before, after) = match axis {
            0 => {
                for (x, out) in out.iter_mut().enumerate() {
                    let (before, after) = around(x, nx);
                    change(out, here[before], here[x], here[after]);
                }
                return;
            }
            1 => {
                let (before, after) = around(y, ny);
                (row(before, z), row(after, z))
            }
            _ => {
                let (before, after) = around(z, nz);
                (row(y, before), row(y, after))
            }
        };
        let rows = before.iter().zip(here).zip(after);
        out.iter_mut().zip(rows).for_each(|(out, ((before, here), after))| change(out, *before, *here, *after));
    });
}
