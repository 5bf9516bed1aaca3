//! The source function of the solved terms towards one eye, in cells.

use glam::DVec3;
use rayon::prelude::*;

use super::lanes::{EightLanes, WIDTH};
use crate::field::Lattice;

/// Cells whose edges are not longer by more than this are as coarse.
const COARSER: f64 = 1.2;

/// S of the solved terms towards an eye, before sums of them are made.
#[derive(Debug, Clone)]
pub struct EyeSource {
    pub lattice: Lattice,
    /// Values of each cell, eight terms by eight.
    pub groups: Vec<Vec<EightLanes>>,
}

/// Two cells and the share of the second, for a place along an axis.
fn between(at: f64, cells: usize) -> (usize, usize, f32) {
    let at = at.clamp(0.0, (cells - 1) as f64);
    let first = (at as usize).min(cells.saturating_sub(2));
    (first, (first + 1).min(cells - 1), (at - first as f64) as f32)
}

/// Values of cells at a place, trilinear between the middles of cells and constant beyond the outermost.
pub fn trilinear(lattice: &Lattice, values: &[EightLanes], place: DVec3) -> EightLanes {
    let at = (place - lattice.bounds.low) / lattice.voxel_pc() - 0.5;
    let [(x0, x1, fx), (y0, y1, fy), (z0, z1, fz)] = [0, 1, 2].map(|axis| between(at[axis], lattice.dims[axis]));
    let row = |y, z| (&values[lattice.index(x0, y, z)], &values[lattice.index(x1, y, z)]);
    let mut sum = [0.0; WIDTH];
    for ((low, high), share) in
        [(row(y0, z0), (1.0 - fy) * (1.0 - fz)), (row(y1, z0), fy * (1.0 - fz)), (row(y0, z1), (1.0 - fy) * fz), (row(y1, z1), fy * fz)]
    {
        (0..WIDTH).for_each(|t| sum[t] += share * (low[t] + fx * (high[t] - low[t])));
    }
    sum
}

impl EyeSource {
    /// S of the terms of a group at a place.
    pub fn at(&self, group: usize, place: DVec3) -> EightLanes {
        trilinear(&self.lattice, &self.groups[group], place)
    }

    /// Limit of the source for cells of no size: errors fall with the first power of a cell's edge, so the difference from
    /// coarser cells is the error that is left; at most the source itself is added. The same where the other is not coarser.
    pub fn extrapolated(mut self, coarse: &Self) -> Self {
        let ratio = coarse.lattice.voxel_pc().max_element() / self.lattice.voxel_pc().max_element();
        if ratio < COARSER {
            return self;
        }
        let factor = (1.0 / (ratio - 1.0)).min(1.0) as f32;
        let lattice = &self.lattice;
        for (group, values) in self.groups.iter_mut().enumerate() {
            values.par_iter_mut().enumerate().for_each(|(cell, value)| {
                let [x, y, z] = lattice.place(cell);
                let before = coarse.at(group, lattice.centre(x, y, z));
                for t in 0..WIDTH {
                    let most = value[t].abs();
                    value[t] += (factor * (value[t] - before[t])).clamp(-most, most);
                }
            });
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Bounds;

    fn source(cells: usize, value: impl Fn(DVec3, f64) -> f64) -> EyeSource {
        let lattice = Lattice { dims: [cells, cells + 2, cells], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let edge = 2.0 / cells as f64;
        let of_cell = |cell: usize| {
            let [x, y, z] = lattice.place(cell);
            [value(lattice.centre(x, y, z), edge) as f32; WIDTH]
        };
        EyeSource { groups: vec![(0..lattice.cells()).map(of_cell).collect()], lattice }
    }

    /// An error that falls with the edge of a cell goes; sources that are no coarser change nothing, and none becomes negative.
    #[test]
    fn errors_of_cells_are_extrapolated() {
        let truth = |p: DVec3| 3.0 + p.x - 0.5 * p.y;
        let with_error = |p: DVec3, edge: f64| truth(p) * (1.0 - 0.8 * edge);
        let (fine, coarse) = (source(20, with_error), source(10, with_error));
        let place = DVec3::new(0.31, -0.17, 0.23);
        let error = |source: &EyeSource| (f64::from(source.at(0, place)[2]) / truth(place) - 1.0).abs();
        let extrapolated = fine.clone().extrapolated(&coarse);
        assert!(error(&fine) > 0.07 && error(&extrapolated) < 5e-3, "{} {}", error(&fine), error(&extrapolated));
        assert!(fine.clone().extrapolated(&fine).groups == fine.groups);
        let bright = source(10, |_, _| 100.0);
        assert!(fine.extrapolated(&bright).groups[0].iter().all(|value| value[0] >= 0.0));
    }
}
