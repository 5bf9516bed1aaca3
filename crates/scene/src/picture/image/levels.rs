//! Pixels by which automatic levels are chosen.
//!
//! A star is drawn over the same number of pixels whatever their size: in a small picture it covers more of the nebula, and is fainter.
//! Levels are therefore those of a picture of [`LEVEL_WIDTH`] pixels in a row: stars as they are there, and the light between them.

use std::collections::BTreeMap;

use super::{Image, PixelScale};
use crate::points::disc;

/// Pixels in a row of the picture by which levels are chosen.
const LEVEL_WIDTH: f64 = 1280.0;

/// Pixels by which levels are chosen, pixel × band [W m⁻² sr⁻¹].
pub(super) struct LevelPixels {
    bands: usize,
    /// Light without stars, in the pixels of the image or means of several.
    light: Vec<f64>,
    /// Weight of such a pixel; that of a pixel of a star is one.
    weight: f64,
    /// Light in the pixels of stars.
    stars: Vec<f64>,
}

impl LevelPixels {
    /// Pixels of an image.
    pub fn of(image: &Image) -> Self {
        let (size, bands) = (image.width * image.height, image.bands.len());
        // Pixels of the image along one of the picture by which levels are chosen.
        let edge = image.part.map_or(image.width, |part| part.whole.0) as f64 / LEVEL_WIDTH;
        let mut light: Vec<f64> = vec![0.0; size * bands];
        for (pixel, values) in light.chunks_exact_mut(bands).enumerate() {
            values.iter_mut().enumerate().for_each(|(band, value)| *value = image.samples.at(band * size + pixel));
        }
        let mut stars: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        let [columns, rows] = [image.width, image.height].map(|pixels| (pixels as f64 / edge).ceil() as usize);
        for point in &image.points {
            for (pixel, share) in disc([image.width, image.height], point.column, point.row) {
                let per_watt = share / solid_angle(image, pixel);
                light[pixel * bands..][..bands].iter_mut().zip(&point.flux).for_each(|(light, flux)| *light -= per_watt * flux);
            }
            for (pixel, share) in disc([columns, rows], point.column / edge, point.row / edge) {
                let here = beneath(image, (pixel % columns, pixel / columns), edge);
                let per_watt = share / (edge * edge * solid_angle(image, here));
                let sums = stars.entry(pixel).or_insert_with(|| vec![0.0; bands]);
                sums.iter_mut().zip(&point.flux).for_each(|(sum, flux)| *sum += per_watt * flux);
            }
        }
        for (pixel, values) in &mut stars {
            let here = beneath(image, (pixel % columns, pixel / columns), edge);
            values.iter_mut().zip(&light[here * bands..]).for_each(|(value, light)| *value += light.max(0.0));
        }
        let covered = stars.len() as f64;
        let light = means(light, (image.width, image.height), bands, (edge.round() as usize).max(1));
        // Light counts as often as there are pixels between stars.
        let weight = (size as f64 / (edge * edge) - covered).max(1.0) * bands as f64 / light.len() as f64;
        Self { bands, light, weight, stars: stars.into_values().flatten().collect() }
    }

    /// Percentile `p` \[1\] of the finite positive values; zero without any. `value` computes the value of a pixel from its bands.
    pub fn percentile(&self, p: f64, value: impl Fn(&[f64]) -> f64) -> f64 {
        let values = |pixels: &[f64]| -> Vec<f64> {
            pixels.chunks_exact(self.bands).map(&value).filter(|value| value.is_finite() && *value > 0.0).collect()
        };
        let (mut light, stars) = (values(&self.light), values(&self.stars));
        let last = if light.is_empty() { 1.0 } else { self.weight };
        let brighter = (1.0 - p) * (self.weight * light.len() as f64 + stars.len() as f64 - last);
        // The brightest pixels alone are sorted.
        let count = ((brighter / self.weight) as usize + 2).min(light.len());
        if count < light.len() {
            let first = light.len() - count;
            light.select_nth_unstable_by(first, f64::total_cmp);
            light.drain(..first);
        }
        let mut brightest: Vec<(f64, f64)> = light.into_iter().map(|value| (value, self.weight)).collect();
        brightest.extend(stars.into_iter().map(|value| (value, 1.0)));
        brightest.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        let mut above = 0.0;
        for (value, weight) in &brightest {
            // Sums of weights are rounded.
            if above >= brighter * (1.0 - 1e-9) {
                return *value;
            }
            above += weight;
        }
        brightest.last().map_or(0.0, |(value, _)| *value)
    }
}

/// Pixel of an image at the middle of a pixel of the picture by which levels are chosen.
fn beneath(image: &Image, (column, row): (usize, usize), edge: f64) -> usize {
    let place = |number: usize, count: usize| (((number as f64 + 0.5) * edge) as usize).min(count - 1);
    place(row, image.height) * image.width + place(column, image.width)
}

