//! Pictures of the graphics processor beside those of the processor: the same plan, the same light.

#[path = "common/device.rs"]
mod test_device;

use barnard::backend::{RenderStats, cpu};
use barnard::control::Control;
use barnard::image::{Display, Image, Level, Samples, Tone, relative_rms};
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{END_SHARE, Options, Plan, Stepping};
use barnard::scene::Scene;
use barnard_gpu::{Gpu, Renderer, Tuning};
use spectra::colour::{Palette, Stretch};
use test_device::device;

/// How far pictures of so many samples a voxel may differ: 16-bit volumes, the device's own interpolation, and what
/// finite steps still cost.
const TOLERANCE: f64 = 1e-3;
const FINE: Stepping = Stepping::PerVoxel(10.0);

fn plan(scene: &mut Scene, edge: usize) -> Plan {
    let shape = scene.camera.height as f64 / scene.camera.width as f64;
    (scene.camera.width, scene.camera.height) = (edge, (edge as f64 * shape) as usize);
    let options = Options::within(DEFAULT_LIMIT);
    Plan::new(scene, &options, &Control::default()).unwrap()
}

/// Radiance and statistics by the device.
fn on(gpu: &Gpu, plan: &Plan) -> (Vec<f32>, RenderStats) {
    Renderer::new(gpu, plan, Tuning::default()).unwrap().radiance(&Control::default()).unwrap()
}

/// The relative rms difference of the worst band.
fn difference(plan: &Plan, ours: &[f32], theirs: &[f32]) -> f64 {
    let pixels = plan.camera().width * plan.camera().height;
    let bands = ours.chunks(pixels).zip(theirs.chunks(pixels));
    bands.map(|(a, b)| relative_rms(a.iter().zip(b).map(|(a, b)| (f64::from(*a), f64::from(*b))))).fold(0.0, f64::max)
}

/// Every built-in scene: with fine steps the same light, with the plan's own, which a packet of sixteen rays shares on
/// the processor, to its accuracy.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn pictures_are_those_of_the_processor() {
    let gpu = device();
    for builtin in barnard_files::builtin::SCENES {
        let mut scene = barnard_files::builtin::load(builtin.name, DEFAULT_LIMIT).unwrap();
        let planned = plan(&mut scene, 32);
        let accuracy = planned.spectral().accuracy;
        // A ray that all but hits a gathered star sees dust between the ends of its step there: all rays take the same.
        let many_lights = planned.space().many_lights.is_some();
        let length_pc = planned.space().dust.as_ref().map_or(0.0, |dust| dust.lattice.bounds.size().length());
        let shared = |s: Stepping| if many_lights { Stepping::Fixed(s.steps(length_pc, planned.space().voxel_pc())) } else { s };
        let (stepping, fine) = (shared(planned.stepping()), shared(FINE));
        let fine = planned.with_stepping(fine);
        let (theirs, found) = cpu::radiance(&fine, &Control::default()).unwrap();
        let (ours, ours_found) = on(&gpu, &fine);
        let wrong = difference(&fine, &ours, &theirs);
        assert!(wrong < TOLERANCE, "{}: {wrong:e}", builtin.name);
        // Rays of a packet end together, those of the GPU each by itself: they need not go as deep.
        let deep = ours_found.depth / found.depth;
        assert!(deep > 0.9 && deep < 1.01, "{}: {} {}", builtin.name, ours_found.depth, found.depth);
        // A hundredth more light would be seen.
        let more: Vec<f32> = theirs.iter().map(|v| 1.01 * v).collect();
        assert!(difference(&fine, &ours, &more) > TOLERANCE);
        let planned = fine.with_stepping(stepping);
        let theirs = cpu::radiance(&planned, &Control::default()).unwrap().0;
        let ours = on(&gpu, &planned).0;
        let wrong = difference(&planned, &ours, &theirs);
        assert!(wrong < accuracy.max(TOLERANCE), "{}: {wrong:e} of {accuracy:e}", builtin.name);
    }
}

