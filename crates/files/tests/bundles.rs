//! Bundles: they show the scene that they were made from, within the errors that they state, and damaged ones are refused.

use std::io::{Cursor, Read, Write};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use barnard::control::{Control, Stage};
use barnard::properties::Value;
use barnard::scene::{Loader, Scene};
use barnard::{Options, render};
use barnard_files::bundle::{Baking, Bundle, bake};
use barnard_files::{Change, SceneFile};

const LIMIT: u64 = 1 << 28;

/// Gas and dust in one turbulent cloud, other emission in a second one, and stars of a table.
const SCENE: &str = r#"
name = "Test cloud"
bands = ["hst-wfc3-f502n", "hst-wfc3-f656n"]
[camera]
kind = "perspective"
position = "0 0 8 pc"
target = "0 0 0 pc"
field_of_view = "24 deg"
size = [64, 48]
[field.t]
kind = "turbulence"
low = "-1.5 -1 -1 pc"
high = "1.5 1 1 pc"
voxels = 48
mach = 1
outer_scale = "1 pc"
slope = 5
[field.unused]
kind = "turbulence"
low = "-1 -1 -1 pc"
high = "1 1 1 pc"
voxels = 16
[field.cloud]
kind = "expression"
formula = "200 * t"
[dust]
density = "cloud"
scale = "5e-22 mag cm2"
law = "draine03_rv31"
[gas]
density = "cloud"
voxels = 48
[[emission]]
kind = "lines"
density = "t * (1 + 0.5 * x)"
lines = [{ wavelength = "656.46 nm", strength = 1 }]
scale = "1e-27 W/m3/sr"
[[star]]
kind = "blackbody"
position = "0.2 0 0 pc"
temperature = "38000 K"
luminosity = "2e4 Lsun"
[[star_table]]
file = "stars.csv"
kind = "blackbody"
"#;

/// The scene, its bundle, and the folder of its files.
fn source() -> &'static (SceneFile, Bundle, tempfile::TempDir) {
    static MADE: OnceLock<(SceneFile, Bundle, tempfile::TempDir)> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("stars.csv"), "x [pc],y [pc],z [pc],temperature [K],luminosity [Lsun]\n0.5,0.4,0.1,9000,100\n")
            .unwrap();
        std::fs::write(folder.path().join("cloud.toml"), SCENE).unwrap();
        let file = SceneFile::open(&folder.path().join("cloud.toml"), LIMIT, Loader::clone).unwrap();
        let bundle = bake(&file, &Baking { bytes: 300_000, options: Options::within(LIMIT), compares: true }, &Control::default()).unwrap();
        (file, bundle, folder)
    })
}

/// Opens bytes, and counts the reports of the solver of gas.
fn opened(bytes: &[u8], changes: &[Change]) -> (barnard::Result<Scene>, usize) {
    let solved = Arc::new(AtomicUsize::new(0));
    let count = solved.clone();
    let control = Control::with_listener(move |stage, _, _| {
        count.fetch_add(usize::from(stage == Stage::Gas), Ordering::Relaxed);
    });
    let scene = Bundle::read(Cursor::new(bytes), Path::new("a.barnard"), LIMIT)
        .and_then(|bundle| bundle.scene_with("a.barnard", changes, LIMIT, |loader| loader.under(&control)));
    (scene.map(|file| file.scene), solved.load(Ordering::Relaxed))
}

/// A bundle opens without its source's files and without a solution of its gas; its picture differs from that of the source by what
/// it states.
#[test]
fn bundles_show_their_scene() {
    let (file, bundle, _) = source();
    let bytes = bundle.encoded().unwrap();
    assert!(bytes.len() <= 300_000, "{}", bytes.len());
    let (scene, solved) = opened(&bytes, &[]);
    let scene = scene.unwrap();
    assert_eq!((solved, scene.stars.len(), scene.name.as_str()), (0, 2, "Test cloud"));
    assert_eq!(bundle.source, SCENE);
    assert!(!bundle.text.contains("turbulence") && bundle.text.contains("stars.csv"), "{}", bundle.text);
    let [a, b] = [&file.scene, &scene].map(|scene| render(scene, &Options::within(LIMIT)).unwrap());
    let errors = bundle.errors.picture.unwrap();
    let mut largest = 0.0f64;
    for band in 0..2 {
        let sum = |value: &dyn Fn(f64, f64) -> f64| a.band(band).zip(b.band(band)).map(|(a, b)| value(a, b)).sum::<f64>();
        largest = largest.max((sum(&|a, b| (a - b).powi(2)) / sum(&|a, _| a * a)).sqrt());
    }
    assert!((largest / errors.rms - 1.0).abs() < 1e-6 && largest > 1e-4, "{largest} {errors:?}");
    assert!(errors.rms < 0.05 && errors.total < 0.02, "{:?}", errors);
    let picture = zune_jpeg::JpegDecoder::new(Cursor::new(&bundle.preview)).decode().unwrap();
    assert_eq!(picture.len(), 3 * 64 * 48);
}

