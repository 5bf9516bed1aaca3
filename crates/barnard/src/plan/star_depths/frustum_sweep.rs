//! Sweeps of optical depth through a frustum that has a star at its apex.
//!
//! Space around a star is cut into six frustums, one along each axis and direction of the lattice. In one of them every
//! ray from the star crosses the planes of voxel centres one after the other, and is given by its slopes (u, v) in
//! voxels a plane:
//!
//!   τ(u, v; w_k) = τ(u, v; w_{k−1}) + ℓ(u, v) ∫ σ(w u, w v, w) dw
//!
//! A ray carries its own depth from the star outwards, so nothing is smeared; a voxel centre of plane k takes the depth
//! of the rays around it, which is the only interpolation (cubic, within the two nearest). Trilinear σ is a cubic
//! polynomial in w but for the crossings of other planes: two Gauss points an interval. Beside the box σ goes on as at
//! its border, so that the rays next to a border voxel are of its kind; what a ray collects before it comes in through
//! a side is taken off again, which makes it negative out there, in one line with what follows. Where that line bends
//! too much, behind a side that rays graze, voxels get exact columns. Rays are as far apart as voxels at the far end of
//! a tier and half as far at its near end; tiers double in distance, and each starts at the star again. So the cost is
//! that of the voxels, however long the box.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | u, v | `Rays::first` + i · `spacing` | voxels a plane |
//! | w | `Frustum::distance` | voxels |
//! | τ | `Tier::depths` | 1 |
//! | ℓ | `edge`, in `advance` | pc |

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use spectra::simd;

use crate::control::Control;
use crate::error::Result;
use crate::field::{Grid, Lattice};
use crate::packet::{LANES, Lane, fma, lanes, place};
use crate::plan::star_depths::OPAQUE;
use crate::plan::star_depths::between_rays::{Places, beside, cubic_line, cubic_rows, grazed};
use crate::plan::star_depths::frustum::{Frustum, Rays, TierOf, frustums};
use crate::plan::star_depths::planes::{BLOCK, DustWindow, Planes, mix, within};
use crate::volume::{ChannelMut, PlanePart, ROWS_TOGETHER};

/// Two-point Gauss rule on [0, 1], weights one half.
pub const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
/// A ray that comes in behind the last plane is followed by this number of intervals; others never enter.
pub const BEYOND: f64 = 3.0;
/// Planes across x that are written together: a line of memory holds sixteen single values; and their bytes at most.
const PLANES_TOGETHER: usize = 16;
const BYTES_TOGETHER: usize = 64 << 20;
/// Voxels on an edge between frustums belong to both: rounding must not leave them to none.
const SHARED: f64 = 1e-6;

/// The sweep of one frustum through the dust, or through the part of it that is at hand.
pub(super) struct FrustumSweep<'a> {
    pub dust: DustWindow<'a>,
    pub frustum: Frustum,
    /// Voxels along u and v that are written.
    pub ranges: [Range<usize>; 2],
    /// The depth of the straight way from the star to a voxel along u, v, w, where no neighbouring ray gives it.
    pub exact: &'a (dyn Fn([usize; 3]) -> f32 + Sync),
}

/// The depths of a tier's rays, or of those within a window of them.
pub(super) struct Tier {
    pub rays: Rays,
    /// The rays along u and v that there are depths of.
    pub window: [Range<usize>; 2],
    /// Depths so far, v × u.
    pub depths: Vec<f32>,
    /// Depths at which rays come into the box through a side, if any do.
    pub entries: Option<Vec<f32>>,
}

impl Tier {
    /// Rays that have met nothing yet.
    fn new(rays: Rays) -> Self {
        let depths = vec![0.0; rays.counts[0] * rays.counts[1]];
        Self { window: rays.counts.map(|n| 0..n), rays, depths, entries: None }
    }
}

/// An interval between two planes, in distances from the star [voxels].
#[derive(Clone, Copy)]
struct Interval {
    from: f64,
    to: f64,
    /// True if no other interval follows in this tier.
    last: bool,
}

