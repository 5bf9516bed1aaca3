//! The dust, the gas and the direct light of stars in cells, as sweeps read them.

use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::harmonics::harmonics;
use super::lanes::EightLanes;
use super::moments::Moments;
use crate::control::Control;
use crate::error::Result;
use crate::field::{Field, Grid, Lattice};
use crate::geometry::Bounds;
use crate::plan::inverse_square::inverse_square_of_voxel;
use crate::plan::many_lights::near_field_kernel::NearFieldKernel;

/// The least σ of a cell, in parts of the largest.
const LEAST: f32 = 1e-9;

/// Cells of a sweep: as near to cubes as the box lets them be.
#[derive(Debug, Clone)]
pub struct SweepCells {
    /// The lattice of the cells.
    pub lattice: Lattice,
    /// Places along each edge of a cell at which it is asked what it holds.
    samples: [usize; 3],
    /// Mean σ at V [pc⁻¹].
    pub sigma: Vec<f32>,
    /// Dust of less is none [pc⁻¹]: its source function would be one of rounding.
    pub least: f32,
}

/// The distance from the dust up to which gas counts whose light scatters in the dust, in parts of the dust's box on
/// each side.
const AROUND: f64 = 0.5;
/// Cells along the longest edge that even a coarse grid is cut into.
const FINE: usize = 32;
/// Most places along an edge of a cell.
const MAX_SAMPLES: usize = 4;

impl SweepCells {
    /// Cuts the box around the dust, and gas near it, into at most `most` cells along an edge; into whole blocks of
    /// voxels where it can.
    pub fn new(dust: &Grid, gas: &[Grid], most: usize) -> Self {
        let dust_bounds = dust.lattice().bounds;
        let reach = AROUND * dust_bounds.size();
        let near = Bounds { low: dust_bounds.low - reach, high: dust_bounds.high + reach };
        let clipped =
            |b: Bounds| Bounds { low: b.low.max(near.low).min(dust_bounds.low), high: b.high.min(near.high).max(dust_bounds.high) };
        let bounds = gas.iter().map(|g| clipped(g.lattice().bounds)).fold(dust_bounds, |a, b| a.union(&b));
        let voxel = dust.lattice().voxel_pc();
        let (longest, finest) = (bounds.size().max_element(), voxel.min_element());
        let along = longest / finest;
        let edge = match (along - 1e-6) / most as f64 {
            many if many > 1.0 => finest * many.ceil(),
            // Few voxels are cut.
            _ => finest / (FINE.min(most) as f64 / along - 1e-6).ceil().max(1.0),
        };
        // Where gas reaches out of flat dust, cells must not be thicker than that.
        let (fewest, oversampled) = if bounds == dust_bounds { (1, 1.0) } else { (4.min(most), 2.0) };
        let dims = <[f64; 3]>::from(bounds.size() / edge).map(|n| (n.round() as usize).clamp(fewest, most));
        let lattice = Lattice { dims, bounds };
        // Twice as many places where cells do not end with the dust.
        let samples = <[f64; 3]>::from(oversampled * lattice.voxel_pc() / voxel - 1e-6);
        let samples = samples.map(|n| (n.ceil() as usize).clamp(1, MAX_SAMPLES));
        let mut cells = Self { lattice, samples, sigma: Vec::new(), least: 0.0 };
        cells.sigma = cells.means(dust);
        cells.least = LEAST * cells.sigma.iter().fold(f32::MIN_POSITIVE / LEAST, |most, s| most.max(*s));
        cells
    }

    /// Cells with these densities.
    #[cfg(test)]
    pub fn of(lattice: Lattice, sigma: Vec<f32>) -> Self {
        Self { lattice, samples: [1; 3], sigma, least: LEAST }
    }

    /// The distances between neighbouring places in a cell [pc].
    fn spacing(&self) -> DVec3 {
        self.lattice.voxel_pc() / DVec3::from(self.samples.map(|n| n as f64))
    }

    /// The places in a cell at which fields are asked.
    fn places(&self, cell: usize) -> impl Iterator<Item = DVec3> + use<> {
        let [x, y, z] = self.lattice.place(cell);
        let (spacing, [nx, ny, nz]) = (self.spacing(), self.samples);
        let low = self.lattice.bounds.low + self.lattice.voxel_pc() * DVec3::new(x as f64, y as f64, z as f64);
        let part = |i: usize| i as f64 + 0.5;
        (0..nx * ny * nz).map(move |i| low + spacing * DVec3::new(part(i % nx), part(i / nx % ny), part(i / (nx * ny))))
    }

    /// Means of a field over the cells.
    pub fn means(&self, field: &Grid) -> Vec<f32> {
        let mean = |cell| self.places(cell).map(|p| field.at(p)).sum::<f64>() / self.samples.iter().product::<usize>() as f64;
        (0..self.lattice.cells()).into_par_iter().map(|cell| mean(cell) as f32).collect()
    }

