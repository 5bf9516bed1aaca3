//! The light of one segment, for sixteen rays: the closed forms of `plan::segment` in f32.

use smallvec::SmallVec;

use super::context::Context;
use super::near_field::NearStar;
use super::propagation;
use super::segment::Segment;
use super::state::{StarView, State};
use super::terms::{DepthSpan, Terms};
use crate::packet::{LANES, Lane, fma, lanes, largest};
use crate::plan::near::{NEAR_ANGLE, NEAR_VOXELS, NearPiece};
use crate::plan::{PhaseEntry, PhaseTable, Scatterer};
use crate::plan::{near, segment as plan_segment};

/// What a segment holds of a star's light where a mean of 1/r² does: ∫ σ/r² dt, zero on lanes that are close to the
/// star, and how far the segment's middle lies behind the foot.
struct Irradiated {
    close: [bool; LANES],
    base: Lane,
    along: Lane,
}

/// Adds the light of a segment and moves τ to its end.
#[inline(always)]
pub(super) fn add(segment: &Segment, context: &Context, state: &mut State, views: &[StarView], near_field: &[NearStar]) {
    if largest(&segment.growth) > 0.0 {
        match &context.tables.light_sums {
            Some(sums) => propagation::accumulate(context, sums, state, segment),
            None => scatter_stars(segment, context, state, views),
        }
        for near_star in near_field.iter().filter(|n| n.meets(segment.span)) {
            near_star.scatter(context, state, segment);
        }
        if !context.slots.scattered_field.is_empty() {
            scatter_again(segment, context, state);
        }
    }
    if !context.tables.weights.emitted.is_empty() {
        emit(segment, context, state);
    }
    for lane in 0..LANES {
        state.tau[lane] += segment.growth[lane];
    }
}

/// Light of the stars that have depths of their own, scattered once.
#[inline(always)]
fn scatter_stars(segment: &Segment, context: &Context, state: &mut State, views: &[StarView]) {
    // What σ grows by in parts of its mean.
    let tilt = match context.slots.dust.filter(|_| context.plan.spectral.phase.is_some()) {
        Some(dust) => lanes(|lane| {
            let (a, b) = (segment.before[dust][lane], segment.after[dust][lane]);
            if a + b > 0.0 { 2.0 * (b - a) / (a + b) } else { 0.0 }
        }),
        None => [0.0; LANES],
    };
    for (scatterer, view) in context.tables.weights.scattered.iter().zip(views) {
        scatter(segment, context, state, scatterer, view, &tilt);
    }
}

/// Light of one star, scattered once.
#[inline(always)]
fn scatter(segment: &Segment, context: &Context, state: &mut State, scatterer: &Scatterer, view: &StarView, tilt: &Lane) {
    let slot = context.slots.stars[scatterer.star];
    let (growth, before, after) = (&segment.growth, &segment.before[slot], &segment.after[slot]);
    let middle = lanes(|lane| state.tau[lane] + 0.5 * (growth[lane] + before[lane] + after[lane]));
    let half = lanes(|lane| 0.5 * (growth[lane] + after[lane] - before[lane]));
    let irradiated = irradiated(segment, context, state, view);
    for lane in 0..LANES {
        let a = if growth[lane] > 0.0 { middle[lane] + half[lane].abs() } else { 0.0 };
        state.deepest[lane] = if a > state.deepest[lane] { a } else { state.deepest[lane] };
    }
    let span = DepthSpan { middle, half };
    let Irradiated { close, base, along } = &irradiated;
    match &context.plan.spectral.phase {
        None => {
            let of_term = |term: usize| Some(scaled(base, scatterer.weights[term]));
            context.tables.terms.accumulate(scatterer.light, &state.drawn, &span, of_term, &mut state.sum);
        }
        Some(table) => {
            let widest =
                largest(&lanes(|lane| base[lane] / growth[lane].max(f32::MIN_POSITIVE) * view.distance[lane] * segment.length[lane]));
            let phases = near::phases(f64::from(widest), context.plan.spectral.phase_angle);
            let angles = angles(segment, context, view, along, tilt, phases);
            scatter_at(context, state, scatterer, table, &span, base, &angles);
        }
    }
    if close.contains(&true) {
        scatter_close(segment, context, state, scatterer, close);
    }
}

