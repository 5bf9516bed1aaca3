//! Upper bounds of a field, block by block, for tracking by collisions that may be null.
//!
//! A grid's bounds are exact: the largest of the values that a block's trilinear cells touch. A function is asked at 4³
//! places of each block and those around it, and nowhere in its box is the bound zero; where it is exceeded all the
//! same, the weights of [`super::medium`] keep the mean right.

use rayon::prelude::*;

use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Field, Grid, Lattice};
use crate::geometry::Ray;

/// Blocks along the longest edge of a function's box.
const BLOCKS: f64 = 32.0;
/// Voxels along the edge of a grid's block.
const VOXELS: usize = 4;
/// Places along the edge of a block at which a function is asked.
const ASKED: usize = 4;
/// The least bound inside of a function's box, of the largest one.
const LEAST: f32 = 0.01;

/// Bounds on a lattice of blocks.
#[derive(Debug)]
pub struct Majorant {
    blocks: Grid,
}

/// A part of a ray with one bound: between two distances [pc].
pub type Cell = (f64, f64, f64);

impl Majorant {
    /// Bounds `field` from above, block by block.
    ///
    /// # Errors
    /// If the field is not finite at a place where it is asked, and on interruption by the user.
    pub fn new(field: &dyn Field, control: &Control) -> Result<Self> {
        let blocks = match field.grid() {
            Some(grid) => of_grid(grid),
            None => of_function(field, control),
        };
        control.check()?;
        let first_bad = blocks.values().iter().position(|v| !v.is_finite());
        match first_bad {
            None => Ok(Self { blocks }),
            Some(i) => {
                let [x, y, z] = blocks.lattice().place(i);
                let p = blocks.lattice().centre(x, y, z);
                Err(Error::Density(format!(
                    "a density near ({:.3}, {:.3}, {:.3}) pc is not finite, so collisions have no bound; limit it, as in min(f, 1e3)",
                    p.x, p.y, p.z
                )))
            }
        }
    }

    /// Copy of the bounds multiplied by a factor: a wrong one, for tests.
    #[cfg(test)]
    pub fn scaled(mut self, factor: f32) -> Self {
        self.blocks = self.blocks.scaled(factor.into());
        self
    }

    /// The blocks that a ray crosses up to `far`, in order.
    pub fn cells(&self, ray: &Ray, far: f64) -> impl Iterator<Item = Cell> + '_ {
        let lattice = self.blocks.lattice();
        let (near, far) = lattice.bounds.clip(ray).map_or((0.0, 0.0), |(near, end)| (near, end.min(far)));
        let size = lattice.voxel_pc();
        let start = (ray.at(near) - lattice.bounds.low) / size;
        let mut place: [usize; 3] = std::array::from_fn(|a| (start[a].floor().max(0.0) as usize).min(lattice.dims[a] - 1));
        // Where the next border across each axis lies.
        let direction = ray.direction;
        let border = move |axis: usize, i: usize| {
            let next = if direction[axis] > 0.0 { i + 1 } else { i };
            if direction[axis] == 0.0 { f64::INFINITY } else { (next as f64 - start[axis]) * size[axis] / direction[axis] + near }
        };
        let mut borders: [f64; 3] = std::array::from_fn(|a| border(a, place[a]));
        let mut t = near;
        std::iter::from_fn(move || {
            if t >= far {
                return None;
            }
            let bound = f64::from(self.blocks.value(place));
            let axis = (0..3).fold(0, |first, a| if borders[a] < borders[first] { a } else { first });
            let end = borders[axis].clamp(t, far);
            let cell = (t, end, bound);
            let last = if direction[axis] > 0.0 { place[axis] + 1 == lattice.dims[axis] } else { place[axis] == 0 };
            t = if last { f64::INFINITY } else { end };
            if !last {
                place[axis] = if direction[axis] > 0.0 { place[axis] + 1 } else { place[axis] - 1 };
                borders[axis] = border(axis, place[axis]);
            }
            Some(cell)
        })
    }
}

fn of_grid(grid: &Grid) -> Grid {
    let field_lattice = grid.lattice();
    let dims = field_lattice.dims.map(|n| n.div_ceil(VOXELS));
    let bounds = crate::geometry::Bounds {
        low: field_lattice.bounds.low,
        high: field_lattice.bounds.low + field_lattice.voxel_pc() * VOXELS as f64 * glam::DVec3::from(dims.map(|n| n as f64)),
    };
    let lattice = Lattice { dims, bounds };
    let largest = |index: usize| {
        let place = lattice.place(index);
        // A place in the block lies between the centres of its voxels and those around them.
        let along = |axis: usize| (place[axis] * VOXELS).saturating_sub(1)..((place[axis] + 1) * VOXELS + 1).min(field_lattice.dims[axis]);
        grid.largest([along(0), along(1), along(2)])
    };
    let data = (0..lattice.cells()).into_par_iter().map(largest).collect();
    Grid::from_lattice(lattice, data)
}

