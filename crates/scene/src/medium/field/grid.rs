//! Grids: values at voxel centres, trilinear between them, clamped in the outer half voxel, zero outside.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use rayon::prelude::*;

use spectra::fingerprint::{Digest, Fingerprint};

use super::Field;
use super::cells::Cell;
use super::front::voxel_shares;
use super::lattice::Lattice;
use super::store::Store;
use crate::blocks::{Blocks, Storage};
use crate::data::Shared;
use crate::error::{Error, Result};
use crate::geometry::{Bounds, Ray};

/// Largest distance from a voxel's centre at which a place represents the voxel [voxels].
const ON_CENTRE: f64 = 1e-9;
/// Values of a row that are read together.
const READ_TOGETHER: usize = 64;

/// Sampled values.
///
/// A grid is made by [`Grid::new`] of an array, or by [`Grid::sampled`] of a function.
#[derive(Debug, Clone)]
pub struct Grid {
    pub(crate) lattice: Lattice,
    /// The values in units of the factor; grids that differ by a factor alone share them.
    pub(super) store: Store,
    pub(super) factor: f64,
    /// u of the front at which the density ends, on the same voxels.
    front: Option<Arc<Grid>>,
    /// Fingerprint of the values, computed once for all clones.
    hash: Arc<OnceLock<Fingerprint>>,
}

impl PartialEq for Grid {
    fn eq(&self, other: &Self) -> bool {
        self.lattice == other.lattice && self.factor == other.factor && self.front == other.front && self.store == other.store
    }
}

impl Grid {
    /// An array of `dims` voxels along x, y and z that fill `bounds`; `data` has depth × height × width values, x
    /// running fastest [unit of the field].
    ///
    /// # Errors
    /// If the array has another length, the box no size, or a value is negative, NaN or infinite.
    pub fn new(dims: [usize; 3], bounds: Bounds, data: Vec<f32>) -> Result<Self> {
        let cells = dims.iter().try_fold(1usize, |n, edge| n.checked_mul(*edge)).filter(|n| *n > 0);
        if cells != Some(data.len()) {
            let [x, y, z] = dims;
            return Err(Error::mismatch("data of a grid", format!("{x} x {y} x {z} values, x fastest"), data.len()));
        }
        let grid = Self::from_lattice(Lattice { dims, bounds: bounds.checked()? }, data);
        grid.check("grid")?;
        Ok(grid)
    }

    /// A grid of values at the voxel centres of a lattice, x running fastest \[unit of the field\]; values are not checked.
    pub fn from_lattice(lattice: Lattice, data: Vec<f32>) -> Self {
        Self::sharing(lattice, data.into())
    }

    /// Variant in shared memory.
    pub(crate) fn sharing(lattice: Lattice, shared: Shared<f32>) -> Self {
        Self { store: Store::Rows(lattice.dims, shared), lattice, factor: 1.0, front: None, hash: Arc::default() }
    }

    /// Variant in blocks.
    pub(crate) fn in_blocks(lattice: Lattice, blocks: Blocks) -> Self {
        Self { lattice, store: Store::Blocks(Arc::new(blocks)), factor: 1.0, front: None, hash: Arc::default() }
    }

