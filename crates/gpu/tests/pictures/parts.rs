//! Every scene, part and method: the same plan, the same light.

use barnard::backend::cpu;
use barnard::control::Control;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planner, Quality, Stepping};
use barnard::scene::Loader;
use barnard_gpu::{DeviceMarch, Tuning};

use super::light::{CAMERA, DUST, FINE, STAR, TOLERANCE, difference, many_lights, on, parsed, plan};
use super::test_device::device;

/// Every built-in scene, its clouds on few voxels: with fine steps the same light, with the plan's own, which a packet of sixteen rays shares on
/// the processor, to its accuracy.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn pictures_are_those_of_the_processor() {
    let gpu = device();
    // Real devices weigh voxels in 256ths: half of one is what filaments that are thinner than voxels may be off by, on each axis.
    let tolerance = if gpu.adapter.real { 2.0 * TOLERANCE } else { TOLERANCE };
    for builtin in barnard_files::builtin::SCENES.iter().filter(|scene| scene.needs.is_none()) {
        let scene = barnard_files::builtin::load_by(builtin.name, DEFAULT_LIMIT, Loader::roughly).unwrap();
        let planned = plan(&scene, 32);
        let accuracy = planned.spectral().accuracy;
        // A ray that all but hits a gathered star sees dust between the ends of its step there: all rays take the same.
        let many_lights = planned.space().many_lights.is_some();
        let length_pc = planned.space().dust.as_ref().map_or(0.0, |dust| dust.lattice().bounds.size().length());
        let shared = |s: Stepping| if many_lights { Stepping::Fixed(s.steps(length_pc, planned.space().voxel_pc())) } else { s };
        let (stepping, fine) = (shared(planned.stepping()), shared(FINE));
        let fine = planned.with_stepping(fine);
        let (theirs, found) = cpu::radiance(&fine, &Control::default()).unwrap();
        let (ours, ours_found) = on(&gpu, &fine);
        let wrong = difference(&fine, &ours, &theirs);
        assert!(wrong < tolerance, "{}: {wrong:e}", builtin.name);
        // Rays of a packet end together, those of the GPU each by itself: they need not go as deep.
        let deep = ours_found.depth / found.depth;
        let is_clear = (ours_found.depth, found.depth) == (0.0, 0.0);
        // Behind a depth of 20, e^-20 of the light is left: where a ray ends there is no matter.
        let is_dark = ours_found.depth > 20.0 && deep < 1.01;
        assert!((deep > 0.9 && deep < 1.01) || is_clear || is_dark, "{}: {} {}", builtin.name, ours_found.depth, found.depth);
        // A hundredth more light would be seen.
        let more: Vec<f32> = theirs.iter().map(|v| 1.01 * v).collect();
        assert!(difference(&fine, &ours, &more) > 2.0 * TOLERANCE);
        let planned = fine.with_stepping(stepping);
        let theirs = cpu::radiance(&planned, &Control::default()).unwrap().0;
        let ours = on(&gpu, &planned).0;
        let wrong = difference(&planned, &ours, &theirs);
        assert!(wrong < accuracy.max(tolerance), "{}: {wrong:e} of {accuracy:e}", builtin.name);
    }
}

/// Gas that ends within the dust, a background, spectral and forward scattering, far and near cameras: each by itself,
/// with a sample in each segment and with two.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn each_part_is_that_of_the_processor() {
    let gpu = device();
    // Glowing gas on a finer lattice that reaches out of the dust.
    let gas = r#"[field.knot]
kind = "sphere"
radius = "0.7 pc"
centre = "0.6 0 0.2 pc"
[[emission]]
name = "H I"
kind = "ion"
ion = "H1"
density = "1e4 * knot"
temperature = "8000 K"
electron_density = "300 cm-3"
"#;
    let behind = r#"[background]
kind = "blackbody"
temperature = "4000 K"
radiance = "2.5e-8 W/m2/sr/um"
"#;
    let forward = "phase = { kind = \"henyey_greenstein\", g = 0.7 }\n";
    let spectral = DUST.replace("ccm89", "draine03_rv31") + "phase = { kind = \"henyey_greenstein\" }\n";
    let far = CAMERA.replace("4 pc", "4000 pc").replace("40 deg", "0.04 deg");
    let inside = CAMERA.replace("0.3 0.2 4 pc", "0.3 0.2 0.4 pc").replace("40 deg", "90 deg");
    let flat =
        CAMERA.replace("kind = \"perspective\"", "kind = \"orthographic\"").replace("field_of_view = \"40 deg\"", "width = \"2.5 pc\"");
    let method = "[method]\nbake = 24\n";
    let lobes = DUST.replace("density = \"ball\"", "density = \"ball * max(0, 4 * x * y - 1)\"");
    let pages = r#"[method]
