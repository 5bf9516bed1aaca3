//! cargo run --release -p barnard --example array
//!
//! A cloud that stands in memory as an array, lit by one star.

use barnard::field::Grid;
use barnard::geometry::Bounds;
use barnard::glam::{DVec3, dvec3};
use barnard::phase::HenyeyGreenstein;
use barnard::scene::{Dust, Scale, SceneSpec, Star};
use barnard::spectra::extinction::Extinction;
use barnard::spectra::units::{Luminosity, Temperature};
use barnard::{Camera, Options};
use barnard_files::SaveImage;

/// Knots along a helix: 64 × 64 × 64 values, x running fastest.
fn helix() -> Vec<f32> {
    let place = |i: usize| dvec3((i % 64) as f64, (i / 64 % 64) as f64, (i / 4096) as f64) / 32.0 - DVec3::splat(63.0 / 64.0);
    let density = |p: DVec3| {
        let axis = dvec3(0.5 * (5.0 * p.y).cos(), p.y, 0.5 * (5.0 * p.y).sin());
        (-30.0 * (p - axis).length_squared()).exp() * (1.0 + 0.6 * (20.0 * p.y).sin()) * (1.0 - p.y.powi(2))
    };
    (0..64 * 64 * 64).map(|i| density(place(i)) as f32).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let density = Grid::new([64, 64, 64], Bounds::cube(DVec3::ZERO, 1.0), helix())?;
    let dust =
        Dust::new(density, Extinction::by_name("gordon23")?, Scale::per_pc(5.0)).with_albedo(0.6).with_phase(HenyeyGreenstein::new(0.5)?);
    let star = Star::blackbody(Temperature(22_000.0), Luminosity::suns(5000.0)).with_position(dvec3(0.2, 0.1, 0.3));
    let camera = Camera::look_at(dvec3(0.0, 0.0, 6.0), DVec3::ZERO).with_field_of_view_deg(25.0).with_size(256, 256);
    let scene = SceneSpec::new(camera).with_dust(dust).with_star(star).build()?;
    Ok(barnard::render(&scene, &Options::default())?.save("array.png", &scene.save_options())?)
}
