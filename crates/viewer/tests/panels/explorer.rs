//! The explorer with a small scene, and what hands and eyes do with it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use barnard::backend::cpu;
use barnard_explorer::document::Document;
use barnard_viewer::app::App;
use barnard_viewer::engine::Engine;
use barnard_viewer::session::Session;
use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Modifiers, PointerButton, Pos2, Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

pub const SCENE: &str = r#"# A small cloud.
bands = "johnson" # comments stay

[camera]
kind = "perspective"
position = "0 0 6 pc"
field_of_view = "24 deg"
size = [64, 48]

[field.cloud]
kind = "fbm"
radius = "1 pc"

[dust]
density = "cloud"
scale = "4 mag/pc"

[[star]]
name = "hot star"
kind = "blackbody"
position = "0.3 0.2 0.9 pc"
temperature = "20000 K"
luminosity = "3000 Lsun"

[method]
accuracy = 0.02
bake = 24
"#;

pub const LIMIT: u64 = 1 << 32;

/// A folder with the scene in it.
pub fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cloud.toml");
    std::fs::write(&path, SCENE).unwrap();
    (folder, path)
}

pub fn app(path: &Path, recovery: Option<PathBuf>) -> App {
    let document = Document::open(path, LIMIT).unwrap();
    App::new(document, Engine::start(cpu::ENTRY, None, || ()), Session::new(recovery), LIMIT)
}

pub fn harness(app: App) -> Harness<'static, App> {
    Harness::builder().with_size(vec2(1150.0, 760.0)).build_ui_state(|ui, app: &mut App| app.ui(ui), app)
}

pub fn open() -> (tempfile::TempDir, Harness<'static, App>) {
    let (folder, path) = folder();
    let mut harness = harness(app(&path, None));
    settle(&mut harness);
    (folder, harness)
}

/// Frames until the picture is the final one.
pub fn settle(harness: &mut Harness<App>) {
    let start = Instant::now();
    harness.step();
    harness.step();
    while !harness.state().is_settled() {
        harness.step();
        std::thread::sleep(Duration::from_millis(5));
        assert!(start.elapsed() < Duration::from_secs(120), "{:?}", harness.state().model.notice.as_ref().map(|n| &n.words));
    }
    harness.step();
}

/// Frames until something is so.
pub fn until(harness: &mut Harness<App>, so: impl Fn(&Harness<App>) -> bool) {
    let start = Instant::now();
    while !so(harness) {
        harness.step();
        std::thread::sleep(Duration::from_millis(5));
        assert!(start.elapsed() < Duration::from_secs(60), "{}", notice(harness));
    }
}

/// Mean radiance of each band.
pub fn means(harness: &Harness<App>) -> Vec<f64> {
    let shown = harness.state().model.shown.as_ref().unwrap();
    let image = &shown.pictures[0].image;
    (0..image.bands.len()).map(|b| image.band(b).sum::<f64>() / (image.width * image.height) as f64).collect()
}

pub fn notice<'a>(harness: &'a Harness<App>) -> &'a str {
    harness.state().model.notice.as_ref().map_or("", |n| &n.words)
}

/// The picture's place in the window.
pub fn viewport(harness: &Harness<App>) -> Rect {
    harness.get_by_role_and_label(Role::Image, "picture").rect()
}

pub fn drag(harness: &mut Harness<App>, button: PointerButton, from: Pos2, to: Pos2) {
    let press = |harness: &mut Harness<App>, pos, pressed| {
        harness.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
    };
    harness.hover_at(from);
    harness.step();
    press(harness, from, true);
    harness.step();
    for i in 1..=4 {
        harness.hover_at(from + (to - from) * (i as f32 / 4.0));
        harness.step();
    }
    press(harness, to, false);
    harness.step();
}
