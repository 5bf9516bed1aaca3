//! Unresolved sources: visible stars and the star field, spread over pixels by a small normalised point-spread
//! function.
//!
//! A source of irradiance E [W m⁻²] adds E w_p / Ω_p to pixel p, Ω_p its solid angle, Σ w_p = 1: the flux in the image
//! is the star's. Under an orthographic camera the intensity L/4π [W sr⁻¹] takes the place of E and the pixel's area
//! \[m²\] that of Ω.

use glam::DVec3;
use rayon::prelude::*;

use crate::camera::{Camera, Projection};
use crate::control::Control;
use crate::error::Result;
use crate::geometry::Ray;
use crate::image::PointSource;
use crate::light::{Light, Route};
use crate::scene::Scene;
use crate::star_catalogue::PlacedCatalogue;
use crate::star_field::{CLASSES, FieldStar, stars_in_view};

/// Half widths of a source in a flat picture along each axis: within the first it has full weight, beyond the second none \[pixels\].
///
/// The trapezoid is the convolution of boxes of two pixels and one. Its samples have a constant sum and largest value and an exact
/// centroid, wherever in a pixel the source is: slow pans do not twinkle, and positions can be measured. The full width at half
/// maximum is two pixels.
const PSF_WIDTHS: (f64, f64) = (0.5, 1.5);
/// Radii of a source in a picture all around, where pixels form no lattice: a raised cosine between them \[pixels\]. Its largest
/// pixel changes by 1 %, its centroid by 0.02 pixels.
const PSF_RADII: (f64, f64) = (0.65, 2.2);
/// Pixels on each side of a source's own that it may touch.
const PSF_REACH: i64 = 2;
/// Distance beside an image from which a source touches it \[pixels\].
const MARGIN: f64 = PSF_RADII.1;

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
#[non_exhaustive]
pub enum Sources {
    /// All of them are drawn.
    All,
    /// Stars of the scene, and at most a number of the star field: those that are brightest without dust.
    Brightest(usize),
}

impl Sources {
    /// Preview during motion.
    pub const PREVIEW: Self = Self::Brightest(1500);
}

/// Draws unresolved sources, and gives them unless the picture is one eye's or a part of one of all around: `add` receives indices in an image (bands × height × width) and radiances; `fluxes(number,
/// light, ray, length)` are the fluxes of a light in all bands behind what lies on the first `length` \[pc\] of the ray
/// to the source of a number, in the order of [`points`].
///
/// # Errors
/// If the star field has too many stars, and on interruption by the user.
pub fn draw(
    sources: Sources,
    scene: &Scene,
    camera: &Camera,
    lights: &[Light],
    fluxes: impl Fn(usize, usize, &Ray, f64) -> Vec<f64> + Sync,
    control: &Control,
    mut add: impl FnMut(usize, f64),
) -> Result<Vec<PointSource>> {
    let points = points(sources, scene, camera, lights)?;
    let fluxes = |(number, point): (usize, &Point)| {
        control.check()?;
        let bare = fluxes(number, point.light, &point.ray(camera), point.length);
        Ok(bare.into_iter().map(|flux| point.gain * flux).collect())
    };
    let fluxes: Vec<Vec<f64>> = points.par_iter().enumerate().map(fluxes).collect::<Result<_>>()?;
    for (point, fluxes) in points.iter().zip(&fluxes) {
        for (pixel, share) in shares(camera, point) {
            for (band, flux) in fluxes.iter().enumerate() {
                add(band * camera.height * camera.width + pixel, share * flux);
            }
        }
    }
    let is_whole = camera.eye.is_none() && camera.part.is_none();
    let is_listed = is_whole || !matches!(camera.projection, Projection::Panorama { .. });
    let source = |(point, flux): (&Point, Vec<f64>)| PointSource { column: point.column, row: point.row, flux };
    Ok(if is_listed { points.iter().zip(fluxes).map(source).collect() } else { Vec::new() })
}

