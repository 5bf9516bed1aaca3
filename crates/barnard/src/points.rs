//! Unresolved sources: visible stars and the star field, spread over pixels by a small normalised point-spread
//! function.
//!
//! A source of irradiance E [W m⁻²] adds E w_p / Ω_p to pixel p, Ω_p its solid angle, Σ w_p = 1: the flux in the image
//! is the star's. Under an orthographic camera the intensity L/4π [W sr⁻¹] takes the place of E and the pixel's area
//! \[m²\] that of Ω.
//!
//! The star field: stars at infinity, drawn from a counter-based generator by (seed, cell of the sky), so they are the
//! same from every camera. Counts grow as 10^(0.4 m) with V magnitude; temperatures follow a table of classes.

use glam::DVec3;
use rayon::prelude::*;

use crate::camera::{Camera, Projection};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::geometry::Ray;
use crate::light::{Light, Route};
use crate::random::Counter;
use crate::scene::{Scene, StarField};
use crate::star_field;

/// Standard deviation of the point-spread function [pixels]: FWHM of 1.65, well sampled.
const PSF_SIGMA: f64 = 0.7;
/// The radius at which the point spread function is cut [pixels].
const PSF_RADIUS: i64 = 4;
/// More field stars than this are a mistake of the scene.
const MAX_FIELD_STARS: f64 = 5e6;

/// A point of the image at which an unresolved source appears, and how bright the source is without dust.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    column: f64,
    row: f64,
    /// The number of its light.
    pub light: usize,
    /// The light's band flux is multiplied by it, then divided by the pixel's measure.
    gain: f64,
    /// The distance of the source along the ray of its place \[pc\].
    pub length: f64,
}

impl Point {
    /// The ray from the camera towards the source.
    pub fn ray(&self, camera: &Camera) -> Ray {
        camera.ray(self.column, self.row)
    }
}

/// The unresolved sources that are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sources {
    /// All of them are drawn.
    All,
    /// Stars of the scene, and at most so many of the star field: those that are brightest without dust.
    Brightest(usize),
}

impl Sources {
    /// What is drawn while things move.
    pub const PREVIEW: Self = Self::Brightest(1500);
}

/// Draws unresolved sources: `add` hears of places in an image (bands × height × width) and radiances; `fluxes(number,
/// light, ray, length)` are the fluxes of a light in all bands behind what lies on the first `length` \[pc\] of the ray
/// to the source of a number, in the order of [`points`].
///
/// # Errors
/// Where the star field has too many stars, and when the user wishes to stop.
pub fn draw(
    sources: Sources,
    scene: &Scene,
    camera: &Camera,
    lights: &[Light],
    fluxes: impl Fn(usize, usize, &Ray, f64) -> Vec<f64> + Sync,
    control: &Control,
    mut add: impl FnMut(usize, f64),
) -> Result<()> {
    let points = points(sources, scene, camera, lights)?;
    let fluxes = |(number, point): (usize, &Point)| {
        control.check()?;
        let bare = fluxes(number, point.light, &point.ray(camera), point.length);
        Ok(bare.into_iter().map(|flux| point.gain * flux).collect())
    };
    let fluxes: Vec<Vec<f64>> = points.par_iter().enumerate().map(fluxes).collect::<Result<_>>()?;
    for (point, fluxes) in points.iter().zip(fluxes) {
        splat(camera, point, &fluxes, &mut add);
    }
    Ok(())
}

/// The unresolved sources that a camera sees: stars of the scene first, then the star field.
///
/// # Errors
/// Where the star field has too many.
pub fn points(sources: Sources, scene: &Scene, camera: &Camera, lights: &[Light]) -> Result<Vec<Point>> {
    let mut points = direct_points(scene, camera, lights);
    if let Some(field) = &scene.background.star_field {
        let circle = Circle::of(camera);
        let stars = field_stars(field, camera, cells_in_view(camera, circle.as_ref()), circle.as_ref())?;
        let first = lights.iter().position(|l| matches!(l.route, Route::FieldStar { class: 0 })).unwrap_or(0);
        let place = |star: &FieldStar| star.point(camera, first);
        match sources {
            Sources::All => points.par_extend(stars.par_iter().filter_map(place)),
            Sources::Brightest(most) => points.append(&mut brightest(stars, most, place)),
        }
    }
    Ok(points)
}

/// At most so many points of `stars`, those of the brightest that have one: few more stars are placed than it takes, twice as many
/// each time, since where few have a point each time looks at all that are left.
fn brightest(mut stars: Vec<FieldStar>, most: usize, place: impl Fn(&FieldStar) -> Option<Point> + Sync) -> Vec<Point> {
    let (mut rest, mut points, mut asked) = (&mut stars[..], Vec::new(), most);
    while points.len() < most && !rest.is_empty() {
        asked = asked.saturating_mul(2);
        let next = asked.min(rest.len());
        if next < rest.len() {
            rest.select_nth_unstable_by(next, |a, b| b.gain.total_cmp(&a.gain));
        }
        let (head, tail) = rest.split_at_mut(next);
        points.par_extend(head.par_iter().filter_map(&place));
        rest = tail;
    }
    if most < points.len() {
        points.select_nth_unstable_by(most, |a, b| b.gain.total_cmp(&a.gain));
        points.truncate(most);
    }
    points
}

