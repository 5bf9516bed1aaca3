//! Glare: what optics make of the bright points of a picture: spikes, rings, halo and seeing. It changes pictures, never radiances.
//!
//! Each band is convolved in linear light with
//!
//!   K = ((1 − h) P + h H) ∗ M,   H ∝ 1/(r² + s²),   M ∝ (1 + r²/a²)^−β,
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | P: pattern of the optics (`optics`), a mean over the band's wavelengths and the pixel | `optics` | |
//! | s: λ/D at 550 nm | `size` | thousandths of the picture's longer edge |
//! | h: the part that is scattered in the halo (King 1971, PASP 83, 199) | `halo` | |
//! | full width of M at half of its height; β = 4.765 (Trujillo et al. 2001, MNRAS 328, 977) | `seeing` | thousandths |
//!
//! K ends half of the longer edge away and keeps all light, but for what leaves the picture. What would come in from beyond the edge
//! is taken to be like what is within: the convolution is divided by that of an even picture.

use glam::Vec2;
use rayon::prelude::*;
use wide::f32x8;

use super::optics::{EYE_CORE_DEG, EYE_DEG, OPTICS, OpticsRow, Pattern};
use super::{Band, Image, Samples};
use crate::error::{Error, Result};
use crate::fourier::{Complex, transform};

/// What optics make of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glare {
    /// The telescope or the eye.
    pub optics: &'static OpticsRow,
    /// λ/D at 550 nm, in thousandths of the picture's longer edge.
    pub size: f64,
    /// How far the optics are turned, counterclockwise \[rad\].
    pub rotation: f64,
    /// The full width at half maximum of what the air does, in thousandths of the longer edge; 0 in space.
    pub seeing: f64,
    /// The part of the light that is scattered in a halo.
    pub halo: f64,
}

/// Ranges of the numbers.
pub(crate) const SIZES: std::ops::RangeInclusive<f64> = 0.01..=20.0;
pub(crate) const SEEINGS: std::ops::RangeInclusive<f64> = 0.0..=50.0;
pub(crate) const HALOS: std::ops::RangeInclusive<f64> = 0.0..=1.0;

impl Default for Glare {
    fn default() -> Self {
        Self { optics: &OPTICS[0], size: 0.5, rotation: 0.0, seeing: 0.0, halo: 0.02 }
    }
}

/// The farthest that light is spread \[pixels\].
const MAX_REACH: usize = 2048;
/// Wavelengths of a band; each has a place of its own in the pixel.
const WAVELENGTHS: usize = 16;
/// Up to so far from the middle, so many places along both edges of a pixel are looked at for each wavelength.
const CORE: i32 = 6;
const CORE_PLACES: usize = 6;
/// Where the core of a pattern, λ/D, is less than this part of a pixel, the light within the pixel of a point is what the others leave.
const UNRESOLVED: f64 = 0.5;
/// Air that spreads light less is still \[pixels\].
const STILL_AIR: f64 = 1e-3;
/// The exponent of Moffat's profile.
const BETA: f64 = 4.765;

impl Glare {
    /// Refuses what no optics do.
    ///
    /// # Errors
    /// Where a number is out of its range.
    pub fn check(&self) -> Result<()> {
        for (what, value, range) in
            [("size of a glare", self.size, SIZES), ("seeing of a glare", self.seeing, SEEINGS), ("halo of a glare", self.halo, HALOS)]
        {
            if !range.contains(&value) {
                return Err(Error::value(what, value, format!("{} to {}", range.start(), range.end())));
            }
        }
        if self.rotation.is_finite() { Ok(()) } else { Err(Error::value("rotation of a glare", self.rotation, "an angle")) }
    }

    /// Bytes that a glare takes beside an image of so many bands, at most: all bands in double precision, three transforms of a
    /// picture or of a kernel that air has spread, and two kernels.
    pub(crate) fn bytes(width: usize, height: usize, bands: usize) -> u64 {
        let reach = reach(width.max(height)) as u64;
        let (width, height) = (width as u64, height as u64);
        let values = (width + reach).saturating_mul(height + reach).max((3 * reach + 1).pow(2));
        let transforms = values.saturating_mul(3 * size_of::<Complex<f64>>() as u64);
        let kernels = 2 * (2 * reach + 1).pow(2) * size_of::<f64>() as u64;
        transforms.saturating_add(kernels).saturating_add(width.saturating_mul(height).saturating_mul(8 * bands as u64))
    }

