//! The light of one segment, for sixteen rays: the closed forms of `plan::segment` in f32.

use super::march::{March, StarView, State, Stretch};
use super::tables::Scatterer;
use super::terms::Course;
use crate::packet::{LANES, Lane, fma, lanes, largest};
use crate::plan::near::{NEAR_ANGLE, NEAR_VOXELS};

/// Adds the light of one segment and moves τ to its end.
#[inline(always)]
pub(super) fn segment(march: &March, state: &mut State, views: &[StarView], stretch: Stretch, before: &[Lane], after: &[Lane]) {
    let dt = lanes(|lane| stretch.length * state.dt[lane]);
    let growth = match march.slots.dust {
        Some(dust) => lanes(|lane| 0.5 * dt[lane] * (before[dust][lane] + after[dust][lane])),
        None => [0.0; LANES],
    };
    if largest(&growth) > 0.0 {
        for (scatterer, view) in march.tables.scattered.iter().zip(views) {
            let slot = march.slots.stars[scatterer.star];
            scatter(march, state, (scatterer, view), stretch, &growth, (&before[slot], &after[slot]));
        }
    }
    if !march.tables.emitted.is_empty() {
        emit(march, state, &dt, &growth, (before, after));
    }
    for lane in 0..LANES {
        state.tau[lane] += growth[lane];
    }
}

/// Light of one star, scattered in one segment.
#[inline(always)]
fn scatter(
    march: &March,
    state: &mut State,
    (scatterer, view): (&Scatterer, &StarView),
    stretch: Stretch,
    growth: &Lane,
    depths: (&Lane, &Lane),
) {
    let middle = lanes(|lane| state.tau[lane] + 0.5 * (growth[lane] + depths.0[lane] + depths.1[lane]));
    let half = lanes(|lane| 0.5 * (growth[lane] + depths.1[lane] - depths.0[lane]));
    // ⟨1/r²⟩ = atan(q)/(q p), q = b Δt/p, p = b² + t₀t₁; segments that a star sees under a wide angle go another way.
    let reach = (NEAR_VOXELS * march.voxel_pc) as f32;
    let (mut close, mut base, mut along) = ([false; LANES], [0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let (b, dt) = (view.distance[lane], stretch.length * state.dt[lane]);
        let t0 = fma(stretch.start, state.dt[lane], -view.foot[lane]);
        let p = fma(b, b, t0 * (t0 + dt));
        let near = p < reach * reach || b * dt > NEAR_ANGLE as f32 * p;
        let inverse = 1.0 / if near { 1.0 } else { p };
        let q = b * dt * inverse;
        let q2 = q * q;
        let mean = inverse * fma(q2, fma(q2, fma(q2, fma(q2, 1.0 / 9.0, -1.0 / 7.0), 1.0 / 5.0), -1.0 / 3.0), 1.0);
        close[lane] = near && growth[lane] > 0.0;
        base[lane] = if near { 0.0 } else { mean * growth[lane] };
        along[lane] = t0 + 0.5 * dt;
    }
    for lane in 0..LANES {
        let a = if growth[lane] > 0.0 { middle[lane] + half[lane].abs() } else { 0.0 };
        state.deepest[lane] = if a > state.deepest[lane] { a } else { state.deepest[lane] };
    }
    let (weights, terms, light) = (&scatterer.weights[..], &march.tables.terms, scatterer.light);
    let course = Course { middle, half };
    match &march.plan.spectral.phase {
        None => terms.gather(light, &state.drawn, &course, |term| Some(scaled(&base, weights[term])), &mut state.sum),
        Some(table) => {
            let mut entry = [(0, 0.0); LANES];
            for lane in 0..LANES {
                let r = (view.distance[lane] * view.distance[lane] + along[lane] * along[lane]).sqrt();
                entry[lane] = march.phase_entry(-along[lane] / if r > 0.0 { r } else { 1.0 });
            }
            if table.separable {
                let values = &table.weights[scatterer.light];
                let spread = lanes(|lane| {
                    let (i, f) = entry[lane];
                    base[lane] * (values[i] + f * (values[i + 1] - values[i]))
                });
                terms.gather(light, &state.drawn, &course, |term| Some(scaled(&spread, weights[term])), &mut state.sum);
            } else {
                let of_term = |term: usize| Some(lanes(|lane| base[lane] * march.phase_weight(scatterer, term, entry[lane])));
                terms.gather(light, &state.drawn, &course, of_term, &mut state.sum);
            }
        }
    }
    if close.contains(&true) {
        march.near(state, scatterer, &close, stretch, growth);
    }
}

/// Each lane times one number.
#[inline(always)]
fn scaled(lane: &Lane, factor: f32) -> Lane {
    lanes(|i| lane[i] * factor)
}

/// Light of all species in one segment.
#[inline(always)]
fn emit(march: &March, state: &mut State, dt: &Lane, growth: &Lane, (before, after): (&[Lane], &[Lane])) {
    let course = Course { middle: lanes(|lane| state.tau[lane] + 0.5 * growth[lane]), half: scaled(growth, 0.5) };
    for (light, species, weights) in &march.tables.emitted {
        let slot = march.slots.species[*species];
        let base = lanes(|lane| 0.5 * dt[lane] * (before[slot][lane] + after[slot][lane]));
        if largest(&base) > 0.0 {
            let of_term = |term: usize| (weights[term] > 0.0).then(|| scaled(&base, weights[term]));
            march.tables.terms.gather(*light, &state.drawn, &course, of_term, &mut state.sum);
        }
    }
}
