//! The many lights on the device: a table of its stars, and for each cell of a grid the stars whose kernels reach into
//! it.

use barnard::geometry::Bounds;
use barnard::plan::many_lights::near_field_kernel::{NearFieldKernel, PROFILE};
use barnard::plan::near::near_field_piece;
use barnard::plan::{ManyLights, MultipleScattering, Plan, Stepping, Weights};
use glam::DVec3;

use crate::tables::Tables;

/// Quads of a star beside its weights: place and σ, its kernel, depths before it.
pub const STAR: usize = 2 + PROFILE / 4;
/// Most cells along an edge of the grid.
const CELLS: f64 = 32.0;

/// The many lights of a plan whose light is gathered, where there is anything that scatters it.
pub fn fields(plan: &Plan) -> Option<(&ManyLights, &MultipleScattering)> {
    plan.space().occupied?;
    let (many_lights, scattered_field) = (plan.space().many_lights.as_deref()?, plan.scattered_field().map(|d| &**d)?);
    scattered_field.report.far_field.map(|_| (many_lights, scattered_field))
}

/// Cells that know the stars near them.
struct StarGrid {
    low: DVec3,
    edge: f64,
    dims: [usize; 3],
}

impl StarGrid {
    fn new(occupied: Bounds, kernels: &[NearFieldKernel]) -> Self {
        let size = occupied.size();
        let edge =
            (size.max_element() / CELLS).max(kernels.iter().map(|kernel| kernel.reach_pc).sum::<f64>() / kernels.len().max(1) as f64);
        Self { low: occupied.low, edge, dims: <[f64; 3]>::from(size / edge).map(|n| n.ceil().max(1.0) as usize) }
    }

    /// Numbers of the cells that a box touches.
    fn touched(&self, bounds: Bounds) -> impl Iterator<Item = usize> + use<> {
        let dims = self.dims;
        let cell = |p: DVec3| ((p - self.low) / self.edge).floor();
        let (low, high) = (cell(bounds.low).to_array(), cell(bounds.high).to_array());
        // Boxes beside the grid touch nothing.
        let range = |axis: usize| low[axis].max(0.0) as usize..(high[axis] + 1.0).clamp(0.0, dims[axis] as f64) as usize;
        let (x, y, z) = (range(0), range(1), range(2));
        z.flat_map(move |z| {
            let x = x.clone();
            y.clone().flat_map(move |y| x.clone().map(move |x| (z * dims[1] + y) * dims[0] + x))
        })
    }
}

impl Tables {
    /// The gathered stars, and behind the `bricks` the lists of the grid.
    pub fn many_lights(&mut self, plan: &Plan, weights: &Weights, room: usize, bricks: &mut Vec<u32>) {
        self.begin("MANY_LIGHTS_HEAD");
        let (Some((many_lights, scattered_field)), Some(occupied)) = (fields(plan), plan.space().occupied) else {
            return self.begin("MANY_LIGHTS_STARS");
        };
        let kernels = scattered_field.kernels();
        let grid = StarGrid::new(occupied, kernels);
        // A segment is known by its middle.
        let longest = match plan.stepping() {
            Stepping::PerVoxel(n) | Stepping::Paired(n) => plan.space().voxel_pc() / n,
            Stepping::Fixed(n) => occupied.size().length() / n as f64,
        };
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); grid.dims.iter().product()];
        for (star, (place, kernel)) in many_lights.places.iter().zip(kernels).enumerate() {
            let bounds = kernel.bounds(scattered_field.towards_eye(*place));
            let reached = Bounds { low: *place + bounds.low - 0.5 * longest, high: *place + bounds.high + 0.5 * longest };
            grid.touched(reached).for_each(|cell| lists[cell].push(star as u32));
        }
        let cells = bricks.len();
        let mut first = (cells + lists.len() + 1) as u32;
        for list in &lists {
            bricks.push(first);
            first += list.len() as u32;
        }
        bricks.push(first);
        bricks.extend(lists.into_iter().flatten());
        self.place(grid.low, (1.0 / grid.edge) as f32);
        let [x, y, z] = grid.dims.map(|n| n as f32);
        self.list.0.push([x, y, z, cells as f32]);
        let piece = near_field_piece(plan.spectral().phase_angle, plan.spectral().accuracy);
        self.list.0.push([piece as f32, 0.0, 0.0, 0.0]);
        self.begin("MANY_LIGHTS_STARS");
        for (star, weights) in weights.many_lights.iter().enumerate() {
            self.place(many_lights.places[star], many_lights.sigma[star]);
            let kernel = kernels[star];
            let (shape, ahead) = (kernel.shape(), kernel.ahead_pc / kernel.reach_pc);
            self.list.0.push([kernel.reach_pc, ahead, f64::from(shape.flat), PROFILE as f64 / kernel.ahead_pc].map(|v| v as f32));
            self.list.numbers(&scattered_field.profiles[star][1..], 0);
            self.list.numbers(weights, room / 4);
        }
    }
}
