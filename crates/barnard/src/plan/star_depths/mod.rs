//! Star depths: the optical depth at V from a star to every voxel centre.
//!
//! They are swept by `frustum_sweep`, then moved by −δ²/12 along each axis: a trilinear interpolant of a curved
//! function lies on one side of it, and after that its mean over a voxel is right to the fourth order, so that what is
//! left averages out along a ray.

mod between_rays;
pub mod frustum;
pub mod frustum_sweep;
pub(crate) mod planes;
pub mod relay;

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::control::{Control, Stage};
use crate::error::Result;
use crate::field::Grid;
use crate::plan::star_depths::frustum_sweep::sweep;
use crate::volume::{Bricks, ChannelMut, Volume, VoxelPlane};

/// Depth at V past which light is gone at any wavelength: where extinction is least, k = 0.03 in the mid infrared,
/// e^(−30) is left.
pub const OPAQUE: f64 = 1000.0;

/// The progress of a work that one star's depths are a part of \[voxels\].
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// The voxels that were done before them.
    pub done: u64,
    /// The voxels of the whole work.
    pub all: u64,
}

impl Progress {
    /// The progress of work that nobody waits for.
    pub const UNHEARD: Self = Self { done: 0, all: 1 };
}

/// Depths from `star` through `dust` (σ at V [pc⁻¹]) into a channel of a volume.
///
/// # Errors
/// On interruption by the user.
pub fn bake(dust: &Grid, star: DVec3, mut out: ChannelMut, progress: Progress, control: &Control) -> Result<()> {
    let done = AtomicU64::new(progress.done);
    out.volume.choose_unit(out.slot, || OPAQUE as f32);
    sweep(dust, star, &mut out, control, |voxels| {
        let before = done.fetch_add(voxels, Ordering::Relaxed);
        control.report(Stage::StarDepths, (before + voxels).min(progress.all), progress.all);
    })?;
    settle(out.volume, out.slot);
    Ok(())
}

/// Makes depths at voxel centres the numbers that are read between them: moved to means, and going on in the layer
/// around the box.
pub(crate) fn settle(volume: &mut Volume, slot: usize) {
    match_means(volume, slot);
    volume.extrapolate(slot);
}

/// The largest of these depths at a place with dust, whose bricks come first in the plan \[1\].
pub fn deepest(volume: &Volume, slot: usize, dust: &Bricks) -> f32 {
    let lattice = &volume.inner;
    // The bricks that voxels lie in, axis by axis.
    let bricks: [Vec<usize>; 3] = std::array::from_fn(|axis| {
        let along = |i: usize| std::array::from_fn(|a| if a == axis { i } else { 0 });
        let centre = |[x, y, z]: [usize; 3]| lattice.centre(x, y, z);
        (0..lattice.dims[axis]).map(|i| dust.brick_of(centre(along(i)))[axis]).collect()
    });
    let deepest = |z: usize| {
        let row = |y: usize| volume.largest_in_row(slot, [y, z], |x| dust.clear([bricks[0][x], bricks[1][y], bricks[2][z]]) == 0);
        (0..lattice.dims[1]).map(row).fold(0.0, f32::max)
    };
    (0..lattice.dims[2]).into_par_iter().map(deepest).reduce(|| 0.0, f32::max)
}

