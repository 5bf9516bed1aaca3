//! Pixels by which automatic levels are chosen.
//!
//! A star is drawn over the same number of pixels whatever their size: in a small picture it covers more of the nebula, and is fainter.
//! Levels are therefore those of a picture of [`LEVEL_WIDTH`] pixels in a row: stars as they are there, and the light between them.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::convolution::Sphere;
use super::coordinates::solid_angle;
use super::{Image, PixelScale};
use crate::camera::Camera;
use crate::points::{disc, disc_on_sphere};

/// Pixels in a row of the picture by which levels are chosen.
const LEVEL_WIDTH: f64 = 1280.0;

/// Most points that are taken out and drawn anew, the brightest: the light of more would fill all pixels of such a picture.
const MOST_POINTS: usize = 100_000;

/// Light of points in a pixel: number of each point, and radiance per flux.
type PointShares = Vec<(usize, f64)>;

/// Pixels by which levels are chosen.
pub(super) struct LevelPixels<'a> {
    image: &'a Image,
    /// Pixels of the image along a pixel of the picture by which levels are chosen.
    edge: f64,
    /// Pixels along a block of the image; the mean of a block is one value.
    block: usize,
    /// Weight of such a value; that of a pixel of a star is one.
    weight: f64,
    /// Points in pixels of the image.
    drawn: BTreeMap<usize, PointShares>,
    /// Points in pixels of the picture by which levels are chosen.
    stars: BTreeMap<usize, PointShares>,
}

impl<'a> LevelPixels<'a> {
    /// Pixels of an image.
    pub fn of(image: &'a Image) -> Self {
        let edge = image.part.map_or(image.width, |part| part.whole.0) as f64 / LEVEL_WIDTH;
        let block = match (edge.round() as usize).max(1) {
            block if block <= image.width.min(image.height) => block,
            _ => 1,
        };
        let mut pixels = Self { image, edge, block, weight: 1.0, drawn: BTreeMap::new(), stars: BTreeMap::new() };
        let sky = Sphere::of(image).map(|sphere| {
            let camera = sphere.camera();
            let [width, height] = pixels.size();
            (camera.clone(), camera.with_size(width, height))
        });
        for number in brightest(image) {
            let (drawn, stars) = pixels.discs(number, sky.as_ref());
            drawn.into_iter().for_each(|(pixel, per_flux)| pixels.drawn.entry(pixel).or_default().push((number, per_flux)));
            stars.into_iter().for_each(|(pixel, per_flux)| pixels.stars.entry(pixel).or_default().push((number, per_flux)));
        }
        // Light counts as often as there are pixels between stars.
        let between = (image.width * image.height) as f64 / (edge * edge) - pixels.stars.len() as f64;
        pixels.weight = between.max(1.0) / pixels.blocks().max(1) as f64;
        pixels
    }

    /// Radiance per flux of a point in pixels of the image, and of the picture by which levels are chosen; `sky` has the cameras of both
    /// where they are all around.
    fn discs(&self, number: usize, sky: Option<&(Camera, Camera)>) -> (PointShares, PointShares) {
        let (image, edge, point) = (self.image, self.edge, &self.image.points[number]);
        let (column, row) = (point.column / edge, point.row / edge);
        match sky {
            Some((camera, other)) => (disc_on_sphere(camera, point.column, point.row), disc_on_sphere(other, column, row)),
            None => {
                let drawn = disc([image.width, image.height], point.column, point.row);
                let stars = disc(self.size(), column, row);
                let per_flux = |(pixel, share): (usize, f64)| (pixel, share / (edge * edge * measure(image, self.beneath(pixel))));
                (drawn.map(|(pixel, share)| (pixel, share / measure(image, pixel))).collect(), stars.map(per_flux).collect())
            }
        }
    }

    /// Columns and rows of the picture by which levels are chosen; quotients are rounded.
    fn size(&self) -> [usize; 2] {
        [self.image.width, self.image.height].map(|pixels| (pixels as f64 / self.edge - 1e-9).ceil() as usize)
    }

    /// Whole blocks of the image.
    fn blocks(&self) -> usize {
        (self.image.width / self.block) * (self.image.height / self.block)
    }

    /// Pixel of the image at the middle of a pixel of the picture by which levels are chosen.
    fn beneath(&self, pixel: usize) -> usize {
        let columns = self.size()[0];
        let place = |number: usize, count: usize| (((number as f64 + 0.5) * self.edge) as usize).min(count - 1);
        place(pixel / columns, self.image.height) * self.image.width + place(pixel % columns, self.image.width)
    }

    /// Adds light of points to the bands of a pixel, times a factor.
    fn add(&self, points: &PointShares, factor: f64, bands: &mut [f64]) {
        for (number, per_flux) in points {
            bands.iter_mut().zip(&self.image.points[*number].flux).for_each(|(band, flux)| *band += factor * per_flux * flux);
        }
    }

