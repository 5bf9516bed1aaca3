//! Gas of a scene that its stars ionise.

use std::sync::Arc;

use barnard::Control;
use barnard::backend::cpu;
use barnard::field::Grid;
use barnard::geometry::Bounds;
use barnard::glam::DVec3;
use barnard::image::relative_rms;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planner, Stepping};
use barnard::scene::{Gas, Loader, Scene};
use barnard::spectra::units::Temperature;
use barnard_files::formats::{GridFile, save_grid};
use ionisation::balance::{Accuracy, Diffuse};
use ionisation::benchmarks::BENCHMARKS;

const PARSEC_CM: f64 = 3.085_677_581e18;

fn parsed(gas: &str, star: &str, loader: &Loader) -> Result<Scene, String> {
    let text = format!(
        r#"bands = ["hst-wfc3-f502n", "hst-wfc3-f656n", "hst-wfc3-f658n", "hst-wfc3-f673n"]
[camera]
kind = "perspective"
position = "0 0 30 pc"
field_of_view = "25 deg"
size = [24, 24]
[field.ball]
kind = "sphere"
radius = "5.3 pc"
[field.hole]
kind = "sphere"
radius = "0.972 pc"
[gas]
density = "100 * ball * (1 - hole)"
{gas}
[[star]]
position = "0 0 0 pc"
kind = "blackbody"
{star}
"#
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
    let names: Vec<&str> = scene.species().iter().map(|species| species.name.as_str()).collect();
    for label in ["Ba3-2", "[OIII]5007", "[NII]6584", "[SII]6716", "[SII]6731"] {
        let species = scene.species().iter().find(|species| species.name == label).unwrap_or_else(|| panic!("{label}: {names:?}"));
        let grid = species.density.grid().unwrap();
        let volume = (grid.lattice().voxel_pc() * PARSEC_CM).element_product();
        let power = grid.voxel_means().values().iter().map(|v| f64::from(*v)).sum::<f64>() * volume;
        let part = power / sphere.line(label);
        println!("{label}: {part:.4}");
        assert!((part - 1.0).abs() < 0.03, "{label}: {part}");
    }
    // What is not seen is not there, but for the continuum, which is everywhere.
    assert!(!names.contains(&"[OII]3729") && names.contains(&"hydrogen's continuum"), "{names:?}");
    // The same scene again is what was made before; with another star it is not.
    let grid = |scene: &Scene| scene.species()[0].density.clone();
    assert!(std::sync::Arc::ptr_eq(&grid(&scene), &grid(&parsed("abundances = \"hii40\"\nvoxels = 64", star, &loader).unwrap())));
    let colder = parsed("abundances = \"hii40\"\nvoxels = 24", &star.replace("40000", "20000"), &loader).unwrap();
    let mean = |scene: &Scene, label: &str| {
        let species = scene.species().iter().find(|species| species.name == label);
        species.map_or(0.0, |species| {
            let values = species.density.grid().unwrap().voxel_means().values().into_owned();
            values.iter().sum::<f32>() / values.len() as f32
        })
    };
    // All of it at one temperature, its own light on the spot.
    let isothermal = parsed("temperature = \"9000 K\"\ndiffuse = \"on_the_spot\"\nvoxels = 24", star, &loader).unwrap();
    let temperature = isothermal.ionised().and_then(|gas| gas.temperature).unwrap();
    assert!((temperature / 9000.0 - 1.0).abs() < 1e-3, "{temperature}");
    let hotter = parsed("temperature = \"12000 K\"\ndiffuse = \"on_the_spot\"\nvoxels = 24", star, &loader).unwrap();
    assert!(mean(&hotter, "[OIII]5007") > 1.5 * mean(&isothermal, "[OIII]5007"));
    // A star of 20 000 K has next to no photons that make O²⁺.
    assert!(mean(&colder, "[OIII]5007") < 0.01 * mean(&scene, "[OIII]5007") && mean(&colder, "[NII]6584") > 0.0);
}

/// Lists of eight abundances include magnesium, lists of six do not.
#[test]
fn magnesium_is_followed() {
    let loader = barnard_files::in_folder(".", DEFAULT_LIMIT);
    let shines = |abundances: &str| {
        let text = format!(
            r#"bands = ["hst-wfc3-f280n"]
[camera]
kind = "perspective"
position = "0 0 30 pc"
field_of_view = "25 deg"
size = [24, 24]
[field.ball]
kind = "sphere"
radius = "5.3 pc"
[gas]
density = "100 * ball"
voxels = 16
abundances = {abundances}
[[star]]
position = "0 0 0 pc"
kind = "blackbody"
temperature = "40000 K"
luminosity = "8.05e5 Lsun"
"#
        );
        let scene = barnard_files::parse("gas.toml", "gas", text, &loader).unwrap();
        scene.species().iter().any(|species| species.name.starts_with("MgII"))
    };
    assert!(shines("\"orion\"") && shines("[0.1, 3e-4, 7e-5, 4e-4, 6e-5, 3e-6, 4e-6, 1e-5]"));
    assert!(!shines("[0.1, 3e-4, 7e-5, 4e-4, 6e-5, 1e-5]") && !shines("\"lmc\""));
}

/// What is wrong is refused with its place.
#[test]
fn bad_gas_is_refused() {
    let loader = barnard_files::in_folder(".", DEFAULT_LIMIT);
    let star = "temperature = \"40000 K\"\nluminosity = \"1e5 Lsun\"";
    for (gas, word) in [
        ("abundances = \"mars\"", "orion"),
        ("abundances = [1, 2]", "eight numbers"),
        ("abundances = [0.1, 0.5, 0, 0, 0, 0]", "abundance of C"),
        ("abundances = [0.1, 1e-4, 1e-4, 1e-4, 1e-4, 0.5, 1e-5, 1e-5]", "abundance of Mg"),
        ("voxels = 4", "voxels"),
        ("colour = 1", "unknown key"),
        ("voxels = 2000", "MiB"),
        ("temperature = \"100 K\"", "500 and 60000 K"),
        ("diffuse = \"nowhere\"", "on_the_spot"),
    ] {
        let message = parsed(gas, star, &loader).map(|_| ()).unwrap_err();
        assert!(message.contains(word) && message.contains("gas"), "{message}");
    }
    // A cool star ionises nothing, and there is no more to it.
    let dark = parsed("voxels = 16", "temperature = \"3000 K\"\nluminosity = \"10 Lsun\"", &loader).unwrap();
    assert!(dark.species().iter().all(|species| species.density.grid().unwrap().values().iter().all(|v| *v < 1e-25)));
}

/// A first look is on few voxels and says so; what is known whole is taken as it is; what is told names temperature and what
/// leaves; and a grid of density is gone through on more voxels than it has.
#[test]
fn first_looks_are_rough() {
    let loader = barnard_files::in_folder(".", DEFAULT_LIMIT);
    let star = "temperature = \"40000 K\"\nluminosity = \"8.05e5 Lsun\"\nname = \"the star\"";
    let text = "abundances = \"hii40\"\nvoxels = 52";
    let edge = |scene: &Scene| scene.species()[0].density.grid().unwrap().lattice().dims[0];
    let rough = parsed(text, star, &loader.roughly()).unwrap();
    let gas = rough.ionised().unwrap();
    assert!(gas.is_rough && edge(&rough) == 48, "{}", edge(&rough));
    let whole = parsed(text, star, &loader).unwrap();
    assert!(!whole.ionised().unwrap().is_rough && edge(&whole) == 52);
    let again = parsed(text, star, &loader.roughly()).unwrap();
    assert!(!again.ionised().unwrap().is_rough && edge(&again) == 52);
    let temperature = |scene: &Scene| scene.ionised().unwrap().temperature.unwrap();
    assert!((temperature(&rough) / temperature(&whole) - 1.0).abs() < 0.02, "{} {}", temperature(&rough), temperature(&whole));
    assert!(whole.ionised().unwrap().notes()[0].contains(" K and "), "{:?}", whole.ionised().unwrap().notes());
    // Ten times as bright, the star ionises all of it and has photons left.
    let bright = parsed(text, &star.replace("8.05e5", "8.05e6"), &loader.roughly()).unwrap();
    let notes = bright.ionised().unwrap().notes().join("; ");
    assert!(notes.contains("ionising photons of the star leave or miss the cloud"), "{notes}");
    let cold = parsed(text, &star.replace("40000", "1000"), &loader.roughly()).unwrap();
    assert!(cold.ionised().unwrap().notes()[0].contains("no star has photons"));
    let folder = tempfile::tempdir().unwrap();
    let bounds = Bounds { low: DVec3::splat(-1.0), high: DVec3::splat(1.0) };
    let grid = Grid::new([8; 3], bounds, vec![1.0; 512]).unwrap();
    let file = GridFile { grid: &grid, unit: None, name: "n", memory_limit: DEFAULT_LIMIT };
    save_grid(&folder.path().join("n.npy"), &file).unwrap();
    let scene = r#"bands = ["hst-wfc3-f656n"]
[camera]
kind = "perspective"
position = "0 0 9 pc"
field_of_view = "25 deg"
size = [8, 8]
[field.n]
kind = "grid"
file = "n.npy"
axes = "zyx"
factor = 100
low = "-1 -1 -1 pc"
high = "1 1 1 pc"
[gas]
density = "n"
voxels = 20
[[star]]
kind = "blackbody"
position = "0 0 0 pc"
temperature = "40000 K"
luminosity = "1e4 Lsun"
"#;
    let in_folder = barnard_files::in_folder(folder.path(), DEFAULT_LIMIT);
    let parse = |text: &str| barnard_files::parse("n.toml", "n", text.to_owned(), &in_folder).unwrap();
    assert_eq!(edge(&parse(scene)), 20);
    assert_eq!(edge(&parse(&scene.replace("voxels = 20\n", ""))), 8);
}

/// Gas of a film is solved at moments between which a star moves by no more than a voxel. Frames are a B-spline of knots five frames apart,
/// each the mean of its solutions; solved for each frame, gas would jump with the voxels.
#[test]
fn gas_of_films_is_a_curve_of_moments() {
    let loader = barnard_files::in_folder(".", DEFAULT_LIMIT);
    let scene = |changes: &str, x: f64, time: f64| {
        let text = format!(
            r#"bands = ["hst-wfc3-f656n"]
[camera]
kind = "perspective"
position = "0 0 30 pc"
field_of_view = "25 deg"
size = [8, 8]
[field.ball]
kind = "sphere"
radius = "5.3 pc"
[gas]
density = "60 * ball"
voxels = 24
[[star]]
position = "{x} 0.1 0.2 pc"
kind = "blackbody"
temperature = "38000 K"
luminosity = "1e5 Lsun"
{changes}"#
        );
        barnard_files::parse("film.toml", "film", text, &loader.at(time)).unwrap()
    };
    // The star moves by a quarter of a voxel (10.6 pc / 24) per frame: a knot is the mean of two solutions.
    let film = r#"[[animation]]
of = "star[0].position"
times = ["0 s", "2 s"]
values = ["0 0.1 0.2 pc", "1.76 0.1 0.2 pc"]
interpolation = "linear"
[sequence]
frames_per_second = 8
"#;
    let glow = |scene: &Scene| {
        let species = scene.species().iter().find(|species| species.name == "Ba3-2").unwrap();
        species.density.grid().unwrap().voxel_means().values().into_owned()
    };
    let solved = |knot: f64, place: f64| glow(&scene("", (0.55 * (knot + place)).clamp(0.0, 1.76), 0.0));
    let knot = |k: i32| -> Vec<f32> {
        let [before, after] = [-0.25, 0.25].map(|place| solved(f64::from(k), place));
        before.iter().zip(&after).map(|(a, b)| 0.5 * (a + b)).collect()
    };
    let solved: Vec<Vec<f32>> = (0..4).map(knot).collect();
    let all: f32 = solved[0].iter().sum();
    let apart = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>() / all;
    let knots = apart(&solved[1], &solved[2]);
    for (frame, nearest, s) in [(5, 1, 0.0f32), (6, 1, 0.2), (9, 2, -0.2), (10, 2, 0.0)] {
        let light_here = glow(&scene(film, 0.0, f64::from(frame) / 8.0));
        let weights = [0.5 * (0.5 - s).powi(2), 0.75 - s * s, 0.5 * (0.5 + s).powi(2)];
        let wanted: Vec<f32> = (0..light_here.len()).map(|i| (0..3).map(|j| weights[j] * solved[nearest + j - 1][i]).sum()).collect();
        // Fronts of a mean are sharper than a mean of fronts.
        let far = apart(&light_here, &solved[3 - nearest]);
        assert!(apart(&light_here, &wanted) < 0.2 * knots && far > 0.6 * knots, "{frame}: {} {far} {knots}", apart(&light_here, &wanted));
    }
}

/// Webb's bands see gas, and say what of dust and molecules is missing.
#[test]
fn gas_is_seen_in_the_infrared() {
    let loader = barnard_files::in_folder(".", DEFAULT_LIMIT);
    let seen = |band: &str| {
        let text = format!(
            r#"bands = ["{band}"]
[camera]
kind = "perspective"
position = "0 0 30 pc"
field_of_view = "25 deg"
size = [8, 8]
[field.ball]
kind = "sphere"
radius = "5.3 pc"
[gas]
density = "60 * ball"
voxels = 16
[[star]]
position = "0 0 0 pc"
kind = "blackbody"
temperature = "38000 K"
luminosity = "1e5 Lsun"
"#
        );
        barnard_files::parse("ir.toml", "ir", text, &loader).unwrap()
    };
    for (band, line) in [
        ("jwst-nircam-f405n", "Br5-4"),
        ("jwst-nircam-f466n", "Pf7-5"),
        ("jwst-miri-f770w", "Pf6-5"),
        ("jwst-miri-f1280w", "[NeII]12.81um"),
    ] {
        let scene = seen(band);
        let names: Vec<&str> = scene.species().iter().map(|species| species.name.as_str()).collect();
        assert!(scene.species().iter().any(|species| species.name == line), "{band}: {names:?}");
        assert!(names.contains(&"hydrogen's continuum"), "{band}: {names:?}");
        let control = barnard::control::Control::default();
        let plan = barnard::plan::Planner::new(&barnard::plan::Options::within(DEFAULT_LIMIT)).plan(&scene, None, &control).unwrap();
        let picture = barnard::backend::Renderer::new(&mut barnard::backend::cpu::Cpu).render(&plan, &control).unwrap().0;
        assert!(picture.band(0).any(|value| value > 0.0), "{band}");
        assert!(barnard::backend::left_out(&scene).unwrap().contains("H2"));
    }
    assert_eq!(barnard::backend::left_out(&seen("hst-wfc3-f656n")), None);
}

/// Gas made of objects glows as that of a file, bit by bit, and is solved again when what it depends on changes, and only then.
#[test]
fn objects_make_the_gas_that_a_file_makes() {
    let star = "temperature = \"40000 K\"\nluminosity = \"8.05e5 Lsun\"";
    let read = parsed("voxels = 16", star, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap();
    let values = |scene: &Scene| -> Vec<Vec<f32>> {
        scene.species().iter().map(|species| species.density.grid().unwrap().values().into_owned()).collect()
    };
    // The file's density on its voxels.
    let cloud = &read.ionised().unwrap().cloud;
    let gas = Gas::new(Grid::from_lattice(cloud.lattice.clone(), cloud.hydrogen.clone()));
    let with_gas = |gas: &Gas| read.edited(|spec| spec.gas = Some(gas.clone()));
    let made = with_gas(&gas).unwrap();
    let names = |scene: &Scene| scene.species().iter().map(|species| species.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&made), names(&read));
    assert!(!Arc::ptr_eq(made.ionised().unwrap(), read.ionised().unwrap()) && values(&made) == values(&read));
    // Another temperature, another star and fewer passbands.
    let colder = with_gas(&gas.clone().with_temperature(Temperature(6000.0))).unwrap();
    assert!(colder.species().len() <= made.species().len() && values(&colder) != values(&made));
    let moved = made.edited(|spec| spec.stars[0].position.x += 1.0).unwrap();
    assert!(values(&moved) != values(&made));
    let narrow = made.edited(|spec| *spec = spec.clone().with_bands(spec.bands[..1].to_vec())).unwrap();
    assert!(narrow.species().len() < made.species().len());
    // A display is no matter, nor is a star that moves there and back.
    let brighter = made.edited(|spec| spec.display.white = barnard::image::Level::Radiance(1.0)).unwrap();
    assert!(Arc::ptr_eq(brighter.ionised().unwrap(), made.ionised().unwrap()));
    assert!(values(&moved.edited(|spec| spec.stars[0].position.x -= 1.0).unwrap()) == values(&made));
    // What no file may say is refused.
    let mut metals = gas.abundances;
    metals[4] = -1e-4;
    let bad = [gas.clone().with_voxels(0), gas.clone().with_dust_absorption(f64::NAN), gas.clone().with_abundances(metals)];
    for gas in bad.into_iter().chain([gas.clone().with_temperature(Temperature(-1.0))]) {
        let refused = with_gas(&gas).err().map(|error| error.to_string());
        assert!(refused.as_ref().is_some_and(|words| words.contains("must be") || words.contains("out of range")), "{refused:?}");
    }
}

/// The reference and the processor see the same fronts, which differ from a picture of voxel means.
#[test]
fn back_ends_agree_on_fronts() {
    let loader = barnard_files::in_folder(".", DEFAULT_LIMIT);
    let star = "temperature = \"40000 K\"\nluminosity = \"4e5 Lsun\"\nvisible = false";
    let scene = parsed("voxels = 24", star, &loader).unwrap();
    let grids = || scene.species().iter().map(|gas| gas.density.grid().unwrap());
    assert!(grids().all(|grid| grid.front().is_some()));
    let truth = barnard::render_reference(&scene, 1e-4, &Control::default()).unwrap();
    let truth: Vec<f64> = (0..truth.samples.len()).map(|i| truth.samples.at(i)).collect();
    let on_cpu = |scene: &Scene| {
        let plan = Planner::new(&Options::default()).plan(scene, None, &Control::default()).unwrap();
        cpu::radiance(&plan.with_stepping(Stepping::PerVoxel(16.0)), &Control::default()).unwrap().0
    };
    let off = |picture: Vec<f32>| relative_rms(picture.into_iter().map(f64::from).zip(truth.iter().copied()));
    let mut means = scene.as_lights();
    means.emission.iter_mut().for_each(|gas| gas.density = Arc::new(gas.density.grid().unwrap().voxel_means()));
    let (fronts, means) = (off(on_cpu(&scene)), off(on_cpu(&means.build().unwrap())));
    assert!(fronts < 1e-3 && means > 0.01, "{fronts} {means}");
}
