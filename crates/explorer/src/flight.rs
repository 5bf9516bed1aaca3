//! Motion of the observer: around a place, across the view, towards it, and freely.

use barnard::camera::panorama::PanoramaLayout;
use barnard::camera::{Camera, Projection};
use barnard::geometry::Bounds;
use barnard::glam::{DQuat, DVec3};
use barnard::scene::Scene;
use toml_edit::Value;

use crate::edit::{Edit, numbers, place_text, rounded};

/// Turns of a drag over the whole width of the view [rad].
const ORBIT: f64 = std::f64::consts::PI;
/// Distance below which places are equal, relative to the viewing distance: texts round them.
const SAME: f64 = 1e-3;
/// Closest to and furthest from the middle of motion [pc].
const REACH: (f64, f64) = (1e-6, 1e8);
/// Fields of view that can be reached [rad].
const FIELD: (f64, f64) = (1e-5, 2.9);

/// The observer, and the place they move around.
#[derive(Debug, Clone, PartialEq)]
pub struct Flight {
    /// The place and direction of the eye; its size is that of the scene's own picture.
    pub camera: Camera,
    /// The middle of motion, which the eye looks at \[pc\].
    pub pivot: DVec3,
    /// Speed of free flight [pc s⁻¹].
    pub speed: f64,
}

impl Flight {
    /// A flight that begins at the scene's own view.
    pub fn of(scene: &Scene) -> Self {
        let camera = centred(&scene.camera);
        let distance = distance_to_middle(scene, &camera);
        Self { pivot: camera.position + distance * camera.forward, speed: 0.15 * distance, camera }
    }

    /// Another camera of a scene: it moves around the middle of the cloud, or as far ahead as before where it looks from the same place.
    pub fn take(&mut self, scene: &Scene, camera: &Camera) {
        let stays = (camera.position - self.camera.position).length() < SAME * self.distance();
        let distance = if stays { self.distance() } else { distance_to_middle(scene, camera) };
        self.camera = centred(camera);
        self.pivot = camera.position + distance * camera.forward;
    }

    /// The distance from the eye to the middle of motion \[pc\].
    pub fn distance(&self) -> f64 {
        (self.pivot - self.camera.position).dot(self.camera.forward).clamp(REACH.0, REACH.1)
    }

    /// The length that the width of the view has at the middle of motion [pc].
    fn width(&self) -> f64 {
        2.0 * match self.camera.projection {
            Projection::Perspective { half_width } => half_width * self.distance(),
            Projection::Orthographic { half_width_pc } => half_width_pc,
            Projection::Panorama { half_width, .. } => half_width.min(1.0) * self.distance(),
        }
    }

    fn turn(&mut self, rotation: DQuat) {
        let c = &mut self.camera;
        c.forward = (rotation * c.forward).normalize();
        c.right = (rotation * c.right - (rotation * c.right).dot(c.forward) * c.forward).normalize();
        c.up = c.right.cross(c.forward);
    }

    /// Turns around the middle of motion, by parts of the view's width.
    pub fn orbit(&mut self, right: f64, down: f64) {
        let distance = self.distance();
        let rotation = DQuat::from_axis_angle(self.camera.up, -ORBIT * right) * DQuat::from_axis_angle(self.camera.right, -ORBIT * down);
        self.turn(rotation);
        self.camera.position = self.pivot - distance * self.camera.forward;
    }

    /// The eye turns where it stands, by parts of the view's width.
    pub fn look(&mut self, right: f64, down: f64) {
        let field = match self.camera.projection {
            Projection::Perspective { half_width } => 2.0 * half_width.atan(),
            Projection::Orthographic { .. } => 0.5,
            Projection::Panorama { half_width, .. } => 2.0 * half_width.min(1.0),
        };
        let distance = self.distance();
        let rotation = DQuat::from_axis_angle(self.camera.up, -field * right) * DQuat::from_axis_angle(self.camera.right, -field * down);
        self.turn(rotation);
        self.pivot = self.camera.position + distance * self.camera.forward;
    }