impl Interval {
    fn gauss(&self) -> [f64; 2] {
        GAUSS.map(|g| self.from + g * (self.to - self.from))
    }
}

/// Depths from `star` \[pc\] through `dust` (σ at V [pc⁻¹]) of all voxels, written into `out`; `visit` receives how
/// many were written.
///
/// # Errors
/// On interruption by the user.
pub fn sweep(dust: &Grid, star: DVec3, out: &mut ChannelMut, control: &Control, mut visit: impl FnMut(u64)) -> Result<()> {
    let lattice = out.volume.inner.clone();
    for frustum in frustums(&lattice, star) {
        let axes = frustum.axes;
        let exact = |place| exact_depth(dust, star, &lattice, axes, place);
        let ranges = [0, 1].map(|axis| 0..frustum.dims[axis]);
        FrustumSweep { dust: DustWindow::whole(dust), frustum, ranges, exact: &exact }.run(out, control, &mut visit)?;
    }
    Ok(())
}

/// The depth of the straight way through `dust` from the star to a voxel of a lattice along `axes`.
pub(super) fn exact_depth(dust: &Grid, star: DVec3, lattice: &Lattice, axes: [usize; 3], place: [usize; 3]) -> f32 {
    let mut voxel = [0; 3];
    axes.iter().zip(place).for_each(|(axis, i)| voxel[*axis] = i);
    dust.column(star, lattice.centre(voxel[0], voxel[1], voxel[2]), OPAQUE).min(OPAQUE) as f32
}

