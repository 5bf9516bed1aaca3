//! The command as a user meets it: good input works, bad input gives one clear message, status 1 or 2 and no file.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

struct Desk {
    folder: tempfile::TempDir,
}

const SCENE: &str = r#"
bands = "johnson"
[camera]
kind = "perspective"
position = "0 0 5 pc"
field_of_view = "30 deg"
size = [16, 12]
[field.cloud]
kind = "grid"
file = "cloud.npy"
low = "-1 -1 -1 pc"
high = "1 1 1 pc"
[dust]
density = "cloud"
scale = "2 mag/pc"
law = "fitzpatrick99"
albedo = 0.6
[[star]]
kind = "blackbody"
position = "0.3 0.3 0.3 pc"
temperature = "12000 K"
luminosity = "500 Lsun"
"#;

/// A version 1.0 .npy file.
fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(data);
    bytes
}

fn cloud(change: impl Fn(usize) -> f32) -> Vec<u8> {
    let data: Vec<u8> = (0..512).flat_map(|i| change(i).to_le_bytes()).collect();
    npy("<f4", "(8, 8, 8)", &data)
}

impl Desk {
    fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        desk.write("cloud.npy", &cloud(|i| 0.5 + 0.4 * (i as f32).sin()));
        desk.write("scene.toml", SCENE.as_bytes());
        desk
    }
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }
    fn with(&self, from: &str, to: &str) -> &Self {
        assert!(SCENE.contains(from), "{from}");
        self.write("scene.toml", SCENE.replace(from, to).as_bytes());
        self
    }
    fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_barnard")).args(arguments).current_dir(self.folder.path()).output().unwrap()
    }
    /// Renders the scene and expects that it goes well.
    #[cfg(feature = "study")]
    fn renders(&self, arguments: &[&str]) {
        let output = self.run(&[&["render", "scene.toml"], arguments].concat());
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    /// Renders and expects a message with all of `words`, a failing status, no panic and no file.
    fn refuses(&self, arguments: &[&str], words: &[&str]) {
        let before = listing(self.folder.path());
        let output = self.run(arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success(), "{arguments:?} went through");
        assert!(output.status.code().is_some_and(|c| c == 1 || c == 2), "{:?}: {message}", output.status);
        for word in words {
            assert!(message.contains(word), "\"{word}\" is not in: {message}");
        }
        assert!(!message.contains("panicked"), "{message}");
        assert_eq!(before, listing(self.folder.path()), "files were left behind");
    }
    fn refuses_scene(&self, words: &[&str]) {
        self.refuses(&["render", "scene.toml", "-o", "out.npy"], words);
    }
}

fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut names: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    names
}

