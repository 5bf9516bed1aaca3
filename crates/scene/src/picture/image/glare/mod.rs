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
//! K fades from a quarter of the longer edge to half of it, where it ends, and keeps all light, but for what leaves the picture. What
//! would come in from beyond the edge is taken to be like what is within: the convolution is divided by that of an even picture.
//! In pictures of all around, points are spread on the sphere (`convolution::sphere`): spikes cross seams and poles.

mod kernels;

use std::cell::OnceCell;
use std::sync::Arc;

use fourier::Complex;

use self::kernels::{KEPT_BYTES, LAST};
use super::convolution::{Kernel, Sphere, Spread, reach};
use super::optics::{OPTICS, OpticsRow};
use super::{Image, PixelScale, Samples};
use crate::error::{Error, Result};

/// Glare of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glare {
    /// The telescope or the eye.
    pub optics: &'static OpticsRow,
    /// λ/D at 550 nm, in thousandths of the picture's longer edge.
    pub size: f64,
    /// Rotation of the optics, counterclockwise \[rad\].
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

impl Glare {
    /// Refuses what no optics do.
    ///
    /// # Errors
    /// If a number is out of its range.
    pub fn check(&self) -> Result<()> {
        for (what, value, range) in
            [("size of a glare", self.size, SIZES), ("seeing of a glare", self.seeing, SEEINGS), ("halo of a glare", self.halo, HALOS)]
        {
            if !range.contains(&value) {
                return Err(Error::out_of_range(what, value, format!("between {} and {}", range.start(), range.end())));
            }
        }
        if self.rotation.is_finite() { Ok(()) } else { Err(Error::out_of_range("rotation of a glare", self.rotation, "finite")) }
    }

    /// Largest number of bytes of a glare in addition to an image of a number of bands: all bands in double precision, three transforms of a
    /// picture, or of a kernel and the air that spreads it, that of the air beside them, two kernels, and those that are kept.
    pub fn bytes(width: usize, height: usize, bands: usize) -> u64 {
        let reach = reach(width.max(height)) as u64;
        let (width, height) = (width as u64, height as u64);
        let air = (3 * reach + 1).pow(2);
        let values = (width + reach).saturating_mul(height + reach).max(air);
        let transforms = values.saturating_mul(3).saturating_add(air).saturating_mul(size_of::<Complex<f64>>() as u64);
        let kernel = (2 * reach + 1).pow(2) * size_of::<f64>() as u64;
        let kernels = kernel.saturating_mul(bands as u64).min(KEPT_BYTES) + 2 * kernel;
        let points = Sphere::bytes(width as usize, height as usize, 2 * bands);
        transforms
            .saturating_add(kernels)
            .saturating_add(points)
            .saturating_add(width.saturating_mul(height).saturating_mul(8 * bands as u64))
    }

    /// The image as these optics show it, white at a radiance [W m⁻² sr⁻¹]; its standard errors stay what they are.
    pub fn seen(&self, image: &Image, white: f64) -> Image {
        let (columns, rows) = image.views;
        let (width, height) = (image.width / columns.max(1), image.height / rows.max(1));
        let mut samples: Vec<f64> = (0..image.samples.len()).map(|i| image.samples.at(i)).collect();
        if width > 0 && height > 0 {
            let haze = OnceCell::new();
            let kernels: Vec<Arc<Kernel>> =
                image.radiances().map(|band| self.cached_kernel(&image.bands[band], width.max(height), &haze, &LAST)).collect();
            let sphere = Sphere::of(image);
            // Bright points are spread on the sphere, the rest of the picture flat.
            let mut points = Vec::new();
            if let Some(sphere) = &sphere {
                for eye in 0..columns {
                    let mut planes = planes(&samples, image, eye);
                    points.push(sphere.take(&mut planes, &kernels, white));
                    put_planes(&mut samples, image, eye, &planes);
                }
            }
            let margin = if closes(image, width) { reach(width.max(height)).min(width) } else { 0 };
            for (band, kernel) in image.radiances().zip(&kernels) {
                let spread = Spread::new(kernel, width + 2 * margin, height);
                for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
                    let first = (band * image.height + row * height) * image.width + column * width;
                    let view = &mut samples[first..];
                    if margin == 0 {
                        spread.apply(view, image.width);
                    } else {
                        let mut wide = continued(view, image.width, (width, height), margin);
                        spread.apply(&mut wide, width + 2 * margin);
                        for (row, wide) in view.chunks_mut(image.width).zip(wide.chunks(width + 2 * margin)) {
                            row[..width].copy_from_slice(&wide[margin..margin + width]);
                        }
                    }
                }
            }
            if let Some(sphere) = &sphere {
                for (eye, points) in points.iter().enumerate() {
                    let mut planes = planes(&samples, image, eye);
                    sphere.put(points, &mut planes, &kernels);
                    put_planes(&mut samples, image, eye, &planes);
                }
            }
            if let Some(circle) = image.circle {
                for (band, column) in image.radiances().flat_map(|band| (0..columns).map(move |column| (band, column))) {
                    let view = &mut samples[band * image.height * image.width + column * width..];
                    cut(view, image.width, (width, height), (image.axis, circle));
                }
            }
        }
        Image { samples: Samples::Double(samples), ..image.header() }
    }
}

