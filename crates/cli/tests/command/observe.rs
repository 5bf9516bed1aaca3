//! `barnard observe`: frames and masters, and what is refused before anything is rendered.

use super::desk::{Desk, scene};

const INSTRUMENT: &str = r#"
[instrument]
aperture = "0.5 m"
read_noise = "3 e"
sky = "21 mag"
exposure = "10 s"
frames = 3
"#;

fn desk() -> Desk {
    let desk = Desk::new();
    desk.write("scene.toml", (scene() + INSTRUMENT).as_bytes());
    desk
}

/// Frames have numbers from one on, the master stands beside them, and words say what was gathered. What the command line says
/// takes the place of what the scene says.
#[test]
fn frames_and_masters_are_written() {
    let desk = desk();
    let output = desk.run(&[
        "observe",
        "scene.toml",
        "-o",
        "master.fits",
        "-o",
        "seen.png",
        "--raw",
        "raw_%02d.fits",
        "--number",
        "2",
        "--exposure",
        "40 s",
    ]);
    let words = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words}");
    for part in ["2 frames of 40 s", "e/s of the sky per pixel", "wrote raw_02.fits", "wrote master.fits", "wrote seen.png"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert!(!desk.path("raw_03.fits").exists());
    let card = |file: &str, card: &str| String::from_utf8_lossy(&std::fs::read(desk.path(file)).unwrap()).contains(card);
    assert!(card("raw_01.fits", "BUNIT   = 'adu     '") && card("raw_02.fits", "EXPTIME =                  4E1"));
    assert!(card("master.fits", "EXPTIME =                  8E1") && card("master.fits", "EXTNAME = 'mask.johnson-V'"));
    // The same seed is the same noise, another is other noise.
    let raw = |seed: &str| {
        assert!(desk.run(&["observe", "scene.toml", "--raw", "again_%d.fits", "--number", "1", "--seed", seed]).status.success());
        // The head says when a file was written.
        std::fs::read(desk.path("again_1.fits")).unwrap().split_off(2880)
    };
    let first = raw("5");
    assert!(first == raw("5") && first != raw("6"));
}

#[test]
fn what_cannot_be_observed_is_refused_at_once() {
    let desk = desk();
    let refused = |arguments: &[&str], words: &[&str]| desk.refuses(&[&["observe", "scene.toml"], arguments].concat(), words);
    refused(&[], &["-o master.fits"]);
    refused(&["-o", "m.gif"], &["gif"]);
    refused(&["-o", "m.fits", "--raw", "raw.fits"], &["raw_%03d.fits"]);
    refused(&["-o", "m.fits", "--raw", "raw_%03d.png"], &["raw_%03d.fits"]);
    refused(&["-o", "raw_2.fits", "--raw", "raw_%d.fits"], &["raw_2.fits", "rename it"]);
    refused(&["-o", "m.fits", "--exposure", "-3 s"], &["exposure"]);
    refused(&["-o", "m.fits", "--number", "0"], &["1 to 10000"]);
    refused(&["-o", "m.fits", "--preset", "hubble"], &["hst-wfc3-uvis"]);
    // Finer than the picture, and a mosaic of other passbands: asked before a picture that would take an hour.
    let foreign = ["-o", "m.fits", "--preset", "hst-wfc3-uvis", "--size", "4000x4000", "--backend", "reference"];
    refused(&foreign, &["johnson-B", "hst-wfc3-f953n", "allow_foreign_filters"]);
    let set = ["--set", "bands=[\"hst-wfc3-f555w\"]"];
    refused(&[&foreign[..], &set].concat(), &["finer", "per row"]);
    let set = ["--set", "bands=hoo-3nm"];
    refused(
        &[&["-o", "m.fits", "--preset", "refractor-0.2m-duo", "--size", "4000x4000", "--backend", "reference"], &set[..]].concat(),
        &["finer"],
    );
    desk.write("scene.toml", scene().as_bytes());
    refused(&["-o", "m.fits"], &["no instrument", "list instruments"]);
    let biased = "[instrument]\naperture = \"0.5 m\"\nbias = \"70000 ADU\"\n";
    desk.write("scene.toml", (scene() + biased).as_bytes());
    refused(&["-o", "m.fits"], &["bias", "65535", "instrument.bias"]);
}
