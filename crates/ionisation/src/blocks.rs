//! Voxels merged in cubic blocks, for thin gas that needs no finer steps.

use rayon::prelude::*;

use crate::balance::Gas;
use crate::cloud::{Cloud, Settings, place_of};

/// Ratio of the largest to the smallest density of a block up to which one solution stands for all its voxels \[1\].
const EVEN: f32 = 8.0;

/// Blocks of the same number of voxels along each edge.
pub struct Blocks {
    /// Voxels along an edge.
    pub edge: usize,
    /// Blocks along x, y and z; those at the upper ends may be incomplete.
    pub dims: [usize; 3],
    /// Root mean square density of hydrogen nuclei: a block of this density recombines as its voxels do \[cm⁻³\].
    pub hydrogen: Vec<f32>,
    /// Mean density relative to that \[1\].
    means: Vec<f32>,
    /// Largest density relative to that, infinite where densities differ too much \[1\].
    contrasts: Vec<f32>,
}

impl Blocks {
    /// Merges the voxels of a cloud.
    pub fn new(cloud: &Cloud, edge: usize) -> Self {
        let dims = cloud.dims.map(|n| n.div_ceil(edge));
        let merged = |block: usize| {
            let [sum, squares, least, most] = voxels_of(cloud.dims, dims, edge, block)
                .map(|voxel| cloud.hydrogen[voxel])
                .fold([0.0, 0.0, f32::INFINITY, 0.0], |[sum, squares, least, most]: [f32; 4], n| {
                    [sum + n, squares + n * n, least.min(n), most.max(n)]
                });
            let count = voxels_of(cloud.dims, dims, edge, block).count() as f32;
            let root_mean_square = (squares / count).sqrt();
            let relative = |value: f32| if root_mean_square > 0.0 { value / root_mean_square } else { 1.0 };
            let contrast = if most <= EVEN * least { relative(most) } else { f32::INFINITY };
            (root_mean_square, (relative(sum / count), contrast))
        };
        let (hydrogen, (means, contrasts)) = (0..dims.iter().product()).into_par_iter().map(merged).unzip();
        Self { edge, dims, hydrogen, means, contrasts }
    }

    /// The blocks as voxels of a cloud.
    pub fn cloud<'a>(&'a self, voxels: &Cloud<'a>) -> Cloud<'a> {
        Cloud { dims: self.dims, voxel: voxels.voxel * self.edge as f64, hydrogen: &self.hydrogen, ..voxels.clone() }
    }

    /// The gas of a block, which absorbs as its voxels do.
    pub fn gas(&self, cloud: &Cloud, block: usize, settings: &Settings) -> Gas {
        let gas = cloud.gas(block, settings);
        Gas { dust_cm2: gas.dust_cm2 * f64::from(self.means[block]), ..gas }
    }

    /// The largest density relative to that of the block; `None` where voxels differ too much.
    pub fn contrast(&self, block: usize) -> Option<f64> {
        Some(f64::from(self.contrasts[block])).filter(|contrast| contrast.is_finite())
    }
}

/// The voxels of a block.
fn voxels_of(dims: [usize; 3], blocks: [usize; 3], edge: usize, block: usize) -> impl Iterator<Item = usize> {
    let place = place_of(blocks, block);
    let [x, y, z] = std::array::from_fn(|axis| place[axis] * edge..((place[axis] + 1) * edge).min(dims[axis]));
    z.flat_map(move |z| {
        let x = x.clone();
        y.clone().flat_map(move |y| x.clone().map(move |x| (z * dims[1] + y) * dims[0] + x))
    })
}
