//! Stars without number: light that is gathered against that of stars one by one, by integrators that know of no such
//! field.

use barnard::backend::{cpu, path};
use barnard::control::Control;
use barnard::image::relative_rms;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planned, Planner, Quality};
use barnard::scene::Scene;

/// A cloud with so many stars of different spectra, at places that look like chance, seen by 14 x 14 pixels.
fn text(stars: usize, phase: &str, method: &str) -> String {
    let part = |i: usize, step: f64| (step * (i + 1) as f64).fract();
    let star = |i: usize| {
        let place = [0.618_034, 0.414_214, 0.732_051].map(|step| 1.6 * part(i, step) - 0.8);
        format!(
            r#"[[star]]
kind = "blackbody"
visible = false
position = "{:.4} {:.4} {:.4} pc"
temperature = "{} K"
luminosity = "{} Lsun"
"#,
            place[0],
            place[1],
            place[2],
            3500 + 900 * (i % 17),
            50 + 37 * (i % 11)
        )
    };
    format!(
        r#"bands = ["johnson-B"]
[camera]
kind = "perspective"
position = "0.3 0.2 5 pc"
field_of_view = "26 deg"
size = [14, 14]
[field.cloud]
kind = "fbm"
seed = 3
radius = "1 pc"
scale = "0.8 pc"
octaves = 3
offset = 0.3
[dust]
density = "cloud"
scale = "1.2 /pc"
law = "ccm89"
albedo = 0.7
{phase}{}[method]
bake = 48
accuracy = 3e-3
{method}"#,
        (0..stars).map(star).collect::<String>()
    )
}

