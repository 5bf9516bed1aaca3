//! Kernels: where the light of a point goes.

use glam::Vec2;
use rayon::prelude::*;
use wide::f32x8;

use crate::image::Band;
use crate::image::optics::{EYE_CORE_DEG, EYE_DEG, Pattern};

/// Wavelengths of a band; each has a place of its own in the pixel.
const WAVELENGTHS: usize = 16;
/// Up to this distance from the middle, this number of points along both edges of a pixel is sampled per wavelength.
const CORE: i32 = 6;
const CORE_PLACES: usize = 6;
/// Where the core of a pattern, λ/D, is less than this part of a pixel, the light within the pixel of a point is what the others leave.
const UNRESOLVED: f64 = 0.5;

/// The light of a point around its pixel, up to `reach` pixels away along both axes; all together one.
pub struct Kernel {
    /// Radius \[pixels\].
    pub reach: usize,
    /// Its values, row by row: (2 reach + 1)².
    pub values: Vec<f64>,
}

impl Kernel {
    /// A profile by the square of the distance \[pixel²\].
    pub fn round(reach: usize, profile: impl Fn(f64) -> f64 + Sync) -> Self {
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

    /// The bytes that it takes.
    pub(crate) fn bytes(&self) -> u64 {
        size_of_val(&self.values[..]) as u64
    }

    /// Bilinear value at an offset from the middle, in pixels to the right and upwards; zero beyond the reach.
    pub fn between(&self, right: f64, up: f64) -> f64 {
        let (reach, edge) = (self.reach as f64, 2 * self.reach + 1);
        let (x, y) = (reach + right, reach - up);
        if !(0.0..2.0 * reach).contains(&x) || !(0.0..2.0 * reach).contains(&y) {
            return 0.0;
        }
        let (column, row) = (x as usize, y as usize);
        let (u, v) = (x - column as f64, y - row as f64);
        let at = row * edge + column;
        let [a, b, c, d] = [at, at + 1, at + edge, at + edge + 1].map(|at| self.values[at]);
        (1.0 - v) * ((1.0 - u) * a + u * b) + v * ((1.0 - u) * c + u * d)
    }

    /// Takes the light away that would end with an edge: all beyond the reach in any direction, none within half of it.
    pub fn fade(&mut self) {
        let (reach, edge) = (self.reach as f64, 2 * self.reach + 1);
        self.values.par_chunks_mut(edge).enumerate().for_each(|(row, values)| {
            for (column, value) in values.iter_mut().enumerate() {
                let left = (2.0 - 2.0 * (column as f64 - reach).hypot(row as f64 - reach) / reach).clamp(0.0, 1.0);
                *value *= left * left * (3.0 - 2.0 * left);
            }
        });
        self.normalise();
    }

    /// Makes all of it together one.
    pub fn normalise(&mut self) {
        // Rows have sums of their own, so that the order is the same on any number of threads.
        let rows: Vec<f64> = self.values.par_chunks(2 * self.reach + 1).map(|row| row.iter().sum()).collect();
        let sum: f64 = rows.into_iter().sum();
        self.values.par_iter_mut().for_each(|v| *v /= sum);
    }

    /// A pattern of optics that are turned by an angle \[rad\], in a band, of a given number of pixels in λ/D at 550 nm.
    pub fn of_optics(pattern: &Pattern, rotation: f64, band: &Band, reach: usize, size: f64) -> Self {
        let (pivot, width) = (band.pivot_um.unwrap_or(0.55), band.width_um.unwrap_or(0.0));
        let wavelength = |i: usize| pivot + width.min(pivot) * ((i as f64 + 0.5) / WAVELENGTHS as f64 - 0.5);
        // The part of the light that goes to a pixel for a pattern of one there, and the width of the core in pixels.
        let (share, core) = match pattern {
            Pattern::Pupil(pupil) => (1.0 / (size * size * pupil.area()), size * pivot / 0.55),
            Pattern::Scatter(_) => ((EYE_DEG / size).to_radians().powi(2), size * EYE_CORE_DEG / EYE_DEG),
        };
        let turn = Vec2::from_angle(-rotation as f32);
        // The mean of a pixel, for one wavelength, over places within it.
        let value = |x: f32x8, y: f32, i: usize, places: &[Vec2]| {
            let relative = (wavelength(i) / 0.55) as f32;
            let scale = 1.0 / (size as f32 * relative);
            let sum = places.iter().fold(f32x8::ZERO, |sum, place| {
                // Rows run downwards.
                let (right, up) = (x + place.x, -(y + place.y));
                let u = [(right * turn.x - turn.y * up) * scale, (right * turn.y + turn.x * up) * scale];
                sum + match pattern {
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
        let points: [Vec2; WAVELENGTHS] = std::array::from_fn(|i| Vec2::new(radical_inverse(i, 2), radical_inverse(i, 3)) - 0.5);
        let edge = 2 * reach + 1;
        let mut values = vec![0.0; edge * edge];
        let (upper, _) = values.split_at_mut((reach + 1) * edge);
        upper.par_chunks_mut(edge).enumerate().for_each(|(row, out)| {
            let y = row as i32 - reach as i32;
            for (chunk, out) in out.chunks_mut(8).enumerate() {
                let first = (8 * chunk) as i32 - reach as i32;
                let x = f32x8::from(std::array::from_fn(|lane| (first + lane as i32) as f32));
                let in_core = y.abs() <= CORE && first <= CORE && first + 7 >= -CORE;
                let sum =
                    (0..WAVELENGTHS).fold(f32x8::ZERO, |sum, i| sum + value(x, y as f32, i, if in_core { &fine } else { &points[i..=i] }));
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
        let mut kernel = Self { reach, values };
        kernel.normalise();
        kernel
    }
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
