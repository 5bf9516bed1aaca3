//! Reads of a packet whose rays are close together: several are in one cell, and each cell is read once.
//!
//! A lane reads Σ w v over the corners of its cell. The values v are numbers that all lanes of a cell share; the weights
//! w of lanes that are elsewhere are zero.

use super::lane::{LANES, Lane, fma, lanes};
use super::track::{PacketPlaces, Track};
use crate::stored::Stored;
use crate::volume::Volume;

/// Largest separation of rays, in voxels summed over the axes: farther apart they share so few cells that each lane
/// is read faster for itself (measured with five to eight channels; with fewer it always is).
const FARTHEST: f32 = 2.0;
/// Placeholder cell number of lanes that were read.
const DONE: u32 = u32::MAX;

/// True if rays, at a distance `t` of each, are close enough.
pub(super) fn are_worthwhile(volume: &Volume, track: &Track, t: &Lane) -> bool {
    volume.channels.len() > 4 && volume.pages.voxels() < DONE as usize && track.extent(t) <= FARTHEST
}

/// Reads all channels of `data`, a volume's values, at places of each ray.
#[inline(always)]
pub(super) fn read<S: Stored, const CHANNELS: usize>(
    data: &[S],
    volume: &Volume,
    track: &Track,
    places: PacketPlaces,
    out: &mut [Lane; CHANNELS],
) {
    let [(x, fx), (y, fy), (z, fz)] = track.cells(volume.lattice.dims.map(|n| n - 1), places);
    let first = volume.pages.first_voxels([&x, &y, &z]);
    let mut number = [0; LANES];
    for lane in 0..LANES {
        number[lane] = first[lane] as u32;
    }
    let all = CornerWeights::new([&fx, &fy, &fz]);
    let [_, dy, dz] = volume.pages.strides().map(|n| n * CHANNELS);
    *out = [[0.0; LANES]; CHANNELS];
    loop {
        let first = least(&number);
        if first == DONE {
            return;
        }
        let mut here = [0.0f32; LANES];
        for lane in 0..LANES {
            let is_here = number[lane] == first;
            here[lane] = if is_here { 1.0 } else { 0.0 };
            number[lane] = if is_here { DONE } else { number[lane] };
        }
        let weights = all.at(&here);
        let cell = &data[first as usize * CHANNELS..][..dz + dy + 2 * CHANNELS];
        let [a, b, c, d] = [row(cell, 0, CHANNELS), row(cell, dy, CHANNELS), row(cell, dz, CHANNELS), row(cell, dz + dy, CHANNELS)];
        for (channel, sum) in out.iter_mut().enumerate() {
            let high = CHANNELS + channel;
            let low = [a[channel].value(), b[channel].value(), c[channel].value(), d[channel].value()];
            weights.add(low, [a[high].value(), b[high].value(), c[high].value(), d[high].value()], sum);
        }
    }
}

/// The two voxels of a cell in one of its four rows, channel by channel.
#[inline(always)]
fn row<S: Stored>(cell: &[S], at: usize, channels: usize) -> &[S] {
    &cell[at..at + 2 * channels]
}

/// The weights of the corners of a cell: at the low and the high end of its four rows along x.
struct CornerWeights {
    low: [Lane; 4],
    high: [Lane; 4],
}

impl CornerWeights {
    #[inline(always)]
    fn new([fx, fy, fz]: [&Lane; 3]) -> Self {
        let rows = [
            lanes!(|lane| (1.0 - fz[lane]) * (1.0 - fy[lane])),
            lanes!(|lane| (1.0 - fz[lane]) * fy[lane]),
            lanes!(|lane| fz[lane] * (1.0 - fy[lane])),
            lanes!(|lane| fz[lane] * fy[lane]),
        ];
        let before = lanes!(|lane| 1.0 - fx[lane]);
        Self { low: products(&rows, &before), high: products(&rows, fx) }
    }

    /// The weights of some lanes, and zero for the others.
    #[inline(always)]
    fn at(&self, here: &Lane) -> Self {
        Self { low: products(&self.low, here), high: products(&self.high, here) }
    }

    /// Adds what a cell holds, at the low and the high ends of its rows.
    #[inline(always)]
    fn add(&self, [a0, b0, c0, d0]: [f32; 4], [a1, b1, c1, d1]: [f32; 4], sum: &mut Lane) {
        let ([p0, q0, r0, s0], [p1, q1, r1, s1]) = (&self.low, &self.high);
        for lane in 0..LANES {
            let low = fma(p0[lane], a0, fma(q0[lane], b0, fma(r0[lane], c0, s0[lane] * d0)));
            let high = fma(p1[lane], a1, fma(q1[lane], b1, fma(r1[lane], c1, fma(s1[lane], d1, sum[lane]))));
            sum[lane] = low + high;
        }
    }
}

#[inline(always)]
fn products([a, b, c, d]: &[Lane; 4], by: &Lane) -> [Lane; 4] {
    [
        lanes!(|lane| a[lane] * by[lane]),
        lanes!(|lane| b[lane] * by[lane]),
        lanes!(|lane| c[lane] * by[lane]),
        lanes!(|lane| d[lane] * by[lane]),
    ]
}

/// The least of some numbers, by halves.
#[inline(always)]
fn least(numbers: &[u32; LANES]) -> u32 {
    let mut rest = *numbers;
    let mut width = LANES / 2;
    while width > 0 {
        for i in 0..width {
            rest[i] = if rest[i + width] < rest[i] { rest[i + width] } else { rest[i] };
        }
        width /= 2;
    }
    rest[0]
}
