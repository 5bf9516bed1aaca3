//! The march of one packet of rays.
//!
//! Samples stand at equal steps between the ends of the occupied box; in a segment σ, τ_ℓ and j are linear, its light
//! is the closed form of `plan::segment`:
//!
//!   ΔI = Σ_j Δτ ⟨1/r²⟩ w_j(θ) e^(−k_j ā) sinh(k_j y)/(k_j y),  a = τ + τ_ℓ
//!
//! A step that is long beside its distance to a star is marched in parts; what is close to a star comes in pieces from
//! `plan::near`. Empty bricks are jumped over; a packet ends when what lies behind cannot change a pixel by a fiftieth
//! of the accuracy.
//!
//! A march may be one of a part of space alone (`bricks`): steps are those of the whole rays, and a segment counts where
//! its middle lies in the part.

use std::ops::Range;

use glam::DVec3;
use spectra::simd;

use super::borders::{Borders, moved_out};
use super::context::Context;
use super::detail::PacketDetail;
use super::near_field::{NearField, NearStar};
use super::segment::Segment;
use super::state::{Moments, PacketState, StarView, StepSpan};
use super::tables::Tables;
use super::terms::{NodeTerms, Terms};
use super::{double_integration, shading};
use crate::geometry::{Bounds, Ray};
use crate::packet::{Cursor, LANES, Lane, PacketPlaces, Track, exp, lanes, largest};
use crate::plan::near;
use crate::plan::near::PART_DISTANCE;
use crate::plan::{END_DEPTH, END_EVERY, END_SHARE, Plan};
use crate::volume::{Channel, Volume};

/// A march of one plan, packet by packet.
pub struct March<'a> {
    context: Context<'a>,
    near_field: Option<NearField<'a>>,
    borders: Borders,
    /// The dust without star depths beside it, for the double integration, which reads nothing else.
    dust_alone: Option<Volume>,
    /// Largest σ and largest density of each species.
    brightest: (f32, Vec<f32>),
    /// The part of space whose segments count, its upper borders left out; all of it where there is none.
    domain: Option<Bounds>,
    /// True if the distances of light are measured.
    measures: bool,
    /// True if rays are followed to the end of the dust, whatever is left there.
    is_whole: bool,
}

impl<'a> March<'a> {
    /// Prepares the march of one plan through a part of space, or all of it.
    pub fn new(plan: &'a Plan, tables: &'a Tables, domain: Option<Bounds>) -> Self {
        let context = Context::new(plan, tables);
        let mut largest = plan.largest_densities().into_iter();
        let sigma = if context.slots.dust.is_some() { largest.next().unwrap_or(0.0) } else { 0.0 };
        let dust_alone = plan.space.dust.as_ref().filter(|_| plan.star_march.is_some()).map(|dust| {
            let mut volume = Volume::zeroed(dust.lattice(), vec![Channel::Dust]);
            volume.fill(0, dust);
            volume
        });
        Self {
            context,
            near_field: NearField::new(plan),
            // The volumes of a part end with it, and nothing of theirs counts beyond.
            borders: Borders::new(&plan.space, domain.is_none()),
            dust_alone,
            brightest: (sigma, largest.collect()),
            domain,
            measures: false,
            is_whole: false,
        }
    }

    /// Copy of the march, which measures how far light comes from.
    pub fn measuring(self) -> Self {
        Self { measures: true, ..self.whole() }
    }

    /// Copy of the march, whose rays go on where little light is left.
    pub fn whole(self) -> Self {
        Self { is_whole: true, ..self }
    }

    /// What a packet comes through and from how far, quantity × lane: the light of all bands times its distance
    /// [pc W m⁻² sr⁻¹], that light [W m⁻² sr⁻¹], the optical depth at V, and the part of light that it takes \[1\].
    pub fn distances(&self, rays: &[Ray; LANES], numbers: &[u64; LANES]) -> Vec<f32> {
        let state = self.light(rays, numbers);
        let all = |sum: &[Lane], channels: &[Lane]| {
            let bands = self.bands_of(sum, &state.tau, channels);
            (0..LANES).map(move |lane| bands.iter().skip(lane).step_by(LANES).sum::<f32>()).collect::<Vec<f32>>()
        };
        let moments = state.moments.as_ref().map_or_else(|| vec![0.0; LANES], |moments| all(&moments.sum, &moments.channels));
        let taken = state.tau.iter().map(|tau| -(-tau).exp_m1());
        moments.into_iter().chain(all(&state.sum, &state.channels)).chain(state.tau).chain(taken).collect()
    }

