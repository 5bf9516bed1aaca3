//! One ray in f64, step by step as the fast back ends march it: what light arrives, and through how much dust.
//!
//! Pilot rays and the probe are eyes at its end.

use spectra::rule::DepthSpan;

use crate::geometry::{Bounds, Ray};
use crate::light::{Light, Route};
use crate::plan::near;
use crate::plan::near::NearPiece;
use crate::plan::segment::{Segment, mean_inverse_square};
use crate::plan::{SpatialPlan, SpectralPlan, Stepping};
use crate::volume::Channel;

/// An observer at the end of a ray that is marched in f64.
pub(in crate::plan) trait Eye {
    /// So much of a light arrives, fallen by its mean over the depths at V.
    fn light(&mut self, light: usize, amount: f64, depths: DepthSpan);

    /// The stars that it sees, those with depths of their own first: those that have depths of their own, and of many
    /// lights their representatives where there are no others.
    fn stars(&self, space: &SpatialPlan) -> Vec<usize> {
        let representatives = space.many_lights.iter().flat_map(|many_lights| &many_lights.representatives);
        space.marched().iter().chain(representatives).copied().collect()
    }

    /// Whether scattered light comes by [`dust`](Self::dust), that of all stars together, and not star by star.
    fn scattered_together(&self) -> bool {
        false
    }

    /// Whether the eye is to hear of the whole ray, also of parts that no light comes from.
    fn goes_on(&self) -> bool {
        false
    }

    /// Tells the eye that the ray passes dust.
    fn dust(&mut self, _segment: &Segment) {}
}

/// A step of a ray, and what is at its ends.
struct Step<'a> {
    segment: Segment,
    before: &'a Sample,
    after: &'a Sample,
}

/// The factor by which an exact march takes more pieces near a star than back ends do.
const FINENESS: f64 = 4.0;
/// The part of a step at whose ends an exact march looks within it: a field may jump where steps meet.
const INSIDE: f64 = 1e-6;
/// Growth of the optical depth at V in a step of an exact march, and most parts of a step in which it grows by more.
const GROWTH: f64 = 0.1;
const MAX_PARTS: f64 = 4096.0;
/// Optical depth at the wavelength that dust lets through best, past which an exact march ends: e^(−30) is left.
const END: f64 = 30.0;

/// The march of one ray from the front to the back.
pub(in crate::plan) struct RayMarch<'a> {
    pub space: &'a SpatialPlan,
    pub spectral: &'a SpectralPlan,
    pub lights: &'a [Light],
    pub ray: &'a Ray,
    pub stepping: Stepping,
    /// Whether densities are those of the fields themselves and star depths are marched; else both are read from the
    /// samples.
    pub exact: bool,
}

/// A source of light along a ray.
enum Source {
    /// A star, and its place among those that the eye sees.
    Star { star: usize, seen: usize },
    /// A species of gas.
    Gas { species: usize },
}