/// Moves every value by −δ²/12 along each axis, not past its neighbours; not along those on which it has a neighbour in
/// a page that is not held.
fn match_means(volume: &mut Volume, slot: usize) {
    let [nx, ny, nz] = volume.inner.dims;
    let width = volume.lattice.dims[0];
    // Planes are those of the lattice that has a layer around the box.
    let across = |z: usize| VoxelPlane { axes: [0, 1, 2], at: z + 1 };
    let row = |y: usize| (y + 1) * width + 1..(y + 1) * width + 1 + nx;
    // Planes before, here and behind, as they were swept.
    let mut planes: Vec<Vec<f32>> = vec![Vec::new(); nz.min(3)];
    planes.iter_mut().enumerate().for_each(|(z, plane)| volume.plane(slot, across(z), plane));
    let mut moved = vec![0.0; nx * ny];
    let mut first = 0;
    // The second difference of the outermost value is that of its neighbour.
    let middle = |i: usize, n: usize| i.clamp(1, n.saturating_sub(2).max(1));
    for z in 0..nz {
        while nz > 2 && first + 1 < middle(z, nz) {
            planes.rotate_left(1);
            first += 1;
            volume.plane(slot, across(first + 2), &mut planes[2]);
        }
        let plane = &planes[z - first];
        moved.par_chunks_exact_mut(nx).enumerate().for_each_init(
            || Around::new(nx),
            |around, (y, line)| {
                around.begin(&plane[row(y)]);
                if nx > 2 {
                    around.along(&plane[row(y)]);
                }
                if ny > 2 {
                    let y = middle(y, ny);
                    around.across([y - 1, y, y + 1].map(|y| &plane[row(y)]));
                }
                if nz > 2 {
                    around.across([0, 1, 2].map(|i| &planes[i][row(y)]));
                }
                line.iter_mut().zip(around.moved(&plane[row(y)])).for_each(|(value, moved)| *value = moved);
            },
        );
        volume.put_plane(slot, across(z), [1..nx + 1, 1..ny + 1], |x, y| moved[(y - 1) * nx + x - 1]);
    }
}

/// A row of values, and what is around each: the sum of its second differences, and its least and largest neighbour.
struct Around {
    second: Vec<f32>,
    low: Vec<f32>,
    high: Vec<f32>,
}

impl Around {
    fn new(length: usize) -> Self {
        Self { second: vec![0.0; length], low: vec![0.0; length], high: vec![0.0; length] }
    }

    /// Begins with a row alone.
    fn begin(&mut self, plane: &[f32]) {
        self.second.fill(0.0);
        self.low.copy_from_slice(plane);
        self.high.copy_from_slice(plane);
    }

    /// Adds the neighbours across the row, given the row and those on both sides of it.
    fn across(&mut self, [a, b, c]: [&[f32]; 3]) {
        for (i, second) in self.second.iter_mut().enumerate() {
            *second += known(a[i] - 2.0 * b[i] + c[i]);
            self.low[i] = self.low[i].min(a[i]).min(b[i]).min(c[i]);
            self.high[i] = self.high[i].max(a[i]).max(b[i]).max(c[i]);
        }
    }

    /// Adds the neighbours along the row.
    fn along(&mut self, plane: &[f32]) {
        let last = plane.len() - 1;
        let mut add = |i: usize, [a, b, c]: [f32; 3]| {
            self.second[i] += known(a - 2.0 * b + c);
            self.low[i] = self.low[i].min(a).min(b).min(c);
            self.high[i] = self.high[i].max(a).max(b).max(c);
        };
        add(0, [plane[0], plane[1], plane[2]]);
        add(last, [plane[last - 2], plane[last - 1], plane[last]]);
        for i in 1..last {
            add(i, [plane[i - 1], plane[i], plane[i + 1]]);
        }
    }

    /// The row's values, moved by a twelfth of the second differences.
    fn moved(&self, plane: &[f32]) -> impl Iterator<Item = f32> {
        let ends = self.low.iter().zip(&self.high);
        plane.iter().zip(&self.second).zip(ends).map(|((first, second), (low, high))| (first - second / 12.0).max(*low).min(*high))
    }
}

