//! Light of bright points in pictures of all around, spread by angles on the sphere.
//!
//! A flat convolution stretches what it spreads as the picture does, and ends at its edges. Points that are brighter than what is
//! around them are therefore taken out of the picture (a white top-hat transform; Serra 1982, ch. XII), and their light is put back
//! by the kernel in the tangent plane of each: at an angle θ from a point, θ / pixel pixels from the kernel's middle. What remains is
//! smooth, and a flat convolution serves it.

use glam::DVec3;
use rayon::prelude::*;

use super::Kernel;
use crate::camera::panorama::{Axes, PanoramaLayout};
use crate::camera::{Camera, Projection};
use crate::image::{Image, PixelScale};

/// Ahead, right and up of every picture: turns of all around change nothing.
const VIEW: Axes = [DVec3::NEG_Z, DVec3::X, DVec3::Y];
/// Half of the width of the largest point \[pixels\].
const POINT: usize = 3;
/// Points whose light is seen no farther away stay in the picture \[pixels\].
const NEAR: usize = 4;
/// The light that is seen, relative to the picture's white.
const SEEN: f64 = 1e-4;
/// The light that is looked for at least, relative to the brightest point: a picture of few stars has a white of nearly zero.
const FAINTEST: f64 = 1e-9;
/// Pixels that are lit, all points together, for each pixel of the picture at most: of more points the faintest light is left out.
const LIT: f64 = 16.0;
/// Edge of the tiles in which points are looked for \[pixels\].
const TILE: usize = 32;

/// The directions of the pixels of a picture of all around.
pub(crate) struct Sphere {
    layout: PanoramaLayout,
    width: usize,
    height: usize,
    /// The place of direction zero \[pixels\].
    middle: (f64, f64),
    /// The unit of a layout's places in a pixel.
    unit: f64,
}

/// A bright point.
pub(crate) struct Point {
    direction: DVec3,
    /// To the right and upwards in the picture, each of length one.
    right: DVec3,
    up: DVec3,
    /// Radius of visible light \[pixels\].
    radius: f64,
    /// Its light in each band, times the solid angle of its pixel relative to one in the middle.
    light: Vec<f64>,
}

/// A kernel by the distance from its middle.
struct KernelProfile {
    /// Largest value at a distance of the index or more, in pixels.
    largest: Vec<f64>,
    /// Light within a distance of the index, in pixels, integrated on the sphere.
    within: Vec<f64>,
}

impl KernelProfile {
    fn new(kernel: &Kernel, unit: f64) -> Self {
        let edge = 2 * kernel.reach + 1;
        let (mut largest, mut within) = (vec![0.0f64; kernel.reach + 2], vec![0.0f64; kernel.reach + 2]);
        for (row, values) in kernel.values.chunks(edge).enumerate() {
            for (column, value) in values.iter().enumerate() {
                let distance = (row as f64 - kernel.reach as f64).hypot(column as f64 - kernel.reach as f64);
                let ring = (distance.ceil() as usize).min(kernel.reach + 1);
                largest[ring] = largest[ring].max(*value);
                let angle = (distance * unit).min(std::f64::consts::PI);
                within[ring] += value * if angle > 0.0 { angle.sin() / angle } else { 1.0 };
            }
        }
        (0..=kernel.reach).rev().for_each(|ring| largest[ring] = largest[ring].max(largest[ring + 1]));
        (1..within.len()).for_each(|ring| within[ring] += within[ring - 1]);
        Self { largest, within }
    }

    /// Radius within which light of a given strength exceeds a level \[pixels\].
    fn radius(&self, light: f64, level: f64) -> usize {
        self.largest.partition_point(|value| light * value > level)
    }
}

impl Sphere {
    /// Geometry of one eye of an all-sky picture; none for flat pictures.
    pub fn of(image: &Image) -> Option<Self> {
        let (layout, degrees) = match image.pixel? {
            PixelScale::Equidistant(degrees) => {
                let half_aperture = image.circle? * degrees.to_radians();
                (PanoramaLayout::Dome { half_aperture, tilt: std::f64::consts::FRAC_PI_2 }, degrees)
            }
            PixelScale::PlateCarree(degrees) => (PanoramaLayout::Sphere, degrees),
            PixelScale::OnCube(degrees) => (PanoramaLayout::Cube, degrees),
            PixelScale::Angle(_) | PixelScale::Length(_) => return None,
        };
        let (width, height) = (image.width / image.views.0.max(1), image.height);
        let middle = (0.5 * width as f64 + image.axis.0, 0.5 * height as f64 - image.axis.1);
        Some(Self { layout, width, height, middle, unit: degrees.to_radians() })
    }