/// ⟨1/r²⟩ = atan(q)/(q p), q = b Δt/p, p = b² + t₀t₁; segments that a star sees under a wide angle go another way.
#[inline(always)]
fn irradiated(segment: &Segment, context: &Context, state: &State, view: &StarView) -> Irradiated {
    let reach = (NEAR_VOXELS * context.voxel_pc) as f32;
    let mut irradiated = Irradiated { close: [false; LANES], base: [0.0; LANES], along: [0.0; LANES] };
    for lane in 0..LANES {
        let (b, dt, growth) = (view.distance[lane], segment.length[lane], segment.growth[lane]);
        let t0 = fma(segment.span.start, state.dt[lane], -view.foot[lane]);
        let p = fma(b, b, t0 * (t0 + dt));
        let near = p < reach * reach || b * dt > NEAR_ANGLE as f32 * p;
        let inverse = 1.0 / if near { 1.0 } else { p };
        let q = b * dt * inverse;
        let q2 = q * q;
        let mean = inverse * fma(q2, fma(q2, fma(q2, fma(q2, 1.0 / 9.0, -1.0 / 7.0), 1.0 / 5.0), -1.0 / 3.0), 1.0);
        irradiated.close[lane] = near && growth > 0.0;
        irradiated.base[lane] = if near { 0.0 } else { mean * growth };
        irradiated.along[lane] = t0 + 0.5 * dt;
    }
    irradiated
}

/// Some angles under which the segment scatters, by their shares of the light, which go as σ/r²; one in its middle,
/// mostly.
#[inline(always)]
fn angles(segment: &Segment, context: &Context, view: &StarView, along: &Lane, tilt: &Lane, phases: usize) -> SmallVec<[Angle; 1]> {
    let mut angles: SmallVec<[Angle; 1]> = SmallVec::new();
    let mut sum = [0.0; LANES];
    for j in 0..phases {
        let part = (j as f32 + 0.5) / phases as f32 - 0.5;
        let mut angle = Angle { entry: [PhaseEntry::default(); LANES], share: [0.0; LANES] };
        for lane in 0..LANES {
            let t = fma(part, segment.length[lane], along[lane]);
            let r2 = fma(t, t, view.distance[lane] * view.distance[lane]);
            let inverse = if r2 > 0.0 { 1.0 / r2 } else { 0.0 };
            let b = view.distance[lane];
            angle.entry[lane] = context.phase_entry(-t * inverse.sqrt(), b * b * inverse);
            angle.share[lane] = fma(part, tilt[lane], 1.0) * inverse;
            sum[lane] += inverse;
        }
        angles.push(angle);
    }
    for angle in &mut angles {
        for lane in 0..LANES {
            angle.share[lane] = if sum[lane] > 0.0 { angle.share[lane] / sum[lane] } else { 0.0 };
        }
    }
    angles
}

/// Light of a star on the lanes that are close to it: in pieces, lane by lane.
fn scatter_close(segment: &Segment, context: &Context, state: &mut State, scatterer: &Scatterer, close: &[bool; LANES]) {
    let star = context.plan.space.stars[scatterer.star];
    let resolution = near::Resolution { phase_angle: context.plan.spectral.phase_angle, fineness: 1.0 };
    for lane in (0..LANES).filter(|lane| close[*lane]) {
        let at = |steps: f32| state.span.0[lane] + f64::from(steps) * f64::from(state.dt[lane]);
        let own = plan_segment::Segment {
            from: at(segment.span.start),
            to: at(segment.span.end()),
            tau: f64::from(state.tau[lane]),
            growth: f64::from(segment.growth[lane]),
        };
        let add = |piece: NearPiece| {
            let phase = context.phase_entry(piece.cosine as f32, (1.0 - piece.cosine * piece.cosine) as f32);
            for term in 0..context.tables.weights.band_of.len() {
                let weight = context.phase_weight(scatterer, term, phase);
                let decay = context.tables.terms.at(scatterer.light, &state.drawn, lane, term, piece.depth as f32);
                state.sum[term][lane] += piece.scattering as f32 * weight * decay;
            }
        };
        near::pieces(near::samples(&context.plan.space, star), resolution, star, &state.rays[lane], &own, add);
    }
}