fn direct_points(scene: &Scene, camera: &Camera, lights: &[Light]) -> Vec<Point> {
    let point = |(light, l): (usize, &Light)| {
        let Route::Direct { star } = l.route else { return None };
        let position = scene.stars[star].position;
        let (column, row) = camera.project(position)?;
        let (length, gain) = match camera.projection {
            Projection::Perspective { .. } | Projection::Panorama { .. } => {
                let length = (position - camera.ray(column, row).origin).length();
                (length, 1.0 / (length * length))
            }
            // L/4π [W sr⁻¹] over pc² of pixel: the light's unit is W m⁻² at one parsec, so its intensity is that times
            // pc².
            Projection::Orthographic { .. } => {
                let ray = camera.ray(column, row);
                ((position - ray.origin).dot(ray.direction), 1.0)
            }
        };
        let inside = (-(PSF_RADIUS as f64)..=(camera.width as f64 + PSF_RADIUS as f64)).contains(&column)
            && (-(PSF_RADIUS as f64)..=(camera.height as f64 + PSF_RADIUS as f64)).contains(&row);
        inside.then_some(Point { column, row, light, gain, length })
    };
    lights.iter().enumerate().filter_map(point).collect()
}

/// A distance at which two eyes see a star alike [pc].
const SKY_PC: f64 = 1e12;
/// Number of cells from pole to pole; cells have equal areas.
const SKY_SLICES: u64 = 512;

/// A star of the star field before its place is worked out: numbers in [0, 1) say where in its cell of the sky it is.
struct FieldStar {
    cell: u64,
    within: (f64, f64),
    /// 10^(−0.4 m), m its V magnitude.
    gain: f64,
    /// The number of its class in [`star_field::CLASSES`].
    class: usize,
}

impl FieldStar {
    /// The next star of a cell, where it lies in the circle; `range` is 10^(−0.4 m) of the faintest star and how many times it that of
    /// the brightest is.
    fn drawn(cell: u64, range: (f64, f64), circle: Option<&Circle>, random: &mut Counter) -> Option<Self> {
        let within = (random.uniform(), random.uniform());
        if circle.is_some_and(|circle| !circle.holds(cell, within)) {
            // Its brightness and its class.
            random.skip(2);
            return None;
        }
        // Counts grow as 10^(0.4 m): from the brightest to the faintest, 10^(0.4 m) is evenly spread.
        let (faintest, times) = range;
        let low = times.recip();
        let gain = faintest / (low + random.uniform() * (1.0 - low));
        let mut pick = random.uniform();
        let class = star_field::CLASSES.iter().position(|(_, part)| {
            pick -= part;
            pick < 0.0
        });
        Some(Self { cell, within, gain, class: class.unwrap_or(star_field::CLASSES.len() - 1) })
    }

