//! Stated spatial errors beside true ones: a picture says of itself what it is off from the reference.

use barnard::backend::{Renderer, cpu};
use barnard::control::Control;
use barnard::image::relative_rms;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planner};
use barnard::scene::Scene;

/// Stated and true relative rms error of the worst band.
fn errors(text: &str) -> (f64, f64) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cases");
    let scene = barnard_files::parse("stated.toml", "stated", text.to_owned(), &barnard_files::in_folder(folder, DEFAULT_LIMIT)).unwrap();
    let truth = barnard::render_reference(&scene, 1e-5, &Control::default()).unwrap();
    beside(&scene, &(0..scene.bands.len()).map(|band| truth.band(band).collect()).collect::<Vec<_>>())
}

/// Comparison with known radiances per band.
fn beside(scene: &Scene, truth: &[Vec<f64>]) -> (f64, f64) {
    let control = Control::default();
    let plan = Planner::new(&Options::within(DEFAULT_LIMIT)).plan(scene, None, &control).unwrap();
    let (image, _) = Renderer::new(&mut cpu::Cpu).render(&plan, &control).unwrap();
    assert_eq!(truth.len(), scene.bands.len());
    let off = truth.iter().enumerate().map(|(b, truth)| relative_rms(image.band(b).zip(truth.iter().copied()))).fold(0.0, f64::max);
    (plan.space().spatial.unwrap().error, off)
}

/// Built-in scenes at 8 × 8 pixels and their radiances by the reference, which takes minutes for some of them.
fn built_in() -> Vec<(Scene, Vec<Vec<f64>>)> {
    let mut scenes: Vec<(&str, Vec<Vec<f64>>)> = Vec::new();
    for line in include_str!("cases/builtins.csv").lines().filter(|line| !line.starts_with('#')) {
        let (name, rest) = line.split_once(',').unwrap();
        let pixels: Vec<f64> = rest.split(',').skip(1).map(|value| value.parse().unwrap()).collect();
        assert_eq!(pixels.len(), 64);
        match scenes.last_mut().filter(|(last, _)| *last == name) {
            Some((_, bands)) => bands.push(pixels),
            None => scenes.push((name, vec![pixels])),
        }
    }
    let loaded = |(name, truth): (&str, Vec<Vec<f64>>)| {
        let scene = barnard_files::builtin::load(name, DEFAULT_LIMIT).unwrap();
        let camera = scene.camera.clone().with_size(8, 8);
        let scene = scene.with_camera(camera);
        (scene, truth)
    };
    scenes.into_iter().map(loaded).collect()
}

const OUTSIDE: &str = "position = \"0 0 6 pc\"\nfield_of_view = \"22 deg\"";
const GRID: &str = r#"[field.n]
kind = "grid"
file = "density.npy"
axes = "zyx"
low = "-1 -1 -1 pc"
high = "1 1 1 pc"
"#;
const BALL: &str = r#"[field.n]
kind = "sphere"
radius = "1 pc"
"#;

/// Dust lit by a star that is not drawn itself.
fn lit(camera: &str, field: &str, density: &str, scale: f64, star: &str, g: f64) -> String {
    format!(
        r#"bands = ["bessell-V"]
[camera]
kind = "perspective"
{camera}
size = [24, 24]
{field}[dust]
density = "{density}"
scale = "{scale} /pc"
law = "ccm89"
albedo = 0.6
phase = {{ kind = "henyey_greenstein", g = {g} }}
[[star]]
kind = "blackbody"
position = "{star} pc"
temperature = "12000 K"
luminosity = "1000 Lsun"
visible = false
"#
    )
}

/// An eye in the dust.
fn inside(position: &str, target: &str, degrees: f64) -> String {
    format!("position = \"{position} pc\"\ntarget = \"{target} pc\"\nfield_of_view = \"{degrees} deg\"")
}

