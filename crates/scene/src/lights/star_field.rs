//! The star field: stars at infinity, drawn from a counter-based generator by (seed, cell of the sky), so they are the
//! same from every camera. Counts grow as 10^(0.4 m) with V magnitude; classes are black bodies of a few temperatures.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use spectra::passband::Passband;
use spectra::sed::{BlackBody, MagnitudeSystem, zero_point};
use spectra::spectrum::Spectrum;
use spectra::units::Temperature;

use crate::camera::{Camera, Projection};
use crate::error::{Error, Result};
use crate::random::Counter;
use crate::scene::StarField;
use crate::star_catalogue::StarClass;

/// More field stars in view than this are a mistake of the scene.
const MAX_FIELD_STARS: f64 = 2e8;
/// Stars that are drawn in a picture of any size at least, and per pixel of a larger one: of more the brightest, since fainter ones
/// cannot be told apart.
const DRAWN: f64 = 1e5;
const DRAWN_PER_PIXEL: f64 = 0.5;

/// Temperature \[K\] and part of the stars.
pub const CLASSES: [(f64, f64); 6] = [(3600.0, 0.22), (4500.0, 0.28), (5600.0, 0.25), (6800.0, 0.14), (9500.0, 0.08), (18000.0, 0.03)];

/// The classes, in order.
///
/// # Errors
/// If Vega's flux is not known through V, which a test rules out.
pub fn field_classes() -> Result<Vec<StarClass>> {
    let v = Passband::by_name("johnson-V")?;
    let flux = zero_point(&v, MagnitudeSystem::Vega)?;
    CLASSES
        .iter()
        .map(|(t, _)| {
            let shape = BlackBody(Temperature(*t));
            let scale = flux / v.integrate(|l| spectra::spectrum::Shape::at(&shape, l));
            Ok(StarClass { name: format!("field stars of {t} K"), spectrum: Spectrum::continuous(scale, Arc::new(shape)) })
        })
        .collect()
}

/// Number of cells from pole to pole; cells have equal areas.
const SKY_SLICES: u64 = 512;

/// A star of the star field before its place is worked out: numbers in [0, 1) say where in its cell of the sky it is.
pub(crate) struct FieldStar {
    cell: u64,
    within: (f64, f64),
    /// 10^(−0.4 m), m its V magnitude.
    pub(crate) gain: f64,
    /// The number of its class in [`CLASSES`].
    pub(crate) class: usize,
}

impl FieldStar {
    /// The next star of a cell, where it lies in the circle and among the brightest `share`; `range` is 10^(−0.4 m) of the faintest
    /// star and how many times it that of the brightest is.
    fn drawn(cell: u64, range: (f64, f64), share: f64, circle: Option<&Circle>, random: &mut Counter) -> Option<Self> {
        let within = (random.uniform(), random.uniform());
        if circle.is_some_and(|circle| !circle.holds(cell, within)) {
            // Its brightness and its class.
            random.skip(2);
            return None;
        }
        // Counts grow as 10^(0.4 m): from the brightest to the faintest, 10^(0.4 m) is evenly spread.
        let (faintest, times) = range;
        let low = times.recip();
        let rank = random.uniform();
        let gain = faintest / (low + rank * (1.0 - low));
        let mut pick = random.uniform();
        let class = CLASSES.iter().position(|(_, part)| {
            pick -= part;
            pick < 0.0
        });
        (rank <= share).then(|| Self { cell, within, gain, class: class.unwrap_or(CLASSES.len() - 1) })
    }

    /// The direction in which it is seen.
    pub(crate) fn direction(&self) -> DVec3 {
        sky_direction(self.cell, self.within.0, self.within.1)
    }
}

/// The circle of the sky in which a flat image and what shines into it from beside lie.
#[derive(Clone, Copy)]
struct Circle {
    ahead: DVec3,
    /// The radius \[rad\].
    radius: f64,
    /// Heights of its lowest and highest place: z of a direction.
    heights: (f64, f64),
}

