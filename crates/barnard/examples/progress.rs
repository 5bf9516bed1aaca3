//! cargo run --release -p barnard --example progress
//!
//! Progress of a render in words, and a way to stop it: here after a minute.

use std::time::{Duration, Instant};

use barnard::control::Stage;
use barnard::field::Fbm;
use barnard::glam::{DVec3, dvec3};
use barnard::scene::{Dust, Scale, SceneSpec, Star};
use barnard::spectra::extinction::Extinction;
use barnard::spectra::units::{Luminosity, Temperature};
use barnard::{Camera, Control, Error, Options};
use barnard_files::SaveImage;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let dust = Dust::new(Fbm::new(5), Extinction::by_name("gordon23")?, Scale::mag_per_pc(5.0)).with_albedo(0.6);
    let star = Star::blackbody(Temperature(12_000.0), Luminosity::suns(1000.0)).with_position(dvec3(0.2, 0.3, 0.4));
    let scene =
        SceneSpec::new(Camera::look_at(dvec3(0.0, 0.0, 5.0), DVec3::ZERO).with_size(200, 200)).with_dust(dust).with_star(star).build()?;
    let control = Control::with_listener(|stage: Stage, done, all| eprint!("\r{stage:?} {:>3} %   ", 100 * done / all.max(1)));
    let (watch, begun) = (control.clone(), Instant::now());
    std::thread::spawn(move || {
        while begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(100));
        }
        watch.interrupt();
    });
    match barnard::render_with(&scene, &Options::default(), &control) {
        Err(Error::Interrupted) => eprintln!("stopped: it took more than a minute"),
        image => image?.save("progress.png", &scene.save_options())?,
    }
    Ok(())
}