    /// Looks at a place from another \[pc\], with the horizon level: up stays in the plane of the former one.
    pub fn aim(&mut self, position: DVec3, target: DVec3) {
        let c = &mut self.camera;
        let forward = (target - position).normalize_or(c.forward);
        let right = forward.cross(c.up).normalize_or(c.right);
        (c.position, c.forward, c.right, c.up) = (position, forward, right, right.cross(forward));
        self.pivot = target;
    }

    /// Rolls about the line of sight \[rad\].
    pub fn roll(&mut self, angle: f64) {
        self.turn(DQuat::from_axis_angle(self.camera.forward, angle));
    }

    /// Moves across the view, by parts of its width: what was under the pointer stays there.
    pub fn pan(&mut self, right: f64, down: f64) {
        let shift = self.width() * (down * self.camera.up - right * self.camera.right);
        self.camera.position += shift;
        self.pivot += shift;
    }

    /// Moves towards the middle of motion: the distance is multiplied by `factor`.
    pub fn approach(&mut self, factor: f64) {
        if let Projection::Orthographic { half_width_pc } = &mut self.camera.projection {
            *half_width_pc = (*half_width_pc * factor).clamp(REACH.0, REACH.1);
            return;
        }
        let distance = (self.distance() * factor).clamp(REACH.0, REACH.1);
        self.camera.position = self.pivot - distance * self.camera.forward;
    }

    /// Flies freely: to the right, up and forward in seconds of flight.
    pub fn fly(&mut self, right: f64, up: f64, forward: f64) {
        let c = &self.camera;
        let shift = self.speed * (right * c.right + up * c.up + forward * c.forward);
        self.camera.position += shift;
        self.pivot += shift;
    }

    /// The field of view, or the width of parallel rays, is multiplied by `factor`.
    pub fn widen(&mut self, factor: f64) {
        match &mut self.camera.projection {
            Projection::Perspective { half_width } => {
                *half_width = (0.5 * (2.0 * half_width.atan() * factor).clamp(FIELD.0, FIELD.1)).tan();
            }
            Projection::Orthographic { half_width_pc } => *half_width_pc = (*half_width_pc * factor).clamp(REACH.0, REACH.1),
            Projection::Panorama { layout: PanoramaLayout::Dome { half_aperture, .. }, half_width } => {
                let wider = (2.0 * *half_aperture * factor).clamp(FIELD.0, 2.0 * std::f64::consts::PI) / (2.0 * *half_aperture);
                (*half_aperture, *half_width) = (wider * *half_aperture, wider * *half_width);
            }
            // All around stays all around.
            Projection::Panorama { .. } => {}
        }
    }

    /// Moves back or forth until all of `bounds` is seen.
    pub fn frame(&mut self, bounds: &Bounds) {
        let (middle, radius) = (0.5 * (bounds.low + bounds.high), 0.5 * bounds.size().length());
        let narrow = (self.camera.height as f64 / self.camera.width as f64).min(1.0);
        self.pivot = middle;
        let distance = match &mut self.camera.projection {
            Projection::Perspective { half_width } => radius / (*half_width * narrow).atan().sin(),
            Projection::Orthographic { half_width_pc } => {
                *half_width_pc = radius / narrow;
                2.0 * radius
            }
            Projection::Panorama { .. } => 2.0 * radius,
        };
        self.camera.position = middle - distance * self.camera.forward;
        self.speed = 0.15 * distance;
    }

