//! Density that supersonic turbulence leaves: lognormal, with the variance that a Mach number gives and a power spectrum.
//!
//! s = ln(ρ/⟨ρ⟩) is a Gaussian random field with
//!
//!   σ_s² = ln(1 + b² M² β/(1 + β)),   P(k) ∝ (k² + k₀²)^(−n/2),   k₀ = 2π/L,
//!
//! the first after Padoan, Nordlund & Jones 1997 (MNRAS 288, 145), Federrath, Klessen & Schmidt 2008 (ApJ 688, L79) and,
//! with magnetic fields, Molina et al. 2012 (MNRAS 423, 2680); the second after von Kármán, even beyond the outer scale L and
//! a power law within it. ρ = e^s over its mean, so that the mean of the box is one.
//!
//! Each wave has an amplitude of its own, by seed and wave numbers: more voxels add waves and change none. What they cannot
//! hold of σ_s² is missing from the field: waves shorter than two voxels.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use fourier::{Complex32, real_part, wave_number};
use glam::DVec3;
use rayon::prelude::*;
use spectra::fingerprint::Digest;
use spectra::quadrature::integrate;
use spectra::units::Length;

use super::{Field, Grid, within};
use crate::data::Inputs;
use crate::error::Result;
use crate::field::lattice::Lattice;
use crate::geometry::Bounds;
use crate::memory;
use crate::properties::{Choice, Choices, Integer, Key, Kind, Number, OrDefault, Position, Section};
use crate::random::Counter;

/// How compressive the forcing is, b: 1/3 where it is solenoidal, 1 where it is compressive, 0.4 for the natural mixture
/// (Federrath et al. 2010, A&A 512, A81).
#[derive(Clone, Copy)]
enum Forcing {
    Solenoidal,
    Mixed,
    Compressive,
}

impl Choices for Forcing {
    const ROWS: &'static [(&'static str, Self)] =
        &[("solenoidal", Self::Solenoidal), ("mixed", Self::Mixed), ("compressive", Self::Compressive)];
}

impl Forcing {
    const fn b(self) -> f64 {
        match self {
            Self::Solenoidal => 1.0 / 3.0,
            Self::Mixed => 0.4,
            Self::Compressive => 1.0,
        }
    }
}
/// Default exponent of the three-dimensional spectrum: that of Kolmogorov, 5/3 along a line.
const SLOPE_OF_KOLMOGOROV: f64 = 11.0 / 3.0;
/// Voxels that are made at once where a scene is read roughly: the same waves, without the fine ones.
const ROUGH: usize = 64;

const SEED: Key<Integer<u32>, OrDefault> = Key::integer("seed", "seed of the random waves").default(1);
const LOW: Key<Position, OrDefault> = Key::position("low", "lower corner of the box; the field is periodic in it").default("-1 -1 -1 pc");
const HIGH: Key<Position, OrDefault> = Key::position("high", "upper corner of the box").default("1 1 1 pc");
const VOXELS: Key<Integer<usize>, OrDefault> =
    Key::integer("voxels", "voxels along the longest edge; more voxels add finer waves and keep the others").range(8..=2048).default(128);
const OUTER_SCALE: Key<Length> = Key::quantity::<Length>("outer_scale", "driving scale of turbulence; larger waves are not stronger")
    .positive()
    .otherwise("half of the shortest edge");
const MACH: Key<Number, OrDefault> = Key::number("mach", "rms Mach number M; 0 is uniform").range(0.0..=1000.0).default(5.0);
const FORCING: Key<Choice<Forcing>, OrDefault> =
    Key::choice("forcing", "driving of the turbulence: b = 1/3, 0.4 or 1 in σ² = ln(1 + b² M²)").default("mixed");
const PLASMA_BETA: Key<Number> =
    Key::number("plasma_beta", "thermal over magnetic pressure").range(1e-6..=1e6).otherwise("no magnetic field");
const SLOPE: Key<Number, OrDefault> =
    Key::number("slope", "n of the spectrum k^-n of ln ρ in three dimensions: 3.6 to 4.3 in simulations (Federrath et al. 2010)")
        .range(3.05..=8.0)
        .default(SLOPE_OF_KOLMOGOROV)
        .example("3.667");

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "turbulence",
    summary: "lognormal density of supersonic turbulence in a box, with mean 1, on voxels",
    keys: &[SEED.row, LOW.row, HIGH.row, VOXELS.row, OUTER_SCALE.row, MACH.row, FORCING.row, PLASMA_BETA.row, SLOPE.row],
    build,
};

