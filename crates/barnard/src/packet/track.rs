//! Track of a packet's rays through a lattice.

use glam::DVec3;

use super::lane::{self, LANES, Lane, fma};
use crate::field::Lattice;
use crate::geometry::Ray;

/// PacketPlaces of a packet: the distance along each ray, and displacements from there, if any \[pc\].
#[derive(Clone, Copy)]
pub struct PacketPlaces<'a> {
    /// Distance along each ray.
    pub t: &'a Lane,
    /// Displacements along each axis.
    pub displaced: Option<&'a [Lane; 3]>,
}

impl<'a> PacketPlaces<'a> {
    /// PacketPlaces on the rays.
    pub fn on_rays(t: &'a Lane) -> Self {
        Self { t, displaced: None }
    }
}

/// u = origin + slope · t in cells of a lattice, axis × lane.
pub struct Track {
    origin: [Lane; 3],
    slope: [Lane; 3],
    /// Cells per parsec.
    per_pc: [f32; 3],
    part: Option<CellWindow>,
}

/// The cells of a lattice that are held, where not all are: places are those in the whole, so that a place has the same
/// numbers in any part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellWindow {
    /// Cells of the whole along each axis.
    pub whole: [usize; 3],
    /// The first that is held.
    pub first: [usize; 3],
}

impl Track {
    /// The track of `rays` through a lattice; distances are counted from `start` of each, cells from the lattice's
    /// corner plus `shift` of them.
    pub fn new(lattice: &Lattice, shift: DVec3, rays: &[Ray; LANES], start: &[f64; LANES]) -> Self {
        let per_pc = lattice.voxel_pc().recip();
        let cells_per_pc = per_pc.to_array().map(|number| number as f32);
        let mut track = Self { origin: [[0.0; LANES]; 3], slope: [[0.0; LANES]; 3], per_pc: cells_per_pc, part: None };
        for (lane, ray) in rays.iter().enumerate() {
            let u = (ray.at(start[lane]) - lattice.bounds.low) * per_pc - shift;
            let s = ray.direction * per_pc;
            for axis in 0..3 {
                track.origin[axis][lane] = u[axis] as f32;
                track.slope[axis][lane] = s[axis] as f32;
            }
        }
        track
    }

    /// Copy of the track where only some cells are held: cells are counted from the first of these.
    pub fn within(self, part: Option<CellWindow>) -> Self {
        Self { part, ..self }
    }

    /// Cell and place within it along each axis of `counts` cells, clamped to the borders.
    #[inline(always)]
    pub fn cells(&self, counts: [usize; 3], places: PacketPlaces) -> [([u32; LANES], Lane); 3] {
        let Some(part) = &self.part else { return self.axes(counts, places) };
        let mut cells = self.axes(part.whole, places);
        for (axis, (cell, _)) in cells.iter_mut().enumerate() {
            for lane in 0..LANES {
                cell[lane] = cell[lane].saturating_sub(part.first[axis] as u32).min(counts[axis] as u32 - 1);
            }
        }
        cells
    }

    /// Separation of the rays at a distance `t`, in cells summed over the axes.
    pub fn extent(&self, t: &Lane) -> f32 {
        let of_axis = |axis: usize| {
            let place = |lane: usize| fma(self.slope[axis][lane], t[lane], self.origin[axis][lane]);
            let (low, high) = (0..LANES).map(place).fold((f32::MAX, f32::MIN), |(low, high), u| (low.min(u), high.max(u)));
            high - low
        };
        (0..3).map(of_axis).sum()
    }

    /// The cell of one ray.
    #[inline(always)]
    pub fn cell_of(&self, lane: usize, counts: [usize; 3], t: f32) -> [usize; 3] {
        let cell = |axis: usize| fma(self.slope[axis][lane], t, self.origin[axis][lane]) as usize;
        std::array::from_fn(|axis| cell(axis).min(counts[axis] - 1))
    }

    /// All axes; a closure would stay a function of its own, without the processor's wide instructions.
    #[inline(always)]
    fn axes(&self, counts: [usize; 3], places: PacketPlaces) -> [([u32; LANES], Lane); 3] {
        [self.axis(0, counts[0], places), self.axis(1, counts[1], places), self.axis(2, counts[2], places)]
    }

    #[inline(always)]
    fn axis(&self, axis: usize, count: usize, places: PacketPlaces) -> ([u32; LANES], Lane) {
        let (mut cell, mut fraction) = ([0; LANES], [0.0; LANES]);
        let mut along = [0.0; LANES];
        for lane in 0..LANES {
            along[lane] = fma(self.slope[axis][lane], places.t[lane], self.origin[axis][lane]);
        }
        if let Some(displaced) = places.displaced {
            for lane in 0..LANES {
                along[lane] = fma(self.per_pc[axis], displaced[axis][lane], along[lane]);
            }
        }
        for (lane, u) in along.into_iter().enumerate() {
            let place = lane::place(u, count);
            (cell[lane], fraction[lane]) = (place.cell, place.fraction);
        }
        (cell, fraction)
    }
}
