//! `barnard plates` and `barnard expose`.

use super::desk::{Desk, scene};

/// Pictures of plates are those that are rendered, other keys of the scene change them, and what plates cannot show is refused.
#[test]
fn plates_are_exposed() {
    let desk = Desk::new();
    desk.write("scene.toml", scene().as_bytes());
    let run = |arguments: &[&str]| {
        let output = desk.run(arguments);
        let words = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{words}");
        words
    };
    let words = run(&["plates", "scene.toml", "-o", "own.plates", "--range", "400 nm", "900 nm"]);
    assert!(words.contains("wrote own.plates") && words.contains(" nm, "), "{words}");
    let words = run(&["expose", "own.plates", "scene.toml", "-o", "own.npy", "--verbose"]);
    assert!(words.contains("spectral error at most") && words.contains("wrote own.npy"), "{words}");
    run(&["render", "scene.toml", "-o", "fresh.npy"]);
    let mean = |file: &str| {
        let image = barnard_files::formats::read_image(&desk.path(file), 1 << 30).unwrap();
        (0..image.bands.len()).map(|band| image.band(band).sum::<f64>()).collect::<Vec<f64>>()
    };
    let near = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 3e-3);
    assert!(near(&mean("own.npy"), &mean("fresh.npy")));
    let hot = "star.0.luminosity=1234 Lsun";
    run(&["expose", "own.plates", "scene.toml", "-o", "hot.npy", "--set", hot]);
    run(&["render", "scene.toml", "-o", "hot_fresh.npy", "--set", hot]);
    assert!(near(&mean("hot.npy"), &mean("hot_fresh.npy")) && !near(&mean("hot.npy"), &mean("own.npy")));
    let refused = |arguments: &[&str], words: &[&str]| desk.refuses(arguments, words);
    let expose = ["expose", "own.plates", "scene.toml", "-o", "x.npy"];
    refused(&[&expose[..], &["--size", "9x9"]].concat(), &["camera", "make new plates"]);
    refused(&[&expose[..], &["--set", "bands=2mass"]].concat(), &["outside of the range"]);
    refused(&[&expose[..], &["--set", "dust.scale=99 /pc"]].concat(), &["amount of dust"]);
    refused(&["plates", "scene.toml", "-o", "x.plates", "--dust", "2", "3"], &["dust range of plates"]);
    refused(&[&expose[..], &["--set", "bands"]].concat(), &["KEY=VALUE"]);
    refused(&[&expose[..], &["--set", "star.7.luminosity=1 Lsun"]].concat(), &["star"]);
    refused(&["expose", "scene.toml", "scene.toml", "-o", "x.npy"], &["scene.toml"]);
    refused(&["plates", "scene.toml", "-o", "x.npz"], &[".plates"]);
    refused(&["plates", "scene.toml", "-o", "x.plates", "--range", "700 nm", "400 nm"], &["range of plates"]);
    // A file that ends early is none.
    let whole = std::fs::read(desk.path("own.plates")).unwrap();
    desk.write("short.plates", &whole[..whole.len() / 2]);
    refused(&["expose", "short.plates", "scene.toml", "-o", "x.npy"], &["short.plates"]);
}
