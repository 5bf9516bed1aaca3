//! `barnard fit`.

use super::desk::{Desk, scene};

const INSTRUMENT: &str = r#"
[instrument]
aperture = "1 mm"
read_noise = "3 e"
sky = []
exposure = "5 s"
frames = 3
"#;

/// What was recorded of a scene is found again, in words, as JSON, as a scene, with residuals and a plot.
#[test]
fn scenes_are_fitted() {
    let desk = Desk::new();
    desk.write("scene.toml", (scene() + INSTRUMENT).as_bytes());
    let run = |arguments: &[&str]| {
        let output = desk.run(arguments);
        let words = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{words}");
        words
    };
    run(&["observe", "scene.toml", "-o", "master.fits"]);
    let free = "star.0.luminosity, star.0.temperature=3000..40000";
    let fit = ["fit", "scene.toml", "--to", "master.fits", "--free", free];
    let files = ["-o", "fit.json", "--found", "found.toml", "--residuals", "left.fits"];
    let plots: &[&str] = if cfg!(feature = "study") { &["--plot", "left.svg", "--corner", "corner.png"] } else { &[] };
    let words = run(&[&fit[..], &files, plots, &["--set", "star.0.luminosity=1 Lsun"]].concat());
    for part in ["2 free (1 linear)", "star.0.luminosity = ", " +- ", "Lsun (start 1;", "master.fits johnson-V: chi2 ", "wrote left.fits"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert!(!words.contains("chi2 per degree"), "{words}");
    // Other dust is another picture, whatever the star.
    let other = run(&["fit", "scene.toml", "--to", "master.fits", "--free", "star.0.luminosity", "--set", "dust.scale=8 mag/pc"]);
    assert!(other.contains("warning: chi2 per degree") && other.contains("far above 1"), "{other}");
    let found: serde_json::Value = serde_json::from_slice(&std::fs::read(desk.path("fit.json")).unwrap()).unwrap();
    let parameter = &found["parameters"][0];
    let number = |key: &str| parameter[key].as_f64().unwrap();
    let scene = barnard_files::toml::properties("scene.toml", &scene()).unwrap();
    let luminosity = barnard::properties::places::get(&scene, "star.0.luminosity").unwrap().unwrap().value.clone();
    let (_, truth) = barnard::properties::Form::of(&luminosity).unwrap();
    assert!((number("value") - truth[0]).abs() < 5.0 * number("sigma") && number("sigma") > 0.0, "{parameter} {truth:?}");
    assert!(found["converged"] == true && found["covariance"][1][1].as_f64().unwrap() > 0.0);
    run(&["render", "found.toml", "-o", "found.npy"]);
    let left = barnard_files::formats::read_image(&desk.path("left.fits"), 1 << 30).unwrap();
    assert_eq!((left.bands.len() / 2, left.bands[0].name.as_str()), (3, "johnson-B"));
    if cfg!(feature = "study") {
        assert!(std::fs::read(desk.path("corner.png")).unwrap().starts_with(b"\x89PNG"));
        assert!(String::from_utf8_lossy(&std::fs::read(desk.path("left.svg")).unwrap()).contains("standard errors"));
    }
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let desk = Desk::new();
    desk.write("scene.toml", (scene() + INSTRUMENT).as_bytes());
    assert!(desk.run(&["observe", "scene.toml", "-o", "master.fits"]).status.success());
    let refused = |arguments: &[&str], words: &[&str]| desk.refuses(&[&["fit", "scene.toml"], arguments].concat(), words);
    let to = ["--to", "master.fits", "--free"];
    refused(&[&to[..], &["star.0.luminosity=3..1"]].concat(), &["KEY=LOW..HIGH"]);
    refused(&[&to[..], &["star.9.luminosity"]].concat(), &["star.9.luminosity"]);
    refused(&[&to[..], &["star.0.luminosity", "--size", "9x9"]].concat(), &["--size", "--set"]);
    refused(&[&to[..], &["star.0.luminosity", "--set", "camera.size=[9, 9]"]].concat(), &["16 x 12 pixels", "9 x 9"]);
    refused(&[&to[..], &["star.0.luminosity", "--with", "a.toml", "--with", "b.toml"]].concat(), &["2 --with for 1 --to"]);
    refused(&[&to[..], &["star.0.luminosity", "--plot", "left.gif"]].concat(), &["left.gif"]);
    refused(&[&to[..], &["star.0.luminosity", "--corner", "left.gif"]].concat(), &["--corner left.gif"]);
    refused(&[&to[..], &["star.0.luminosity", "-o", "fit.txt"]].concat(), &["-o fit.txt", ".json"]);
    refused(&[&to[..], &["star.0.luminosity", "--found", "scene.toml"]].concat(), &["is an input of the scene"]);
    refused(&["--to", "none.fits", "--free", "star.0.luminosity"], &["none.fits"]);
    refused(&["--to", "scene.toml", "--free", "star.0.luminosity"], &["scene.toml"]);
}