    /// The image as these optics show it; its standard errors stay what they are.
    pub fn seen(&self, image: &Image) -> Image {
        let (columns, rows) = image.views;
        let (width, height) = (image.width / columns.max(1), image.height / rows.max(1));
        let mut samples: Vec<f64> = (0..image.samples.len()).map(|i| image.samples.at(i)).collect();
        if width > 0 && height > 0 {
            for band in image.radiances() {
                let spread = Spread::new(&self.kernel(&image.bands[band], width.max(height)), width, height);
                for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
                    let first = (band * image.height + row * height) * image.width + column * width;
                    spread.apply(&mut samples[first..], image.width);
                }
            }
        }
        Image {
            samples: Samples::Double(samples),
            layers: Vec::new(),
            bands: image.bands.clone(),
            notes: image.notes.clone(),
            keywords: image.keywords.clone(),
            display: image.display.clone(),
            ..*image
        }
    }

    /// Where the light of a point goes in a picture whose longer edge is so long.
    fn kernel(&self, band: &Band, longer: usize) -> Kernel {
        let pixels = longer as f64 / 1000.0;
        let reach = reach(longer);
        let size = self.size * pixels;
        let mut kernel = self.diffracted(band, reach, size);
        if self.halo > 0.0 {
            let halo = Kernel::round(reach, |square| 1.0 / (square + size.max(1.0).powi(2)));
            kernel.values.iter_mut().zip(halo.values).for_each(|(own, halo)| *own += self.halo * (halo - *own));
        }
        let width = 0.5 * self.seeing * pixels / (2f64.powf(1.0 / BETA) - 1.0).sqrt();
        if width > STILL_AIR {
            let moffat = Kernel::round(reach, |square| (1.0 + square / width.powi(2)).powf(-BETA));
            let edge = 2 * reach + 1;
            // Its own even picture is all of it: nothing comes in from beyond its edges.
            Spread::new(&moffat, edge, edge).within(&mut kernel.values);
            kernel.normalise();
        }
        kernel
    }

    /// The pattern of the optics in a band, of so many pixels in λ/D at 550 nm.
    fn diffracted(&self, band: &Band, reach: usize, size: f64) -> Kernel {
        let (pivot, width) = (band.pivot_um.unwrap_or(0.55), band.width_um.unwrap_or(0.0));
        let wavelength = |i: usize| pivot + width.min(pivot) * ((i as f64 + 0.5) / WAVELENGTHS as f64 - 0.5);
        let pattern = (self.optics.pattern)();
        // The part of the light that goes to a pixel for a pattern of one there, and the width of the core in pixels.
        let (share, core) = match &pattern {
            Pattern::Pupil(pupil) => (1.0 / (size * size * pupil.area()), size * pivot / 0.55),
            Pattern::Scatter(_) => ((EYE_DEG / size).to_radians().powi(2), size * EYE_CORE_DEG / EYE_DEG),
        };
        let turn = Vec2::from_angle(-self.rotation as f32);
        // The mean of a pixel, for one wavelength, over places within it.
        let value = |x: f32x8, y: f32, i: usize, places: &[Vec2]| {
            let relative = (wavelength(i) / 0.55) as f32;
            let scale = 1.0 / (size as f32 * relative);
            let sum = places.iter().fold(f32x8::ZERO, |sum, place| {
                // Rows run downwards.
                let (right, up) = (x + place.x, -(y + place.y));
                let u = [(right * turn.x - turn.y * up) * scale, (right * turn.y + turn.x * up) * scale];
                sum + match &pattern {
                    Pattern::Pupil(pupil) => pupil.pattern(u) * (1.0 / (relative * relative)),
                    Pattern::Scatter(light) => {
                        let radius = (right * right + up * up).sqrt() / size as f32;
                        f32x8::from(radius.to_array().map(|r| light(f64::from(r) * EYE_DEG) as f32))
                    }
                }
            });
            sum * (1.0 / places.len() as f32)
        };
        let fine: Vec<Vec2> = (0..CORE_PLACES.pow(2))
            .map(|i| (Vec2::new((i % CORE_PLACES) as f32, (i / CORE_PLACES) as f32) + 0.5) / CORE_PLACES as f32 - 0.5)
            .collect();
        let edge = 2 * reach + 1;
        let mut values = vec![0.0; edge * edge];
        let (upper, _) = values.split_at_mut((reach + 1) * edge);
        upper.par_chunks_mut(edge).enumerate().for_each(|(row, out)| {
            let y = row as i32 - reach as i32;
            for (chunk, out) in out.chunks_mut(8).enumerate() {
                let first = (8 * chunk) as i32 - reach as i32;
                let x = f32x8::from(std::array::from_fn(|lane| (first + lane as i32) as f32));
                let in_core = y.abs() <= CORE && first <= CORE && first + 7 >= -CORE;
                let sum = (0..WAVELENGTHS).fold(f32x8::ZERO, |sum, i| {
                    let own = [Vec2::new(radical_inverse(i, 2), radical_inverse(i, 3)) - 0.5];
                    sum + value(x, y as f32, i, if in_core { &fine } else { &own })
                });
                out.iter_mut().zip(sum.to_array()).for_each(|(out, value)| *out = share * f64::from(value) / WAVELENGTHS as f64);
            }
        });
        // The squared transform of what is real is the same on the other side of the middle.
        for i in 0..reach * edge + reach {
            values[edge * edge - 1 - i] = values[i];
        }
        if core < UNRESOLVED {
            let middle = reach * edge + reach;
            values[middle] = 0.0;
            values[middle] = (1.0 - values.iter().sum::<f64>()).max(0.0);
        }
        let mut kernel = Kernel { reach, values };
        kernel.normalise();
        kernel
    }
}