    /// Adds moments of the stars' own light, in the mean over the dust of each cell; `direct_sources` are those that a
    /// row of cells sees, `k` the terms' extinctions.
    ///
    /// # Errors
    /// On interruption by the user.
    pub fn direct<'a>(
        &self,
        dust: &Grid,
        direct_sources: impl Fn(usize) -> Vec<DirectSource<'a>> + Sync,
        k: &EightLanes,
        out: &mut Moments,
        control: &Control,
    ) -> Result<()> {
        let (row, count) = (self.lattice.dims[0], out.count);
        let radius = 0.5 * self.lattice.voxel_pc().length();
        out.data.par_chunks_mut(row * count).enumerate().try_for_each(|(r, out)| -> Result<()> {
            control.check()?;
            let direct_sources = direct_sources(r);
            for (x, sum) in out.chunks_exact_mut(count).enumerate().filter(|_| !direct_sources.is_empty()) {
                let [_, y, z] = self.lattice.place(r * row);
                let centre = self.lattice.centre(x, y, z);
                let reaches = |direct_source: &&DirectSource| {
                    direct_source.kernel_pc.is_none_or(|reach| (direct_source.place - centre).length() < reach + radius)
                };
                let near: SmallVec<[&DirectSource; 8]> = direct_sources.iter().filter(reaches).collect();
                if !near.is_empty() {
                    self.starlight(dust, r * row + x, &near, k, sum);
                }
            }
            Ok(())
        })
    }

    /// Adds the light of some stars in one cell.
    fn starlight(&self, dust: &Grid, cell: usize, direct_sources: &[&DirectSource], k: &EightLanes, sum: &mut [EightLanes]) {
        let spacing = self.spacing();
        let sigmas: SmallVec<[f64; 64]> = self.places(cell).map(|place| dust.at(place)).collect();
        let filled = |sigma: &f64| *sigma > f64::from(self.least);
        let mass: f64 = sigmas.iter().filter(|s| filled(s)).sum();
        for (place, sigma) in self.places(cell).zip(&sigmas).filter(|(_, sigma)| filled(sigma)) {
            for direct_source in direct_sources {
                let offset = place - direct_source.place;
                let part = direct_source.kernel_pc.map_or(1.0, |reach| NearFieldKernel::even(reach).share(offset.length_squared(), 0.0));
                let near = (part * sigma / mass * inverse_square_of_voxel(offset, spacing)) as f32;
                let depth = (direct_source.depth)(place, *sigma).max(0.0) as f32;
                let light: EightLanes = std::array::from_fn(|t| direct_source.sent[t] * near * (-k[t] * depth).exp());
                // What a star has in the middle of goes everywhere.
                let count = if (offset / spacing).length() < 0.3 { 1 } else { sum.len() };
                for (sum, y) in sum[..count].iter_mut().zip(harmonics(offset.normalize_or(DVec3::Z))) {
                    sum.iter_mut().zip(light).for_each(|(s, l)| *s += y as f32 * l);
                }
            }
        }
    }
}

/// A star as cells see it.
pub struct DirectSource<'a> {
    /// The place of the star [pc].
    pub place: DVec3,
    /// The weights without k ω that it sends.
    pub sent: &'a EightLanes,
    /// Depth at V from it to a place of extinction σ [1].
    pub depth: Box<dyn Fn(DVec3, f64) -> f64 + 'a>,
    /// Radius of the kernel within which its light counts [pc]; none where all of it does.
    pub kernel_pc: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells hold the dust of the grid along every axis, however few or flat its voxels are and however far gas reaches
    /// out of it; coarse grids are cut, and the number of cells is held to.
    #[test]
    fn cells_hold_all_dust() {
        let lattice = |dims, size: DVec3| Lattice { dims, bounds: Bounds { low: -0.5 * size, high: 0.5 * size } };
        let cube = DVec3::splat(2.0);
        let gas = |size: f64| [Grid::sampled(lattice([2; 3], DVec3::splat(size)), |_| 1.0)];
        let (none, near, far) = ([], gas(2.6), gas(4e6));
        for (dims, size) in
            [([96; 3], cube), ([7, 5, 3], cube), ([1, 1, 200], cube), ([1; 3], cube), ([128, 128, 1], DVec3::new(2.0, 2.0, 0.02))]
        {
            let dust = Grid::sampled(lattice(dims, size), |p| 2.0 + p.x + p.z);
            for (gas, most) in [(&none[..], 64), (&none[..], 24), (&none[..], 1), (&near[..], 64), (&far[..], 48)] {
                let cells = SweepCells::new(&dust, gas, most);
                let [nx, ny, nz] = cells.lattice.dims;
                assert!(nx.max(ny).max(nz) <= most && (most < 24 || nx.max(ny).max(nz) >= 16), "{dims:?} {most}: {nx} {ny} {nz}");
                assert!(gas.is_empty() || cells.lattice.bounds.size().max_element() <= 2.01 * size.max_element());
                let grid = Grid::from_lattice(cells.lattice.clone(), cells.sigma.clone());
                for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                    let column = |grid: &Grid| grid.column(-9.0 * axis, 9.0 * axis, f64::INFINITY);
                    let (found, truth) = (column(&grid), column(&dust));
                    let coarse = if most == 1 || !gas.is_empty() { 0.35 } else { 0.03 };
                    assert!((found / truth - 1.0).abs() < coarse, "{dims:?} {most} {axis}: {found} {truth}");
                }
            }
        }
    }
}