fn parsed(text: &str) -> Scene {
    barnard_files::parse("test.toml", "test", text.to_owned(), &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap()
}

const CAMERA: &str = "bands = [\"johnson-B\", \"johnson-V\"]\n[camera]\nkind = \"perspective\"\nposition = \"0.3 0.2 4 pc\"\nfield_of_view = \"40 deg\"\nsize = [24, 24]\n";
const DUST: &str =
    "[field.ball]\nkind = \"sphere\"\nradius = \"1 pc\"\n[dust]\ndensity = \"ball\"\nscale = \"2 /pc\"\nlaw = \"ccm89\"\nalbedo = 0.6\n";
const STAR: &str =
    "[[star]]\nkind = \"blackbody\"\nposition = \"0.2 0.5 0.3 pc\"\ntemperature = \"9000 K\"\nluminosity = \"100 Lsun\"\nvisible = false\n";

/// Gas that ends within the dust, a background, spectral and forward scattering, far and near cameras: each by itself.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn each_part_is_that_of_the_processor() {
    let gpu = device();
    // Glowing gas on a finer lattice that reaches out of the dust.
    let gas = "[field.knot]\nkind = \"sphere\"\nradius = \"0.7 pc\"\ncentre = \"0.6 0 0.2 pc\"\n[[emission]]\nname = \"H I\"\nkind = \"ion\"\nion = \"H1\"\n\
               density = \"1e4 * knot\"\ntemperature = \"8000 K\"\nelectron_density = \"300 cm-3\"\n";
    let behind = "[background]\nkind = \"blackbody\"\ntemperature = \"4000 K\"\nradiance = \"2.5e-8 W/m2/sr/um\"\n";
    let forward = "phase = { kind = \"henyey_greenstein\", g = 0.7 }\n";
    let spectral = DUST.replace("ccm89", "draine03_rv31") + "phase = { kind = \"henyey_greenstein\" }\n";
    let far = CAMERA.replace("4 pc", "4000 pc").replace("40 deg", "0.04 deg");
    let inside = CAMERA.replace("0.3 0.2 4 pc", "0.3 0.2 0.4 pc").replace("40 deg", "90 deg");
    let flat =
        CAMERA.replace("kind = \"perspective\"", "kind = \"orthographic\"").replace("field_of_view = \"40 deg\"", "width = \"2.5 pc\"");
    let method = "[method]\nbake = 24\n";
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
        ("many bounces", format!("{CAMERA}{DUST}{forward}{STAR}{gas}{method}bounces = 4\n")),
        ("dark", format!("{CAMERA}{DUST}{method}")),
    ] {
        let mut scene = parsed(&text);
        let plan = plan(&mut scene, 24).with_stepping(FINE);
        let theirs = cpu::radiance(&plan, &Control::default()).unwrap().0;
        let ours = on(&gpu, &plan).0;
        let wrong = difference(&plan, &ours, &theirs);
        assert!(wrong < TOLERANCE, "{name}: {wrong:e}");
        assert_eq!(name == "dark", theirs.iter().all(|v| *v == 0.0), "{name}");
    }
}

/// The same picture at every size of workgroup, with empty space marched through and rays followed to their ends, to
/// what other places of samples behind a jump and faint light behind an end cost.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn tuning_changes_nothing() {
    let gpu = device();
    let shell = "[field.ball]\nkind = \"shell\"\nradius = \"1 pc\"\nthickness = \"0.05 pc\"\n[dust]\ndensity = \"ball\"\nscale = \"400 /pc\"\nlaw = \"ccm89\"\nalbedo = 0.6\n";
    let mut scene = parsed(&format!("{CAMERA}{shell}{STAR}[method]\nbake = 64\n"));
    let plan = plan(&mut scene, 33).with_stepping(FINE);
    let by = |tuning: Tuning| Renderer::new(&gpu, &plan, tuning).unwrap().radiance(&Control::default()).unwrap();
    let usual = by(Tuning::default());
    for workgroup in [(1, 1), (4, 4), (64, 1), (3, 7)] {
        assert!(by(Tuning { workgroup, ..Tuning::default() }) == usual, "{workgroup:?}");
    }
    let through = by(Tuning { skip_empty: false, ..Tuning::default() });
    let wrong = difference(&plan, &through.0, &usual.0);
    assert!(wrong < 1e-5, "{wrong:e}");
    let whole = by(Tuning { end_early: false, ..Tuning::default() });
    let wrong = difference(&plan, &whole.0, &usual.0);
    assert!(wrong < END_SHARE as f64 * plan.spectral().accuracy && whole.1.depth > 1.1 * usual.1.depth, "{wrong:e} {whole:?} {usual:?}");
    assert!(usual.0.iter().any(|v| *v > 0.0));
}

