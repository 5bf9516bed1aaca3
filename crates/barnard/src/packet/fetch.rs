//! Trilinear reads of a volume for a packet of rays.
//!
//! Channels are interleaved and x runs fastest, so the two x-neighbours of all channels are one contiguous row: four rows a sample, lerped in y and z
//! as short vectors, then in x.

use crate::geometry::Ray;
use crate::plan::Volume;

use super::lane::{LANES, Lane, ROUND, fma};

/// A volume's place along a packet's rays: u = origin + slope · t in units of voxels.
pub struct Cursor<'a> {
    volume: &'a Volume,
    origin: [Lane; 3],
    slope: [Lane; 3],
}

impl<'a> Cursor<'a> {
    /// For `rays`, distances counted from `start` of each.
    ///
    /// # Panics
    /// If the volume does not hold dims × channels values, at least two voxels along each axis: what the reads rely on.
    pub fn new(volume: &'a Volume, rays: &[Ray; LANES], start: &[f64; LANES]) -> Self {
        let dims = volume.lattice.dims;
        assert!(dims.iter().all(|n| *n >= 2) && (1..=8).contains(&volume.channels.len()));
        assert_eq!(volume.data.len(), volume.lattice.cells() * volume.channels.len());
        let (mut origin, mut slope) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        let voxel = volume.lattice.voxel_pc();
        for (lane, ray) in rays.iter().enumerate() {
            let u = (ray.at(start[lane]) - volume.lattice.bounds.low) / voxel - 0.5;
            let s = ray.direction / voxel;
            for axis in 0..3 {
                origin[axis][lane] = u[axis] as f32;
                slope[axis][lane] = s[axis] as f32;
            }
        }
        Self { volume, origin, slope }
    }

    /// How many channels are read.
    #[inline(always)]
    pub fn channels(&self) -> usize {
        self.volume.channels.len()
    }

    /// All channels at distance `t` of each ray, into `out`.
    #[inline(always)]
    pub fn read(&self, t: &Lane, out: &mut [Lane]) {
        match self.volume.channels.len() {
            1 => self.read_channels::<1, 2>(t, out),
            2 => self.read_channels::<2, 4>(t, out),
            3 => self.read_channels::<3, 6>(t, out),
            4 => self.read_channels::<4, 8>(t, out),
            5 => self.read_channels::<5, 10>(t, out),
            6 => self.read_channels::<6, 12>(t, out),
            7 => self.read_channels::<7, 14>(t, out),
            _ => self.read_channels::<8, 16>(t, out),
        }
    }

    /// `ROW` is twice the number of channels.
    #[inline(always)]
    fn read_channels<const CHANNELS: usize, const ROW: usize>(&self, t: &Lane, out: &mut [Lane]) {
        let out = &mut out[..CHANNELS];
        let [nx, ny, nz] = self.volume.lattice.dims;
        let (ix, fx) = self.axis(0, nx, t);
        let (iy, fy) = self.axis(1, ny, t);
        let (iz, fz) = self.axis(2, nz, t);
        let (dy, dz) = (nx * CHANNELS, nx * ny * CHANNELS);
        let data = &self.volume.data[..];
        let mut base = [0usize; LANES];
        for lane in 0..LANES {
            base[lane] = iz[lane] as usize * dz + iy[lane] as usize * dy + ix[lane] as usize * CHANNELS;
        }
        for lane in 0..LANES {
            let row = |at: usize| -> [f32; ROW] {
                debug_assert!(at + ROW <= data.len());
                // SAFETY: `axis` keeps every cell at most dims − 2 and the volume holds dims × CHANNELS values, so the row of the next
                // y and z ends at or before the last value; `reads_at_every_border_stay_inside` walks all borders.
                unsafe { data.as_ptr().add(at).cast::<[f32; ROW]>().read() }
            };
            let (a, b, c, d) = (row(base[lane]), row(base[lane] + dy), row(base[lane] + dz), row(base[lane] + dz + dy));
            let mut mixed = [0.0f32; ROW];
            for i in 0..ROW {
                let low = fma(fy[lane], b[i] - a[i], a[i]);
                let high = fma(fy[lane], d[i] - c[i], c[i]);
                mixed[i] = fma(fz[lane], high - low, low);
            }
            for channel in 0..CHANNELS {
                out[channel][lane] = fma(fx[lane], mixed[CHANNELS + channel] - mixed[channel], mixed[channel]);
            }
        }
    }

