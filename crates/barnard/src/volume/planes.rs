//! Planes of a volume across any of its axes, read and written.

use std::ops::Range;

use rayon::prelude::*;

use super::Volume;
use crate::stored::{Stored, stored};

/// The fewest rows that a thread takes.
const ROWS_TOGETHER: usize = 8;

/// A plane of a volume's voxels, those of the layer around the box counted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    /// The axes along the plane, the faster one in memory first, and the one across it.
    pub axes: [usize; 3],
    /// The place along the last.
    pub at: usize,
}

impl Plane {
    /// The voxel at a place in the plane.
    fn voxel(&self, u: usize, v: usize) -> [usize; 3] {
        let mut voxel = [self.at; 3];
        (voxel[self.axes[0]], voxel[self.axes[1]]) = (u, v);
        voxel
    }
}

impl Volume {
    /// The values of a channel on a plane, v × u, in parts of the channel's unit; NaN in pages that are not held.
    pub(crate) fn plane(&self, slot: usize, plane: Plane, out: &mut Vec<f32>) {
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
                stored!(&self.values, |data| line.zip(data[from..].iter().step_by(stride)).for_each(|(own, v)| *own = v.value()));
            }
        });
    }

    /// Writes a channel on a part of a plane, columns and rows, in parts of the channel's unit; what lies in no page that
    /// is held is lost.
    pub(crate) fn put_plane(
        &mut self,
        slot: usize,
        plane: Plane,
        [columns, rows]: [Range<usize>; 2],
        value: impl Fn(usize, usize) -> f32 + Sync,
    ) {
        let channels = self.channels.len();
        let side = self.pages.side();
        let [du, dv, dw] = plane.axes.map(|axis| self.pages.strides()[axis] * channels);
        let pages = &self.pages;
        stored!(&mut self.values, |data| {
            let touched = pages
                .of(data, channels)
                .filter(|(first, _)| (first[plane.axes[2]]..first[plane.axes[2]] + side[plane.axes[2]]).contains(&plane.at));
            touched.for_each(|(first, page)| {
                let local = |i: usize, range: &Range<usize>| {
                    let within =
                        |at: usize| at.clamp(first[plane.axes[i]], first[plane.axes[i]] + side[plane.axes[i]]) - first[plane.axes[i]];
                    within(range.start)..within(range.end)
                };
                let (columns, rows) = (local(0, &columns), local(1, &rows));
                let [u0, v0, w0] = plane.axes.map(|axis| first[axis]);
                // Whatever w is, v is slower than u in memory: each row lies in a part of its own.
                let lines = page[slot + (plane.at - w0) * dw..].par_chunks_mut(dv).enumerate();
                let lines = lines.skip(rows.start).take(rows.len()).with_min_len(ROWS_TOGETHER);
                lines.for_each(|(v, line)| columns.clone().for_each(|u| line[u * du] = Stored::of(value(u0 + u, v0 + v))));
            });
        });
    }

    /// Lets the layer around channel `slot` go on as the two voxels beside it do, on the face not below zero.
    pub fn extrapolate(&mut self, slot: usize) {
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for axes in [[1, 2, 0], [0, 2, 1], [0, 1, 2]] {
            let [width, height, depth] = axes.map(|axis| self.lattice.dims[axis]);
            for (layer, nearest, next) in [(0, 1, 2), (depth - 1, depth - 2, depth - 3)] {
                self.plane(slot, Plane { axes, at: nearest }, &mut first);
                self.plane(slot, Plane { axes, at: next }, &mut second);
                self.put_plane(slot, Plane { axes, at: layer }, [0..width, 0..height], |u, v| {
                    let (a, b) = (first[v * width + u], second[v * width + u]);
                    // Beside a page that is not held it goes on as it is.
                    let gone_on = if b.is_nan() { a } else { 2.0 * a - b };
                    gone_on.max(-a.abs())
                });
            }
        }
    }
}