impl Circle {
    /// That of a camera in perspective, up to a half of the sky: corners tell no larger one. Other images have none. `margin` is how far
    /// beside the image a star shines into it \[pixels\].
    fn of(camera: &Camera, margin: f64) -> Option<Self> {
        let Projection::Perspective { .. } = camera.projection else { return None };
        let (width, height) = (camera.width as f64, camera.height as f64);
        let ahead = camera.ray(0.5 * width, 0.5 * height).direction;
        let corners = [(-margin, -margin), (width + margin, -margin), (-margin, height + margin), (width + margin, height + margin)];
        let to_corner = |(column, row): (f64, f64)| camera.ray(column, row).direction.dot(ahead).clamp(-1.0, 1.0).acos();
        // A little more, for what rounding takes of small angles.
        let radius = corners.map(to_corner).into_iter().fold(0.0, f64::max) + 1e-7;
        if radius > std::f64::consts::FRAC_PI_2 {
            return None;
        }
        let pole = ahead.z.clamp(-1.0, 1.0).acos();
        let heights = ((pole + radius).min(std::f64::consts::PI).cos(), (pole - radius).max(0.0).cos());
        Some(Self { ahead, radius, heights })
    }

    /// Whether it holds a place of a cell. Near a pole a circle meets all cells of a slice, and few of their stars: their height is asked
    /// first.
    fn holds(&self, cell: u64, within: (f64, f64)) -> bool {
        let z = height(cell, within.0);
        self.heights.0 <= z && z <= self.heights.1 && sky_direction(cell, within.0, within.1).dot(self.ahead) >= self.radius.cos()
    }
}

/// The stars that can touch an image, and some beside it; `margin` is how far beside it a star shines into it \[pixels\].
///
/// # Errors
/// If there are too many.
pub(crate) fn stars_in_view(field: &StarField, camera: &Camera, margin: f64) -> Result<Vec<FieldStar>> {
    let circle = Circle::of(camera, margin);
    field_stars(field, camera, cells_in_view(camera, circle.as_ref()), circle.as_ref())
}

/// The stars of some cells of the sky, in a circle where there is one.
fn field_stars(field: &StarField, camera: &Camera, visible: Vec<u64>, circle: Option<&Circle>) -> Result<Vec<FieldStar>> {
    let cells = 2 * SKY_SLICES * SKY_SLICES;
    let per_cell = field.density_per_sr * spectra::constants::SPHERE / cells as f64;
    let in_view = camera.pixel_measure(0.5 * camera.width as f64, 0.5 * camera.height as f64) * (camera.width * camera.height) as f64;
    if field.density_per_sr * in_view > MAX_FIELD_STARS {
        return Err(Error::StarField { in_view: field.density_per_sr * in_view, most: MAX_FIELD_STARS });
    }
    let share = drawn_share(field, camera);
    let (bright, faint) = field.magnitudes;
    let range = (10f64.powf(-0.4 * faint), 10f64.powf(0.4 * (faint - bright)));
    let of_cell = |cell: u64| {
        let mut random = Counter::new(field.seed, cell);
        let count = poisson(per_cell, &mut random);
        (0..count).filter_map(move |_| FieldStar::drawn(cell, range, share, circle, &mut random))
    };
    Ok(visible.into_par_iter().flat_map_iter(of_cell).collect())
}

/// Share of the stars in view that are drawn \[1\]: the same for a picture and its parts.
fn drawn_share(field: &StarField, camera: &Camera) -> f64 {
    let (width, height) = camera.part.map_or((camera.width, camera.height), |part| part.whole);
    let pixels = (width * height) as f64;
    let in_view = field.density_per_sr * pixels * camera.pixel_measure(0.5 * camera.width as f64, 0.5 * camera.height as f64);
    ((DRAWN_PER_PIXEL * pixels).max(DRAWN) / in_view).min(1.0)
}