    /// Where it appears, if it touches the image; `first` is the light of the first class.
    fn point(&self, camera: &Camera, first: usize) -> Option<Point> {
        let (column, row) = camera.project(camera.position + SKY_PC * sky_direction(self.cell, self.within.0, self.within.1))?;
        let margin = PSF_RADIUS as f64;
        let inside = column > -margin && row > -margin && column < camera.width as f64 + margin && row < camera.height as f64 + margin;
        inside.then_some(Point { column, row, light: first + self.class, gain: self.gain, length: f64::INFINITY })
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
    /// That of a camera in perspective, up to a half of the sky: corners tell no larger one. Other images have none.
    fn of(camera: &Camera) -> Option<Self> {
        let Projection::Perspective { .. } = camera.projection else { return None };
        let (width, height, margin) = (camera.width as f64, camera.height as f64, PSF_RADIUS as f64);
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

/// The stars of some cells of the sky, in a circle where there is one.
fn field_stars(field: &StarField, camera: &Camera, visible: Vec<u64>, circle: Option<&Circle>) -> Result<Vec<FieldStar>> {
    let cells = 2 * SKY_SLICES * SKY_SLICES;
    let per_cell = field.density_per_sr * spectra::constants::SPHERE / cells as f64;
    let in_view = camera.pixel_measure(0.5 * camera.width as f64, 0.5 * camera.height as f64) * (camera.width * camera.height) as f64;
    if field.density_per_sr * in_view > MAX_FIELD_STARS {
        return Err(Error::StarField { in_view: field.density_per_sr * in_view, most: MAX_FIELD_STARS });
    }
    let (bright, faint) = field.magnitudes;
    let range = (10f64.powf(-0.4 * faint), 10f64.powf(0.4 * (faint - bright)));
    let of_cell = |cell: u64| {
        let mut random = Counter::new(field.seed, cell);
        let count = poisson(per_cell, &mut random);
        (0..count).filter_map(move |_| FieldStar::drawn(cell, range, circle, &mut random))
    };
    Ok(visible.into_par_iter().flat_map_iter(of_cell).collect())
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
        let own = corners.iter().map(|c| c.dot(middle).clamp(-1.0, 1.0).acos()).fold(0.0, f64::max);
        let least = (radius + own).min(std::f64::consts::PI).cos();
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

/// The point-spread function along an axis, in the pixels around pixel `middle`, of a source at `at`.
fn profile(middle: i64, at: f64) -> [f64; 2 * PSF_RADIUS as usize + 1] {
    std::array::from_fn(|i| {
        let pixel = middle - PSF_RADIUS + i as i64;
        (-0.5 * ((pixel as f64 + 0.5 - at) / PSF_SIGMA).powi(2)).exp()
    })
}

/// Spreads one source over its pixels.
fn splat(camera: &Camera, point: &Point, fluxes: &[f64], add: &mut impl FnMut(usize, f64)) {
    let (column, row) = (point.column.floor() as i64, point.row.floor() as i64);
    let (columns, rows) = (profile(column, point.column), profile(row, point.row));
    let norm = 1.0 / (columns.iter().sum::<f64>() * rows.iter().sum::<f64>());
    for (i, of_row) in (row - PSF_RADIUS..).zip(rows) {
        for (j, of_column) in (column - PSF_RADIUS..).zip(columns) {
            if i < 0 || j < 0 || i >= camera.height as i64 || j >= camera.width as i64 {
                continue;
            }
            let share = norm * of_row * of_column / camera.pixel_measure(j as f64 + 0.5, i as f64 + 0.5);
            for (band, flux) in fluxes.iter().enumerate() {
                add((band * camera.height + i as usize) * camera.width + j as usize, share * flux);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cameras that look anywhere, along the axis of the sky's slices and across the ends of their sectors too.
    fn cameras() -> Vec<Camera> {
        let towards = [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z, DVec3::new(-1.0, 1e-3, 0.05), DVec3::new(0.1, -0.2, 0.97)];
        let up = DVec3::new(0.3, 1.0, 0.2).normalize();
        towards
            .iter()
            .flat_map(|t| [12.0, 150.0].map(|deg| Camera::look_at(DVec3::ZERO, *t).up(up).field_of_view_deg(deg).size(64, 36)))
            .collect()
    }

    fn field() -> StarField {
        StarField { density_per_sr: 2e4, magnitudes: (6.0, 14.0), seed: 7 }
    }

    const ALL: std::ops::Range<u64> = 0..2 * SKY_SLICES * SKY_SLICES;

    fn in_view(camera: &Camera) -> Vec<FieldStar> {
        let circle = Circle::of(camera);
        field_stars(&field(), camera, cells_in_view(camera, circle.as_ref()), circle.as_ref()).unwrap()
    }

    fn seen(camera: &Camera, stars: Vec<FieldStar>) -> Vec<(f64, f64, f64)> {
        let mut seen: Vec<_> = stars.iter().filter_map(|s| s.point(camera, 0)).map(|p| (p.gain, p.column, p.row)).collect();
        seen.sort_by(|a, b| b.partial_cmp(a).unwrap());
        seen
    }

    #[test]
    fn no_star_of_the_sky_is_missed() {
        for camera in cameras() {
            let some = in_view(&camera);
            assert!(some.len() < 251_000, "all stars are looked at");
            let all = field_stars(&field(), &camera, ALL.collect(), None).unwrap();
            assert_eq!(seen(&camera, some), seen(&camera, all), "{camera:?}");
            // Beside the middle of a very wide image corners are nearer than an edge.
            let aside = camera.clone().field_of_view_deg(170.0).crop(0, 0, 36, 36).unwrap();
            let all = field_stars(&field(), &aside, ALL.collect(), None).unwrap();
            assert_eq!(seen(&aside, in_view(&aside)), seen(&aside, all), "{aside:?}");
            assert!(cells_in_view(&camera, Circle::of(&camera).as_ref()).len() < ALL.end as usize, "all cells are looked at");
        }
    }

    #[test]
    fn the_brightest_are_the_first_of_all() {
        for camera in cameras() {
            let all = seen(&camera, in_view(&camera));
            for most in [0, 1, 30, all.len(), all.len() + 10] {
                let stars = in_view(&camera);
                let mut gains: Vec<f64> = brightest(stars, most, |s| s.point(&camera, 0)).iter().map(|p| p.gain).collect();
                gains.sort_by(|a, b| b.total_cmp(a));
                let first: Vec<f64> = all.iter().take(most).map(|s| s.0).collect();
                assert_eq!(gains, first, "{most} of {}", all.len());
            }
        }
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