/// Built-in scenes, cameras inside of dust and close before it, depths of 100 to 10⁴, functions with edges and without: what is stated
/// is at least 0.7 of what is true in 95 % of them, and in none less than half of it.
#[test]
#[ignore = "long"]
fn stated_errors_hold() {
    let grid = |camera: &str, scale: f64, star: &str, g: f64| lit(camera, GRID, "n", scale, star, g);
    let shell = |thickness: f64| {
        format!(
            r#"[field.n]
kind = "shell"
radius = "0.8 pc"
thickness = "{thickness} pc"
"#
        )
    };
    let scenes = [
        grid(&inside("0.3 0.1 0.2", "-0.5 0 0", 60.0), 2.0, "-0.3 0.2 -0.1", 0.5),
        grid(&inside("0 0 0", "1 0.2 0", 90.0), 6.0, "0.5 0.2 0.1", 0.5),
        grid(&inside("0.2 0 0.5", "0 0 0", 90.0), 2.0, "0.2 0.05 0.3", 0.5),
        grid(&inside("-0.51 -0.396 0.652", "0.044 0.02 -0.055", 90.0), 30.0, "-0.102 0.203 -0.318", 0.0),
        grid(&inside("0.6 -0.2 0.1", "0 0 0.2", 30.0), 10.0, "1.5 0.4 1.9", 0.0),
        grid(&inside("-0.4 0.5 -0.3", "0.1 0 0", 60.0), 3.0, "-0.7 0.1 0.2", 0.7),
        grid(&inside("0.1 0.6 0.4", "0 0.1 -0.2", 90.0), 1.0, "0.4 -0.3 0.1", 0.7),
        grid(&inside("0.5 0.5 0.5", "-0.1 0 0.2", 60.0), 10.0, "-0.5 0.6 -0.2", 0.5),
        grid(&inside("0 0 1.02", "0 0 0", 60.0), 2.0, "0.3 0.3 0.5", 0.5),
        grid(&inside("0 1.1 0", "0 0 0.1", 60.0), 6.0, "0.3 0.5 0.5", 0.0),
        grid(OUTSIDE, 2.0, "0.2 0.1 0.3", 0.5),
        grid(OUTSIDE, 60.0, "0.2 0.1 0.9", 0.5),
        grid(OUTSIDE, 600.0, "1.2 0.5 2", 0.5),
        grid(OUTSIDE, 6000.0, "1.2 0.5 2", 0.0),
        lit(OUTSIDE, BALL, "n", 2.0, "0.2 0.1 0.3", 0.5),
        lit(&inside("0.5 0 0.2", "-0.5 0 0", 60.0), BALL, "n", 2.0, "0.2 0.1 0.3", 0.5),
        lit(OUTSIDE, BALL, "n * step(z, 0.11)", 4.0, "0.2 0.1 -0.3", 0.5),
        lit(
            OUTSIDE,
            r#"[field.n]
kind = "box"
low = "-0.5 -0.7 -0.4 pc"
high = "0.6 0.5 0.4 pc"
"#,
            "n",
            3.0,
            "0.2 0.1 0.3",
            0.0,
        ),
        lit(
            OUTSIDE,
            r#"[field.n]
kind = "plummer"
core = "0.3 pc"
cut = "1 pc"
"#,
            "n",
            3.0,
            "0.2 0.1 0.3",
            0.5,
        ),
        lit(OUTSIDE, &shell(0.05), "n", 4.0, "0.2 0.1 0.3", 0.5),
        lit(
            OUTSIDE,
            r#"[field.n]
kind = "slab"
normal = [0.3, 0.2, 1]
thickness = "0.3 pc"
extent = "1 pc"
"#,
            "n",
            3.0,
            "0.2 0.1 0.9",
            0.5,
        ),
    ];
    let built_in = built_in();
    let known = built_in.iter().map(|(scene, truth)| beside(scene, truth));
    let found: Vec<(f64, f64)> = scenes.iter().map(|text| errors(text)).chain(known).collect();
    let words: Vec<String> = found.iter().map(|(stated, off)| format!("{stated:.1e} for {off:.1e}")).collect();
    println!("{words:#?}");
    let short = found.iter().filter(|(stated, off)| *stated < 0.7 * off).count();
    assert!(20 * short <= found.len(), "{short} of {}: {words:#?}", found.len());
    assert!(found.iter().all(|(stated, off)| *stated > 0.5 * off), "{words:#?}");
}

/// In deep dust that is a function, where all light comes from a skin far thinner than a voxel, what is stated is what
/// is true: not less than 0.7 of it, nor several times as much.
#[test]
#[ignore = "long"]
fn skins_are_not_overstated() {
    for scale in [10.0, 100.0, 1000.0] {
        let text = lit(OUTSIDE, BALL, "n", scale, "1.2 0.5 2", 0.5) + "[method]\nbake = 48\n";
        let (stated, off) = errors(&text);
        println!("{scale}: {stated:.1e} for {off:.1e}");
        assert!(stated > 0.7 * off && stated < 3.0 * off, "{scale}: {stated:e} for {off:e}");
    }
}

/// A ball that glows in dust, sampled to as few voxels as asked for: what is stated of its picture is what it is off
/// by, and far from nothing. Where nothing is asked for it is sampled as finely as the accuracy needs.
#[test]
fn samples_are_part_of_the_error() {
    let text = |method: &str| {
        format!(
            r#"[camera]
kind = "orthographic"
position = "0 0 5 pc"
width = "2.2 pc"
size = [41, 41]
{BALL}[dust]
density = "n"
scale = "2 mag/pc"
law = "ccm89"
albedo = 0.0
[[emission]]
kind = "lines"
density = "n"
scale = "1e-25 W/m3/sr"
lines = [{{ wavelength = "656.28 nm", strength = 1 }}]
[[band]]
name = "Ha"
kind = "top_hat"
centre = "656.3 nm"
width = "3 nm"
{method}"#
        )
    };
    let (stated, off) = errors(&text("[method]\nbake = 12\n"));
    assert!(off > 0.01 && stated > 0.7 * off && stated < 3.0 * off, "stated {stated:e}, true {off:e}");
    let (stated, off) = errors(&text(""));
    assert!(off < 6e-3 && stated > 0.7 * off, "stated {stated:e}, true {off:e}");
}

/// A star within a cloud of noise that is sampled coarsely: what is stated is about what finer samples change. (The
/// reference, 89 s for 12 × 9 pixels, has 7.8e-2 for the 8.1e-2 that is stated there.)
#[test]
fn dust_at_a_star_is_the_fields_own() {
    let cloud = r#"[field.n]
kind = "fbm"
radius = "1 pc"
"#;
    let rendered = |bake: usize| {
        let text = lit(OUTSIDE, cloud, "n", 3.8, "0.31 -0.21 0.91", 0.5) + &format!("[method]\naccuracy = 0.02\nbake = {bake}\n");
        let scene = barnard_files::parse("noise.toml", "noise", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap();
        let plan = Planner::new(&Options::within(DEFAULT_LIMIT)).plan(&scene, None, &Control::default()).unwrap();
        let image = Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap().0;
        (plan.space().spatial.unwrap().error, image)
    };
    let (stated, coarse) = rendered(24);
    let off = coarse.relative_rmse(0, &rendered(192).1, 0);
    assert!(off > 0.05 && stated > 0.7 * off && stated < 3.0 * off, "{stated:e} for {off:e}");
}