    /// Camera at the origin that sees the picture.
    pub fn camera(&self) -> Camera {
        let half = 0.5 * self.width as f64;
        let offset = ((half - self.middle.0) / half, (self.middle.1 - 0.5 * self.height as f64) / half);
        let projection = Projection::Panorama { layout: self.layout, half_width: self.unit * half };
        Camera { projection, offset, ..Camera::look_at(DVec3::ZERO, VIEW[0]) }.with_size(self.width, self.height)
    }

    /// Bytes that taking points out of a picture needs beside it: their light, and two planes.
    pub fn bytes(width: usize, height: usize, bands: usize) -> u64 {
        (width as u64).saturating_mul(height as u64).saturating_mul(8 * (bands as u64 + 2))
    }

    fn place(&self, x: usize, y: usize) -> (f64, f64) {
        ((x as f64 + 0.5 - self.middle.0) * self.unit, (self.middle.1 - y as f64 - 0.5) * self.unit)
    }

    /// The direction of a pixel; none beside a dome's circle.
    fn direction(&self, x: usize, y: usize) -> Option<DVec3> {
        let place = self.place(x, y);
        self.layout.sees(place).then(|| self.layout.direction(place, &VIEW))
    }

    /// Takes the bright points out of the planes of one eye, whose white is known; a plane is a band's pixels, row by row.
    pub fn take(&self, planes: &mut [Vec<f64>], kernels: &[impl AsRef<Kernel>], white: f64) -> Vec<Point> {
        let profiles: Vec<KernelProfile> = kernels.iter().map(|kernel| KernelProfile::new(kernel.as_ref(), self.unit)).collect();
        let peaks: Vec<Vec<f64>> = planes.iter().map(|plane| self.peaks(plane)).collect();
        let brightest = peaks.iter().flatten().copied().fold(0.0, f64::max);
        let mut level = (SEEN * white).max(FAINTEST * brightest);
        // Pixels that stand out, and their solid angles relative to one in the middle.
        let candidate = |i: usize| {
            let place = self.place(i % self.width, i / self.width);
            let is_seen = peaks.iter().any(|plane| plane[i] > level) && self.layout.sees(place);
            is_seen.then(|| (i, self.layout.measure(place)))
        };
        let candidates: Vec<(usize, f64)> = (0..self.width * self.height).into_par_iter().filter_map(candidate).collect();
        let chosen = loop {
            let reaching = |(i, measure): &(usize, f64)| {
                let radius = profiles.iter().zip(&peaks).map(|(profile, plane)| profile.radius(plane[*i] * measure, level)).max()?;
                (radius > NEAR).then_some((*i, *measure, radius))
            };
            let chosen: Vec<(usize, f64, usize)> = candidates.par_iter().filter_map(reaching).collect();
            let lit: f64 = chosen.iter().map(|(_, _, radius)| std::f64::consts::PI * (*radius as f64).powi(2)).sum();
            if lit <= LIT * (self.width * self.height) as f64 {
                break chosen;
            }
            level *= 2.0;
        };
        let point = |(i, measure, radius): (usize, f64, usize)| {
            let (x, y) = (i % self.width, i / self.width);
            let (s, t) = self.place(x, y);
            let along = |ds: f64, dt: f64| {
                let step = 0.25 * self.unit;
                let at = |sign: f64| self.layout.direction((s + sign * step * ds, t + sign * step * dt), &VIEW);
                (at(1.0) - at(-1.0)).normalize()
            };
            let right = along(1.0, 0.0);
            let up = along(0.0, 1.0);
            let light =
                |(plane, profile): (&Vec<f64>, &KernelProfile)| plane[i] * measure / profile.within[radius.min(profile.within.len() - 1)];
            Point {
                direction: self.layout.direction((s, t), &VIEW),
                right,
                up: (up - right * up.dot(right)).normalize(),
                radius: radius as f64,
                light: peaks.iter().zip(&profiles).map(light).collect(),
            }
        };
        for (plane, peaks) in planes.iter_mut().zip(&peaks) {
            chosen.iter().for_each(|(i, ..)| plane[*i] -= peaks[*i]);
        }
        chosen.into_iter().map(point).collect()
    }

