//! How rough a grid is at its finest: the spectrum that its logarithm has at a few voxels, for what continues it below them.
//!
//! With P(k) ∝ k^(−n) and E(k) = 4π k² P, the mean square of l(x + r) − 2 l(x) + l(x − r), l = ln ρ, is
//!
//!   D(r) = ∫ E(k) (6 − 8 sinc kr + 2 sinc 2kr) dk,   k ≤ π/voxel,
//!
//! which slopes of the cloud as a whole leave alone. D at two and at four voxels give n and E; the octave of a wavelength λ has
//! the variance ∫E dk over k = 2π/λ · 2^(±½). Squares are those of medians, weighted by mass, so that few walls that jump count
//! for little.

use std::f64::consts::PI;

use spectra::quadrature::integrate;

use crate::field::Grid;
use crate::random::Counter;

/// Places at which a grid is asked.
const PLACES: u64 = 1 << 14;
/// The median of what a normal number of variance one is away from zero.
const MEDIAN: f64 = 0.674_489_75;
/// Exponents that are distinguished: a cloud without fine waves gives the last.
const SLOPES: (f64, f64) = (3.05, 6.0);
/// The largest deviation that is believed.
const ROUGHEST: f64 = 1.0;

/// The waves of ln ρ around two voxels of a grid, were it to hold them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roughness {
    /// Two voxels \[pc\].
    pub wavelength_pc: f64,
    /// The deviation of ln ρ in the octave around that wavelength \[1\].
    pub deviation: f64,
    /// n of the spectrum k^−n of ln ρ in three dimensions \[1\].
    pub slope: f64,
}

impl Roughness {
    /// Description of a grid.
    pub fn stated(grid: &Grid, deviation: f64, slope: f64) -> Self {
        Self { wavelength_pc: two_voxels(grid), deviation, slope }
    }

    /// True if the grid has the voxel size on which the roughness was measured.
    pub fn is_of(&self, grid: &Grid) -> bool {
        (two_voxels(grid) / self.wavelength_pc - 1.0).abs() < 1e-9
    }

    /// Estimate from a grid's own voxels; a deviation of zero where it is empty or has few of them.
    pub fn of(grid: &Grid) -> Self {
        let wavelength_pc = two_voxels(grid);
        let [two, four] = [2, 4].map(|apart| second_difference(grid, apart));
        if !(two > 0.0 && four > 0.0) {
            return Self { wavelength_pc, deviation: 0.0, slope: SLOPES.1 };
        }
        // The ratio falls with the exponent.
        let (mut low, mut high) = SLOPES;
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let ratio = 2f64.powf(3.0 - middle) * response(middle, 2.0) / response(middle, 4.0);
            *if ratio > two / four { &mut low } else { &mut high } = middle;
        }
        let slope = 0.5 * (low + high);
        // E(k) = A k^(2−n), in voxels: k is π at two of them.
        let p = slope - 3.0;
        let level = two / (2f64.powf(p) * response(slope, 2.0));
        let variance = level * PI.powf(-p) * (2f64.powf(0.5 * p) - 2f64.powf(-0.5 * p)) / p;
        Self { wavelength_pc, deviation: variance.sqrt().min(ROUGHEST), slope }
    }

    /// The deviation in the octave around another wavelength.
    pub fn at(&self, wavelength_pc: f64) -> f64 {
        self.deviation * (wavelength_pc / self.wavelength_pc).powf(0.5 * (self.slope - 3.0))
    }
}

/// The length of two voxels \[pc\]: of cubes as large as they are, where they are none.
fn two_voxels(grid: &Grid) -> f64 {
    2.0 * (grid.lattice().voxel_pc().to_array().iter().map(|edge| edge.ln()).sum::<f64>() / 3.0).exp()
}

/// ∫ x^(2−n) (6 − 8 sinc x + 2 sinc 2x) dx up to the finest waves of a grid, for places a given number of voxels apart.
fn response(slope: f64, apart: f64) -> f64 {
    let sinc = |x: f64| x.sin() / x;
    let seen = |x: f64| if x < 0.05 { 0.2 * x.powi(4) } else { 6.0 - 8.0 * sinc(x) + 2.0 * sinc(2.0 * x) };
    integrate(|x| if x > 0.0 { x.powf(2.0 - slope) * seen(x) } else { 0.0 }, 0.0, apart * PI, 1e-7)
}