    /// The camera of a view of `size`, width and height in pixels, that shows at least what the scene's own picture
    /// shows.
    pub fn seen(&self, size: (usize, usize)) -> Camera {
        let (width, height) = size;
        let mut camera = self.camera.clone();
        let widened = (width as f64 / height as f64 * camera.height as f64 / camera.width as f64).max(1.0);
        match &mut camera.projection {
            Projection::Perspective { half_width } => *half_width *= widened,
            Projection::Orthographic { half_width_pc } => *half_width_pc *= widened,
            Projection::Panorama { half_width, .. } => *half_width *= widened,
        }
        (camera.width, camera.height, camera.supersampling) = (width, height, 1);
        camera
    }

    /// The edit after which the scene's text is seen from here.
    pub fn edit(&self) -> Edit {
        self.edit_of("camera").with_name("camera")
    }

    /// The edit that writes a bookmark of this view.
    pub fn bookmark(&self, name: &str) -> Edit {
        let place = format!("bookmark.{name}");
        self.edit_of(&place).with_name(place)
    }

    /// The view as the keys of a keyframe.
    pub fn keys(&self) -> Vec<(&'static str, Value)> {
        let (c, distance) = (&self.camera, self.distance());
        let mut keys: Vec<(&str, Value)> = vec![
            ("position", place_text(c.position, distance).into()),
            ("target", place_text(c.position + distance * c.forward, distance).into()),
            ("up", numbers(c.up.to_array())),
        ];
        let angle = |radians: f64| Value::from(format!("{} deg", rounded(radians.to_degrees(), 6)));
        match c.projection {
            Projection::Perspective { half_width } => keys.push(("field_of_view", angle(2.0 * half_width.atan()))),
            Projection::Orthographic { half_width_pc } => keys.push(("width", format!("{} pc", rounded(2.0 * half_width_pc, 6)).into())),
            Projection::Panorama { layout: PanoramaLayout::Dome { half_aperture, tilt }, .. } => {
                keys.extend([("aperture", angle(2.0 * half_aperture)), ("tilt", angle(tilt))]);
            }
            Projection::Panorama { .. } => {}
        }
        keys
    }

    /// The camera, as the keys of a table.
    fn edit_of(&self, table: &str) -> Edit {
        const OF_KINDS: [&str; 5] = ["field_of_view", "width", "aperture", "tilt", "crop"];
        let kind = match self.camera.projection {
            Projection::Perspective { .. } => "perspective",
            Projection::Orthographic { .. } => "orthographic",
            Projection::Panorama { layout: PanoramaLayout::Dome { .. }, .. } => "fisheye",
            Projection::Panorama { layout: PanoramaLayout::Sphere, .. } => "equirectangular",
            Projection::Panorama { layout: PanoramaLayout::Cube, .. } => "cubemap",
        };
        let keys = self.keys();
        let others = OF_KINDS.into_iter().filter(|name| keys.iter().all(|(known, _)| known != name)).map(|name| Edit::remove(table, name));
        let removed = others.fold(Edit::set(table, "kind", kind), Edit::and);
        keys.into_iter().fold(removed, |edit, (key, value)| edit.and(Edit::set(table, key, value)))
    }
}

/// A camera as the explorer flies it: a part of an image is looked at as an image of its own.
fn centred(camera: &Camera) -> Camera {
    Camera { offset: (0.0, 0.0), ..camera.clone() }
}

