//! A flight from the present view into the cloud, around its brightest stars.

use std::f64::consts::PI;

use barnard::camera::Projection;
use barnard::field::column;
use barnard::geometry::Bounds;
use barnard::glam::{DQuat, DVec3};
use barnard::scene::{Scene, Star};

use crate::flight::Flight;

/// Keys of a visit, and the time between them \[s\].
const KEYS: usize = 9;
const BETWEEN: f64 = 2.5;
/// Angle around the target \[rad\].
const SWEEP: f64 = 1.9;
/// Axes of rotation on each side that are compared, and their largest angle from the vertical \[rad\].
const AXES: i32 = 5;
const TILT: f64 = 0.6;
/// Distances from the target at the end that are compared, relative to the smallest half edge of the cloud.
const ENDS: [f64; 3] = [0.3, 0.45, 0.65];
/// Tangents of half the field of view: telescopes begin nearer with the first, and end with the second.
const FAR: f64 = 0.15;
const NEAR: f64 = 0.45;
/// Wavelength at which stars are weighed \[µm\].
const VISIBLE_UM: f64 = 0.55;

/// The keys of a visit and their moments \[s\]; none where parallel rays cannot enter a cloud, and where there is no cloud.
///
/// It begins with the direction and the frame of `from`, ends inside the cloud, and takes the side from which dust hides least of
/// the target.
pub fn route(scene: &Scene, from: &Flight) -> Option<Vec<(f64, Flight)>> {
    if matches!(from.camera.projection, Projection::Orthographic { .. }) {
        return None;
    }
    let bounds = scene.densities().map(|density| density.bounds()).reduce(|a, b| a.union(&b))?;
    let target = target(&scene.stars, &bounds);
    let radius = 0.5 * bounds.size().min_element();
    let angles = (0..2 * AXES).map(|i| TILT * f64::from(2 * (i % AXES) + 1 - AXES) / f64::from(AXES - 1) + PI * f64::from(i / AXES));
    let sides = angles.flat_map(|angle| ENDS.map(|end| Side { angle, end_pc: end * radius }));
    let best = sides.map(|side| (side.clearness(scene, from, target), side)).max_by(|a, b| a.0.total_cmp(&b.0))?.1;
    Some((0..KEYS).map(|key| (BETWEEN * key as f64, best.flight(from, target, key as f64 / (KEYS - 1) as f64))).collect())
}

/// Mean place of the stars inside the cloud, weighted by their visible light; the centre of a cloud without stars.
fn target(stars: &[Star], bounds: &Bounds) -> DVec3 {
    let inside = stars.iter().filter(|star| bounds.contains(star.position));
    let weighted = inside.map(|star| (star.spectrum.continuum(VISIBLE_UM), star.position));
    let (sum, place) = weighted.fold((0.0, DVec3::ZERO), |(sum, place), (weight, position)| (sum + weight, place + weight * position));
    if sum > 0.0 { place / sum } else { 0.5 * (bounds.low + bounds.high) }
}

/// A side of the cloud to which a visit turns.
#[derive(Clone, Copy)]
struct Side {
    /// Angle of the axis of rotation from the vertical \[rad\].
    angle: f64,
    /// Distance from the target at the end \[pc\].
    end_pc: f64,
}

impl Side {
    /// The view at a part of the visit \[0 to 1\]: the width of the view at the target and its angle go from first to last in
    /// equal ratios, the turn around the target is slow at first.
    fn flight(self, from: &Flight, target: DVec3, part: f64) -> Flight {
        let camera = &from.camera;
        let start = camera.position - target;
        let axis = DQuat::from_axis_angle(camera.forward, self.angle) * camera.up;
        let direction = DQuat::from_axis_angle(axis, SWEEP * part * part) * start.normalize_or(-camera.forward);
        let between = |first: f64, last: f64| first * (last / first).powf(part);
        let mut flight = from.clone();
        let distance = if let Projection::Perspective { half_width } = &mut flight.camera.projection {
            let first = half_width.max(FAR);
            let width = between(2.0 * *half_width * start.length(), 2.0 * self.end_pc * first.max(NEAR));
            *half_width = between(first, first.max(NEAR));
            0.5 * width / *half_width
        } else {
            between(start.length(), self.end_pc)
        };
        flight.aim(target + distance * direction, target);
        flight
    }

    /// Mean share of light that arrives from the target at views of the second half, and from near surroundings.
    fn clearness(self, scene: &Scene, from: &Flight, target: DVec3) -> f64 {
        let depth = |a: DVec3, b: DVec3| scene.dust.as_ref().map_or(0.0, |dust| dust.sigma_v_per_pc * column(&*dust.density, a, b));
        let clear = |key: usize| {
            let position = self.flight(from, target, key as f64 / (KEYS - 1) as f64).camera.position;
            (-depth(position, target)).exp() + (-depth(position, position.lerp(target, 0.2))).exp()
        };
        (KEYS / 2..KEYS).map(clear).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A visit begins in the direction of the present view, ends inside the cloud with the target in the middle, and no view is
    /// upside down.
    #[test]
    fn visits_end_inside() {
        let scene = barnard_files::builtin::load("six_stars", 1 << 30).unwrap();
        let from = Flight::of(&scene);
        let keys = route(&scene, &from).unwrap();
        assert_eq!((keys.len(), keys[0].0), (KEYS, 0.0));
        let bounds = scene.dust.as_ref().unwrap().density.bounds();
        let end = &keys[KEYS - 1].1.camera;
        assert!(bounds.contains(end.position) && !bounds.contains(from.camera.position));
        let target = target(&scene.stars, &bounds);
        let start = |flight: &Flight| (flight.camera.position - target).normalize();
        assert!(start(&keys[0].1).dot(start(&from)) > 1.0 - 1e-9);
        for (_, flight) in &keys[1..] {
            let (column, row) = flight.camera.project(target).unwrap();
            let (width, height) = (flight.camera.width as f64, flight.camera.height as f64);
            assert!((column - 0.5 * width).abs() < 1e-6 * width && (row - 0.5 * height).abs() < 1e-6 * height, "{column} {row}");
            assert!(flight.camera.up.dot(from.camera.up) > -0.5);
        }
        let distances: Vec<f64> = keys.iter().map(|(_, flight)| flight.camera.position.distance(target)).collect();
        assert!(distances.windows(2).all(|pair| pair[1] < pair[0]), "{distances:?}");
    }

    /// Of two sides, one behind a wall of dust, the other is chosen.
    #[test]
    fn visits_avoid_dust() {
        use barnard::camera::Camera;
        use barnard::field::{Grid, Lattice};
        use barnard::scene::{Dust, Scale, SceneSpec};
        use barnard::spectra::extinction::Extinction;
        let wall = Grid::sampled(Lattice { dims: [16; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) }, |p| f64::from(u8::from(p.x > 0.15)));
        let dust = Dust::new(wall, Extinction::by_name("gordon23").unwrap(), Scale::per_pc(50.0));
        let scene = SceneSpec::new(Camera::look_at(DVec3::Z * 5.0, DVec3::ZERO)).with_dust(dust).build().unwrap();
        let keys = route(&scene, &Flight::of(&scene)).unwrap();
        assert!(keys[KEYS - 1].1.camera.position.x < 0.0, "{}", keys[KEYS - 1].1.camera.position);
        let mut parallel = scene.clone();
        let projection = Projection::Orthographic { half_width_pc: 1.0 };
        parallel = parallel.clone().with_camera(Camera { projection, ..parallel.camera.clone() });
        assert!(route(&parallel, &Flight::of(&parallel)).is_none());
    }
}
