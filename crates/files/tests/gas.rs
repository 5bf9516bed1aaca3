//! Gas of a scene that its stars ionise.

use barnard::memory::DEFAULT_LIMIT;
use barnard::scene::{Loader, Scene};
use ionisation::balance::{Accuracy, Diffuse};
use ionisation::benchmarks::BENCHMARKS;

const PARSEC_CM: f64 = 3.085_677_581e18;

fn parsed(gas: &str, star: &str, loader: &Loader) -> Result<Scene, String> {
    let text = format!(
        "bands = [\"hst-wfc3-f502n\", \"hst-wfc3-f656n\", \"hst-wfc3-f658n\", \"hst-wfc3-f673n\"]\n\
         [camera]\nkind = \"perspective\"\nposition = \"0 0 30 pc\"\nfield_of_view = \"25 deg\"\nsize = [24, 24]\n\
         [field.ball]\nkind = \"sphere\"\nradius = \"5.3 pc\"\n[field.hole]\nkind = \"sphere\"\nradius = \"0.972 pc\"\n\
         [gas]\ndensity = \"100 * ball * (1 - hole)\"\n{gas}\n[[star]]\nposition = \"0 0 0 pc\"\nkind = \"blackbody\"\n{star}\n"
    );
    barnard_files::parse("gas.toml", "gas", text, loader).map_err(|e| e.to_string())
}

/// The benchmark HII40 as a scene: its lines have the power that the sphere has.
#[test]
fn scenes_have_the_lines_of_their_gas() {
    let loader = barnard_files::in_folder(".", DEFAULT_LIMIT);
    // 3.082e39 erg/s.
    let star = "temperature = \"40000 K\"\nluminosity = \"8.05e5 Lsun\"";
    let scene = parsed("abundances = \"hii40\"\nvoxels = 64", star, &loader).unwrap();
    let sphere = BENCHMARKS[0].sphere(Diffuse::Outward, &Accuracy::REFERENCE);
    let names: Vec<&str> = scene.emission.iter().map(|species| species.name.as_str()).collect();
    for label in ["Ba3-2", "[OIII]5007", "[NII]6584", "[SII]6716", "[SII]6731"] {
        let species = scene.emission.iter().find(|species| species.name == label).unwrap_or_else(|| panic!("{label}: {names:?}"));
        let grid = species.density.grid().unwrap();
        let volume = (grid.lattice().voxel_pc() * PARSEC_CM).element_product();
        let power = grid.values().iter().map(|v| f64::from(*v)).sum::<f64>() * volume;
        let part = power / sphere.line(label);
        println!("{label}: {part:.4}");
        assert!((part - 1.0).abs() < 0.03, "{label}: {part}");
    }
    // What is not seen is not there, but for the continuum, which is everywhere.
    assert!(!names.contains(&"[OII]3729") && names.contains(&"hydrogen's continuum"), "{names:?}");
    // The same scene again is what was made before; with another star it is not.
    let grid = |scene: &Scene| scene.emission[0].density.clone();
    assert!(std::sync::Arc::ptr_eq(&grid(&scene), &grid(&parsed("abundances = \"hii40\"\nvoxels = 64", star, &loader).unwrap())));
    let colder = parsed("abundances = \"hii40\"\nvoxels = 24", &star.replace("40000", "20000"), &loader).unwrap();
    let mean = |scene: &Scene, label: &str| {
        let species = scene.emission.iter().find(|species| species.name == label);
        species.map_or(0.0, |species| {
            let values = species.density.grid().unwrap().values().into_owned();
            values.iter().sum::<f32>() / values.len() as f32
        })
    };
    // A star of 20 000 K has next to no photons that make O²⁺.
    assert!(mean(&colder, "[OIII]5007") < 0.01 * mean(&scene, "[OIII]5007") && mean(&colder, "[NII]6584") > 0.0);
}

/// What is wrong is refused with its place.
#[test]
fn bad_gas_is_refused() {
    let loader = barnard_files::in_folder(".", DEFAULT_LIMIT);
    let star = "temperature = \"40000 K\"\nluminosity = \"1e5 Lsun\"";
    for (gas, word) in [
        ("abundances = \"mars\"", "orion"),
        ("abundances = [1, 2]", "six numbers"),
        ("abundances = [0.1, 0.5, 0, 0, 0, 0]", "nuclei of C"),
        ("voxels = 4", "voxels"),
        ("colour = 1", "unknown key"),
        ("voxels = 2000", "MiB"),
    ] {
        let message = parsed(gas, star, &loader).map(|_| ()).unwrap_err();
        assert!(message.contains(word) && message.contains("gas"), "{message}");
    }
    // A cool star ionises nothing, and there is no more to it.
    let dark = parsed("voxels = 16", "temperature = \"3000 K\"\nluminosity = \"10 Lsun\"", &loader).unwrap();
    assert!(dark.emission.iter().all(|species| species.density.grid().unwrap().values().iter().all(|v| *v < 1e-25)));
}
