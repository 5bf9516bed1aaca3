//! The march of one packet of rays.
//!
//! Samples stand at equal steps between the ends of the occupied box; in a segment σ, τ_ℓ and j are linear, its light is the closed form of
//! `plan::segment`:
//!
//!   ΔI = Σ_j Δτ ⟨1/r²⟩ w_j(θ) e^(−k_j ā) sinh(k_j y)/(k_j y),  a = τ + τ_ℓ
//!
//! Where a segment is close to a star its pieces come from `plan::near`. Empty bricks are jumped over; a packet ends when what lies behind cannot
//! change a pixel by a fiftieth of the accuracy.

use multiversion::multiversion;

use super::tables::{Scatterer, Tables, Terms};
use crate::geometry::Ray;
use crate::packet::{Cursor, LANES, Lane, SERIES_LIMIT, exp, fma, lanes, largest, mean_transmittance, sinhc};
use crate::plan::near::{self, NEAR_ANGLE, NEAR_VOXELS};
use crate::plan::{Channel, Plan, Stepping, star_depth};

/// What is the same for all packets.
pub struct March<'a> {
    plan: &'a Plan,
    tables: &'a Tables,
    slots: Slots,
    voxel_pc: f64,
    /// Largest σ and largest density of each species.
    brightest: (f32, Vec<f32>),
}

/// Where the channels of all volumes stand in a sample.
struct Slots {
    count: usize,
    /// First slot of each volume.
    first: Vec<usize>,
    dust: Option<usize>,
    stars: Vec<usize>,
    species: Vec<usize>,
}

impl Slots {
    fn new(plan: &Plan) -> Self {
        let space = &plan.space;
        let mut slots =
            Self { count: 0, first: Vec::new(), dust: None, stars: vec![0; space.stars.len()], species: vec![0; space.species()] };
        for volume in &space.volumes {
            slots.first.push(slots.count);
            for channel in &volume.channels {
                match *channel {
                    Channel::Dust => slots.dust = Some(slots.count),
                    Channel::StarDepth(star) => slots.stars[star] = slots.count,
                    Channel::Emission(species) => slots.species[species] = slots.count,
                }
                slots.count += 1;
            }
        }
        slots
    }
}

/// Samples between looks at whether the ray can end.
const END_EVERY: usize = 8;
/// What lies behind an ended ray, as a part of the accuracy.
const END_SHARE: f32 = 0.02;
/// Depth from which on a look is worth its price.
const END_DEPTH: f32 = 3.0;

/// A packet on its way.
struct State<'a> {
    rays: &'a [Ray; LANES],
    /// Where the current span starts and ends.
    span: ([f64; LANES], [f64; LANES]),
    dt: Lane,
    tau: Lane,
    /// Light so far, term × lane.
    sum: Vec<Lane>,
    deepest: Lane,
}

/// A star as the packet sees it: foot of the perpendicular, from the span's start, and length of it.
struct StarView {
    foot: Lane,
    distance: Lane,
}

impl<'a> March<'a> {
    /// For one plan.
    pub fn new(plan: &'a Plan, tables: &'a Tables) -> Self {
        let slots = Slots::new(plan);
        let mut largest = plan.space.bricks.iter().map(|b| b.largest());
        let sigma = if slots.dust.is_some() { largest.next().unwrap_or(0.0) } else { 0.0 };
        Self { plan, tables, slots, voxel_pc: plan.space.voxel_pc(), brightest: (sigma, largest.collect()) }
    }

    /// Radiance of a packet, band × lane, and the largest optical depth met.
    pub fn packet(&self, rays: &[Ray; LANES]) -> (Vec<f32>, f32) {
        let terms = self.tables.band_of.len();
        let nowhere = ([0.0; LANES], [0.0; LANES]);
        let mut state =
            State { rays, span: nowhere, dt: [0.0; LANES], tau: [0.0; LANES], sum: vec![[0.0; LANES]; terms], deepest: [0.0; LANES] };
        for span in self.spans(rays) {
            let length = |lane: usize| span.1[lane] - span.0[lane];
            let longest = (0..LANES).map(length).fold(0.0, f64::max);
            if longest > 0.0 {
                let steps = match self.plan.stepping {
                    Stepping::PerVoxel(n) => (longest / self.voxel_pc * n).ceil().max(1.0) as usize,
                    Stepping::Fixed(n) => n,
                };
                state.dt = lanes(|lane| (length(lane) / steps as f64) as f32);
                state.span = span;
                march_span(self, &mut state, steps);
            }
        }
        (self.bands_of(&state), largest(&state.deepest))
    }