impl FrustumSweep<'_> {
    fn run(&self, out: &mut ChannelMut, control: &Control, visit: &mut impl FnMut(u64)) -> Result<()> {
        let planes = self.frustum.planes();
        let mut together = Together::new(&self.frustum);
        for TierOf { rays, begin, end } in self.frustum.tiers() {
            let (mut tier, planes) = (Tier::new(rays), &planes[..end]);
            if self.frustum.has_side_entries() {
                // Rays come in through sides: a first pass finds their depths there.
                tier.entries = Some(vec![0.0; tier.depths.len()]);
                self.follow(&mut tier, planes, 0..end, control, |_, _| ())?;
                tier.depths = tier.entries.take().unwrap_or_default().into_iter().map(|depth| -depth).collect();
            }
            self.follow(&mut tier, planes, 0..end, control, |tier, number| {
                if number >= begin {
                    let made = |values: &mut [f32]| self.plane_values(tier, planes[number], values);
                    visit(together.take(&self.frustum, planes[number], made, out));
                }
            })?;
            visit(together.write(&self.frustum, out));
        }
        Ok(())
    }

    /// Carries the rays to the planes of some numbers, of all that their tier meets; `visit` sees them on each.
    pub(super) fn follow(
        &self,
        tier: &mut Tier,
        planes: &[usize],
        numbers: Range<usize>,
        control: &Control,
        mut visit: impl FnMut(&Tier, usize),
    ) -> Result<()> {
        let mut store = Planes::new(self.dust, self.frustum.axes, self.frustum.sign);
        let mut slabs = [Vec::new(), Vec::new()];
        let mut from = self.frustum.before(planes, numbers.start);
        // The way to the last of the planes of dust that are copied together.
        let ahead = BLOCK as f64 * self.frustum.dims[2] as f64 / self.dust.dims[self.frustum.axes[2]] as f64;
        for number in numbers {
            control.check()?;
            let interval = Interval { from, to: self.frustum.distance(planes[number]), last: number + 1 == planes.len() };
            for (slab, point) in slabs.iter_mut().zip(interval.gauss()) {
                let (window, far) = (self.window(tier, point), self.window(tier, point + ahead));
                store.slab(self.to_dust(2, self.frustum.star[2] + self.frustum.sign * point), &window, &far, slab);
            }
            self.advance(tier, &slabs, interval);
            visit(tier, number);
            from = interval.to;
        }
        Ok(())
    }

    /// A coordinate of the voxels in those of the dust, clamped to its outermost centres.
    fn to_dust(&self, axis: usize, x: f64) -> f64 {
        let cells = self.dust.dims[self.frustum.axes[axis]] as f64;
        ((x + 0.5) * cells / self.frustum.dims[axis] as f64 - 0.5).clamp(0.0, cells - 1.0)
    }

    /// Columns and rows of the dust at hand that rays meet, or stand beside, on a plane at this distance.
    fn window(&self, tier: &Tier, point: f64) -> [Range<usize>; 2] {
        let Tier { rays, window, .. } = tier;
        [0, 1].map(|axis| {
            let at = |ray: f64| self.to_dust(axis, self.frustum.star[axis] + (rays.first[axis] + ray * rays.spacing) * point) as usize;
            let slab_range = &window[axis];
            within(
                &(at(slab_range.start as f64 - 1.0).saturating_sub(1)..at(slab_range.end as f64 - 2.0) + 3),
                &self.dust.stored(self.frustum.axes[axis]),
            )
        })
    }

    /// Adds to every ray its depth in an interval, σ given on the planes of the two Gauss points.
    fn advance(&self, tier: &mut Tier, slabs: &[Vec<f32>; 2], interval: Interval) {
        let columns = interval.gauss().map(|point| self.window(tier, point)[0].clone());
        let (first, spacing, window) = (tier.rays.first, tier.rays.spacing, tier.window.clone());
        let width = window[0].len();
        let [cells, rows] = [0, 1].map(|axis| self.dust.dims[self.frustum.axes[axis]]);
        let [held_columns, held_rows] = [0, 1].map(|axis| self.dust.stored(self.frustum.axes[axis]));
        let column_count = held_columns.len();
        let scale = cells as f64 / self.frustum.dims[0] as f64;
        let half = 0.5 * (interval.to - interval.from);
        let scratch = || ([vec![0.0f32; column_count + 1], vec![0.0f32; column_count + 1]], vec![0.0f32; width]);
        let row = |(mixed, gains): &mut ([Vec<f32>; 2], Vec<f32>), (j, depths): (usize, &mut [f32]), entries: Option<&mut [f32]>| {
            let v = first[1] + ((window[1].start + j) as f64 - 1.0) * spacing;
            for (((row, slab), point), columns) in mixed.iter_mut().zip(slabs).zip(interval.gauss()).zip(&columns) {
                let y = self.to_dust(1, self.frustum.star[1] + v * point);
                let low = (y as usize).min(rows - 1);
                let local = |row: usize| row.min(rows - 1).clamp(held_rows.start, held_rows.end - 1) - held_rows.start;
                let slab_row = |row: usize| &slab[local(row) * column_count..][columns.clone()];
                mix(&mut row[columns.clone()], slab_row(low), slab_row(low + 1), (y - low as f64) as f32);
                row[column_count] = row[column_count - 1];
            }
            let slope = first[0] - spacing;
            let line = RayRow {
                samples: interval
                    .gauss()
                    .map(|z| (((self.frustum.star[0] + slope * z + 0.5) * scale - 0.5) as f32, (spacing * z * scale) as f32)),
                across: ((slope * self.frustum.edge[0]) as f32, (spacing * self.frustum.edge[0]) as f32),
                flat: (self.frustum.edge[2].powi(2) + (v * self.frustum.edge[1]).powi(2)) as f32,
                half: half as f32,
                cells,
                first_column: held_columns.start,
                first_ray: window[0].start,
            };
            advance_line(&line, [&mixed[0], &mixed[1]], gains, depths);
            let Some(entries) = entries else { return };
            for (i, entry) in entries.iter_mut().enumerate() {
                let at = self.frustum.enters(0, slope + (window[0].start + i) as f64 * spacing).max(self.frustum.enters(1, v));
                let part = (at - interval.from) / (interval.to - interval.from);
                if part > 0.0 && (part <= 1.0 || interval.last) {
                    *entry = if part < BEYOND { depths[i] + (part - 1.0) as f32 * gains[i] } else { f32::MAX };
                }
            }
        };
        let lines = tier.depths.par_chunks_mut(width).enumerate().with_min_len(ROWS_TOGETHER);
        match &mut tier.entries {
            None => lines.for_each_init(scratch, |scratch, line| row(scratch, line, None)),
            Some(entries) => {
                let entries = entries.par_chunks_mut(width).with_min_len(ROWS_TOGETHER);
                lines.zip(entries).for_each_init(scratch, |scratch, (line, entries)| row(scratch, line, Some(entries)));
            }
        }
    }

    /// The voxels along u or v of a plane at distance `z` that are written and lie inside the frustum.
    pub(super) fn covered(&self, axis: usize, z: f64) -> Range<usize> {
        let slab_range = &self.ranges[axis];
        let (low, high) = (self.frustum.star[axis] - z - SHARED, self.frustum.star[axis] + z + SHARED);
        let (low, high) = (low.ceil().max(slab_range.start as f64), high.floor().min(slab_range.end as f64 - 1.0));
        if low > high { slab_range.start..slab_range.start } else { low as usize..high as usize + 1 }
    }

    /// Where voxel number 0 along u or v of a plane at distance `z` stands among the rays, and the step from voxel to
    /// voxel.
    pub(super) fn among(&self, rays: &Rays, axis: usize, z: f64) -> (f64, f64) {
        let step = 1.0 / (z * rays.spacing);
        (1.0 - self.frustum.star[axis] * step - rays.first[axis] / rays.spacing, step)
    }

    /// Depths of the voxels of one plane that are covered, into `values` of all that are written, v × u.
    pub(super) fn plane_values(&self, tier: &Tier, plane: usize, values: &mut [f32]) -> [Range<usize>; 2] {
        let z = self.frustum.distance(plane);
        let (columns, rows) = (self.covered(0, z), self.covered(1, z));
        if columns.is_empty() || rows.is_empty() {
            return [columns, rows];
        }
        let has_side_entries = self.frustum.has_side_entries();
        let Tier { rays, window, depths, .. } = tier;
        let width = window[0].len();
        let among = [0, 1].map(|axis| self.among(rays, axis, z));
        let around = |axis: usize, x: usize| beside(among[axis].0 + x as f64 * among[axis].1, rays.counts[axis]);
        let slab_ranges = &self.ranges;
        let lines = values.par_chunks_mut(slab_ranges[0].len().max(1)).enumerate().skip(rows.start - slab_ranges[1].start).take(rows.len());
        lines.with_min_len(ROWS_TOGETHER).for_each_init(
            || vec![0.0f32; width],
            |mixed, (row, line)| {
                let y = slab_ranges[1].start + row;
                let (j, f) = around(1, y);
                let ray_rows = [j - 1, j, j + 1, j + 2].map(|j| &depths[(j - window[1].start) * width..][..width]);
                cubic_rows(mixed, ray_rows, f);
                let (first, step) = among[0];
                let local = columns.start - slab_ranges[0].start..columns.end - slab_ranges[0].start;
                let places = Places { first, step, voxel: columns.start, counts: rays.counts[0], first_ray: window[0].start };
                cubic_line(&mut line[local], mixed, &places);
                for x in columns.clone().filter(|_| has_side_entries) {
                    let (i, _) = around(0, x);
                    let i = i - window[0].start;
                    if grazed(ray_rows.map(|row| &row[i - 1..i + 3])) {
                        line[x - slab_ranges[0].start] = (self.exact)([x, y, plane]);
                    }
                }
            },
        );
        [columns, rows]
    }
}