/// Voxel with another number along one axis.
fn neighbour(mut voxel: [usize; 3], axis: usize, number: usize) -> [usize; 3] {
    voxel[axis] = number;
    voxel
}

/// The mean square of second differences of ln ρ over a given number of voxels, by the median over places where there is mass.
fn second_difference(grid: &Grid, apart: usize) -> f64 {
    let dims = grid.lattice().dims;
    let axes: Vec<usize> = (0..3).filter(|axis| dims[*axis] > 2 * apart).collect();
    if axes.is_empty() {
        return 0.0;
    }
    let difference = |i: u64| {
        let mut random = Counter::new(1, i);
        let axis = axes[i as usize % axes.len()];
        let mut voxel = dims.map(|n| (random.uniform() * n as f64) as usize);
        voxel[axis] = apart + (random.uniform() * (dims[axis] - 2 * apart) as f64) as usize;
        let places = [voxel[axis] - apart, voxel[axis], voxel[axis] + apart];
        // Values behind a front are no density.
        if grid.front().is_some_and(|front| places.iter().any(|at| front.value(neighbour(voxel, axis, *at)) < 1.0)) {
            return None;
        }
        let values = places.map(|at| grid.value(neighbour(voxel, axis, at)));
        let [before, here, after] = values.map(|value| f64::from(value).ln());
        values.iter().all(|v| *v > 0.0).then(|| ((before - 2.0 * here + after).abs(), f64::from(values[1])))
    };
    let mut found: Vec<(f64, f64)> = (0..PLACES).filter_map(difference).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * found.iter().map(|(_, mass)| mass).sum::<f64>();
    let mut mass = 0.0;
    let median = found.iter().find(|(_, grid_slope)| {
        mass += grid_slope;
        mass >= half
    });
    median.map_or(0.0, |(difference, _)| (difference / MEDIAN).powi(2))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::{Lattice, Turbulence};
    use crate::geometry::Bounds;

    /// Of turbulence whose spectrum is known, slope and deviation are those of the waves that its voxels do not hold.
    #[test]
    fn a_known_spectrum_is_continued() {
        for slope in [11.0 / 3.0, 4.5] {
            let wanted = Turbulence { slope, voxels: 96, ..Turbulence::new(3, Bounds::cube(DVec3::ZERO, 2.0), 5.0).unwrap() };
            let found = Roughness::of(&wanted.grid(1 << 30).unwrap());
            let spectrum = wanted.spectrum();
            let middle = 1.0 / found.wavelength_pc;
            let shell = |q: f64| 4.0 * PI * q * q * spectrum(DVec3::X * q);
            let truth = integrate(shell, middle / 2f64.sqrt(), middle * 2f64.sqrt(), 1e-8).sqrt();
            assert!((found.deviation / truth - 1.0).abs() < 0.2, "{slope}: {found:?} {truth}");
            assert!((found.slope - slope).abs() < 0.3, "{slope}: {found:?}");
            // An octave below, there is as much less as the spectrum says.
            let below = integrate(shell, middle * 2f64.sqrt(), middle * 8f64.sqrt(), 1e-8).sqrt();
            assert!((found.at(0.5 * found.wavelength_pc) / below - 1.0).abs() < 0.25, "{slope}");
        }
    }

    /// What is smooth is continued by next to nothing, and what is empty, or has few voxels, by nothing at all.
    #[test]
    fn smooth_clouds_stay_smooth() {
        let sampled = |edge: usize, density: fn(DVec3) -> f64| {
            Grid::sampled(Lattice { dims: [edge; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) }, density)
        };
        let smooth = Roughness::of(&sampled(64, |p| (-3.0 * p.length_squared()).exp()));
        assert!(smooth.deviation < 0.01, "{smooth:?}");
        // A wall that jumps is no roughness.
        let wall = Roughness::of(&sampled(64, |p| if p.x > 0.1 { 5.0 } else { 1.0 }));
        assert_eq!(wall.deviation, 0.0);
        assert_eq!(Roughness::of(&sampled(64, |_| 0.0)).deviation, 0.0);
        assert_eq!(Roughness::of(&sampled(4, |p| 2.0 + p.x)).deviation, 0.0);
    }
}
