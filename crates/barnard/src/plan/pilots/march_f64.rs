//! One ray in f64, step by step as the fast back ends march it: what light arrives, and through how much dust.
//!
//! Pilot rays and the probe are eyes at its end.

use smallvec::{SmallVec, smallvec};
use spectra::rule::DepthSpan;

use super::samples::{RaySamples, Sample};
use super::star_columns::StarColumns;
use super::steps::{StepEnd, Steps};
use crate::field::mean_share;
use crate::geometry::Ray;
use crate::light::{Light, Route};
use crate::plan::near;
use crate::plan::near::NearPiece;
use crate::plan::segment::{Segment, mean_inverse_square};
use crate::plan::{SpatialPlan, SpectralPlan, Stepping};

/// An observer at the end of a ray that is marched in f64.
pub(in crate::plan) trait Eye {
    /// So much of a light arrives, fallen by its mean over the depths at V.
    fn light(&mut self, light: usize, amount: f64, depths: DepthSpan);

    /// True if scattered light comes by [`dust`](Self::dust), that of all stars together, and not star by star.
    fn scattered_together(&self) -> bool {
        false
    }

    /// True if the eye is to hear of the whole ray, also of parts that no light comes from.
    fn goes_on(&self) -> bool {
        false
    }

    /// Tells the eye that the ray passes dust.
    fn dust(&mut self, _segment: &Segment) {}
}

/// A step of a ray, and what is at its ends.
struct RayStep<'a> {
    segment: Segment,
    before: Sample<'a>,
    after: Sample<'a>,
    middle: Option<Sample<'a>>,
    /// The mean depth from its beginning of what all species of gas send along it \[1\].
    gas_depth: f64,
}

impl RayStep<'_> {
    /// The mean of a value over the light that the dust scatters: by σ, both linear between the places that are looked
    /// at.
    fn mean_over_dust(&self, value: impl Fn(&Sample) -> f64) -> f64 {
        let Some(middle) = &self.middle else { return self.mean(value) };
        let [s0, s1, s2] = [&self.before, middle, &self.after].map(|sample| sample.sigma);
        let [v0, v1, v2] = [&self.before, middle, &self.after].map(value);
        let sum = s0 * (2.0 * v0 + v1) + s1 * (v0 + 4.0 * v1 + v2) + s2 * (v1 + 2.0 * v2);
        sum / (3.0 * (s0 + 2.0 * s1 + s2)).max(f64::MIN_POSITIVE)
    }

    /// The mean depth from its beginning of light that is sent along its parts as `sent` says \[1\].
    fn mean_depth(&self, sent: &[f64]) -> f64 {
        let (growth, Some(middle), [before, after]) = (self.segment.growth, &self.middle, sent) else { return 0.5 * self.segment.growth };
        let all = before + after;
        let early = if all > 0.0 { before / all } else { 0.5 };
        let first = 0.25 * self.segment.length() * (self.before.sigma + middle.sigma);
        0.5 * (growth * (1.0 - early) + first)
    }

    /// Mean density of a species over each part between two samples, ended at the front where the species has one.
    fn glow(&self, gas: &GlowingSpecies) -> SmallVec<[f64; 2]> {
        let part = |before: &Sample, after: &Sample| {
            let mean = 0.5 * (before.emission[gas.species] + after.emission[gas.species]);
            if gas.has_front { mean * mean_share(before.front, after.front) } else { mean }
        };
        match &self.middle {
            None => smallvec![part(&self.before, &self.after)],
            Some(middle) => smallvec![part(&self.before, middle), part(middle, &self.after)],
        }
    }

    /// The mean of a value over it, which is linear between the places that are looked at.
    fn mean(&self, value: impl Fn(&Sample) -> f64) -> f64 {
        let ends = value(&self.before) + value(&self.after);
        self.middle.as_ref().map_or(0.5 * ends, |middle| 0.25 * ends + 0.5 * value(middle))
    }
}

/// The factor by which an exact march takes more pieces near a star than back ends do.
const FINENESS: f64 = 4.0;
/// Optical depth at the wavelength that dust lets through best, past which an exact march ends: e^(−30) is left.
const END: f64 = 30.0;

/// The march of one ray from the front to the back.
pub(in crate::plan) struct RayMarch<'a> {
    pub space: &'a SpatialPlan,
    pub spectral: &'a SpectralPlan,
    pub lights: &'a [Light],
    pub ray: &'a Ray,
    pub stepping: Stepping,
    /// True if densities are those of the fields themselves and star depths are marched; else both are read from the
    /// samples.
    pub exact: bool,
    /// The stars that are seen, and their exact depths along the ray.
    pub columns: &'a StarColumns,
}

/// A source of light along a ray.
enum RayLight {
    /// A star, and its place among those that the eye sees.
    Star { star: usize, seen: usize },
    /// A species of gas.
    Gas(GlowingSpecies),
}

