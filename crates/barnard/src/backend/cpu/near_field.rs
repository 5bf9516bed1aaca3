//! Gathered stars that a packet passes: the part of their light that is not gathered in the field, within a kernel
//! around each.
//!
//! A segment within the kernel is marched in pieces of equal angle as the star sees them,
//!
//!   ΔI = Σ_j w_j p(θ) σ w Δϑ/b e^(−k_j (τ + d))
//!
//! with the kernel w and the depths d of `plan::near_field_kernel`.

use std::ops::Range;

use smallvec::SmallVec;

use super::context::Context;
use super::phase_rows::PhaseEntries;
use super::segment::Segment;
use super::state::{PacketState, StepSpan};
use super::terms::{Bases, DepthSpan};
use crate::packet::{LANES, Lane, fma, lanes, largest};
use crate::plan::many_lights::near_field_kernel::{KernelShape, PROFILE, Profile, depth_within};
use crate::plan::near::{CLOSEST, NEAR_FIELD_PIECES, near_field_piece};
use crate::plan::{ManyLights, MultipleScattering, Plan};

/// A gathered star beside a packet: foot of the perpendicular, from the span's start, its length, and half the chord of
/// the kernel.
pub struct NearStar<'a> {
    star: usize,
    foot: Lane,
    distance: Lane,
    half: Lane,
    /// Length of the kernel in front of the star, relative to its width.
    ahead: f32,
    shape: KernelShape,
    /// Depths before it, their places in one parsec, and σ at it.
    profile: &'a Profile,
    inverse_step: f32,
    sigma: f32,
    /// Widest angle of a piece [rad].
    piece: f32,
    /// Steps that touch the kernel.
    steps: Range<f32>,
}

/// A piece of a segment on each ray: its light without phase function, and where in the phase table it is.
struct SegmentPiece {
    light: Lane,
    entries: PhaseEntries,
}

/// The near field of a plan: its many lights as packets meet them.
pub struct NearField<'a> {
    many_lights: &'a ManyLights,
    scattered_field: &'a MultipleScattering,
    /// The largest radius of a kernel, and the longest before a star [pc].
    reach_pc: f64,
    ahead_pc: f64,
    /// Widest angle of a piece [rad].
    piece: f32,
}

impl<'a> NearField<'a> {
    /// Finds the near field of a plan; none where no light is gathered.
    pub fn new(plan: &'a Plan) -> Option<Self> {
        let (many_lights, scattered_field) = (plan.space.many_lights.as_deref()?, plan.scattered_field.as_deref()?);
        let reach_pc = scattered_field.report.far_field?.near_pc.1;
        let ahead_pc = scattered_field.kernels().iter().map(|kernel| kernel.ahead_pc).fold(0.0, f64::max);
        let piece = near_field_piece(plan.spectral.phase_angle, plan.spectral.accuracy) as f32;
        Some(Self { many_lights, scattered_field, reach_pc, ahead_pc, piece })
    }

    /// The stars whose kernels a packet's span crosses.
    pub fn beside(&self, state: &PacketState) -> Vec<NearStar<'a>> {
        let (near, far) = (0..LANES)
            .filter(|lane| state.dt[*lane] > 0.0)
            .fold((f64::MAX, 0.0f64), |(near, far), lane| (near.min(state.span.0[lane]), far.max(state.span.1[lane])));
        if far <= near {
            return Vec::new();
        }
        let middle = &state.rays[LANES / 2];
        let apart = |t: f64| state.rays.iter().map(|ray| (ray.at(t) - middle.at(t)).length()).fold(0.0, f64::max);
        // What is before a star may be met though the star itself is behind the end.
        let far = far + self.ahead_pc;
        let reach = self.reach_pc + apart(near).max(apart(far));
        self.many_lights.beside(middle, near, far, reach).filter_map(|star| self.near_star(state, star)).collect()
    }

    fn near_star(&self, state: &PacketState, star: usize) -> Option<NearStar<'a>> {
        let place = self.many_lights.places[star];
        let along = |lane: usize| (place - state.rays[lane].origin).dot(state.rays[lane].direction);
        let foot = lanes!(|lane| (along(lane) - state.span.0[lane]) as f32);
        let distance = lanes!(|lane| (place - state.rays[lane].at(along(lane))).length().max(CLOSEST) as f32);
        let (kernel, profile) = (self.scattered_field.kernels().get(star)?, self.scattered_field.profiles.get(star)?);
        let reach = kernel.reach_pc as f32;
        let half = lanes!(|lane| (reach * reach - distance[lane] * distance[lane]).max(0.0).sqrt());
        let ahead = (kernel.ahead_pc / kernel.reach_pc) as f32;
        let touched = |lane: usize| {
            let dt = state.dt[lane];
            (dt > 0.0 && half[lane] > 0.0).then(|| ((foot[lane] - ahead * half[lane]) / dt, (foot[lane] + half[lane]) / dt))
        };
        let (from, to) = (0..LANES).filter_map(touched).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
        let inverse_step = (PROFILE as f64 / kernel.ahead_pc) as f32;
        let (shape, sigma, piece) = (kernel.shape(), self.many_lights.sigma[star], self.piece);
        Some(NearStar { star, foot, distance, half, ahead, shape, profile, inverse_step, sigma, piece, steps: from..to })
    }
}