/// One bounce by chance is the reference's picture, within the errors that stand beside it; more bounces are brighter;
/// a target ends it; settings of others are refused.
#[test]
#[cfg(feature = "study")]
fn paths_referee() {
    let desk = Desk::new();
    desk.renders(&["--backend", "reference", "-o", "truth.fits"]);
    desk.renders(&["--backend", "path", "--bounces", "1", "--samples", "400", "-o", "once.fits", "-o", "once.png"]);
    let compared = desk.run(&["compare", "once.fits", "truth.fits", "--json", "--tolerance", "0.2"]);
    let list: serde_json::Value = serde_json::from_slice(&compared.stdout).unwrap();
    assert!(compared.status.success() && list.as_array().unwrap().len() == 3, "{list}");
    for band in list.as_array().unwrap() {
        assert!((0.5..2.0).contains(&band["chi_squared"].as_f64().unwrap()), "{list}");
    }
    desk.renders(&["--backend", "path", "--bounces", "1000", "--target-error", "0.5", "--samples", "100000", "-o", "soon.fits"]);
    // The same paths go on behind their first scattering: no pixel is darker, all together are brighter.
    let light = |bounces: &str| {
        desk.renders(&["--backend", "path", "--bounces", bounces, "--samples", "100", "-o", "light.npy"]);
        let bytes = std::fs::read(desk.path("light.npy")).unwrap();
        let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let values: Vec<f64> = bytes[header..].chunks_exact(8).map(|v| f64::from_le_bytes(v.try_into().unwrap())).collect();
        // Errors stand behind the bands.
        values[..values.len() / 2].iter().sum::<f64>()
    };
    let (once, twice, many) = (light("1"), light("2"), light("1000"));
    assert!(twice > 1.05 * once && many > 1.02 * twice && many < 5.0 * once, "{once:e} {twice:e} {many:e}");
    desk.refuses(&["render", "scene.toml", "-o", "x.fits", "--backend", "reference", "--bounces", "2"], &["bounces = 1"]);
    // Methods that know one bounce are left out; what the path tracer would need stands beside the others.
    let bench =
        ["bench", "scene.toml", "--bounces", "3", "--methods", "lookup,band_quadrature", "--frames", "1", "--error-size", "8", "--json"];
    let rows: serde_json::Value = serde_json::from_slice(&desk.run(&bench).stdout).unwrap();
    let row = |name: &str| rows.as_array().unwrap().iter().find(|r| r["method"].as_str().unwrap().starts_with(name));
    assert!(
        row("lookup").is_none() && row("band_quadrature").is_some() && row("path").unwrap()["seconds"].as_f64().unwrap() > 0.0,
        "{rows}"
    );
    let render = desk.run(&["render", "scene.toml", "-o", "x.npy", "--bounces", "3"]);
    let words = String::from_utf8_lossy(&render.stdout).into_owned();
    assert!(
        render.status.success() && words.contains("many bounces: 2 orders of scattering") && words.contains("angular about"),
        "{words}"
    );
    // In two runs or in one, it is the same picture.
    desk.renders(&["--backend", "path", "--samples", "8", "--state", "s.npz", "-o", "half.fits"]);
    desk.renders(&["--backend", "path", "--samples", "16", "--state", "s.npz", "-o", "two.fits"]);
    desk.renders(&["--backend", "path", "--samples", "16", "-o", "one.fits"]);
    assert!(std::fs::read(desk.path("one.fits")).unwrap() == std::fs::read(desk.path("two.fits")).unwrap());
    assert!(std::fs::read(desk.path("one.fits")).unwrap() != std::fs::read(desk.path("half.fits")).unwrap());
    let again = |more: &[&str], words: &[&str]| {
        desk.refuses(&[&["render", "scene.toml", "-o", "x.fits", "--backend", "path", "--state", "s.npz"], more].concat(), words);
    };
    again(&["--seed", "2"], &["s.npz", "another seed"]);
    again(&["--bounces", "2"], &["s.npz", "another number of bounces"]);
    again(&["--size", "8x8"], &["s.npz", "another size"]);
    desk.with("12000 K", "11000 K");
    again(&[], &["s.npz", "another scene"]);
    desk.with("12000 K", "12000 K");
    let whole = std::fs::read(desk.path("s.npz")).unwrap();
    desk.write("s.npz", &whole[..whole.len() / 2]);
    again(&[], &["s.npz", "no .npz archive"]);
    desk.refuses(&["render", "scene.toml", "-o", "x.fits", "--backend", "path", "--state", "s.txt"], &["--state", ".npz"]);
    desk.refuses(&["render", "scene.toml", "-o", "x.fits", "--samples", "4"], &["--backend path"]);
    desk.refuses(&["render", "scene.toml", "-o", "x.fits", "--backend", "path", "--steps", "4"], &["--steps", "--samples"]);
    desk.refuses(&["render", "scene.toml", "-o", "x.fits", "--backend", "path", "--samples", "0"], &["--samples 0"]);
    desk.refuses(&["render", "scene.toml", "-o", "x.fits", "--backend", "path", "--bounces", "0"], &["--bounces 0"]);
    desk.refuses(&["render", "scene.toml", "-o", "x.fits", "--backend", "path", "--target-error", "nan"], &["--target-error NaN"]);
}