impl RayMarch<'_> {
    /// Shows `eye` all light; returns the optical depth of the whole ray at V \[1\].
    pub fn run(&self, eye: &mut impl Eye) -> f64 {
        let clipped = self.space.occupied.and_then(|b| b.clip(self.ray));
        let tau = clipped.map_or(0.0, |(near, far)| self.dust_and_gas(near, far, eye));
        for (light, _) in self.lights.iter().enumerate().filter(|(_, l)| l.route == Route::Background) {
            eye.light(light, 1.0, DepthSpan::at(tau));
        }
        tau
    }

    /// The light between two distances [pc].
    fn dust_and_gas(&self, near: f64, far: f64, eye: &mut impl Eye) -> f64 {
        let (space, ray) = (self.space, self.ray);
        let seen = eye.stars(space);
        let sources = self.sources(&seen, eye.scattered_together());
        let mut steps = Steps { near, ends: self.ends(near, far, !eye.scattered_together()) };
        let enough = if eye.goes_on() { f64::INFINITY } else { END / self.spectral.least_k };
        let truth = self.exact.then(|| {
            let depths = steps.refine(space, ray, enough);
            Truth::new(space, ray, &steps, &depths, &seen)
        });
        let at = |t: f64| match &truth {
            None => Sample::at(space, ray, t, &seen),
            Some(truth) => truth.at(t),
        };
        let (mut tau, mut from, mut before) = (0.0, near, at(near));
        for to in steps.ends {
            let after = match self.exact {
                false => at(to),
                true => {
                    before = at(from + INSIDE * (to - from));
                    at(to - INSIDE * (to - from))
                }
            };
            let growth = 0.5 * (to - from) * (before.sigma + after.sigma);
            let step = Step { segment: Segment { from, to, tau, growth }, before: &before, after: &after };
            for (light, source) in &sources {
                self.shine(*light, source, &step, eye);
            }
            if growth > 0.0 {
                eye.dust(&step.segment);
            }
            tau += growth;
            (from, before) = (to, after);
            if self.exact && !eye.goes_on() && tau * self.spectral.least_k > END {
                break;
            }
        }
        tau
    }

    /// The lights that come from along the ray, those of stars only where they come star by star.
    fn sources(&self, seen: &[usize], scattered_together: bool) -> Vec<(usize, Source)> {
        let mut number = vec![None; self.space.stars.len()];
        seen.iter().enumerate().for_each(|(i, star)| number[*star] = Some(i));
        let source = |(light, l): (usize, &Light)| match l.route {
            Route::Scattered { star } if !scattered_together => number[star].map(|seen| (light, Source::Star { star, seen })),
            Route::Emitted { species } => Some((light, Source::Gas { species })),
            _ => None,
        };
        self.lights.iter().enumerate().filter_map(source).collect()
    }

    /// The ends of the steps [pc]. A step that is long beside its distance to a star is marched in parts, as the back
    /// ends do, where it is to be `cut`.
    fn ends(&self, near: f64, far: f64, cut: bool) -> Vec<f64> {
        let (space, ray) = (self.space, self.ray);
        let voxel = space.voxel_pc();
        let steps = self.stepping.steps(far - near, space.voxel_along(ray.direction));
        let dt = (far - near) / steps as f64;
        let feet = space.marched().iter().filter(|_| cut).map(|star| {
            let star = space.stars[*star];
            let foot = (star - ray.origin).dot(ray.direction);
            (foot, (star - ray.at(foot)).length())
        });
        let feet: Vec<(f64, f64)> = feet.collect();
        let of_step = |i: usize| {
            let t = near + i as f64 * dt;
            let parts = feet.iter().map(|(foot, distance)| near::parts(*distance, foot - t, dt, voxel)).max().unwrap_or(1);
            (1..=parts).map(move |part| t + dt * part as f64 / parts as f64)
        };
        (0..steps).flat_map(of_step).collect()
    }

    /// Light of one source in one step.
    fn shine(&self, light: usize, source: &Source, step: &Step, eye: &mut impl Eye) {
        match source {
            Source::Star { star, seen } if step.segment.growth > 0.0 => self.scatter(light, *star, *seen, step, eye),
            Source::Star { .. } => {}
            Source::Gas { species } => {
                let emission = step.before.emission[*species] + step.after.emission[*species];
                let density = 0.5 * step.segment.length() * emission;
                if density > 0.0 {
                    eye.light(light, density, step.segment.depths());
                }
            }
        }
    }

    /// Light of one star that one step scatters.
    fn scatter(&self, light: usize, star: usize, seen: usize, step: &Step, eye: &mut impl Eye) {
        let Step { segment, before, after } = step;
        let Segment { from, to, tau, growth } = *segment;
        let (space, spectral, ray, length) = (self.space, self.spectral, self.ray, segment.length());
        let position = space.stars[star];
        let foot = (position - ray.origin).dot(ray.direction);
        let b = (position - ray.at(foot)).length();
        let (u0, u1) = (from - foot, to - foot);
        let product = b * b + u0 * u1;
        let reach = near::NEAR_VOXELS * space.voxel_pc();
        if product < reach * reach || b * length > near::NEAR_ANGLE * product {
            let resolution = near::Resolution { phase_angle: spectral.phase_angle, fineness: if self.exact { FINENESS } else { 1.0 } };
            let light = |NearPiece { scattering, depth, cosine }| {
                eye.light(light, scattering * spectral.phase_factor(cosine), DepthSpan::at(depth))
            };
            match self.exact {
                true => near::pieces(near::fields(space, position), resolution, position, ray, segment, light),
                false => near::pieces(near::samples(space, position), resolution, position, ray, segment, light),
            }
            return;
        }
        let scattering = growth * mean_inverse_square(b, u0, u1);
        // The mean of the phase function over the angle that the segment spans, weighted by σ/r² as the light is.
        let phases = near::phases(scattering / growth * b * length, spectral.phase_angle);
        let sample = |j: usize| {
            let u = u0 + length * (j as f64 + 0.5) / phases as f64;
            let r2 = b * b + u * u;
            let share = before.sigma + (after.sigma - before.sigma) * (j as f64 + 0.5) / phases as f64;
            (share * spectral.phase_factor(-u / r2.sqrt()) / r2, 1.0 / r2)
        };
        let (sum, weight) = (0..phases).map(sample).fold((0.0, 0.0), |(s, w), (p, v)| (s + p, w + v));
        let depths = DepthSpan { from: tau + before.depths[seen], to: tau + growth + after.depths[seen] };
        eye.light(light, scattering * sum / (weight * 0.5 * (before.sigma + after.sigma)), depths);
    }
}