/// The part of a segment in a star's kernel: where the segment starts and how long it is, where it enters and leaves,
/// from the foot, and the angle between both as the star sees them.
struct Within {
    start: Lane,
    length: Lane,
    from: Lane,
    to: Lane,
    angle: Lane,
    /// True if one piece, taken as narrow, serves all lanes.
    is_narrow: bool,
}

/// Pieces of a segment, what all of them scatter, and that times their depths from the star.
struct Pieces {
    total: Lane,
    deep: Lane,
    list: SmallVec<[SegmentPiece; 1]>,
}

impl NearStar<'_> {
    /// True if a step touches the kernel.
    #[inline(always)]
    pub fn meets(&self, span: StepSpan) -> bool {
        span.start < self.steps.end && span.end() > self.steps.start
    }

    /// Adds its light of one segment, between whose ends σ is linear.
    #[inline(always)]
    pub fn scatter(&self, context: &Context, state: &mut PacketState, segment: &Segment) {
        let Some(dust) = context.slots.dust else { return };
        let pieces = self.pieces(context, &self.within(state, segment), &segment.before[dust], &segment.after[dust]);
        if largest(&pieces.total) > 0.0 {
            self.shine(context, state, &segment.growth, &pieces);
        }
    }

    /// The part of a segment that lies in the kernel.
    #[inline(always)]
    fn within(&self, state: &PacketState, segment: &Segment) -> Within {
        // Where the segment enters and leaves the kernel, from the foot.
        let start = lanes!(|lane| fma(segment.span.start, state.dt[lane], -self.foot[lane]));
        let length = segment.length;
        let from = lanes!(|lane| start[lane].max(-self.ahead * self.half[lane]));
        let to = lanes!(|lane| (start[lane] + length[lane]).min(self.half[lane]).max(from[lane]));
        let b = &self.distance;
        // The angle between both as the star sees them: its sine and cosine, times both distances.
        let sine = lanes!(|lane| b[lane] * (to[lane] - from[lane]));
        let cosine = lanes!(|lane| fma(b[lane], b[lane], from[lane] * to[lane]));
        let is_narrow = (0..LANES).all(|lane| sine[lane] <= self.piece * cosine[lane]);
        let angle: Lane = match is_narrow {
            true => lanes!(|lane| small_atan(sine[lane] / cosine[lane])),
            // An eighth of it, by three halvings.
            false => lanes!(|lane| {
                let (s, c) = (sine[lane], cosine[lane]);
                let length = length_of(s, c);
                let half = if c > 0.0 { s / (length + c) } else { (length - c) / s.max(f32::MIN_POSITIVE) };
                8.0 * small_atan(halved(halved(half)))
            }),
        };
        Within { start, length, from, to, angle, is_narrow }
    }

    /// Pieces of equal angle, by their middles.
    #[inline(always)]
    fn pieces(&self, context: &Context, within: &Within, before: &Lane, after: &Lane) -> Pieces {
        let Within { start, length, from, to, angle, is_narrow } = within;
        let b = &self.distance;
        let count = ((largest(angle) / self.piece).ceil() as usize).clamp(1, NEAR_FIELD_PIECES);
        let turn = lanes!(|lane| angle[lane] / count as f32);
        let mut pieces = Pieces { total: [0.0; LANES], deep: [0.0; LANES], list: SmallVec::new() };
        // Cosine and sine of half a turn, and of where the first piece has its middle, as the star sees it.
        let half: [Turn; LANES] =
            std::array::from_fn(|lane| Turn { cosine: small_cos(0.5 * turn[lane]), sine: small_sin(0.5 * turn[lane]) });
        let mut towards = half;
        for lane in 0..LANES {
            let inverse = 1.0 / length_of(b[lane], from[lane]);
            let start = Turn { cosine: b[lane] * inverse, sine: from[lane] * inverse };
            towards[lane] = start.and(half[lane]);
        }
        for _ in 0..count {
            let (mut piece, mut cosines, mut sines2) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            for lane in 0..LANES {
                let tangent = match is_narrow {
                    true => 0.5 * (from[lane] + to[lane]) / b[lane],
                    false => towards[lane].sine / towards[lane].cosine.max(f32::MIN_POSITIVE),
                };
                let t = (b[lane] * tangent).clamp(from[lane], to[lane]);
                let square = fma(t, t, b[lane] * b[lane]);
                let part = if length[lane] > 0.0 { (t - start[lane]) / length[lane] } else { 0.0 };
                let density = fma(part, after[lane] - before[lane], before[lane]);
                let along = if t < 0.0 { t * t * (1.0 - self.shape.flat) } else { t * t };
                let kernel = fma(-self.shape.inverse_square, fma(b[lane], b[lane], along), 1.0).max(0.0);
                piece[lane] = density * kernel * kernel * turn[lane] / b[lane];
                pieces.total[lane] += piece[lane];
                let inverse = 1.0 / square.sqrt();
                let cosine = -t * inverse;
                let depth = depth_within(self.profile, self.inverse_step, 0.5 * (self.sigma + density), square * inverse, cosine);
                pieces.deep[lane] = fma(piece[lane], depth, pieces.deep[lane]);
                (cosines[lane], sines2[lane]) = (cosine, b[lane] * b[lane] * inverse * inverse);
            }
            pieces.list.push(SegmentPiece { light: piece, entries: context.phase_entries(&cosines, &sines2) });
            for lane in 0..LANES {
                towards[lane] = towards[lane].and(half[lane]).and(half[lane]);
            }
        }
        pieces
    }

    /// Adds what pieces send, each at its own angle, all behind the depth of their middle.
    #[inline(always)]
    fn shine(&self, context: &Context, state: &mut PacketState, growth: &Lane, pieces: &Pieces) {
        let Pieces { total, deep, list } = pieces;
        let weights = &context.tables.weights.many_lights[self.star];
        let depth = lanes!(|lane| if total[lane] > 0.0 { deep[lane] / total[lane] } else { 0.0 });
        let span = DepthSpan {
            middle: lanes!(|lane| fma(0.5, growth[lane], state.tau[lane] + depth[lane])),
            half: lanes!(|lane| 0.5 * growth[lane]),
        };
        let terms = &context.tables.terms;
        let Some(phase) = &context.tables.phase else {
            return terms.accumulate(0, &state.drawn, &span, Bases::Weighted(total, weights), &mut state.sum);
        };
        let spread = &mut state.bases[..phase.at_nodes.columns()];
        spread.fill([0.0; LANES]);
        for SegmentPiece { light, entries } in list {
            phase.at_nodes.add(entries, light, spread);
        }
        let bases = if phase.separable {
            Bases::Weighted(&spread[0], weights)
        } else {
            for (base, weight) in spread.iter_mut().zip(weights) {
                *base = lanes!(|lane| weight * base[lane]);
            }
            Bases::Each(spread)
        };
        terms.accumulate(0, &state.drawn, &span, bases, &mut state.sum);
    }
}