    /// Cell and fraction along one axis, clamped to the border.
    #[inline(always)]
    fn axis(&self, axis: usize, n: usize, t: &Lane) -> ([u32; LANES], Lane) {
        let (mut cell, mut fraction) = ([0; LANES], [0.0; LANES]);
        let (last, last_cell) = ((n - 1) as f32, (n - 2) as u32);
        for lane in 0..LANES {
            let u = fma(self.slope[axis][lane], t[lane], self.origin[axis][lane]);
            let u = if u < 0.0 { 0.0 } else { u };
            let u = if u > last { last } else { u };
            // Rounding u − ½ gives floor(u), or u − 1 on an integer: the fraction is then 1, which is the same place.
            let rounded = (u - 0.5 + ROUND).to_bits() & 0x003f_ffff;
            let c = if rounded > last_cell { last_cell } else { rounded };
            cell[lane] = c;
            fraction[lane] = u - c as i32 as f32;
        }
        (cell, fraction)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::{Grid, Lattice};
    use crate::geometry::Bounds;
    use crate::plan::Channel;

    fn filled(lattice: &Lattice, grids: &[Grid]) -> Volume {
        let mut volume = Volume::zeroed(lattice, (0..grids.len()).map(Channel::Emission).collect());
        grids.iter().enumerate().for_each(|(slot, grid)| volume.fill(slot, grid));
        volume
    }

    /// The twin of `Volume::at`, for every number of channels.
    #[test]
    fn reads_are_those_of_the_scalar_twin() {
        let lattice = Lattice { dims: [9, 5, 7], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        for count in 1..=8usize {
            let grids: Vec<Grid> =
                (0..count).map(|c| Grid::sampled(lattice.clone(), |p| (p.x * 3.0 + c as f64).sin() + p.y * p.z)).collect();
            let volume = filled(&lattice, &grids);
            let ray =
                |i: usize| Ray { origin: DVec3::new(-1.5, -0.9 + 0.11 * i as f64, 0.1), direction: DVec3::new(1.0, 0.05, 0.1).normalize() };
            let rays: [Ray; LANES] = std::array::from_fn(ray);
            let cursor = Cursor::new(&volume, &rays, &[0.3; LANES]);
            for step in 0..50 {
                let t = [0.05 * step as f32; LANES];
                let mut out = [[0.0; LANES]; 8];
                cursor.read(&t, &mut out);
                for (lane, ray) in rays.iter().enumerate() {
                    for c in 0..count {
                        let truth = volume.at(c, ray.at(0.3 + f64::from(t[lane])));
                        assert!((f64::from(out[c][lane]) - truth).abs() < 2e-5, "{count} {step} {lane}");
                    }
                }
            }
        }
    }

    /// Rays along every border and corner, far outside and with NaN: the values are the border's, and debug builds check every address.
    #[test]
    fn reads_at_every_border_stay_inside() {
        let lattice = Lattice { dims: [3, 2, 4], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let grid = Grid::sampled(lattice.clone(), |p| 1.0 + p.x + 2.0 * p.y + 4.0 * p.z);
        for count in 1..=8 {
            let volume = filled(&lattice, &vec![grid.clone(); count]);
            let ray = |i: usize| {
                let corner = DVec3::new(f64::from(i as u32 & 1), f64::from(i as u32 >> 1 & 1), f64::from(i as u32 >> 2 & 1)) * 2.0 - 1.0;
                Ray {
                    origin: corner * if i < 8 { 1.0 } else { 50.0 },
                    direction: if i.is_multiple_of(3) { -corner.normalize() } else { DVec3::X },
                }
            };
            let cursor = Cursor::new(&volume, &std::array::from_fn(ray), &[0.0; LANES]);
            for t in [0.0, 1.0, 2.0, 3.5, 1e6, -1e6, f32::INFINITY, f32::NAN] {
                let mut out = [[0.0; LANES]; 8];
                cursor.read(&[t; LANES], &mut out);
                if t.is_finite() {
                    assert!(out[..count].iter().flatten().all(|v| (-6.0..=8.0).contains(v)), "{t}");
                }
            }
        }
    }
}
