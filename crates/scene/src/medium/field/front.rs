//! Fronts: surfaces at which a density of a grid ends, placed more finely than its voxels.
//!
//! A grid with a front has the density ρ(p) = e(p) min(max(u(p), 0), 1), e and u trilinear. Where u rises by several units per voxel,
//! the density ends within a fraction of a voxel.

use glam::DVec3;
use rayon::prelude::*;

use super::lattice::trilinear;

/// Places per edge of an octant of a voxel at which its mean share is computed.
const PLACES: usize = 2;

/// Mean of min(max(u, 0), 1) over a segment in which u is linear \[1\].
pub fn mean_share(from: f64, to: f64) -> f64 {
    let primitive = |u: f64| if u < 1.0 { 0.5 * u.max(0.0).powi(2) } else { u - 0.5 };
    let change = to - from;
    if change.abs() < 1e-6 { (0.5 * (from + to)).clamp(0.0, 1.0) } else { (primitive(to) - primitive(from)) / change }
}

/// Means of min(max(u, 0), 1) over voxels, x running fastest \[1\]: exact where u is between 0 and 1 in all neighbours, otherwise from
/// several places in the voxel.
pub fn voxel_shares(dims: [usize; 3], values: &[f32]) -> Vec<f32> {
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
                let last = nx - 1;
                change(&mut out[0], here[0], here[0], here[last.min(1)]);
                out[1..].iter_mut().zip(here.windows(3)).for_each(|(out, row)| change(out, row[0], row[1], row[2]));
                if last > 0 {
                    change(&mut out[last], here[last - 1], here[last], here[last]);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Filters reach each face of the box, where the voxel at the face stands for the next one, along axes of any length.
    #[test]
    fn filters_reach_the_faces() {
        for dims in [[1, 1, 1], [1, 3, 2], [2, 1, 4], [5, 4, 3]] {
            let cells: usize = dims.iter().product();
            let values: Vec<f32> = (0..cells).map(|i| (i * 7 % 11) as f32).collect();
            let sums = filtered(dims, values.clone(), |before, here, after| before + 10.0 * here + 100.0 * after);
            for (i, sum) in sums.iter().enumerate() {
                let place = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
                let value = |at: [usize; 3]| values[(at[2] * dims[1] + at[1]) * dims[0] + at[0]];
                let weights = [1.0, 10.0, 100.0];
                let mut wanted = 0.0;
                for n in 0..27 {
                    let steps = [n % 3, n / 3 % 3, n / 9];
                    let at = std::array::from_fn(|axis| (place[axis] + steps[axis]).saturating_sub(1).min(dims[axis] - 1));
                    wanted += steps.iter().map(|step| weights[*step]).product::<f32>() * value(at);
                }
                assert!((sum - wanted).abs() <= 1e-4 * wanted, "{dims:?} {i}: {sum} {wanted}");
            }
        }
    }

    /// Mean shares are those of the exact integral over a voxel cut by a plane.
    #[test]
    fn shares_are_volumes() {
        let dims = [9, 8, 7];
        // u rises by six per voxel along a slanted direction.
        let value = |x: f64, y: f64, z: f64| 6.0 * (0.8 * (x - 4.1) + 0.36 * (y - 3.6) + 0.48 * (z - 3.2)) + 0.5;
        let values: Vec<f32> = (0..504).map(|i| value((i % 9) as f64, (i / 9 % 8) as f64, (i / 72) as f64) as f32).collect();
        let shares = voxel_shares(dims, &values);
        let mut cut = 0;
        for (x, y, z) in (1..8).flat_map(|x| (1..7).flat_map(move |y| (1..6).map(move |z| (x, y, z)))) {
            const FINE: usize = 40;
            let part = |i: usize| (i as f64 + 0.5) / FINE as f64 - 0.5;
            let sum: f64 = (0..FINE.pow(3))
                .map(|i| {
                    value(x as f64 + part(i % FINE), y as f64 + part(i / FINE % FINE), z as f64 + part(i / FINE.pow(2))).clamp(0.0, 1.0)
                })
                .sum();
            let (found, wanted) = (f64::from(shares[(z * 8 + y) * 9 + x]), sum / FINE.pow(3) as f64);
            assert!((found - wanted).abs() < 0.02, "{x} {y} {z}: {found} {wanted}");
            cut += usize::from((0.1..0.9).contains(&wanted));
        }
        assert!(cut > 10, "{cut}");
    }
}
