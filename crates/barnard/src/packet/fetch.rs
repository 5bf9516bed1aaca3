//! Trilinear reads of a volume for a packet of rays.
//!
//! Channels are interleaved and x runs fastest, so the two x-neighbours of all channels are one contiguous row: four
//! rows a sample, lerped in y and z as short vectors, then in x.

use glam::DVec3;
use spectra::simd;
use wide::f32x4;

use crate::geometry::Ray;
use crate::stored::{Half, Stored};
use crate::volume::{Values, Volume, stored};

use super::lane::{LANES, Lane, fma, lanes};
use super::quads::{four, lerp};
use super::shared_cells;
use super::track::{CellWindow, PacketPlaces, Track};

/// A volume along a packet's rays.
pub struct Cursor<'a> {
    volume: &'a Volume,
    track: Track,
    /// True if cells are read for all rays that are in them.
    shares_cells: bool,
}

/// The places of a packet in a volume: the index of each cell's first value, the strides of the axes, and the place
/// within the cell, axis × lane.
struct PacketCells {
    first: [usize; LANES],
    strides: [usize; 3],
    fraction: [Lane; 3],
}

impl<'a> Cursor<'a> {
    /// Follows `rays` through `volume` between two distances of each; those that are read are counted from the first.
    ///
    /// # Panics
    /// If the volume does not hold voxels × channels values, at least two voxels along each axis: what the reads rely on.
    pub fn new(volume: &'a Volume, rays: &[Ray; LANES], start: &[f64; LANES], end: &[f64; LANES]) -> Self {
        let dims = volume.lattice.dims;
        assert!(dims.iter().all(|n| *n >= 2) && (1..=8).contains(&volume.channels.len()));
        assert_eq!(stored!(&volume.values, |data| data.len()), volume.pages.voxels() * volume.channels.len());
        // Values stand in the middles of voxels.
        let track = match &volume.part {
            None => Track::new(&volume.lattice, DVec3::splat(0.5), rays, start),
            Some(part) => {
                let whole = part.whole.dims.map(|n| n - 1);
                Track::new(&part.whole, DVec3::splat(0.5), rays, start).within(Some(CellWindow { whole, first: part.first }))
            }
        };
        let middle = lanes!(|lane| (0.5 * (end[lane] - start[lane])) as f32);
        let shares_cells = shared_cells::are_worthwhile(volume, &track, &middle);
        Self { volume, track, shares_cells }
    }

    /// The number of channels that are read.
    #[inline(always)]
    pub fn channels(&self) -> usize {
        self.volume.channels.len()
    }

    /// Reads all channels at places of each ray into `out`.
    pub fn read(&self, places: PacketPlaces, out: &mut [Lane]) {
        match &self.volume.values {
            Values::Single(data) => read_singles(self, data, places, out),
            Values::Half(data) => read_halves(self, data, places, out),
        }
    }

    /// Reads all channels of `data`, the volume's values, in parts of their units.
    #[inline(always)]
    fn read_stored<S: Stored>(&self, data: &[S], places: PacketPlaces, out: &mut [Lane]) {
        match self.volume.channels.len() {
            1 => self.read_one(data, places, &mut out[0]),
            2 => self.read_channels::<S, 2, 4>(data, places, out),
            3 => self.read_channels::<S, 3, 6>(data, places, out),
            4 => self.read_quads::<S, 4>(data, places, out),
            5 => self.read_many::<S, 5>(data, places, out),
            6 => self.read_many::<S, 6>(data, places, out),
            7 => self.read_many::<S, 7>(data, places, out),
            _ => self.read_many::<S, 8>(data, places, out),
        }
    }

    /// Reads five channels or more.
    #[inline(always)]
    fn read_many<S: Stored, const CHANNELS: usize>(&self, data: &[S], places: PacketPlaces, out: &mut [Lane]) {
        match out.first_chunk_mut::<CHANNELS>() {
            Some(out) if self.shares_cells => shared_cells::read(data, self.volume, &self.track, places, out),
            _ => self.read_quads::<S, CHANNELS>(data, places, out),
        }
    }

    /// Reads four channels or more: each quad of them is lerped in all axes, then four lanes change places with four
    /// channels. Quads may overlap.
    #[inline(always)]
    fn read_quads<S: Stored, const CHANNELS: usize>(&self, data: &[S], places: PacketPlaces, out: &mut [Lane]) {
        let out = &mut out[..CHANNELS];
        let cells = self.cells(places);
        let [dx, dy, dz] = cells.strides;
        let quads = || (0..CHANNELS).step_by(4).map(|i| i.min(CHANNELS - 4));
        for lane in (0..LANES).step_by(4) {
            let mut turning = [[f32x4::ZERO; 2]; 4];
            for (i, values) in turning.iter_mut().enumerate() {
                let lane = lane + i;
                let cell = &data[cells.first[lane]..][..dz + dy + 2 * CHANNELS];
                let [fx, fy, fz] = [0, 1, 2].map(|axis| f32x4::splat(cells.fraction[axis][lane]));
                for (value, at) in values.iter_mut().zip(quads()) {
                    let (low, high) = (face(cell, at, [dy, dz], [fy, fz]), face(cell, at + dx, [dy, dz], [fy, fz]));
                    *value = lerp(low, high, fx);
                }
            }
            for (q, at) in quads().enumerate() {
                let turned = f32x4::transpose([turning[0][q], turning[1][q], turning[2][q], turning[3][q]]);
                for (channel, values) in turned.into_iter().enumerate() {
                    out[at + channel][lane..lane + 4].copy_from_slice(&values.to_array());
                }
            }
        }
    }