/// The pixels over which a source of a flat picture is drawn, each with its share of the light; the sum over an endless picture is one.
pub fn disc([width, height]: [usize; 2], column: f64, row: f64) -> impl Iterator<Item = (usize, f64)> {
    const EDGE: usize = 2 * PSF_REACH as usize + 1;
    let along = |first: i64, place: f64| {
        let weight = |i: usize| {
            let distance = ((first + i as i64) as f64 + 0.5 - place).abs();
            0.5 * ((PSF_WIDTHS.1 - distance) / (PSF_WIDTHS.1 - PSF_WIDTHS.0)).clamp(0.0, 1.0)
        };
        std::array::from_fn::<f64, EDGE, _>(weight)
    };
    let (left, top) = (column.floor() as i64 - PSF_REACH, row.floor() as i64 - PSF_REACH);
    let (columns, rows) = (along(left, column), along(top, row));
    let pixels = (0..EDGE * EDGE).map(move |n| (left + (n % EDGE) as i64, top + (n / EDGE) as i64, columns[n % EDGE] * rows[n / EDGE]));
    let is_drawn = move |(j, i, share): &(i64, i64, f64)| *share > 0.0 && (0..width as i64).contains(j) && (0..height as i64).contains(i);
    pixels.filter(is_drawn).map(move |(j, i, share)| (i as usize * width + j as usize, share))
}

/// The unresolved sources that a camera sees: stars of the scene first, then the star field.
///
/// # Errors
/// If the star field has too many.
pub fn points(sources: Sources, scene: &Scene, camera: &Camera, lights: &[Light]) -> Result<Vec<Point>> {
    let mut points = direct_points(scene, camera, lights);
    let first_of = |first: usize| lights.iter().position(|l| l.route == Route::FieldStar { class: first }).unwrap_or(0);
    if let Some(placed) = &scene.background.catalogue {
        let most = match sources {
            Sources::All => usize::MAX,
            Sources::Brightest(most) => 2 * most,
        };
        points.extend(catalogue_points(placed, camera, first_of(CLASSES.len())).take(most));
    }
    if let Some(field) = &scene.background.star_field {
        let stars = stars_in_view(field, camera, MARGIN)?;
        let first = first_of(0);
        let place = |star: &FieldStar| field_point(star, camera, first);
        match sources {
            Sources::All => points.par_extend(stars.par_iter().filter_map(place)),
            Sources::Brightest(most) => points.append(&mut brightest(stars, most, place)),
        }
    }
    Ok(points)
}

/// At most a number of points of `stars`, those of the brightest that have one: few more stars are placed than it takes, twice as many
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
        touches(camera, (column, row)).then_some(Point { column, row, light, gain, length })
    };
    lights.iter().enumerate().filter_map(point).collect()
}

/// A distance at which two eyes see a star alike [pc].
const SKY_PC: f64 = 1e12;

/// Image position of a direction of the sky \[pixels\], if a star there touches the image.
fn place_of(direction: DVec3, camera: &Camera) -> Option<(f64, f64)> {
    camera.project(camera.position + SKY_PC * direction).filter(|place| touches(camera, *place))
}

/// True if a source at a place touches the image. In a part of an image of all around it may do so from across a seam.
fn touches(camera: &Camera, (column, row): (f64, f64)) -> bool {
    let margin = MARGIN;
    let is_near = column > -margin && row > -margin && column < camera.width as f64 + margin && row < camera.height as f64 + margin;
    let may_cross = camera.part.is_some() && matches!(camera.projection, Projection::Panorama { .. });
    is_near || (may_cross && !disc_on_sphere(camera, column, row).is_empty())
}

/// Image position of a star of the star field, if it touches the image; `first` is the light of the first class.
fn field_point(star: &FieldStar, camera: &Camera, first: usize) -> Option<Point> {
    let (column, row) = place_of(star.direction(), camera)?;
    Some(Point { column, row, light: first + star.class, gain: star.gain, length: f64::INFINITY })
}

