//! Pilot rays: what a step size and the resolution of the star depths cost in error, measured on the scene itself.
//!
//! Some rays of the image are marched in f64 with six steps a voxel and exact star depths; then with coarser steps and the baked depths, as the fast
//! back ends do. The coarsest that keeps `accuracy` (relative rms over the pilots, worst band) is taken.

use rayon::prelude::*;

use super::near::{self, NearPiece};
use super::segment::mean_inverse_square;
use super::volume::Channel;
use super::{Options, Space, Spectral};
use crate::control::Control;
use crate::error::Result;
use crate::geometry::Ray;
use crate::image::{relative_rms, worst};
use crate::light::{Light, Path};
use crate::scene::Scene;

/// The spatial error that pilot rays measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spatial {
    /// Samples in a voxel edge.
    pub per_voxel: f64,
    /// Relative rms error of the worst band.
    pub error: f64,
    /// How many rays were asked.
    pub rays: usize,
}

/// Pilot rays along each edge of the image.
const EDGE: usize = 10;
/// The part of the accuracy that the pilots may use up: rays between them can be worse.
const SHARE: f64 = 0.7;
/// Samples in a voxel edge, from cheap to dear.
const STEPS: [f64; 6] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0];
/// Those of the truth, whose own error is a few parts in 1e5.
const TRUTH: f64 = 6.0;
/// The finest star depths that are baked, in voxels along one of dust.
const MAX_FACTOR: usize = 3;

/// Picks the step, refining the star depths where they are what is wrong; returns samples in a voxel edge.
pub fn choose(
    scene: &Scene,
    lights: &[Light],
    spectral: &Spectral,
    space: &mut Space,
    options: &Options,
    control: &Control,
) -> Result<f64> {
    let camera = &scene.camera;
    let along = |n: usize, i: usize| n as f64 * (i as f64 + 0.5) / EDGE as f64;
    let rays: Vec<Ray> = (0..EDGE * EDGE).map(|i| camera.ray(along(camera.width, i % EDGE), along(camera.height, i / EDGE))).collect();
    let march = |space: &Space, per_voxel: f64, exact: bool| -> Result<Vec<Vec<f64>>> {
        let ray = |ray: &Ray| control.check().map(|()| march(space, spectral, lights, ray, per_voxel, exact));
        rays.par_iter().map(ray).collect()
    };
    let truth = march(space, TRUTH, true)?;
    let mut best = Spatial { per_voxel: STEPS[STEPS.len() - 1], error: f64::INFINITY, rays: rays.len() };
    for factor in 1..=MAX_FACTOR {
        if factor > 1 {
            // More memory than allowed for finer depths is no failure of the scene: the coarser ones stay, with their error stated.
            match space.refine_stars(factor, options, control) {
                Err(crate::Error::Memory { .. }) => {
                    space.refine_stars(factor - 1, options, control)?;
                    break;
                }
                other => other?,
            }
        }
        let mut improved = false;
        for per_voxel in STEPS {
            let error = relative_error(&march(space, per_voxel, false)?, &truth);
            if error < best.error {
                improved = best.error.is_infinite() || error < 0.8 * best.error || improved;
                best = Spatial { per_voxel, error, rays: rays.len() };
            }
            if error <= SHARE * options.method.accuracy {
                space.spatial = Some(Spatial { per_voxel, error, rays: rays.len() });
                return Ok(per_voxel);
            }
        }
        if !improved || space.stars.is_empty() {
            break;
        }
    }
    space.spatial = Some(best);
    Ok(best.per_voxel)
}

/// Largest relative rms over the bands.
fn relative_error(values: &[Vec<f64>], truth: &[Vec<f64>]) -> f64 {
    let bands = truth.first().map_or(0, Vec::len);
    let of_band = |b: usize| relative_rms(values.iter().zip(truth).map(|(v, t)| (v[b], t[b])));
    worst((0..bands).map(of_band))
}