/// The radiances of one of the eyes of a picture, band by band.
fn planes(samples: &[f64], image: &Image, eye: usize) -> Vec<Vec<f64>> {
    let width = image.width / image.views.0.max(1);
    let rows = |band: usize| samples[band * image.height * image.width..].chunks(image.width).take(image.height);
    image.radiances().map(|band| rows(band).flat_map(|row| row[eye * width..][..width].iter().copied()).collect()).collect()
}

/// Puts such planes back.
fn put_planes(samples: &mut [f64], image: &Image, eye: usize, planes: &[Vec<f64>]) {
    let width = image.width / image.views.0.max(1);
    for (band, plane) in image.radiances().zip(planes) {
        let rows = samples[band * image.height * image.width..].chunks_mut(image.width);
        rows.zip(plane.chunks(width)).for_each(|(row, line)| row[eye * width..][..width].copy_from_slice(line));
    }
}

/// True if the left and the right edge of a view are neighbours: a sphere by longitude, all around.
fn closes(image: &Image, width: usize) -> bool {
    matches!(image.pixel, Some(PixelScale::PlateCarree(degrees)) if (width as f64 * degrees - 360.0).abs() < 1e-6)
}

/// A view with columns of its other side added at both edges; rows of the image are `stride` values apart.
fn continued(view: &[f64], stride: usize, (width, height): (usize, usize), margin: usize) -> Vec<f64> {
    let rows = view.chunks(stride).take(height);
    rows.flat_map(|row| [&row[width - margin..width], &row[..width], &row[..margin]].concat()).collect()
}