fn scene(text: String) -> Scene {
    let scene = barnard_files::parse("test.toml", "test", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap();
    barnard::plan::sample_functions(&scene, &Options::within(DEFAULT_LIMIT)).unwrap()
}

fn plan(scene: &Scene) -> Planned {
    let options = Options::within(DEFAULT_LIMIT);
    Planner::new(&options).plan(scene, None, &Control::default()).unwrap()
}

fn light(plan: &Planned) -> Vec<f64> {
    cpu::radiance(plan, &Control::default()).unwrap().0.into_iter().map(f64::from).collect()
}

fn difference(ours: &[f64], truth: &[f64]) -> f64 {
    relative_rms(ours.iter().copied().zip(truth.iter().copied()))
}

const FORWARD: &str = "phase = { kind = \"henyey_greenstein\", g = 0.6 }\n";
const BACKWARD: &str = "phase = { kind = \"henyey_greenstein\", g = -0.6 }\n";

/// Twelve gathered stars, scattered evenly and forwards, is what the reference has star by star; another phase function
/// would be seen.
#[test]
fn a_field_of_many_lights_is_the_sum_of_its_stars() {
    for (phase, other, most) in [("", FORWARD, 0.005), (FORWARD, BACKWARD, 0.02)] {
        let scene = scene(text(12, phase, "exact_stars = 0\n"));
        let plan = plan(&scene);
        let gathered = plan.scattered_field().as_ref().unwrap().report.far_field.unwrap();
        assert_eq!(gathered.stars, 12);
        let truth = barnard::render_reference(&scene, 3e-3, &Control::default()).unwrap();
        let truth: Vec<f64> = (0..196).map(|i| truth.at(0, i / 14, i % 14)).collect();
        let error = difference(&light(&plan), &truth);
        println!("{phase}: {error:.1e}, at places {:?}", gathered.error);
        assert!(error < most, "{phase}: {error}");
        // At places errors do not average out, and more than a tenth of the light would be wrong there if anything was
        // left out.
        assert!(gathered.error.is_some_and(|e| e > 0.0 && e < 0.1), "{gathered}");
        let wrong = self::plan(&self::scene(text(12, other, "exact_stars = 0\n")));
        assert!(difference(&light(&wrong), &truth) > 0.1);
    }
}

/// Light of gathered stars that scatters many times is that of the path tracer, whose noise is taken off; its first
/// scattering alone is not.
#[test]
fn a_field_of_many_lights_scatters_many_times() {
    let scene = scene(text(12, FORWARD, "exact_stars = 0\nbounces = 1000\n"));
    let all = light(&plan(&scene));
    let mut film = path::Film::default();
    let options = path::Options::default().with_samples(150);
    path::trace(&scene, &options, &mut film, &Control::default(), &mut |_| ()).unwrap();
    let truth: Vec<f64> = film.estimates.iter().map(|e| e.mean).collect();
    let error = |ours: &[f64]| {
        let wrong: f64 = ours.iter().zip(&film.estimates).map(|(o, e)| (o - e.mean).powi(2) - e.error().powi(2)).sum();
        (wrong.max(0.0) / truth.iter().map(|t| t * t).sum::<f64>()).sqrt()
    };
    let once = light(&plan(&self::scene(text(12, FORWARD, "exact_stars = 0\n"))));
    println!("{:.1e} {:.1e}", error(&all), error(&once));
    assert!(error(&all) < 0.05 && error(&once) > 0.09, "{} {}", error(&all), error(&once));
}

/// The brightest are marched one by one, as many as are asked for, and what is asked for of all is what it was without
/// many lights.
#[test]
fn bright_stars_stay_exact() {
    let marched = |method: &str, bright: bool| {
        let text = text(40, "", method);
        let text = if bright { text.replacen("luminosity = \"50 Lsun\"", "luminosity = \"9e6 Lsun\"", 1) } else { text };
        plan(&scene(text)).space().marched().to_vec()
    };
    assert!(marched("", false).is_empty());
    assert_eq!(marched("", true), [0]);
    assert_eq!(marched("exact_stars = 3\n", true).len(), 3);
    assert_eq!(marched("name = \"lookup\"\ncount = 64\n", true).len(), 40);
    let all = plan(&scene(text(9, "", "exact_stars = 9\n")));
    assert!(all.space().many_lights.is_none() && all.scattered_field().is_none());
    let few = plan(&scene(text(8, "", "")));
    assert!(few.space().many_lights.is_none() && few.scattered_field().is_none() && few.space().marched().len() == 8);
}

/// A plan that looks from elsewhere is that of a camera there, bit by bit.
#[test]
fn a_field_of_many_lights_is_seen_from_elsewhere() {
    let there = text(20, FORWARD, "").replace("0.3 0.2 5", "2 -1 4").replace("26 deg", "30 deg");
    let mut moved =
        Planner::new(&options()).with_quality(Quality::Fixed(60)).plan(scene(text(20, FORWARD, "")), None, &Control::default()).unwrap();
    let there = Planner::new(&options()).with_quality(Quality::Fixed(60)).plan(scene(there), None, &Control::default()).unwrap();
    let before = light(&moved);
    moved.look_from(there.camera().clone(), &Control::default()).unwrap();
    assert!(light(&moved) == light(&there) && light(&moved) != before);
}

fn options() -> Options {
    Options::default()
}

/// Too little memory for depths and field: coarser ones, then an error that says what is needed.
#[test]
fn a_field_of_many_lights_keeps_to_its_memory() {
    let scene = scene(text(40, FORWARD, ""));
    let by = |memory_limit: u64| Planner::new(&Options::within(memory_limit)).plan(&scene, None, &Control::default());
    let (large, small) = (by(DEFAULT_LIMIT).unwrap(), by(3 << 20).unwrap());
    let bytes = |plan: &Planned| plan.space().many_lights.as_ref().unwrap().bytes();
    assert!(bytes(&small) < bytes(&large) / 4 && bytes(&small) < 1 << 20);
    let error = by(1 << 19).err().unwrap().to_string();
    assert!(error.contains("memory"), "{error}");
}

/// A plan that is renewed has the bits of one that is new: seen from elsewhere, with a star of another colour, with one
/// that moved, with more dust. Light that was scattered before is solved again only where something else shines.
#[test]
#[ignore = "long"]
fn what_did_not_change_is_not_baked_again() {
    // The same loader: densities that are read again are the same.
    let loader = barnard_files::in_folder(".", DEFAULT_LIMIT);
    let parsed = |text: String| barnard_files::parse("test.toml", "test", text, &loader).unwrap();
    let before = text(11, FORWARD, "exact_stars = 2\nbounces = 4\ncount = 2\n").replace("[14, 14]", "[8, 8]");
    // So much that pilots choose the same star depths and directions from every camera.
    let before = before.replace("accuracy = 3e-3", "accuracy = 1e-1");
    let first = plan(&parsed(before.clone()));
    let cases = [
        ("0.3 0.2 5", "2 -1 4", true),
        ("temperature = \"4400 K\"", "temperature = \"9400 K\"", false),
        ("position = \"0.1889", "position = \"0.2889", false),
        ("scale = \"1.2 /pc\"", "scale = \"1.5 /pc\"", false),
    ];
    for (from, to, survivors) in cases {
        assert!(before.contains(from), "{from}");
        let scene = parsed(before.replace(from, to));
        let options = Options::within(DEFAULT_LIMIT);
        let renewed = Planner::new(&options).plan(&scene, Some(&first), &Control::default()).unwrap();
        let new = plan(&scene);
        assert_eq!(renewed.expected_report().words(), new.expected_report().words(), "{from}");
        assert!(light(&renewed) == light(&new), "{from}");
        assert!(light(&renewed) != light(&first), "{from}");
        let shares = renewed.scattered_field().as_ref().unwrap().shares(first.scattered_field().as_ref().unwrap());
        assert_eq!(shares, survivors, "{from}");
    }
}
