//! Detail below the voxels: a displacement that wrinkles clouds where a pixel sees finer than their grids.
//!
//! All that the camera sees at a place p is read at
//!
//!   p + Σ_j f_j ξ_j(p),   ξ_j = a λ_j c_j(p),                                        eq. (26) of docs/method.md
//!
//! c_j the curl of a noise whose waves are λ_j = 2^j pc long, from four voxels on downwards, its components of variance one; a the
//! [strength](Detail::strength); f_j one where a wave is longer than five pixels, zero where it is shorter than three. Each ξ_j keeps
//! volumes, so that means stay; edges and fronts become rough at all lengths alike, and voxels no longer show. Waves have their place,
//! turn and seed by j alone: a finer grid, or a closer look, adds waves and changes none.
//!
//! Cameras see it; stars do not: gas, depths of stars, light that scatters more than once and stars seen through the cloud are those
//! of the densities themselves, and so are measured spatial errors.

mod noise;

use std::ops::RangeInclusive;

use glam::{DMat3, DVec3};

#[doc(hidden)]
pub use noise::NORM;
pub use noise::{WAVELENGTH, double, single};

use crate::error::Result;
use crate::field::{Grid, within};
use crate::random::Counter;

/// Numbers of octaves.
pub const OCTAVES: RangeInclusive<i64> = 1..=8;
/// Displacements relative to the wavelength.
pub const STRENGTHS: RangeInclusive<f64> = 0.0..=0.2;
/// Longest wave \[voxels\].
const FIRST_VOXELS: f64 = 4.0;

/// Settings of detail below the voxel size.
#[derive(Debug, Clone, PartialEq)]
pub struct Detail {
    /// The number of the noise.
    pub seed: u32,
    /// Octaves from four voxels downwards.
    pub octaves: usize,
    /// Root mean square of a component of the displacement in each octave, relative to its wavelength; 0 disables detail.
    pub strength: f64,
}

impl Default for Detail {
    fn default() -> Self {
        Self { seed: 1, octaves: 6, strength: 0.05 }
    }
}

impl Detail {
    /// Refuses numbers outside of their ranges.
    ///
    /// # Errors
    /// If there is one; the error states the range.
    pub fn check(&self) -> Result<()> {
        within("octaves of detail", self.octaves as f64, *OCTAVES.start() as f64..=*OCTAVES.end() as f64)?;
        within("strength of detail", self.strength, STRENGTHS)?;
        Ok(())
    }
}

/// Waves of one length.
#[derive(Debug, Clone, PartialEq)]
pub struct Octave {
    /// Their length \[pc\].
    pub wavelength_pc: f64,
    /// The number of their noise, below 2²⁴.
    pub seed: u32,
    /// From a place \[pc\] to one of the noise: turned and scaled, then moved.
    pub turn: DMat3,
    /// The place of the noise at the origin.
    pub shift: DVec3,
    /// Displacements by both components of the noise \[pc\].
    pub displacements: [DVec3; 2],
}

impl Octave {
    fn new(detail: &Detail, exponent: i32) -> Self {
        // Angles between the axes of any two octaves are large, and no two seeds have an octave in common.
        const AXIS: DVec3 = DVec3::new(0.36, 0.48, 0.8);
        const GOLDEN: f64 = 2.399_963_229_728_653;
        let wavelength_pc = 2f64.powi(exponent);
        let mut random = Counter::nested(0xde7a11, u64::from(detail.seed), exponent as u64);
        let shift = DVec3::from([0; 3].map(|_| random.uniform()));
        let rotation = DMat3::from_axis_angle(AXIS, GOLDEN * f64::from(exponent));
        Self {
            wavelength_pc,
            seed: (random.uniform() * f64::from(1 << 24)) as u32,
            turn: rotation * (noise::WAVELENGTH / wavelength_pc),
            shift,
            displacements: [0, 1].map(|row| detail.strength * wavelength_pc * rotation.row(row)),
        }
    }