/// How far light is spread in a picture whose longer edge is so long \[pixels\].
fn reach(longer: usize) -> usize {
    (longer / 2).clamp(1, MAX_REACH)
}

/// Halton's numbers, from 0 to 1.
fn radical_inverse(index: usize, base: usize) -> f32 {
    let (mut rest, mut scale, mut sum) = (index + 1, 1.0, 0.0);
    while rest > 0 {
        scale /= base as f32;
        sum += scale * (rest % base) as f32;
        rest /= base;
    }
    sum
}

/// The light of a point around its pixel, up to `reach` pixels away along both axes; all together one.
struct Kernel {
    reach: usize,
    values: Vec<f64>,
}

impl Kernel {
    /// A profile by the square of the distance \[pixel²\].
    fn round(reach: usize, profile: impl Fn(f64) -> f64 + Sync) -> Self {
        let edge = 2 * reach + 1;
        let mut values = vec![0.0; edge * edge];
        values.par_chunks_mut(edge).enumerate().for_each(|(row, out)| {
            let y = row as f64 - reach as f64;
            for (column, out) in out.iter_mut().enumerate() {
                let x = column as f64 - reach as f64;
                let places = if x.abs().max(y.abs()) <= f64::from(CORE) { CORE_PLACES } else { 1 };
                let place = |i: usize| (i as f64 + 0.5) / places as f64 - 0.5;
                let all = (0..places).flat_map(|i| (0..places).map(move |j| (i, j)));
                *out = all.map(|(i, j)| profile((x + place(i)).powi(2) + (y + place(j)).powi(2))).sum::<f64>() / (places * places) as f64;
            }
        });
        let mut kernel = Self { reach, values };
        kernel.normalise();
        kernel
    }

    fn normalise(&mut self) {
        let sum: f64 = self.values.iter().sum();
        self.values.iter_mut().for_each(|v| *v /= sum);
    }
}

/// The convolution of pictures of one size with a kernel.
struct Spread {
    width: usize,
    height: usize,
    dims: [usize; 3],
    /// The kernel's transform, over the number of values.
    factors: Vec<Complex<f64>>,
}

impl Spread {
    fn new(kernel: &Kernel, width: usize, height: usize) -> Self {
        let reach = kernel.reach;
        let dims = [smooth(width + reach), smooth(height + reach), 1];
        let (mut factors, count) = (vec![Complex::default(); dims[0] * dims[1]], (dims[0] * dims[1]) as f64);
        let edge = 2 * reach + 1;
        for (i, value) in kernel.values.iter().enumerate() {
            // The middle of the kernel is the first value; what is left of it or above comes from the other end.
            let wrapped = |at: usize, count: usize| (at + count - reach % count) % count;
            factors[wrapped(i / edge, dims[1]) * dims[0] + wrapped(i % edge, dims[0])] += value / count;
        }
        transform(&mut factors, dims, true);
        Self { width, height, dims, factors }
    }