    /// Radiance of a packet, band × lane, and the largest optical depth met.
    ///
    /// `numbers` tell the rays of an image apart.
    pub fn packet(&self, rays: &[Ray; LANES], numbers: &[u64; LANES]) -> (Vec<f32>, f32) {
        let state = self.light(rays, numbers);
        let behind = if self.context.tables.weights.background.is_some() { largest(&state.tau) } else { 0.0 };
        let radiance = self.bands_of(&state.sum, &state.tau, &state.channels);
        (radiance, largest(&state.deepest).max(behind))
    }

    /// Marches a packet: the light of each term, and the depths behind all.
    pub fn light<'r>(&self, rays: &'r [Ray; LANES], numbers: &[u64; LANES]) -> PacketState<'r> {
        let terms = self.context.tables.weights.terms;
        let nowhere = ([0.0; LANES], [0.0; LANES]);
        let (sums, channels) = (self.context.tables.terms.sums(terms), self.context.tables.light_sums.as_ref().map_or(0, |g| g.channels()));
        let mut state = PacketState {
            rays,
            drawn: self.context.tables.terms.draw(numbers),
            final_span: false,
            span: nowhere,
            dt: [0.0; LANES],
            tau: [0.0; LANES],
            sum: vec![[0.0; LANES]; sums],
            bases: vec![[0.0; LANES]; terms.next_multiple_of(4)],
            channels: vec![[0.0; LANES]; channels],
            deepest: [0.0; LANES],
            moments: self.measures.then(|| Moments::new(sums, channels)),
        };
        let spans = self.borders.spans(rays);
        let last = spans.len().saturating_sub(1);
        for (i, span) in spans.into_iter().enumerate() {
            state.final_span = i == last && self.context.tables.weights.background.is_none();
            let length = |lane: usize| span.1[lane] - span.0[lane];
            if (0..LANES).map(length).fold(0.0, f64::max) > 0.0 {
                let steps =
                    |lane: usize| self.context.plan.stepping.steps(length(lane), self.context.plan.space.voxel_along(rays[lane].direction));
                let steps = (0..LANES).filter(|lane| length(*lane) > 0.0).map(steps).max().unwrap_or(1);
                state.dt = lanes!(|lane| (length(lane) / steps as f64) as f32);
                state.span = span;
                march_span(self, &mut state, steps);
            }
        }
        state
    }

    /// The sums with the background behind them, band by band.
    pub fn bands_of(&self, sum: &[Lane], tau: &Lane, channels: &[Lane]) -> Vec<f32> {
        let bands = self.context.plan.spectral.bands.len();
        let mut radiance = vec![0.0; bands * LANES];
        for (term, band) in self.context.tables.weights.band_of.iter().enumerate() {
            let out = &mut radiance[band * LANES..(band + 1) * LANES];
            out.iter_mut().zip(&sum[term]).for_each(|(r, s)| *r += s);
        }
        if let Some(sums) = &self.context.tables.light_sums {
            sums.resolve(channels, &mut radiance);
        }
        if let Terms::CommonNodes(common) = &self.context.tables.terms {
            common.resolve(sum, tau, &mut radiance);
        } else if let Some(light) = self.context.tables.weights.background {
            for (band, plan) in self.context.plan.spectral.bands.iter().enumerate() {
                for lane in 0..LANES {
                    radiance[band * LANES + lane] += plan.rule.evaluate(light, f64::from(tau[lane])) as f32;
                }
            }
        }
        radiance
    }

    fn star_view(&self, star: usize, state: &PacketState) -> StarView {
        let place = self.context.plan.space.stars[star];
        let foot = |lane: usize| (place - state.rays[lane].origin).dot(state.rays[lane].direction);
        let foot_of = lanes!(|lane| (foot(lane) - state.span.0[lane]) as f32);
        let distance = lanes!(|lane| (place - state.rays[lane].at(foot(lane))).length() as f32);
        // Steps that come closer to the star than this, by its square.
        let within = |square: &dyn Fn(f32, f32) -> f32| {
            let of_lane = |lane: usize| {
                let (b, dt) = (distance[lane], state.dt[lane]);
                let reach = (square(b, dt) - b * b).max(0.0).sqrt();
                (dt > 0.0 && reach > 0.0).then(|| ((foot_of[lane] - reach) / dt, (foot_of[lane] + reach) / dt))
            };
            let all = (0..LANES).filter_map(of_lane).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
            // A step more at both ends, since the whole of it counts; negative numbers become zero.
            all.map_or(0..0, |(from, to)| (from - 1.0) as usize..(to + 2.0) as usize)
        };
        let long = within(&|_, dt| (dt / PART_DISTANCE as f32).powi(2));
        let wide = within(&|b, dt| b * dt / self.context.plan.spectral.phase_angle as f32);
        StarView { foot: foot_of, distance, long, wide }
    }

    /// The number of parts that step number `step` must be marched in, so that each is short beside its distance to a
    /// star.
    fn parts(&self, state: &PacketState, views: &[StarView], step: usize) -> usize {
        let of_lane = |view: &StarView, lane: usize| {
            let dt = f64::from(state.dt[lane]);
            near::parts(f64::from(view.distance[lane]), f64::from(view.foot[lane]) - step as f64 * dt, dt, self.context.voxel_pc)
        };
        let near = views.iter().filter(|view| view.long.contains(&step));
        near.flat_map(|view| (0..LANES).map(move |lane| of_lane(view, lane))).max().unwrap_or(1)
    }

    /// For each volume, a one on the lanes whose span lies inside it; none where all lanes do.
    fn masks(&self, state: &PacketState) -> Vec<Option<Lane>> {
        let middle = |lane: usize| state.rays[lane].at(0.5 * (state.span.0[lane] + state.span.1[lane]));
        let mask = |v: &Volume| {
            let mask = lanes!(|lane| f32::from(u8::from(v.inner.bounds.contains(middle(lane)))));
            (self.domain.is_none() && mask.contains(&0.0)).then_some(mask)
        };
        self.context.plan.volumes().map(mask).collect()
    }

    /// The steps of a span in which a segment may count.
    fn counted(&self, state: &PacketState, steps: usize) -> Range<usize> {
        let Some(domain) = &self.domain else { return 0..steps };
        let domain = self.context.plan.space.occupied.map_or(*domain, |all| moved_out(domain, &all));
        let of_lane = |lane: usize| {
            let (near, far) = domain.clip(&state.rays[lane]).filter(|_| state.dt[lane] > 0.0)?;
            let place = |t: f64| (t - state.span.0[lane]) / f64::from(state.dt[lane]);
            // A step more at both ends, since the whole of it counts; negative numbers become zero.
            Some((place(near) - 1.0) as usize..((place(far) + 2.0) as usize).min(steps))
        };
        let all = (0..LANES).filter_map(of_lane).filter(|range| !range.is_empty());
        all.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
    }

    /// The lanes on which a segment counts; none where it does on all.
    #[inline(always)]
    fn counting(&self, state: &PacketState, span: StepSpan) -> Option<[bool; LANES]> {
        let domain = self.domain.as_ref()?;
        let middle = f64::from(span.start + 0.5 * span.length);
        let counts: [bool; LANES] =
            std::array::from_fn(|lane| domain.holds(state.rays[lane].at(state.span.0[lane] + middle * f64::from(state.dt[lane]))));
        counts.contains(&false).then_some(counts)
    }

    /// Marches the star depths of a sample again, as Barrès & Neyret do.
    fn star_depths_again(&self, state: &PacketState, at: f32, samples: usize, out: &mut [Lane]) {
        let Some(dust) = &self.dust_alone else { return };
        let place = |lane: usize| state.rays[lane].at(state.span.0[lane] + f64::from(at) * f64::from(state.dt[lane]));
        let places = std::array::from_fn(place);
        for (star, position) in self.context.plan.space.stars.iter().enumerate() {
            out[self.context.slots.stars[star]] = double_integration::depths_of(dust, *position, &places, samples);
        }
    }

    /// True if nothing behind `steps` can change any band by a part of the accuracy.
    fn ended(&self, state: &PacketState, views: &[StarView], steps: usize) -> bool {
        let Tables { terms, weights, .. } = self.context.tables;
        let Some(NodeTerms { k, range }) = terms.exponentials() else { return false };
        if !state.final_span || self.domain.is_some() || self.is_whole {
            return false;
        }
        let shallowest = state.tau.iter().copied().fold(f32::MAX, f32::min);
        if shallowest * range.0 < END_DEPTH {
            return false;
        }
        let tolerance = END_SHARE * self.context.plan.spectral.accuracy as f32;
        let rest: Vec<Lane> = views.iter().map(|view| self.rest_of_star(state, view, steps)).collect();
        let brightest: Vec<&[f32]> =
            weights.scattered.iter().map(|s| &s.brightest[..]).chain(weights.emitted.iter().map(|e| &e.weights[..])).collect();
        let lane_ended = |lane: usize| {
            let length = (state.span.1[lane] - state.span.0[lane]) as f32;
            // What each light may have behind, in parts of its brightest.
            let gas = weights.emitted.iter().map(|e| self.brightest.1[e.species] * length);
            let bounds: Vec<f32> = rest.iter().map(|r| r[lane]).chain(gas).collect();
            let left: Vec<f32> = k.iter().map(|k| exp(-k * state.tau[lane])).collect();
            // What may lie behind a term, and what it has.
            let of_term = |term: usize| {
                let lights: f32 = brightest.iter().zip(&bounds).map(|(brightest, bound)| brightest[term] * bound).sum();
                // ∫ k σ e^(−k τ) ds is less than one.
                let scattered_field = self.context.plan.scattered_field.as_ref().map_or(0.0, |d| d.largest[term]);
                (left[term] * (lights + scattered_field), state.sum[term][lane])
            };
            let of_band = |band: usize| match terms {
                Terms::CommonNodes(common) => common.behind(band, &left, &bounds, &brightest, &state.sum, lane),
                _ => {
                    let terms = (0..k.len()).filter(|term| weights.band_of[*term] == band);
                    terms.map(of_term).fold((0.0, 0.0), |all, term| (all.0 + term.0, all.1 + term.1))
                }
            };
            state.dt[lane] == 0.0 || (0..self.context.plan.spectral.bands.len()).map(of_band).all(|(behind, sum)| behind <= tolerance * sum)
        };
        (0..LANES).all(lane_ended)
    }

    /// Bound of ∫ σ dt/r² over the rest of the span.
    fn rest_of_star(&self, state: &PacketState, view: &StarView, steps: usize) -> Lane {
        lanes!(|lane| {
            let b = view.distance[lane].max(1e-6);
            let here = steps as f32 * state.dt[lane] - view.foot[lane];
            let end = (state.span.1[lane] - state.span.0[lane]) as f32 - view.foot[lane];
            self.brightest.0 * ((end / b).atan() - (here / b).atan()) / b
        })
    }
}

