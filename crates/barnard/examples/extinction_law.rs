//! cargo run --release -p barnard --example extinction_law
//!
//! An extinction law of one's own: grey dust with a bump in the ultraviolet.

use barnard::field::Fbm;
use barnard::glam::{DVec3, dvec3};
use barnard::scene::{Background, Dust, Scale, SceneSpec, Star, StarField};
use barnard::spectra::extinction::{Extinction, ExtinctionLaw};
use barnard::spectra::passband;
use barnard::spectra::units::{Luminosity, Temperature};
use barnard::{Camera, Options};
use barnard_files::SaveImage;

#[derive(Debug)]
struct GreyWithBump;

impl ExtinctionLaw for GreyWithBump {
    fn k(&self, lambda_um: f64) -> f64 {
        1.0 + 1.5 * (-0.5 * ((1.0 / lambda_um - 4.6) / 0.5).powi(2)).exp()
    }
    fn range_um(&self) -> (f64, f64) {
        (0.1, 3.0)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let law = Extinction::new("grey with a bump", GreyWithBump);
    let cloud = Fbm { ridged: true, scale: 0.5, ..Fbm::new(11) }.checked()?;
    let dust = Dust::new(cloud, law, Scale::mag_per_pc(6.0)).with_albedo(0.5);
    let star = Star::blackbody(Temperature(9000.0), Luminosity::suns(300.0)).with_position(dvec3(0.3, 0.4, 0.6));
    let camera = Camera::look_at(dvec3(0.0, 0.5, 5.0), DVec3::ZERO).with_size(200, 200);
    let sky = Background::stars(StarField { seed: 7, ..StarField::default() });
    let scene =
        SceneSpec::new(camera).with_bands(passband::set("johnson")?).with_dust(dust).with_star(star).with_background(sky).build()?;
    Ok(barnard::render(&scene, &Options::default())?.save("extinction_law.png", &scene.save_options())?)
}