bake = 60
sparse = "always"
"#;
    for (name, text) in [
        ("plain", format!("{CAMERA}{DUST}{STAR}{method}")),
        ("forward", format!("{CAMERA}{DUST}{forward}{STAR}{method}")),
        ("far", format!("{far}{DUST}{STAR}{method}")),
        ("inside", format!("{inside}{DUST}{STAR}{method}")),
        ("orthographic", format!("{flat}{DUST}{STAR}{method}")),
        ("supersampled", format!("{}{DUST}{STAR}{method}", CAMERA.replace("size", "supersampling = 2\nsize"))),
        ("gas", format!("{CAMERA}{DUST}{STAR}{gas}{method}")),
        ("background", format!("{CAMERA}{DUST}{STAR}{behind}{method}")),
        ("spectral", format!("{CAMERA}{spectral}{STAR}{method}")),
        ("multiple scattering", format!("{CAMERA}{DUST}{forward}{STAR}{gas}{method}bounces = 4\n")),
        ("shared nodes", format!("{CAMERA}{spectral}{STAR}{gas}{behind}{method}name = \"common_nodes\"\n")),
        // More sums than registers hold.
        ("shared nodes of six stars", format!("{CAMERA}{spectral}{STAR}{}{gas}{behind}{method}name = \"common_nodes\"\n", many_lights(5))),
        ("dark", format!("{CAMERA}{DUST}{method}")),
        ("pages", format!("{CAMERA}{lobes}{STAR}{pages}")),
        ("pages of dust and of gas", format!("{CAMERA}{lobes}{STAR}{gas}{pages}bounces = 3\n")),
    ] {
        let scene = parsed(&text);
        let planned = plan(&scene, 24);
        assert_eq!(name.contains("pages"), planned.space().volumes.iter().any(|volume| volume.pages().count() > 1), "{name}");
        for stepping in [FINE, Stepping::Paired(5.0)] {
            let plan = planned.clone().with_stepping(stepping);
            let theirs = cpu::radiance(&plan, &Control::default()).unwrap().0;
            let ours = on(&gpu, &plan).0;
            let wrong = difference(&plan, &ours, &theirs);
            assert!(wrong < TOLERANCE, "{name}, {stepping}: {wrong:e}");
            assert_eq!(name == "dark", theirs.iter().all(|v| *v == 0.0), "{name}");
        }
    }
}

/// Detail below voxels, of dust and gas, with samples at the ends of segments and in their middles too, for cameras whose pixels
/// grow along a ray and for one whose pixels do not.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn detail_is_that_of_the_processor() {
    const GAS: &str = r#"[field.core]
kind = "sphere"
radius = "0.6 pc"
[[emission]]
name = "H I"
kind = "ion"
ion = "H1"
density = "2e6 * core"
temperature = "8000 K"
electron_density = "300 cm-3"
"#;
    const METHOD: &str = "[method]\nbake = 24\n[detail]\nstrength = 0.08\n";
    let gpu = device();
    let near = CAMERA.replace("40 deg", "9 deg");
    let flat = CAMERA.replace("perspective", "orthographic").replace("field_of_view = \"40 deg\"", "width = \"0.6 pc\"");
    for (camera, stepping) in [(&near, FINE), (&near, Stepping::Paired(3.0)), (&flat, Stepping::PerVoxel(2.0))] {
        let text = format!("{camera}{DUST}{STAR}{GAS}");
        let detailed = plan(&parsed(&format!("{text}{METHOD}")), 24).with_stepping(stepping);
        let plain = plan(&parsed(&text.replace("[field.core]", "[method]\nbake = 24\n[field.core]")), 24).with_stepping(stepping);
        let (theirs, without) =
            (cpu::radiance(&detailed, &Control::default()).unwrap().0, cpu::radiance(&plain, &Control::default()).unwrap().0);
        let (wrong, changed) = (difference(&detailed, &on(&gpu, &detailed).0, &theirs), difference(&detailed, &without, &theirs));
        println!("{stepping}: {wrong:.2e}, detail changes {changed:.2e}");
        assert!(wrong < 2.0 * TOLERANCE && changed > 20.0 * wrong, "{stepping}: {wrong:e} {changed:e}");
    }
}