simd! {
    fn march_span(march: &March, state: &mut PacketState, steps: usize) {
        let context = &march.context;
        let cursors: Vec<Cursor> = context.plan.volumes().map(|v| Cursor::new(v, state.rays, &state.span.0, &state.span.1)).collect();
        let masks = march.masks(state);
        let tracks: Vec<Track> =
            context.plan.space.bricks.iter().map(|b| Track::new(&b.lattice, DVec3::ZERO, state.rays, &state.span.0)).collect();
        let views: Vec<StarView> = context.tables.weights.scattered.iter().map(|s| march.star_view(s.star, state)).collect();
        let near_field: Vec<NearStar> = march.near_field.as_ref().map_or_else(Vec::new, |near_field| near_field.beside(state));
        let mut before = vec![[0.0; LANES]; context.slots.count];
        let mut after = before.clone();
        let mut middle = context.plan.stepping.has_middles().then(|| before.clone());
        let Range { start: mut step, end: steps } = march.counted(state, steps);
        let detail = PacketDetail::along(context.plan, state);
        let samples = SpanSamples { context, cursors: &cursors, masks: &masks, dt: state.dt, detail };
        samples.read(step as f32, &mut before);
        // What counts of a sample, where only some lanes do.
        let mut counted = [Vec::new(), Vec::new(), Vec::new()];
        while step < steps {
            // Jump over empty space; the sample behind the jump starts anew.
            let jump = if is_dark(context, &before) { clear_steps(context, &tracks, &state.dt, step) } else { 0 };
            if jump > 1 {
                step = step.saturating_add(jump).min(steps);
                samples.read(step as f32, &mut before);
                continue;
            }
            // Barrès & Neyret's own form takes its N samples and no more.
            let parts = if context.plan.star_march.is_some() { 1 } else { march.parts(state, &views, step) };
            for part in 0..parts {
                let length = 1.0 / parts as f32;
                let span = StepSpan { start: step as f32 + part as f32 * length, length };
                samples.read(span.end(), &mut after);
                if let Some(samples) = context.plan.star_march {
                    march.star_depths_again(state, span.end(), samples, &mut after);
                }
                if let Some(middle) = &mut middle {
                    samples.read(span.start + 0.5 * length, middle);
                }
                let counts = march.counting(state, span);
                let (first, last, between) = match &counts {
                    None => (&before, &after, middle.as_deref()),
                    Some(counts) => {
                        let [first, last, between] = &mut counted;
                        only(context, &before, counts, first);
                        only(context, &after, counts, last);
                        let between = middle.as_deref().map(|middle| {
                            only(context, middle, counts, between);
                            &between[..]
                        });
                        (&*first, &*last, between)
                    }
                };
                if counts.is_none_or(|counts| counts.contains(&true)) {
                    let segment = Segment::new(context, state, span, [first, last], between);
                    shading::add(&segment, context, state, &views, &near_field);
                    if let Some(moments) = &mut state.moments {
                        let middle = f64::from(span.start + 0.5 * span.length);
                        let distance = lanes!(|lane| (state.span.0[lane] + middle * f64::from(state.dt[lane])) as f32);
                        moments.count(&state.sum, &state.channels, &distance);
                    }
                }
                std::mem::swap(&mut before, &mut after);
            }
            step += 1;
            if step % END_EVERY == 0 && march.ended(state, &views, step) {
                break;
            }
        }
    }
}