/// The z of a direction within a cell.
fn height(cell: u64, u: f64) -> f64 {
    2.0 * ((cell / (2 * SKY_SLICES)) as f64 + u) / SKY_SLICES as f64 - 1.0
}

/// A direction within slices of equal z and longitude.
fn sky_direction(cell: u64, u: f64, v: f64) -> DVec3 {
    let (z, sector) = (height(cell, u), cell % (2 * SKY_SLICES));
    let (sin, cos) = (std::f64::consts::PI * (sector as f64 + v) / SKY_SLICES as f64).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

/// The cells that can touch the image: those whose middle lies within the image's circle, widened by the cell's own
/// size, which is that of all cells of a slice. In a slice they are neighbours, sectors around the longitude at which
/// the camera looks.
fn cells_in_view(camera: &Camera, circle: Option<&Circle>) -> Vec<u64> {
    let Some(Circle { ahead, radius, .. }) = circle.copied() else {
        // From the whole sky most is seen, and a picture without perspective sees none.
        let is_flat = matches!(camera.projection, Projection::Orthographic { .. });
        return (0..if is_flat { 0 } else { 2 * SKY_SLICES * SKY_SLICES }).collect();
    };
    let sectors = 2 * SKY_SLICES as i64;
    let per_radian = SKY_SLICES as f64 / std::f64::consts::PI;
    let looks_at = (ahead.y.atan2(ahead.x) * per_radian).floor() as i64;
    let of_slice = |slice: u64| {
        let first = slice * 2 * SKY_SLICES;
        let middle = sky_direction(first, 0.5, 0.5);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| sky_direction(first, u, v));
        let half_angle = corners.iter().map(|c| c.dot(middle).clamp(-1.0, 1.0).acos()).fold(0.0, f64::max);
        let least = (radius + half_angle).min(std::f64::consts::PI).cos();
        // The middles m with m · ahead ≥ least; the longitudes of both differ by no more than the arc of this cosine.
        let across = middle.truncate().length() * ahead.truncate().length();
        let cosine = (least - middle.z * ahead.z) / across.max(f64::MIN_POSITIVE);
        let most = (cosine <= 1.0).then(|| (cosine.max(-1.0).acos() * per_radian).ceil() as i64 + 1)?;
        let range = if 2 * most < sectors { looks_at - most..=looks_at + most } else { 0..=sectors - 1 };
        Some(range.map(move |sector| first + sector.rem_euclid(sectors) as u64))
    };
    (0..SKY_SLICES).into_par_iter().filter_map(of_slice).flatten_iter().collect()
}

