//! Light of a star on its way through gas that is known.

use multiversion::multiversion;
use rayon::prelude::*;
use spectra::constants::SPHERE;

use crate::beam::mean_square;
use crate::cloud::PARSEC_CM;
use crate::light::IonisingLight;
use crate::lit::{Entering, Lit};
use crate::nodes::Nodes;
use crate::patch::Patch;
use crate::rays::{BEYOND, Rays};
use crate::tally::AbsorbedShare;
use crate::tracer::{Failure, Light, Listener, Task, Turns};
use crate::voxel::{ByStar, Crossing, Voxel, cross};

/// Turns of light on the processor.
pub struct OnProcessor<'a> {
    task: Task<'a>,
    lit: Lit,
}

impl<'a> OnProcessor<'a> {
    /// None yet.
    pub fn new(task: Task<'a>) -> Self {
        Self { task, lit: Lit::new(task.cloud.hydrogen.len(), task.kind().energies_ev.len()) }
    }
}

impl Turns for OnProcessor<'_> {
    fn next(&mut self, voxels: Option<&[Voxel]>, light: &mut Light, listener: Listener) -> Result<Vec<f64>, Failure> {
        light.flux.fill(0.0);
        let mut escaped = Vec::new();
        for (number, star) in self.task.stars.iter().enumerate() {
            let (rays, others) = (self.task.rays(number), sum_but(&light.rates, number));
            let transport = Transport::new(&self.task, (rays, star.light), voxels, &others, &self.lit);
            let send = |patch: &Patch| {
                transport.send(*patch);
                listener(0)
            };
            if !rays.in_parts(&rays.sent_out(), listener, |patches| patches.iter().all(send)) {
                return Err(Failure::Stopped);
            }
            escaped.push(transport.cache.escaped());
            light.rates[number] = self.lit.add_to(&mut light.flux, (&rays, star.light));
        }
        Ok(escaped)
    }
}

/// By voxel the sum over all stars but one.
fn sum_but(values: &[Vec<f32>], but: usize) -> Vec<f32> {
    let others = |voxel: usize| values.iter().enumerate().filter(|(i, _)| *i != but).map(|(_, values)| values[voxel]).sum();
    (0..values[but].len()).into_par_iter().map(others).collect()
}

/// A star's light in a cloud.
struct Transport<'a> {
    rays: Rays<'a>,
    by: ByStar,
    /// Fraction of the light below which a beam ends.
    used_up: f32,
    /// State of the gas; `None` for transparent gas.
    voxels: Option<&'a [Voxel]>,
    /// The opacity of neutral gas for one nucleus of hydrogen \[cm²\].
    dark: Nodes,
    /// By voxel, ionisations of hydrogen by the light of all other stars \[s⁻¹\].
    others: &'a [f32],
    /// Sums of the star's light in voxels.
    lit: &'a Lit,
    /// Fraction of the star's photons that stays in the cloud.
    cache: AbsorbedShare,
    /// The star's photons in a steradian \[s⁻¹ sr⁻¹\], and by node in parts of all.
    photons: f64,
    parts: Nodes,
    /// The face of a cube of a voxel's volume \[cm²\] times the largest cross section.
    widest_cm2: f64,
    /// That cross section, in parts of that face.
    widest: f64,
}

/// Photons of a patch on their way.
#[derive(Clone, Copy)]
struct PhotonRay {
    patch: Patch,
    photons: Nodes,
    /// Distance covered \[pc\], and the last voxel that all of them entered.
    at: f64,
    met: Option<usize>,
}

impl<'a> Transport<'a> {
    fn new(
        task: &Task<'a>,
        (rays, light): (Rays<'a>, &IonisingLight),
        voxels: Option<&'a [Voxel]>,
        others: &'a [f32],
        lit: &'a Lit,
    ) -> Self {
        let (all, parts) = (light.photons.iter().sum::<f64>(), Nodes::of(&light.parts(), 1.0));
        let widest = rays.widest_cross_section();
        let widest_cm2 = (rays.cloud.voxel * PARSEC_CM).element_product().cbrt().powi(2) * widest;
        let (by, dark, used_up) = (ByStar::new(light), Nodes::of(&task.dark, 1.0), task.used_up as f32);
        Self {
            rays,
            by,
            used_up,
            voxels,
            dark,
            others,
            lit,
            cache: AbsorbedShare::default(),
            photons: all / SPHERE,
            parts,
            widest_cm2,
            widest,
        }
    }

    /// Has the light of a patch go its way.
    fn send(&self, patch: Patch) {
        let mut waiting = vec![PhotonRay { patch, photons: self.parts, at: 0.0, met: None }];
        while let Some(ray) = waiting.pop() {
            follow(self, ray, &mut waiting);
        }
    }
}

/// Follows a ray up to where it parts or ends.
#[multiversion(targets = "simd")]
fn follow(transport: &Transport, mut ray: PhotonRay, waiting: &mut Vec<PhotonRay>) {
    let Transport { rays, by, used_up, voxels, others, lit, cache, .. } = transport;
    let (direction, solid_angle) = (ray.patch.direction(), ray.patch.solid_angle());
    let all = (transport.parts * by.ionises).sum();
    let (mut left, mut dark) = ((ray.photons * by.ionises).sum(), None);
    let (cloud, used_up) = (rays.cloud, used_up * all);
    let keep = |left: f32| cache.add(solid_angle / SPHERE * f64::from(1.0 - left / all).clamp(0.0, 1.0));
    let Some((near, far)) = rays.clipped(direction) else { return keep(left) };
    let (area, variance) = rays.met(direction);
    let (area, variance) = ((area / transport.widest) as f32, variance as f32);
    let (part, widest, beyond) = (solid_angle / transport.widest_cm2, rays.widest(solid_angle), BEYOND * cloud.voxel.length());
    let mut way = rays.way(direction, ray.at.max(near));
    while way.at < far * (1.0 - 1e-12) {
        if dark.is_none() {
            if way.at > widest {
                return waiting.extend(ray.patch.parts().map(|patch| PhotonRay { patch, at: way.at, ..ray }));
            }
            if left <= used_up {
                dark = Some(way.at);
            }
        }
        if dark.is_some_and(|since| way.at - since > beyond) {
            break;
        }
        let (voxel, exit) = (way.voxel(), way.exit().min(far));
        if cloud.hydrogen[voxel] > 0.0 {
            let (inner, thickness) = (way.at * PARSEC_CM, (exit - way.at) * PARSEC_CM);
            let mean_square = mean_square(inner, thickness);
            let part = (part * mean_square) as f32;
            if dark.is_some() {
                lit.meet_dark(voxel, part);
            } else {
                if ray.met != Some(voxel) {
                    let square = rays.square(way.place);
                    let distance = (inner + 0.5 * thickness) / rays.farthest_in(square);
                    let (factor, behind) = ((square / mean_square) as f32 * part, [distance as f32, area, variance]);
                    lit.meet(&Entering { voxel, part, photons: &ray.photons, factor, behind });
                }
                if let Some(voxels) = voxels {
                    let crossing = Crossing { inner, thickness, undimmed: transport.photons / mean_square, others: others[voxel] };
                    left = if voxels[voxel].is_lit() {
                        cross(&mut ray.photons, &voxels[voxel], &crossing, by)
                    } else {
                        cross(&mut ray.photons, &Voxel::dark(transport.dark * cloud.hydrogen[voxel]), &crossing, by)
                    };
                }
            }
        }
        ray.met = Some(voxel);
        if !way.go_on() {
            break;
        }
    }
    keep(left);
}
