//! Grids of functions: sampled at the centres of voxels, or averaged over those in which they jump.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use spectra::fingerprint::{Digest, Fingerprint};

use super::Field;
use super::grid::Grid;
use super::lattice::Lattice;
use crate::blocks::Blocks;
use crate::cache::{Cache, Record};
use crate::control::Control;
use crate::error::Result;

/// Kind of stored grids.
const KIND: &str = "fields";
/// Number of records of grids in blocks.
const IN_BLOCKS: f64 = 1.0;
/// Grids of fewer voxels are not stored.
const SMALL: usize = 1 << 17;
/// Grids of more voxels are kept in blocks, of which many may be empty.
const LARGE: usize = 1 << 24;
/// Fewest voxels along each axis of such a grid: blocks reach beyond its edges.
const THICK: usize = 128;
/// Parts along each edge of a voxel in which a function jumps.
const PARTS: usize = 6;
/// By how much a function may change in a voxel that is taken for even.
const EVEN: f64 = 0.1;

impl Grid {
    /// Samples `f` at the voxel centres, on all cores.
    pub fn sampled(lattice: Lattice, f: impl Fn(DVec3) -> f64 + Sync) -> Self {
        Self::filled(lattice, |places, values| values.iter_mut().zip(places).for_each(|(value, p)| *value = f(*p)))
    }

    /// The grid of a cache, or a new one, which is stored; `content` is the fingerprint of its values. Small grids are made anew.
    ///
    /// # Errors
    /// Errors of `make`.
    pub fn stored(
        cache: Option<&dyn Cache>,
        content: impl FnOnce() -> Fingerprint,
        lattice: &Lattice,
        make: impl FnOnce() -> Result<Self>,
    ) -> Result<Self> {
        let Some(cache) = cache.filter(|_| lattice.cells() >= SMALL) else { return make() };
        let content = Digest::new("grid").part(content()).plain(lattice).finish();
        if let Some(Record { mut arrays, numbers, .. }) = cache.get(KIND, content)
            && let Some(values) = arrays.pop().filter(|values| values.len() == lattice.cells())
        {
            if numbers != [IN_BLOCKS] {
                return Ok(Self::sharing(lattice.clone(), values));
            }
            let [length, height, _] = lattice.dims;
            let row =
                |(): &mut (), [y, z]: [usize; 2], out: &mut [f32]| out.copy_from_slice(&values[(z * height + y) * length..][..length]);
            return Ok(Self::in_blocks(lattice.clone(), Blocks::made(lattice.dims, || (), row)));
        }
        let grid = make()?;
        let (numbers, values) = match grid.rows() {
            Some(values) => (Vec::new(), values),
            None => (vec![IN_BLOCKS], grid.values().into_owned().into()),
        };
        cache.put(KIND, content, &Record { numbers, arrays: vec![values], ..Record::default() });
        Ok(grid)
    }

    /// Samples a field times `factor`, with the means of voxels in which it jumps; from a cache if that has it.
    ///
    /// # Errors
    /// On interruption by the user.
    pub fn from_function(
        field: &Arc<dyn Field>,
        lattice: Lattice,
        factor: f64,
        cache: Option<&dyn Cache>,
        control: &Control,
    ) -> Result<Self> {
        let content = || Digest::new("samples").part(super::fingerprint(&**field)).number(factor).finish();
        Self::stored(cache, content, &lattice.clone(), || Self::of_samples(field, lattice, factor, control))
    }

    fn of_samples(field: &Arc<dyn Field>, lattice: Lattice, factor: f64, control: &Control) -> Result<Self> {
        let sample = |places: &[DVec3], values: &mut [f64]| {
            if control.interrupted() {
                return;
            }
            field.sample(places, values);
            values.iter_mut().for_each(|value| *value *= factor);
        };
        let grid = if field.has_edges() {
            Self::averaged(lattice, |_, places, values| sample(places, values))
        } else {
            Self::filled(lattice, sample)
        };
        control.check()?;
        Ok(grid)
    }