/// Other dust leaves the gas as it was solved; another star has it solved again.
#[test]
fn changed_bundles_are_solved_again() {
    let bytes = source().1.encoded().unwrap();
    let change = |key: &str, value: &str| [Change { key: key.into(), value: Value::Text(value.into()) }];
    let (dustier, solved) = opened(&bytes, &change("dust.scale", "1e-21 mag cm2"));
    assert!(dustier.is_ok() && solved == 0);
    let (hotter, solved) = opened(&bytes, &change("star.0.temperature", "45000 K"));
    assert!(hotter.is_ok() && solved > 0);
}

/// A file is saved and opened by its extension; a limit that nothing fits into is an error.
#[test]
fn bundles_are_files() {
    let (file, bundle, _) = source();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cloud.barnard");
    bundle.save(&path).unwrap();
    let scene = barnard_files::load(&path, LIMIT).unwrap();
    assert_eq!(scene.provenance.as_ref().unwrap().files, [path]);
    let small = bake(file, &Baking { bytes: 5_000, options: Options::within(LIMIT), compares: true }, &Control::default());
    let message = small.unwrap_err().to_string();
    assert!(message.contains("MB") && message.contains("--limit"), "{message}");
}

/// Any damage is an error or changes nothing, and never a panic.
#[test]
fn damaged_bundles_are_refused() {
    let bytes = source().1.encoded().unwrap();
    let whole = Bundle::read(Cursor::new(&bytes), Path::new("a.barnard"), LIMIT).unwrap();
    let mut refused = 0;
    let places: Vec<usize> = (0..bytes.len()).step_by(bytes.len() / 400).collect();
    for at in &places {
        let mut damaged = bytes.clone();
        damaged[*at] ^= 0x24;
        match Bundle::read(Cursor::new(&damaged), Path::new("a.barnard"), LIMIT) {
            Ok(read) => assert_eq!((read.text, read.preview), (whole.text.clone(), whole.preview.clone()), "{at}"),
            Err(_) => refused += 1,
        }
        assert!(Bundle::read(Cursor::new(&bytes[..*at]), Path::new("a.barnard"), LIMIT).is_err());
    }
    assert!(refused > places.len() * 9 / 10, "{refused} of {}", places.len());
    assert!(Bundle::read(Cursor::new(&bytes), Path::new("a.barnard"), 10_000).is_err());
}

/// A bundle with another text of an entry.
fn with_entry(name: &str, edit: impl Fn(&str) -> String) -> Vec<u8> {
    let bytes = source().1.encoded().unwrap();
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut edited = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).unwrap();
        let entry_name = entry.name().unwrap().into_owned();
        let mut content = Vec::new();
        entry.read_to_end(&mut content).unwrap();
        if entry_name == name {
            content = edit(&String::from_utf8(content).unwrap()).into_bytes();
        }
        edited.start_file(entry_name, zip::write::SimpleFileOptions::default()).unwrap();
        edited.write_all(&content).unwrap();
    }
    edited.finish().unwrap().into_inner()
}

/// Wrong manifests are refused with the reason.
#[test]
fn wrong_manifests_are_refused() {
    let replaced = |from: &'static str, to: &'static str| {
        move |text: &str| {
            assert!(text.contains(from), "{text}");
            text.replacen(from, to, 1)
        }
    };
    for (from, to, expected) in [
        ("version = 1", "version = 2", "reads version 1"),
        ("barnard bundle", "another", "\"barnard bundle\""),
        ("\"stars.csv\"", "\"../stars.csv\"", "leaves the folder"),
        ("\"stars.csv\"", "\"other.csv\"", "other.csv"),
        ("exponent = ", "exponent = 999", "shape"),
        ("shape = [", "shape = [9, ", "3 whole numbers"),
        ("times = [\"0\"]", "times = [\"1\"]", "product"),
    ] {
        let bytes = with_entry("manifest.toml", replaced(from, to));
        let message = Bundle::read(Cursor::new(&bytes), Path::new("a.barnard"), LIMIT).err().unwrap().to_string();
        assert!(message.contains(expected) && message.contains("a.barnard"), "{from}: {message}");
    }
}