/// The steps of a ray: where the first begins, and where each ends [pc].
struct Steps {
    near: f64,
    ends: Vec<f64>,
}

impl Steps {
    /// Cuts the steps of an exact march where functions jump, and where the depth grows fast, and leaves out
    /// those behind twice a depth of `enough`; returns about how deep the ends of the steps lie.
    fn refine(&mut self, space: &SpatialPlan, ray: &Ray, enough: f64) -> Vec<f64> {
        let (near, ends) = (self.near, &mut self.ends);
        let far = ends.last().copied().unwrap_or(near);
        ends.extend(space.crossings(ray).into_iter().filter(|t| (near..far).contains(t)));
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|a, b| *a - *b <= 1e-12 * far);
        let (mut fine, mut depths) = (Vec::with_capacity(ends.len()), Vec::with_capacity(ends.len()));
        let (mut t0, mut tau) = (near, 0.0);
        for t1 in ends.iter().copied() {
            let within = [INSIDE, 0.5, 1.0 - INSIDE].map(|u| space.fields_at(ray.at(t0 + u * (t1 - t0))).0);
            let parts = (within.into_iter().fold(0.0, f64::max) * (t1 - t0) / GROWTH).ceil().clamp(1.0, MAX_PARTS);
            let growth = (t1 - t0) * (within[0] + 4.0 * within[1] + within[2]) / 6.0;
            for part in (1..=parts as usize).map(|i| i as f64 / parts) {
                fine.push(t0 + (t1 - t0) * part);
                depths.push(tau + growth * part);
            }
            (t0, tau) = (t1, tau + growth);
            if tau > 2.0 * enough {
                break;
            }
        }
        *ends = fine;
        depths
    }

    /// Chooses `count` places along the steps: a part of them evenly, the others where light comes from, which falls with
    /// the depth.
    fn places(&self, depths: &[f64], count: usize) -> Vec<f64> {
        let (near, ends) = (self.near, &self.ends);
        let (far, deepest) = (ends.last().copied().unwrap_or(near), depths.last().copied().unwrap_or(0.0));
        let seen = 1.0 - (-deepest).exp();
        let even = if seen > 0.0 { EVEN } else { 1.0 };
        let share = |t: f64, tau: f64| even * (t - near) / (far - near) + (1.0 - even) * (1.0 - (-tau).exp()) / seen.max(f64::MIN_POSITIVE);
        let (mut places, mut before) = (Vec::with_capacity(count), (near, 0.0));
        for (t, tau) in ends.iter().zip(depths) {
            let after = share(*t, *tau);
            while places.len() < count && (places.len() as f64 + 0.5) / count as f64 <= after {
                let part = ((places.len() as f64 + 0.5) / count as f64 - before.1) / (after - before.1);
                places.push(before.0 + part.clamp(0.0, 1.0) * (t - before.0));
            }
            before = (*t, after);
        }
        if places.is_empty() {
            places.push(0.5 * (near + far));
        }
        places
    }
}

