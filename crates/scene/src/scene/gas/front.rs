//! Ionisation fronts below the voxel.
//!
//! Beams store the ionised fraction f of each voxel. A front is mostly thinner than a voxel, and its place within the voxel follows from
//! f alone: where the smoothed fraction passes one half. Emission is therefore stored as a grid with a [front](Grid::front),
//!
//!   ε(p) = e(p) min(max(u(p), 0), 1),   u = ½ + (f̃ − ½) M                                              (G8) of docs/gas.md
//!
//! f̃ is f, smoothed twice by the cubic B-spline of the voxels. M is [`SHARPNESS`] where f̃ falls within a few voxels, and 1 where it
//! falls slowly: gas that is partly ionised over many voxels has no front, and ε is then the smoothed emission. e is the emission of the
//! ionised side, continued across the front, such that the light around each voxel is that of the solution.

use std::sync::Arc;

use rayon::prelude::*;

use crate::field::{Grid, Lattice, along, filtered, largest_around, voxel_shares};

/// Rise of u per voxel, relative to that of the ionised fraction.
const SHARPNESS: f32 = 8.0;
/// Change of the smoothed ionised fraction per voxel below which gas has no front, and above which it has one. A plane front has 0.36.
const SLOPES: (f32, f32) = (0.1, 0.2);
/// Ionised fraction that counts as one: beams leave a trace of neutral hydrogen everywhere.
const IONISED: f32 = 0.95;
/// Largest mean share of a voxel and its neighbours at which it counts as neutral and gets no emission.
const DARK: f32 = 1e-3;
/// Corrections of e (Richardson 1972, J. Opt. Soc. Am. 62, 55; Lucy 1974, AJ 79, 745).
const CORRECTIONS: usize = 2;
/// Largest factor of a correction.
const MOST_CORRECTION: f32 = 4.0;

/// Fronts of a cloud.
pub(super) struct Fronts {
    lattice: Lattice,
    front: Arc<Grid>,
    /// Mean shares of the voxels.
    shares: Vec<f32>,
    /// Smoothed shares of voxels next to a front; one elsewhere.
    smooth_shares: Vec<f32>,
}

impl Fronts {
    /// Fronts of a cloud with the ionised fractions of its voxels.
    pub fn new(lattice: &Lattice, ionised: Vec<f32>) -> Self {
        let dims = lattice.dims;
        let fractions = ionised.into_par_iter().map(|fraction| (fraction / IONISED).min(1.0)).collect();
        let smooth = smoothed(dims, smoothed(dims, fractions));
        let steep = smoothed(dims, largest_around(dims, &slopes(dims, &smooth)));
        let sharpened = |(fraction, slope): (f32, f32)| {
            let part = ((slope - SLOPES.0) / (SLOPES.1 - SLOPES.0)).clamp(0.0, 1.0);
            let sharpness = 1.0 + (SHARPNESS - 1.0) * part * part * (3.0 - 2.0 * part);
            0.5 + (fraction - 0.5) * sharpness
        };
        let values: Vec<f32> = smooth.into_par_iter().zip(steep).map(sharpened).collect();
        let shares = voxel_shares(dims, &values);
        let front = Arc::new(Grid::from_lattice(lattice.clone(), values));
        let smooth_shares = smoothed(dims, shares.clone());
        Self { lattice: lattice.clone(), front, shares, smooth_shares }
    }

    /// Emission of voxels that ends at the fronts.
    pub fn shaded(&self, emission: Vec<f32>) -> Grid {
        let (dims, shares) = (self.lattice.dims, &self.shares);
        let wanted = smoothed(dims, emission);
        let share = |whole: &f32| if *whole > DARK { 1.0 / whole } else { 0.0 };
        let mut values: Vec<f32> = wanted.par_iter().zip(&self.smooth_shares).map(|(value, whole)| value * share(whole)).collect();
        for _ in 0..CORRECTIONS {
            let light = values.par_iter().zip(shares).map(|(value, share)| value * share).collect();
            let mut ratios = smoothed(dims, light);
            let ratio = |found: f32, wanted: f32| if found > 0.0 { (wanted / found).min(MOST_CORRECTION) } else { 1.0 };
            // Away from fronts, the smoothed emission is the one that is wanted.
            ratios
                .par_iter_mut()
                .zip(wanted.par_iter().zip(shares).zip(&self.smooth_shares))
                .for_each(|(found, ((wanted, share), whole))| *found = share * if *whole < 1.0 { ratio(*found, *wanted) } else { 1.0 });
            let factors = smoothed(dims, ratios);
            values.par_iter_mut().zip(factors.par_iter().zip(&self.smooth_shares)).for_each(|(value, (factor, whole))| {
                *value *= factor * share(whole);
            });
        }
        Grid::from_lattice(self.lattice.clone(), values).with_front(self.front.clone())
    }
}

