//! Scenes of tests, and their plans.

use barnard::control::Control;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Plan};
use barnard::scene::Scene;

pub fn plan_of(scene: &Scene) -> Plan {
    let options = Options::within(DEFAULT_LIMIT);
    Plan::sampled(scene, &options, 40, &Control::default()).unwrap()
}

/// The cloud of these tests with so many voxels along an edge.
pub fn scene(bake: usize, method: &str) -> Scene {
    parsed(text(bake, method))
}

pub fn parsed(text: String) -> Scene {
    barnard_files::parse("test.toml", "test", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap()
}

pub fn text(bake: usize, method: &str) -> String {
    format!(
        "bands = [\"cie-x\", \"cie-y\"]\n[camera]\nkind = \"perspective\"\nposition = \"0.3 0.2 4 pc\"\nfield_of_view = \"40 deg\"\nsize = [48, 32]\n\
         [field.ball]\nkind = \"fbm\"\nradius = \"1 pc\"\nwarp = \"0.2 pc\"\nvariant = \"ridged\"\n[field.knot]\nkind = \"sphere\"\nradius = \"0.3 pc\"\ncentre = \"0.9 0 0.2 pc\"\n\
         [dust]\ndensity = \"ball\"\nscale = \"2 /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0.6\nphase = {{ kind = \"henyey_greenstein\", g = 0.6 }}\n\
         [[star]]\nkind = \"blackbody\"\nposition = \"0.2 0.5 0.3 pc\"\ntemperature = \"9000 K\"\nluminosity = \"100 Lsun\"\n\
         [[star]]\nkind = \"blackbody\"\nposition = \"-0.3 -0.2 0.1 pc\"\ntemperature = \"4000 K\"\nluminosity = \"100 Lsun\"\n\
         [[emission]]\nname = \"H I\"\nkind = \"ion\"\nion = \"H1\"\ndensity = \"1e3 * knot\"\ntemperature = \"8000 K\"\nelectron_density = \"300 cm-3\"\n\
         [method]\nbake = {bake}\n{method}\n"
    )
}