    /// Reads the channels of each cell row by row; `ROW` is twice their number, at least four; quads of a row may overlap.
    #[inline(always)]
    fn read_channels<S: Stored, const CHANNELS: usize, const ROW: usize>(&self, data: &[S], places: PacketPlaces, out: &mut [Lane]) {
        let out = &mut out[..CHANNELS];
        let cells = self.cells(places);
        let [_, dy, dz] = cells.strides;
        let mut rows = [[0.0f32; ROW]; LANES];
        for (lane, row) in rows.iter_mut().enumerate() {
            let cell = &data[cells.first[lane]..][..dz + dy + ROW];
            let (fy, fz) = (f32x4::splat(cells.fraction[1][lane]), f32x4::splat(cells.fraction[2][lane]));
            let corner_row = |at: usize| -> &[S; ROW] { cell[at..at + ROW].try_into().expect("ROW values") };
            let (a, b, c, d) = (corner_row(0), corner_row(dy), corner_row(dz), corner_row(dz + dy));
            for i in (0..ROW).step_by(4).map(|i| i.min(ROW - 4)) {
                let (low, high) = (lerp(quad(a, i), quad(b, i), fy), lerp(quad(c, i), quad(d, i), fy));
                row[i..i + 4].copy_from_slice(&lerp(low, high, fz).to_array());
            }
        }
        for (channel, out) in out.iter_mut().enumerate() {
            for lane in 0..LANES {
                let (low, high) = (rows[lane][channel], rows[lane][CHANNELS + channel]);
                out[lane] = fma(cells.fraction[0][lane], high - low, low);
            }
        }
    }

    /// A single channel: its rows are pairs, so those of both y are lerped in z together.
    #[inline(always)]
    fn read_one<S: Stored>(&self, data: &[S], places: PacketPlaces, out: &mut Lane) {
        let cells = self.cells(places);
        let [_, dy, dz] = cells.strides;
        let mut faces = [[0.0f32; 4]; LANES];
        for (lane, face) in faces.iter_mut().enumerate() {
            let cell = &data[cells.first[lane]..][..dz + dy + 2];
            let pairs = |at: usize| f32x4::new([cell[at].value(), cell[at + 1].value(), cell[at + dy].value(), cell[at + dy + 1].value()]);
            *face = lerp(pairs(0), pairs(dz), f32x4::splat(cells.fraction[2][lane])).to_array();
        }
        let [fx, fy, _] = &cells.fraction;
        for lane in 0..LANES {
            let [a, b, c, d] = faces[lane];
            let (low, high) = (fma(fy[lane], c - a, a), fma(fy[lane], d - b, b));
            out[lane] = fma(fx[lane], high - low, low);
        }
    }

    /// The cells that hold the rays' places.
    #[inline(always)]
    fn cells(&self, places: PacketPlaces) -> PacketCells {
        let [(ix, fx), (iy, fy), (iz, fz)] = self.track.cells(self.volume.lattice.dims.map(|n| n - 1), places);
        let channels = self.volume.channels.len();
        let strides = self.volume.pages.strides().map(|n| n * channels);
        let mut first = self.volume.pages.first_voxels([&ix, &iy, &iz]);
        for number in &mut first {
            *number *= channels;
        }
        PacketCells { first, strides, fraction: [fx, fy, fz] }
    }
}

simd! {
    /// Reads all channels of singles.
    fn read_singles(cursor: &Cursor, data: &[f32], places: PacketPlaces, out: &mut [Lane]) {
        cursor.read_stored(data, places, out);
    }
}

simd! {
    /// Reads all channels of halves.
    fn read_halves(cursor: &Cursor, data: &[Half], places: PacketPlaces, out: &mut [Lane]) {
        cursor.read_stored(data, places, out);
        for (values, unit) in out.iter_mut().zip(&cursor.volume.units) {
            for lane in 0..LANES {
                values[lane] *= unit;
            }
        }
    }
}

/// Four values in a row.
#[inline(always)]
fn quad<S: Stored, const N: usize>(values: &[S; N], at: usize) -> f32x4 {
    f32x4::new([values[at].value(), values[at + 1].value(), values[at + 2].value(), values[at + 3].value()])
}

