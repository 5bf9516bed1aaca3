//! The light of one segment, for sixteen rays: the closed forms of `plan::segment` in f32.

use glam::DVec3;
use smallvec::SmallVec;

use super::context::Context;
use super::near_field::NearStar;
use super::phase_rows::PhaseEntries;
use super::propagation;
use super::segment::Segment;
use super::state::{PacketState, StarView};
use super::tables::Tables;
use super::terms::{Bases, DepthSpan, Terms};
use crate::packet::{LANES, Lane, fma, lanes, largest};
use crate::plan::Scatterer;
use crate::plan::near::{DustNearby, NEAR_ANGLE, NEAR_VOXELS, NearPiece};
use crate::plan::{near, segment as plan_segment};

/// Starlight in a segment with a mean of 1/r²: ∫ σ/r² dt, zero on lanes that are close to the
/// star, and how far the segment's middle lies behind the foot.
struct Irradiated {
    close: [bool; LANES],
    base: Lane,
    /// The mean of 1/r², zero where the base is none.
    mean: Lane,
    along: Lane,
}

/// Adds the light of a segment and moves τ to its end.
#[inline(always)]
pub(super) fn add(segment: &Segment, context: &Context, state: &mut PacketState, views: &[StarView], near_field: &[NearStar]) {
    if largest(&segment.growth) > 0.0 {
        match &context.tables.light_sums {
            Some(sums) => propagation::accumulate(context, sums, state, segment),
            None => {
                for (scatterer, view) in context.tables.weights.scattered.iter().zip(views) {
                    scatter(segment, context, state, scatterer, view);
                }
            }
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

/// Light of one star, scattered once.
#[inline(always)]
fn scatter(segment: &Segment, context: &Context, state: &mut PacketState, scatterer: &Scatterer, view: &StarView) {
    let slot = context.slots.stars[scatterer.star];
    let (growth, before, after) = (&segment.growth, &segment.before[slot], &segment.after[slot]);
    let from_star = segment.mean_over_dust(slot, context.slots.dust.unwrap_or(slot));
    let middle = lanes!(|lane| fma(0.5, growth[lane], state.tau[lane]) + from_star[lane]);
    let half = lanes!(|lane| 0.5 * (growth[lane] + after[lane] - before[lane]));
    let irradiated = irradiated(segment, context, state, view);
    for lane in 0..LANES {
        let a = if growth[lane] > 0.0 { middle[lane] + half[lane].abs() } else { 0.0 };
        state.deepest[lane] = if a > state.deepest[lane] { a } else { state.deepest[lane] };
    }
    let span = DepthSpan { middle, half };
    let Irradiated { close, base, mean, along } = &irradiated;
    match &context.tables.phase {
        None => {
            let bases = Bases::Weighted(base, &scatterer.weights);
            context.tables.terms.accumulate(scatterer.light, &state.drawn, &span, bases, &mut state.sum);
        }
        Some(phase) => {
            let rows = &phase.lights[scatterer.light];
            let spread = &mut state.bases[..rows.columns()];
            match phases(segment, context, view, mean) {
                1 => rows.spread(&angle(segment, context, view, along, 0.0).0, base, spread),
                phases => {
                    spread.fill([0.0; LANES]);
                    for SegmentAngle { entries, share } in angles(segment, context, view, along, phases) {
                        rows.add(&entries, &lanes!(|lane| base[lane] * share[lane]), spread);
                    }
                }
            }
            let bases = if phase.separable { Bases::Weighted(&state.bases[0], &scatterer.weights) } else { Bases::Each(&state.bases) };
            context.tables.terms.accumulate(scatterer.light, &state.drawn, &span, bases, &mut state.sum);
        }
    }
    if close.contains(&true) {
        scatter_close(segment, context, state, scatterer, close);
    }
}

/// ⟨1/r²⟩ = atan(q)/(q p), q = b Δt/p, p = b² + t₀t₁; segments that a star sees under a wide angle go another way.
#[inline(always)]
fn irradiated(segment: &Segment, context: &Context, state: &PacketState, view: &StarView) -> Irradiated {
    let reach = (NEAR_VOXELS * context.voxel_pc) as f32;
    let mut irradiated = Irradiated { close: [false; LANES], base: [0.0; LANES], mean: [0.0; LANES], along: [0.0; LANES] };
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
        irradiated.mean[lane] = if near { 0.0 } else { mean };
        irradiated.base[lane] = irradiated.mean[lane] * growth;
        irradiated.along[lane] = t0 + 0.5 * dt;
    }
    irradiated
}

/// The number of angles at which the phase function must be asked in a segment, whatever its dust.
#[inline(always)]
fn phases(segment: &Segment, context: &Context, view: &StarView, mean: &Lane) -> usize {
    if !view.wide.contains(&(segment.span.start as usize)) {
        return 1;
    }
    let angles = lanes!(|lane| mean[lane] * view.distance[lane] * segment.length[lane]);
    near::phases(f64::from(largest(&angles)), context.plan.spectral.phase_angle)
}

/// The angle under which the segment scatters at a part of its length from its middle, and 1/r² there.
#[inline(always)]
fn angle(segment: &Segment, context: &Context, view: &StarView, along: &Lane, part: f32) -> (PhaseEntries, Lane) {
    let (mut cosine, mut sine2, mut inverse_square) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let (t, b) = (fma(part, segment.length[lane], along[lane]), view.distance[lane]);
        let r2 = fma(t, t, b * b);
        let inverse = if r2 > 0.0 { 1.0 / r2 } else { 0.0 };
        (cosine[lane], sine2[lane]) = (-t * inverse.sqrt(), b * b * inverse);
        inverse_square[lane] = inverse;
    }
    (context.phase_entries(&cosine, &sine2), inverse_square)
}

/// Several angles under which the segment scatters, by their shares of the light, which go as σ/r².
#[inline(always)]
fn angles(segment: &Segment, context: &Context, view: &StarView, along: &Lane, phases: usize) -> SmallVec<[SegmentAngle; 4]> {
    // What σ grows by in parts of its mean.
    let tilt = match context.slots.dust {
        Some(dust) => lanes!(|lane| {
            let (a, b) = (segment.before[dust][lane], segment.after[dust][lane]);
            if a + b > 0.0 { 2.0 * (b - a) / (a + b) } else { 0.0 }
        }),
        None => [0.0; LANES],
    };
    let mut angles: SmallVec<[SegmentAngle; 4]> = SmallVec::new();
    let mut sum = [0.0; LANES];
    for j in 0..phases {
        let part = (j as f32 + 0.5) / phases as f32 - 0.5;
        let (entries, inverse) = angle(segment, context, view, along, part);
        angles.push(SegmentAngle { entries, share: lanes!(|lane| fma(part, tilt[lane], 1.0) * inverse[lane]) });
        for lane in 0..LANES {
            sum[lane] += inverse[lane];
        }
    }
    for angle in &mut angles {
        for lane in 0..LANES {
            angle.share[lane] = if sum[lane] > 0.0 { angle.share[lane] / sum[lane] } else { 0.0 };
        }
    }
    angles
}

/// Light of a star on the lanes that are close to it: in pieces, lane by lane.
fn scatter_close(segment: &Segment, context: &Context, state: &mut PacketState, scatterer: &Scatterer, close: &[bool; LANES]) {
    let star = context.plan.space.stars[scatterer.star];
    let resolution = near::Resolution { phase_angle: context.plan.spectral.phase_angle, fineness: 1.0 };
    let first = context.tables.terms.start(scatterer.light);
    let footprint = context.plan.camera.footprint();
    for lane in (0..LANES).filter(|lane| close[*lane]) {
        let at = |steps: f32| state.span.0[lane] + f64::from(steps) * f64::from(state.dt[lane]);
        let part = plan_segment::Segment {
            from: at(segment.span.start),
            to: at(segment.span.end()),
            tau: f64::from(state.tau[lane]),
            growth: f64::from(segment.growth[lane]),
        };
        let add = |piece: NearPiece| {
            let phase = context.phase_entry(piece.cosine as f32, (1.0 - piece.cosine * piece.cosine) as f32);
            for term in 0..context.tables.weights.terms {
                let weight = context.phase_weight(scatterer, term, phase);
                let decay = context.tables.terms.at(scatterer.light, &state.drawn, lane, term, piece.depth as f32);
                state.sum[first + term][lane] += piece.scattering as f32 * weight * decay;
            }
        };
        let (ray, dust) = (&state.rays[lane], near::samples(&context.plan.space, star));
        let footprint_at = |p: DVec3| footprint.at((p - ray.origin).dot(ray.direction));
        let seen_at = |p: DVec3| context.plan.detail.as_ref().map_or(p, |detail| p + detail.displacement(p, footprint_at(p)));
        let seen = DustNearby { sigma: |p| (dust.sigma)(seen_at(p)), depth: |p| (dust.depth)(seen_at(p)) };
        near::pieces(seen, resolution, star, ray, &part, add);
    }
}

/// Light that was scattered before.
#[inline(always)]
fn scatter_again(segment: &Segment, context: &Context, state: &mut PacketState) {
    let Terms::Nodes(nodes) = &context.tables.terms else { return };
    let growth = &segment.growth;
    let span = DepthSpan { middle: lanes!(|lane| state.tau[lane] + 0.5 * growth[lane]), half: scaled(growth, 0.5) };
    for (term, base) in state.bases.iter_mut().enumerate().take(nodes.k.len()) {
        let twice = segment.twice_the_mean(context.slots.scattered_field[term]);
        *base = lanes!(|lane| 0.5 * nodes.k[term] * growth[lane] * twice[lane]);
    }
    context.tables.terms.accumulate(0, &state.drawn, &span, Bases::Each(&state.bases), &mut state.sum);
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
fn emit(segment: &Segment, context: &Context, state: &mut PacketState) {
    let growth = &segment.growth;
    let Tables { terms, weights, .. } = context.tables;
    let mut glows: SmallVec<[Lane; 8]> = SmallVec::new();
    // Light of all species through all bands, and that of the first half of the segment.
    let (mut all, mut early) = ([0.0; LANES], [0.0; LANES]);
    for emitter in &weights.emitted {
        let [glow, early_glow] = segment.twice_the_glow(context.slots.species[emitter.species], context.slots.has_front[emitter.species]);
        for lane in 0..LANES {
            all[lane] = fma(emitter.total, glow[lane], all[lane]);
            early[lane] = fma(emitter.total, early_glow[lane], early[lane]);
        }
        glows.push(glow);
    }
    if largest(&all) <= 0.0 {
        return;
    }
    let depth = segment.mean_depth(&all, &early);
    let span = DepthSpan { middle: lanes!(|lane| state.tau[lane] + depth[lane]), half: scaled(growth, 0.5) };
    if terms.are_shared() {
        // What all terms of a species have in common is rounded alike: where terms cancel, so does that.
        for glow in &mut glows {
            *glow = lanes!(|lane| 0.5 * segment.length[lane] * glow[lane]);
        }
        for (term, base) in state.bases.iter_mut().enumerate().filter(|(term, _)| context.tables.glowing.get(*term) == Some(&true)) {
            let mut sum = [0.0; LANES];
            for (emitter, glow) in weights.emitted.iter().zip(&glows) {
                let weight = emitter.weights[term];
                for lane in 0..LANES {
                    sum[lane] = fma(weight, glow[lane], sum[lane]);
                }
            }
            *base = sum;
        }
        terms.accumulate(0, &state.drawn, &span, Bases::Some(&state.bases, &context.tables.glowing), &mut state.sum);
        return;
    }
    for (emitter, glow) in weights.emitted.iter().zip(&glows) {
        let base = lanes!(|lane| 0.5 * segment.length[lane] * glow[lane]);
        if largest(&base) > 0.0 {
            let bases = Bases::Weighted(&base, &emitter.weights);
            terms.accumulate(emitter.light, &state.drawn, &span, bases, &mut state.sum);
        }
    }
}

/// An angle under which a segment scatters: its place in the phase table, and the share of the light.
struct SegmentAngle {
    entries: PhaseEntries,
    share: Lane,
}

/// Multiplies each lane by one number.
#[inline(always)]
fn scaled(lane: &Lane, factor: f32) -> Lane {
    lanes!(|i| lane[i] * factor)
}