/// Cubic B-spline of values at their own voxels: each is shared with its neighbours, by 1/6, 2/3 and 1/6 along each axis. The sum
/// stays.
fn smoothed(dims: [usize; 3], values: Vec<f32>) -> Vec<f32> {
    filtered(dims, values, |before, here, after| (before + after + 4.0 * here) / 6.0)
}

/// Change of a value per voxel, at each voxel.
fn slopes(dims: [usize; 3], values: &[f32]) -> Vec<f32> {
    let mut squares = vec![0.0; values.len()];
    (0..3).for_each(|axis| {
        along(dims, axis, values, &mut squares, |square, before, _, after| *square += 0.25 * (after - before) * (after - before));
    });
    squares.par_iter_mut().for_each(|square| *square = square.sqrt());
    squares
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::Field;
    use crate::geometry::Bounds;

    const EDGE: usize = 48;
    /// Radius of the front \[voxels\].
    const RADIUS: f64 = 18.3;
    /// The density of hydrogen grows by a factor of e over this length towards the front \[voxels\].
    const SCALE: f64 = 6.0;

    /// Voxels of one parsec, the middle of the sphere not on a grid point.
    fn lattice() -> Lattice {
        Lattice { dims: [EDGE; 3], bounds: Bounds::cube(DVec3::new(0.17, -0.24, 0.31), 0.5 * EDGE as f64) }
    }

    /// Emission of a sphere whose density grows towards its front, before the gas ends.
    fn emission(p: DVec3) -> f64 {
        (2.0 * (p.length() - RADIUS) / SCALE).exp()
    }

    /// Means over voxels of the ionised fraction, which falls from one to zero over a width, and of the emission.
    fn solution(width: f64) -> (Vec<f32>, Vec<f32>) {
        const PLACES: usize = 5;
        let lattice = lattice();
        let mean = |voxel: usize| {
            let [x, y, z] = lattice.place(voxel);
            let centre = lattice.centre(x, y, z);
            let (mut fraction, mut light) = (0.0, 0.0);
            for i in 0..PLACES.pow(3) {
                let part = |i: usize| (i as f64 + 0.5) / PLACES as f64 - 0.5;
                let p = centre + DVec3::new(part(i % PLACES), part(i / PLACES % PLACES), part(i / PLACES.pow(2)));
                let ionised = (0.5 - (p.length() - RADIUS) / width).clamp(0.0, 1.0);
                fraction += ionised;
                light += ionised * emission(p);
            }
            let count = PLACES.pow(3) as f64;
            ((fraction / count) as f32, (light / count) as f32)
        };
        (0..lattice.cells()).into_par_iter().map(mean).unzip()
    }

    fn directions(count: usize) -> impl Iterator<Item = DVec3> {
        (0..count).map(move |i| {
            let (z, turn) = (1.0 - (2 * i + 1) as f64 / count as f64, 2.399_963 * i as f64);
            DVec3::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z)
        })
    }

    /// A front is within a sixth of a voxel of the exact one, ends within a quarter of a voxel, and keeps the light. Voxel means alone
    /// take more than a voxel to end.
    #[test]
    fn fronts_are_thinner_than_voxels() {
        let (fractions, light) = solution(1e-9);
        let sum = |values: &[f32]| values.iter().map(|value| f64::from(*value)).sum::<f64>();
        let shaded = Fronts::new(&lattice(), fractions).shaded(light.clone());
        let total = sum(&shaded.voxel_means().values()) / sum(&light);
        assert!((total - 1.0).abs() < 0.01, "{total}");
        let spline = Grid::from_lattice(lattice(), smoothed([EDGE; 3], light));
        // Where light has fallen to a part of that one voxel before the front.
        let falls_to = |grid: &Grid, direction: DVec3, part: f64| {
            let at = |i: i32| grid.at((RADIUS + 0.01 * f64::from(i)) * direction);
            let most = at(-100);
            0.01 * f64::from((-100..400).find(|i| at(*i) < part * most).unwrap_or(400))
        };
        let mut mean_width = [0.0; 2];
        for direction in directions(200) {
            let place = falls_to(&shaded, direction, 0.5);
            assert!(place.abs() < 0.17, "{direction}: {place}");
            for (mean, grid) in mean_width.iter_mut().zip([&shaded, &spline]) {
                *mean += (falls_to(grid, direction, 0.1) - falls_to(grid, direction, 0.8)) / 200.0;
            }
        }
        assert!(mean_width[0] < 0.25 && mean_width[1] > 1.0, "{mean_width:?}");
    }

    /// Pictures from 45 sides show no structure of the voxels on the front.
    #[test]
    fn fronts_have_no_stripes() {
        let (fractions, light) = solution(1e-9);
        let shaded = Fronts::new(&lattice(), fractions).shaded(light.clone());
        let cubes = Grid::from_lattice(lattice(), light);
        let worst = |grid: &Grid| directions(45).map(|direction| stripes(grid, direction)).fold(0.0, f64::max);
        let (found, of_cubes) = (worst(&shaded), worst(&cubes));
        assert!(found < 5e-3 && of_cubes > 8e-3, "{found} {of_cubes}");
    }

    /// Root mean square structure of up to four voxels in a picture of the sphere's face, relative to the exact picture.
    fn stripes(grid: &Grid, direction: DVec3) -> f64 {
        const PIXELS: usize = 48;
        const PIXEL: f64 = 0.4;
        let (across, up) = direction.any_orthonormal_pair();
        let pixel = |i: usize| {
            let at = |i: usize| PIXEL * (i as f64 + 0.5 - 0.5 * PIXELS as f64);
            let middle = at(i % PIXELS) * across + at(i / PIXELS) * up;
            let half = (RADIUS * RADIUS - middle.length_squared()).sqrt();
            let truth = |t: f64| emission(middle + t * direction);
            let exact = 2.0 * spectra::quadrature::integrate(truth, 0.0, half, 1e-9);
            let steps = 10 * EDGE;
            let step = 2.0 * (half + 2.0) / steps as f64;
            let light: f64 = (0..steps).map(|i| grid.at(middle + (step * (i as f64 + 0.5) - half - 2.0) * direction)).sum();
            step * light / exact
        };
        let picture: Vec<f64> = (0..PIXELS * PIXELS).into_par_iter().map(pixel).collect();
        // The smooth part: means over squares of four voxels.
        const AROUND: usize = 5;
        let inner = AROUND..PIXELS - AROUND;
        let of_pixel = |(x, y): (usize, usize)| {
            let square = (y - AROUND..=y + AROUND).flat_map(|y| picture[y * PIXELS + x - AROUND..=y * PIXELS + x + AROUND].iter());
            picture[y * PIXELS + x] - square.sum::<f64>() / (2 * AROUND + 1).pow(2) as f64
        };
        let all: Vec<f64> = inner.clone().flat_map(|y| inner.clone().map(move |x| (x, y))).map(of_pixel).collect();
        (all.iter().map(|v| v * v).sum::<f64>() / all.len() as f64).sqrt()
    }

    /// Gas that is partly ionised over many voxels has no front: its light is the smoothed one.
    #[test]
    fn partly_ionised_gas_is_left_alone() {
        let (fractions, light) = solution(16.0);
        let spline = Grid::from_lattice(lattice(), smoothed([EDGE; 3], light.clone()));
        let shaded = Fronts::new(&lattice(), fractions).shaded(light);
        for direction in directions(50) {
            for distance in [6.0, 12.0, 15.0, 18.3, 21.0] {
                let (found, wanted) = (shaded.at(distance * direction), spline.at(distance * direction));
                assert!((found / wanted - 1.0).abs() < 0.05, "{direction} {distance}: {found} {wanted}");
            }
        }
    }
}