/// The number of stars of the scene's catalogue, and how many of them are in the field of a camera; none without one.
pub fn catalogue_note(scene: &Scene, camera: &Camera) -> Option<String> {
    let placed = scene.background.catalogue.as_ref()?;
    let turn = placed.scene_from_sky(camera);
    let inside = placed.catalogue.stars.iter().filter(|star| place_of(turn * star.direction, camera).is_some()).count();
    Some(format!("{inside} of {} in the field", placed.catalogue.note()))
}

/// Where the stars of a catalogue appear, the brightest first, each as the points of its two classes; `first` is the light of the
/// first class.
fn catalogue_points<'a>(placed: &'a PlacedCatalogue, camera: &'a Camera, first: usize) -> impl Iterator<Item = Point> + 'a {
    let turn = placed.scene_from_sky(camera);
    placed
        .catalogue
        .stars
        .iter()
        .filter_map(move |star| {
            let (column, row) = place_of(turn * star.direction, camera)?;
            let point = move |(class, gain): (usize, f64)| Point { column, row, light: first + class, gain, length: f64::INFINITY };
            Some(star.shares.into_iter().filter(|(_, gain)| *gain > 0.0).map(point))
        })
        .flatten()
}

/// The stars of the catalogue that have a name and are seen: name, column and row \[pixels\], the brightest first.
pub fn names<'a>(scene: &'a Scene, camera: &'a Camera) -> impl Iterator<Item = (&'a str, f64, f64)> + 'a {
    scene.background.catalogue.iter().flat_map(move |placed| {
        let turn = placed.scene_from_sky(camera);
        let named = placed.catalogue.stars.iter().filter(|star| !star.name.is_empty());
        named.filter_map(move |star| place_of(turn * star.direction, camera).map(|(x, y)| (star.name.as_str(), x, y)))
    })
}

/// The weight of a pixel of a picture all around at a distance from a source \[pixels\].
fn profile(distance: f64) -> f64 {
    let (flat, end) = PSF_RADII;
    0.5 + 0.5 * (std::f64::consts::PI * ((distance - flat) / (end - flat)).clamp(0.0, 1.0)).cos()
}

/// The pixels over which a source is spread, each with its share of the flux divided by the pixel's measure.
fn shares(camera: &Camera, point: &Point) -> Vec<(usize, f64)> {
    match camera.projection {
        Projection::Panorama { .. } => disc_on_sphere(camera, point.column, point.row),
        Projection::Perspective { .. } | Projection::Orthographic { .. } => shares_on_plane(camera, point),
    }
}

/// Shares of a point-spread function that is round in the image.
fn shares_on_plane(camera: &Camera, point: &Point) -> Vec<(usize, f64)> {
    let middle = |pixel: usize| ((pixel % camera.width) as f64 + 0.5, (pixel / camera.width) as f64 + 0.5);
    let share = |(pixel, share): (usize, f64)| {
        let (column, row) = middle(pixel);
        (pixel, share / camera.pixel_measure(column, row))
    };
    disc([camera.width, camera.height], point.column, point.row).map(share).collect()
}

/// The number of a pixel; none outside of the image.
fn inside(camera: &Camera, column: i64, row: i64) -> Option<usize> {
    let is_inside = (0..camera.width as i64).contains(&column) && (0..camera.height as i64).contains(&row);
    is_inside.then(|| row as usize * camera.width + column as usize)
}