    /// This grid times `factor`, in the same memory.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { factor: self.factor * factor, ..self.clone() }
    }

    /// Copy of the grid that ends at a front on the same voxels.
    pub(crate) fn with_front(self, front: Arc<Self>) -> Self {
        Self { front: Some(front), ..self }
    }

    /// Copy of the grid that ends where another one on the same voxels does.
    pub(crate) fn with_front_of(self, other: &Self) -> Self {
        Self { front: other.front.clone(), ..self }
    }

    /// Values u of the front at which the density ends \[1\]: the density is that of the [values](Self::values) times
    /// min(max(u, 0), 1). `None` for a grid without a front.
    pub fn front(&self) -> Option<&Grid> {
        self.front.as_deref()
    }

    /// Grid of the mean densities of the voxels, without a front.
    pub fn voxel_means(&self) -> Self {
        let Some(front) = &self.front else { return self.clone() };
        let means =
            self.values().par_iter().zip(voxel_shares(front.lattice.dims, &front.values())).map(|(value, share)| value * share).collect();
        Self::from_lattice(self.lattice.clone(), means)
    }

    /// True if another grid has its values in the same memory.
    pub fn shares(&self, other: &Self) -> bool {
        self.store.is(&other.store)
    }

    /// Memory of the values \[bytes\].
    pub fn bytes(&self) -> u64 {
        self.store.bytes()
    }

    /// Storage precision of the values.
    pub(crate) fn storage(&self) -> Storage {
        self.store.storage()
    }

    /// Value of a voxel \[unit of the field\].
    pub fn value(&self, voxel: [usize; 3]) -> f32 {
        let sides = std::array::from_fn(|axis| [self.store.address(axis, voxel[axis]); 2]);
        (self.store.corners(sides)[0] * self.factor) as f32
    }

    /// Writes the values of some voxels of a row along x into as many of `out` \[unit of the field\].
    ///
    /// # Panics
    /// Where there are no such voxels, or `out` has another length.
    #[inline]
    pub fn row(&self, along: Range<usize>, y: usize, z: usize, out: &mut [f32]) {
        self.store.row(along, y, z, out);
        if self.factor != 1.0 {
            out.iter_mut().for_each(|v| *v = (f64::from(*v) * self.factor) as f32);
        }
    }

    /// The largest of the values of some voxels along x, y and z \[unit of the field\]; zero where all are less.
    pub fn largest(&self, voxels: [Range<usize>; 3]) -> f32 {
        (f64::from(self.store.largest(voxels)) * self.factor) as f32
    }

    /// Largest value of the grid \[unit of the field\].
    pub fn densest(&self) -> f32 {
        let [nx, ny, nz] = self.lattice.dims;
        (0..nz).into_par_iter().map(|z| self.largest([0..nx, 0..ny, z..z + 1])).reduce(|| 0.0, f32::max)
    }

    /// True if the field exceeds zero within a box \[pc\] or less than a voxel outside it.
    pub fn is_filled(&self, low: DVec3, high: DVec3) -> bool {
        let Lattice { dims, .. } = self.lattice;
        let (low, high) = ((self.lattice.index_space(low) + ON_CENTRE).floor(), (self.lattice.index_space(high) - ON_CENTRE).ceil());
        // Conversions make zero of what is negative.
        let along = |axis: usize| (low[axis] as usize).min(dims[axis] - 1)..(high[axis] as usize).min(dims[axis] - 1) + 1;
        along(2).any(|z| self.largest([along(0), along(1), z..z + 1]) > 0.0)
    }

    /// Positions of the voxels.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The values, depth × height × width, x running fastest \[unit of the field\].
    pub fn values(&self) -> Cow<'_, [f32]> {
        match &self.store {
            Store::Rows(_, values) if self.factor == 1.0 => Cow::Borrowed(values),
            _ => {
                let [nx, ny, _] = self.lattice.dims;
                let mut values = vec![0.0; self.lattice.cells()];
                values.par_chunks_exact_mut(nx).enumerate().for_each(|(r, out)| self.row(0..nx, r % ny, r / ny, out));
                Cow::Owned(values)
            }
        }
    }

    /// The values in the grid's own memory, if they are there in rows and in its unit.
    pub(super) fn rows(&self) -> Option<Shared<f32>> {
        match &self.store {
            Store::Rows(_, values) if self.factor == 1.0 => Some(values.clone()),
            _ => None,
        }
    }

    /// `factor` times the means of blocks of `block` voxels along each axis; blocks at the upper faces take what is
    /// left.
    ///
    /// The box grows to whole blocks, so that densities stay where they are.
    pub fn merged(&self, block: usize, factor: f64) -> Self {
        if self.front.is_some() {
            return self.voxel_means().merged(block, factor);
        }
        let fine_dims = self.lattice.dims;
        let dims = fine_dims.map(|n| n.div_ceil(block));
        let voxel = self.lattice.voxel_pc() * block as f64;
        let low = self.lattice.bounds.low;
        let bounds = Bounds { low, high: low + voxel * DVec3::from(dims.map(|n| n as f64)) };
        let lattice = Lattice { dims, bounds };
        let share = self.factor * factor / block.pow(3) as f64;
        let means = |row: &mut Vec<f32>, (r, out): (usize, &mut [f32])| {
            let along = |axis: usize, i: usize| i * block..((i + 1) * block).min(fine_dims[axis]);
            let (y, z) = (r % dims[1], r / dims[1]);
            let mut sums = vec![0.0; dims[0]];
            row.resize(fine_dims[0], 0.0);
            for (y, z) in along(2, z).flat_map(|z| along(1, y).map(move |y| (y, z))) {
                self.store.row(0..fine_dims[0], y, z, row);
                sums.iter_mut().zip(row.chunks(block)).for_each(|(sum, part)| *sum += part.iter().map(|v| f64::from(*v)).sum::<f64>());
            }
            out.iter_mut().zip(sums).for_each(|(out, sum)| *out = (share * sum) as f32);
        };
        let mut data = vec![0.0; lattice.cells()];
        data.par_chunks_exact_mut(dims[0]).enumerate().for_each_init(Vec::new, means);
        Self::from_lattice(lattice, data)
    }

    /// The first of the voxels at some places, where these are the centres of voxels side by side along x.
    fn row_at(&self, places: &[DVec3]) -> Option<[usize; 3]> {
        let Lattice { dims, bounds } = &self.lattice;
        let first = self.lattice.index_space(*places.first()?);
        let voxel = first.round();
        let last = voxel + DVec3::new((places.len() - 1) as f64, 0.0, 0.0);
        let dims = DVec3::from(dims.map(|n| n as f64));
        if (first - voxel).abs().max_element() > ON_CENTRE || voxel.min_element() < 0.0 || last.cmpge(dims).any() {
            return None;
        }
        let (edge, margin) = (self.lattice.voxel_pc(), ON_CENTRE * self.lattice.voxel_pc());
        let origin = bounds.low + (voxel + 0.5) * edge;
        let on_centre = |(i, p): (usize, &DVec3)| (*p - origin - DVec3::new(i as f64 * edge.x, 0.0, 0.0)).abs().cmple(margin).all();
        places.iter().enumerate().all(on_centre).then(|| voxel.to_array().map(|i| i as usize))
    }

    /// Trilinear value at a place in index space, clamped to the border.
    fn trilinear(&self, u: DVec3) -> f64 {
        let dims = self.lattice.dims;
        let u = u.clamp(DVec3::ZERO, DVec3::from(dims.map(|n| (n - 1) as f64)));
        // The conversion cuts fractions off.
        let [x, y, z] = std::array::from_fn(|axis| (u[axis] as usize).min(dims[axis].saturating_sub(2)));
        let sides = |axis: usize, i: usize| [i, (i + 1).min(dims[axis] - 1)].map(|i| self.store.address(axis, i));
        self.factor * Cell::read(&self.store, DVec3::new(x as f64, y as f64, z as f64), [sides(0, x), sides(1, y), sides(2, z)]).at(u)
    }
}