    /// Light of a pixel of the image without its points, band by band.
    fn add_light(&self, pixel: usize, bands: &mut [f64]) {
        let size = self.image.width * self.image.height;
        bands.iter_mut().enumerate().for_each(|(number, band)| *band += self.image.samples.at(number * size + pixel));
        if let Some(points) = self.drawn.get(&pixel) {
            self.add(points, -1.0, bands);
        }
    }

    /// Mean light of a block without its points, band by band.
    fn block_light(&self, block: usize, bands: &mut [f64]) {
        let columns = self.image.width / self.block;
        let (left, top) = (block % columns * self.block, block / columns * self.block);
        bands.fill(0.0);
        for (row, column) in (top..top + self.block).flat_map(|row| (left..left + self.block).map(move |column| (row, column))) {
            self.add_light(row * self.image.width + column, bands);
        }
        bands.iter_mut().for_each(|band| *band /= self.block.pow(2) as f64);
    }

    /// Light of a pixel with stars, band by band.
    fn star_light(&self, pixel: usize, points: &PointShares, bands: &mut [f64]) {
        bands.fill(0.0);
        self.add_light(self.beneath(pixel), bands);
        bands.iter_mut().for_each(|band| *band = band.max(0.0));
        self.add(points, 1.0, bands);
    }

