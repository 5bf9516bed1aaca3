//! One ray in f64, step by step as the fast back ends march it: what light arrives, and through how much dust.
//!
//! Pilot rays and the probe are eyes at its end.

use crate::geometry::{Bounds, Ray};
use crate::light::{Light, Route};
use crate::plan::near;
use crate::plan::near::NearPiece;
use crate::plan::segment::mean_inverse_square;
use crate::plan::{SpatialPlan, SpectralPlan, Stepping};
use crate::volume::Channel;

/// What looks along a ray.
pub(in crate::plan) trait Eye {
    /// So much of a light arrives, fallen by its mean over the depths at V.
    fn light(&mut self, light: usize, amount: f64, depths: (f64, f64));

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

    /// Whether it is to hear of the whole ray, also of what no light comes from.
    fn goes_on(&self) -> bool {
        false
    }

    /// The ray passes dust between two distances [pc]: the depth before it, and how much it grows.
    fn dust(&mut self, _span: (f64, f64), _depth: (f64, f64)) {}
}

/// How many times as many pieces an exact walk takes near a star as back ends do.
const FINENESS: f64 = 4.0;
/// The part of a step at whose ends an exact walk looks within it: a field may jump where steps meet.
const INSIDE: f64 = 1e-6;
/// Growth of the optical depth at V in a step of an exact walk, and most parts of a step in which it grows by more.
const GROWTH: f64 = 0.1;
const MAX_PARTS: f64 = 4096.0;
/// Optical depth at the wavelength that dust lets through best, past which an exact walk ends: e^(−30) is left.
const END: f64 = 30.0;

/// Walks `ray` from the front to the back; returns the optical depth of all of it at V [1]. Where `exact`, densities
/// are those of the fields themselves and star depths are marched; else both are read.
pub(in crate::plan) fn march_ray(
    space: &SpatialPlan,
    spectral: &SpectralPlan,
    lights: &[Light],
    ray: &Ray,
    stepping: Stepping,
    exact: bool,
    eye: &mut impl Eye,
) -> f64 {
    let mut tau = 0.0;
    let seen = eye.stars(space);
    let mut number = vec![None; space.stars.len()];
    seen.iter().enumerate().for_each(|(i, star)| number[*star] = Some(i));
    let shines = |(_, light): &(usize, &Light)| match light.route {
        Route::Scattered { star } => number[star].is_some(),
        Route::Emitted { .. } => true,
        _ => false,
    };
    let shining: Vec<(usize, &Light)> = lights.iter().enumerate().filter(shines).collect();
    if let Some((near, far)) = space.occupied.and_then(|b| b.clip(ray)) {
        let mut ends = ends(space, ray, (near, far), stepping, !eye.scattered_together()).collect::<Vec<f64>>();
        let enough = if eye.goes_on() { f64::INFINITY } else { END / spectral.least_k };
        let truth = exact.then(|| {
            let depths = refine(space, ray, near, &mut ends, enough);
            Truth::new(space, ray, (near, &ends), &depths, &seen)
        });
        let at = |t: f64| match &truth {
            None => Sample::at(space, ray, t, &seen),
            Some(truth) => truth.at(t),
        };
        let mut before = at(near);
        let mut t0 = near;
        for t1 in ends {
            let dt = t1 - t0;
            let after = match exact {
                false => at(t1),
                true => {
                    before = at(t0 + INSIDE * dt);
                    at(t1 - INSIDE * dt)
                }
            };
            let growth = 0.5 * dt * (before.sigma + after.sigma);
            for (light, l) in &shining {
                let light = *light;
                match l.route {
                    Route::Scattered { star } if growth > 0.0 && !eye.scattered_together() => {
                        let Some(i) = number[star] else { continue };
                        let depths = (tau + before.depths[i], tau + growth + after.depths[i]);
                        let segment = Segment { span: (t0, t1), sigma: (before.sigma, after.sigma), tau: (tau, growth), depths };
                        scatter((space, spectral), (light, star), ray, &segment, exact, eye);
                    }
                    Route::Emitted { species } => {
                        let density = 0.5 * dt * (before.emission[species] + after.emission[species]);
                        if density > 0.0 {
                            eye.light(light, density, (tau, tau + growth));
                        }
                    }
                    _ => {}
                }
            }
            if growth > 0.0 {
                eye.dust((t0, t1), (tau, growth));
            }
            tau += growth;
            (t0, before) = (t1, after);
            if exact && !eye.goes_on() && tau * spectral.least_k > END {
                break;
            }
        }
    }
    for (light, _) in lights.iter().enumerate().filter(|(_, l)| l.route == Route::Background) {
        eye.light(light, 1.0, (tau, tau));
    }
    tau
}