impl Field for Grid {
    fn content(&self, digest: &mut Digest) {
        digest.text("grid").plain(&self.lattice).number(self.factor).part(*self.hash.get_or_init(|| self.store.hashed(self.lattice.dims)));
        if let Some(front) = self.front() {
            front.content(digest.text("front"));
        }
    }
    fn at(&self, p: DVec3) -> f64 {
        if !self.lattice.bounds.contains(p) {
            return 0.0;
        }
        let place = self.lattice.index_space(p);
        let share = self.front().map_or(1.0, |front| front.trilinear(place).clamp(0.0, 1.0));
        if share > 0.0 { share * self.trilinear(place) } else { 0.0 }
    }
    fn sample(&self, places: &[DVec3], values: &mut [f64]) {
        if let Some([x, y, z]) = self.row_at(places) {
            let mut part = [0.0; READ_TOGETHER];
            for (i, values) in values.chunks_mut(READ_TOGETHER).enumerate() {
                let (first, part) = (x + i * READ_TOGETHER, &mut part[..values.len()]);
                self.store.row(first..first + part.len(), y, z, part);
                values.iter_mut().zip(&*part).for_each(|(value, stored)| *value = f64::from(*stored) * self.factor);
                if let Some(front) = self.front() {
                    front.store.row(first..first + part.len(), y, z, part);
                    values.iter_mut().zip(part).for_each(|(value, u)| *value *= f64::from(*u).clamp(0.0, 1.0));
                }
            }
            return;
        }
        // One place many times is read once.
        match places.split_first() {
            Some((first, rest)) if rest.iter().all(|p| p == first) => values.fill(self.at(*first)),
            _ => values.iter_mut().zip(places).for_each(|(value, p)| *value = self.at(*p)),
        }
    }
    fn bounds(&self) -> Bounds {
        self.lattice.bounds
    }
    fn grid(&self) -> Option<&Grid> {
        Some(self)
    }
    fn feature_pc(&self) -> f64 {
        self.lattice.voxel_pc().min_element()
    }
    /// The planes through the voxel centres.
    fn crossings(&self, ray: &Ray, out: &mut Vec<f64>) {
        let Some((near, far)) = self.lattice.bounds.clip(ray) else { return };
        out.extend([near, far]);
        let origin = self.lattice.index_space(ray.origin);
        let slope = ray.direction / self.lattice.voxel_pc();
        for axis in 0..3 {
            if slope[axis] == 0.0 {
                continue;
            }
            let u = |t: f64| origin[axis] + t * slope[axis];
            let last = (self.lattice.dims[axis] - 1) as f64;
            let (low, high) = (u(near).min(u(far)).max(0.0).ceil(), u(near).max(u(far)).min(last).floor());
            let mut plane = low;
            while plane <= high {
                out.push((plane - origin[axis]) / slope[axis]);
                plane += 1.0;
            }
        }
    }
}

