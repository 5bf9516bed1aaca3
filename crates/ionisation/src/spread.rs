//! Quantities of voxels from the sums of beams over voxels and over blocks.

use rayon::prelude::*;

use crate::blocks::Blocks;
use crate::cloud::{Cloud, place_of};
use crate::tally::{CellMeans, Tally};

/// Number of a block that no beam has met.
const UNMET: u32 = u32::MAX;

/// The quantities in the blocks of one size that beams have met: each is proportional to a power of the density of hydrogen.
struct BlockMeans<'a> {
    blocks: &'a Blocks,
    quantities: usize,
    /// By block its number among those that beams have met.
    numbers: Vec<u32>,
    /// By number the fraction of the block's volume that beams have crossed \[1\], and ln of its density.
    met: Vec<[f32; 2]>,
    /// By number and quantity, for the square of the density \[most cm⁶\], and exponents beyond that square.
    for_square: Vec<f32>,
    exponents: Vec<f32>,
}

/// Blocks around a voxel.
struct Around {
    /// Fraction of the volume of the voxel's block that beams have crossed \[1\].
    volume: f32,
    /// Their numbers and weights.
    blocks: [(usize, f32); 8],
    /// Mean of ln of their densities.
    ln_hydrogen: f32,
}

impl<'a> BlockMeans<'a> {
    fn new(tally: &Tally, (level, blocks): (usize, &'a Blocks)) -> Self {
        let cells: Vec<Option<CellMeans>> = (0..blocks.hydrogen.len())
            .into_par_iter()
            .map(|block| tally.means(level, place_of(blocks.dims, block)).filter(|_| blocks.hydrogen[block] > 0.0))
            .collect();
        let met: Vec<(f32, &CellMeans)> = blocks.hydrogen.iter().zip(&cells).filter_map(|(n, cell)| Some((*n, cell.as_ref()?))).collect();
        let mut count = 0;
        let mut number = |cell: &Option<CellMeans>| {
            count += u32::from(cell.is_some());
            if cell.is_some() { count - 1 } else { UNMET }
        };
        let quantities = tally.quantities().len();
        let of_each = |value: &(dyn Fn(f32, &CellMeans, usize) -> f32 + Sync)| -> Vec<f32> {
            met.par_iter().flat_map_iter(|(n, means)| (0..quantities).map(|quantity| value(*n, means, quantity))).collect()
        };
        Self {
            blocks,
            quantities,
            numbers: cells.iter().map(&mut number).collect(),
            met: met.iter().map(|(n, means)| [means.volume as f32, n.ln()]).collect(),
            for_square: of_each(&|n, means, quantity| (means.mean(quantity) / f64::from(n).powi(2)) as f32),
            exponents: of_each(&|_, means, quantity| means.exponent(quantity) as f32 - 2.0),
        }
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> Option<usize> {
        let [nx, ny, _] = self.blocks.dims;
        Some(self.numbers[(z * ny + y) * nx + x]).filter(|number| *number != UNMET).map(|number| number as usize)
    }

    /// The blocks around a voxel with weights linear between their middles; those that no beam has met are replaced by its own.
    fn around(&self, voxel: [usize; 3]) -> Option<Around> {
        let Blocks { edge, dims, .. } = self.blocks;
        let block = voxel.map(|place| place / edge);
        let here = self.number(block)?;
        let beside: [[(Option<usize>, f32); 2]; 3] = std::array::from_fn(|axis| {
            let offset = ((voxel[axis] % edge) as f32 + 0.5) / *edge as f32 - 0.5;
            let next = if offset < 0.0 { block[axis].checked_sub(1) } else { Some(block[axis] + 1).filter(|place| *place < dims[axis]) };
            [(Some(block[axis]), 1.0 - offset.abs()), (next, offset.abs())]
        });
        let blocks: [(usize, f32); 8] = std::array::from_fn(|corner| {
            let [(x, a), (y, b), (z, c)] = [beside[0][corner & 1], beside[1][corner >> 1 & 1], beside[2][corner >> 2]];
            let place = x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]);
            (place.and_then(|place| self.number(place)).unwrap_or(here), a * b * c)
        });
        let ln_hydrogen = blocks.iter().map(|(number, weight)| weight * self.met[*number][1]).sum();
        Some(Around { volume: self.met[here][0], blocks, ln_hydrogen })
    }

    /// Adds the quantities of a voxel with a density, weighted by volume.
    fn add(&self, around: &Around, hydrogen: f32, sums: &mut [f32]) {
        let (denser, weight) = (hydrogen.ln() - around.ln_hydrogen, around.volume * hydrogen * hydrogen);
        for (quantity, sum) in sums.iter_mut().enumerate() {
            let (mut for_square, mut exponent) = (0.0, 0.0);
            for (number, part) in around.blocks {
                let place = number * self.quantities + quantity;
                for_square += part * self.for_square[place];
                exponent += part * self.exponents[place];
            }
            *sum += weight * for_square * (exponent * denser).exp();
        }
    }
}

/// By quantity its mean in each voxel, weighted by the volume that beams have crossed in the voxel and in its blocks.
pub fn spread(cloud: &Cloud, blocks: &[Blocks], tally: &Tally) -> Vec<Vec<f32>> {
    let nx = cloud.dims[0];
    let levels: Vec<BlockMeans> = blocks.iter().enumerate().map(|(level, blocks)| BlockMeans::new(tally, (level + 1, blocks))).collect();
    let mut found: Vec<Vec<f32>> = tally.quantities().iter().map(|_| vec![0.0; cloud.hydrogen.len()]).collect();
    let mut rows: Vec<Vec<&mut [f32]>> = (0..cloud.hydrogen.len() / nx).map(|_| Vec::new()).collect();
    found.iter_mut().for_each(|values| rows.iter_mut().zip(values.chunks_exact_mut(nx)).for_each(|(rows, row)| rows.push(row)));
    rows.par_iter_mut().enumerate().for_each(|(row, values)| {
        let mut sums = vec![0.0; values.len()];
        for x in 0..nx {
            let (place, hydrogen) = (place_of(cloud.dims, row * nx + x), cloud.hydrogen[row * nx + x]);
            let mut volume = 0.0;
            sums.fill(0.0);
            if let Some(means) = tally.means(0, place) {
                volume += means.volume as f32;
                sums.iter_mut().enumerate().for_each(|(quantity, sum)| *sum += (means.volume * means.mean(quantity)) as f32);
            }
            for level in &levels {
                if let Some(around) = level.around(place) {
                    volume += around.volume;
                    level.add(&around, hydrogen, &mut sums);
                }
            }
            if volume > 0.0 {
                let most = tally.quantities().iter().map(|quantity| quantity.most);
                values
                    .iter_mut()
                    .zip(&sums)
                    .zip(most)
                    .for_each(|((values, sum), most)| values[x] = (most * f64::from(sum / volume)) as f32);
            }
        }
    });
    found
}