/// What a ray really passes: the fields themselves, and star depths marched through them.
struct Truth<'a> {
    space: &'a SpatialPlan,
    ray: &'a Ray,
    seen: &'a [usize],
    /// The places at which the dust itself is marched towards the stars [pc], ascending; values between them are
    /// linear.
    places: Vec<f64>,
    /// The difference between star depths through the dust itself and through its samples: at those places, star by
    /// star.
    beyond: Vec<Vec<f64>>,
}

/// The number of places along a ray for all stars together.
const PLACES: usize = 24;
/// The least number of places for each star.
const MIN_PLACES: usize = 6;
/// The part of them that lies evenly along the way; the others lie where light comes from.
const EVEN: f64 = 0.4;

impl<'a> Truth<'a> {
    /// The truth along some steps, whose ends have about these depths.
    fn new(space: &'a SpatialPlan, ray: &'a Ray, steps: &Steps, depths: &[f64], seen: &'a [usize]) -> Self {
        if !space.depth_is_sampled() {
            return Self { space, ray, seen, places: Vec::new(), beyond: Vec::new() };
        }
        let count = (PLACES / seen.len().max(1)).max(MIN_PLACES);
        let places = steps.places(depths, count);
        let beyond = |star: &usize| places.iter().map(|t| space.depth_beyond_samples(space.stars[*star], ray.at(*t))).collect();
        let beyond = seen.iter().map(beyond).collect();
        Self { space, ray, seen, places, beyond }
    }

    fn at(&self, t: f64) -> Sample {
        let p = self.ray.at(t);
        let (sigma, emission) = self.space.fields_at(p);
        let mut sample = Sample { sigma, depths: vec![0.0; self.seen.len()], emission: emission.collect() };
        if sigma > 0.0 {
            for (i, depth) in sample.depths.iter_mut().enumerate() {
                *depth = (self.space.depth(self.space.stars[self.seen[i]], p) + self.beyond(i, t)).max(0.0);
            }
        }
        sample
    }

    fn beyond(&self, star: usize, t: f64) -> f64 {
        let Some(values) = self.beyond.get(star) else { return 0.0 };
        let above = self.places.partition_point(|place| *place <= t);
        let (low, high) = (above.saturating_sub(1), above.min(values.len() - 1));
        let gap = self.places[high] - self.places[low];
        let u = if gap > 0.0 { (t - self.places[low]) / gap } else { 0.0 };
        values[low] + u * (values[high] - values[low])
    }
}

/// The dust and gas at a place, and the depths of stars there.
struct Sample {
    sigma: f64,
    /// The depths from the stars that are seen, in their order.
    depths: Vec<f64>,
    emission: Vec<f64>,
}

impl Sample {
    /// The sample that the plan's volumes hold at distance `t`.
    fn at(space: &SpatialPlan, ray: &Ray, t: f64, seen: &[usize]) -> Self {
        let p = ray.at(t);
        let mut sample = Self { sigma: 0.0, depths: vec![0.0; seen.len()], emission: vec![0.0; space.species()] };
        for volume in &space.volumes {
            // A place on the border belongs to the box, whatever its rounding.
            let margin = 1e-9 * volume.inner.bounds.size();
            let grown = Bounds { low: volume.inner.bounds.low - margin, high: volume.inner.bounds.high + margin };
            if !grown.contains(p) {
                continue;
            }
            for (c, channel) in volume.channels.iter().enumerate() {
                match *channel {
                    Channel::Dust => sample.sigma = volume.at(c, p),
                    Channel::StarDepth(star) => {
                        // Stars with depths of their own come first, in ascending order.
                        if let Ok(i) = space.marched().binary_search(&star) {
                            sample.depths[i] = volume.at(c, p);
                        }
                    }
                    Channel::Emission(species) => sample.emission[species] = volume.at(c, p),
                    Channel::Light(_) | Channel::MultipleScattering(_) => {}
                }
            }
        }
        // Stars without depths of their own come last.
        if sample.sigma > 0.0 {
            let marched = sample.depths.iter_mut().zip(seen).skip(space.marched().len().min(seen.len()));
            marched.for_each(|(depth, star)| *depth = space.depth(space.stars[*star], p));
        }
        sample
    }
}
