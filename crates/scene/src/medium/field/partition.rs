//! Lattices that are cut into bricks.

use std::ops::Range;

use super::lattice::Lattice;
use crate::error::{Error, Result};

/// A lattice, and the voxels at which it is cut into bricks.
#[derive(Debug, Clone, PartialEq)]
pub struct Partition {
    lattice: Lattice,
    /// Along each axis: where bricks begin, and the end of the last.
    cuts: [Vec<usize>; 3],
}

impl Partition {
    /// Cuts a lattice at some voxels along x, y and z, from the first to behind the last.
    ///
    /// # Errors
    /// If the cuts do not run so, the lattice has no voxels, or its box no size.
    pub fn new(lattice: Lattice, cuts: [Vec<usize>; 3]) -> Result<Self> {
        lattice.bounds.checked()?;
        for (axis, cuts) in cuts.iter().enumerate() {
            let grows = cuts.windows(2).all(|pair| pair[0] < pair[1]);
            if !grows || cuts.len() < 2 || cuts.first() != Some(&0) || cuts.last() != Some(&lattice.dims[axis]) {
                let expected = format!("ascending voxels from 0 to {}", lattice.dims[axis]);
                return Err(Error::mismatch("cuts of a volume", expected, format!("{cuts:?}")));
            }
        }
        Ok(Self { lattice, cuts })
    }

    /// All of the lattice.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Bricks along an axis.
    pub fn count(&self, axis: usize) -> usize {
        self.cuts[axis].len() - 1
    }

    /// The voxels of a brick along an axis; fewer for the last.
    pub fn range(&self, axis: usize, brick: usize) -> Range<usize> {
        let brick = brick.min(self.count(axis) - 1);
        self.cuts[axis][brick]..self.cuts[axis][brick + 1]
    }

    /// The voxels of a brick along x, y and z.
    pub fn voxels(&self, place: [usize; 3]) -> [Range<usize>; 3] {
        [0, 1, 2].map(|axis| self.range(axis, place[axis]))
    }

    /// The numbers of all bricks along x, y and z, x running fastest.
    pub fn bricks(&self) -> Vec<[usize; 3]> {
        let planes = (0..self.count(2)).flat_map(|z| (0..self.count(1)).map(move |y| (y, z)));
        planes.flat_map(|(y, z)| (0..self.count(0)).map(move |x| [x, y, z])).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::Bounds;

    /// Cuts that are none are refused, and bricks hold every voxel once.
    #[test]
    fn cuts_run_from_end_to_end() {
        let lattice = Lattice { dims: [8, 5, 8], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        for wrong in [vec![], vec![0], vec![8], vec![0, 4], vec![1, 8], vec![0, 5, 5, 8], vec![0, 9]] {
            assert!(Partition::new(lattice.clone(), [vec![0, 8], vec![0, 5], wrong.clone()]).is_err(), "{wrong:?}");
        }
        let partition = Partition::new(lattice, [vec![0, 3, 8], vec![0, 5], vec![0, 1, 2, 8]]).unwrap();
        let cells = partition.bricks().into_iter().map(|place| partition.voxels(place).iter().map(|range| range.len()).product::<usize>());
        assert_eq!(cells.sum::<usize>(), 8 * 5 * 8);
        assert_eq!(partition.voxels([1, 0, 2]), [3..8, 0..5, 2..8]);
    }
}