    /// Samples row by row at the voxel centres, on all cores: `sample` writes the values at many places.
    pub fn filled(lattice: Lattice, sample: impl Fn(&[DVec3], &mut [f64]) + Sync) -> Self {
        let [length, height, _] = lattice.dims;
        let room = || (vec![DVec3::ZERO; length], vec![0.0; length]);
        let row = |(centres, values): &mut (Vec<DVec3>, Vec<f64>), [y, z]: [usize; 2], out: &mut [f32]| {
            centres.iter_mut().enumerate().for_each(|(x, centre)| *centre = lattice.centre(x, y, z));
            sample(centres, values);
            out.iter_mut().zip(&*values).for_each(|(out, value)| *out = *value as f32);
        };
        if lattice.cells() > LARGE && lattice.dims.iter().all(|n| *n >= THICK) {
            let blocks = Blocks::made(lattice.dims, room, row);
            return Self::in_blocks(lattice, blocks);
        }
        let mut data = vec![0.0; lattice.cells()];
        let rows = data.par_chunks_mut(length).enumerate();
        rows.for_each_init(room, |room, (r, out)| row(room, [r % height, r / height], out));
        Self::from_lattice(lattice, data)
    }

    /// Samples a function that may jump: `sample` takes the centres of voxels and as many places within them. A voxel
    /// that it changes in has the mean over its parts, all others the value at their middle.
    pub(crate) fn averaged(lattice: Lattice, sample: impl Fn(&[DVec3], &[DVec3], &mut [f64]) + Sync) -> Self {
        let voxel = lattice.voxel_pc();
        let corners = (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) - 0.5);
        let corners: Vec<DVec3> = corners.map(|c| (1.0 - 1e-9) * c * voxel).collect();
        let along = |i: usize| (i as f64 + 0.5) / PARTS as f64 - 0.5;
        let part = |i: usize| DVec3::new(along(i % PARTS), along(i / PARTS % PARTS), along(i / (PARTS * PARTS))) * voxel;
        let parts: Vec<DVec3> = (0..PARTS.pow(3)).map(part).collect();
        Self::filled(lattice, |centres, values| {
            sample(centres, centres, values);
            let (mut low, mut high, mut means) = (values.to_vec(), values.to_vec(), values.to_vec());
            for corner in &corners {
                let places: Vec<DVec3> = centres.iter().map(|centre| *centre + *corner).collect();
                sample(centres, &places, &mut means);
                low.iter_mut().zip(&means).for_each(|(low, v)| *low = low.min(*v));
                high.iter_mut().zip(&means).for_each(|(high, v)| *high = high.max(*v));
            }
            for (i, value) in values.iter_mut().enumerate() {
                if high[i] - low[i] <= EVEN * high[i].abs().max(low[i].abs()) {
                    continue;
                }
                let mut of_parts = [0.0; PARTS.pow(3)];
                let places: Vec<DVec3> = parts.iter().map(|part| centres[i] + *part).collect();
                sample(&vec![centres[i]; places.len()], &places, &mut of_parts);
                *value = of_parts.iter().sum::<f64>() / of_parts.len() as f64;
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::MemoryCache;
    use crate::geometry::Bounds;

    /// A stored grid has the values and the blocks of the one that was made, and is made once.
    #[test]
    fn grids_come_back_as_they_were() {
        let lattice = Lattice { dims: [60, 52, 48], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let value = |[x, y, z]: [usize; 3]| if x > 20 && y < 30 { (x * 7 + y * 3 + z) as f32 } else { 0.0 };
        let rows = || Grid::from_lattice(lattice.clone(), (0..lattice.cells()).map(|i| value(lattice.place(i))).collect());
        let row =
            |(): &mut (), [y, z]: [usize; 2], out: &mut [f32]| out.iter_mut().enumerate().for_each(|(x, out)| *out = value([x, y, z]));
        let blocks = || Grid::in_blocks(lattice.clone(), Blocks::made(lattice.dims, || (), row));
        let cache = MemoryCache::default();
        let stored = |name: &str, make: &dyn Fn() -> Grid| {
            Grid::stored(Some(&cache), || Fingerprint::of_text(name), &lattice, || Ok(make())).unwrap()
        };
        for (name, make) in [("rows", &rows as &dyn Fn() -> Grid), ("blocks", &blocks)] {
            assert!(stored(name, make) == make());
            let again = stored(name, &|| panic!("made again"));
            assert!(again == make() && again.bytes() == make().bytes());
        }
        assert!(blocks().bytes() < rows().bytes() && blocks() != rows().scaled(2.0));
        let other = Lattice { bounds: Bounds::cube(DVec3::ZERO, 2.0), ..lattice.clone() };
        assert_eq!(cache.counts(), (2, 2));
        Grid::stored(Some(&cache), || Fingerprint::of_text("rows"), &other, || Ok(rows())).unwrap();
        assert_eq!(cache.counts(), (0, 1));
    }
}
