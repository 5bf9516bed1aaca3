//! Star depths: the optical depth at V from a star to every voxel centre, by exact marches.
//!
//! A sweep would cost O(1) a voxel, but interpolates what it has interpolated before and smears shadows; an exact march costs O(N) a voxel and none of its
//! error travels. Voxels around which there is no dust scatter nothing and are left at zero; a march stops where nothing is left of the light.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::control::{Control, Stage};
use crate::error::Result;
use crate::field::{Grid, Lattice};
use crate::plan::Bricks;

/// Depth past which light is gone: e^(−80) is below the smallest f32 beside 1.
pub const OPAQUE: f64 = 80.0;

/// Depths from `star` on `lattice`, through `dust` (σ at V [pc⁻¹]).
pub fn bake(dust: &Grid, bricks: &Bricks, lattice: &Lattice, star: DVec3, share: (u64, u64), control: &Control) -> Result<Vec<f32>> {
    let row = lattice.dims[0];
    let mut depths = vec![0.0f32; lattice.cells()];
    let (before, all) = share;
    let done = AtomicU64::new(0);
    depths.par_chunks_mut(row).enumerate().try_for_each(|(r, values)| {
        control.check()?;
        let [_, y, z] = lattice.place(r * row);
        for (x, value) in values.iter_mut().enumerate() {
            let centre = lattice.centre(x, y, z);
            if dusty(bricks, centre) {
                *value = dust.column(star, centre, OPAQUE).min(OPAQUE) as f32;
            }
        }
        let count = done.fetch_add(row as u64, Ordering::Relaxed) + row as u64;
        control.report(Stage::StarDepths, before + count, all);
        Ok::<(), crate::Error>(())
    })?;
    Ok(depths)
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
