//! Rays from a star through the voxels of a cloud.

use glam::DVec3;
use rayon::prelude::*;

use crate::cloud::{Cloud, PARSEC_CM};
use crate::lanes::LANES;
use crate::patch::Patch;

/// The level of patches with which beams begin.
const FIRST: u32 = 3;
/// The level of patches at which a star is too far away for its light to be followed: more than 10⁸ of a voxel's edges.
const DEEPEST: u32 = 28;
/// Rounding error of an angle given by its cosine [rad].
const ROUNDED: f64 = 5e-8;
/// The largest area of a beam in parts of a voxel's face \[1\].
pub const WIDEST: f64 = 1.0;
/// Distance that a beam is followed after its light is absorbed, so that voxels know how much of them is dark \[voxels\].
pub const BEYOND: f64 = 3.0;

/// Hears of voxels that the light of one star has gone through, and says whether it is to go on.
pub type Listener<'a> = &'a (dyn Fn(u64) -> bool + Sync);

/// Rays from a place.
#[derive(Clone, Copy)]
pub struct Rays<'a> {
    /// Cloud that the rays cross.
    pub cloud: &'a Cloud<'a>,
    /// Positions of their sources \[pc\].
    pub place: DVec3,
}

impl Rays<'_> {
    /// The patches of all beams that the place sends to the cloud.
    pub fn sent_out(&self) -> Vec<Patch> {
        self.sent_out_in_blocks(1)
    }

    /// Variant for beams as wide as blocks of that many voxels along an edge, where all of a beam meets the cloud.
    pub fn sent_out_in_blocks(&self, edge: usize) -> Vec<Patch> {
        let mut patches = Vec::new();
        Patch::all(FIRST).for_each(|patch| self.begin(patch, edge as f64, &mut patches));
        patches
    }

    /// Has patches followed, some at a time; `listener` receives the number of finished voxels. Gives false where it or
    /// `follow` did not want to go on.
    pub fn in_parts(&self, patches: &[Patch], listener: Listener, follow: impl Fn(&[Patch]) -> bool + Sync) -> bool {
        let each = (self.cloud.hydrogen.len() / patches.len().div_ceil(LANES).max(1)) as u64;
        patches.par_chunks(LANES).all(|patches| listener(0) && follow(patches) && listener(each))
    }

    /// A patch whose beam meets the cloud, or its parts where that is too wide there.
    fn begin(&self, patch: Patch, edge: f64, patches: &mut Vec<Patch>) {
        let (low, high) = (self.cloud.low - self.place, self.cloud.high() - self.place);
        let middle = 0.5 * (low + high);
        if patch.level() == DEEPEST {
            return;
        }
        // What lies beside the sphere around the cloud does not meet it.
        let size = (0.5 * (high - low)).length();
        let beside = if middle.length() > size { (size / middle.length()).asin() } else { std::f64::consts::PI };
        if middle.length() > 0.0 && middle.normalize().dot(patch.direction()).clamp(-1.0, 1.0).acos() > beside + patch.reach() + ROUNDED {
            return;
        }
        // Where its middle misses the cloud, a part of it may meet the farthest corner.
        let enters = self.clipped(patch.direction()).map(|(enters, _)| enters);
        let enters_at = enters.unwrap_or_else(|| self.farthest());
        let widest = self.widest(patch.solid_angle());
        if enters_at > edge * widest || enters_at > widest && self.leaves_first(patch) <= enters_at {
            return patch.parts().into_iter().for_each(|part| self.begin(part, edge, patches));
        }
        if enters.is_some() {
            patches.push(patch);
        }
    }

    /// The distance up to which all of a patch is within the cloud or in front of it \[pc\]; zero where a corner misses it.
    pub fn leaves_first(&self, patch: Patch) -> f64 {
        patch.corners().map(|corner| self.clipped(corner).map_or(0.0, |(_, far)| far)).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The distance of the farthest corner \[pc\].
    pub fn farthest(&self) -> f64 {
        (self.cloud.low - self.place).abs().max((self.cloud.high() - self.place).abs()).length()
    }

    /// The distance from the star at which a beam is wider than a voxel \[pc\].
    pub fn widest(&self, solid_angle: f64) -> f64 {
        self.cloud.voxel.min_element() * (WIDEST / solid_angle).sqrt()
    }

    /// Entry and exit of a ray from the star \[pc\].
    pub fn clipped(&self, direction: DVec3) -> Option<(f64, f64)> {
        let (a, b) = ((self.cloud.low - self.place) / direction, (self.cloud.high() - self.place) / direction);
        let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
        (far > near).then_some((near, far))
    }

    /// A voxel's cross section in light of a direction, for that of a cube of its volume along its edges, and the relative
    /// variance of the ways ℓ that its rays have through it. Of two voxels that are t apart along the rays the common part
    /// is Π (1 − t dᵢ/eᵢ), and the integral of that over t is half of ⟨ℓ²⟩ times the cross section.
    pub fn met(&self, direction: DVec3) -> (f64, f64) {
        let edges = self.cloud.voxel / self.cloud.voxel.element_product().cbrt();
        let rates = direction.abs() / edges;
        let (area, longest) = (rates.element_sum(), 1.0 / rates.max_element());
        let pairs = rates.x * rates.y + rates.y * rates.z + rates.z * rates.x;
        let powers = [1.0, -area / 2.0, pairs / 3.0, -rates.element_product() / 4.0];
        let common = powers.into_iter().rev().fold(0.0, |sum, factor| sum * longest + factor) * longest;
        (area, (2.0 * common * area - 1.0).max(0.0))
    }

    /// A voxel's largest cross section in light of any direction, for that of a cube of its volume along its edges.
    pub fn widest_cross_section(&self) -> f64 {
        self.cloud.voxel.element_product().cbrt() * self.cloud.voxel.recip().length()
    }

    /// The square of a voxel's distance \[cm²\]: of its nearest place, and no less than half of its shortest edge.
    #[inline(always)]
    pub fn square(&self, voxel: [usize; 3]) -> f64 {
        let low = self.cloud.low + DVec3::from(voxel.map(|i| i as f64)) * self.cloud.voxel;
        let least = 0.5 * self.cloud.voxel.min_element();
        let nearest = self.place.clamp(low, low + self.cloud.voxel);
        (nearest - self.place).length_squared().max(least * least) * PARSEC_CM * PARSEC_CM
    }

    /// The largest distance in a voxel, given that square \[cm\].
    pub fn farthest_in(&self, square: f64) -> f64 {
        square.sqrt() + self.cloud.voxel.length() * PARSEC_CM
    }

    /// The way of a ray from voxel to voxel, from a distance on \[pc\].
    pub fn way(&self, direction: DVec3, at: f64) -> Way {
        let Cloud { dims, low, voxel, .. } = self.cloud;
        // A little farther on, so that a place on a face is behind it; far away from the star that is what rounding leaves.
        let little = (1e-9 * voxel.min_element()).max(4.0 * f64::EPSILON * at);
        let place = (self.place + (at + little) * direction - *low) / *voxel;
        let place: [usize; 3] = std::array::from_fn(|axis| (place[axis].max(0.0) as usize).min(dims[axis] - 1));
        let side = |axis: usize| place[axis] as f64 + f64::from(u8::from(direction[axis] > 0.0));
        let plane = |axis: usize| (low[axis] + side(axis) * voxel[axis] - self.place[axis]) / direction[axis];
        let next = std::array::from_fn(|axis| if direction[axis] == 0.0 { f64::INFINITY } else { plane(axis) });
        let apart = (*voxel / direction).abs().to_array();
        Way { place, dims: *dims, next, apart, forward: direction.to_array().map(|d| d > 0.0), at, little }
    }

    /// The voxel at a distance along a ray, and where the ray leaves it \[pc\].
    pub fn voxel(&self, direction: DVec3, at: f64) -> (usize, f64) {
        let way = self.way(direction, at);
        (way.voxel(), way.exit())
    }
}