/// Shares of a point-spread function that is round on the sphere, a function of the angle from the source: across
/// seams, around poles, and over edges and corners of a cube. Pixels that show no direction get nothing. All light of the
/// source is in the whole image, of which a crop has its part.
pub(crate) fn disc_on_sphere(camera: &Camera, column: f64, row: f64) -> Vec<(usize, f64)> {
    let direction = camera.ray(column, row).direction;
    // Pixels in the middle of a face of a cube are wider than others.
    let step = camera.footprint().per_pc.max(camera.pixel_measure(column, row).sqrt());
    let radius = PSF_RADII.1 * step;
    let angle = |other: DVec3| 2.0 * (0.5 * direction.distance(other)).min(1.0).asin();
    // Pixels that are neighbours on the sphere may be far apart in the image: places on a lattice around the source find
    // a first one on each side, their neighbours in the image follow.
    let (right, up) = direction.any_orthonormal_pair();
    let mut waiting: Vec<(i64, i64)> = Vec::new();
    for (x, y) in (-PSF_REACH..=PSF_REACH).flat_map(|x| (-PSF_REACH..=PSF_REACH).map(move |y| (x as f64, y as f64))) {
        let place = (direction + step * (x * right + y * up)).normalize();
        waiting.extend(camera.project(camera.position + SKY_PC * place).map(|(column, row)| (column.floor() as i64, row.floor() as i64)));
    }
    let mut seen = std::collections::BTreeSet::new();
    let mut weights = Vec::new();
    while let Some((column, row)) = waiting.pop() {
        let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
        if !seen.insert((column, row)) || !camera.sees(x, y) {
            continue;
        }
        let theta = angle(camera.ray(x, y).direction);
        if theta > radius {
            continue;
        }
        weights.push(((column, row), profile(theta / step), camera.pixel_measure(x, y)));
        waiting.extend([(column - 1, row), (column + 1, row), (column, row - 1), (column, row + 1)]);
    }
    // Sums do not depend on the order in which pixels were found.
    weights.sort_by_key(|(place, ..)| *place);
    let sum: f64 = weights.iter().map(|(_, weight, measure)| weight * measure).sum();
    let share = |((column, row), weight, _): ((i64, i64), f64, f64)| Some((inside(camera, column, row)?, weight / sum));
    if sum > 0.0 { weights.into_iter().filter_map(share).collect() } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::StarField;

    /// Wherever a source is in its pixel, its light, its largest pixel and its centroid are exact.
    #[test]
    fn sources_do_not_twinkle() {
        for n in 0..41 * 41 {
            let (x, y) = (7.0 + (n % 41) as f64 / 40.0, 7.0 + (n / 41) as f64 / 40.0);
            let (mut sum, mut peak, mut centroid) = (0.0, 0.0f64, (0.0, 0.0));
            for (pixel, share) in disc([16, 16], x, y) {
                (sum, peak) = (sum + share, peak.max(share));
                centroid.0 += share * ((pixel % 16) as f64 + 0.5 - x);
                centroid.1 += share * ((pixel / 16) as f64 + 0.5 - y);
            }
            assert!((sum - 1.0).abs() < 1e-12 && (peak - 0.25).abs() < 1e-12, "{x} {y}: {sum} {peak}");
            assert!(f64::hypot(centroid.0, centroid.1) < 1e-12, "{x} {y}: {centroid:?}");
        }
        // Beside an edge, the part outside is missing.
        assert!((disc([16, 16], 0.0, 8.0).map(|(_, share)| share).sum::<f64>() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn the_brightest_are_the_first_of_all() {
        let field = StarField { density_per_sr: 2e4, magnitudes: (6.0, 14.0), seed: 7 };
        for (towards, deg) in [(DVec3::X, 12.0), (DVec3::Z, 12.0), (DVec3::new(0.1, -0.2, 0.97), 150.0)] {
            let up = DVec3::new(0.3, 1.0, 0.2).normalize();
            let camera = Camera::look_at(DVec3::ZERO, towards).with_up(up).with_field_of_view_deg(deg).with_size(64, 36);
            let stars = || stars_in_view(&field, &camera, MARGIN).unwrap();
            let place = |star: &FieldStar| field_point(star, &camera, 0);
            let sorted = |points: Vec<Point>| {
                let mut gains: Vec<f64> = points.iter().map(|point| point.gain).collect();
                gains.sort_by(|a, b| b.total_cmp(a));
                gains
            };
            let all = sorted(stars().iter().filter_map(place).collect());
            assert!(all.len() > 30);
            for most in [0, 1, 30, all.len(), all.len() + 10] {
                let first = &all[..most.min(all.len())];
                assert_eq!(sorted(brightest(stars(), most, place)), first, "{most} of {}", all.len());
            }
        }
    }
}
