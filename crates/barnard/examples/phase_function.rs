//! cargo run --release -p barnard --example phase_function
//!
//! A phase function of one's own: two lobes, most of the light forward, the rest backward.

use barnard::field::Fbm;
use barnard::glam::{DVec3, dvec3};
use barnard::phase::{HenyeyGreenstein, Phase};
use barnard::random::Counter;
use barnard::scene::{Dust, Scale, SceneSpec, Star};
use barnard::spectra::extinction::Extinction;
use barnard::spectra::units::{Luminosity, Temperature};
use barnard::{Camera, Options};
use barnard_files::SaveImage;

#[derive(Debug)]
struct TwoLobes {
    forward: HenyeyGreenstein,
    backward: HenyeyGreenstein,
}

impl Phase for TwoLobes {
    fn at(&self, cosine: f64, lambda_um: f64) -> f64 {
        0.8 * self.forward.at(cosine, lambda_um) + 0.2 * self.backward.at(cosine, lambda_um)
    }
    fn sample(&self, lambda_um: f64, random: &mut Counter) -> f64 {
        if random.uniform() < 0.8 { self.forward.sample(lambda_um, random) } else { self.backward.sample(lambda_um, random) }
    }
    fn is_spectral(&self) -> bool {
        false
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let lobes = TwoLobes { forward: HenyeyGreenstein::new(0.75)?, backward: HenyeyGreenstein::new(-0.4)? };
    let dust = Dust::new(Fbm::new(3), Extinction::by_name("ccm89")?, Scale::mag_per_pc(4.0)).with_albedo(0.6).with_phase(lobes);
    let star = Star::blackbody(Temperature(15_000.0), Luminosity::suns(2000.0)).with_position(dvec3(0.1, 0.2, -0.5));
    let scene =
        SceneSpec::new(Camera::look_at(dvec3(0.0, 0.0, 5.0), DVec3::ZERO).with_size(200, 200)).with_dust(dust).with_star(star).build()?;
    Ok(barnard::render(&scene, &Options::default())?.save("phase_function.png", &scene.save_options())?)
}
