//! Detail below the voxels: noise that continues the spectrum of a density where a pixel sees finer than its grid.
//!
//! A density ρ is seen as
//!
//!   ρ(p) exp(Σ_j s_j f_j n_j(p) − Σ_j M(s_j f_j)),   M(s) = ln ⟨e^(s n)⟩,        eq. (26) of docs/method.md
//!
//! n_j noise of variance one whose waves are λ_j = 2^j pc long, from two voxels on downwards; s_j their deviation, which the grid's
//! own [roughness](Roughness) says, or the scene; f_j one where a wave is longer than five pixels, zero where it is shorter than
//! three. The mean stays what it was. Waves have their place, turn and seed by j alone: a finer grid, or a closer look, adds waves
//! and changes none.
//!
//! Eyes see it; stars do not: depths of stars, light that scatters more than once and stars seen through the cloud are those of
//! the densities themselves, and so are measured spatial errors.

mod noise;
mod roughness;

use std::ops::RangeInclusive;

use glam::{DMat3, DVec3};

pub use noise::single;
#[doc(hidden)]
pub use noise::{CUMULANTS, NORM};
pub use noise::{MOST, WAVELENGTH, double, log_mean};
pub use roughness::Roughness;

use crate::error::Result;
use crate::field::{Grid, within};
use crate::random::Counter;

/// Numbers of octaves.
pub const OCTAVES: RangeInclusive<i64> = 1..=8;
/// Factors by which measured deviations may be made larger.
pub const STRENGTHS: RangeInclusive<f64> = 0.0..=10.0;
/// Deviations of the first octave.
pub const DEVIATIONS: RangeInclusive<f64> = 0.0..=1.5;
/// Exponents of spectra.
pub const SLOPES: RangeInclusive<f64> = 3.05..=8.0;

/// Settings of detail below the voxel size.
#[derive(Debug, Clone, PartialEq)]
pub struct Detail {
    /// The number of the noise.
    pub seed: u32,
    /// Octaves below two voxels.
    pub octaves: usize,
    /// A factor of all deviations.
    pub strength: f64,
    /// The deviation of ln ρ in the octave of two voxels; where it is not said, that of each grid as it is measured.
    pub deviation: Option<f64>,
    /// n of the spectrum k^−n that is continued; where it is not said, that of each grid.
    pub slope: Option<f64>,
}

impl Default for Detail {
    fn default() -> Self {
        Self { seed: 1, octaves: 4, strength: 1.0, deviation: None, slope: None }
    }
}

impl Detail {
    /// Refuses numbers that scenes may not say.
    ///
    /// # Errors
    /// If there is one, with what would be right.
    pub fn check(&self) -> Result<()> {
        within("octaves of detail", self.octaves as f64, *OCTAVES.start() as f64..=*OCTAVES.end() as f64)?;
        within("strength of detail", self.strength, STRENGTHS)?;
        within("deviation of detail", self.deviation.unwrap_or(0.0), DEVIATIONS)?;
        within("slope of detail", self.slope.unwrap_or(*SLOPES.start()), SLOPES)?;
        Ok(())
    }

    /// The roughness with which a grid is continued.
    fn roughness(&self, grid: &Grid) -> Roughness {
        let stated = self.deviation.zip(self.slope);
        let roughness = stated.map_or_else(|| Roughness::of(grid), |(deviation, slope)| Roughness::stated(grid, deviation, slope));
        let deviation = self.strength * self.deviation.unwrap_or(roughness.deviation);
        Roughness { deviation: deviation.min(*DEVIATIONS.end()), slope: self.slope.unwrap_or(roughness.slope), ..roughness }
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
    /// The deviation of ln ρ by them, for each density: dust first, then each species of gas \[1\].
    pub deviations: Vec<f64>,
}

impl Octave {
    fn new(seed: u32, exponent: i32) -> Self {
        // Angles between the axes of any two octaves are large, and no two seeds have an octave in common.
        const AXIS: DVec3 = DVec3::new(0.36, 0.48, 0.8);
        const GOLDEN: f64 = 2.399_963_229_728_653;
        let wavelength_pc = 2f64.powi(exponent);
        let mut random = Counter::nested(0xde7a11, u64::from(seed), exponent as u64);
        let shift = DVec3::from([0; 3].map(|_| random.uniform()));
        let turn = DMat3::from_axis_angle(AXIS, GOLDEN * f64::from(exponent)) * (noise::WAVELENGTH / wavelength_pc);
        Self { wavelength_pc, seed: (random.uniform() * f64::from(1 << 24)) as u32, turn, shift, deviations: Vec::new() }
    }

