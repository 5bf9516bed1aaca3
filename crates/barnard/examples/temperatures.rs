//! cargo run --release -p barnard --example temperatures
//!
//! One cloud lit by a star of five temperatures: whatever of a plan does not hang on the spectrum is kept.

use barnard::backend::{Renderer, cpu};
use barnard::field::Fbm;
use barnard::glam::{DVec3, dvec3};
use barnard::plan::Planner;
use barnard::scene::{Dust, Scale, SceneSpec, Star};
use barnard::spectra::extinction::Extinction;
use barnard::spectra::units::{Luminosity, Temperature};
use barnard::{Camera, Control, Options, Planned};
use barnard_files::SaveImage;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let dust = Dust::new(Fbm::new(2), Extinction::by_name("gordon23")?, Scale::mag_per_pc(5.0)).with_albedo(0.6);
    let camera = Camera::look_at(dvec3(0.0, 0.0, 5.0), DVec3::ZERO).with_size(160, 160);
    let (cloud, options, control) = (SceneSpec::new(camera).with_dust(dust), Options::default(), Control::default());
    let mut before: Option<Planned> = None;
    for kelvin in [4000.0, 7000.0, 12_000.0, 22_000.0, 40_000.0] {
        let star = Star::blackbody(Temperature(kelvin), Luminosity::suns(1000.0)).with_position(dvec3(0.2, 0.3, 0.4));
        let scene = cloud.clone().with_star(star).build()?;
        let planned = Planner::new(&options).plan(&scene, before.as_ref(), &control)?;
        let (image, _) = Renderer::new(&mut cpu::Cpu).render(&planned, &control)?;
        println!("{kelvin} K: {}", image.report.worst_words("johnson-V"));
        image.save(format!("temperature_{kelvin}.png"), &scene.save_options())?;
        before = Some(planned);
    }
    Ok(())
}