/// Distance from a camera to the centre of a scene's cloud \[pc\].
fn distance_to_middle(scene: &Scene, camera: &Camera) -> f64 {
    let bounds = scene.dust.as_ref().map(|d| d.density.bounds()).or_else(|| scene.species().first().map(|e| e.density.bounds()));
    let distance = match bounds {
        Some(bounds) => (0.5 * (bounds.low + bounds.high) - camera.position).dot(camera.forward),
        None => camera.position.length(),
    };
    if distance > REACH.0 { distance } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flight() -> Flight {
        Flight::of(&barnard_files::builtin::load("six_stars", 1 << 30).unwrap())
    }

    fn is_right(c: &Camera) -> bool {
        let unit = |v: DVec3| (v.length() - 1.0).abs() < 1e-9;
        unit(c.forward) && unit(c.right) && unit(c.up) && c.right.cross(c.forward).distance(c.up) < 1e-9
    }

    /// An orbit keeps the distance and the middle of the view; half a turn looks from behind.
    #[test]
    fn orbits_keep_their_distance() {
        let mut flight = flight();
        let (distance, pivot, forward) = (flight.distance(), flight.pivot, flight.camera.forward);
        for _ in 0..10 {
            flight.orbit(0.1, 0.0);
        }
        assert!(is_right(&flight.camera) && (flight.distance() / distance - 1.0).abs() < 1e-9 && flight.pivot == pivot);
        assert!(flight.camera.forward.dot(forward) < -0.999, "{:?}", flight.camera.forward);
    }

    /// A pan keeps what was under the pointer there.
    #[test]
    fn pans_carry_the_view_along() {
        let mut flight = flight();
        let place = flight.pivot;
        flight.pan(0.25, -0.1);
        let (column, row) = flight.camera.project(place).unwrap();
        let (w, h) = (flight.camera.width as f64, flight.camera.height as f64);
        assert!((column - (0.5 * w + 0.25 * w)).abs() < 1e-6 * w && (row - (0.5 * h - 0.1 * w)).abs() < 1e-6 * w, "{column} {row}");
    }

    /// Framed, all corners are seen, and something reaches near the border.
    #[test]
    fn frames_show_all() {
        let mut flight = flight();
        flight.approach(7.0);
        flight.orbit(0.3, 0.1);
        let bounds = Bounds { low: DVec3::new(-1.0, -2.0, 0.5), high: DVec3::new(3.0, 1.0, 1.5) };
        flight.frame(&bounds);
        let corner = |i: usize| DVec3::from_array(std::array::from_fn(|a| if i >> a & 1 == 0 { bounds.low[a] } else { bounds.high[a] }));
        let places: Vec<(f64, f64)> = (0..8).map(|i| flight.camera.project(corner(i)).unwrap()).collect();
        let edge = flight.camera.width as f64;
        assert!(places.iter().all(|(x, y)| (0.0..=edge).contains(x) && (0.0..=edge).contains(y)), "{places:?}");
        assert!(places.iter().any(|(x, y)| (x - 0.5 * edge).abs().max((y - 0.5 * edge).abs()) > 0.25 * edge), "{places:?}");
    }

    /// The text that a view is written as brings it back, to the digits that are written.
    #[test]
    fn views_are_written() {
        let mut document = crate::document::Document::builtin("six_stars", 1 << 30).unwrap();
        let mut flight = Flight::of(document.scene());
        flight.orbit(0.2, -0.15);
        flight.roll(0.4);
        flight.widen(0.7);
        document.apply(flight.edit()).unwrap();
        let (seen, written) = (&flight.camera, &document.scene().camera);
        assert!(is_right(written) && seen.position.distance(written.position) < 1e-4 && seen.forward.distance(written.forward) < 1e-5);
        assert!(seen.up.distance(written.up) < 1e-5 && seen.position.distance(Flight::of(document.scene()).camera.position) < 1e-4);
        let (Projection::Perspective { half_width: a }, Projection::Perspective { half_width: b }) = (seen.projection, written.projection)
        else {
            panic!("another projection")
        };
        assert!((a / b - 1.0).abs() < 1e-5);
    }

    /// A view of another shape shows all that the scene's own picture shows.
    #[test]
    fn wide_views_show_the_frame() {
        let flight = flight();
        for size in [(640, 360), (200, 500)] {
            let camera = flight.seen(size);
            let ray = flight.camera.ray(1.0, flight.camera.height as f64 - 1.0);
            let (column, row) = camera.project(ray.at(5.0)).unwrap();
            assert!((0.0..=size.0 as f64).contains(&column) && (0.0..=size.1 as f64).contains(&row), "{size:?} {column} {row}");
        }
    }
}