/// Rays that pause many times on a software adapter, in the middle of steps too, bring the light of those that need
/// not: software stops loops after 65535 turns.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn rays_pause_in_time() {
    let gpu = device();
    let mut scene = parsed(&format!("{CAMERA}{DUST}{STAR}[method]\nbake = 16\nname = \"midpoint\"\ncount = 200\n"));
    let plan = plan(&mut scene, 16).with_stepping(Stepping::PerVoxel(30.0));
    let theirs = cpu::radiance(&plan, &Control::default()).unwrap().0;
    let pausing = Tuning { pauses: Some(true), ..Tuning::default() };
    let mut renderer = Renderer::new(&gpu, &plan, pausing).unwrap();
    let first = renderer.radiance(&Control::default()).unwrap().0;
    let wrong = difference(&plan, &first, &theirs);
    assert!(wrong < 1e-4, "{wrong:e}");
    assert!(renderer.dispatches() > 3, "{}", renderer.dispatches());
    // What rays of the picture before left behind is not met again.
    assert!(renderer.radiance(&Control::default()).unwrap().0 == first);
    // Where there is little to do, the shader without pauses, which real adapters run, makes the same picture.
    let plan = plan.with_stepping(Stepping::Fixed(8));
    let by = |pauses| {
        let tuning = Tuning { pauses: Some(pauses), ..Tuning::default() };
        let mut renderer = Renderer::new(&gpu, &plan, tuning).unwrap();
        let data = renderer.radiance(&Control::default()).unwrap().0;
        assert_eq!(renderer.dispatches(), 1);
        data
    };
    assert!(by(true) == by(false));
}

/// A star that moves on the device gives the picture of a plan that has it there: inside, on a voxel, outside, beside a
/// face; the other star stays, and a plan that is taken afterwards has its own places.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn a_star_moves_on_the_device() {
    let gpu = device();
    let cloud =
        "[field.ball]\nkind = \"fbm\"\nradius = \"1 pc\"\n[dust]\ndensity = \"ball\"\nscale = \"3 /pc\"\nlaw = \"ccm89\"\nalbedo = 0.6\n";
    let second = STAR.replace("0.2 0.5 0.3", "-0.3 -0.2 0.1").replace("9000 K", "4000 K");
    let made = |place: &str| {
        let mut scene = parsed(&format!("{CAMERA}{cloud}{second}{}[method]\nbake = 40\n", STAR.replace("0.2 0.5 0.3", place)));
        (scene.camera.width, scene.camera.height) = (12, 12);
        let options = Options::within(DEFAULT_LIMIT);
        Plan::sampled(&scene, &options, 40, &Control::default()).unwrap().with_stepping(FINE)
    };
    let first = made("0.2 0.5 0.3");
    let mut renderer = Renderer::new(&gpu, &first, Tuning::default()).unwrap();
    let before = renderer.radiance(&Control::default()).unwrap();
    // The last ones stand on diagonals that run through voxel centres only to rounding.
    for place in [
        [-0.4, 0.1, 0.5],
        [0.025, 0.075, -0.025],
        [1.6, 0.3, 0.2],
        [0.2, -3.0, 2.5],
        [0.3, 0.2, 0.999],
        [0.22, -0.1, 0.22],
        [0.22, 0.22, 0.22],
    ] {
        let there = made(&place.map(|x: f64| x.to_string()).join(" "));
        let theirs = cpu::radiance(&first.clone().with_space(there.space().clone()), &Control::default()).unwrap().0;
        renderer.move_star(1, place.into()).unwrap();
        let ours = renderer.radiance(&Control::default()).unwrap().0;
        let wrong = difference(&first, &ours, &theirs);
        println!("{place:?}: {wrong:.1e}");
        assert!(wrong < TOLERANCE, "{place:?}: {wrong:e}");
        assert!(difference(&first, &before.0, &theirs) > 10.0 * TOLERANCE);
    }
    for (place, word) in [([f64::NAN, 0.0, 0.0], "numbers"), ([0.0, f64::INFINITY, 0.0], "numbers"), ([0.0, 0.0, 1e9], "so far")] {
        assert!(renderer.move_star(1, place.into()).err().unwrap().to_string().contains(word), "{place:?}");
    }
    assert!(renderer.move_star(2, [0.0; 3].into()).err().unwrap().to_string().contains("2 stars"));
    renderer.update(&first).unwrap();
    assert!(renderer.radiance(&Control::default()).unwrap() == before);
}