/// Copies a sample, without dust and gas on the lanes that do not count.
#[inline(always)]
fn only(context: &Context, sample: &[Lane], counts: &[bool; LANES], out: &mut Vec<Lane>) {
    out.clear();
    out.extend_from_slice(sample);
    for slot in context.slots.dust.iter().chain(&context.slots.species) {
        for lane in 0..LANES {
            out[*slot][lane] = if counts[lane] { out[*slot][lane] } else { 0.0 };
        }
    }
}

/// The samples of a packet along its span.
struct SpanSamples<'a> {
    context: &'a Context<'a>,
    cursors: &'a [Cursor<'a>],
    masks: &'a [Option<Lane>],
    dt: Lane,
    detail: Option<PacketDetail>,
}

impl SpanSamples<'_> {
    /// Reads all channels at a number of steps into the span.
    #[inline(always)]
    fn read(&self, steps: f32, out: &mut [Lane]) {
        let t = lanes!(|lane| steps * self.dt[lane]);
        let displaced = self.detail.as_ref().map(|detail| detail.displacements(&t));
        let places = PacketPlaces { t: &t, displaced: displaced.as_ref() };
        for ((cursor, mask), first) in self.cursors.iter().zip(self.masks).zip(&self.context.slots.first) {
            let end = out.len().min(first + crate::volume::MAX_CHANNELS);
            let terms = &mut out[*first..end];
            cursor.read(places, terms);
            if let Some(mask) = mask {
                for values in terms.iter_mut().take(cursor.channels()) {
                    for lane in 0..LANES {
                        values[lane] *= mask[lane];
                    }
                }
            }
        }
    }
}