/// A difference, none where a value of it is not known.
fn known(difference: f32) -> f32 {
    if difference.is_nan() { 0.0 } else { difference }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Lattice;
    use crate::geometry::Bounds;
    use crate::stored::Precision;
    use crate::volume::{Channel, Pages};

    /// Rms difference between swept depths and exact columns in parts of the exact rms, and the largest in parts of 1 +
    /// the exact.
    fn differences(grid: &Grid, lattice: &Lattice, star: DVec3) -> (f64, f64) {
        let mut volume = Volume::zeroed(lattice, vec![Channel::StarDepth(0), Channel::Dust]);
        sweep(grid, star, &mut ChannelMut { volume: &mut volume, slot: 0 }, &Control::default(), |_| ()).unwrap();
        let (mut sum, mut size, mut worst) = (0.0, 0.0f64, 0.0f64);
        let lattice = &volume.inner;
        for index in 0..lattice.cells() {
            let [x, y, z] = lattice.place(index);
            let values = [0, 1].map(|slot| volume.value(volume.index([x, y, z]), slot));
            let exact = grid.column(star, lattice.centre(x, y, z), f64::INFINITY);
            let difference = f64::from(values[0]) - exact;
            assert_eq!(values[1], 0.0, "the channel beside it is left alone");
            sum += difference * difference;
            size += exact * exact;
            worst = worst.max(difference.abs() / (1.0 + exact));
        }
        ((sum / size).sqrt(), worst)
    }

    fn waves(dims: [usize; 3]) -> Grid {
        let lattice = Lattice { dims, bounds: Bounds { low: DVec3::splat(-1.0), high: DVec3::new(1.0, 1.2, 1.0) } };
        Grid::sampled(lattice, |p| 4.0 * (0.5 + 0.5 * (9.0 * p.x).sin() * (7.0 * p.y + 3.0 * p.z).cos()))
    }

    /// The stars of the tests: inside, on a face, on a corner, beside a face, outside and far away.
    const STARS: [DVec3; 6] = [
        DVec3::new(0.1, -0.2, 0.3),
        DVec3::new(0.0, 0.0, -1.0),
        DVec3::new(1.0, 1.2, 1.0),
        DVec3::new(1.01, -0.99, 0.0),
        DVec3::new(3.0, 0.5, 0.2),
        DVec3::new(0.0, 0.0, -500.0),
    ];

    #[test]
    fn sweeps_agree_with_exact_columns() {
        let grid = waves([48; 3]);
        for star in STARS {
            let (rms, worst) = differences(&grid, grid.lattice(), star);
            assert!(rms < 3e-3 && worst < 6e-2, "{star}: {rms:.1e} {worst:.1e}");
        }
    }

    /// Stars with equal coordinates, inside and outside, whose diagonals run through voxel centres only to rounding: no
    /// voxel is left to no frustum.
    #[test]
    fn no_voxel_between_frustums_is_left_out() {
        let lattice = Lattice { dims: [12; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let uniform = Grid::sampled(lattice.clone(), |_| 2.0);
        for place in (0..60).map(|i| -1.3 + f64::from(i) / 23.0).flat_map(|x| [[x, 0.3, x], [x, x, x]]) {
            let mut volume = Volume::zeroed(&lattice, vec![Channel::StarDepth(0)]);
            sweep(&uniform, place.into(), &mut ChannelMut { volume: &mut volume, slot: 0 }, &Control::default(), |_| ()).unwrap();
            for index in 0..lattice.cells() {
                let [x, y, z] = lattice.place(index);
                let exact = uniform.column(place.into(), lattice.centre(x, y, z), f64::INFINITY);
                let ours = f64::from(volume.value(volume.index([x, y, z]), 0));
                // Coarse voxels are coarsely right; one left out would be zero.
                assert!(ours > 0.5 * exact - 0.02 && ours < 2.0 * exact + 0.1, "{place:?} {x} {y} {z}: {ours} {exact}");
            }
        }
    }

    /// Depths in pages are those of one page for all, bit by bit, whether the last page has one cell or all of them.
    #[test]
    fn pages_hold_the_same_depths() {
        for edge in [31, 32] {
            let grid = waves([edge, 20, 18]);
            for star in STARS {
                let baked = |pages: fn([usize; 3]) -> Pages| {
                    let dims = Volume::zeroed(grid.lattice(), Vec::new()).lattice.dims;
                    let channels = vec![Channel::Dust, Channel::StarDepth(0)];
                    let mut volume = Volume::with_pages(grid.lattice(), channels, Precision::Single, pages(dims));
                    bake(&grid, star, ChannelMut { volume: &mut volume, slot: 1 }, Progress::UNHEARD, &Control::default()).unwrap();
                    (volume.pages().count(), volume.rows().flat_map(|row| row.into_owned()).collect::<Vec<_>>())
                };
                let (whole, paged) = (baked(Pages::whole), baked(|dims| Pages::stored(dims, |_| true)));
                assert!(whole.0 == 1 && paged.0 == 1 + 2 * 2 * (edge + 1).div_ceil(16), "{edge}: {}", paged.0);
                assert!(whole.1 == paged.1 && whole.1.iter().any(|v| *v > 0.0), "{edge} {star}");
            }
        }
    }

    /// Two and three voxels along an axis, one doubled, voxels of unequal edges: what a voxel cannot show is lost,
    /// nothing else.
    #[test]
    fn boxes_of_all_kinds_are_swept() {
        for dims in [[33, 20, 27], [40, 3, 5], [1, 24, 24], [2, 2, 90]] {
            let grid = waves(dims);
            for star in STARS {
                let (rms, worst) = differences(&grid, grid.lattice(), star);
                assert!(rms < 5e-2 && worst < 0.2, "{dims:?} {star}: {rms:.1e} {worst:.1e}");
            }
        }
    }

    /// Depths on a finer lattice than the dust's.
    #[test]
    fn finer_depths_are_swept() {
        let grid = waves([24; 3]);
        for star in STARS {
            let (rms, worst) = differences(&grid, &grid.lattice().refined(2), star);
            assert!(rms < 4e-3 && worst < 6e-2, "{star}: {rms:.1e} {worst:.1e}");
        }
    }

    /// The light behind an opaque wall is gone, and none is missing beside it.
    #[test]
    fn walls_throw_sharp_shadows() {
        let lattice = Lattice { dims: [40; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let wall = Grid::sampled(lattice.clone(), |p| if p.z.abs() < 0.1 && p.x > 0.0 { 1e4 } else { 0.0 });
        let mut volume = Volume::zeroed(&lattice, vec![Channel::StarDepth(0)]);
        bake(&wall, DVec3::new(0.0, 0.0, -0.9), ChannelMut { volume: &mut volume, slot: 0 }, Progress::UNHEARD, &Control::default())
            .unwrap();
        for index in 0..lattice.cells() {
            let [x, y, z] = lattice.place(index);
            let (p, depth) = (lattice.centre(x, y, z), &volume.value(volume.index([x, y, z]), 0));
            if p.z > 0.2 && p.x > 0.12 * (p.z + 0.9) {
                assert_eq!(*depth, OPAQUE as f32, "{p}");
            }
            if p.z < -0.2 || p.x < -0.12 * (p.z + 0.9) {
                assert_eq!(*depth, 0.0, "{p}");
            }
        }
    }

    /// A lit face has no depth, whatever the angle, and just behind it the depth is that of the way through the dust.
    #[test]
    fn depths_begin_at_the_face() {
        let lattice = Lattice { dims: [8; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let uniform = Grid::sampled(lattice.clone(), |_| 2.0);
        let star = DVec3::new(4.0, 2.0, -30.0);
        let mut volume = Volume::zeroed(&lattice, vec![Channel::StarDepth(0)]);
        bake(&uniform, star, ChannelMut { volume: &mut volume, slot: 0 }, Progress::UNHEARD, &Control::default()).unwrap();
        for depth in [0.0, 0.05, 0.1, 0.2, 0.4] {
            let p = DVec3::new(-0.3, -0.2, -1.0 + depth);
            let truth = uniform.column(star, p, f64::INFINITY);
            // A box without the layer would hold the first centre's 0.25 here.
            assert!((volume.at(0, p) - truth).abs() < 2e-3, "{depth}: {} {truth}", volume.at(0, p));
        }
    }

    /// The trilinear interpolant of a moved parabola has the parabola's mean over a voxel: ∫ x² = 1/12 + x₀² about x₀.
    #[test]
    fn means_are_matched() {
        let lattice = Lattice { dims: [7; 3], bounds: Bounds::cube(DVec3::ZERO, 3.5) };
        let parabola = Grid::sampled(lattice.clone(), |p| 50.0 + p.x * p.x - 2.0 * p.y * p.y + 0.5 * p.z * p.z + 9.0 * (p.x + p.y + p.z));
        let mut volume = Volume::zeroed(&lattice, vec![Channel::StarDepth(0)]);
        volume.fill(0, &parabola);
        let before = volume.at(0, DVec3::new(0.5, 0.5, 0.5));
        match_means(&mut volume, 0);
        // Between eight centres the mean of a trilinear function is its value in the middle.
        let curvature = 1.0 - 2.0 + 0.5;
        let truth = 50.0 + 0.25 * curvature + 13.5 + curvature / 12.0;
        let middle = volume.at(0, DVec3::new(0.5, 0.5, 0.5));
        assert!((middle - truth).abs() < 1e-4 && (before - truth).abs() > 0.05, "{before} {middle} {truth}");
    }
}