/// Measure of a pixel of a flat picture: Ω = p² cos³θ \[sr\], tan θ the distance from the axis, or an area \[pc²\]. Flux divided by it
/// is radiance.
fn solid_angle(image: &Image, pixel: usize) -> f64 {
    match image.pixel {
        Some(PixelScale::Angle(degrees)) => {
            let square = degrees.to_radians().powi(2);
            let (column, row) = ((pixel % image.width) as f64, (pixel / image.width) as f64);
            let right = column + 0.5 - 0.5 * image.width as f64 - image.axis.0;
            let up = 0.5 * image.height as f64 - row - 0.5 - image.axis.1;
            square * (1.0 + square * (right * right + up * up)).powf(-1.5)
        }
        Some(PixelScale::Length(pc)) => pc * pc,
        _ => f64::INFINITY,
    }
}

/// Means over blocks of pixels, pixel × band; blocks that the picture does not fill are left out.
fn means(values: Vec<f64>, (width, height): (usize, usize), bands: usize, block: usize) -> Vec<f64> {
    if block == 1 || width < block || height < block {
        return values;
    }
    let (columns, rows) = (width / block, height / block);
    let mut means = vec![0.0; columns * rows * bands];
    for row in 0..rows * block {
        for column in 0..columns * block {
            let mean = &mut means[(row / block * columns + column / block) * bands..][..bands];
            mean.iter_mut().zip(&values[(row * width + column) * bands..]).for_each(|(mean, value)| *mean += value);
        }
    }
    means.iter_mut().for_each(|mean| *mean /= (block * block) as f64);
    means
}

#[cfg(test)]
mod tests {
    use super::super::{PointSource, Samples};
    use super::*;

    /// A nebula with twenty stars as a camera of 10° sees it with so many pixels in a row; the stars as wide as `disc` draws them.
    fn picture(width: usize) -> Image {
        let height = width * 9 / 16;
        let nebula = |i: usize| {
            let (x, y) = (((i % width) as f64 + 0.5) / width as f64, ((i / width) as f64 + 0.5) / width as f64);
            1e-6 * (1.0 + (40.0 * x).sin() * (30.0 * y).cos()) * (-8.0 * (x - 0.4).powi(2)).exp()
        };
        let mut samples: Vec<f64> = (0..width * height).map(nebula).collect();
        let degrees = (2.0 * 5f64.to_radians().tan() / width as f64).to_degrees();
        let mut image = Image::bare(width, height, vec!["V".into()], Samples::Double(Vec::new()));
        image.pixel = Some(PixelScale::Angle(degrees));
        image.points = (1..=20)
            .map(|i| {
                let [x, y] = [0.618_034, 0.754_878].map(|step| (f64::from(i) * step).fract());
                PointSource { column: x * width as f64, row: y * height as f64, flux: vec![1e-13 * f64::from(i).powi(3)] }
            })
            .collect();
        for point in &image.points {
            for (pixel, share) in disc([width, height], point.column, point.row) {
                samples[pixel] += share * point.flux[0] / solid_angle(&image, pixel);
            }
        }
        image.samples = Samples::Double(samples);
        image
    }

    /// Levels of pictures of all sizes are alike, those of the pixels themselves are not.
    #[test]
    fn levels_are_those_of_any_size() {
        let level = |width: usize| LevelPixels::of(&picture(width)).percentile(0.998, |bands| bands[0]);
        let of_pixels = |width: usize| {
            let image = picture(width);
            let mut values: Vec<f64> = image.band(0).collect();
            values.sort_by(f64::total_cmp);
            values[((values.len() - 1) as f64 * 0.998) as usize]
        };
        let (wanted, raw) = (level(1280), of_pixels(1280));
        assert!((wanted / raw - 1.0).abs() < 0.02, "{wanted} {raw}");
        for width in [192, 640, 1000, 1920, 3840] {
            let found = level(width);
            assert!((found / wanted - 1.0).abs() < 0.06, "{width}: {found} {wanted}");
        }
        assert!(of_pixels(192) > 2.0 * raw);
    }

    /// Without stars, levels are percentiles of the pixels.
    #[test]
    fn levels_without_stars_are_percentiles() {
        let values: Vec<f64> = (0..1000).map(|i| f64::from(i * 7 % 1000) - 10.0).collect();
        let image = Image::bare(50, 20, vec!["V".into()], Samples::Double(values));
        let pixels = LevelPixels::of(&image);
        for (p, wanted) in [(0.0, 1.0), (0.5, 495.0), (0.998, 987.0), (1.0, 989.0)] {
            assert_eq!(pixels.percentile(p, |bands| bands[0]), wanted, "{p}");
        }
        assert_eq!(LevelPixels::of(&Image { samples: Samples::Double(vec![0.0; 1000]), ..image }).percentile(0.5, |bands| bands[0]), 0.0);
    }
}