/// Light that was scattered before.
#[inline(always)]
fn scatter_again(segment: &Segment, context: &Context, state: &mut State) {
    let Terms::Nodes(nodes) = &context.tables.terms else { return };
    let (growth, before, after) = (&segment.growth, segment.before, segment.after);
    let span = DepthSpan { middle: lanes(|lane| state.tau[lane] + 0.5 * growth[lane]), half: scaled(growth, 0.5) };
    let base = |term: usize| {
        let slot = context.slots.scattered_field[term];
        Some(lanes(|lane| 0.5 * nodes.k[term] * growth[lane] * (before[slot][lane] + after[slot][lane])))
    };
    context.tables.terms.accumulate(0, &state.drawn, &span, base, &mut state.sum);
    if context.plan.space.many_lights.is_some() {
        // Stars that are gathered may be as deep as any.
        let behind = context.plan.space.star_depth as f32;
        for lane in 0..LANES {
            let depth = if growth[lane] > 0.0 { state.tau[lane] + growth[lane] + behind } else { 0.0 };
            state.deepest[lane] = state.deepest[lane].max(depth);
        }
    }
}

/// Adds the light that all species of gas send out along the segment.
#[inline(always)]
fn emit(segment: &Segment, context: &Context, state: &mut State) {
    let (growth, before, after) = (&segment.growth, segment.before, segment.after);
    let span = DepthSpan { middle: lanes(|lane| state.tau[lane] + 0.5 * growth[lane]), half: scaled(growth, 0.5) };
    for emitter in &context.tables.weights.emitted {
        let slot = context.slots.species[emitter.species];
        let base = lanes(|lane| 0.5 * segment.length[lane] * (before[slot][lane] + after[slot][lane]));
        if largest(&base) > 0.0 {
            let of_term = |term: usize| (emitter.weights[term] != 0.0).then(|| scaled(&base, emitter.weights[term]));
            context.tables.terms.accumulate(emitter.light, &state.drawn, &span, of_term, &mut state.sum);
        }
    }
}

/// An angle under which a segment scatters: entry and fraction of the phase table, and the share of the light.
struct Angle {
    entry: [PhaseEntry; LANES],
    share: Lane,
}

/// Adds a star's light, `base` of it in each segment, scattered under these angles.
#[inline(always)]
fn scatter_at(
    context: &Context,
    state: &mut State,
    scatterer: &Scatterer,
    table: &PhaseTable,
    span: &DepthSpan,
    base: &Lane,
    angles: &[Angle],
) {
    let terms = &context.tables.terms;
    if table.separable {
        let values = &table.weights[scatterer.light];
        let mut spread = [0.0; LANES];
        for Angle { entry, share } in angles {
            for lane in 0..LANES {
                let PhaseEntry { entry: i, fraction: f } = entry[lane];
                spread[lane] += base[lane] * share[lane] * (values[i] + f * (values[i + 1] - values[i]));
            }
        }
        terms.accumulate(scatterer.light, &state.drawn, span, |term| Some(scaled(&spread, scatterer.weights[term])), &mut state.sum);
    } else if let [Angle { entry, .. }] = angles {
        let of_term = |term: usize| Some(lanes(|lane| base[lane] * context.phase_weight(scatterer, term, entry[lane])));
        terms.accumulate(scatterer.light, &state.drawn, span, of_term, &mut state.sum);
    } else {
        let of_term = |term: usize| {
            let mut spread = [0.0; LANES];
            for Angle { entry, share } in angles {
                for lane in 0..LANES {
                    spread[lane] += base[lane] * share[lane] * context.phase_weight(scatterer, term, entry[lane]);
                }
            }
            Some(spread)
        };
        terms.accumulate(scatterer.light, &state.drawn, span, of_term, &mut state.sum);
    }
}

/// Multiplies each lane by one number.
#[inline(always)]
fn scaled(lane: &Lane, factor: f32) -> Lane {
    lanes(|i| lane[i] * factor)
}
