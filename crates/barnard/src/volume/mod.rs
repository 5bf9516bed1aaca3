//! Volumes: several scalar fields on one lattice, interleaved, so that one place is read together.
//!
//! A layer of voxels lies around the box: in its outermost half voxel a density is that of the border, but a star depth
//! goes on as it came, down to nothing on a face that the star shines on.

mod bricks;
mod pages;
mod planes;
mod values;

pub use bricks::Bricks;
pub use pages::{PAGE, Pages};
pub(crate) use planes::{PlanePart, ROWS_TOGETHER, VoxelPlane};
pub use values::Values;
pub(crate) use values::stored;

use std::borrow::Cow;

use glam::DVec3;
use rayon::prelude::*;

use crate::field::{Grid, Lattice, trilinear};
use crate::geometry::Bounds;
use crate::stored::{Half, Precision, Stored, unit};

/// Content of a volume channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Channel {
    /// Extinction σ at V [pc⁻¹].
    Dust,
    /// Optical depth at V from a star \[1\].
    StarDepth(usize),
    /// Density of a glowing species, in its own unit.
    Emission(usize),
    /// Values u of the [front](Grid::front) at which gas ends \[1\].
    Front,
    /// Light of all stars, in one element and polynomial.
    Light(usize),
    /// The source function towards the eye of one term [W m⁻² sr⁻¹]: light that was scattered before, and that of the
    /// gathered stars from afar.
    MultipleScattering(usize),
}

/// Fields on one lattice: depth × height × width × channels.
#[derive(Debug, Clone)]
pub struct Volume {
    /// The lattice of the voxels in the box; at least two along each axis.
    pub inner: Lattice,
    /// The lattice of those and the layer around them.
    pub lattice: Lattice,
    /// Content of each channel.
    pub channels: Vec<Channel>,
    /// Memory layout of the voxels.
    pub(crate) pages: Pages,
    /// The values, page by page: depth × height × width × channels, in parts of their channels' units.
    pub(crate) values: Values,
    /// The unit of each channel's values; one in single precision.
    pub(crate) units: Vec<f32>,
    /// Larger volume that contains it, if any.
    pub(crate) part: Option<VolumePart>,
}

/// Larger volume that contains a volume.
#[derive(Debug, Clone)]
pub(crate) struct VolumePart {
    /// The lattice of the whole's voxels and the layer around them.
    pub whole: Lattice,
    /// The voxel of the whole's box that is the part's first.
    pub first: [usize; 3],
}

/// A lattice of at least two voxels along each axis: trilinear between equals is the same.
fn doubled(lattice: &Lattice) -> Lattice {
    Lattice { dims: lattice.dims.map(|n| n.max(2)), bounds: lattice.bounds }
}

/// The lattice of a box's voxels and the layer around them.
fn with_layer(inner: &Lattice) -> Lattice {
    let voxel = inner.voxel_pc();
    let bounds = Bounds { low: inner.bounds.low - voxel, high: inner.bounds.high + voxel };
    Lattice { dims: inner.dims.map(|n| n + 2), bounds }
}

/// The voxels around a place, of which every channel can be read.
pub struct VolumeCell<'a> {
    volume: &'a Volume,
    /// The place of the lowest voxel's values.
    first: usize,
    /// From voxel to voxel along each axis.
    strides: [usize; 3],
    /// The part of the cell that lies before the place.
    fraction: DVec3,
}

impl VolumeCell<'_> {
    /// One channel, trilinear, in f64 arithmetic.
    #[inline]
    pub fn value(&self, channel: usize) -> f64 {
        let [dx, dy, dz] = self.strides;
        let corners = [0, dx, dy, dy + dx, dz, dz + dx, dz + dy, dz + dy + dx];
        let values = stored!(&self.volume.values, |data| {
            let cell = &data[self.first + channel..];
            corners.map(|at| f64::from(cell[at].value()))
        });
        trilinear(values, self.fraction) * f64::from(self.volume.units[channel])
    }
}

/// One channel of a volume that is written.
pub struct ChannelMut<'a> {
    /// The volume that is written.
    pub volume: &'a mut Volume,
    /// The channel's place among the others of a voxel.
    pub slot: usize,
}

/// Largest distance from a voxel's centre at which a place represents the voxel \[voxels\].
const ON_FACE: f64 = 1e-6;

/// More channels than this are put into another volume: the march reads them together.
pub const MAX_CHANNELS: usize = 8;

impl Volume {
    /// Room for `channels` on a lattice, all zero, in single precision. An axis of one voxel is doubled: trilinear
    /// between equals is the same.
    pub fn zeroed(lattice: &Lattice, channels: Vec<Channel>) -> Self {
        Self::with_precision(lattice, channels, Precision::Single)
    }

    /// Variant in any precision.
    pub fn with_precision(lattice: &Lattice, channels: Vec<Channel>, precision: Precision) -> Self {
        let pages = Pages::whole(with_layer(&doubled(lattice)).dims);
        Self::with_pages(lattice, channels, precision, pages)
    }