    /// Percentile `p` \[1\] of the finite positive values; zero without any. `value` computes the value of a pixel from its bands.
    pub fn percentile(&self, p: f64, value: impl Fn(&[f64]) -> f64 + Sync) -> f64 {
        let bands = || vec![0.0; self.image.bands.len()];
        let is_light = |value: &f64| value.is_finite() && *value > 0.0;
        let of_block = |bands: &mut Vec<f64>, block: usize| {
            self.block_light(block, bands);
            value(bands)
        };
        let of_star = |bands: &mut Vec<f64>, (pixel, points): (&usize, &PointShares)| {
            self.star_light(*pixel, points, bands);
            value(bands)
        };
        let mut light: Vec<f64> = (0..self.blocks()).into_par_iter().map_init(bands, of_block).filter(is_light).collect();
        let stars: Vec<f64> = self.stars.par_iter().map_init(bands, of_star).filter(is_light).collect();
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

/// Numbers of the brightest points of an image, in ascending order.
fn brightest(image: &Image) -> Vec<usize> {
    let mut numbers: Vec<usize> = (0..image.points.len()).collect();
    if numbers.len() > MOST_POINTS {
        let flux = |number: &usize| image.points[*number].flux.iter().sum::<f64>();
        numbers.select_nth_unstable_by(MOST_POINTS, |a, b| flux(b).total_cmp(&flux(a)).then(a.cmp(b)));
        numbers.truncate(MOST_POINTS);
        numbers.sort_unstable();
    }
    numbers
}

/// Measure of a pixel of a flat picture, by which flux is divided for radiance: a solid angle \[sr\] or an area \[pc²\].
fn measure(image: &Image, pixel: usize) -> f64 {
    match image.pixel {
        Some(PixelScale::Angle(degrees)) => solid_angle(degrees.to_radians(), [image.width, image.height], image.axis, pixel),
        Some(PixelScale::Length(pc)) => pc * pc,
        _ => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{PointSource, Samples};
    use super::*;

    /// Image of a nebula with twenty stars: 10° in perspective, or 1 pc in parallel projection.
    fn picture(width: usize, is_parallel: bool) -> Image {
        let height = width * 9 / 16;
        let nebula = |i: usize| {
            let (x, y) = (((i % width) as f64 + 0.5) / width as f64, ((i / width) as f64 + 0.5) / width as f64);
            1e-6 * (1.0 + (40.0 * x).sin() * (30.0 * y).cos()) * (-8.0 * (x - 0.4).powi(2)).exp()
        };
        let mut samples: Vec<f64> = (0..width * height).map(nebula).collect();
        let degrees = (2.0 * 5f64.to_radians().tan() / width as f64).to_degrees();
        let mut image = Image::bare(width, height, vec!["V".into()], Samples::Double(Vec::new()));
        image.pixel = Some(if is_parallel { PixelScale::Length(1.0 / width as f64) } else { PixelScale::Angle(degrees) });
        let unit = if is_parallel { 1e-13 / 0.0306 } else { 1e-13 };
        image.points = (1..=20)
            .map(|i| {
                let [x, y] = [0.618_034, 0.754_878].map(|step| (f64::from(i) * step).fract());
                PointSource { column: x * width as f64, row: y * height as f64, flux: vec![unit * f64::from(i).powi(3)] }
            })
            .collect();
        for point in &image.points {
            for (pixel, share) in disc([width, height], point.column, point.row) {
                samples[pixel] += share * point.flux[0] / measure(&image, pixel);
            }
        }
        image.samples = Samples::Double(samples);
        image
    }

    /// Levels of pictures of all sizes are alike, those of the pixels themselves are not.
    #[test]
    fn levels_are_those_of_any_size() {
        for is_parallel in [false, true] {
            let level = |width: usize| LevelPixels::of(&picture(width, is_parallel)).percentile(0.998, |bands| bands[0]);
            let of_pixels = |width: usize| {
                let image = picture(width, is_parallel);
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
    }

    /// In pictures of all around too: a proxy of a dome, a sphere or a cube has the white of its final, unlike its pixels.
    #[test]
    fn levels_are_those_of_any_size_all_around() {
        use crate::camera::Camera;
        use glam::DVec3;
        let ahead = || Camera::look_at(DVec3::ZERO, DVec3::NEG_Z);
        let cameras: [(&str, &dyn Fn(usize) -> Camera); 3] = [
            ("dome", &|width| ahead().with_fisheye_deg(180.0, 60.0).with_size(width, width)),
            ("sphere", &|width| ahead().with_equirectangular(width)),
            ("cube", &|width| ahead().with_cubemap(width)),
        ];
        let stars: Vec<(DVec3, f64)> = (1..=400)
            .map(|i| {
                let [z, turn] = [0.618_034, 0.754_878].map(|step| (f64::from(i) * step).fract());
                let (z, turn) = (2.0 * z - 1.0, std::f64::consts::TAU * turn);
                let r = (1.0 - z * z).sqrt();
                (DVec3::new(r * turn.cos(), r * turn.sin(), z), 1e-12 * f64::from(i % 20 + 1).powi(3))
            })
            .collect();
        for (name, camera) in cameras {
            let picture = |width: usize| {
                let camera = camera(width);
                let (width, height) = (camera.width, camera.height);
                let centre = |i: usize| ((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
                let nebula = |i: usize| {
                    let (x, y) = centre(i);
                    if camera.sees(x, y) { 1e-9 * (1.5 + camera.ray(x, y).direction.x).powi(2) } else { 0.0 }
                };
                let mut samples: Vec<f64> = (0..width * height).map(nebula).collect();
                let placed = stars.iter().filter_map(|(towards, flux)| Some((camera.project(*towards)?, *flux)));
                let points: Vec<PointSource> = placed.map(|((column, row), flux)| PointSource { column, row, flux: vec![flux] }).collect();
                for point in &points {
                    for (pixel, per_flux) in disc_on_sphere(&camera, point.column, point.row) {
                        samples[pixel] += per_flux * point.flux[0];
                    }
                }
                let image = Image::bare(width, height, vec!["V".into()], Samples::Double(samples));
                let circle = matches!(camera.pixel_scale(), PixelScale::Equidistant(_)).then_some(0.5 * width as f64);
                Image {
                    pixel: Some(camera.pixel_scale()),
                    axis: camera.axis(),
                    views: (1, if name == "cube" { 6 } else { 1 }),
                    circle,
                    points,
                    ..image
                }
            };
            let level = |width: usize| LevelPixels::of(&picture(width)).percentile(0.998, |bands| bands[0]);
            let of_pixels = |width: usize| {
                let mut values: Vec<f64> = picture(width).band(0).filter(|value| *value > 0.0).collect();
                values.sort_by(f64::total_cmp);
                values[((values.len() - 1) as f64 * 0.998) as usize]
            };
            let wanted = level(1280);
            assert!((wanted / of_pixels(1280) - 1.0).abs() < 0.03, "{name}: {wanted} {}", of_pixels(1280));
            for width in [128, 320, 1000] {
                assert!((level(width) / wanted - 1.0).abs() < 0.06, "{name} {width}: {} {wanted}", level(width));
            }
            assert!((of_pixels(128) / wanted - 1.0).abs() > 0.2, "{name}: {}", of_pixels(128));
        }
    }

    /// Of more points than are drawn anew, the faintest stay in the light between.
    #[test]
    fn the_brightest_points_are_drawn_anew() {
        let mut image = picture(192, false);
        let faint =
            |i: usize| PointSource { column: (i % 192) as f64, row: (i / 192 % 108) as f64, flux: vec![1e-20 * (1 + i % 7) as f64] };
        let before = LevelPixels::of(&image).percentile(0.998, |bands| bands[0]);
        image.points.splice(0..0, (0..MOST_POINTS + 5).map(faint));
        let numbers = brightest(&image);
        assert!(
            numbers.len() == MOST_POINTS
                && numbers.is_sorted()
                && numbers[MOST_POINTS - 20..].iter().eq(&Vec::from_iter(MOST_POINTS + 5..MOST_POINTS + 25))
        );
        let after = LevelPixels::of(&image).percentile(0.998, |bands| bands[0]);
        assert!((after / before - 1.0).abs() < 0.02, "{before} {after}");
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
