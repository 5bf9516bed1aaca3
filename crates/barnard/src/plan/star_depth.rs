//! Star depths: the optical depth at V from a star to every voxel centre, each by a march of its own.
//!
//! A sweep would cost O(1) a voxel, but interpolates what it has interpolated before and smears shadows; a march costs O(N) a voxel and none of its
//! error travels. Sixteen neighbours are marched together, by the midpoint rule with `PER_VOXEL` samples a voxel edge. Voxels around which there is
//! no dust scatter nothing and are left at zero; a march stops where nothing is left of the light.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use multiversion::multiversion;
use rayon::prelude::*;

use crate::control::{Control, Stage};
use crate::error::Result;
use crate::field::Lattice;
use crate::geometry::Ray;
use crate::packet::{Cursor, LANES, lanes, largest};
use crate::plan::{Bricks, Volume};

/// Depth past which light is gone: e^(−80) is below the smallest f32 beside 1.
pub const OPAQUE: f64 = 80.0;

/// Samples in a voxel edge of the dust: the trilinear field has kinks, but no structure, below one voxel.
const PER_VOXEL: f64 = 2.0;

/// Depths from `star` on `lattice`, through `dust` (σ at V [pc⁻¹], the volume's only channel).
pub fn bake(dust: &Volume, bricks: &Bricks, lattice: &Lattice, star: DVec3, share: (u64, u64), control: &Control) -> Result<Vec<f32>> {
    let row = lattice.dims[0];
    let mut depths = vec![0.0f32; lattice.cells()];
    let (before, all) = share;
    let done = AtomicU64::new(0);
    depths.par_chunks_mut(row).enumerate().try_for_each(|(r, values)| {
        control.check()?;
        let [_, y, z] = lattice.place(r * row);
        for (packet, values) in values.chunks_mut(LANES).enumerate() {
            // The last packet of a row repeats its last voxel.
            let centre = |lane: usize| lattice.centre((packet * LANES + lane).min(row - 1), y, z);
            let centres: [DVec3; LANES] = std::array::from_fn(centre);
            if centres.iter().any(|c| dusty(bricks, *c)) {
                values.copy_from_slice(&depths_of(dust, 0, star, &centres, None)[..values.len()]);
            }
        }
        let count = done.fetch_add(row as u64, Ordering::Relaxed) + row as u64;
        control.report(Stage::StarDepths, before + count, all);
        Ok::<(), crate::Error>(())
    })?;
    Ok(depths)
}

/// Depths from `star` to sixteen places through channel `slot` of `dust`, with `steps` samples or `PER_VOXEL` of them a voxel.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq+avx2+fma+bmi1+bmi2", "x86_64+avx2+fma+bmi1+bmi2", "aarch64+neon"))]
pub fn depths_of(dust: &Volume, slot: usize, star: DVec3, places: &[DVec3; LANES], steps: Option<usize>) -> [f32; LANES] {
    let rays: [(Ray, f64); LANES] = std::array::from_fn(|lane| Ray::between(star, places[lane]));
    let inside = |lane: usize| dust.lattice.bounds.clip(&rays[lane].0).map_or((0.0, 0.0), |(near, far)| (near, far.min(rays[lane].1)));
    let spans: [(f64, f64); LANES] = std::array::from_fn(inside);
    let length = lanes(|lane| (spans[lane].1 - spans[lane].0).max(0.0) as f32);
    let natural = f64::from(largest(&length)) / dust.lattice.voxel_pc().min_element() * PER_VOXEL;
    let steps = steps.unwrap_or(natural.ceil().max(1.0) as usize);
    let dt = lanes(|lane| length[lane] / steps as f32);
    let cursor = Cursor::new(dust, &std::array::from_fn(|lane| rays[lane].0), &std::array::from_fn(|lane| spans[lane].0));
    let mut sum = [0.0; LANES];
    for step in 0..steps {
        let t = lanes(|lane| (step as f32 + 0.5) * dt[lane]);
        let mut values = [[0.0; LANES]; crate::plan::MAX_CHANNELS];
        cursor.read(&t, &mut values);
        for lane in 0..LANES {
            sum[lane] += values[slot][lane] * dt[lane];
        }
        if step % 16 == 15 && sum.iter().all(|s| *s > OPAQUE as f32) {
            break;
        }
    }
    lanes(|lane| if sum[lane] > OPAQUE as f32 { OPAQUE as f32 } else { sum[lane] })
}

/// Whether a sample near this voxel centre can meet dust: its own brick, or a neighbour closer than a voxel, is not empty.
fn dusty(bricks: &Bricks, centre: DVec3) -> bool {
    let edge = bricks.lattice.voxel_pc();
    let reach = 1.001 / super::bricks::BRICK as f64;
    let u = (centre - bricks.lattice.bounds.low) / edge;
    let range = |axis: usize| {
        let last = bricks.lattice.dims[axis] as i64 - 1;
        ((u[axis] - reach).floor() as i64).clamp(0, last)..=((u[axis] + reach).floor() as i64).clamp(0, last)
    };
    range(2).any(|z| range(1).any(|y| range(0).any(|x| bricks.majorant[bricks.lattice.index(x as usize, y as usize, z as usize)] > 0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Grid;
    use crate::geometry::Bounds;
    use crate::plan::Channel;

    /// Marched depths against exact columns, for stars inside and outside.
    #[test]
    fn marches_agree_with_exact_columns() {
        let lattice = Lattice { dims: [33, 20, 27], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let grid = Grid::sampled(lattice.clone(), |p| 4.0 * (0.5 + 0.5 * (9.0 * p.x).sin() * (7.0 * p.y + 3.0 * p.z).cos()));
        let volume = Volume::new(&lattice, &[(Channel::Dust, &grid.data)]);
        let bricks = Bricks::new(&grid);
        for star in [DVec3::new(0.1, -0.2, 0.3), DVec3::new(3.0, 0.5, 0.2), DVec3::new(0.0, 0.0, -500.0)] {
            let depths = bake(&volume, &bricks, &lattice, star, (0, 1), &Control::default()).unwrap();
            for (index, depth) in depths.iter().enumerate() {
                let [x, y, z] = lattice.place(index);
                let exact = grid.column(star, lattice.centre(x, y, z), f64::INFINITY);
                assert!((f64::from(*depth) - exact).abs() < 4e-3 + 2e-3 * exact, "{star} {index}: {depth} {exact}");
            }
        }
    }
}
