//! The light of one segment, for sixteen rays: the closed forms of `plan::segment` in f32.

use smallvec::SmallVec;

use super::march::{March, StarView, State, StepSpan};
use super::near_field::NearStar;
use super::propagation;
use super::terms::{DepthSpan, Terms};
use crate::packet::{LANES, Lane, fma, lanes, largest};
use crate::plan::Scatterer;
use crate::plan::near;
use crate::plan::near::{NEAR_ANGLE, NEAR_VOXELS};

/// Adds the light of one segment and moves τ to its end.
#[inline(always)]
pub(super) fn segment(
    march: &March,
    state: &mut State,
    (views, near_field): (&[StarView], &[NearStar]),
    stretch: StepSpan,
    before: &[Lane],
    after: &[Lane],
) {
    let dt = lanes(|lane| stretch.length * state.dt[lane]);
    let growth = match march.slots.dust {
        Some(dust) => lanes(|lane| 0.5 * dt[lane] * (before[dust][lane] + after[dust][lane])),
        None => [0.0; LANES],
    };
    if let Some(gathered) = march.tables.gathered.as_ref().filter(|_| largest(&growth) > 0.0) {
        propagation::gather(march, gathered, state, &growth, (before, after));
    } else if largest(&growth) > 0.0 {
        // What σ grows by in parts of its mean.
        let tilt = match march.slots.dust.filter(|_| march.plan.spectral.phase.is_some()) {
            Some(dust) => lanes(|lane| {
                let (a, b) = (before[dust][lane], after[dust][lane]);
                if a + b > 0.0 { 2.0 * (b - a) / (a + b) } else { 0.0 }
            }),
            None => [0.0; LANES],
        };
        for (scatterer, view) in march.tables.weights.scattered.iter().zip(views) {
            let slot = march.slots.stars[scatterer.star];
            scatter(march, state, (scatterer, view), stretch, (&growth, &tilt), (&before[slot], &after[slot]));
        }
    }
    if let Some(dust) = march.slots.dust.filter(|_| largest(&growth) > 0.0) {
        for near_star in near_field.iter().filter(|n| n.meets(stretch)) {
            near_star.scatter(march, state, stretch, &growth, (&before[dust], &after[dust]));
        }
    }
    if !march.slots.scattered_field.is_empty() && largest(&growth) > 0.0 {
        scatter_again(march, state, &growth, (before, after));
    }
    if !march.tables.weights.emitted.is_empty() {
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
    stretch: StepSpan,
    (growth, tilt): (&Lane, &Lane),
    depths: (&Lane, &Lane),
) {
    let middle = lanes(|lane| state.tau[lane] + 0.5 * (growth[lane] + depths.0[lane] + depths.1[lane]));
    let half = lanes(|lane| 0.5 * (growth[lane] + depths.1[lane] - depths.0[lane]));
    // ⟨1/r²⟩ = atan(q)/(q p), q = b Δt/p, p = b² + t₀t₁; segments that a star sees under a wide angle go another way.
    let reach = (NEAR_VOXELS * march.voxel_pc) as f32;
    let length = lanes(|lane| stretch.length * state.dt[lane]);
    let (mut close, mut base, mut along) = ([false; LANES], [0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let (b, dt) = (view.distance[lane], length[lane]);
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
    let span = DepthSpan { middle, half };
    match &march.plan.spectral.phase {
        None => terms.gather(light, &state.drawn, &span, |term| Some(scaled(&base, weights[term])), &mut state.sum),
        Some(table) => {
            let widest = largest(&lanes(|lane| base[lane] / growth[lane].max(f32::MIN_POSITIVE) * view.distance[lane] * length[lane]));
            let phases = near::phases(f64::from(widest), march.plan.spectral.phase_angle);
            let angles = angles(march, view, &along, &length, tilt, phases);
            if table.separable {
                let values = &table.weights[light];
                let mut spread = [0.0; LANES];
                for (entry, share) in &angles {
                    for lane in 0..LANES {
                        let (i, f) = entry[lane];
                        spread[lane] += base[lane] * share[lane] * (values[i] + f * (values[i + 1] - values[i]));
                    }
                }
                terms.gather(light, &state.drawn, &span, |term| Some(scaled(&spread, weights[term])), &mut state.sum);
            } else if let [(entry, _)] = &angles[..] {
                let of_term = |term: usize| Some(lanes(|lane| base[lane] * march.phase_weight(scatterer, term, entry[lane])));
                terms.gather(light, &state.drawn, &span, of_term, &mut state.sum);
            } else {
                let of_term = |term: usize| {
                    let mut spread = [0.0; LANES];
                    for (entry, share) in &angles {
                        for lane in 0..LANES {
                            spread[lane] += base[lane] * share[lane] * march.phase_weight(scatterer, term, entry[lane]);
                        }
                    }
                    Some(spread)
                };
                terms.gather(light, &state.drawn, &span, of_term, &mut state.sum);
            }
        }
    }
    if close.contains(&true) {
        march.near(state, scatterer, &close, stretch, growth);
    }
}

/// Entry and fraction of the phase table, and the share of the light, lane by lane.
type Angle = ([(usize, f32); LANES], Lane);

/// Entries of the phase table and shares of the light at some angles of a segment, which go as σ/r²; one angle in its
/// middle, mostly.
#[inline(always)]
fn angles(march: &March, view: &StarView, along: &Lane, length: &Lane, tilt: &Lane, phases: usize) -> SmallVec<[Angle; 1]> {
    let mut angles: SmallVec<[Angle; 1]> = SmallVec::new();
    let mut sum = [0.0; LANES];
    for j in 0..phases {
        let part = (j as f32 + 0.5) / phases as f32 - 0.5;
        let (mut entry, mut share) = ([(0, 0.0); LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let t = fma(part, length[lane], along[lane]);
            let r2 = fma(t, t, view.distance[lane] * view.distance[lane]);
            let inverse = if r2 > 0.0 { 1.0 / r2 } else { 0.0 };
            let b = view.distance[lane];
            entry[lane] = march.phase_entry(-t * inverse.sqrt(), b * b * inverse);
            share[lane] = fma(part, tilt[lane], 1.0) * inverse;
            sum[lane] += inverse;
        }
        angles.push((entry, share));
    }
    for (_, share) in &mut angles {
        for lane in 0..LANES {
            share[lane] = if sum[lane] > 0.0 { share[lane] / sum[lane] } else { 0.0 };
        }
    }
    angles
}

/// Each lane times one number.
#[inline(always)]
fn scaled(lane: &Lane, factor: f32) -> Lane {
    lanes(|i| lane[i] * factor)
}

/// Light of one segment that was scattered before.
#[inline(always)]
fn scatter_again(march: &March, state: &mut State, growth: &Lane, (before, after): (&[Lane], &[Lane])) {
    let Terms::Nodes(nodes) = &march.tables.terms else { return };
    let span = DepthSpan { middle: lanes(|lane| state.tau[lane] + 0.5 * growth[lane]), half: scaled(growth, 0.5) };
    let base = |term: usize| {
        let slot = march.slots.scattered_field[term];
        Some(lanes(|lane| 0.5 * nodes.k[term] * growth[lane] * (before[slot][lane] + after[slot][lane])))
    };
    march.tables.terms.gather(0, &state.drawn, &span, base, &mut state.sum);
    if march.plan.space.many_lights.is_some() {
        // Stars that are gathered may be as deep as any.
        let behind = march.plan.space.star_depth as f32;
        for lane in 0..LANES {
            let depth = if growth[lane] > 0.0 { state.tau[lane] + growth[lane] + behind } else { 0.0 };
            state.deepest[lane] = state.deepest[lane].max(depth);
        }
    }
}

/// Light of all species in one segment.
#[inline(always)]
fn emit(march: &March, state: &mut State, dt: &Lane, growth: &Lane, (before, after): (&[Lane], &[Lane])) {
    let span = DepthSpan { middle: lanes(|lane| state.tau[lane] + 0.5 * growth[lane]), half: scaled(growth, 0.5) };
    for emitter in &march.tables.weights.emitted {
        let slot = march.slots.species[emitter.species];
        let base = lanes(|lane| 0.5 * dt[lane] * (before[slot][lane] + after[slot][lane]));
        if largest(&base) > 0.0 {
            let of_term = |term: usize| (emitter.weights[term] != 0.0).then(|| scaled(&base, emitter.weights[term]));
            march.tables.terms.gather(emitter.light, &state.drawn, &span, of_term, &mut state.sum);
        }
    }
}