/// Passes settle to the light of whole pixels: to a picture of 144 rays a pixel by the processor, closer with every
/// four times as many, from a first look on; colours are those of the processor; another plan, a picture in one go and
/// an interrupted pass start anew.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn passes_settle() {
    let gpu = device();
    let mut scene = parsed(&format!("{CAMERA}{DUST}{STAR}[method]\nbake = 24\n"));
    scene.camera.supersampling = 12;
    let plan = plan(&mut scene, 24);
    let truth = cpu::radiance(&plan, &Control::default()).unwrap().0;
    let mut renderer = Renderer::new(&gpu, &plan, Tuning::default()).unwrap();
    let tone = Tone {
        palette: Palette::named("natural", &scene.bands).unwrap(),
        black: 0.0,
        white: 1e-5,
        stretch: Stretch::named("asinh", None).unwrap(),
    };
    let image = |data: &[f32]| {
        let mut image = Image::bare(24, 24, vec!["B".into(), "V".into()], Samples::Single(data.to_vec()));
        image.pixel = None;
        image
    };
    let display = Display {
        palette: tone.palette.clone(),
        balance: false,
        stretch: tone.stretch,
        black: Level::Radiance(tone.black),
        white: Level::Radiance(tone.white),
    };
    // Colours by the device beside those of the processor from the same light, in parts of 255.
    let mut wrong = Vec::new();
    for pass in 0..=64 {
        assert_eq!(renderer.refine(&Control::default()).unwrap(), pass);
        let data = renderer.picture().unwrap();
        if [0, 1, 4, 16, 64].contains(&pass) {
            wrong.push(difference(&plan, &data, &truth));
            renderer.resolve(&tone).unwrap();
            let colours = display.picture(&image(&data)).into_iter().flat_map(|p| p.map(|v| 255.0 * v));
            let pixels = renderer.pixels().unwrap();
            let ours = pixels.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).map(f64::from);
            let furthest = colours.zip(ours).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(furthest < 1.0, "{furthest}");
            assert!(pixels.iter().any(|v| *v > 60 && *v < 255));
        }
    }
    println!("{wrong:?}");
    assert!(wrong[4] < 0.02 && wrong[4] < 0.5 * wrong[2] && wrong[2] < wrong[1] && wrong[0] < 1.0, "{wrong:?}");
    renderer.radiance(&Control::default()).unwrap();
    assert_eq!(renderer.refine(&Control::default()).unwrap(), 0);
    assert_eq!(renderer.refine(&Control::default()).unwrap(), 1);
    let control = Control::default();
    control.interrupt();
    assert!(renderer.refine(&control).is_err());
    assert_eq!(renderer.refine(&Control::default()).unwrap(), 0);
    let other = Tone { palette: Palette::named("grey", &scene.bands[..1]).unwrap(), ..tone };
    assert!(renderer.resolve(&other).err().unwrap().to_string().contains("1 bands, the picture has 2"));
    renderer.update(&plan).unwrap();
    assert_eq!(renderer.refine(&Control::default()).unwrap(), 0);
}