#[test]
fn renders_every_format_and_compares_them() {
    let desk = Desk::new();
    let output = desk.run(&["render", "scene.toml", "-o", "a.npy", "-o", "a.fits", "-o", "a.exr", "-o", "a.png"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("rays/s") && text.contains("spectral error at most"), "{text}");
    for other in ["a.fits", "a.exr"] {
        assert!(desk.run(&["compare", "a.npy", other, "--tolerance", "1e-7"]).status.success(), "{other}");
    }
    assert!(std::fs::read(desk.path("a.png")).unwrap().starts_with(b"\x89PNG"));
    // Another star is another picture, and compare says so by its status.
    desk.with("12000 K", "11000 K");
    assert!(desk.run(&["render", "scene.toml", "-o", "b.npy"]).status.success());
    assert_eq!(desk.run(&["compare", "b.npy", "a.npy", "--tolerance", "1e-3"]).status.code(), Some(1));
}

/// A reader that stops listening does not stop the render.
#[cfg(unix)]
#[test]
fn a_closed_pipe_loses_nothing() {
    let desk = Desk::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_barnard"))
        .args(["render", "scene.toml", "-o", "out.npy"])
        .current_dir(desk.folder.path())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
    assert!(desk.path("out.npy").is_file());
}

#[test]
fn the_cpu_agrees_with_the_reference() {
    let desk = Desk::new();
    assert!(desk.run(&["render", "scene.toml", "-o", "cpu.npy"]).status.success());
    assert!(desk.run(&["render", "scene.toml", "-o", "truth.npy", "--backend", "reference"]).status.success());
    let output = desk.run(&["compare", "cpu.npy", "truth.npy", "--tolerance", "3e-3"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}

#[test]
fn the_same_bits_on_one_thread_and_on_many() {
    let desk = Desk::new();
    for threads in ["1", "5"] {
        assert!(desk.run(&["render", "scene.toml", "-o", &format!("{threads}.npy"), "--threads", threads]).status.success());
    }
    assert_eq!(std::fs::read(desk.path("1.npy")).unwrap(), std::fs::read(desk.path("5.npy")).unwrap());
}

#[test]
fn every_method_renders() {
    let desk = Desk::new();
    // A closed form holds for one law alone.
    desk.refuses(&["render", "scene.toml", "-o", "m.npy", "--method", "analytic"], &["inverse_wavelength"]);
    desk.with("fitzpatrick99", "inverse_wavelength");
    assert!(desk.run(&["render", "scene.toml", "-o", "truth.npy", "--backend", "reference"]).status.success());
    let list = desk.run(&["list", "methods", "--json"]);
    let names: Vec<String> = String::from_utf8(list.stdout)
        .unwrap()
        .lines()
        .filter_map(|l| l.trim().strip_prefix("\"name\": \"")?.strip_suffix("\",").map(str::to_owned))
        .collect();
    assert!(names.len() >= 5);
    for name in names {
        let output = desk.run(&["render", "scene.toml", "--method", &name, "-o", "m.npy"]);
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        // One wavelength is no spectrum, and four random ones are noisy; analytic fits real filters with a polynomial.
        let tolerance = match name.as_str() {
            "fixed_wavelength" => "0.2",
            "sampled" => "0.05",
            // 1/r² between voxels, with the star among eight of them along an edge: the pilots state it, and warn.
            "propagation" => "0.06",
            _ => "0.01",
        };
        let compared = desk.run(&["compare", "m.npy", "truth.npy", "--tolerance", tolerance]);
        assert!(compared.status.success(), "{name}: {}", String::from_utf8_lossy(&compared.stdout));
    }
}

#[test]
fn every_catalogue_lists() {
    let desk = Desk::new();
    let names = String::from_utf8(desk.run(&["list"]).stdout).unwrap();
    assert!(names.lines().count() >= 15);
    for line in names.lines() {
        let name = line.split_whitespace().next().unwrap();
        let rows = String::from_utf8(desk.run(&["list", name]).stdout).unwrap();
        assert!(rows.lines().count() >= 2 && rows.lines().all(|l| l.split_whitespace().count() >= 2), "{name}: {rows}");
    }
    assert!(String::from_utf8(desk.run(&["list", "passbands"]).stdout).unwrap().lines().count() == 209);
}

#[test]
fn every_built_in_scene_is_valid() {
    for scene in barnard_files::builtin::SCENES {
        barnard_files::builtin::load(scene.name, barnard::memory::DEFAULT_LIMIT).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
    }
}

#[test]
fn check_prints_the_plan() {
    let output = Desk::new().run(&["check", "scene.toml"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for word in ["nodes", "memory", "steps", "johnson-B", "ok"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn unknown_keys_and_names_are_answered_with_the_nearest() {
    let desk = Desk::new();
    desk.with("albedo = 0.6", "albdeo = 0.6").refuses_scene(&["albdeo", "did you mean \"albedo\"", "scene.toml:17"]);
    desk.with("fitzpatrick99", "fitzpatrik99").refuses_scene(&["fitzpatrik99", "fitzpatrick99", "scene.toml:16"]);
    desk.with("\"johnson\"", "\"jonson\"").refuses_scene(&["jonson", "did you mean \"johnson"]);
    desk.with("kind = \"blackbody\"", "kind = \"blackbodi\"").refuses_scene(&["blackbodi", "blackbody"]);
    desk.with("density = \"cloud\"", "density = \"clud\"").refuses_scene(&["clud", "cloud"]);
    desk.with("kind = \"grid\"", "kind = \"gird\"").refuses_scene(&["gird", "grid"]);
}

#[test]
fn wrong_units_and_values_are_named() {
    let desk = Desk::new();
    desk.with("30 deg", "30 pc").refuses_scene(&["30 pc", "angle", "field_of_view", "scene.toml:6"]);
    desk.with("2 mag/pc", "2 mag").refuses_scene(&["2 mag", "mag/pc"]);
    desk.with("12000 K", "-5 K").refuses_scene(&["-5 K", "above zero"]);
    desk.with("albedo = 0.6", "albedo = 1.5").refuses_scene(&["albedo"]);
    desk.with("[16, 12]", "[0, 12]").refuses_scene(&["0 x 12", "size"]);
    desk.with("\"0 0 5 pc\"", "\"0 0 pc\"").refuses_scene(&["position"]);
    desk.with("bands = \"johnson\"", "bands = 'johnson").refuses_scene(&["scene.toml:2"]);
}

#[test]
fn keys_that_would_be_ignored_are_refused() {
    let desk = Desk::new();
    let magnitude = "luminosity = \"500 Lsun\"\ndistance = \"100 pc\"";
    desk.with("luminosity = \"500 Lsun\"", magnitude).refuses_scene(&["\"distance\" goes with magnitude"]);
    let wavelength = "luminosity = \"500 Lsun\"\nwavelength = \"500 nm\"";
    desk.with("luminosity = \"500 Lsun\"", wavelength).refuses_scene(&["\"wavelength\" goes with spectral_luminosity"]);
    desk.with("\"cloud.npy\"", "\"cloud.npy\"\narray = \"density\"").refuses_scene(&["without a name", "cloud.npy"]);
    let phase = "albedo = 0.6\nphase = { kind = \"henyey_greenstein\", g = 0.5, g_file = \"g.csv\" }";
    desk.with("albedo = 0.6", phase).refuses_scene(&["g_file", "not both"]);
}

#[test]
fn bad_densities_are_counted() {
    let desk = Desk::new();
    desk.write("cloud.npy", &cloud(|i| if i % 100 == 7 { -1.0 } else { 1.0 }));
    desk.refuses_scene(&["6 negative cells of 512 cells", "cloud"]);
    desk.write("cloud.npy", &cloud(|i| if i == 9 { f32::NAN } else { 1.0 }));
    desk.refuses_scene(&["1 cells that are NaN or infinite", "[0, 1, 1]"]);
    desk.write("cloud.npy", &cloud(|i| if i == 9 { f32::INFINITY } else { 1.0 }));
    desk.refuses_scene(&["NaN or infinite"]);
}

#[test]
fn broken_grids_are_refused_before_they_are_believed() {
    let desk = Desk::new();
    let good = cloud(|_| 1.0);
    desk.write("cloud.npy", &good[..1000]);
    desk.refuses_scene(&["truncated", "cloud.npy"]);
    desk.write("cloud.npy", b"hello");
    desk.refuses_scene(&["no .npy array", "cloud.npy"]);
    desk.write("cloud.npy", &npy("<f4", "(8, 64)", &good[128..]));
    desk.refuses_scene(&["2 axes", "three"]);
    desk.write("cloud.npy", &npy("<f4", "(99999, 99999, 99999)", &[0; 64]));
    desk.refuses_scene(&["MiB"]);
    desk.write("cloud.npy", &npy("<c8", "(2, 2, 2)", &[0; 64]));
    desk.refuses_scene(&["no real numbers"]);
    desk.write("cloud.npy", &npy("<f4", "(0, 8, 8)", &[]));
    desk.refuses_scene(&["empty"]);
    // A header that is cut, twisted or longer than the file.
    for length in [8, 10, 20, 60] {
        desk.write("cloud.npy", &good[..length]);
        desk.refuses_scene(&["cloud.npy"]);
    }
    std::fs::remove_file(desk.path("cloud.npy")).unwrap();
    desk.refuses_scene(&["cannot be read", "cloud.npy"]);
}

#[test]
fn broken_archives_and_fits_are_refused() {
    let desk = Desk::new();
    desk.with("cloud.npy", "no.npy").refuses_scene(&["no.npy", "scene.toml:", "[field.cloud] file"]);
    desk.write("cloud.npz", b"PK\x03\x04 nothing");
    desk.with("cloud.npy", "cloud.npz").refuses_scene(&["cloud.npz"]);
    let mut fits = b"SIMPLE  =                    T".to_vec();
    fits.resize(2880, b' ');
    desk.write("cloud.fits", &fits);
    desk.with("cloud.npy", "cloud.fits").refuses_scene(&["cloud.fits", "END"]);
    let card = |text: &str| format!("{text:<80}");
    let header = |axes: &str| {
        let cards = [
            "SIMPLE  =                    T",
            "BITPIX  =                  -32",
            "NAXIS   =                    3",
            axes,
            "NAXIS2  =                    8",
            "NAXIS3  =                    8",
            "END",
        ];
        let mut bytes: Vec<u8> = cards.iter().flat_map(|c| card(c).into_bytes()).collect();
        bytes.resize(2880, b' ');
        bytes
    };
    desk.write("cloud.fits", &header("NAXIS1  =                    8")[..1000]);
    desk.refuses_scene(&["truncated", "cloud.fits"]);
    desk.write("cloud.fits", &header("NAXIS1  =                    8"));
    desk.refuses_scene(&["truncated", "cloud.fits"]);
    desk.write("cloud.fits", &header("NAXIS1  =  9223372036854775807"));
    desk.refuses_scene(&["cloud.fits"]);
    // And a good one renders.
    let mut good = header("NAXIS1  =                    8");
    good.extend((0..512).flat_map(|_| 0.7f32.to_be_bytes()));
    good.resize(5760, 0);
    desk.write("cloud.fits", &good);
    assert!(desk.run(&["render", "scene.toml", "-o", "fits.npy"]).status.success());
}

#[test]
fn laws_and_passbands_must_meet() {
    let desk = Desk::new();
    desk.with("\"johnson\"", "\"jwst-miri\"").refuses_scene(&["fitzpatrick99", "valid from", "jwst-miri"]);
    desk.write("band.csv", b"wavelength_nm,t\n500,0\n600,0\n");
    let own = "[[band]]\nname = \"mine\"\nkind = \"file\"\nfile = \"band.csv\"\n[camera]";
    desk.with("bands = \"johnson\"\n[camera]", own).refuses_scene(&["empty", "band.csv"]);
    desk.write("band.csv", b"wavelength_nm,t\n500,0.1\n400,x\n");
    desk.refuses_scene(&["line 3", "band.csv"]);
    desk.write("band.csv", b"wavelength_nm,t\n500,0.1\n520,0.9\n600,0.3\n");
    assert!(desk.run(&["render", "scene.toml", "-o", "own.npy"]).status.success());
}

#[test]
fn a_buried_star_is_noticed() {
    Desk::new().with("2 mag/pc", "5000 mag/pc").refuses_scene(&["star 1", "optical depth"]);
    let desk = Desk::new();
    desk.with("2 mag/pc", "5000 mag/pc").refuses(&["render", "scene.toml", "-o", "out.npy", "--steps", "20"], &["star 1", "optical depth"]);
}

#[test]
fn impossible_sizes_and_outputs_are_refused_at_once() {
    let desk = Desk::new();
    let render = |rest: &[&'static str]| [&["render", "scene.toml"], rest].concat();
    desk.refuses(&render(&["-o", "missing/out.npy"]), &["missing", "does not exist"]);
    desk.refuses(&render(&["-o", "out.gif"]), &["gif", ".png"]);
    desk.refuses(&render(&["-o", "out.npy", "--size", "0x5"]), &["1920x1080"]);
    desk.refuses(&render(&["-o", "out.npy", "--size", "60000x60000"]), &["MiB", "the image"]);
    desk.refuses(&render(&["-o", "out.npy", "--memory", "0.000001"]), &["MiB"]);
    desk.refuses(&render(&["-o", "out.npy", "--accuracy", "0"]), &["accuracy"]);
    desk.refuses(&render(&["-o", "out.npy", "--method", "midpont"]), &["midpont", "midpoint"]);
    desk.refuses(&["render", "nowhere.toml", "-o", "out.npy"], &["nowhere.toml"]);
    desk.refuses(&["render", "--builtin", "pilars", "-o", "out.npy"], &["pilars", "pillars"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_render_leaves_nothing() {
    let desk = Desk::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_barnard"))
        .args(["render", "scene.toml", "-o", "out.npy", "--size", "6000x6000", "--backend", "reference"])
        .current_dir(desk.folder.path())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(800));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait().unwrap();
    assert_eq!(output.code(), Some(1));
    assert_eq!(listing(desk.folder.path()).len(), 2, "files were left behind");
}

/// A folder that takes no file, not even from root.
#[cfg(target_os = "linux")]
#[test]
fn an_unwritable_folder_is_refused() {
    let desk = Desk::new();
    desk.refuses(&["render", "scene.toml", "-o", "/proc/out.npy"], &["/proc", "cannot be written"]);
}

#[test]
fn completions_end_quietly_in_a_closed_pipe() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_barnard"))
        .args(["completions", "bash"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"));
    assert!(Desk::new().run(&["completions", "zsh"]).stdout.len() > 1000);
}

#[test]
fn inputs_are_not_overwritten() {
    let desk = Desk::new();
    let before = std::fs::read(desk.path("cloud.npy")).unwrap();
    desk.refuses(&["render", "scene.toml", "-o", "cloud.npy"], &["cloud.npy", "another name"]);
    desk.refuses(&["render", "scene.toml", "-o", "./../../nowhere/../cloud.npy"], &["cloud.npy"]);
    std::fs::rename(desk.path("scene.toml"), desk.path("scene.png")).unwrap();
    desk.refuses(&["render", "scene.png", "-o", "scene.png"], &["another name"]);
    assert_eq!(before, std::fs::read(desk.path("cloud.npy")).unwrap());
}

#[test]
fn numbers_past_single_precision_are_refused() {
    let desk = Desk::new();
    desk.with("\"2 mag/pc\"", "\"1e60 mag/pc\"").refuses_scene(&["dust"]);
    desk.with("[[star]]", "[background]\nkind = \"power_law\"\nexponent = 0\nradiance = \"1e60 W/m2/sr/nm\"\n[[star]]").refuses_scene(&[
        "background",
        "single precision",
        "unit of its brightness",
    ]);
    desk.with("low = \"-1 -1 -1 pc\"\nhigh = \"1 1 1 pc\"", "voxel = \"1e50 pc\"").refuses_scene(&["voxel", "longer"]);
}

#[test]
fn names_that_mean_something_else_are_refused() {
    let desk = Desk::new();
    for name in ["x", "exp", "pi", "a-b"] {
        desk.write("scene.toml", SCENE.replace("field.cloud", &format!("field.{name}")).as_bytes());
        desk.refuses_scene(&[name, "scene.toml", "expression"]);
    }
}

#[test]
fn filters_are_checked() {
    let desk = Desk::new();
    let own = "[[band]]\nname = \"own\"\nkind = \"file\"\nfile = \"own.csv\"\n[camera]";
    desk.write("scene.toml", SCENE.replace("bands = \"johnson\"", "").replace("[camera]", own).as_bytes());
    desk.write("own.csv", b"wavelength_nm,throughput\n500,50\n600,80\n");
    desk.refuses_scene(&["own.csv", "percent"]);
    desk.write("own.csv", b"frequency_Hz,throughput\n500,0.5\n600,0.8\n");
    desk.refuses_scene(&["own.csv", "frequency"]);
    desk.write("own.csv", b"a,b\n500,5;0,5\n600,0;0,8\n");
    desk.refuses_scene(&["own.csv", "decimal point"]);
    desk.write("own.csv", "Wavelength (Å),T\n5000,0.5\n6000,0.8\n".as_bytes());
    assert!(desk.run(&["render", "scene.toml", "-o", "out.npy"]).status.success());
}

#[test]
fn comparisons_are_of_like_with_like() {
    let desk = Desk::new();
    for (set, file) in [("johnson", "a.fits"), ("2mass", "b.fits")] {
        desk.with("\"johnson\"", &format!("\"{set}\""));
        assert!(desk.run(&["render", "scene.toml", "-o", file]).status.success(), "{set}");
    }
    desk.refuses(&["compare", "a.fits", "b.fits"], &["different bands", "johnson-V", "twomass-J"]);
    desk.refuses(&["compare", "a.fits", "a.fits", "--tolerance", "nan"], &["--tolerance"]);
    assert!(desk.run(&["compare", "a.fits", "a.fits", "--tolerance", "0"]).status.success());
}

/// An archive whose member holds more than its header says.
#[test]
fn what_lies_behind_an_array_is_refused() {
    let desk = Desk::new();
    let mut bytes = cloud(|_| 0.5);
    bytes.extend(vec![0; 1 << 20]);
    desk.write("cloud.npy", &bytes);
    desk.refuses_scene(&["cloud.npy", "1050752 bytes", "512 values"]);
}

#[cfg(unix)]
#[test]
fn links_lead_on_and_masks_hold() {
    use std::os::unix::fs::PermissionsExt;
    let desk = Desk::new();
    desk.write("target.npy", b"old");
    std::os::unix::fs::symlink("target.npy", desk.path("link.npy")).unwrap();
    assert!(desk.run(&["render", "scene.toml", "-o", "link.npy"]).status.success());
    assert!(desk.path("link.npy").is_symlink() && std::fs::read(desk.path("target.npy")).unwrap().starts_with(b"\x93NUMPY"));
    std::os::unix::fs::symlink("nowhere/lost.npy", desk.path("dangling.npy")).unwrap();
    let refused = desk.run(&["render", "scene.toml", "-o", "dangling.npy"]);
    assert!(!refused.status.success() && String::from_utf8_lossy(&refused.stderr).contains("leads to no file"));
    let script = format!("umask 077; exec {} render scene.toml -o private.npy", env!("CARGO_BIN_EXE_barnard"));
    assert!(Command::new("sh").args(["-c", &script]).current_dir(desk.folder.path()).status().unwrap().success());
    assert_eq!(std::fs::metadata(desk.path("private.npy")).unwrap().permissions().mode() & 0o777, 0o600);
}

/// A disk that is full: a file size limit makes the system refuse the bytes, as a full disk does.
#[cfg(unix)]
#[test]
fn a_refused_write_leaves_nothing() {
    let desk = Desk::new();
    let before = listing(desk.folder.path());
    let script = format!("trap '' XFSZ; ulimit -f 1; exec {} render scene.toml -o out.npy --size 64x64", env!("CARGO_BIN_EXE_barnard"));
    let output = Command::new("sh").args(["-c", &script]).current_dir(desk.folder.path()).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && message.contains("out.npy") && message.contains("cannot be written"), "{message}");
    assert_eq!(before, listing(desk.folder.path()));
}

#[test]
#[cfg(feature = "study")]
fn the_study_is_written_or_refused() {
    let desk = Desk::new();
    let output = desk.run(&["study", "convergence", "-o", "new/folder"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = std::fs::read_to_string(desk.path("new/folder/study-convergence.md")).unwrap();
    assert!(page.contains("band_quadrature") && page.contains("](study/convergence.svg)"), "{page}");
    for extension in ["csv", "svg", "png"] {
        assert!(desk.path(&format!("new/folder/study/convergence.{extension}")).is_file());
    }
    desk.refuses(&["study", "convergance", "-o", "x"], &["convergance", "convergence"]);
    desk.refuses(&["study", "convergence", "-o", "scene.toml"], &["scene.toml", "folder"]);
}

/// What a method puts aside, or approximates beside its integrals, is said.
#[test]
fn methods_say_what_they_cost() {
    let desk = Desk::new();
    desk.with("albedo = 0.6", "albedo = 0.6\nphase = { kind = \"henyey_greenstein\", g = 0.5 }");
    let text = |output: Output| String::from_utf8_lossy(&output.stdout).into_owned();
    let words = text(desk.run(&["check", "scene.toml", "--method", "propagation", "--count", "3"]));
    assert!(words.contains("scatters evenly") && words.contains("polynomial fits: worst of degree 5"), "{words}");
    assert!(words.contains("numbers a voxel"), "{words}");
    desk.with("fitzpatrick99", "inverse_wavelength");
    let words = text(desk.run(&["check", "scene.toml", "--method", "analytic"]));
    assert!(words.contains("polynomial fits: worst of degree 5"), "{words}");
    assert!(!text(desk.run(&["check", "scene.toml"])).contains("polynomial fits"));
}

/// What this machine renders on, and a picture by whatever it has; where there is no adapter, words that say what to
/// do.
#[test]
#[cfg(all(feature = "gpu", feature = "study"))]
fn machines_say_what_they_render_on() {
    let desk = Desk::new();
    let out = desk.run(&["info", "--json"]);
    assert!(out.status.success());
    let info: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!(info["threads"].as_u64().unwrap() > 0);
    let adapters = info["adapters"].as_array().unwrap().len();
    assert!(String::from_utf8_lossy(&desk.run(&["info"]).stdout).contains("--backend auto takes"));
    let auto = desk.run(&["render", "scene.toml", "-o", "auto.npy", "--backend", "auto"]);
    assert!(auto.status.success());
    let words = String::from_utf8_lossy(&auto.stdout).into_owned();
    assert!(words.contains("on the cpu: ") || words.contains("gpu: "), "{words}");
    let wrong = desk.run(&["render", "scene.toml", "-o", "fly.npy", "--on-the-fly"]);
    assert!(!wrong.status.success() && String::from_utf8_lossy(&wrong.stderr).contains("--backend gpu") && !desk.path("fly.npy").exists());
    let wrong = desk.run(&["bench", "scene.toml", "--methods", "band_quadrature,midpiont"]);
    assert!(!wrong.status.success() && String::from_utf8_lossy(&wrong.stderr).contains("\"midpoint\""), "{wrong:?}");
    let gpu = desk.run(&["render", "scene.toml", "-o", "gpu.npy", "--backend", "gpu"]);
    let error = String::from_utf8_lossy(&gpu.stderr).into_owned();
    assert_eq!(gpu.status.success(), adapters > 0, "{error}");
    assert_eq!(error.contains("--backend cpu") && !desk.path("gpu.npy").exists(), adapters == 0, "{error}");
}

/// A device renders what the processor does, tells its own time, and says what it does not do.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
#[cfg(all(feature = "gpu", feature = "study"))]
fn the_gpu_renders_what_the_processor_does() {
    let desk = Desk::new();
    let gpu = desk.run(&["render", "scene.toml", "-o", "gpu.npy", "--backend", "gpu"]);
    assert!(gpu.status.success(), "{gpu:?}");
    assert!(desk.run(&["render", "scene.toml", "-o", "cpu.npy"]).status.success());
    assert!(desk.run(&["compare", "gpu.npy", "cpu.npy", "--tolerance", "3e-3"]).status.success());
    assert!(!desk.run(&["compare", "gpu.npy", "cpu.npy", "--tolerance", "1e-9"]).status.success());
    let bench = desk.run(&["bench", "scene.toml", "--backend", "gpu", "--frames", "1", "--error-size", "0", "--json"]);
    let rows: serde_json::Value = serde_json::from_slice(&bench.stdout).unwrap();
    let rows = rows.as_array().unwrap();
    // What the device does not do itself, an upload, has no time of the device.
    let timed = |r: &serde_json::Value| r["gpu_seconds"].is_number() || (r["terms"] == 0 && r["seconds"].is_number());
    assert!(rows.len() >= 5 && rows.iter().all(timed), "{rows:?}");
    assert!(rows.iter().all(|r| r["method"] != "sampled") && rows.iter().any(|r| r["method"] == "band_quadrature"));
    assert!(rows.iter().any(|r| r["method"] == "star depths of one star"));
    let few = desk.run(&["bench", "scene.toml", "--methods", "midpoint", "--frames", "1", "--error-size", "0", "--json"]);
    let few: serde_json::Value = serde_json::from_slice(&few.stdout).unwrap();
    assert!(few.as_array().unwrap().iter().all(|r| r["method"].as_str().unwrap().starts_with("midpoint")), "{few}");
    let other = desk.run(&["render", "scene.toml", "-o", "other.npy", "--backend", "gpu", "--method", "sampled"]);
    let error = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(!other.status.success() && error.contains("sampled") && !desk.path("other.npy").exists(), "{error}");
    let auto = desk.run(&["render", "scene.toml", "-o", "auto.npy", "--backend", "auto", "--method", "sampled"]);
    assert!(auto.status.success());
}

/// Names that were others before are still read, from the command line and from scenes.
#[test]
fn names_of_before_are_read() {
    let desk = Desk::new();
    let before = desk.run(&["render", "scene.toml", "-o", "before.npy", "--method", "newton"]);
    assert!(before.status.success(), "{before:?}");
    desk.with("[camera]", "[method]\nname = \"newton\"\n[camera]");
    assert!(desk.run(&["render", "scene.toml", "-o", "inside.npy"]).status.success());
    desk.write("scene.toml", SCENE.as_bytes());
    assert!(desk.run(&["render", "scene.toml", "-o", "now.npy", "--method", "midpoint"]).status.success());
    let read = |name: &str| std::fs::read(desk.path(name)).unwrap();
    assert!(read("before.npy") == read("now.npy") && read("inside.npy") == read("now.npy"));
    let shown = |name: &str| desk.run(&["check", "--builtin", name, "--size", "8x8"]).stdout;
    assert!(!shown("deck").is_empty() && shown("deck") == shown("barres_neyret"));
}