    /// The part of these waves that pixels of a footprint \[pc\] see: all of those over five of them, none below three.
    pub fn seen(&self, footprint_pc: f64) -> f64 {
        (0.5 * self.wavelength_pc / footprint_pc - 1.5).clamp(0.0, 1.0)
    }

    /// Displacement at a place \[pc\].
    fn displacement(&self, place: DVec3) -> DVec3 {
        let [first, second] = double((self.turn * place + self.shift).to_array(), self.seed);
        first * self.displacements[0] + second * self.displacements[1]
    }
}

/// The farthest place of the noise that single precision resolves well enough, to 1e-2 of a wave.
const FARTHEST: f64 = 1e5;

/// The displacement of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct FineDetail {
    /// Scene settings.
    pub settings: Detail,
    /// All octaves, the longest first.
    pub octaves: Vec<Octave>,
}

impl FineDetail {
    /// The displacement of a scene with some grids: from four of the coarsest voxels down to as many octaves below four of the finest.
    pub fn new<'a>(detail: &Detail, grids: impl Iterator<Item = &'a Grid>) -> Self {
        let (mut coarsest, mut finest, mut reach) = (0.0f64, f64::INFINITY, 0.0f64);
        for lattice in grids.map(Grid::lattice) {
            let voxel = lattice.voxel_pc().max_element();
            (coarsest, finest) = (coarsest.max(voxel), finest.min(voxel));
            reach = reach.max(lattice.bounds.low.abs().max(lattice.bounds.high.abs()).max_element());
        }
        if coarsest == 0.0 || detail.strength == 0.0 {
            return Self { settings: detail.clone(), octaves: Vec::new() };
        }
        let exponent = |voxel: f64| (FIRST_VOXELS * voxel).log2().round() as i32;
        let exponents = exponent(finest).saturating_sub(detail.octaves as i32 - 1)..=exponent(coarsest);
        let octaves = exponents.rev().map(|exponent| Octave::new(detail, exponent));
        let is_placed = |octave: &Octave| reach * WAVELENGTH <= FARTHEST * octave.wavelength_pc;
        Self { settings: detail.clone(), octaves: octaves.filter(is_placed).collect() }
    }

    /// Displacement at a place where a pixel is so wide \[pc\].
    pub fn displacement(&self, place: DVec3, footprint_pc: f64) -> DVec3 {
        let of_octave = |octave: &Octave| match octave.seen(footprint_pc) {
            0.0 => DVec3::ZERO,
            seen => seen * octave.displacement(place),
        };
        self.octaves.iter().map(of_octave).sum()
    }

    /// Upper bound of displacements \[pc\].
    pub fn reach_pc(&self) -> f64 {
        noise::MOST * self.settings.strength * self.octaves.iter().map(|octave| octave.wavelength_pc).sum::<f64>()
    }

    /// The length of the shortest waves that pixels of a footprint \[pc\] see; none where they see none.
    pub fn finest_pc(&self, footprint_pc: f64) -> Option<f64> {
        self.octaves.iter().rev().find(|octave| octave.seen(footprint_pc) > 0.0).map(|octave| octave.wavelength_pc)
    }

    /// Description.
    pub fn in_words(&self) -> String {
        let [longest, shortest] = [self.octaves.first(), self.octaves.last()].map(|o| o.map_or(0.0, |octave| octave.wavelength_pc));
        format!(
            "displacement by waves of {longest:.2e} to {shortest:.2e} pc where pixels resolve them, {} of each wavelength; gas, star depths, multiple scattering and spatial errors ignore it",
            self.settings.strength
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Lattice;
    use crate::geometry::Bounds;

    fn grid(edge: usize) -> Grid {
        Grid::sampled(Lattice { dims: [edge; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) }, |p| 2.0 + (9.0 * p.x).sin() * (7.0 * p.y).cos())
    }

    fn places(count: u64) -> impl Iterator<Item = DVec3> {
        (0..count).map(|i| {
            let mut random = Counter::new(2, i);
            DVec3::from([0; 3].map(|_| 2.0 * random.uniform() - 1.0))
        })
    }

    /// Displacements have no mean, lie across all directions, and become smaller as pixels grow, to nothing.
    #[test]
    fn displacements_fade() {
        let noise = FineDetail::new(&Detail::default(), [&grid(32)].into_iter());
        let mut before = f64::INFINITY;
        for footprint in [1e-4, 0.01, 0.03, 0.06] {
            let all: Vec<DVec3> = places(50_000).map(|p| noise.displacement(p, footprint)).collect();
            let mean = all.iter().sum::<DVec3>() / all.len() as f64;
            let square = all.iter().map(|v| *v * *v).sum::<DVec3>() / all.len() as f64;
            let spread = square.element_sum().sqrt();
            assert!(mean.length() < 0.02 * spread && spread < before, "{footprint}: {mean} {spread}");
            assert!(all.iter().all(|v| v.length() <= noise.reach_pc()));
            before = spread;
        }
        // The longest waves, of a quarter of a parsec, have 0.05 of their length in two components.
        let longest: f64 = places(50_000).map(|p| noise.octaves[0].displacement(p).length_squared()).sum::<f64>() / 5e4;
        assert!((longest.sqrt() / (0.05 * 0.25 * 2f64.sqrt()) - 1.0).abs() < 0.02, "{longest}");
        assert_eq!(noise.displacement(DVec3::ONE, 0.09), DVec3::ZERO);
    }

    /// Octaves halve from four voxels down; without strength, and where single precision resolves no positions, there is none.
    #[test]
    fn octaves_begin_at_four_voxels() {
        let lengths = |noise: FineDetail| noise.octaves.iter().map(|o| o.wavelength_pc).collect::<Vec<_>>();
        let detail = Detail { octaves: 4, ..Detail::default() };
        // Voxels of 1/16 pc.
        assert_eq!(lengths(FineDetail::new(&detail, [&grid(32)].into_iter())), [0.25, 0.125, 0.0625, 0.03125]);
        assert_eq!(lengths(FineDetail::new(&detail, [&grid(64), &grid(32)].into_iter())), [0.25, 0.125, 0.0625, 0.03125, 0.015625]);
        let far = Grid::sampled(Lattice { dims: [32; 3], bounds: Bounds::cube(DVec3::X * 4e3, 1.0) }, |_| 1.0);
        assert_eq!(lengths(FineDetail::new(&detail, [&far].into_iter())), [0.25, 0.125, 0.0625]);
        let none = Detail { strength: 0.0, ..detail };
        assert!(lengths(FineDetail::new(&none, [&grid(32)].into_iter())).is_empty());
    }

    /// A finer grid changes no waves that both have, another seed all.
    #[test]
    fn octaves_are_those_of_other_grids() {
        let coarse = FineDetail::new(&Detail::default(), [&grid(32)].into_iter());
        let both = FineDetail::new(&Detail::default(), [&grid(64), &grid(32)].into_iter());
        assert!(coarse.octaves == both.octaves[..coarse.octaves.len()] && both.octaves.len() == coarse.octaves.len() + 1);
        let p = DVec3::new(0.3, 0.1, -0.7);
        assert_eq!(coarse.displacement(p, 2e-3), both.displacement(p, 2e-3));
        let other = FineDetail::new(&Detail { seed: 2, ..Detail::default() }, [&grid(32)].into_iter());
        assert_ne!(coarse.displacement(p, 1e-3), other.displacement(p, 1e-3));
    }

    #[test]
    fn wrong_numbers_are_refused() {
        for (wrong, words) in [
            (Detail { octaves: 0, ..Detail::default() }, "octaves"),
            (Detail { octaves: 99, ..Detail::default() }, "octaves"),
            (Detail { strength: f64::NAN, ..Detail::default() }, "strength"),
            (Detail { strength: 0.5, ..Detail::default() }, "strength"),
        ] {
            assert!(wrong.check().unwrap_err().to_string().contains(words));
        }
        Detail::default().check().unwrap();
    }
}
