//! Light of a star on its way through gas that is known.

use glam::DVec3;
use spectra::constants::SPHERE;

use crate::balance::Accuracy;
use crate::beam::mean_square;
use crate::cloud::PARSEC_CM;
use crate::known::{Crossing, Known, cross};
use crate::light::{ByNode, IonisingLight};
use crate::patch::Patch;
use crate::rays::{BEYOND, Rays};
use crate::tally::{Kept, Lit};

/// A star's light in a cloud.
pub struct Transport<'a> {
    rays: Rays<'a>,
    light: &'a IonisingLight,
    accuracy: &'a Accuracy,
    /// What is known of the gas; nothing where it is taken to be clear.
    known: Option<&'a Known<'a>>,
    /// By voxel, ionisations of hydrogen by the light of all other stars \[s⁻¹\].
    others: &'a [f32],
    /// The same by the star's when the gas was solved \[s⁻¹\].
    own: &'a [f32],
    /// Where it comes.
    pub lit: Lit,
    /// How much of it stays.
    pub kept: Kept,
    ionises: ByNode,
    /// The face of a cube of a voxel's volume \[cm²\].
    face_cm2: f64,
}

/// Photons of a patch on their way.
struct Ray {
    patch: Patch,
    photons: ByNode,
    /// How far they have come \[pc\], and the voxel that the whole of them met last.
    at: f64,
    met: Option<usize>,
}

/// A ray in a direction.
struct Way {
    direction: DVec3,
    solid_angle: f64,
    /// Voxels beside that direction ([`Rays::met`]).
    met: (f64, f64),
    /// Where it leaves the cloud \[pc\].
    far: f64,
}

impl<'a> Transport<'a> {
    /// The light of a star in a cloud, given what is known of that, and by voxel the ionisations of hydrogen by the light of all
    /// other stars and by its own \[s⁻¹\].
    pub fn new(
        rays: Rays<'a>,
        light: &'a IonisingLight,
        accuracy: &'a Accuracy,
        known: Option<&'a Known<'a>>,
        (others, own): (&'a [f32], &'a [f32]),
    ) -> Self {
        let voxel = rays.cloud.voxel * PARSEC_CM;
        let reach = (rays.nearest() * PARSEC_CM).max(voxel.min_element());
        let lit = Lit::new(rays.cloud.hydrogen.len(), (reach, rays.farthest() * PARSEC_CM), light);
        let face_cm2 = voxel.element_product().cbrt().powi(2);
        Self { rays, light, accuracy, known, others, own, ionises: light.ionises(), face_cm2, lit, kept: Kept::default() }
    }

    /// Has the light of a patch go its way.
    pub fn send(&self, patch: Patch) {
        let part = patch.solid_angle() / SPHERE;
        let mut waiting = vec![Ray { patch, photons: self.light.photons.map(|photons| photons * part), at: 0.0, met: None }];
        while let Some(ray) = waiting.pop() {
            self.follow(ray, &mut waiting);
        }
    }

    fn follow(&self, mut ray: Ray, waiting: &mut Vec<Ray>) {
        let (direction, solid_angle) = (ray.patch.direction(), ray.patch.solid_angle());
        let all = self.light.ionising() * solid_angle / SPHERE;
        let (mut left, mut dark) = (self.light.ionising_of(&ray.photons), None);
        let keep = |left: f64| self.kept.add(solid_angle / SPHERE * (1.0 - left / all).clamp(0.0, 1.0));
        let Some((near, far)) = self.rays.clipped(direction) else { return keep(left) };
        let way = Way { direction, solid_angle, met: self.rays.met(direction), far };
        let (widest, longest) = (self.rays.widest(solid_angle), self.rays.cloud.voxel.length());
        ray.at = ray.at.max(near);
        while ray.at < far * (1.0 - 1e-12) {
            if ray.at > widest && dark.is_none() {
                let part = |part: Patch| {
                    let share = part.solid_angle() / solid_angle;
                    Ray { patch: part, photons: ray.photons.map(|photons| photons * share), at: ray.at, met: ray.met }
                };
                return waiting.extend(ray.patch.parts().map(part));
            }
            if dark.is_none() && left <= self.accuracy.used_up * all {
                dark = Some(ray.at);
            }
            if dark.is_some_and(|since| ray.at - since > BEYOND * longest) {
                break;
            }
            self.cross(&mut ray, &way, (dark.is_none()).then_some(&mut left));
        }
        keep(left);
    }

    /// Goes through a voxel, and says how many photons are left that ionise where there are any.
    fn cross(&self, ray: &mut Ray, way: &Way, left: Option<&mut f64>) {
        let (voxel, exit) = self.rays.voxel(way.direction, ray.at);
        let (exit, cloud) = (exit.min(way.far), self.rays.cloud);
        let (inner, thickness) = (ray.at * PARSEC_CM, (exit - ray.at) * PARSEC_CM);
        let is_met = ray.met == Some(voxel);
        (ray.at, ray.met) = (exit, Some(voxel));
        if cloud.hydrogen[voxel] <= 0.0 {
            return;
        }
        let area = way.solid_angle * mean_square(inner, thickness);
        let part = area / self.face_cm2;
        let photons = &mut ray.photons;
        let Some(left) = left else {
            return self.lit.meet_dark(voxel, part);
        };
        if !is_met {
            self.lit.meet(voxel, part, (photons, 1.0 / area), [inner + 0.5 * thickness, way.met.0, way.met.1]);
        }
        if let Some(known) = self.known {
            let crossing = Crossing { inner, thickness, area, others: self.others[voxel].into(), own: self.own[voxel].into() };
            let by = (self.light, &self.ionises);
            *left = match known.lit(voxel) {
                Some(lit) => cross(photons, lit, &crossing, by),
                None => cross(photons, &known.dark(voxel), &crossing, by),
            };
        }
    }
}