    /// The part of these waves that pixels of a footprint \[pc\] see: all of those over five of them, none below three.
    pub fn seen(&self, footprint_pc: f64) -> f64 {
        (0.5 * self.wavelength_pc / footprint_pc - 1.5).clamp(0.0, 1.0)
    }
}

/// The farthest place of the noise that single precision resolves well enough, to 1e-2 of a wave.
const FARTHEST: f64 = 1e5;

/// Largest distance of a grid from the origin \[pc\].
fn reach(grid: &Grid) -> f64 {
    let bounds = grid.lattice().bounds;
    bounds.low.abs().max(bounds.high.abs()).max_element()
}

/// The noise that continues the grids of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct FineDetail {
    /// Scene settings.
    pub settings: Detail,
    /// All octaves, the longest first.
    pub octaves: Vec<Octave>,
    /// Continuation of each density.
    pub roughness: Vec<Roughness>,
}

impl FineDetail {
    /// The noise that continues some grids, the densities of a scene in their order.
    pub fn new<'a>(detail: &Detail, grids: impl Iterator<Item = &'a Grid>) -> Self {
        Self::by(detail, grids, &[])
    }

    /// The noise that continues some grids by roughness that is known of as many; where a grid has other voxels it is measured.
    pub fn by<'a>(detail: &Detail, grids: impl Iterator<Item = &'a Grid>, known: &[Roughness]) -> Self {
        let grids: Vec<&Grid> = grids.collect();
        let known = |i: usize| known.get(i).filter(|roughness| known.len() == grids.len() && roughness.is_of(grids[i])).copied();
        let roughness: Vec<Roughness> = (0..grids.len()).map(|i| known(i).unwrap_or_else(|| detail.roughness(grids[i]))).collect();
        let reaches: Vec<f64> = grids.iter().map(|grid| reach(grid)).collect();
        // The octave that two voxels lie in is the first of a grid.
        let first = |roughness: &Roughness| roughness.wavelength_pc.log2().round() as i32;
        let (highest, lowest) = roughness.iter().map(first).fold((i32::MIN, i32::MAX), |(high, low), k| (high.max(k), low.min(k)));
        let exponents = lowest.saturating_sub(detail.octaves as i32 - 1)..=highest;
        let octaves = exponents.rev().map(|exponent| {
            let octave = Octave::new(detail.seed, exponent);
            let deviation = |(roughness, reach): (&Roughness, &f64)| {
                let is_resolved = (first(roughness) - detail.octaves as i32 + 1..=first(roughness)).contains(&exponent);
                let is_placed = reach * WAVELENGTH <= FARTHEST * octave.wavelength_pc;
                if is_resolved && is_placed { roughness.at(octave.wavelength_pc).min(*DEVIATIONS.end()) } else { 0.0 }
            };
            Octave { deviations: roughness.iter().zip(&reaches).map(deviation).collect(), ..octave }
        });
        let octaves = octaves.filter(|octave| octave.deviations.iter().any(|s| *s > 0.0)).collect();
        Self { settings: detail.clone(), octaves, roughness }
    }

    /// The factor of a density at a place where a pixel is so wide \[pc\].
    pub fn factor(&self, density: usize, place: DVec3, footprint_pc: f64) -> f64 {
        let exponent = |octave: &Octave| {
            let s = octave.deviations[density] * octave.seen(footprint_pc);
            if s == 0.0 { 0.0 } else { s * double((octave.turn * place + octave.shift).to_array(), octave.seed) - log_mean(s) }
        };
        self.octaves.iter().map(exponent).sum::<f64>().exp()
    }

    /// Upper bound of a density's factor.
    pub fn most(&self, density: usize) -> f64 {
        self.octaves.iter().map(|octave| MOST * octave.deviations[density]).sum::<f64>().exp()
    }

    /// Factor of a density at two standard deviations.
    pub fn usual_most(&self, density: usize) -> f64 {
        let variance = self.octaves.iter().map(|octave| octave.deviations[density].powi(2)).sum::<f64>();
        (2.0 * variance.sqrt()).exp()
    }

    /// The length of the shortest waves of a density that pixels of a footprint \[pc\] see; none where they see none.
    pub fn finest_pc(&self, density: usize, footprint_pc: f64) -> Option<f64> {
        let seen = |octave: &&Octave| octave.deviations[density] * octave.seen(footprint_pc) > 0.0;
        self.octaves.iter().rev().find(seen).map(|octave| octave.wavelength_pc)
    }

    /// Description.
    pub fn in_words(&self) -> String {
        let [longest, shortest] = [self.octaves.first(), self.octaves.last()].map(|o| o.map_or(0.0, |octave| octave.wavelength_pc));
        let deviations: Vec<String> =
            self.roughness.iter().map(|roughness| format!("{:.2} (k^-{:.1})", roughness.deviation, roughness.slope)).collect();
        format!(
            "noise below the voxels, waves of {longest:.2e} to {shortest:.2e} pc where pixels resolve them, deviations of ln density {} in the octave of two voxels; star depths, multiple scattering and spatial errors ignore it",
            deviations.join(", ")
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

    fn detail() -> Detail {
        Detail { deviation: Some(0.4), slope: Some(11.0 / 3.0), ..Detail::default() }
    }

    fn places(count: u64) -> impl Iterator<Item = DVec3> {
        (0..count).map(|i| {
            let mut random = Counter::new(2, i);
            DVec3::from([0; 3].map(|_| 2.0 * random.uniform() - 1.0))
        })
    }

    /// The mean of all factors is one at every footprint, and their spread falls as pixels grow, to nothing.
    #[test]
    fn the_mean_stays() {
        let noise = FineDetail::new(&detail(), [&grid(32)].into_iter());
        let mut before = f64::INFINITY;
        for footprint in [1e-4, 0.01, 0.02, 0.03, 0.05] {
            let factors: Vec<f64> = places(200_000).map(|p| noise.factor(0, p, footprint)).collect();
            let mean = factors.iter().sum::<f64>() / factors.len() as f64;
            let spread = (factors.iter().map(|f| f.ln().powi(2)).sum::<f64>() / factors.len() as f64).sqrt();
            assert!((mean - 1.0).abs() < 0.01, "{footprint}: {mean}");
            assert!(factors.iter().all(|f| *f <= noise.most(0)) && spread < before, "{footprint}: {spread}");
            before = spread;
        }
        assert_eq!(noise.factor(0, DVec3::ONE, 0.07), 1.0);
    }

    /// Octaves halve from two voxels down, each as strong as the slope says; without roughness there is none.
    #[test]
    fn octaves_continue_a_grid() {
        let noise = FineDetail::new(&detail(), [&grid(32)].into_iter());
        // Voxels of 1/16 pc: waves of 1/8.
        assert_eq!(noise.octaves.iter().map(|o| o.wavelength_pc).collect::<Vec<_>>(), [0.125, 0.0625, 0.03125, 0.015625]);
        let deviations: Vec<f64> = noise.octaves.iter().map(|o| o.deviations[0]).collect();
        assert!((deviations[0] - 0.4).abs() < 1e-12 && (deviations[2] / deviations[0] - 2f64.powf(-2.0 / 3.0)).abs() < 1e-12);
        let turned = |o: &Octave| (o.turn * o.turn.transpose()).col(0).x.sqrt() * o.wavelength_pc;
        assert!(noise.octaves.iter().all(|o| (turned(o) - WAVELENGTH).abs() < 1e-12));
        let measured = FineDetail::new(&Detail::default(), [&grid(32)].into_iter());
        assert!(measured.octaves.len() == 4 && measured.octaves.iter().all(|o| o.deviations[0] < 0.05));
        // Where single precision resolves no positions, there is no noise.
        let far = Grid::sampled(Lattice { dims: [32; 3], bounds: Bounds::cube(DVec3::X * 2e3, 1.0) }, |_| 1.0);
        assert_eq!(
            FineDetail::new(&detail(), [&far].into_iter()).octaves.iter().map(|o| o.wavelength_pc).collect::<Vec<_>>(),
            [0.125, 0.0625, 0.03125]
        );
        // What is as rough as can be is no rougher in a first octave that is longer than two voxels.
        let rough = Detail { deviation: Some(1.5), slope: Some(8.0), ..detail() };
        let voxel = |edge: usize| FineDetail::new(&rough, [&grid(edge)].into_iter()).octaves[0].deviations[0];
        assert!((24..=46).all(|edge| voxel(edge) <= 1.5));
        let none = Detail { strength: 0.0, ..detail() };
        assert!(FineDetail::new(&none, [&grid(32)].into_iter()).octaves.is_empty());
    }

    /// A finer grid, and a second one beside it, change no waves that both have: each has those below its own voxels.
    #[test]
    fn octaves_are_those_of_other_grids() {
        let coarse = FineDetail::new(&detail(), [&grid(32)].into_iter());
        let both = FineDetail::new(&detail(), [&grid(64), &grid(32)].into_iter());
        assert_eq!(both.octaves.len(), 5);
        for (one, other) in coarse.octaves.iter().zip(&both.octaves) {
            assert_eq!((one.seed, one.turn, one.shift, one.deviations[0]), (other.seed, other.turn, other.shift, other.deviations[1]));
        }
        assert!(both.octaves[0].deviations[0] == 0.0 && both.octaves[4].deviations[1] == 0.0 && both.octaves[4].deviations[0] > 0.0);
        let p = DVec3::new(0.3, 0.1, -0.7);
        assert_eq!(coarse.factor(0, p, 1e-3), both.factor(1, p, 1e-3));
        let other = FineDetail::new(&Detail { seed: 2, ..detail() }, [&grid(32)].into_iter());
        assert_ne!(coarse.factor(0, p, 1e-3), other.factor(0, p, 1e-3));
    }

    #[test]
    fn wrong_numbers_are_refused() {
        for (wrong, words) in [
            (Detail { octaves: 0, ..detail() }, "octaves"),
            (Detail { octaves: 99, ..detail() }, "octaves"),
            (Detail { strength: f64::NAN, ..detail() }, "strength"),
            (Detail { deviation: Some(7.0), ..detail() }, "deviation"),
            (Detail { slope: Some(2.0), ..detail() }, "slope"),
        ] {
            assert!(wrong.check().unwrap_err().to_string().contains(words));
        }
        detail().check().unwrap();
    }
}
