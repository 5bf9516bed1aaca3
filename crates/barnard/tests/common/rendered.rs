//! Scenes from a text, and their pictures.

use barnard::control::Control;
use barnard::image::Image;
use barnard::memory::DEFAULT_LIMIT;
use barnard::scene::Scene;

pub fn parse(text: &str) -> Scene {
    barnard_files::parse("truth.toml", "truth", text.to_owned(), &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap()
}

pub fn on_reference(scene: &Scene) -> Image {
    barnard::render_reference(scene, 1e-6, &Control::default()).unwrap()
}