/// Noise evaluated at every sample gives the picture of noise that was sampled, closer the finer it was; what is no
/// noise is refused.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn noise_on_the_fly_is_noise_that_was_sampled() {
    let gpu = device();
    let cloud = "[field.ball]\nkind = \"fbm\"\nradius = \"1 pc\"\nscale = \"0.8 pc\"\noctaves = 3\noffset = 0.6\n[dust]\ndensity = \"ball\"\nscale = \"2 /pc\"\nlaw = \"ccm89\"\nalbedo = 0.6\n";
    let on_the_fly = Tuning { on_the_fly: true, ..Tuning::default() };
    let wrong = [12, 24, 48].map(|bake| {
        let mut scene = parsed(&format!("{CAMERA}{cloud}{}[method]\nbake = {bake}\n", STAR.replace("0.2 0.5 0.3", "1.5 1.2 1.4")));
        let plan = plan(&mut scene, 12).with_stepping(Stepping::Fixed(100));
        let ours = Renderer::new(&gpu, &plan, on_the_fly).unwrap().radiance(&Control::default()).unwrap().0;
        difference(&plan, &ours, &on(&gpu, &plan).0)
    });
    println!("{wrong:?}");
    assert!(wrong[2] < 0.02 && wrong[2] < 0.5 * wrong[1] && wrong[1] < 0.5 * wrong[0] && wrong[2] > 0.0, "{wrong:?}");
    let mut scene = parsed(&format!("{CAMERA}{DUST}{STAR}[method]\nbake = 16\n"));
    let error = Renderer::new(&gpu, &plan(&mut scene, 24), on_the_fly).err().unwrap().to_string();
    assert!(error.contains("fbm") && error.contains("sampled to a grid"), "{error}");
}

/// Gathered stars: places and temperatures that look like chance.
fn many_lights(count: usize) -> String {
    let part = |i: usize, step: f64| (step * (i + 1) as f64).fract();
    let star = |i: usize| {
        let place = [0.618_034, 0.414_214, 0.732_051].map(|step| 1.2 * part(i, step) - 0.6);
        STAR.replace("0.2 0.5 0.3", &format!("{:.4} {:.4} {:.4}", place[0], place[1], place[2]))
            .replace("9000 K", &format!("{} K", 4000 + 700 * (i % 20)))
    };
    (0..count).map(star).collect()
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
        let mut scene = parsed(&format!("{camera}{dust}{phase}{}{method}", many_lights(30)));
        let plan = plan(&mut scene, 24).with_stepping(FINE);
        let ours = on(&gpu, &plan).0;
        let wrong = difference(&plan, &ours, &cpu::radiance(&plan, &Control::default()).unwrap().0);
        println!("{phase}: {wrong:.1e}");
        assert!(wrong < 2.0 * TOLERANCE, "{phase}: {wrong:e}");
        // Without what is near the stars the pictures would differ.
        let lonely = plan.clone().without_near_field();
        assert!(difference(&plan, &on(&gpu, &lonely).0, &ours) > 10.0 * TOLERANCE, "{phase}");
    }
}

/// A plan that changes on the device gives the picture of one that is new: another star, camera, size, method, number
/// of bounces, space, and back.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn changes_are_taken() {
    let gpu = device();
    let made = |text: String| {
        let scene = parsed(&text);
        let options = Options::within(DEFAULT_LIMIT);
        Plan::sampled(&scene, &options, 40, &Control::default()).unwrap()
    };
    let method = "[method]\nbake = 16\n";
    let first = made(format!("{CAMERA}{DUST}{STAR}{method}"));
    let hot = made(format!("{CAMERA}{DUST}{}{method}", STAR.replace("9000 K", "30000 K")));
    let finer = made(format!("{CAMERA}{DUST}{STAR}{method}count = 5\n"));
    let from = |camera: &str| made(format!("{camera}{DUST}{STAR}{method}"));
    let (aside, larger) = (from(&CAMERA.replace("0.3 0.2 4", "3 1 2")), from(&CAMERA.replace("[24, 24]", "[40, 17]")));
    let many = made(format!("{CAMERA}{DUST}{STAR}{method}bounces = 3\n"));
    let mut many_aside = many.clone();
    many_aside.look_from(aside.camera().clone(), &Control::default()).unwrap();
    let gathered = made(format!("{CAMERA}{DUST}{}{method}", many_lights(12)));
    let mut gathered_aside = gathered.clone();
    gathered_aside.look_from(aside.camera().clone(), &Control::default()).unwrap();
    let gathered_finer = gathered_aside.clone().with_stepping(Stepping::Fixed(80));
    let space = || first.space().clone();
    let changed = [
        hot.with_space(space()),
        aside.with_space(space()),
        finer.with_space(space()),
        many.clone().with_space(space()),
        many_aside.with_space(space()),
        many,
        gathered,
        gathered_aside,
        gathered_finer,
        larger,
        made(format!("{CAMERA}{DUST}{STAR}{}{method}", STAR.replace("0.2 0.5", "-0.2 0.1"))),
    ];
    let mut renderer = Renderer::new(&gpu, &first, Tuning::default()).unwrap();
    let before = renderer.radiance(&Control::default()).unwrap();
    for (i, plan) in changed.iter().enumerate() {
        renderer.update(plan).unwrap();
        let after = renderer.radiance(&Control::default()).unwrap();
        assert!(after == on(&gpu, plan), "{i}");
        assert!(after.0 != before.0, "{i}");
    }
    renderer.update(&first).unwrap();
    assert!(renderer.radiance(&Control::default()).unwrap() == before);
}