/// Where the steps end [pc]. A step that is long beside its distance to a star is marched in parts, as the back ends
/// do.
fn ends(space: &SpatialPlan, ray: &Ray, (near, far): (f64, f64), stepping: Stepping, cut: bool) -> impl Iterator<Item = f64> {
    let voxel = space.voxel_pc();
    let steps = stepping.steps(far - near, space.voxel_along(ray.direction));
    let dt = (far - near) / steps as f64;
    let feet = space.marched().iter().filter(|_| cut).map(|star| {
        let star = space.stars[*star];
        let foot = (star - ray.origin).dot(ray.direction);
        (foot, (star - ray.at(foot)).length())
    });
    let feet: Vec<(f64, f64)> = feet.collect();
    (0..steps).flat_map(move |i| {
        let t = near + i as f64 * dt;
        let parts = feet.iter().map(|(foot, distance)| near::parts(*distance, foot - t, dt, voxel)).max().unwrap_or(1);
        (1..=parts).map(move |part| t + dt * part as f64 / parts as f64)
    })
}

/// Cuts the steps of an exact walk from `near` on where functions jump, and where the depth grows fast, and leaves out
/// those behind twice a depth of `enough`; returns about how deep the ends of the steps lie.
fn refine(space: &SpatialPlan, ray: &Ray, near: f64, ends: &mut Vec<f64>, enough: f64) -> Vec<f64> {
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

/// What a ray really passes: the fields themselves, and star depths marched through them.
struct Truth<'a> {
    space: &'a SpatialPlan,
    ray: &'a Ray,
    seen: &'a [usize],
    /// Where the dust itself is marched towards the stars [pc], ascending; what lies between is taken linear.
    places: Vec<f64>,
    /// By how much star depths through the dust itself are larger than those through its samples: at those places, star
    /// by star.
    beyond: Vec<Vec<f64>>,
}

/// Places along a ray, of all stars together, and fewest for each.
const PLACES: usize = 24;
const MIN_PLACES: usize = 6;
/// The part of them that lies evenly along the way; the others lie where light comes from.
const EVEN: f64 = 0.4;

impl<'a> Truth<'a> {
    /// For steps that begin at `near` and have these `ends` and about these depths there.
    fn new(space: &'a SpatialPlan, ray: &'a Ray, (near, ends): (f64, &[f64]), depths: &[f64], seen: &'a [usize]) -> Self {
        if !space.depth_is_sampled() {
            return Self { space, ray, seen, places: Vec::new(), beyond: Vec::new() };
        }
        let count = (PLACES / seen.len().max(1)).max(MIN_PLACES);
        let places = places((near, ends), depths, count);
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

/// So many places along a way of steps, some evenly, some where light comes from that falls with the depth.
fn places((near, ends): (f64, &[f64]), depths: &[f64], count: usize) -> Vec<f64> {
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

/// A segment of a ray: distances of its ends, σ there, τ at its start and how it grows, depths eye to sample to star at
/// its ends.
struct Segment {
    span: (f64, f64),
    sigma: (f64, f64),
    tau: (f64, f64),
    depths: (f64, f64),
}

/// Scattered light of one star in one segment.
fn scatter(
    (space, spectral): (&SpatialPlan, &SpectralPlan),
    (light, star): (usize, usize),
    ray: &Ray,
    segment: &Segment,
    exact: bool,
    eye: &mut impl Eye,
) {
    let ((t0, t1), (tau, growth), depths, sigma) = (segment.span, segment.tau, segment.depths, segment.sigma);
    let position = space.stars[star];
    let foot = (position - ray.origin).dot(ray.direction);
    let b = (position - ray.at(foot)).length();
    let (u0, u1) = (t0 - foot, t1 - foot);
    let product = b * b + u0 * u1;
    let reach = near::NEAR_VOXELS * space.voxel_pc();
    if product < reach * reach || b * (t1 - t0) > near::NEAR_ANGLE * product {
        let resolution = near::Resolution { phase_angle: spectral.phase_angle, fineness: if exact { FINENESS } else { 1.0 } };
        let light = |NearPiece { scattering, depth, cosine }| eye.light(light, scattering * spectral.phase_factor(cosine), (depth, depth));
        match exact {
            true => near::pieces(near::fields(space, position), resolution, position, ray, (t0, t1), (tau, growth), light),
            false => near::pieces(near::samples(space, position), resolution, position, ray, (t0, t1), (tau, growth), light),
        }
        return;
    }
    let scattering = growth * mean_inverse_square(b, u0, u1);
    // The mean of the phase function over the angle that the segment spans, weighted by σ/r² as the light is.
    let phases = near::phases(scattering / growth * b * (t1 - t0), spectral.phase_angle);
    let sample = |j: usize| {
        let u = u0 + (t1 - t0) * (j as f64 + 0.5) / phases as f64;
        let r2 = b * b + u * u;
        let share = sigma.0 + (sigma.1 - sigma.0) * (j as f64 + 0.5) / phases as f64;
        (share * spectral.phase_factor(-u / r2.sqrt()) / r2, 1.0 / r2)
    };
    let (sum, weight) = (0..phases).map(sample).fold((0.0, 0.0), |(s, w), (p, v)| (s + p, w + v));
    eye.light(light, scattering * sum / (weight * 0.5 * (sigma.0 + sigma.1)), depths);
}

/// What a place holds.
struct Sample {
    sigma: f64,
    /// From the stars that are seen, in their order.
    depths: Vec<f64>,
    emission: Vec<f64>,
}

impl Sample {
    /// What the plan's volumes hold.
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