    /// Variant in some pages of the lattice that has the layer.
    pub(crate) fn with_pages(lattice: &Lattice, channels: Vec<Channel>, precision: Precision, pages: Pages) -> Self {
        let inner = doubled(lattice);
        let lattice = with_layer(&inner);
        let count = pages.voxels() * channels.len();
        let values = match precision {
            Precision::Single => Values::Single(vec![0.0; count]),
            Precision::Half => Values::Half(vec![Half::default(); count]),
        };
        Self { inner, lattice, units: vec![1.0; channels.len()], channels, pages, values, part: None }
    }

    /// The pages of a volume of this lattice in which one of some grids is not zero, or no farther than `margin_pc` from
    /// them along each axis.
    pub(crate) fn pages_with(lattice: &Lattice, grids: &[&Grid], margin_pc: f64) -> Pages {
        let layered = with_layer(&doubled(lattice));
        Pages::stored(layered.dims, |voxels| {
            let [low, high] = [voxels.each_ref().map(|v| v.start), voxels.map(|v| v.end - 1)].map(|[x, y, z]| layered.centre(x, y, z));
            grids.iter().any(|grid| grid.is_filled(low - margin_pc, high + margin_pc))
        })
    }

    /// Copy of the volume as a part of a whole, of which its first voxel is number `first` along each axis: places in it
    /// have the numbers that they have in the whole.
    #[must_use]
    pub(crate) fn part_of(self, whole: &Lattice, first: [usize; 3]) -> Self {
        Self { part: Some(VolumePart { whole: with_layer(&doubled(whole)), first }), ..self }
    }

    /// Storage precision of the values.
    pub fn precision(&self) -> Precision {
        match self.values {
            Values::Single(_) => Precision::Single,
            Values::Half(_) => Precision::Half,
        }
    }

    /// The values of a volume that was made in single precision, depth × height × width × channels.
    pub(crate) fn single(&self) -> &[f32] {
        match &self.values {
            Values::Single(data) => data,
            Values::Half(_) => unreachable!("the volume has half precision"),
        }
    }

    /// Variant for writing.
    pub(crate) fn single_mut(&mut self) -> &mut [f32] {
        match &mut self.values {
            Values::Single(data) => data,
            Values::Half(_) => unreachable!("the volume has half precision"),
        }
    }