/// Every method with a shader: two stars, gas, a background and a phase function at once.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn every_method_is_that_of_the_processor() {
    let gpu = device();
    let dust = DUST.replace("ccm89", "inverse_wavelength");
    let second = STAR.replace("0.2 0.5 0.3", "-0.3 -0.2 0.1").replace("9000 K", "4000 K");
    let camera = CAMERA.replace("[\"johnson-B\", \"johnson-V\"]", "[\"cie-x\", \"cie-y\"]");
    let gas = "[field.knot]\nkind = \"sphere\"\nradius = \"0.4 pc\"\ncentre = \"0.2 0 0.2 pc\"\n[[emission]]\nname = \"H I\"\nkind = \"ion\"\nion = \"H1\"\n\
               density = \"1e3 * knot\"\ntemperature = \"8000 K\"\nelectron_density = \"300 cm-3\"\n";
    let behind = "[background]\nkind = \"blackbody\"\ntemperature = \"4000 K\"\nradiance = \"2.5e-8 W/m2/sr/um\"\n";
    let forward = "phase = { kind = \"henyey_greenstein\", g = 0.5 }\n";
    let mut compared = 0;
    for method in barnard::scene::methods().map(|m| m.name) {
        // Closed forms keep few digits of narrow passbands in single precision.
        let (degree, accuracy) = if method == "analytic" { ("degree = 2\n", 0.02) } else { ("", 1e-3) };
        let text = format!(
            "{camera}{dust}{forward}{STAR}{second}{gas}{behind}[method]\nname = \"{method}\"\nbake = 24\naccuracy = {accuracy}\n{degree}"
        );
        let mut scene = parsed(&text);
        let stepping = if method == "double_integration" { Stepping::Fixed(60) } else { FINE };
        let plan = plan(&mut scene, 12).with_stepping(stepping);
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
        let scene = parsed(&format!("{CAMERA}{dust}{STAR}[method]\nbake = 16\nname = \"{method}\"\n"));
        let options = Options::within(DEFAULT_LIMIT);
        let plan = Plan::sampled(&scene, &options, 20, &Control::default()).unwrap();
        let error = Renderer::new(&gpu, &plan, Tuning::default()).err().unwrap().to_string();
        assert_eq!(barnard_gpu::unable(&plan, Tuning::default()).unwrap().to_string(), error);
        assert!(error.contains(words) && error.contains("on the processor"), "{error}");
    }
    // A wish to stop is heard.
    let scene = parsed(&format!("{CAMERA}{DUST}{STAR}[method]\nbake = 16\n"));
    let options = Options::within(DEFAULT_LIMIT);
    let plan = Plan::sampled(&scene, &options, 20, &Control::default()).unwrap();
    let control = Control::default();
    control.interrupt();
    assert!(Renderer::new(&gpu, &plan, Tuning::default()).unwrap().radiance(&control).is_err());
}