/// Noise evaluated at every sample gives the picture of noise that was sampled, closer the finer it was; what is no
/// noise is refused.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn noise_on_the_fly_is_noise_that_was_sampled() {
    let gpu = device();
    let cloud = r#"[field.ball]
kind = "fbm"
radius = "1 pc"
scale = "0.8 pc"
octaves = 3
offset = 0.6
[dust]
density = "ball"
scale = "2 /pc"
law = "ccm89"
albedo = 0.6
"#;
    let on_the_fly = Tuning { on_the_fly: true, ..Tuning::default() };
    let wrong = [12, 24, 48].map(|bake| {
        let scene = parsed(&format!("{CAMERA}{cloud}{}[method]\nbake = {bake}\n", STAR.replace("0.2 0.5 0.3", "1.5 1.2 1.4")));
        let plan = plan(&scene, 12).with_stepping(Stepping::Fixed(100));
        let ours = DeviceMarch::new(&gpu, &plan, on_the_fly).unwrap().radiance(&Control::default()).unwrap().0;
        difference(&plan, &ours, &on(&gpu, &plan).0)
    });
    println!("{wrong:?}");
    assert!(wrong[2] < 0.02 && wrong[2] < 0.5 * wrong[1] && wrong[1] < 0.5 * wrong[0] && wrong[2] > 0.0, "{wrong:?}");
    let scene = parsed(&format!("{CAMERA}{DUST}{STAR}[method]\nbake = 16\n"));
    let error = DeviceMarch::new(&gpu, &plan(&scene, 24), on_the_fly).err().unwrap().to_string();
    assert!(error.contains("fbm") && error.contains("remove it to sample"), "{error}");
}

/// Stars whose light is gathered, scattered evenly, by one phase function and by one for each wavelength, seen from
/// near and from infinity.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn many_lights_are_those_of_the_processor() {
    let gpu = device();
    let method = "[method]\nbake = 24\naccuracy = 1e-3\n";
    let aside =
        CAMERA.replace("kind = \"perspective\"", "kind = \"orthographic\"").replace("field_of_view = \"40 deg\"", "width = \"3 pc\"");
    let cases = [
        (CAMERA.to_owned(), ""),
        (CAMERA.to_owned(), "phase = { kind = \"henyey_greenstein\", g = 0.7 }\n"),
        (aside, "phase = { kind = \"draine\", g = 0.6, alpha = 0.5 }\n"),
        (CAMERA.to_owned(), "phase = { kind = \"henyey_greenstein\" }\nlaw = \"draine03_rv31\"\n"),
    ];
    for (camera, phase) in cases {
        let dust = if phase.contains("law") { DUST.replace("law = \"ccm89\"\nalbedo = 0.6\n", "") } else { DUST.to_owned() };
        let scene = parsed(&format!("{camera}{dust}{phase}{}{method}", many_lights(30)));
        let plan = plan(&scene, 24).with_stepping(FINE);
        let ours = on(&gpu, &plan).0;
        let wrong = difference(&plan, &ours, &cpu::radiance(&plan, &Control::default()).unwrap().0);
        println!("{phase}: {wrong:.1e}");
        assert!(wrong < 2.0 * TOLERANCE, "{phase}: {wrong:e}");
        // Without what is near the stars the pictures would differ.
        let lonely = plan.clone().without_near_field();
        assert!(difference(&plan, &on(&gpu, &lonely).0, &ours) > 10.0 * TOLERANCE, "{phase}");
    }
}

/// Every method with a shader: two stars, gas, a background and a phase function at once.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn every_method_is_that_of_the_processor() {
    let gpu = device();
    let dust = DUST.replace("ccm89", "inverse_wavelength");
    let second = STAR.replace("0.2 0.5 0.3", "-0.3 -0.2 0.1").replace("9000 K", "4000 K");
    let camera = CAMERA.replace("[\"johnson-B\", \"johnson-V\"]", "[\"cie-x\", \"cie-y\"]");
    let gas = r#"[field.knot]
kind = "sphere"
radius = "0.4 pc"
centre = "0.2 0 0.2 pc"
[[emission]]
name = "H I"
kind = "ion"
ion = "H1"
density = "1e3 * knot"
temperature = "8000 K"
electron_density = "300 cm-3"
"#;
    let behind = r#"[background]