    /// The parts of the rays between the borders of all boxes: within one, a ray is inside or outside of each volume.
    fn spans(&self, rays: &[Ray; LANES]) -> Vec<([f64; LANES], [f64; LANES])> {
        let Some(occupied) = self.plan.space.occupied else { return Vec::new() };
        let mut boxes: Vec<crate::geometry::Bounds> = Vec::new();
        for volume in &self.plan.space.volumes {
            if !boxes.contains(&volume.lattice.bounds) {
                boxes.push(volume.lattice.bounds);
            }
        }
        let ends: Vec<Vec<f64>> = rays
            .iter()
            .map(|ray| {
                let Some((near, far)) = occupied.clip(ray) else { return Vec::new() };
                let inner = boxes.iter().filter_map(|b| b.clip(ray)).flat_map(|(a, b)| [a, b]).filter(|t| *t > near && *t < far);
                let mut ends: Vec<f64> = [near, far].into_iter().chain(inner).collect();
                ends.sort_by(f64::total_cmp);
                ends
            })
            .collect();
        let count = ends.iter().map(|e| e.len().saturating_sub(1)).max().unwrap_or(0);
        let end = |lane: usize, i: usize| ends[lane].get(i).or(ends[lane].last()).copied().unwrap_or(0.0);
        (0..count).map(|i| (std::array::from_fn(|lane| end(lane, i)), std::array::from_fn(|lane| end(lane, i + 1)))).collect()
    }

    /// The sums with the background behind them, band by band.
    fn bands_of(&self, state: &State) -> Vec<f32> {
        let bands = self.plan.spectral.bands.len();
        let mut radiance = vec![0.0; bands * LANES];
        for (term, band) in self.tables.band_of.iter().enumerate() {
            let out = &mut radiance[band * LANES..(band + 1) * LANES];
            out.iter_mut().zip(&state.sum[term]).for_each(|(r, s)| *r += s);
        }
        if let Some(light) = self.tables.background {
            for (band, plan) in self.plan.spectral.bands.iter().enumerate() {
                for lane in 0..LANES {
                    radiance[band * LANES + lane] += plan.rule.evaluate(light, f64::from(state.tau[lane])) as f32;
                }
            }
        }
        radiance
    }

    fn star_view(&self, star: usize, state: &State) -> StarView {
        let place = self.plan.space.stars[star];
        let foot = |lane: usize| (place - state.rays[lane].origin).dot(state.rays[lane].direction);
        StarView {
            foot: lanes(|lane| (foot(lane) - state.span.0[lane]) as f32),
            distance: lanes(|lane| (place - state.rays[lane].at(foot(lane))).length() as f32),
        }
    }

    /// For each volume, one where a lane's span lies inside of it.
    fn masks(&self, state: &State) -> Vec<Option<Lane>> {
        let middle = |lane: usize| state.rays[lane].at(0.5 * (state.span.0[lane] + state.span.1[lane]));
        let mask = |v: &crate::plan::Volume| {
            let mask = lanes(|lane| f32::from(u8::from(v.lattice.bounds.contains(middle(lane)))));
            mask.contains(&0.0).then_some(mask)
        };
        self.plan.space.volumes.iter().map(mask).collect()
    }

    /// Marches the star depths of a sample again, as the deck does.
    fn star_depths_again(&self, state: &State, step: usize, samples: usize, out: &mut [Lane]) {
        let volumes = &self.plan.space.volumes;
        let Some((dust, slot)) = volumes.iter().find_map(|v| v.channel(Channel::Dust).map(|slot| (v, slot))) else { return };
        let place = |lane: usize| state.rays[lane].at(state.span.0[lane] + step as f64 * f64::from(state.dt[lane]));
        let places = std::array::from_fn(place);
        for (star, position) in self.plan.space.stars.iter().enumerate() {
            out[self.slots.stars[star]] = star_depth::depths_of(dust, slot, *position, &places, Some(samples));
        }
    }