/// A linear function on a small grid, for tests.
#[cfg(test)]
pub(super) fn linear() -> Grid {
    let lattice = Lattice { dims: [8, 6, 4], bounds: Bounds { low: DVec3::new(-2.0, -1.0, 0.0), high: DVec3::new(2.0, 2.0, 1.0) } };
    Grid::sampled(lattice, |p| 10.0 + p.x + 2.0 * p.y + 4.0 * p.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trilinear_reproduces_linear_functions() {
        let grid = linear();
        let p = DVec3::new(0.3, 0.7, 0.4);
        assert!((grid.at(p) - (10.0 + 0.3 + 1.4 + 1.6)).abs() < 1e-5);
        assert_eq!(grid.at(DVec3::new(5.0, 0.0, 0.0)), 0.0);
        // The outer half voxel has the border's value.
        assert!((grid.at(DVec3::new(-2.0, 0.5, 0.5)) - grid.at(DVec3::new(-1.75, 0.5, 0.5))).abs() < 1e-5);
    }

    /// Rows of voxel centres, and places that are none, side by side as one by one.
    #[test]
    fn samples_are_the_values_themselves() {
        let grid = linear();
        let row: Vec<DVec3> = (2..7).map(|x| grid.lattice.centre(x, 3, 1)).collect();
        let (mut moved, mut beyond) = (row.clone(), row.clone());
        moved[3].y += 0.2;
        beyond.push(grid.lattice.centre(7, 3, 1));
        beyond.push(grid.lattice.centre(8, 3, 1));
        assert!(grid.row_at(&row).is_some() && grid.row_at(&moved).is_none() && grid.row_at(&beyond).is_none());
        for places in [row, moved, beyond] {
            let mut values = vec![f64::NAN; places.len()];
            grid.sample(&places, &mut values);
            assert!(places.iter().zip(&values).all(|(p, value)| (grid.at(*p) - value).abs() < 1e-12), "{values:?}");
        }
    }

    /// A grid and a multiple of it share their memory, and nothing else is alike: what one reads is the other's, times
    /// the factor.
    #[test]
    fn multiples_share_their_values() {
        let grid = linear();
        let double = grid.scaled(0.5).scaled(4.0);
        assert!(double.shares(&grid) && double != grid && double.values()[7] == 2.0 * grid.values()[7]);
        let (a, b) = (DVec3::new(0.1, -0.2, 0.3), DVec3::new(-0.4, 0.7, 0.1));
        let close = |found: f64, other: f64| (found / (2.0 * other) - 1.0).abs() < 1e-14;
        assert!(close(double.at(a), grid.at(a)) && close(double.column(a, b, f64::INFINITY), grid.column(a, b, f64::INFINITY)));
        let (enough, whole) = (0.5 * double.column(a, b, f64::INFINITY), double.column(a, b, f64::INFINITY));
        assert!((enough..whole).contains(&double.column(a, b, enough)));
        let centres: Vec<DVec3> = (0..2).map(|x| grid.lattice.centre(x, 1, 1)).collect();
        let (mut means, mut other) = ([0.0; 2], [0.0; 2]);
        double.sample(&centres, &mut means);
        grid.sample(&centres, &mut other);
        assert!(means[1] == 2.0 * other[1] && close(double.merged(2, 1.0).at(a), grid.merged(2, 1.0).at(a)));
    }

    /// Merged voxels hold as much as those they are made of, where they were, and blocks at the edge count what is
    /// missing as nothing.
    #[test]
    fn voxels_are_merged() {
        let lattice = Lattice { dims: [5, 4, 6], bounds: Bounds { low: DVec3::ZERO, high: DVec3::new(5.0, 4.0, 6.0) } };
        let grid = Grid::sampled(lattice, |p| 1.0 + p.x + 10.0 * p.y * p.z);
        let merged = grid.merged(2, 3.0);
        assert_eq!(merged.lattice.dims, [3, 2, 3]);
        assert_eq!(merged.lattice.bounds.high, DVec3::new(6.0, 4.0, 6.0));
        let sum = |g: &Grid| g.values().iter().map(|v| f64::from(*v)).sum::<f64>() * g.lattice.voxel_pc().element_product();
        assert!((sum(&merged) / (3.0 * sum(&grid)) - 1.0).abs() < 1e-6);
        let corner =
            [0.5, 1.5].into_iter().flat_map(|x| [0.5, 1.5].into_iter().flat_map(move |y| [0.5, 1.5].map(|z| 1.0 + x + 10.0 * y * z)));
        assert!((f64::from(merged.values()[0]) - 3.0 * corner.sum::<f64>() / 8.0).abs() < 1e-4);
    }
}
