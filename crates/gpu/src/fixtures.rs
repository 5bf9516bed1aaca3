//! Scenes of tests, and their plans.

use barnard::control::Control;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planned, Planner, Quality};
use barnard::scene::Scene;

pub fn plan_of(scene: &Scene) -> Planned {
    let options = Options::within(DEFAULT_LIMIT);
    Planner::new(&options).with_quality(Quality::Fixed(40)).plan(scene, None, &Control::default()).unwrap()
}

/// The cloud of these tests with a given number of voxels along an edge.
pub fn scene(bake: usize, method: &str) -> Scene {
    parsed(text(bake, method))
}

pub fn parsed(text: String) -> Scene {
    barnard_files::parse("test.toml", "test", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap()
}

pub fn text(bake: usize, method: &str) -> String {
    format!(
        r#"bands = ["cie-x", "cie-y"]
[camera]
kind = "perspective"
position = "0.3 0.2 4 pc"
field_of_view = "40 deg"
size = [48, 32]
[field.ball]
kind = "fbm"
radius = "1 pc"
warp = "0.2 pc"
variant = "ridged"
[field.knot]
kind = "sphere"
radius = "0.3 pc"
centre = "0.9 0 0.2 pc"
[dust]
density = "ball"
scale = "2 /pc"
law = "inverse_wavelength"
albedo = 0.6
phase = {{ kind = "henyey_greenstein", g = 0.6 }}
[[star]]
kind = "blackbody"
position = "0.2 0.5 0.3 pc"
temperature = "9000 K"
luminosity = "100 Lsun"
[[star]]
kind = "blackbody"
position = "-0.3 -0.2 0.1 pc"
temperature = "4000 K"
luminosity = "100 Lsun"
[[emission]]
name = "H I"
kind = "ion"
ion = "H1"
density = "1e3 * knot"
temperature = "8000 K"
electron_density = "300 cm-3"
[method]
bake = {bake}
{method}
"#
    )
}