/// Keys of a turbulent field.
#[derive(Debug, Clone, PartialEq)]
pub struct Turbulence {
    /// The number of the random waves.
    pub seed: u32,
    /// The box, in which the field is periodic \[pc\].
    pub bounds: Bounds,
    /// Voxels along the longest edge.
    pub voxels: usize,
    /// The scale from which on waves become weaker \[pc\].
    pub outer_scale: f64,
    /// The variance of ln ρ.
    pub variance: f64,
    /// The exponent of the spectrum in three dimensions.
    pub slope: f64,
}

impl Turbulence {
    /// Turbulence of a Mach number whose forcing is a natural mixture, in a box \[pc\], driven at half of its shortest edge.
    /// Change its fields, then ask for its [`grid`](Self::grid).
    ///
    /// # Errors
    /// If the box has no size, or the number is none.
    pub fn new(seed: u32, bounds: Bounds, mach: f64) -> Result<Self> {
        let bounds = bounds.checked()?;
        MACH.check(mach)?;
        let variance = variance(mach, Forcing::Mixed.b(), None);
        Ok(Self { seed, bounds, voxels: 128, outer_scale: 0.5 * bounds.size().min_element(), variance, slope: SLOPE_OF_KOLMOGOROV })
    }

    /// The density on voxels, of mean one.
    ///
    /// # Errors
    /// If a number is out of its range, or the waves take more than `memory_limit` bytes.
    pub fn grid(&self, memory_limit: u64) -> Result<Grid> {
        VOXELS.check(self.voxels as f64)?;
        SLOPE.check(self.slope)?;
        within("variance of the logarithm", self.variance, 0.0..=20.0)?;
        let bounds = self.bounds.checked()?;
        let edge = bounds.size().max_element();
        within("outer scale", self.outer_scale, 1e-6 * edge..=1e6 * edge)?;
        let lattice = Lattice::along(bounds, self.voxels);
        let bytes = (lattice.cells() as u64).saturating_mul(fourier::BYTES);
        memory::check("the waves of a field of turbulence", bytes, memory_limit)?;
        let mut density = real_part(self.waves(&lattice), lattice.dims);
        density.par_iter_mut().for_each(|v| *v = v.exp());
        let planes = density.par_chunks(lattice.dims[0] * lattice.dims[1]).map(|plane| plane.iter().map(|v| f64::from(*v)).sum::<f64>());
        // In the order of planes, whatever the threads.
        let mean = planes.collect::<Vec<f64>>().iter().sum::<f64>() / density.len() as f64;
        density.par_iter_mut().for_each(|v| *v = (f64::from(*v) / mean) as f32);
        Ok(Grid::from_lattice(lattice, density))
    }

    /// The amplitude of each wave: the real part of their sum is ln ρ, but for what makes the mean one.
    fn waves(&self, lattice: &Lattice) -> Vec<Complex32> {
        let [nx, ny, nz] = lattice.dims;
        let (size, spectrum) = (lattice.bounds.size(), self.spectrum());
        let mut waves = vec![Complex32::default(); lattice.cells()];
        waves.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
            let (y, z) = (wave_number(row % ny, ny), wave_number(row / ny, nz));
            let variance = |x: usize| spectrum(DVec3::new(x as f64, y as f64, z as f64) / size) / size.element_product();
            let variances: Vec<f64> = (0..=nx / 2).map(variance).collect();
            for (i, wave) in out.iter_mut().enumerate() {
                let number = [wave_number(i, nx), y, z];
                // A wave of two voxels has no partner on the other side.
                if number.iter().zip(lattice.dims).any(|(k, count)| 2 * k.unsigned_abs() as usize == count) || number == [0; 3] {
                    continue;
                }
                let mut random = Counter::nested(u64::from(self.seed), pair(number[0], number[1]), number[2] as u64);
                // Box & Muller's normal numbers.
                let (length, turn) = ((-2.0 * (1.0 - random.uniform()).ln()).sqrt(), random.uniform());
                // Values are those in the middles of voxels.
                let angle = TAU * turn + PI * (0..3).map(|axis| number[axis] as f64 / lattice.dims[axis] as f64).sum::<f64>();
                let amplitude = variances[i.min(nx - i)].sqrt() * length;
                *wave = Complex32::new((amplitude * angle.cos()) as f32, (amplitude * angle.sin()) as f32);
            }
        });
        waves
    }

    /// The variance of ln ρ for each unit of the space of waves \[pc³\], by waves in a parsec along each axis.
    pub fn spectrum(&self) -> impl Fn(DVec3) -> f64 + Sync + use<> {
        let n = self.slope;
        let outer = 1.0 / self.outer_scale;
        // ∫ 4π k² (k² + k₀²)^(−n/2) dk is 4π k₀^(3−n) ∫ sin²θ cos^(n−4)θ dθ by k = k₀ tan θ, and that a plain integral over
        // cos^(n−3)θ.
        let angles = integrate(|u: f64| (1.0 - u.powf(2.0 / (n - 3.0))).max(0.0).sqrt(), 0.0, 1.0, 1e-9) / (n - 3.0);
        let factor = self.variance / (4.0 * PI * outer.powf(3.0 - n) * angles);
        move |waves| factor * (waves.length_squared() + outer * outer).powf(-0.5 * n)
    }
}