kind = "blackbody"
temperature = "4000 K"
radiance = "2.5e-8 W/m2/sr/um"
"#;
    let forward = "phase = { kind = \"henyey_greenstein\", g = 0.5 }\n";
    let mut compared = 0;
    for method in barnard::scene::methods().map(|m| m.name) {
        // Closed forms keep few digits of narrow passbands in single precision.
        let (degree, accuracy) = if method == "analytic" { ("degree = 2\n", 0.02) } else { ("", 1e-3) };
        let text = format!(
            r#"{camera}{dust}{forward}{STAR}{second}{gas}{behind}[method]
name = "{method}"
bake = 24
accuracy = {accuracy}
{degree}"#
        );
        let scene = parsed(&text);
        let stepping = if method == "double_integration" { Stepping::Fixed(60) } else { FINE };
        let plan = plan(&scene, 12).with_stepping(stepping);
        if method == "sampled" {
            assert!(barnard_gpu::unable(&plan, Tuning::default()).is_some());
            continue;
        }
        let (theirs, found) = cpu::radiance(&plan, &Control::default()).unwrap();
        let (ours, ours_found) = on(&gpu, &plan);
        let wrong = difference(&plan, &ours, &theirs);
        println!("{method}: {wrong:.1e}");
        assert!(wrong < TOLERANCE, "{method}: {wrong:e}");
        assert!((ours_found.depth / found.depth - 1.0).abs() < 0.01, "{method}: {} {}", ours_found.depth, found.depth);
        compared += 1;
    }
    assert!(compared >= 9);
}

/// What no shader does is refused, with what would be right.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn other_methods_are_refused() {
    let gpu = device();
    let narrow = DUST.replace("ccm89", "inverse_wavelength");
    for (method, dust, words) in [("sampled", DUST, "sampled"), ("analytic", &narrow, "single precision")] {
        let scene = parsed(&format!(
            r#"{CAMERA}{dust}{STAR}[method]
bake = 16
name = "{method}"
"#
        ));
        let options = Options::within(DEFAULT_LIMIT);
        let plan = Planner::new(&options).with_quality(Quality::Fixed(20)).plan(&scene, None, &Control::default()).unwrap();
        let error = DeviceMarch::new(&gpu, &plan, Tuning::default()).err().unwrap().to_string();
        assert_eq!(barnard_gpu::unable(&plan, Tuning::default()).unwrap().to_string(), error);
        assert!(error.contains(words) && error.contains("on the processor"), "{error}");
    }
    // A wish to stop is heard.
    let scene = parsed(&format!("{CAMERA}{DUST}{STAR}[method]\nbake = 16\n"));
    let options = Options::within(DEFAULT_LIMIT);
    let plan = Planner::new(&options).with_quality(Quality::Fixed(20)).plan(&scene, None, &Control::default()).unwrap();
    let control = Control::default();
    control.interrupt();
    assert!(DeviceMarch::new(&gpu, &plan, Tuning::default()).unwrap().radiance(&control).is_err());
}

/// Images of all around from within the dust, in parts and with several rays a pixel: the same light, and none beside the
/// circle of a dome, where the background does not shine either.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn all_around() {
    let gpu = device();
    let background = r#"[background]
kind = "blackbody"
temperature = "4000 K"
radiance = "1e-9 W/m2/sr/um"
"#;
    let camera = CAMERA.replace("0.3 0.2 4 pc", "-0.4 0.2 0.3 pc");
    let scene = parsed(&format!("{camera}{DUST}{STAR}{background}"));
    let planned = plan(&scene, 24).with_stepping(FINE);
    let camera = planned.camera().clone();
    let dome = camera.clone().with_fisheye_deg(200.0, 40.0);
    let part = camera.clone().with_equirectangular(40).crop(9, 3, 24, 11).unwrap();
    let mut pictures = Vec::new();
    // Other shapes than a sphere's and a cube's have nothing beside them.
    let others = [camera.clone().with_equirectangular(40).with_size(40, 30), camera.clone().with_cubemap(9).with_size(9, 70)];
    let usual = [dome.clone().with_supersampling(2), dome, camera.clone().with_equirectangular(40), part, camera.with_cubemap(9)];
    for camera in usual.into_iter().chain(others) {
        let mut plan = planned.clone();
        plan.look_from(camera, &Control::default()).unwrap();
        let (ours, _) = on(&gpu, &plan);
        let (theirs, _) = cpu::radiance(&plan, &Control::default()).unwrap();
        let off = difference(&plan, &ours, &theirs);
        assert!(off < TOLERANCE, "{:?} {off:e}", plan.camera().projection);
        pictures.push(ours);
    }
    assert_eq!((pictures[1][0], pictures[1][12 * 24 + 12] > 0.0), (0.0, true));
    assert_eq!((pictures[5][0], pictures[5][15 * 40 + 20] > 0.0), (0.0, true));
    assert!(pictures[0] != pictures[1]);
}