    /// Spreads the light of a picture whose rows are so far apart.
    fn apply(&self, values: &mut [f64], stride: usize) {
        let pixels = || (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        let level = pixels().map(|(x, y)| values[y * stride + x].abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        // The even picture is the imaginary part, which a real kernel keeps apart.
        let spread = self.convolved(|x, y| Complex::new(values[y * stride + x] / level, 1.0));
        for (x, y) in pixels() {
            let value = spread[y * self.dims[0] + x];
            values[y * stride + x] = level * value.re / value.im;
        }
    }

    /// Spreads the light of a picture beyond whose edges there is none.
    fn within(&self, values: &mut [f64]) {
        let spread = self.convolved(|x, y| Complex::new(values[y * self.width + x], 0.0));
        values.iter_mut().enumerate().for_each(|(i, v)| *v = spread[i / self.width * self.dims[0] + i % self.width].re);
    }

    fn convolved(&self, value: impl Fn(usize, usize) -> Complex<f64>) -> Vec<Complex<f64>> {
        let mut data = vec![Complex::default(); self.factors.len()];
        for (y, row) in data.chunks_mut(self.dims[0]).take(self.height).enumerate() {
            row.iter_mut().take(self.width).enumerate().for_each(|(x, v)| *v = value(x, y));
        }
        transform(&mut data, self.dims, true);
        data.par_iter_mut().zip(&self.factors).for_each(|(v, factor)| *v *= factor);
        transform(&mut data, self.dims, false);
        data
    }
}

/// The next number that twos, threes and fives make, of which transforms are fast.
fn smooth(at_least: usize) -> usize {
    let is_smooth = |number: &usize| {
        let rest = [2, 3, 5].into_iter().fold(*number, |mut rest, prime| {
            while rest % prime == 0 {
                rest /= prime;
            }
            rest
        });
        rest == 1
    };
    (at_least.max(1)..).find(is_smooth).unwrap_or(at_least)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture with points, given by column, row and light.
    fn points(width: usize, height: usize, at: &[(usize, usize, f64)]) -> Image {
        let mut values = vec![0.0; width * height];
        at.iter().for_each(|(x, y, light)| values[y * width + x] = *light);
        let mut image = Image::bare(width, height, vec!["V".into()], Samples::Double(values));
        (image.bands[0].pivot_um, image.bands[0].width_um) = (Some(0.55), Some(1e-4));
        image
    }

    fn of(name: &str) -> Glare {
        Glare { optics: OPTICS.iter().find(|row| row.name == name).unwrap(), halo: 0.0, ..Glare::default() }
    }

    /// A lens has Airy's pattern: dark rings at 1.220 and 2.233 λ/D, 83.8 % of the light within the first (Born & Wolf, 8.5.2).
    #[test]
    fn a_lens_shows_airys_rings() {
        let image = points(1001, 1001, &[(500, 500, 1.0)]);
        // 10 pixels in λ/D.
        let seen = Glare { size: 10.0 / 1.001, ..of("refractor") }.seen(&image);
        let along = |x: usize| seen.at(0, 500, 500 + x);
        let darkest = |from: usize, to: usize| (from..to).min_by(|a, b| along(*a).total_cmp(&along(*b))).unwrap();
        assert_eq!((darkest(8, 16), darkest(18, 26)), (12, 22));
        let within: f64 = (0..1001 * 1001)
            .filter(|i| ((i % 1001) as f64 - 500.0).hypot((i / 1001) as f64 - 500.0) < 12.2)
            .map(|i| seen.at(0, i / 1001, i % 1001))
            .sum();
        // The kernel ends 50 λ/D away, beyond which 0.4 % of the light goes: 2/(π² 50).
        assert!((within - 0.838 * 1.004).abs() < 0.003, "{within}");
    }

    /// Light stays what it is: as much of a point in the middle, an even picture even, at its edges too.
    #[test]
    fn light_is_kept() {
        for row in OPTICS {
            let glare = Glare { seeing: 3.0, halo: 0.1, size: 1.0, rotation: 0.3, ..of(row.name) };
            let even = Image { samples: Samples::Double(vec![2.5; 120 * 80]), ..points(120, 80, &[]) };
            let seen = glare.seen(&even);
            let worst = (0..9600).map(|i| (seen.samples.at(i) / 2.5 - 1.0).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-9, "{}: {worst}", row.name);
            let kernel = glare.kernel(&even.bands[0], 120);
            assert!((kernel.values.iter().sum::<f64>() - 1.0).abs() < 1e-12 && kernel.values.iter().all(|v| *v > -1e-12));
        }
    }

    /// Light that pixels do not tell from that of a point stays in its pixel, and what leaves it is as much as a lens sends out
    /// of a square: beyond r λ/D it is 2/(π² r) of all (Born & Wolf, 8.5.2), so 0.18244 of h⁻¹ beyond half a pixel of h λ/D.
    #[test]
    fn sharp_optics_leave_light_in_its_pixel() {
        let image = points(321, 321, &[(160, 160, 1.0)]);
        for size in [0.01, 0.05, 0.2, 1.2] {
            let seen = Glare { size, ..of("refractor") }.kernel(&image.bands[0], 321);
            let left = 1.0 - seen.values[160 * 321 + 160];
            let wanted = 0.182_44 / (0.5 / (size * 0.321));
            assert!((left / wanted - 1.0).abs() < 0.1, "{size}: {left} {wanted}");
        }
    }

    /// The convolution is the sum of all points, spread one by one: no light wraps around, and pictures side by side have none of
    /// each other's.
    #[test]
    fn points_are_spread_one_by_one() {
        let at = [(3, 2, 1e6), (57, 35, 2.0), (30, 20, 5.0)];
        let (image, glare) = (points(60, 40, &at), of("hubble"));
        let kernel = glare.kernel(&image.bands[0], 60);
        let (reach, edge) = (kernel.reach as i64, 2 * kernel.reach + 1);
        let around = |x: i64, y: i64| {
            let inside = x.abs() <= reach && y.abs() <= reach;
            if inside { kernel.values[(y + reach) as usize * edge + (x + reach) as usize] } else { 0.0 }
        };
        let seen = glare.seen(&image);
        for (x, y) in (0..40i64).flat_map(|y| (0..60i64).map(move |x| (x, y))) {
            let light: f64 = at.iter().map(|(px, py, light)| light * around(x - *px as i64, y - *py as i64)).sum();
            let even: f64 = (0..2400i64).map(|i| around(x - i % 60, y - i / 60)).sum();
            let (own, wanted) = (seen.at(0, y as usize, x as usize), light / even);
            assert!((own - wanted).abs() < 1e-9 * wanted + 1e-9, "{x} {y}: {own} {wanted}");
        }
        let both = Image { views: (2, 1), ..points(120, 40, &at) };
        let parted = glare.seen(&both);
        assert!((0..40).all(|y| (60..120).all(|x| parted.at(0, y, x).abs() < 1e-300)));
        assert!((0..40).all(|y| (0..60).all(|x| (parted.at(0, y, x) - seen.at(0, y, x)).abs() <= 1e-12 * seen.at(0, y, x))));
    }

    /// Spikes turn with the telescope, counterclockwise as one sees the picture, and red ones are longer than blue ones.
    #[test]
    fn spikes_turn_and_grow_with_wavelength() {
        let spoke = |image: &Image, degrees: f64| -> f64 {
            let (sin, cos) = degrees.to_radians().sin_cos();
            (60..180)
                .map(|r| image.at(0, (200.0 - f64::from(r) * sin).round() as usize, (200.0 + f64::from(r) * cos).round() as usize))
                .sum()
        };
        let image = points(401, 401, &[(200, 200, 1.0)]);
        let glare = Glare { size: 5.0, ..of("newtonian") };
        let (straight, turned) = (glare.seen(&image), Glare { rotation: 30f64.to_radians(), ..glare }.seen(&image));
        assert!(spoke(&straight, 0.0) > 5.0 * spoke(&straight, 30.0), "{} {}", spoke(&straight, 0.0), spoke(&straight, 30.0));
        assert!(spoke(&turned, 30.0) > 5.0 * spoke(&turned, 0.0) && spoke(&turned, 30.0) > 5.0 * spoke(&turned, 60.0));
        let spread_at = |pivot: f64| {
            let mut image = image.clone();
            image.bands[0].pivot_um = Some(pivot);
            let seen = Glare { optics: of("refractor").optics, size: 10.0, ..glare }.seen(&image);
            (0..401 * 401).map(|i| seen.samples.at(i) * ((i % 401) as f64 - 200.0).hypot((i / 401) as f64 - 200.0).min(20.0)).sum::<f64>()
        };
        assert!((spread_at(0.8) / spread_at(0.4) - 2.0).abs() < 0.3, "{}", spread_at(0.8) / spread_at(0.4));
    }

    /// What the air does has the width that was asked for.
    #[test]
    fn seeing_has_its_width() {
        let image = points(401, 401, &[(200, 200, 1.0)]);
        let seen = Glare { size: 0.1, seeing: 20.0 / 0.401, ..of("refractor") }.seen(&image);
        let half = 0.5 * seen.at(0, 200, 200);
        assert!(seen.at(0, 200, 209) > half && seen.at(0, 200, 211) < half && seen.at(0, 190, 200) > 0.9 * half);
    }

    #[test]
    fn what_no_optics_do_is_refused() {
        let glare = Glare::default();
        assert!(glare.check().is_ok());
        for wrong in [Glare { size: f64::NAN, ..glare }, Glare { halo: 1.5, ..glare }, Glare { rotation: f64::INFINITY, ..glare }] {
            assert!(wrong.check().is_err(), "{wrong:?}");
        }
    }
}