fn of_function(field: &dyn Field, control: &Control) -> Grid {
    let bounds = field.bounds();
    let block = bounds.size().max_element() / BLOCKS;
    let dims = bounds.size().to_array().map(|edge| ((edge / block).ceil() as usize).max(1));
    let lattice = Lattice { dims, bounds };
    let fine = lattice.refined(ASKED);
    // NaN must not be lost among numbers.
    let larger = |a: f32, b: f32| if a.is_nan() || a > b { a } else { b };
    let asked = Grid::sampled(fine.clone(), |p| if control.interrupted() { 0.0 } else { field.at(p) });
    let asked = asked.values();
    let largest = |index: usize| {
        let place = lattice.place(index);
        let along = |axis: usize| (place[axis] * ASKED).saturating_sub(ASKED)..((place[axis] + 2) * ASKED).min(fine.dims[axis]);
        let rows = along(2).flat_map(|z| along(1).map(move |y| (y, z)));
        rows.flat_map(|(y, z)| asked[fine.row(along(0), y, z)].iter().copied()).fold(0.0, larger)
    };
    let mut data: Vec<f32> = (0..lattice.cells()).into_par_iter().map(largest).collect();
    // Any bound does where nothing was met, as long as it is one: a field may be thinner than the places asked.
    let largest = data.iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
    let least = if largest > 0.0 { LEAST * largest } else { 1.0 };
    data.iter_mut().filter(|v| **v < least).for_each(|v| *v = least);
    Grid::from_lattice(lattice, data)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::Bounds;
    use crate::random::Counter;

    fn rays(count: u64) -> impl Iterator<Item = Ray> {
        (0..count).map(|i| {
            let mut random = Counter::new(7, i);
            let mut place = |half: f64| DVec3::from([random.uniform(), random.uniform(), random.uniform()].map(|u| half * (2.0 * u - 1.0)));
            let (origin, target) = (place(3.0), place(0.8));
            Ray::between(origin, target).0
        })
    }

    /// The cells of a ray follow each other without a gap through the whole box, and no value in them passes their
    /// bound.
    #[test]
    fn cells_bound_grids() {
        let lattice = Lattice { dims: [13, 10, 22], bounds: Bounds { low: DVec3::new(-1.0, -0.7, -1.1), high: DVec3::new(1.0, 0.9, 1.3) } };
        let grid = Grid::sampled(lattice, |p| (5.0 * p.x + 3.0 * p.y * p.z).sin().max(0.0));
        let majorant = Majorant::new(&grid, &Control::default()).unwrap();
        let mut tight = 0.0f64;
        for ray in rays(200) {
            let Some((near, far)) = grid.bounds().clip(&ray) else { continue };
            let cells: Vec<Cell> = majorant.cells(&ray, f64::INFINITY).collect();
            assert!(cells[0].0 <= near && cells.windows(2).all(|w| w[0].1 == w[1].0) && cells[cells.len() - 1].1 > far - 1e-9);
            for (start, end, bound) in cells {
                for i in 0..20 {
                    let value = grid.at(ray.at(start + (end - start) * (i as f64 + 0.5) / 20.0));
                    assert!(value <= bound * (1.0 + 1e-6), "{value} {bound}");
                    tight = tight.max(value / bound.max(1e-9));
                }
            }
        }
        assert!(tight > 0.95, "{tight}");
    }

    /// A slab between the places that are asked has a bound all the same.
    #[test]
    fn thin_fields_are_bounded() {
        #[derive(Debug)]
        struct Thin;
        impl Field for Thin {
            fn at(&self, p: DVec3) -> f64 {
                f64::from(p.z.abs() < 0.005)
            }
            fn bounds(&self) -> Bounds {
                Bounds::cube(DVec3::ZERO, 1.0)
            }
        }
        let majorant = Majorant::new(&Thin, &Control::default()).unwrap();
        let ray = Ray { origin: DVec3::new(0.1, 0.2, -3.0), direction: DVec3::Z };
        assert!(majorant.cells(&ray, f64::INFINITY).all(|(_, _, bound)| bound > 0.0));
    }

    /// Rays that run along an axis, on a border of blocks or backwards, cross the box as well.
    #[test]
    fn rays_along_axes_cross() {
        let grid = Grid::sampled(Lattice { dims: [8; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) }, |_| 1.0);
        let majorant = Majorant::new(&grid, &Control::default()).unwrap();
        for direction in [DVec3::X, -DVec3::Y, DVec3::Z] {
            let ray = Ray { origin: -4.0 * direction, direction };
            let length: f64 = majorant.cells(&ray, f64::INFINITY).map(|(a, b, bound)| (b - a) * bound).sum();
            assert!((length - 2.0).abs() < 1e-12, "{length}");
            let half: f64 = majorant.cells(&ray, 4.0).map(|(a, b, _)| b - a).sum();
            assert!((half - 1.0).abs() < 1e-12, "{half}");
        }
    }
}