    /// How many steps a ray may jump where everything around is empty.
    fn jump(&self, state: &State) -> usize {
        let edge = self.plan.space.bricks.iter().map(|b| b.lattice.voxel_pc().min_element()).fold(f64::INFINITY, f64::min);
        (edge / f64::from(largest(&state.dt)).max(1e-30)) as usize
    }

    /// Whether all lanes, `steps` into the span, stand where a brick and its neighbours are empty.
    fn all_clear(&self, state: &State, steps: usize) -> bool {
        (0..LANES).all(|lane| {
            let place = state.rays[lane].at(state.span.0[lane] + steps as f64 * f64::from(state.dt[lane]));
            self.plan.space.bricks.iter().all(|b| b.clear_at(place))
        })
    }

    /// Whether nothing behind `steps` can change any term by a part of the accuracy.
    fn ended(&self, state: &State, views: &[StarView], steps: usize) -> bool {
        let Terms::Nodes { k } = &self.tables.terms else { return false };
        let shallowest = state.tau.iter().copied().fold(f32::MAX, f32::min);
        if shallowest * self.tables.k_range.0 < END_DEPTH {
            return false;
        }
        let tolerance = END_SHARE * self.plan.spectral.accuracy as f32;
        let rest: Vec<Lane> = views.iter().map(|view| self.rest_of_star(state, view, steps)).collect();
        (0..k.len()).all(|term| {
            (0..LANES).all(|lane| {
                let stars: f32 = self.tables.scattered.iter().zip(&rest).map(|(s, r)| s.brightest[term] * r[lane]).sum();
                let length = (state.span.1[lane] - state.span.0[lane]) as f32;
                let gas: f32 = self.tables.emitted.iter().map(|(_, species, w)| w[term] * self.brightest.1[*species] * length).sum();
                let behind = exp(-k[term] * state.tau[lane]) * (stars + gas);
                behind <= tolerance * state.sum[term][lane] || state.dt[lane] == 0.0
            })
        })
    }

    /// Bound of ∫ σ dt/r² over the rest of the span.
    fn rest_of_star(&self, state: &State, view: &StarView, steps: usize) -> Lane {
        lanes(|lane| {
            let b = view.distance[lane].max(1e-6);
            let here = steps as f32 * state.dt[lane] - view.foot[lane];
            let end = (state.span.1[lane] - state.span.0[lane]) as f32 - view.foot[lane];
            self.brightest.0 * ((end / b).atan() - (here / b).atan()) / b
        })
    }

    /// The pieces of the segments that are close to a star, lane by lane.
    fn near(&self, state: &mut State, scatterer: &Scatterer, close: &[bool; LANES], step: usize, growth: &Lane) {
        let star = self.plan.space.stars[scatterer.star];
        for lane in (0..LANES).filter(|lane| close[*lane]) {
            let at = |i: usize| state.span.0[lane] + i as f64 * f64::from(state.dt[lane]);
            let depth = (f64::from(state.tau[lane]), f64::from(growth[lane]));
            near::pieces(&self.plan.space, star, &state.rays[lane], (at(step), at(step + 1)), depth, |piece| {
                let phase = self.phase_entry(piece.cosine as f32);
                for term in 0..self.tables.band_of.len() {
                    let weight = self.phase_weight(scatterer, term, phase);
                    let decay = match &self.tables.terms {
                        Terms::Nodes { k } => exp(-k[term] * piece.depth as f32),
                        Terms::Lookup { tables } => exp(tables[scatterer.light][term].at(piece.depth as f32).0),
                    };
                    state.sum[term][lane] += piece.scattering as f32 * weight * decay;
                }
            });
        }
    }

    /// Entry and fraction of the phase table for cos θ.
    #[inline(always)]
    fn phase_entry(&self, cosine: f32) -> (usize, f32) {
        let half = 0.5 * (1.0 - cosine);
        let u = (if half > 0.0 { half } else { 0.0 }).sqrt() * (self.tables.phase_entries.saturating_sub(1)) as f32;
        let entry = (u as usize).min(self.tables.phase_entries.saturating_sub(2));
        (entry, u - entry as f32)
    }

