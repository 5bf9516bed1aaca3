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
    /// σ at V there, cell × place [pc⁻¹].
    sampled: Vec<f32>,
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
        let lattice = Self::lattice(dust, gas, most);
        // Means of blocks where there are more voxels than places.
        let block = (lattice.voxel_pc() / dust.lattice().voxel_pc()).min_element() / MAX_SAMPLES as f64;
        let merged = (block >= 2.0).then(|| dust.merged(block as usize, 1.0));
        let dust = merged.as_ref().unwrap_or(dust);
        // Twice as many places where cells do not end with the dust.
        let oversampled = if lattice.bounds == dust.lattice().bounds { 1.0 } else { 2.0 };
        let samples = <[f64; 3]>::from(oversampled * lattice.voxel_pc() / dust.lattice().voxel_pc() - 1e-6);
        let samples = samples.map(|n| (n.ceil() as usize).clamp(1, MAX_SAMPLES));
        let mut cells = Self { lattice, samples, sampled: Vec::new(), sigma: Vec::new(), least: 0.0 };
        cells.sampled = cells.samples_of(dust);
        cells.sigma = cells.means_of(&cells.sampled);
        cells.least = LEAST * cells.sigma.iter().fold(f32::MIN_POSITIVE / LEAST, |most, s| most.max(*s));
        cells
    }

    /// The lattice of the cells of some dust and gas.
    pub fn lattice(dust: &Grid, gas: &[Grid], most: usize) -> Lattice {
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
        let fewest = if bounds == dust_bounds { 1 } else { 4.min(most) };
        let dims = <[f64; 3]>::from(bounds.size() / edge).map(|n| (n.round() as usize).clamp(fewest, most));
        Lattice { dims, bounds }
    }

    /// Cells with these densities.
    #[cfg(test)]
    pub fn of(lattice: Lattice, sigma: Vec<f32>) -> Self {
        Self { lattice, samples: [1; 3], sampled: sigma.clone(), sigma, least: LEAST }
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

    /// Places of a cell.
    fn count(&self) -> usize {
        self.samples.iter().product()
    }

    /// A field at the places of all cells, cell × place.
    fn samples_of(&self, field: &Grid) -> Vec<f32> {
        let ([nx, ny, _], [sx, sy, sz], count) = (self.lattice.dims, self.samples, self.count());
        let (low, spacing) = (self.lattice.bounds.low, self.spacing());
        let mut samples = vec![0.0; self.lattice.cells() * count];
        let row = |(places, values): &mut (Vec<DVec3>, Vec<f64>), (row, out): (usize, &mut [f32])| {
            for across in 0..sy * sz {
                let (y, z) = (row % ny * sy + across % sy, row / ny * sz + across / sy);
                let place = |x: usize| low + spacing * (DVec3::new(x as f64, y as f64, z as f64) + 0.5);
                places.clear();
                places.extend((0..nx * sx).map(place));
                values.resize(places.len(), 0.0);
                field.sample(places, values);
                for (x, value) in values.iter().enumerate() {
                    out[x / sx * count + across * sx + x % sx] = *value as f32;
                }
            }
        };
        samples.par_chunks_mut(nx * count).enumerate().for_each_init(Default::default, row);
        samples
    }

    /// Means of samples over the cells.
    fn means_of(&self, samples: &[f32]) -> Vec<f32> {
        let mean = |cell: &[f32]| (cell.iter().map(|sample| f64::from(*sample)).sum::<f64>() / cell.len() as f64) as f32;
        samples.par_chunks(self.count()).map(mean).collect()
    }

    /// Means of a field over the cells.
    pub fn means(&self, field: &Grid) -> Vec<f32> {
        self.means_of(&self.samples_of(field))
    }

    /// Adds moments of the stars' own light, in the mean over the dust of each cell; `direct_sources` are those that a
    /// row of cells sees, `k` the terms' extinctions.
    ///
    /// # Errors
    /// On interruption by the user.
    pub fn direct<'a>(
        &self,
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
                    self.starlight(r * row + x, &near, k, sum);
                }
            }
            Ok(())
        })
    }

    /// Adds the light of some stars in one cell.
    fn starlight(&self, cell: usize, direct_sources: &[&DirectSource], k: &EightLanes, sum: &mut [EightLanes]) {
        let spacing = self.spacing();
        let sigmas = &self.sampled[cell * self.count()..][..self.count()];
        let filled = |sigma: &f32| *sigma > self.least;
        let mass: f64 = sigmas.iter().filter(|s| filled(s)).map(|s| f64::from(*s)).sum();
        for (place, sigma) in self.places(cell).zip(sigmas).filter(|(_, sigma)| filled(sigma)) {
            let sigma = f64::from(*sigma);
            for direct_source in direct_sources {
                let offset = place - direct_source.place;
                let part = direct_source.kernel_pc.map_or(1.0, |reach| NearFieldKernel::even(reach).share(offset.length_squared(), 0.0));
                let near = (part * sigma / mass * inverse_square_of_voxel(offset, spacing)) as f32;
                let depth = (direct_source.depth)(place, sigma).max(0.0) as f32;
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
