//! Light of a star on its way through gas that is known.

use multiversion::multiversion;
use spectra::constants::SPHERE;

use crate::balance::Accuracy;
use crate::beam::mean_square;
use crate::cloud::PARSEC_CM;
use crate::known::Known;
use crate::light::IonisingLight;
use crate::lit::{Entering, Lit};
use crate::nodes::Nodes;
use crate::patch::Patch;
use crate::rays::{BEYOND, Rays};
use crate::tally::Kept;
use crate::voxel::{ByStar, Crossing, cross};

/// A star's light in a cloud.
pub struct Transport<'a> {
    rays: Rays<'a>,
    by: ByStar,
    accuracy: &'a Accuracy,
    /// What is known of the gas; nothing where it is taken to be clear.
    known: Option<&'a Known<'a>>,
    /// By voxel, ionisations of hydrogen by the light of all other stars \[s⁻¹\].
    others: &'a [f32],
    /// Where it comes.
    lit: &'a Lit,
    /// How much of it stays.
    pub kept: Kept,
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
struct Ray {
    patch: Patch,
    photons: Nodes,
    /// How far they have come \[pc\], and the voxel that the whole of them met last.
    at: f64,
    met: Option<usize>,
}

impl<'a> Transport<'a> {
    /// The light of a star in a cloud, given what is known of that, and by voxel the ionisations of hydrogen by the light of all
    /// other stars \[s⁻¹\].
    pub fn new(
        (rays, light): (Rays<'a>, &'a IonisingLight),
        accuracy: &'a Accuracy,
        known: Option<&'a Known<'a>>,
        others: &'a [f32],
        lit: &'a Lit,
    ) -> Self {
        let all = light.photons.iter().sum::<f64>();
        let parts = Nodes::of(&light.photons, if all > 0.0 { 1.0 / all } else { 0.0 });
        let widest = rays.widest_cross_section();
        let widest_cm2 = (rays.cloud.voxel * PARSEC_CM).element_product().cbrt().powi(2) * widest;
        let (by, kept) = (ByStar::new(light), Kept::default());
        Self { rays, by, accuracy, known, others, lit, kept, photons: all / SPHERE, parts, widest_cm2, widest }
    }

    /// Has the light of a patch go its way.
    pub fn send(&self, patch: Patch) {
        let mut waiting = vec![Ray { patch, photons: self.parts, at: 0.0, met: None }];
        while let Some(ray) = waiting.pop() {
            follow(self, ray, &mut waiting);
        }
    }
}

/// Follows a ray up to where it parts or ends.
#[multiversion(targets = "simd")]
fn follow(transport: &Transport, mut ray: Ray, waiting: &mut Vec<Ray>) {
    let Transport { rays, by, accuracy, known, others, lit, kept, .. } = transport;
    let (direction, solid_angle) = (ray.patch.direction(), ray.patch.solid_angle());
    let all = (transport.parts * by.ionises).sum();
    let (mut left, mut dark) = ((ray.photons * by.ionises).sum(), None);
    let (cloud, used_up) = (rays.cloud, accuracy.used_up as f32 * all);
    let keep = |left: f32| kept.add(solid_angle / SPHERE * f64::from(1.0 - left / all).clamp(0.0, 1.0));
    let Some((near, far)) = rays.clipped(direction) else { return keep(left) };
    let (area, variance) = rays.met(direction);
    let (area, variance) = ((area / transport.widest) as f32, variance as f32);
    let (part, widest, beyond) = (solid_angle / transport.widest_cm2, rays.widest(solid_angle), BEYOND * cloud.voxel.length());
    let mut way = rays.way(direction, ray.at.max(near));
    while way.at < far * (1.0 - 1e-12) {
        if dark.is_none() {
            if way.at > widest {
                return waiting.extend(ray.patch.parts().map(|patch| Ray { patch, at: way.at, ..ray }));
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
                    let (factor, behind) = ((square / mean_square) as f32, [distance as f32, area, variance]);
                    lit.meet(&Entering { voxel, part, photons: &ray.photons, factor, behind });
                }
                if let Some(known) = known {
                    let crossing = Crossing { inner, thickness, undimmed: transport.photons / mean_square, others: others[voxel] };
                    left = match known.lit(voxel) {
                        Some(lit) => cross(&mut ray.photons, lit, &crossing, by),
                        None => cross(&mut ray.photons, &known.dark(voxel), &crossing, by),
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