    /// The weight of a term at an angle, 1/4π or p(θ) included.
    #[inline(always)]
    fn phase_weight(&self, scatterer: &Scatterer, term: usize, (entry, fraction): (usize, f32)) -> f32 {
        let Some(table) = &self.plan.spectral.phase else { return scatterer.weights[term] };
        let values = &table.weights[scatterer.light];
        let (stride, column, weight) =
            if table.separable { (1, 0, scatterer.weights[term]) } else { (self.tables.band_of.len(), term, 1.0) };
        let (low, high) = (values[entry * stride + column], values[(entry + 1) * stride + column]);
        weight * (low + fraction * (high - low))
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq+avx2+fma+bmi1+bmi2", "x86_64+avx2+fma+bmi1+bmi2", "aarch64+neon"))]
fn march_span(march: &March, state: &mut State, steps: usize) {
    let cursors: Vec<Cursor> = march.plan.space.volumes.iter().map(|v| Cursor::new(v, state.rays, &state.span.0)).collect();
    let masks = march.masks(state);
    let views: Vec<StarView> = march.tables.scattered.iter().map(|s| march.star_view(s.star, state)).collect();
    let jump = march.jump(state);
    let mut before = vec![[0.0; LANES]; march.slots.count];
    let mut after = before.clone();
    sample(march, &cursors, &masks, &state.dt, 0, &mut before);
    let mut step = 0;
    while step < steps {
        // Jump over empty space; the sample behind the jump starts anew.
        if jump > 1 && is_dark(march, &before) && march.all_clear(state, step) {
            step = (step + jump).min(steps);
            sample(march, &cursors, &masks, &state.dt, step, &mut before);
            continue;
        }
        sample(march, &cursors, &masks, &state.dt, step + 1, &mut after);
        if let Some(samples) = march.plan.star_march {
            march.star_depths_again(state, step + 1, samples, &mut after);
        }
        segment(march, state, &views, step, &before, &after);
        std::mem::swap(&mut before, &mut after);
        step += 1;
        if step % END_EVERY == 0 && march.ended(state, &views, step) {
            break;
        }
    }
}

/// All channels, `step` steps into the span.
#[inline(always)]
fn sample(march: &March, cursors: &[Cursor], masks: &[Option<Lane>], dt: &Lane, step: usize, out: &mut [Lane]) {
    let t = lanes(|lane| step as f32 * dt[lane]);
    for ((cursor, mask), first) in cursors.iter().zip(masks).zip(&march.slots.first) {
        let end = out.len().min(first + crate::plan::MAX_CHANNELS);
        let own = &mut out[*first..end];
        cursor.read(&t, own);
        if let Some(mask) = mask {
            for values in own.iter_mut().take(cursor.channels()) {
                for lane in 0..LANES {
                    values[lane] *= mask[lane];
                }
            }
        }
    }
}

/// Whether a sample holds neither dust nor gas on any lane.
#[inline(always)]
fn is_dark(march: &March, sample: &[Lane]) -> bool {
    let empty = |slot: &usize| largest(&sample[*slot]) <= 0.0;
    march.slots.dust.iter().all(empty) && march.slots.species.iter().all(empty)
}

/// Adds the light of one segment and moves τ to its end.
#[inline(always)]
fn segment(march: &March, state: &mut State, views: &[StarView], step: usize, before: &[Lane], after: &[Lane]) {
    let growth = match march.slots.dust {
        Some(dust) => lanes(|lane| 0.5 * state.dt[lane] * (before[dust][lane] + after[dust][lane])),
        None => [0.0; LANES],
    };
    if largest(&growth) > 0.0 {
        for (scatterer, view) in march.tables.scattered.iter().zip(views) {
            let slot = march.slots.stars[scatterer.star];
            scatter(march, state, scatterer, view, step, &growth, (&before[slot], &after[slot]));
        }
    }
    if !march.tables.emitted.is_empty() {
        emit(march, state, &growth, before, after);
    }
    for lane in 0..LANES {
        state.tau[lane] += growth[lane];
    }
}

/// Light of one star, scattered in one segment.
#[inline(always)]
fn scatter(march: &March, state: &mut State, scatterer: &Scatterer, view: &StarView, step: usize, growth: &Lane, depths: (&Lane, &Lane)) {
    let middle = lanes(|lane| state.tau[lane] + 0.5 * (growth[lane] + depths.0[lane] + depths.1[lane]));
    let half = lanes(|lane| 0.5 * (growth[lane] + depths.1[lane] - depths.0[lane]));
    // ⟨1/r²⟩ = atan(q)/(q p), q = b Δt/p, p = b² + t₀t₁; segments that a star sees under a wide angle go another way.
    let reach = (NEAR_VOXELS * march.voxel_pc) as f32;
    let (mut close, mut base, mut along) = ([false; LANES], [0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let (b, dt) = (view.distance[lane], state.dt[lane]);
        let t0 = fma(step as f32, dt, -view.foot[lane]);
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
    let weights = &scatterer.weights[..];
    match &march.plan.spectral.phase {
        None => gather(march, state, scatterer, &middle, &half, |term| scaled(&base, weights[term])),
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
                gather(march, state, scatterer, &middle, &half, |term| scaled(&spread, weights[term]));
            } else {
                gather(march, state, scatterer, &middle, &half, |term| {
                    lanes(|lane| base[lane] * march.phase_weight(scatterer, term, entry[lane]))
                });
            }
        }
    }
    if close.contains(&true) {
        march.near(state, scatterer, &close, step, growth);
    }
}

/// Each lane times one number.
#[inline(always)]
fn scaled(lane: &Lane, factor: f32) -> Lane {
    lanes(|i| lane[i] * factor)
}

/// Adds base · ⟨e^(−k a)⟩ to every term, `base` being scattering times the term's weight.
#[inline(always)]
fn gather(march: &March, state: &mut State, scatterer: &Scatterer, middle: &Lane, half: &Lane, base: impl Fn(usize) -> Lane) {
    match &march.tables.terms {
        Terms::Nodes { k } => {
            let gentle = largest(&lanes(|lane| half[lane].abs())) * march.tables.k_range.1 <= SERIES_LIMIT;
            for (term, (k, sum)) in k.iter().zip(&mut state.sum).enumerate() {
                let base = base(term);
                if gentle {
                    for lane in 0..LANES {
                        let y = k * half[lane];
                        sum[lane] = fma(base[lane] * sinhc(y * y), exp(-k * middle[lane]), sum[lane]);
                    }
                } else {
                    for lane in 0..LANES {
                        sum[lane] += base[lane] * mean_transmittance(k * middle[lane], k * half[lane]);
                    }
                }
            }
        }
        Terms::Lookup { tables } => {
            for (term, (table, sum)) in tables[scatterer.light].iter().zip(&mut state.sum).enumerate() {
                let base = base(term);
                for lane in 0..LANES {
                    let (log, slope) = table.at(middle[lane]);
                    // In the segment the medium is grey with the local mean extinction.
                    sum[lane] += base[lane] * mean_transmittance(0.0, slope * half[lane]) * exp(log);
                }
            }
        }
    }
}

/// Light of all species in one segment.
#[inline(always)]
fn emit(march: &March, state: &mut State, growth: &Lane, before: &[Lane], after: &[Lane]) {
    let middle = lanes(|lane| state.tau[lane] + 0.5 * growth[lane]);
    let gentle = 0.5 * largest(growth) * march.tables.k_range.1 <= SERIES_LIMIT;
    for (light, species, weights) in &march.tables.emitted {
        let slot = march.slots.species[*species];
        let base = lanes(|lane| 0.5 * state.dt[lane] * (before[slot][lane] + after[slot][lane]));
        if largest(&base) <= 0.0 {
            continue;
        }
        for (term, sum) in state.sum.iter_mut().enumerate().filter(|(term, _)| weights[*term] > 0.0) {
            let base = scaled(&base, weights[term]);
            match &march.tables.terms {
                Terms::Nodes { k } if gentle => {
                    let k = k[term];
                    for lane in 0..LANES {
                        let y = 0.5 * k * growth[lane];
                        sum[lane] = fma(base[lane] * sinhc(y * y), exp(-k * middle[lane]), sum[lane]);
                    }
                }
                Terms::Nodes { k } => {
                    let k = k[term];
                    for lane in 0..LANES {
                        sum[lane] += base[lane] * mean_transmittance(k * middle[lane], 0.5 * k * growth[lane]);
                    }
                }
                Terms::Lookup { tables } => {
                    let table = &tables[*light][term];
                    for lane in 0..LANES {
                        let (log, slope) = table.at(middle[lane]);
                        sum[lane] += base[lane] * mean_transmittance(0.0, 0.5 * slope * growth[lane]) * exp(log);
                    }
                }
            }
        }
    }
}