    /// The values row by row along x, width × channels each, whatever they are stored as.
    pub fn rows(&self) -> impl Iterator<Item = Cow<'_, [f32]>> {
        let (channels, [nx, ny, nz]) = (self.channels.len(), self.lattice.dims);
        (0..ny * nz).map(move |row| {
            let voxel = |x: usize| self.pages.number([x, row % ny, row / ny]) * channels;
            match &self.values {
                Values::Single(data) if self.pages.is_whole() => Cow::Borrowed(&data[voxel(0)..][..nx * channels]),
                _ => (0..nx).flat_map(|x| (0..channels).map(move |slot| self.value(voxel(x), slot))).collect(),
            }
        })
    }

    /// One value, by its place among all.
    #[inline(always)]
    pub fn value(&self, place: usize, slot: usize) -> f32 {
        stored!(&self.values, |data| data[place + slot].value()) * self.units[slot]
    }

    /// The largest value of a channel, without its sign.
    pub fn largest(&self, slot: usize) -> f32 {
        let channels = self.channels.len();
        let parts =
            stored!(&self.values, |data| data.iter().skip(slot).step_by(channels).fold(0.0f32, |most, v| most.max(v.value().abs())));
        parts * self.units[slot]
    }

    /// Multiplies a channel.
    pub fn scale(&mut self, slot: usize, factor: f32) {
        let channels = self.channels.len();
        match &mut self.values {
            Values::Single(data) => data.iter_mut().skip(slot).step_by(channels).for_each(|value| *value *= factor),
            Values::Half(_) => self.units[slot] *= factor,
        }
    }

    /// Chooses the unit of a channel that is written next, by what will be its largest value.
    pub(crate) fn choose_unit(&mut self, slot: usize, largest: impl FnOnce() -> f32) {
        if self.precision() == Precision::Half {
            self.units[slot] = unit(largest());
        }
    }

    /// Position of channel 0 of a voxel of the box.
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        self.pages.number([x + 1, y + 1, z + 1]) * self.channels.len()
    }

    /// Copies a grid of the same box and resolution into channel `slot`; the layer around it is like the border.
    pub fn fill(&mut self, slot: usize, grid: &Grid) {
        let dims = grid.lattice().dims;
        let inside = |axis: usize, i: usize| i.saturating_sub(1).min(dims[axis] - 1);
        let channels = self.channels.len();
        self.choose_unit(slot, || grid.densest());
        let parts = self.units[slot].recip();
        let (pages, [nx, ny, _]) = (&self.pages, self.pages.side());
        stored!(&mut self.values, |data| pages.of(data, channels).for_each(|(first, page)| {
            page.par_chunks_exact_mut(nx * channels).enumerate().for_each_init(Vec::new, |buffer, (r, row)| {
                let along = inside(0, first[0])..inside(0, first[0] + nx - 1) + 1;
                buffer.resize(along.len(), 0.0);
                grid.row(along.clone(), inside(1, first[1] + r % ny), inside(2, first[2] + r / ny), buffer);
                for (x, values) in row.chunks_exact_mut(channels).enumerate() {
                    values[slot] = Stored::of(buffer[inside(0, first[0] + x) - along.start] * parts);
                }
            });
        }));
    }

    /// One channel at the place `p`, trilinear, in f64 arithmetic.
    pub fn at(&self, channel: usize, p: DVec3) -> f64 {
        self.cell(p).value(channel)
    }

    /// The voxels around the place `p`.
    pub fn cell(&self, p: DVec3) -> VolumeCell<'_> {
        let size = DVec3::from(self.lattice.dims.map(|n| n as f64));
        let u = (p - self.lattice.bounds.low) / self.lattice.bounds.size() * size - 0.5;
        let u = u.clamp(DVec3::ZERO, size - 1.0);
        // The conversion cuts fractions off.
        let mut cell: [usize; 3] = std::array::from_fn(|axis| (u[axis] as usize).min(self.lattice.dims[axis] - 2));
        if !self.pages.holds(cell) {
            cell = self.beside(cell, u).unwrap_or(cell);
        }
        let fraction = u - DVec3::from(cell.map(|i| i as f64));
        let channels = self.channels.len();
        let strides = self.pages.strides().map(|n| n * channels);
        VolumeCell { volume: self, first: self.pages.number(cell) * channels, strides, fraction }
    }

    /// A cell in a page that is held which meets `cell` at the place `u`, in voxels: on the face between two pages
    /// stands what either of them holds.
    fn beside(&self, cell: [usize; 3], u: DVec3) -> Option<[usize; 3]> {
        let near = |axis: usize| {
            let fraction = u[axis] - cell[axis] as f64;
            let before = (fraction < ON_FACE).then(|| cell[axis].checked_sub(1)).flatten();
            let behind = (fraction > 1.0 - ON_FACE && cell[axis] + 2 < self.lattice.dims[axis]).then_some(cell[axis] + 1);
            [Some(cell[axis]), before.or(behind)].into_iter().flatten()
        };
        let mut cells = near(2).flat_map(|z| near(1).flat_map(move |y| near(0).map(move |x| [x, y, z])));
        cells.find(|cell| self.pages.holds(*cell))
    }

    /// Memory layout of the voxels.
    pub fn pages(&self) -> &Pages {
        &self.pages
    }

    /// The values of a page by its number in memory: depth × height × width × channels.
    pub fn page(&self, number: usize) -> impl Iterator<Item = f32> + '_ {
        let size = self.channels.len() * self.pages.side().iter().product::<usize>();
        (number * size..(number + 1) * size)
            .map(|place| (place, place % self.channels.len()))
            .map(|(place, slot)| self.value(place - slot, slot))
    }

    /// Voxels that memory is taken for, in parts of those that there are \[1\]; more than one where those on faces of pages
    /// stand twice.
    pub fn stored_share(&self) -> f64 {
        self.pages.voxels() as f64 / self.lattice.cells() as f64
    }

    /// The bytes that the values take.
    pub fn bytes(&self) -> u64 {
        self.precision().bytes() * (self.pages.voxels() * self.channels.len()) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of halves are those of singles, each channel in its own unit.
    #[test]
    fn rows_are_read_in_their_units() {
        let lattice = Lattice { dims: [5, 3, 4], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let grids = [1e-9, 1.0, 3e7].map(|factor| Grid::sampled(lattice.clone(), |p| factor * (1.5 + p.x + 0.3 * p.y * p.z)));
        let filled = |precision| {
            let mut volume = Volume::with_precision(&lattice, (0..3).map(Channel::Emission).collect(), precision);
            grids.iter().enumerate().for_each(|(slot, grid)| volume.fill(slot, grid));
            volume.scale(1, 0.3);
            volume
        };
        let (single, half) = (filled(Precision::Single), filled(Precision::Half));
        assert_eq!(single.bytes(), 2 * half.bytes());
        let (a, b): (Vec<_>, Vec<_>) = (single.rows().collect(), half.rows().collect());
        let close = |a: &f32, b: &f32| (b / a - 1.0).abs() <= 2f32.powi(-11);
        assert!(a.len() == 5 * 6 && a.concat().iter().zip(&b.concat()).all(|(a, b)| close(a, b)) && a != b);
        assert!((0..3).all(|slot| close(&single.largest(slot), &half.largest(slot))));
    }
}
