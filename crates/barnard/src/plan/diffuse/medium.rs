//! The dust, the gas and the direct light of stars in cells, as sweeps read them.

use glam::DVec3;
use rayon::prelude::*;

use super::harmonics::harmonics;
use super::{Moments, Octet};
use crate::control::Control;
use crate::error::Result;
use crate::field::{Field, Grid, Lattice};
use crate::geometry::Bounds;
use crate::plan::Space;
use crate::plan::light_field::inverse_square_of_voxel;

/// The least σ of a cell, in parts of the largest.
const LEAST: f32 = 1e-9;

/// Cells of a sweep.
#[derive(Debug, Clone)]
pub struct Cells {
    /// Where they are.
    pub lattice: Lattice,
    /// Voxels of dust along an edge of one.
    pub block: usize,
    /// Mean σ at V [pc⁻¹].
    pub sigma: Vec<f32>,
    /// Dust of less is none [pc⁻¹]: its source function would be one of rounding.
    pub least: f32,
}

impl Cells {
    /// The smallest blocks of the dust's voxels of which no more than `most` stand along an edge of the box around dust and gas.
    pub fn new(dust: &Grid, gas: &[Grid], most: usize) -> Self {
        let whole = gas.iter().map(|g| g.lattice.bounds).fold(dust.lattice.bounds, |a, b| a.union(&b));
        let own = dust.lattice.bounds;
        let placed = |block: usize| {
            let edge = dust.lattice.voxel_pc() * block as f64;
            // A border of the box may lie on that of a cell.
            let below = ((own.low - whole.low) / edge - 1e-9).ceil().max(DVec3::ZERO);
            let above = ((whole.high - own.low) / edge - 1e-9).ceil().max(DVec3::ONE);
            (edge, below, above)
        };
        let mut block = 1;
        while {
            let (_, below, above) = placed(block);
            // Where gas reaches out of the dust on both sides, two are the fewest.
            (below + above).max_element() > most.max(2) as f64
        } {
            block += 1;
        }
        let (edge, below, above) = placed(block);
        let dims = <[f64; 3]>::from(below + above).map(|n| n as usize);
        let lattice = Lattice { dims, bounds: Bounds { low: own.low - below * edge, high: own.low + above * edge } };
        let mut cells = Self { lattice, block, sigma: Vec::new(), least: 0.0 };
        cells.sigma = cells.means(dust);
        cells.least = LEAST * cells.sigma.iter().fold(f32::MIN_POSITIVE, |most, s| most.max(*s));
        cells
    }

    /// Places in a cell: the middles of the dust's voxels.
    fn places(&self, cell: usize) -> impl Iterator<Item = DVec3> + use<> {
        let [x, y, z] = self.lattice.place(cell);
        let (edge, block) = (self.lattice.voxel_pc(), self.block);
        let low = self.lattice.bounds.low + edge * DVec3::new(x as f64, y as f64, z as f64);
        let part = move |i: usize| (i as f64 + 0.5) / block as f64;
        (0..block.pow(3)).map(move |i| low + edge * DVec3::new(part(i % block), part(i / block % block), part(i / (block * block))))
    }

    /// Means of a field over the cells.
    pub fn means(&self, field: &Grid) -> Vec<f32> {
        let mean = |cell| self.places(cell).map(|p| field.at(p)).sum::<f64>() / self.block.pow(3) as f64;
        (0..self.lattice.cells()).into_par_iter().map(|cell| mean(cell) as f32).collect()
    }

    /// Adds moments of the stars' own light, in the mean over the dust of each cell; `weights` are those of each star's terms, `k` the terms' extinctions.
    pub fn direct(&self, space: &Space, stars: &[(usize, Octet)], k: &Octet, out: &mut Moments, control: &Control) -> Result<()> {
        let Some(dust) = &space.dust else { return Ok(()) };
        let voxel = dust.lattice.voxel_pc();
        let of_cell = |(cell, sum): (usize, &mut [Octet])| -> Result<()> {
            control.check()?;
            let mut mass = 0.0;
            for place in self.places(cell) {
                let sigma = dust.at(place);
                if sigma <= f64::from(self.least) {
                    continue;
                }
                mass += sigma;
                for (star, weights) in stars {
                    let offset = place - space.stars[*star];
                    let depth = space.star_channel(*star).map_or(0.0, |(volume, slot)| volume.at(slot, place)).max(0.0) as f32;
                    let near = (sigma * inverse_square_of_voxel(offset, voxel)) as f32;
                    let light: Octet = std::array::from_fn(|t| weights[t] * near * (-k[t] * depth).exp());
                    for (sum, y) in sum.iter_mut().zip(harmonics(offset.normalize_or(DVec3::Z))) {
                        sum.iter_mut().zip(light).for_each(|(s, l)| *s += y as f32 * l);
                    }
                }
            }
            let share = if mass > 0.0 { 1.0 / mass as f32 } else { 0.0 };
            sum.iter_mut().flatten().for_each(|s| *s *= share);
            Ok(())
        };
        out.data.par_chunks_mut(out.count).with_min_len(256).enumerate().try_for_each(of_cell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells hold the dust of the grid, however few they are and however far gas reaches out of it.
    #[test]
    fn cells_hold_all_dust() {
        let lattice = |dims, low: f64, high: f64| Lattice { dims, bounds: Bounds { low: DVec3::splat(low), high: DVec3::splat(high) } };
        let dust = Grid::sampled(lattice([7, 5, 3], -1.0, 1.0), |p| 2.0 + p.x + p.y * p.z);
        let gas = [Grid::sampled(lattice([2; 3], -3.0, 1.5), |_| 1.0)];
        let all =
            |sigma: &[f32], lattice: &Lattice| sigma.iter().map(|s| f64::from(*s)).sum::<f64>() * lattice.voxel_pc().element_product();
        let truth = all(&dust.data, &dust.lattice);
        for (gas, most) in [(&[][..], 64), (&[][..], 3), (&[][..], 1), (&gas[..], 64), (&gas[..], 8), (&gas[..], 1)] {
            let cells = Cells::new(&dust, gas, most);
            let [x, y, z] = cells.lattice.dims;
            assert!(x.max(y).max(z) <= most.max(2), "{most}: {x} {y} {z}");
            let whole = gas.iter().map(|g| g.lattice.bounds).fold(dust.lattice.bounds, |a, b| a.union(&b));
            let margin = DVec3::splat(1e-9);
            assert!(cells.lattice.bounds.contains(whole.low + margin) && cells.lattice.bounds.contains(whole.high - margin));
            let own = all(&cells.sigma, &cells.lattice);
            assert!((own / truth - 1.0).abs() < 1e-5, "{most}: {own} {truth}");
        }
    }
}