/// Planes of depths that are written together: those across x, of which a line of memory has several.
struct Together {
    /// The most of them.
    most: usize,
    parts: Vec<PlanePart>,
    /// The values of each, v × u.
    values: Vec<Vec<f32>>,
}

impl Together {
    fn new(frustum: &Frustum) -> Self {
        let plane = frustum.dims[0] * frustum.dims[1];
        let most = if frustum.axes[2] == 0 { (BYTES_TOGETHER / (4 * plane)).clamp(1, PLANES_TOGETHER) } else { 1 };
        Self { most, parts: Vec::new(), values: vec![vec![0.0; plane]; most] }
    }

    /// Takes one more plane, once `made` has made its values; returns how many voxels were written, where it was.
    fn take(&mut self, frustum: &Frustum, plane: usize, made: impl FnOnce(&mut [f32]) -> [Range<usize>; 2], out: &mut ChannelMut) -> u64 {
        let ranges = made(&mut self.values[self.parts.len()]);
        // The layer around the box is before its first voxel.
        let [columns, rows] = ranges.map(|range| range.start + 1..range.end + 1);
        self.parts.push(PlanePart { at: plane + 1, columns, rows });
        if self.parts.len() == self.most { self.write(frustum, out) } else { 0 }
    }

    /// Writes what has come; returns the number of voxels.
    fn write(&mut self, frustum: &Frustum, out: &mut ChannelMut) -> u64 {
        let ChannelMut { volume, slot } = out;
        let (parts, width) = (volume.units[*slot].recip(), frustum.dims[0]);
        let (planes, values) = (std::mem::take(&mut self.parts), &self.values);
        volume.put_planes(*slot, frustum.axes, &planes, |plane, x, y| values[plane][(y - 1) * width + x - 1] * parts);
        planes.iter().map(|part| (part.rows.len() * part.columns.len()) as u64).sum()
    }
}