/// Band radiances of one ray, marched as the fast back ends do, in f64.
fn march(space: &Space, spectral: &Spectral, lights: &[Light], ray: &Ray, per_voxel: f64, exact: bool) -> Vec<f64> {
    let mut bands = vec![0.0; spectral.bands.len()];
    let mut tau = 0.0;
    if let Some((near, far)) = space.occupied.and_then(|b| b.clip(ray)) {
        let steps = ((far - near) / space.voxel_pc() * per_voxel).ceil().max(1.0) as usize;
        let dt = (far - near) / steps as f64;
        let mut before = Sample::at(space, ray, near, exact);
        // A step that is long beside its distance to a star is marched in parts, as the back ends do.
        let voxel = space.voxel_pc();
        let feet = space.stars.iter().map(|star| {
            let foot = (*star - ray.origin).dot(ray.direction);
            (foot, (*star - ray.at(foot)).length())
        });
        let feet: Vec<(f64, f64)> = feet.collect();
        let ends = (0..steps).flat_map(|i| {
            let t = near + i as f64 * dt;
            let parts = feet.iter().map(|(foot, distance)| near::parts(*distance, foot - t, dt, voxel)).max().unwrap_or(1);
            (1..=parts).map(move |part| t + dt * part as f64 / parts as f64)
        });
        let mut t0 = near;
        for t1 in ends {
            let dt = t1 - t0;
            let after = Sample::at(space, ray, t1, exact);
            let growth = 0.5 * dt * (before.sigma + after.sigma);
            for (light, l) in lights.iter().enumerate() {
                match l.path {
                    Path::Scattered { star } if growth > 0.0 => {
                        let depths = (tau + before.depths[star], tau + growth + after.depths[star]);
                        let segment = Segment { span: (t0, t1), tau: (tau, growth), depths };
                        scatter((space, spectral), (light, star), ray, &segment, &mut bands);
                    }
                    Path::Emitted { species } => {
                        let density = 0.5 * dt * (before.emission[species] + after.emission[species]);
                        if density > 0.0 {
                            add(spectral, light, density, (tau, tau + growth), &mut bands);
                        }
                    }
                    _ => {}
                }
            }
            tau += growth;
            (t0, before) = (t1, after);
        }
    }
    for (light, _) in lights.iter().enumerate().filter(|(_, l)| l.path == Path::Background) {
        for (band, plan) in bands.iter_mut().zip(&spectral.bands) {
            *band += plan.rule.evaluate(light, tau);
        }
    }
    bands
}

/// A segment of a ray: distances of its ends, τ at its start and how it grows, depths eye to sample to star at its ends.
struct Segment {
    span: (f64, f64),
    tau: (f64, f64),
    depths: (f64, f64),
}

/// Scattered light of one star in one segment.
fn scatter((space, spectral): (&Space, &Spectral), (light, star): (usize, usize), ray: &Ray, segment: &Segment, bands: &mut [f64]) {
    let ((t0, t1), (tau, growth), depths) = (segment.span, segment.tau, segment.depths);
    let position = space.stars[star];
    let foot = (position - ray.origin).dot(ray.direction);
    let b = (position - ray.at(foot)).length();
    let (u0, u1) = (t0 - foot, t1 - foot);
    let product = b * b + u0 * u1;
    let reach = near::NEAR_VOXELS * space.voxel_pc();
    if product < reach * reach || b * (t1 - t0) > near::NEAR_ANGLE * product {
        near::pieces(space, position, ray, (t0, t1), (tau, growth), |NearPiece { scattering, depth, cosine }| {
            add(spectral, light, scattering * spectral.phase_factor(cosine), (depth, depth), bands);
        });
        return;
    }
    let scattering = growth * mean_inverse_square(b, u0, u1);
    let middle = ray.at(0.5 * (t0 + t1)) - position;
    let cosine = -middle.normalize_or_zero().dot(ray.direction);
    add(spectral, light, scattering * spectral.phase_factor(cosine), depths, bands);
}

/// Adds so much light to every band, fallen by the rule's mean over the depths.
fn add(spectral: &Spectral, light: usize, amount: f64, depths: (f64, f64), bands: &mut [f64]) {
    for (band, plan) in bands.iter_mut().zip(&spectral.bands) {
        *band += amount * plan.rule.mean(light, depths);
    }
}

/// What a place holds.
struct Sample {
    sigma: f64,
    depths: Vec<f64>,
    emission: Vec<f64>,
}

impl Sample {
    fn at(space: &Space, ray: &Ray, t: f64, exact: bool) -> Self {
        let p = ray.at(t);
        let mut sample = Self { sigma: 0.0, depths: vec![0.0; space.stars.len()], emission: vec![0.0; space.species()] };
        for volume in &space.volumes {
            // A place on the border belongs to the box, whatever its rounding.
            let margin = 1e-9 * volume.lattice.bounds.size();
            let grown = crate::geometry::Bounds { low: volume.lattice.bounds.low - margin, high: volume.lattice.bounds.high + margin };
            if !grown.contains(p) {
                continue;
            }
            for (c, channel) in volume.channels.iter().enumerate() {
                match *channel {
                    Channel::Dust => sample.sigma = volume.at(c, p),
                    Channel::StarDepth(star) if !exact => sample.depths[star] = volume.at(c, p),
                    Channel::StarDepth(_) => {}
                    Channel::Emission(species) => sample.emission[species] = volume.at(c, p),
                }
            }
        }
        if exact && sample.sigma > 0.0 {
            sample.depths.iter_mut().zip(&space.stars).for_each(|(d, star)| *d = space.depth(*star, p));
        }
        sample
    }
}