/// A Poisson number: by inversion where the mean is small, by its normal limit where it is large.
fn poisson(mean: f64, random: &mut Counter) -> u64 {
    if mean > 200.0 {
        let (u, v) = (random.uniform().max(1e-300), random.uniform());
        let normal = (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos();
        return (mean + mean.sqrt() * normal).round().max(0.0) as u64;
    }
    let (mut k, mut product, limit) = (0, random.uniform(), (-mean).exp());
    while product > limit {
        product *= random.uniform();
        k += 1;
    }
    k
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Margin around an image in which stars are requested [pixels].
    const MARGIN: f64 = 4.0;
    const ALL: std::ops::Range<u64> = 0..2 * SKY_SLICES * SKY_SLICES;

    /// Cameras that look anywhere, along the axis of the sky's slices and across the ends of their sectors too.
    fn cameras() -> Vec<Camera> {
        let towards = [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z, DVec3::new(-1.0, 1e-3, 0.05), DVec3::new(0.1, -0.2, 0.97)];
        let up = DVec3::new(0.3, 1.0, 0.2).normalize();
        towards
            .iter()
            .flat_map(|t| {
                [12.0, 150.0].map(|deg| Camera::look_at(DVec3::ZERO, *t).with_up(up).with_field_of_view_deg(deg).with_size(64, 36))
            })
            .collect()
    }

    fn field() -> StarField {
        StarField { density_per_sr: 2e4, magnitudes: (6.0, 14.0), seed: 7 }
    }

    /// Brightness and place of those that touch the image, the brightest first.
    fn seen(camera: &Camera, stars: &[FieldStar]) -> Vec<(f64, f64, f64)> {
        let (width, height) = (camera.width as f64 + MARGIN, camera.height as f64 + MARGIN);
        let place = |star: &FieldStar| {
            let (column, row) = camera.project(camera.position + 1e12 * star.direction())?;
            (column > -MARGIN && row > -MARGIN && column < width && row < height).then_some((star.gain, column, row))
        };
        let mut seen: Vec<_> = stars.iter().filter_map(place).collect();
        seen.sort_by(|a, b| b.partial_cmp(a).unwrap());
        seen
    }

    #[test]
    fn no_star_of_the_sky_is_missed() {
        for camera in cameras() {
            let some = stars_in_view(&field(), &camera, MARGIN).unwrap();
            assert!(some.len() < 251_000, "all stars are looked at");
            let all = field_stars(&field(), &camera, ALL.collect(), None).unwrap();
            assert_eq!(seen(&camera, &some), seen(&camera, &all), "{camera:?}");
            // Beside the middle of a very wide image corners are nearer than an edge.
            let aside = camera.clone().with_field_of_view_deg(170.0).crop(0, 0, 36, 36).unwrap();
            let all = field_stars(&field(), &aside, ALL.collect(), None).unwrap();
            assert_eq!(seen(&aside, &stars_in_view(&field(), &aside, MARGIN).unwrap()), seen(&aside, &all), "{aside:?}");
            assert!(cells_in_view(&camera, Circle::of(&camera, MARGIN).as_ref()).len() < ALL.end as usize, "all cells are looked at");
        }
    }

    /// Of a field too crowded to be told apart the brightest stars are drawn: those of the sparse picture's bright end.
    #[test]
    fn crowded_fields_show_their_brightest() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::X).with_field_of_view_deg(50.0).with_size(640, 360);
        let crowded = StarField { density_per_sr: 1e6, ..field() };
        let gains = |camera: &Camera| -> Vec<f64> {
            let (width, height) = (camera.width as f64, camera.height as f64);
            let is_inside = |(_, x, y): &(f64, f64, f64)| *x > 0.0 && *y > 0.0 && *x < width && *y < height;
            let stars = seen(camera, &stars_in_view(&crowded, camera, MARGIN).unwrap());
            stars.into_iter().filter(is_inside).map(|star| star.0).collect()
        };
        let inside = gains(&camera);
        // The field of view is 50 deg by 29.4 deg, flat: the middle's measure stands for all.
        assert!((inside.len() as f64 / (0.5 * 640.0 * 360.0) - 1.0).abs() < 0.15, "{}", inside.len());
        let wide = camera.clone().with_size(2560, 1440);
        let all = gains(&wide);
        assert!(all.len() > 2 * inside.len() && all[..inside.len()] == inside[..], "{} {}", all.len(), inside.len());
    }

    #[test]
    fn counts_grow_with_magnitude() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::X);
        let stars = field_stars(&field(), &camera, ALL.collect(), None).unwrap();
        let brighter = |m: f64| stars.iter().filter(|s| s.gain > 10f64.powf(-0.4 * m)).count() as f64;
        assert_eq!(brighter(6.0), 0.0);
        assert_eq!(brighter(14.0 + 1e-9), stars.len() as f64);
        // N(m) grows as 10^(0.4 m): 251 189 stars, of which 10^(0.4 (m − 14)) are brighter than m.
        for m in [10.0, 12.0, 13.0] {
            let expected = spectra::constants::SPHERE * 2e4 * (10f64.powf(0.4 * (m - 14.0)) - 10f64.powf(-3.2)) / (1.0 - 10f64.powf(-3.2));
            assert!((brighter(m) - expected).abs() < 4.0 * expected.sqrt(), "{m}: {} {expected}", brighter(m));
        }
    }
}