/// atan x for |x| ≤ 0.42, error 3e-5 of it.
#[inline(always)]
fn small_atan(x: f32) -> f32 {
    let square = x * x;
    x * fma(square, fma(square, fma(square, fma(square, 1.0 / 9.0, -1.0 / 7.0), 1.0 / 5.0), -1.0 / 3.0), 1.0)
}

/// tan(x/2) of tan x, for 0 ≤ x < π/2.
#[inline(always)]
fn halved(tangent: f32) -> f32 {
    tangent / (1.0 + length_of(1.0, tangent))
}

#[inline(always)]
fn length_of(a: f32, b: f32) -> f32 {
    fma(a, a, b * b).sqrt()
}

/// cos x and sin x for |x| ≤ 0.2, error below 1e-7.
#[inline(always)]
fn small_cos(x: f32) -> f32 {
    let square = x * x;
    fma(square, fma(square, 1.0 / 24.0, -0.5), 1.0)
}

#[inline(always)]
fn small_sin(x: f32) -> f32 {
    let square = x * x;
    x * fma(square, fma(square, 1.0 / 120.0, -1.0 / 6.0), 1.0)
}

/// An angle by its cosine and sine.
#[derive(Clone, Copy)]
struct Turn {
    cosine: f32,
    sine: f32,
}

impl Turn {
    /// The sum of both angles.
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self {
            cosine: fma(self.cosine, other.cosine, -self.sine * other.sine),
            sine: fma(self.cosine, other.sine, self.sine * other.cosine),
        }
    }
}
