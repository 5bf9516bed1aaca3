//! Changes on the device and partial work.

use barnard::backend::cpu;
use barnard::control::Control;
use barnard::image::{Display, Image, Level, Samples, Tone};
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{END_SHARE, Options, Planned, Planner, Quality, Stepping};
use barnard_gpu::{DeviceMarch, GpuError, Tuning};
use spectra::colour::{Palette, Stretch};

use super::light::{CAMERA, DUST, FINE, STAR, TOLERANCE, difference, many_lights, on, parsed, plan};
use super::test_device::device;

/// Pictures do not depend on the size of workgroups, with empty space marched through and rays followed to their ends, to
/// what other places of samples behind a jump and faint light behind an end cost.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn tuning_changes_nothing() {
    let gpu = device();
    let shell = r#"[field.ball]
kind = "shell"
radius = "1 pc"
thickness = "0.05 pc"
[dust]
density = "ball"
scale = "400 /pc"
law = "ccm89"
albedo = 0.6
"#;
    let scene = parsed(&format!("{CAMERA}{shell}{STAR}[method]\nbake = 64\n"));
    let plan = plan(&scene, 33).with_stepping(FINE);
    let by = |tuning: Tuning| DeviceMarch::new(&gpu, &plan, tuning).unwrap().radiance(&Control::default()).unwrap();
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
    let scene = parsed(&format!(
        r#"{CAMERA}{DUST}{STAR}[method]
bake = 16
name = "midpoint"
count = 200
"#
    ));
    let plan = plan(&scene, 16).with_stepping(Stepping::PerVoxel(30.0));
    let theirs = cpu::radiance(&plan, &Control::default()).unwrap().0;
    let pausing = Tuning { pauses: Some(true), ..Tuning::default() };
    let mut renderer = DeviceMarch::new(&gpu, &plan, pausing).unwrap();
    let first = renderer.radiance(&Control::default()).unwrap().0;
    let wrong = difference(&plan, &first, &theirs);
    // Real devices weigh voxels in 256ths, and need no pauses.
    assert!(wrong < if gpu.adapter.real { TOLERANCE } else { 1e-4 }, "{wrong:e}");
    assert!(renderer.dispatches() > 3, "{}", renderer.dispatches());
    // What rays of the picture before left behind is not met again.
    assert!(renderer.radiance(&Control::default()).unwrap().0 == first);
    // Where there is little to do, the shader without pauses, which real adapters run, makes the same picture.
    let plan = plan.with_stepping(Stepping::Fixed(8));
    let by = |pauses| {
        let tuning = Tuning { pauses: Some(pauses), ..Tuning::default() };
        let mut renderer = DeviceMarch::new(&gpu, &plan, tuning).unwrap();
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
    let cloud = r#"[field.ball]
kind = "fbm"
radius = "1 pc"
[dust]
density = "ball"
scale = "3 /pc"
law = "ccm89"
albedo = 0.6
"#;
    let second = STAR.replace("0.2 0.5 0.3", "-0.3 -0.2 0.1").replace("9000 K", "4000 K");
    let made = |place: &str| {
        let scene = parsed(&format!("{CAMERA}{cloud}{second}{}[method]\nbake = 40\n", STAR.replace("0.2 0.5 0.3", place)));
        let camera = scene.camera.clone().with_size(12, 12);
        let scene = scene.with_camera(camera);
        let options = Options::within(DEFAULT_LIMIT);
        Planner::new(&options).with_quality(Quality::Fixed(40)).plan(&scene, None, &Control::default()).unwrap().with_stepping(FINE)
    };
    let first = made("0.2 0.5 0.3");
    let mut renderer = DeviceMarch::new(&gpu, &first, Tuning::default()).unwrap();
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
    for (place, word) in [([f64::NAN, 0.0, 0.0], "finite"), ([0.0, f64::INFINITY, 0.0], "finite"), ([0.0, 0.0, 1e9], "too far")] {
        assert!(renderer.move_star(1, place.into()).err().unwrap().to_string().contains(word), "{place:?}");
    }
    assert!(renderer.move_star(2, [0.0; 3].into()).err().unwrap().to_string().contains("number 2 of 2"));
    renderer.update(&first).unwrap();
    assert!(renderer.radiance(&Control::default()).unwrap() == before);
}

/// A star whose depths stand in pages is not moved on the device: it stays where it is, and a new plan is asked for.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn stars_in_pages_are_not_moved() {
    let gpu = device();
    let lobes = DUST.replace("density = \"ball\"", "density = \"ball * max(0, 4 * x * y - 1)\"");
    let rendered = |sparse: &str| {
        plan(
            &parsed(&format!(
                r#"{CAMERA}{lobes}{STAR}[method]
bake = 60
sparse = "{sparse}"
"#
            )),
            24,
        )
    };
    let renderer = |plan: &Planned| DeviceMarch::new(&gpu, plan, Tuning::default()).unwrap();
    let (whole, pages) = (rendered("never"), rendered("always"));
    assert!(renderer(&whole).can_move(0) && !renderer(&pages).can_move(0));
    let mut renderer = renderer(&pages);
    let before = renderer.radiance(&Control::default()).unwrap();
    let refused = renderer.move_star(0, [0.4, 0.1, 0.5].into()).err().unwrap();
    assert!(matches!(refused, GpuError::InPages(0)), "{refused}");
    assert!(renderer.radiance(&Control::default()).unwrap() == before);
}

/// Passes settle to the light of whole pixels: to a picture of 144 rays a pixel by the processor, closer with every
/// four times as many, from a first look on; colours are those of the processor; another plan, a picture in one go and
/// an interrupted pass start anew.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn passes_settle() {
    let gpu = device();
    let scene = parsed(&format!("{CAMERA}{DUST}{STAR}[method]\nbake = 24\n"));
    let scene = scene.clone().with_camera(scene.camera.clone().with_supersampling(12));
    let plan = plan(&scene, 24);
    let truth = cpu::radiance(&plan, &Control::default()).unwrap().0;
    let mut renderer = DeviceMarch::new(&gpu, &plan, Tuning::default()).unwrap();
    let tone = Tone {
        palette: Palette::by_name("natural", &scene.bands).unwrap(),
        black: 0.0,
        white: 1e-5,
        stretch: Stretch::by_name("asinh", None).unwrap(),
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
        ..Display::grey(2)
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
    let other = Tone { palette: Palette::by_name("grey", &scene.bands[..1]).unwrap(), ..tone };
    assert!(renderer.resolve(&other).err().unwrap().to_string().contains("1 bands, the picture has 2"));
    renderer.update(&plan).unwrap();
    assert_eq!(renderer.refine(&Control::default()).unwrap(), 0);
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
        Planner::new(&options).with_quality(Quality::Fixed(40)).plan(&scene, None, &Control::default()).unwrap()
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
    let mut renderer = DeviceMarch::new(&gpu, &first, Tuning::default()).unwrap();
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
