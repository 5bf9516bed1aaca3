//! Planes of a volume across any of its axes, read and written.

use std::ops::Range;

use rayon::prelude::*;

use super::Volume;
use super::stored;
use crate::stored::Stored;

/// The fewest rows that a thread takes.
pub(crate) const ROWS_TOGETHER: usize = 8;

/// A plane of a volume's voxels, those of the layer around the box counted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VoxelPlane {
    /// The axes along the plane, the faster one in memory first, and the one across it.
    pub axes: [usize; 3],
    /// The place along the last.
    pub at: usize,
}

/// A part of a plane.
#[derive(Debug, Clone)]
pub(crate) struct PlanePart {
    /// The place along the axis across it.
    pub at: usize,
    /// The voxels along its faster axis.
    pub columns: Range<usize>,
    /// The voxels along its slower axis.
    pub rows: Range<usize>,
}

impl VoxelPlane {
    /// The voxel at a place in the plane.
    fn voxel(&self, u: usize, v: usize) -> [usize; 3] {
        let mut voxel = [self.at; 3];
        (voxel[self.axes[0]], voxel[self.axes[1]]) = (u, v);
        voxel
    }
}

impl Volume {
    /// The values of a channel on a plane, v × u, in parts of the channel's unit; NaN in pages that are not held.
    pub(crate) fn plane(&self, slot: usize, plane: VoxelPlane, out: &mut Vec<f32>) {
        let [width, height] = [0, 1].map(|i| self.lattice.dims[plane.axes[i]]);
        let channels = self.channels.len();
        let (side, stride) = (self.pages.side()[plane.axes[0]], self.pages.strides()[plane.axes[0]] * channels);
        out.resize(width * height, 0.0);
        out.par_chunks_exact_mut(width).enumerate().with_min_len(ROWS_TOGETHER).for_each(|(v, line)| {
            if !self.pages.is_whole() {
                line.fill(f32::NAN);
            }
            for (first, number) in self.pages.along(plane.axes[0], plane.voxel(0, v)) {
                let line = line[first..].iter_mut().take(side);
                let from = number * channels + slot;
                stored!(&self.values, |data| line.zip(data[from..].iter().step_by(stride)).for_each(|(value, v)| *value = v.value()));
            }
        });
    }

    /// The largest value of a channel at those voxels of a row of the box that are `wanted`; zero where all are less.
    pub(crate) fn largest_in_row(&self, slot: usize, [y, z]: [usize; 2], wanted: impl Fn(usize) -> bool) -> f32 {
        let (channels, [side, ..]) = (self.channels.len(), self.pages.side());
        let mut largest = 0.0f32;
        // The layer around the box is before its first voxel and behind its last.
        for (first, number) in self.pages.along(0, [0, y + 1, z + 1]) {
            let places = (first..first + side).zip((number * channels + slot..).step_by(channels));
            let inside = places.filter(|(x, _)| (1..=self.inner.dims[0]).contains(x) && wanted(x - 1));
            largest = stored!(&self.values, |data| inside.fold(largest, |most, (_, place)| most.max(data[place].value())));
        }
        largest * self.units[slot]
    }

    /// Writes a channel on a part of a plane, columns and rows, in parts of the channel's unit; what lies in no page that
    /// is held is lost.
    pub(crate) fn put_plane(
        &mut self,
        slot: usize,
        plane: VoxelPlane,
        [columns, rows]: [Range<usize>; 2],
        value: impl Fn(usize, usize) -> f32 + Sync,
    ) {
        self.put_planes(slot, plane.axes, &[PlanePart { at: plane.at, columns, rows }], |_, u, v| value(u, v));
    }

    /// Variant of several planes; they are all across x where there are more than one, since a line of memory has some
    /// of each then.
    pub(crate) fn put_planes(
        &mut self,
        slot: usize,
        axes: [usize; 3],
        planes: &[PlanePart],
        value: impl Fn(usize, usize, usize) -> f32 + Sync,
    ) {
        assert!(planes.len() < 2 || axes[2] == 0);
        let channels = self.channels.len();
        let side = axes.map(|axis| self.pages.side()[axis]);
        let [du, dv, dw] = axes.map(|axis| self.pages.strides()[axis] * channels);
        let pages = &self.pages;
        stored!(&mut self.values, |data| {
            pages.of(data, channels).for_each(|(first, page)| {
                let first = axes.map(|axis| first[axis]);
                let local = |i: usize, range: &Range<usize>| {
                    let within = |at: usize| at.clamp(first[i], first[i] + side[i]) - first[i];
                    within(range.start)..within(range.end)
                };
                let part = |(number, plane): (usize, &PlanePart)| {
                    let touched = (first[2]..first[2] + side[2]).contains(&plane.at);
                    touched.then(|| (number, plane.at - first[2], local(0, &plane.columns), local(1, &plane.rows)))
                };
                let parts: Vec<_> = planes.iter().enumerate().filter_map(part).collect();
                let Some(rows) = parts.iter().map(|part| part.3.clone()).reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)) else {
                    return;
                };
                // Whatever w is, v is slower than u in memory: each row lies in a part of its own.
                let start = if axes[2] == 0 { 0 } else { parts[0].1 * dw };
                let lines = page[slot + start..].par_chunks_mut(dv).enumerate().skip(rows.start).take(rows.len());
                lines.with_min_len(ROWS_TOGETHER).for_each(|(v, line)| {
                    for (number, w, columns, _) in parts.iter().filter(|part| part.3.contains(&v)) {
                        let line = &mut line[w * dw - start..];
                        columns.clone().for_each(|u| line[u * du] = Stored::of(value(*number, first[0] + u, first[1] + v)));
                    }
                });
            });
        });
    }

    /// Lets the layer around channel `slot` go on as the two voxels beside it do, on the face not below zero.
    pub fn extrapolate(&mut self, slot: usize) {
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for axes in [[1, 2, 0], [0, 2, 1], [0, 1, 2]] {
            let [width, height, depth] = axes.map(|axis| self.lattice.dims[axis]);
            for (layer, nearest, next) in [(0, 1, 2), (depth - 1, depth - 2, depth - 3)] {
                self.plane(slot, VoxelPlane { axes, at: nearest }, &mut first);
                self.plane(slot, VoxelPlane { axes, at: next }, &mut second);
                self.put_plane(slot, VoxelPlane { axes, at: layer }, [0..width, 0..height], |u, v| {
                    let (a, b) = (first[v * width + u], second[v * width + u]);
                    // Beside a page that is not held it goes on as it is.
                    let gone_on = if b.is_nan() { a } else { 2.0 * a - b };
                    gone_on.max(-a.abs())
                });
            }
        }
    }
}
