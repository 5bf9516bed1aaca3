//! Radiance of each light at nodes shared by all bands, as combinations of them: the march of plates.

use spectra::simd;

use super::march::March;
use super::tables::Tables;
use super::{RayPacket, RenderStats, marched, stats_of};
use crate::control::Control;
use crate::error::Result;
use crate::light::Route;
use crate::packet::{LANES, Lane, fma, lanes, largest};
use crate::plan::Plan;

/// Combinations of what lights send at nodes.
pub(crate) struct Combined {
    /// Light × combination × height × width.
    pub data: Vec<f32>,
    /// Measurements of the march.
    pub stats: RenderStats,
}

/// Combinations Σ_j r_j G_j of what each of some lights of a plan sends at its common nodes, a `row` for each: G is that of a light whose
/// spectral factor is one. Rays are followed to the end of the dust, since other spectra may have light there.
///
/// # Errors
/// On interruption by the user.
pub(crate) fn combined(plan: &Plan, lights: &[usize], rows: &[Vec<f32>], control: &Control) -> Result<Combined> {
    let tables = Tables::new(plan);
    let march = March::new(plan, &tables, None).whole();
    let k = tables.terms.exponentials().map_or(&[][..], |nodes| &nodes.k);
    let packet = |(rays, numbers): RayPacket| {
        let state = march.light(rays, numbers);
        let mut out = vec![0.0; lights.len() * rows.len() * LANES];
        let mut deepest = largest(&state.deepest);
        for (light, out) in lights.iter().zip(out.chunks_exact_mut(rows.len() * LANES)) {
            if plan.lights[*light].route == Route::Background {
                let left: Vec<Lane> = k.iter().map(|k| lanes!(|lane| (-k * state.tau[lane]).exp())).collect();
                deepest = deepest.max(largest(&state.tau));
                combine(rows, &left, out);
            } else {
                combine(rows, &state.sum[tables.terms.start(*light)..][..k.len()], out);
            }
        }
        (out, deepest)
    };
    let (data, depth) = marched(&plan.camera, lights.len() * rows.len(), packet, control)?;
    Ok(Combined { data, stats: stats_of(plan, depth, 0) })
}

simd! {
    fn combine(rows: &[Vec<f32>], nodes: &[Lane], out: &mut [f32]) {
        for (row, out) in rows.iter().zip(out.chunks_exact_mut(LANES)) {
            let mut sum = [0.0; LANES];
            for (weight, node) in row.iter().zip(nodes) {
                for lane in 0..LANES {
                    sum[lane] = fma(*weight, node[lane], sum[lane]);
                }
            }
            out.copy_from_slice(&sum);
        }
    }
}