/// A species of gas.
#[derive(Clone, Copy)]
struct GlowingSpecies {
    species: usize,
    /// True if it ends at the front.
    has_front: bool,
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
        let sources = self.sources(&self.columns.stars, eye.scattered_together());
        let mut steps = Steps { near, ends: self.ends(near, far, !eye.scattered_together()) };
        let enough = if eye.goes_on() { f64::INFINITY } else { END / self.spectral.least_k };
        let (steps, samples) = if self.exact {
            steps.refine(space, ray, enough);
            let (depths, places) = steps.within_ends();
            let samples = RaySamples::of_fields(space, ray, &steps, &places, self.columns);
            (depths, samples)
        } else {
            let (depths, places) = if self.stepping.has_middles() { steps.at_ends_and_middles() } else { steps.at_ends() };
            let samples = RaySamples::of_volumes(space, ray, &places, self.columns);
            (depths, samples)
        };
        let gas: Vec<(GlowingSpecies, f64)> = sources
            .iter()
            .filter_map(|(light, source)| match source {
                RayLight::Gas(gas) => Some((*gas, self.spectral.total(*light))),
                RayLight::Star { .. } => None,
            })
            .collect();
        let mut tau = 0.0;
        for looked in steps {
            let (from, to, before, after) = (looked.from, looked.to, samples.at(looked.before), samples.at(looked.after));
            let middle = looked.middle.map(|middle| samples.at(middle));
            let mut step = RayStep { segment: Segment { from, to, tau, growth: 0.0 }, before, after, middle, gas_depth: 0.0 };
            let growth = (to - from) * step.mean(|sample| sample.sigma);
            step.segment.growth = growth;
            let mut sent: SmallVec<[f64; 2]> = SmallVec::from_elem(0.0, if step.middle.is_some() { 2 } else { 1 });
            for (gas, total) in &gas {
                sent.iter_mut().zip(step.glow(gas)).for_each(|(sent, glow)| *sent += total * glow);
            }
            step.gas_depth = step.mean_depth(&sent);
            for (light, source) in &sources {
                self.shine(*light, source, &step, eye);
            }
            if growth > 0.0 {
                eye.dust(&step.segment);
            }
            tau += growth;
            if self.exact && !eye.goes_on() && tau * self.spectral.least_k > END {
                break;
            }
        }
        tau
    }

    /// The lights that come from along the ray, those of stars only where they come star by star.
    fn sources(&self, seen: &[usize], scattered_together: bool) -> Vec<(usize, RayLight)> {
        let mut number = vec![None; self.space.stars.len()];
        seen.iter().enumerate().for_each(|(i, star)| number[*star] = Some(i));
        let source = |(light, l): (usize, &Light)| match l.route {
            Route::Scattered { star } if !scattered_together => number[star].map(|seen| (light, RayLight::Star { star, seen })),
            Route::Emitted { species } => {
                let has_front = self.space.gas()[species].front().is_some();
                Some((light, RayLight::Gas(GlowingSpecies { species, has_front })))
            }
            _ => None,
        };
        self.lights.iter().enumerate().filter_map(source).collect()
    }

    /// The ends of the steps [pc]. A step that is long beside its distance to a star is marched in parts, as the back
    /// ends do, where it is to be `cut`.
    fn ends(&self, near: f64, far: f64, cut: bool) -> Vec<StepEnd> {
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
            (1..=parts).map(move |part| StepEnd::smooth(t + dt * part as f64 / parts as f64))
        };
        (0..steps).flat_map(of_step).collect()
    }

    /// Light of one source in one step.
    fn shine(&self, light: usize, source: &RayLight, step: &RayStep, eye: &mut impl Eye) {
        match source {
            RayLight::Star { star, seen } if step.segment.growth > 0.0 => self.scatter(light, *star, *seen, step, eye),
            RayLight::Star { .. } => {}
            RayLight::Gas(gas) => {
                let glow = step.glow(gas);
                let density = step.segment.length() * glow.iter().sum::<f64>() / glow.len() as f64;
                if density > 0.0 {
                    let (tau, half) = (step.segment.tau + step.gas_depth, 0.5 * step.segment.growth);
                    eye.light(light, density, DepthSpan { from: tau - half, to: tau + half });
                }
            }
        }
    }

    /// Light of one star that one step scatters.
    fn scatter(&self, light: usize, star: usize, seen: usize, step: &RayStep, eye: &mut impl Eye) {
        let RayStep { segment, before, after, .. } = step;
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
            let ends = before.sigma + after.sigma;
            let tilt = if ends > 0.0 { 2.0 * (after.sigma - before.sigma) / ends } else { 0.0 };
            let share = 1.0 + tilt * ((j as f64 + 0.5) / phases as f64 - 0.5);
            (share * spectral.phase_factor(-u / r2.sqrt()) / r2, 1.0 / r2)
        };
        let (sum, weight) = (0..phases).map(sample).fold((0.0, 0.0), |(s, w), (p, v)| (s + p, w + v));
        let middle = tau + 0.5 * growth + step.mean_over_dust(|sample| sample.depths[seen]);
        let half = 0.5 * (growth + after.depths[seen] - before.depths[seen]);
        let depths = DepthSpan { from: middle - half, to: middle + half };
        eye.light(light, scattering * sum / weight, depths);
    }
}
