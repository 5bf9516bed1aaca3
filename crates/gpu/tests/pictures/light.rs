//! Scenes that are tried, and their light on either processor.

use barnard::backend::RenderStats;
use barnard::control::Control;
use barnard::image::relative_rms;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planned, Planner, Stepping};
use barnard::scene::Scene;
use barnard_gpu::{DeviceMarch, Gpu, Tuning};

/// Tolerance between pictures with the given number of samples per voxel: 16-bit volumes, the device's own interpolation, and what
/// finite steps still cost.
pub const TOLERANCE: f64 = 1e-3;

pub const FINE: Stepping = Stepping::PerVoxel(10.0);

/// Plan of a scene whose picture is `edge` pixels wide.
pub fn plan(scene: &Scene, edge: usize) -> Planned {
    let shape = scene.camera.height as f64 / scene.camera.width as f64;
    let scene = scene.clone().with_camera(scene.camera.clone().with_size(edge, (edge as f64 * shape) as usize));
    let options = Options::within(DEFAULT_LIMIT);
    Planner::new(&options).plan(scene, None, &Control::default()).unwrap()
}

/// Radiance and statistics by the device.
pub fn on(gpu: &Gpu, plan: &Planned) -> (Vec<f32>, RenderStats) {
    DeviceMarch::new(gpu, plan, Tuning::default()).unwrap().radiance(&Control::default()).unwrap()
}

/// The relative rms difference of the worst band.
pub fn difference(plan: &Planned, ours: &[f32], theirs: &[f32]) -> f64 {
    let pixels = plan.camera().width * plan.camera().height;
    let bands = ours.chunks(pixels).zip(theirs.chunks(pixels));
    bands.map(|(a, b)| relative_rms(a.iter().zip(b).map(|(a, b)| (f64::from(*a), f64::from(*b))))).fold(0.0, f64::max)
}

pub fn parsed(text: &str) -> Scene {
    barnard_files::parse("test.toml", "test", text.to_owned(), &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap()
}

pub const CAMERA: &str = r#"bands = ["johnson-B", "johnson-V"]
[camera]
kind = "perspective"
position = "0.3 0.2 4 pc"
field_of_view = "40 deg"
size = [24, 24]
"#;

pub const DUST: &str = r#"[field.ball]
kind = "sphere"
radius = "1 pc"
[dust]
density = "ball"
scale = "2 /pc"
law = "ccm89"
albedo = 0.6
"#;

pub const STAR: &str = r#"[[star]]
kind = "blackbody"
position = "0.2 0.5 0.3 pc"
temperature = "9000 K"
luminosity = "100 Lsun"
visible = false
"#;

/// Gathered stars: places and temperatures that look like chance.
pub fn many_lights(count: usize) -> String {
    let part = |i: usize, step: f64| (step * (i + 1) as f64).fract();
    let star = |i: usize| {
        let place = [0.618_034, 0.414_214, 0.732_051].map(|step| 1.2 * part(i, step) - 0.6);
        STAR.replace("0.2 0.5 0.3", &format!("{:.4} {:.4} {:.4}", place[0], place[1], place[2]))
            .replace("9000 K", &format!("{} K", 4000 + 700 * (i % 20)))
    };
    (0..count).map(star).collect()
}