/// A ray on its way from voxel to voxel.
pub struct Way {
    /// The voxel that it is in.
    pub place: [usize; 3],
    dims: [usize; 3],
    /// Distances to the next face across each axis, and how far such faces are apart along it \[pc\].
    next: [f64; 3],
    apart: [f64; 3],
    /// True if it goes towards higher numbers.
    forward: [bool; 3],
    /// Position, and path lengths that count as zero \[pc\].
    pub at: f64,
    little: f64,
}

impl Way {
    /// The voxel that it is in, as a number.
    #[inline(always)]
    pub fn voxel(&self) -> usize {
        (self.place[2] * self.dims[1] + self.place[1]) * self.dims[0] + self.place[0]
    }

    /// Exit from the voxel \[pc\].
    #[inline(always)]
    pub fn exit(&self) -> f64 {
        self.next[0].min(self.next[1]).min(self.next[2]).max(self.at + self.little)
    }

    /// Entry into the voxel, which lies behind the position where the ray begins in the voxel \[pc\].
    pub fn entry(&self) -> f64 {
        (0..3).map(|axis| self.next[axis] - self.apart[axis]).filter(|entry| entry.is_finite()).fold(0.0, f64::max)
    }

    /// Goes on to the next voxel, behind its exit; false where it leaves the cloud.
    #[inline(always)]
    pub fn go_on(&mut self) -> bool {
        self.at = self.exit();
        for axis in 0..3 {
            if self.next[axis] <= self.at + self.little {
                self.next[axis] += self.apart[axis];
                let place = if self.forward[axis] { self.place[axis] + 1 } else { self.place[axis].wrapping_sub(1) };
                if place >= self.dims[axis] {
                    return false;
                }
                self.place[axis] = place;
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beams from outside fill the part of the sphere that the cloud takes, to what a voxel at its edges takes.
    #[test]
    fn beams_fill_what_the_cloud_takes() {
        let hydrogen = vec![1.0; 40 * 40 * 40];
        let (low, voxel, abundances) = (DVec3::splat(-2.0), DVec3::splat(0.1), [0.0; crate::atoms::ELEMENTS]);
        let cloud = Cloud { dims: [40; 3], low, voxel, hydrogen: &hydrogen, abundances, dust_cm2: 0.0 };
        for place in [DVec3::new(0.3, 0.2, -2.1), DVec3::new(1.8, 1.7, -2.2), DVec3::new(-2.5, -2.3, -2.4)] {
            let rays = Rays { cloud: &cloud, place };
            let sent: f64 = rays.sent_out().into_iter().map(Patch::solid_angle).sum();
            let taken: f64 = Patch::all(7).filter(|patch| rays.clipped(patch.direction()).is_some()).map(Patch::solid_angle).sum();
            assert!((sent / taken - 1.0).abs() < 1e-2, "{place}: {sent} of {taken}");
        }
    }

    /// Parallel rays through a cube: how many meet it, and how long their ways are.
    #[test]
    fn voxels_are_met_as_rays_tell() {
        let cloud = Cloud {
            dims: [1; 3],
            low: DVec3::new(-1.0, -0.5, -0.25),
            voxel: DVec3::new(2.0, 1.0, 0.5),
            hydrogen: &[1.0],
            abundances: [0.0; crate::atoms::ELEMENTS],
            dust_cm2: 0.0,
        };
        for direction in [DVec3::new(0.01, 0.02, 1.0), DVec3::new(1.0, 0.01, 1.0), DVec3::ONE, DVec3::new(0.3, -0.5, 1.0)] {
            let direction = direction.normalize();
            let (u, v) = direction.any_orthonormal_pair();
            let (mut count, mut sums, edge) = (0.0, [0.0; 2], 400);
            for (i, j) in (0..edge).flat_map(|i| (0..edge).map(move |j| (i, j))) {
                let [x, y] = [i, j].map(|i| 3.0 * (f64::from(i) + 0.5) / f64::from(edge) - 1.5);
                let rays = Rays { cloud: &cloud, place: x * u + y * v - 5.0 * direction };
                if let Some((near, far)) = rays.clipped(direction) {
                    count += 1.0;
                    sums[0] += far - near;
                    sums[1] += (far - near).powi(2);
                }
            }
            let (area, variance) = Rays { cloud: &cloud, place: DVec3::ZERO }.met(direction);
            let truth = [count * 9.0 / f64::from(edge * edge), count * sums[1] / (sums[0] * sums[0]) - 1.0];
            assert!((area - truth[0]).abs() < 0.01 && (variance - truth[1]).abs() < 0.01, "{direction}: {area} {variance} {truth:?}");
        }
    }
}
