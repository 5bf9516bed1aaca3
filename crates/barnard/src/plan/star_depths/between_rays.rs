//! Depths of voxels between the rays beside them: cubic along both axes of a plane, within the two nearest.

use spectra::simd;

use crate::packet::LANES;
use crate::plan::star_depths::OPAQUE;

/// The second of the four rays, of `count`, that a place among them is interpolated from, and how far it lies behind.
#[inline(always)]
pub(super) fn beside(at: f64, count: usize) -> (usize, f32) {
    let second = at.max(1.0).min((count - 3) as f64).floor();
    (second as usize, (at - second) as f32)
}

/// Where the voxels of a line stand among the rays of its row: the place of voxel number 0, and the step from voxel to
/// voxel.
pub(super) struct Places {
    pub first: f64,
    pub step: f64,
    /// The number of the first voxel of the line.
    pub voxel: usize,
    /// All rays of a row, and the first of those that are given.
    pub counts: usize,
    pub first_ray: usize,
}

simd! {
    /// Interpolates a line of voxels from the rays of its row.
    pub(super) fn cubic_line(line: &mut [f32], rays: &[f32], places: &Places) {
        for (chunk, line) in line.chunks_mut(LANES).enumerate() {
            let (mut second, mut between, mut four) = ([0; LANES], [0.0; LANES], [[0.0; LANES]; 4]);
            for lane in 0..LANES {
                let (i, f) = beside(places.first + (places.voxel + chunk * LANES + lane) as f64 * places.step, places.counts);
                (second[lane], between[lane]) = (i - places.first_ray.min(i - 1), f);
            }
            for lane in 0..LANES {
                let rays_near = &rays[(second[lane] - 1).min(rays.len() - 4)..][..4];
                (0..4).for_each(|i| four[i][lane] = rays_near[i]);
            }
            let mut swept = [0.0; LANES];
            for lane in 0..LANES {
                let value = cubic([four[0][lane], four[1][lane], four[2][lane], four[3][lane]], between[lane]);
                swept[lane] = if value > 0.0 { value } else { 0.0 };
            }
            line.copy_from_slice(&swept[..line.len()]);
        }
    }
}

simd! {
    /// Interpolates four rows value by value with `cubic`.
    pub(super) fn cubic_rows(out: &mut [f32], [a, b, c, d]: [&[f32]; 4], t: f32) {
        for i in 0..out.len() {
            out[i] = cubic([a[i], b[i], c[i], d[i]], t);
        }
    }
}

/// The cubic through four depths (Catmull–Rom), never outside of the middle two: an opaque edge throws no false shadow
/// beside itself.
#[inline(always)]
fn cubic(values: [f32; 4], t: f32) -> f32 {
    let [a, b, c, d] = values.map(|v| if v > OPAQUE as f32 { OPAQUE as f32 } else { v });
    let value = b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
    let (low, high) = if b < c { (b, c) } else { (c, b) };
    let value = if value < low { low } else { value };
    if value > high { high } else { value }
}

/// True if rays beside a voxel are so far from coming in that no cubic follows them.
pub(super) fn grazed(rays: [&[f32]; 4]) -> bool {
    let (low, high) = rays.iter().flat_map(|r| r.iter()).fold((f32::MAX, f32::MIN), |(l, h), d| (l.min(*d), h.max(*d)));
    low < -high.max(0.0)
}
