//! Parts of the small scenes that unit tests render.

use glam::DVec3;
use spectra::extinction::Extinction;
use spectra::passband::Passband;
use spectra::units::{Luminosity, Temperature};

use crate::camera::Camera;
use crate::field::{IntoField, Sphere};
use crate::scene::{Dust, Method, Scale, Scene, Star};

/// A ball of density one around the origin.
pub fn ball(radius_pc: f64) -> Sphere {
    Sphere::new(DVec3::ZERO, radius_pc).unwrap()
}

/// Dust of a law by name, albedo one half, of so much extinction for a density of one [pc⁻¹].
pub fn dust(density: impl IntoField, law: &str, per_pc: f64) -> Dust {
    Dust::new(density, Extinction::named(law).unwrap(), Scale::per_pc(per_pc)).albedo(0.5)
}

/// A black body of so many suns.
pub fn star(kelvin: f64, suns: f64, position: DVec3) -> Star {
    Star::blackbody(Temperature(kelvin), Luminosity::suns(suns)).at(position)
}

/// What is seen through johnson-V along z, with functions sampled to `bake` voxels an edge.
pub fn scene(camera: Camera, bake: usize) -> Scene {
    let method = Method { bake: Some(bake), ..Method::default() };
    Scene::new(camera).bands(vec![Passband::named("johnson-V").unwrap()]).method(method)
}

/// A camera on the z axis that looks at the origin.
pub fn on_axis(distance_pc: f64, degrees: f64, size: (usize, usize)) -> Camera {
    Camera::look_at(DVec3::new(0.0, 0.0, distance_pc), DVec3::ZERO).field_of_view_deg(degrees).size(size.0, size.1)
}