/// One number of two.
fn pair(a: i64, b: i64) -> u64 {
    (a as u64) << 32 | (b as u64 & 0xffff_ffff)
}

/// The variance of ln ρ at a Mach number.
fn variance(mach: f64, forcing: f64, plasma_beta: Option<f64>) -> f64 {
    let magnetic = plasma_beta.map_or(1.0, |beta| beta / (1.0 + beta));
    (forcing * forcing * mach * mach * magnetic).ln_1p()
}

/// True if a table asks for more voxels than can be made at once.
pub(super) fn takes_long(section: &Section) -> bool {
    section.read(&VOXELS).is_ok_and(|voxels| voxels > ROUGH)
}

fn build(section: &Section, inputs: &Inputs) -> Result<Arc<dyn Field>> {
    let bounds = Bounds { low: section.read(&LOW)?, high: section.read(&HIGH)? };
    let bounds = section.wrap(&HIGH, bounds.checked())?;
    let seed = section.read(&SEED)?;
    let mach = section.read(&MACH)?;
    let plain = section.wrap(&MACH, Turbulence::new(seed, bounds, mach))?;
    let turbulence = Turbulence {
        voxels: section.read(&VOXELS)?.min(if inputs.is_rough { ROUGH } else { usize::MAX }),
        outer_scale: section.read(&OUTER_SCALE)?.map_or(plain.outer_scale, |length| length.0),
        variance: variance(mach, section.read(&FORCING)?.b(), section.read(&PLASMA_BETA)?),
        slope: section.read(&SLOPE)?,
        ..plain
    };
    let content = || Digest::new("turbulence").plain(&turbulence).finish();
    let make = || section.wrap(&VOXELS, turbulence.grid(inputs.memory_limit));
    Ok(Arc::new(Grid::stored(inputs.cache.as_deref(), content, &Lattice::along(bounds, turbulence.voxels), make)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turbulence(voxels: usize) -> Turbulence {
        Turbulence { voxels, ..Turbulence::new(5, Bounds::cube(DVec3::ZERO, 2.0), 6.0).unwrap() }
    }

    fn logarithms(turbulence: &Turbulence) -> Vec<f64> {
        turbulence.grid(1 << 30).unwrap().values().iter().map(|v| f64::from(*v).ln()).collect()
    }

    /// The variance of all waves is that of the Mach number, and that of the voxels what their waves hold of it; the mean is
    /// one, and the logarithm is normal: its third and fourth moments are those of a bell.
    #[test]
    fn density_is_lognormal() {
        let wanted = turbulence(96);
        let spectrum = wanted.spectrum();
        assert!((wanted.variance - (1.0f64 + 0.16 * 36.0).ln()).abs() < 1e-12);
        // Over all directions at once, with the waves in parsecs^-1.
        let shells = integrate(|k: f64| 4.0 * PI * k * k * spectrum(DVec3::X * k), 0.0, 4000.0, 1e-7);
        assert!((shells / wanted.variance - 1.0).abs() < 0.01, "{shells} {}", wanted.variance);
        let mass: f64 = (0..96usize.pow(3))
            .map(|i| [i % 96, i / 96 % 96, i / 9216].map(|k| wave_number(k, 96)))
            .filter(|k| *k != [0; 3] && k.iter().all(|k| k.abs() < 48))
            .map(|k| spectrum(DVec3::from(k.map(|k| k as f64)) / 4.0) / 64.0)
            .sum();
        assert!(mass < wanted.variance && mass > 0.8 * wanted.variance, "{mass}");
        let grid = wanted.grid(1 << 30).unwrap();
        let mean = grid.values().iter().map(|v| f64::from(*v)).sum::<f64>() / 96f64.powi(3);
        assert!((mean - 1.0).abs() < 1e-5, "{mean}");
        // Over several boxes, since large waves are few.
        let moments: Vec<[f64; 3]> = (0..6)
            .map(|seed| {
                let s = logarithms(&Turbulence { seed, voxels: 96, ..wanted.clone() });
                let mean = s.iter().sum::<f64>() / s.len() as f64;
                [2, 3, 4].map(|n| s.iter().map(|v| (v - mean).powi(n)).sum::<f64>() / s.len() as f64)
            })
            .collect();
        let [second, third, fourth] = [0, 1, 2].map(|n| moments.iter().map(|m| m[n]).sum::<f64>() / 6.0);
        assert!((second / mass - 1.0).abs() < 0.1, "{second} {mass}");
        assert!(third.abs() < 0.2 * second.powf(1.5) && (fourth / (3.0 * second * second) - 1.0).abs() < 0.15, "{third} {fourth}");
    }

    /// Along lines, each wave has the power of all waves of space that look like it there.
    #[test]
    fn the_spectrum_is_what_was_asked_for() {
        for slope in [SLOPE_OF_KOLMOGOROV, 4.3] {
            let mut measured = [0.0; 3];
            let wanted = Turbulence { slope, ..turbulence(64) };
            let spectrum = wanted.spectrum();
            for seed in 0..4 {
                let s = logarithms(&Turbulence { seed, ..wanted.clone() });
                for row in s.chunks_exact(64) {
                    for (k, power) in [4usize, 8, 16].into_iter().zip(&mut measured) {
                        let part =
                            |f: fn(f64) -> f64| row.iter().enumerate().map(|(x, v)| v * f(TAU * (k * x) as f64 / 64.0)).sum::<f64>() / 64.0;
                        *power += (part(f64::cos).powi(2) + part(f64::sin).powi(2)) / (4.0 * 4096.0);
                    }
                }
            }
            let expected = |kx: f64| -> f64 {
                let around = |i: usize| (wave_number(i % 64, 64), wave_number(i / 64, 64));
                let all = (0..4096).map(around).filter(|(y, z)| y.abs() < 32 && z.abs() < 32);
                // Its cosine and its sine have half of a wave's variance, and the wave that runs the other way looks the same.
                all.map(|(y, z)| spectrum(DVec3::new(kx, y as f64, z as f64) / 4.0) / 64.0).sum()
            };
            for (k, power) in [4.0, 8.0, 16.0].into_iter().zip(measured) {
                assert!((power / expected(k) - 1.0).abs() < 0.15, "{slope} {k}: {power} {}", expected(k));
            }
            // A slope that differs by a half would be seen.
            let falls = (measured[0] / measured[2]) / (expected(4.0) / expected(16.0));
            assert!((falls - 1.0).abs() < 0.2, "{falls}");
        }
    }

    /// More voxels show the same cloud, finer; another seed shows another.
    #[test]
    fn voxels_add_waves_and_change_none() {
        let coarse = logarithms(&turbulence(32));
        let likeness = |fine: &[f64]| {
            let mean = |x: usize, y: usize, z: usize| -> f64 {
                let parts = (0..8).map(|i| (2 * x + i % 2, 2 * y + i / 2 % 2, 2 * z + i / 4));
                parts.map(|(x, y, z)| fine[(z * 64 + y) * 64 + x]).sum::<f64>() / 8.0
            };
            let pairs: Vec<(f64, f64)> = (0..32usize.pow(3)).map(|i| (coarse[i], mean(i % 32, i / 32 % 32, i / 1024))).collect();
            let count = pairs.len() as f64;
            let (a, b) = (pairs.iter().map(|p| p.0).sum::<f64>() / count, pairs.iter().map(|p| p.1).sum::<f64>() / count);
            let product = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>();
            let both = product(&|p| (p.0 - a) * (p.1 - b));
            both / (product(&|p| (p.0 - a).powi(2)) * product(&|p| (p.1 - b).powi(2))).sqrt()
        };
        let correlation = likeness(&logarithms(&turbulence(64)));
        let other = likeness(&logarithms(&Turbulence { seed: 6, ..turbulence(64) }));
        assert!(correlation > 0.95 && other.abs() < 0.3, "{correlation} {other}");
    }

    #[test]
    fn wrong_numbers_are_refused() {
        let plain = turbulence(64);
        for (wrong, words) in [
            (Turbulence { slope: 3.0, ..plain.clone() }, "slope"),
            (Turbulence { outer_scale: 0.0, ..plain.clone() }, "outer scale"),
            (Turbulence { outer_scale: 1e-70, ..plain.clone() }, "outer scale"),
            (Turbulence { voxels: 4, ..plain.clone() }, "voxels"),
            (Turbulence { variance: f64::NAN, ..plain.clone() }, "variance"),
        ] {
            let error = wrong.grid(1 << 30).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        assert!(plain.grid(1 << 20).unwrap_err().to_string().contains("waves"));
        assert!(Turbulence::new(1, Bounds::cube(DVec3::ZERO, 0.0), 5.0).is_err());
    }
}