/// Rays of one row: what their places and lengths between two planes are made of, each from ray 0 and the step from ray
/// to ray.
struct RayRow {
    /// Places at the two Gauss points along u [voxels of dust].
    samples: [(f32, f32); 2],
    /// The way along u in a plane [pc].
    across: (f32, f32),
    /// The square of the way along v and w in a plane [pc²].
    flat: f32,
    /// Half of the planes between.
    half: f32,
    /// Voxels of dust along u, and the first of those at hand.
    cells: usize,
    first_column: usize,
    /// The number of the first ray.
    first_ray: usize,
}

simd! {
    /// Adds to the depths of a row of rays what an interval gives them, σ given along u at its two Gauss points; the last
    /// value of each row stands twice.
    fn advance_line(line: &RayRow, rows: [&[f32]; 2], gains: &mut [f32], depths: &mut [f32]) {
        for (chunk, (gains, depths)) in gains.chunks_mut(LANES).zip(depths.chunks_mut(LANES)).enumerate() {
            let number = lanes!(|lane| (line.first_ray + chunk * LANES + lane) as f32);
            let mut sum = [0.0; LANES];
            for (row, (first, step)) in rows.iter().zip(line.samples) {
                let (stored, last) = (line.first_column as u32, row.len() as u32 - 2);
                let (mut cell, mut fraction) = ([0; LANES], [0.0; LANES]);
                for lane in 0..LANES {
                    let at = place(fma(number[lane], step, first), line.cells);
                    (cell[lane], fraction[lane]) = (at.cell.saturating_sub(stored).min(last), at.fraction);
                }
                let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
                for lane in 0..LANES {
                    let pair = &row[cell[lane] as usize..][..2];
                    (low[lane], high[lane]) = (pair[0], pair[1]);
                }
                for lane in 0..LANES {
                    sum[lane] += fma(fraction[lane], high[lane] - low[lane], low[lane]);
                }
            }
            let gain = lanes!(|lane| {
                let u = fma(number[lane], line.across.1, line.across.0);
                fma(u, u, line.flat).sqrt() * line.half * sum[lane]
            });
            if let (Ok(gains), Ok(depths)) = (<&mut Lane>::try_from(&mut *gains), <&mut Lane>::try_from(&mut *depths)) {
                *gains = gain;
                for lane in 0..LANES {
                    depths[lane] += gain[lane];
                }
            } else {
                gains.copy_from_slice(&gain[..gains.len()]);
                depths.iter_mut().zip(gain).for_each(|(depth, gain)| *depth += gain);
            }
        }
    }
}