/// Four channels in the middle of a face of a cell, from value `at` on, by the strides and fractions of y and z.
#[inline(always)]
fn face<S: Stored>(cell: &[S], at: usize, [dy, dz]: [usize; 2], [fy, fz]: [f32x4; 2]) -> f32x4 {
    let (low, high) = (lerp(four(cell, at), four(cell, at + dy), fy), lerp(four(cell, at + dz), four(cell, at + dz + dy), fy));
    lerp(low, high, fz)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::{Grid, Lattice};
    use crate::geometry::Bounds;
    use crate::stored::Precision;
    use crate::volume::Channel;

    fn filled(lattice: &Lattice, grids: &[Grid], precision: Precision) -> Volume {
        let mut volume = Volume::with_precision(lattice, (0..grids.len()).map(Channel::Emission).collect(), precision);
        grids.iter().enumerate().for_each(|(slot, grid)| volume.fill(slot, grid));
        volume
    }

    /// The twin of `Volume::at`, for every number of channels, of rays far apart and so close together that they share
    /// cells.
    #[test]
    fn reads_are_those_of_the_scalar_twin() {
        let lattice = Lattice { dims: [9, 5, 7], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let cases = (1..=8usize).flat_map(|count| [(count, 0.11), (count, 0.012), (count, 0.0)]);
        for ((count, apart), precision) in cases.flat_map(|case| [(case, Precision::Single), (case, Precision::Half)]) {
            let grids: Vec<Grid> =
                (0..count).map(|c| Grid::sampled(lattice.clone(), |p| (p.x * 3.0 + c as f64).sin() + p.y * p.z)).collect();
            let [volume, single] = [precision, Precision::Single].map(|precision| filled(&lattice, &grids, precision));
            let ray = |i: usize| {
                let origin = DVec3::new(-1.5, -0.9 + apart * i as f64, 0.1 + 0.4 * apart * (i % 4) as f64);
                Ray { origin, direction: DVec3::new(1.0, 0.05, 0.1).normalize() }
            };
            let rays: [Ray; LANES] = std::array::from_fn(ray);
            let cursor = Cursor::new(&volume, &rays, &[0.3; LANES], &[2.8; LANES]);
            assert_eq!(cursor.shares_cells, count > 4 && apart < 0.1);
            let mut worst = 0.0f64;
            for step in 0..50 {
                let t = [0.05 * step as f32; LANES];
                let mut out = [[0.0; LANES]; 8];
                cursor.read(PacketPlaces::on_rays(&t), &mut out);
                for (lane, ray) in rays.iter().enumerate() {
                    for c in 0..count {
                        let truth = volume.at(c, ray.at(0.3 + f64::from(t[lane])));
                        assert!((f64::from(out[c][lane]) - truth).abs() < 2e-5, "{count} {apart} {precision:?} {step} {lane}");
                        worst = worst.max((truth - single.at(c, ray.at(0.3 + f64::from(t[lane])))).abs());
                    }
                }
            }
            // Halves are right to 2⁻¹¹ of values that are 2 at most.
            match precision {
                Precision::Single => assert_eq!(worst, 0.0),
                Precision::Half => assert!((1e-6..1e-3).contains(&worst), "{worst}"),
            }
        }
    }

    /// Rays along every border and corner, far outside and with NaN: the values are the border's, and debug builds
    /// check every address.
    #[test]
    fn reads_at_every_border_stay_inside() {
        let lattice = Lattice { dims: [3, 2, 4], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let grid = Grid::sampled(lattice.clone(), |p| 1.0 + p.x + 2.0 * p.y + 4.0 * p.z);
        for count in 1..=8 {
            let volume = filled(&lattice, &vec![grid.clone(); count], Precision::Half);
            let ray = |i: usize| {
                let corner = DVec3::new(f64::from(i as u32 & 1), f64::from(i as u32 >> 1 & 1), f64::from(i as u32 >> 2 & 1)) * 2.0 - 1.0;
                Ray {
                    origin: corner * if i < 8 { 1.0 } else { 50.0 },
                    direction: if i.is_multiple_of(3) { -corner.normalize() } else { DVec3::X },
                }
            };
            let cursor = || Cursor::new(&volume, &std::array::from_fn(ray), &[0.0; LANES], &[2.0; LANES]);
            for cursor in [cursor(), Cursor { shares_cells: count > 4, ..cursor() }] {
                for t in [0.0, 1.0, 2.0, 3.5, 1e6, -1e6, f32::INFINITY, f32::NAN] {
                    let mut out = [[0.0; LANES]; 8];
                    cursor.read(PacketPlaces::on_rays(&[t; LANES]), &mut out);
                    if t.is_finite() {
                        assert!(out[..count].iter().flatten().all(|v| (-6.0..=8.0).contains(v)), "{t}");
                    }
                }
            }
        }
    }
}
