//! Where the light of a star comes: sums in voxels, in whole units, which are the same in whatever order they come.
//!
//! A sum has 32 bits. Its unit is a part of the flux that all of the star's photons would be at the voxel's distance with nothing
//! in their way, so that near and far voxels are resolved as exactly; two of them are added at once.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use spectra::constants::SPHERE;

use crate::cloud::PARSEC_CM;
use crate::light::IonisingLight;
use crate::nodes::{Nodes, PLACES};
use crate::rays::Rays;

/// Units of a sum for the undimmed flux through the largest cross section of a voxel. Both are those of the voxel's nearest place,
/// so that all rays together bring no more than that, but for what they count of a voxel twice at its corners: sixteen times as
/// much has room in 32 bits.
pub const UNITS: f32 = (1u32 << 28) as f32;
/// Quantities after the flux per node, multiplied by the total flux: the distance that it has come \[pc\], the voxel's
/// cross section and the relative variance of ways through it ([`met`](crate::rays::Rays::met)).
pub const BEHIND: usize = 3;

/// Sums of the flux by node times the area of beams, of what stands behind it, and of that area.
pub struct Lit {
    pairs: Vec<AtomicU64>,
    nodes: usize,
    /// Pairs of a voxel.
    room: usize,
}

/// A ray as it enters a voxel.
pub struct Entering<'a> {
    /// The voxel.
    pub voxel: usize,
    /// Its cross section in parts of that of the voxel.
    pub part: f32,
    /// Photons by node, in parts of the star's within the ray's solid angle.
    pub photons: &'a Nodes,
    /// Factor to unattenuated fluxes in the voxel.
    pub factor: f32,
    /// Quantities after the flux, relative to the maximum of each.
    pub behind: [f32; BEHIND],
}

/// Whole units.
#[inline(always)]
fn in_units(value: f32) -> u32 {
    (value * UNITS + 0.5) as i32 as u32
}

/// Units of the cross section that a ray has of a voxel, at least one: rays that have lost their light do not part, and may be
/// wider than a long voxel.
#[inline(always)]
fn area_in_units(part: f32) -> u32 {
    in_units(part.min(1.0)).max(1)
}

impl Lit {
    /// None yet, in a given number of voxels, of a given number of nodes.
    pub fn new(cells: usize, nodes: usize) -> Self {
        let room = Self::room(nodes);
        Self { pairs: (0..cells * room).into_par_iter().map(|_| AtomicU64::new(0)).collect(), nodes, room }
    }

    /// Pairs of sums that a voxel has.
    const fn room(nodes: usize) -> usize {
        (nodes + BEHIND + 1).div_ceil(2)
    }

    /// Bytes that a voxel takes.
    pub const fn bytes(nodes: usize) -> usize {
        size_of::<AtomicU64>() * Self::room(nodes)
    }

    /// The place of the sum of areas.
    fn area(&self) -> usize {
        self.nodes + BEHIND
    }

    /// Has a ray enter a voxel.
    #[inline(always)]
    pub fn meet(&self, ray: &Entering) {
        let flux = *ray.photons * ray.factor;
        let (mut units, all) = ([0; PLACES], flux.sum());
        for (unit, flux) in units.iter_mut().zip(flux.0) {
            *unit = in_units(flux);
        }
        units[self.nodes..][..BEHIND].copy_from_slice(&ray.behind.map(|value| in_units(all * value)));
        units[self.area()] = area_in_units(ray.part);
        let pairs = &self.pairs[ray.voxel * self.room..][..self.room];
        for (pair, two) in pairs.iter().zip(units.chunks_exact(2)) {
            let both = u64::from(two[0]) | u64::from(two[1]) << 32;
            if both > 0 {
                pair.fetch_add(both, Ordering::Relaxed);
            }
        }
    }

    /// Has a ray enter a voxel that brings nothing.
    #[inline(always)]
    pub fn meet_dark(&self, voxel: usize, part: f32) {
        let place = self.area();
        let both = u64::from(area_in_units(part)) << (32 * (place % 2));
        self.pairs[voxel * self.room + place / 2].fetch_add(both, Ordering::Relaxed);
    }

    /// Adds the mean in each voxel of the flux of a star's rays, node by node \[s⁻¹ cm⁻²\], and what stands behind it; gives the
    /// sum over nodes of flux and cross section of hydrogen \[s⁻¹\]. All sums begin anew.
    pub fn add_to(&mut self, flux: &mut [f32], (rays, light): (&Rays, &IonisingLight)) -> Vec<f32> {
        let (nodes, room, area) = (self.nodes, self.room, self.area());
        let (photons, widest) = (light.photons.iter().sum::<f64>() / SPHERE, rays.widest_cross_section());
        let rates = |(voxel, (flux, pairs)): (usize, (&mut [f32], &mut [AtomicU64]))| {
            // Where no ray has come nothing else is looked at: most of the cloud, as a rule.
            if (*pairs[area / 2].get_mut() >> (32 * (area % 2))) as u32 == 0 {
                return 0.0;
            }
            let mut sums = [0.0; PLACES];
            for (two, pair) in sums.chunks_exact_mut(2).zip(pairs) {
                let both = std::mem::take(pair.get_mut());
                (two[0], two[1]) = (both as u32 as f64, (both >> 32) as f64);
            }
            let [nx, ny, _] = rays.cloud.dims;
            let square = rays.square([voxel % nx, voxel / nx % ny, voxel / (nx * ny)]);
            let undimmed = photons / (square * sums[area]);
            let most_behind = [rays.farthest_in(square) / PARSEC_CM, widest, 1.0];
            let (by_node, behind) = flux.split_at_mut(nodes);
            for ((to, sum), most) in behind.iter_mut().zip(&sums[nodes..]).zip(most_behind) {
                *to += (sum * most * undimmed) as f32;
            }
            let mut weighted = 0.0;
            for ((to, sum), sigma) in by_node.iter_mut().zip(sums).zip(&light.weakening[0]) {
                *to += (sum * undimmed) as f32;
                weighted += sum * undimmed * sigma;
            }
            weighted as f32
        };
        flux.par_chunks_exact_mut(nodes + BEHIND).zip(self.pairs.par_chunks_exact_mut(room)).enumerate().map(rates).collect()
    }
}