    /// White top-hat of a plane: its light above an opening by a window as large as a point, stretched as the picture is there.
    fn peaks(&self, plane: &[f64]) -> Vec<f64> {
        // Light of one face of a cube does not stand beside that of the next.
        let block = if self.layout == PanoramaLayout::Cube { self.width } else { self.height };
        let along_rows = |plane: &[f64], better: fn(f64, f64) -> f64| {
            let mut out = vec![0.0; plane.len()];
            out.par_chunks_mut(self.width).zip(plane.par_chunks(self.width)).enumerate().for_each(|(y, (out, row))| {
                let stretch = match self.layout {
                    PanoramaLayout::Sphere => self.layout.measure((0.0, self.place(0, y).1)).max(1.0 / self.width as f64),
                    PanoramaLayout::Dome { .. } => 0.5,
                    PanoramaLayout::Cube => 1.0,
                };
                let half = ((POINT as f64 / stretch).ceil() as usize).min(self.width);
                for (x, out) in out.iter_mut().enumerate() {
                    *out = row[x.saturating_sub(half)..(x + half + 1).min(self.width)].iter().copied().fold(row[x], better);
                }
            });
            out
        };
        let along_columns = |plane: &[f64], better: fn(f64, f64) -> f64| {
            let mut out = vec![0.0; plane.len()];
            out.par_chunks_mut(self.width).enumerate().for_each(|(y, out)| {
                let first = y / block * block;
                let half = if matches!(self.layout, PanoramaLayout::Dome { .. }) { 2 * POINT } else { POINT };
                let rows = y.saturating_sub(half).max(first)..(y + half + 1).min(first + block).min(self.height);
                for (x, out) in out.iter_mut().enumerate() {
                    *out = rows.clone().map(|row| plane[row * self.width + x]).fold(plane[y * self.width + x], better);
                }
            });
            out
        };
        let least = along_columns(&along_rows(plane, f64::min), f64::min);
        let ground = along_columns(&along_rows(&least, f64::max), f64::max);
        plane.iter().zip(ground).map(|(value, ground)| value - ground).collect()
    }

    /// Adds the light of points to the planes out of which they were taken.
    pub fn put(&self, points: &[Point], planes: &mut [Vec<f64>], kernels: &[impl AsRef<Kernel> + Sync]) {
        let rows = self.height.div_ceil(TILE);
        let lit: Vec<Vec<Vec<f64>>> = (0..rows)
            .into_par_iter()
            .map(|row| {
                let height = TILE.min(self.height - row * TILE);
                let mut out = vec![vec![0.0; height * self.width]; planes.len()];
                for first in (0..self.width).step_by(TILE) {
                    self.light_tile(points, kernels, (first, row * TILE), &mut out);
                }
                out
            })
            .collect();
        for (row, lit) in lit.into_iter().enumerate() {
            for (plane, lit) in planes.iter_mut().zip(lit) {
                plane[row * TILE * self.width..].iter_mut().zip(lit).for_each(|(value, lit)| *value += lit);
            }
        }
    }

    /// Adds the light of points to a tile; `out` has the tile's rows, band by band.
    fn light_tile(&self, points: &[Point], kernels: &[impl AsRef<Kernel>], (left, top): (usize, usize), out: &mut [Vec<f64>]) {
        let (right, bottom) = ((left + TILE).min(self.width), (top + TILE).min(self.height));
        let pixels: Vec<(usize, DVec3)> = (top..bottom)
            .flat_map(|y| (left..right).map(move |x| (x, y)))
            .filter_map(|(x, y)| Some(((y - top) * self.width + x, self.direction(x, y)?)))
            .collect();
        let Some(centre) = pixels.iter().map(|(_, direction)| *direction).sum::<DVec3>().try_normalize() else { return };
        let half = pixels.iter().map(|(_, direction)| centre.distance(*direction)).fold(0.0, f64::max);
        for point in points {
            let radius = point.radius * self.unit;
            // Chords: that of an angle is at most the angle.
            let chord = 2.0 * (0.5 * radius.min(std::f64::consts::PI)).sin();
            if centre.distance(point.direction) > half + chord {
                continue;
            }
            for (at, direction) in &pixels {
                let apart = direction.distance(point.direction);
                if apart > chord {
                    continue;
                }
                let (along, up) = (direction.dot(point.right), direction.dot(point.up));
                let pixels = 2.0 * (0.5 * apart).min(1.0).asin() / self.unit;
                let scale = pixels / along.hypot(up).max(f64::MIN_POSITIVE);
                for ((out, kernel), light) in out.iter_mut().zip(kernels).zip(&point.light) {
                    out[*at] += light * kernel.as_ref().between(along * scale, up * scale);
                }
            }
        }
    }
}