/// True if a sample holds neither dust nor gas on any lane.
#[inline(always)]
fn is_dark(context: &Context, sample: &[Lane]) -> bool {
    let empty = |slot: &usize| largest(&sample[*slot]) <= 0.0;
    context.slots.dust.iter().all(empty) && context.slots.species.iter().all(empty)
}

/// Number of steps that all lanes, `step` steps into the span, may skip through empty bricks.
#[inline(always)]
fn clear_steps(context: &Context, tracks: &[Track], dt: &Lane, step: usize) -> usize {
    let mut clear_pc = f32::INFINITY;
    for (bricks, track) in context.plan.space.bricks.iter().zip(tracks) {
        let (mut fewest, margin) = (usize::MAX, context.plan.displaced_bricks(bricks));
        for lane in (0..LANES).filter(|lane| dt[*lane] > 0.0) {
            let clear = bricks.clear(track.cell_of(lane, bricks.lattice.dims, step as f32 * dt[lane]));
            fewest = fewest.min(clear.saturating_sub(margin));
            if fewest == 0 {
                return 0;
            }
        }
        clear_pc = clear_pc.min(fewest as f32 * bricks.lattice.voxel_pc().min_element() as f32);
    }
    (clear_pc / largest(dt).max(f32::MIN_POSITIVE)) as usize
}