/// Takes away what lies outside of a circle around the axis of view, whose place is to the right and upwards from the middle.
fn cut(view: &mut [f64], stride: usize, (width, height): (usize, usize), (axis, radius): ((f64, f64), f64)) {
    let middle = (0.5 * width as f64 + axis.0, 0.5 * height as f64 - axis.1);
    for (y, row) in view.chunks_mut(stride).take(height).enumerate() {
        for (x, value) in row.iter_mut().take(width).enumerate() {
            if (x as f64 + 0.5 - middle.0).hypot(y as f64 + 0.5 - middle.1) > radius {
                *value = 0.0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Band;
    use super::kernels::{KernelCache, KernelKey, keep};
    use super::*;

    /// A point at the edge of a sphere's picture shines on its other side as one in the middle does, and light of a dome stays in its circle.
    #[test]
    fn glares_know_seams_and_circles() {
        let glare = named("hubble");
        let (width, height) = (64, 32);
        let turned = |column: usize, pixel: Option<PixelScale>| {
            let image = Image { pixel, ..points(width, height, &[(column, 16, 1.0)]) };
            let seen: Vec<f64> = glare.seen(&image, 1.0).band(0).collect();
            seen.chunks(width)
                .flat_map(|row| {
                    let mut row = row.to_vec();
                    row.rotate_left((column + width - 32) % width);
                    row
                })
                .collect::<Vec<f64>>()
        };
        let sphere = Some(PixelScale::PlateCarree(360.0 / width as f64));
        let farthest = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let middle = turned(32, sphere);
        assert!(farthest(&middle, &turned(0, sphere)) < 1e-3 * middle[16 * width + 32]);
        assert!(farthest(&middle, &turned(0, None)) > 1e-2 * middle[16 * width + 32]);
        let dome = Image { circle: Some(16.0), ..points(32, 32, &[(16, 1, 1.0)]) };
        let seen: Vec<f64> = glare.seen(&dome, 1.0).band(0).collect();
        let outside = |i: usize| ((i % 32) as f64 - 15.5).hypot((i / 32) as f64 - 15.5) > 16.0;
        assert!((0..seen.len()).all(|i| !outside(i) || seen[i] == 0.0) && seen.iter().sum::<f64>() > 0.1);
    }

    /// The light of a round glare depends on the angle from its star alone, across the seam, a pole and the edges of a cube; flat
    /// pictures of the same pixels have another. The angles are those of directions, and the light is that of the kernel.
    #[test]
    fn glares_are_round_on_the_sphere() {
        use crate::camera::panorama::PanoramaLayout;
        use std::f64::consts::{FRAC_PI_2, PI};
        const LIGHT: f64 = 1e6;
        let glare = Glare { size: 3.0, halo: 1.0, ..named("refractor") };
        let dome = PanoramaLayout::Dome { half_aperture: FRAC_PI_2, tilt: FRAC_PI_2 };
        let cases = [
            (PanoramaLayout::Sphere, (128, 64), PixelScale::PlateCarree as fn(f64) -> PixelScale, vec![(64, 32), (1, 20), (90, 3)]),
            (dome, (96, 96), PixelScale::Equidistant, vec![(48, 48), (47, 10)]),
            (PanoramaLayout::Cube, (48, 288), PixelScale::OnCube, vec![(24, 216), (46, 216), (24, 194), (46, 194)]),
        ];
        for (layout, (width, height), scale, stars) in cases {
            let unit = match layout {
                PanoramaLayout::Dome { .. } => PI / width as f64,
                PanoramaLayout::Sphere => 2.0 * PI / width as f64,
                PanoramaLayout::Cube => 2.0 / width as f64,
            };
            let axes = [glam::DVec3::NEG_Z, glam::DVec3::X, glam::DVec3::Y];
            let place = |x: usize, y: usize| ((x as f64 + 0.5 - 0.5 * width as f64) * unit, (0.5 * height as f64 - y as f64 - 0.5) * unit);
            for star in stars {
                let picture = |pixel: Option<PixelScale>| {
                    let is_dome = matches!(layout, PanoramaLayout::Dome { .. });
                    let views = (1, if layout == PanoramaLayout::Cube { 6 } else { 1 });
                    let circle = (pixel.is_some() && is_dome).then_some(0.5 * width as f64);
                    let image = Image { pixel, views, circle, ..points(width, height, &[(star.0, star.1, LIGHT)]) };
                    // So bright that all of its light is seen.
                    glare.seen(&image, 1.0)
                };
                let here = place(star.0, star.1);
                let direction = layout.direction(here, &axes);
                let longer = if layout == PanoramaLayout::Cube { width } else { width.max(height) };
                let band = &points(1, 1, &[]).bands[0];
                let kernel = glare.kernel(band, longer, &glare.haze(longer));
                let wrong = |image: &Image| {
                    // Light that ends at the antipode is made up for everywhere.
                    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
                    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).filter(|(x, y)| layout.sees(place(*x, *y))) {
                        let apart = layout.direction(place(x, y), &axes).angle_between(direction) / unit;
                        if (4.0..0.7 * kernel.reach as f64).contains(&apart) {
                            let wanted = LIGHT * layout.measure(here) * kernel.between(apart, 0.0);
                            let ratio = image.at(0, y, x) / wanted;
                            (least, most) = (least.min(ratio), most.max(ratio));
                        }
                    }
                    if least > 0.0 { most / least - 1.0 } else { f64::INFINITY }
                };
                let round = picture(Some(scale(unit.to_degrees())));
                assert!(wrong(&round) < 0.1, "{layout:?} {star:?}: {}", wrong(&round));
                let light: f64 = (0..height)
                    .flat_map(|y| (0..width).map(move |x| (x, y)))
                    .filter(|(x, y)| layout.sees(place(*x, *y)))
                    .map(|(x, y)| round.at(0, y, x) * layout.measure(place(x, y)))
                    .sum();
                let is_whole = !matches!(layout, PanoramaLayout::Dome { .. }) || star == (48, 48);
                assert!(!is_whole || (light / LIGHT / layout.measure(here) - 1.0).abs() < 0.03, "{layout:?} {star:?}: {light}");
                let is_flat = layout == PanoramaLayout::Sphere && star == (64, 32) || star == (48, 48) || star == (24, 216);
                assert!(is_flat || wrong(&picture(None)) > 0.5, "{layout:?} {star:?}: {}", wrong(&picture(None)));
            }
        }
    }

    /// A picture with points, given by column, row and light.
    fn points(width: usize, height: usize, at: &[(usize, usize, f64)]) -> Image {
        let mut values = vec![0.0; width * height];
        at.iter().for_each(|(x, y, light)| values[y * width + x] = *light);
        let mut image = Image::bare(width, height, vec!["V".into()], Samples::Double(values));
        (image.bands[0].pivot_um, image.bands[0].width_um) = (Some(0.55), Some(1e-4));
        image
    }

    fn named(name: &str) -> Glare {
        Glare { optics: OPTICS.iter().find(|row| row.name == name).unwrap(), halo: 0.0, ..Glare::default() }
    }

    /// A lens has Airy's pattern: dark rings at 1.220 and 2.233 λ/D, 83.8 % of the light within the first (Born & Wolf, 8.5.2).
    #[test]
    fn a_lens_shows_airys_rings() {
        let image = points(1001, 1001, &[(500, 500, 1.0)]);
        // 10 pixels in λ/D.
        let seen = Glare { size: 10.0 / 1.001, ..named("refractor") }.seen(&image, 1.0);
        let along = |x: usize| seen.at(0, 500, 500 + x);
        let darkest = |from: usize, to: usize| (from..to).min_by(|a, b| along(*a).total_cmp(&along(*b))).unwrap();
        assert_eq!((darkest(8, 16), darkest(18, 26)), (12, 22));
        let within: f64 = (0..1001 * 1001)
            .filter(|i| ((i % 1001) as f64 - 500.0).hypot((i / 1001) as f64 - 500.0) < 12.2)
            .map(|i| seen.at(0, i / 1001, i % 1001))
            .sum();
        // Beyond r λ/D goes 2/(π² r) of the light; the kernel has half of its strength 37.5 λ/D away: it lacks 0.54 %.
        assert!((within - 0.838 * 1.0054).abs() < 0.002, "{within}");
    }

    /// Light stays what it is: as much of a point in the middle, an even picture even, at its edges too.
    #[test]
    fn light_is_kept() {
        for row in OPTICS {
            let glare = Glare { seeing: 3.0, halo: 0.1, size: 1.0, rotation: 0.3, ..named(row.name) };
            let even = Image { samples: Samples::Double(vec![2.5; 120 * 80]), ..points(120, 80, &[]) };
            let seen = glare.seen(&even, 1.0);
            let worst = (0..9600).map(|i| (seen.samples.at(i) / 2.5 - 1.0).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-9, "{}: {worst}", row.name);
            let kernel = glare.kernel(&even.bands[0], 120, &glare.haze(120));
            assert!((kernel.values.iter().sum::<f64>() - 1.0).abs() < 1e-12 && kernel.values.iter().all(|v| *v > -1e-12));
        }
    }

    /// Light that pixels do not tell from that of a point stays in its pixel, and what leaves it is as much as a lens sends out
    /// of a square: beyond r λ/D it is 2/(π² r) of all (Born & Wolf, 8.5.2), so 0.18244 of h⁻¹ beyond half a pixel of h λ/D.
    #[test]
    fn sharp_optics_leave_light_in_its_pixel() {
        let image = points(321, 321, &[(160, 160, 1.0)]);
        for size in [0.01, 0.05, 0.2, 1.2] {
            let glare = Glare { size, ..named("refractor") };
            let seen = glare.kernel(&image.bands[0], 321, &glare.haze(321));
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
        let (image, glare) = (points(60, 40, &at), named("hubble"));
        let kernel = glare.kernel(&image.bands[0], 60, &glare.haze(60));
        let (reach, edge) = (kernel.reach as i64, 2 * kernel.reach + 1);
        let around = |x: i64, y: i64| {
            let inside = x.abs() <= reach && y.abs() <= reach;
            if inside { kernel.values[(y + reach) as usize * edge + (x + reach) as usize] } else { 0.0 }
        };
        let seen = glare.seen(&image, 1.0);
        for (x, y) in (0..40i64).flat_map(|y| (0..60i64).map(move |x| (x, y))) {
            let light: f64 = at.iter().map(|(px, py, light)| light * around(x - *px as i64, y - *py as i64)).sum();
            let even: f64 = (0..2400i64).map(|i| around(x - i % 60, y - i / 60)).sum();
            let (found, wanted) = (seen.at(0, y as usize, x as usize), light / even);
            assert!((found - wanted).abs() < 1e-9 * wanted + 1e-9, "{x} {y}: {found} {wanted}");
        }
        let both = Image { views: (2, 1), ..points(120, 40, &at) };
        let parted = glare.seen(&both, 1.0);
        assert!((0..40).all(|y| (60..120).all(|x| parted.at(0, y, x).abs() < 1e-300)));
        assert!((0..40).all(|y| (0..60).all(|x| (parted.at(0, y, x) - seen.at(0, y, x)).abs() <= 1e-9)));
    }

    /// A kernel that a picture before had is taken again, and none that differs in anything; what is kept is bounded.
    #[test]
    fn kernels_are_kept() {
        let image = points(90, 60, &[(30, 20, 5.0)]);
        let (glare, band) = (Glare { size: 0.777, ..named("newtonian") }, &image.bands[0]);
        let last = KernelCache::default();
        let cached = |glare: &Glare, longer: usize, band: &Band| glare.cached_kernel(band, longer, &OnceCell::new(), &last);
        let first = cached(&glare, 90, band);
        let red = Band { pivot_um: Some(0.8), ..band.clone() };
        let other = cached(&glare, 90, &red);
        assert!(!Arc::ptr_eq(&first, &other) && other.values != first.values);
        assert!(Arc::ptr_eq(&first, &cached(&glare, 90, band)) && Arc::ptr_eq(&other, &cached(&glare, 90, &red)));
        // Another picture takes their place.
        let turned = Glare { rotation: 0.1, ..glare };
        assert!([cached(&turned, 90, band), cached(&glare, 91, band)].iter().all(|other| other.values != first.values));
        assert_eq!(last.lock().unwrap().len(), 1);
        // The last two are kept where there is room for two and a half.
        let (mut last, room) = (Vec::new(), 5 * first.bytes() / 2);
        for pivot_um in [0.4, 0.5, 0.6, 0.7] {
            let asked = KernelKey { glare, longer: 90, pivot_um: Some(pivot_um), width_um: None };
            keep(&mut last, (asked, first.clone()), room);
        }
        assert_eq!(last.iter().map(|(asked, _)| asked.pivot_um).collect::<Vec<_>>(), [Some(0.6), Some(0.7)]);
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
        let glare = Glare { size: 5.0, ..named("newtonian") };
        let (straight, turned) = (glare.seen(&image, 1.0), Glare { rotation: 30f64.to_radians(), ..glare }.seen(&image, 1.0));
        assert!(spoke(&straight, 0.0) > 5.0 * spoke(&straight, 30.0), "{} {}", spoke(&straight, 0.0), spoke(&straight, 30.0));
        assert!(spoke(&turned, 30.0) > 5.0 * spoke(&turned, 0.0) && spoke(&turned, 30.0) > 5.0 * spoke(&turned, 60.0));
        let within = |pivot: f64, radius: f64| -> f64 {
            let mut image = image.clone();
            image.bands[0].pivot_um = Some(pivot);
            let seen = Glare { optics: named("refractor").optics, size: 10.0, ..glare }.seen(&image, 1.0);
            let is_within = |i: &usize| ((i % 401) as f64 - 200.0).hypot((i / 401) as f64 - 200.0) < radius;
            (0..401 * 401).filter(is_within).map(|i| seen.samples.at(i)).sum()
        };
        let (blue, red, nearer) = (within(0.4, 10.2), within(0.8, 20.4), within(0.8, 10.2));
        assert!((red / blue - 1.0).abs() < 0.01 && nearer < 0.95 * red, "{blue} {red} {nearer}");
    }

    /// A glare has no edge: a halo falls as 1/r² within half of its reach and is gone at its end, in steps that none sees.
    #[test]
    fn it_fades() {
        let image = points(401, 401, &[(200, 200, 1.0)]);
        let glare = Glare { halo: 1.0, ..named("hubble") };
        let kernel = glare.kernel(&image.bands[0], 401, &glare.haze(401));
        let left = |x: usize| kernel.values[200 * 401 + 200 + x] * (x * x + 1) as f64;
        let whole = left(20);
        assert!((20..=100).all(|x| (left(x) / whole - 1.0).abs() < 1e-2) && (left(150) / whole - 0.5).abs() < 1e-2);
        assert!((101..=200).all(|x| (0.0..0.02 * whole).contains(&(left(x - 1) - left(x)))) && left(199) < 1e-3 * whole);
        assert!(kernel.values[0] == 0.0);
    }

    /// What the air does has the width that was asked for.
    #[test]
    fn seeing_has_its_width() {
        let image = points(401, 401, &[(200, 200, 1.0)]);
        let seen = Glare { size: 0.1, seeing: 20.0 / 0.401, ..named("refractor") }.seen(&image, 1.0);
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
