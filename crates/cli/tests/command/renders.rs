//! Scenes that render: every format, back end and method.

use std::process::Command;

use super::desk::{Desk, scene};

/// The path tracer with one bounce agrees with the reference within the standard errors in its file.
#[test]
fn one_bounce_of_the_path_tracer_is_the_reference() {
    let desk = Desk::new();
    desk.renders(&["--backend", "reference", "-o", "truth.fits"]);
    desk.renders(&["--backend", "path", "--bounces", "1", "--samples", "400", "-o", "once.fits", "-o", "once.png"]);
    let compared = desk.run(&["compare", "once.fits", "truth.fits", "--json", "--tolerance", "0.2"]);
    let list: serde_json::Value = serde_json::from_slice(&compared.stdout).unwrap();
    assert!(compared.status.success() && list.as_array().unwrap().len() == 3, "{list}");
    for band in list.as_array().unwrap() {
        assert!((0.5..2.0).contains(&band["chi_squared"].as_f64().unwrap()), "{list}");
    }
}

/// `--target-error` ends the path tracer long before the most samples.
#[test]
fn a_target_error_ends_the_path_tracer() {
    let desk = Desk::new();
    let render = desk.run(
        &[
            &["render", "scene.toml", "-o", "soon.fits", "--backend", "path", "--bounces", "1000"][..],
            &["--target-error", "0.5", "--samples", "100000"],
        ]
        .concat(),
    );
    let words = String::from_utf8_lossy(&render.stdout).into_owned();
    let paths = words.split(" paths per pixel").next().and_then(|before| before.rsplit(' ').next()).and_then(|n| n.parse::<u32>().ok());
    assert!(render.status.success() && paths.is_some_and(|paths| paths < 10_000), "{words}");
}

/// Paths with more bounces have the same first ones: all pixels together are brighter.
#[test]
fn more_bounces_are_brighter() {
    let desk = Desk::new();
    let light = |bounces: &str| {
        desk.renders(&["--backend", "path", "--bounces", bounces, "--samples", "100", "-o", "light.npy"]);
        let bytes = std::fs::read(desk.path("light.npy")).unwrap();
        let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let values: Vec<f64> = bytes[header..].chunks_exact(8).map(|v| f64::from_le_bytes(v.try_into().unwrap())).collect();
        // Errors follow the bands.
        values[..values.len() / 2].iter().sum::<f64>()
    };
    let (once, twice, many) = (light("1"), light("2"), light("1000"));
    assert!(twice > 1.05 * once && many > 1.02 * twice && many < 5.0 * once, "{once:e} {twice:e} {many:e}");
}

/// The benchmark of many bounces leaves out methods of one bounce and predicts the time of the path tracer.
#[test]
#[cfg(feature = "study")]
fn benchmarks_of_many_bounces_leave_out_methods_of_one() {
    let desk = Desk::new();
    let bench =
        ["bench", "scene.toml", "--bounces", "3", "--methods", "lookup,band_quadrature", "--frames", "1", "--error-size", "8", "--json"];
    let rows: serde_json::Value = serde_json::from_slice(&desk.run(&bench).stdout).unwrap();
    let row = |name: &str| rows.as_array().unwrap().iter().find(|r| r["method"].as_str().unwrap().starts_with(name));
    assert!(
        row("lookup").is_none() && row("band_quadrature").is_some() && row("path").unwrap()["seconds"].as_f64().unwrap() > 0.0,
        "{rows}"
    );
}

/// A render with many bounces prints the orders of scattering and the angular error.
#[test]
fn renders_print_orders_of_scattering() {
    let desk = Desk::new();
    let render = desk.run(&["render", "scene.toml", "-o", "x.npy", "--bounces", "3", "-v"]);
    let words = String::from_utf8_lossy(&render.stdout).into_owned();
    assert!(
        render.status.success() && words.contains("multiple scattering: 2 scattering orders") && words.contains("angular about"),
        "{words}"
    );
}

/// A resumed render is the picture of an uninterrupted one, bit by bit.
#[test]
fn resumed_paths_are_those_of_one_run() {
    let desk = Desk::new();
    desk.renders(&["--backend", "path", "--samples", "8", "--state", "s.npz", "-o", "half.npy"]);
    desk.renders(&["--backend", "path", "--samples", "16", "--state", "s.npz", "-o", "two.npy"]);
    desk.renders(&["--backend", "path", "--samples", "16", "-o", "one.npy"]);
    assert!(std::fs::read(desk.path("one.npy")).unwrap() == std::fs::read(desk.path("two.npy")).unwrap());
    assert!(std::fs::read(desk.path("one.npy")).unwrap() != std::fs::read(desk.path("half.npy")).unwrap());
}

/// States of another seed, scene, size or number of bounces are refused, and so are broken ones.
#[test]
fn states_of_other_renders_are_refused() {
    let desk = Desk::new();
    desk.renders(&["--backend", "path", "--samples", "8", "--state", "s.npz", "-o", "half.npy"]);
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
    again(&[], &["s.npz", "not an .npz archive"]);
    desk.refuses(&["render", "scene.toml", "-o", "x.fits", "--backend", "path", "--state", "s.txt"], &["--state", ".npz"]);
}

/// Settings of another back end and values out of range are refused by name.
#[test]
fn settings_of_other_back_ends_are_refused() {
    let desk = Desk::new();
    let refused = |settings: &[&str], words: &[&str]| desk.refuses(&[&["render", "scene.toml", "-o", "x.fits"], settings].concat(), words);
    refused(&["--backend", "reference", "--bounces", "2"], &["bounces = 1"]);
    refused(&["--samples", "4"], &["--backend path"]);
    refused(&["--backend", "path", "--steps", "4"], &["--steps", "--samples"]);
    refused(&["--backend", "path", "--samples", "0"], &["between 1 and 1e12", "method.path.samples"]);
    refused(&["--backend", "path", "--bounces", "0"], &["between 1 and 1000", "method.bounces"]);
    refused(&["--backend", "path", "--target-error", "nan"], &["NaN", "method.path.target_error"]);
}

#[test]
fn renders_every_format_and_compares_them() {
    let desk = Desk::new();
    let output = desk.run(&["render", "scene.toml", "-o", "a.npy", "-o", "a.fits", "-o", "a.exr", "-o", "a.png", "--verbose"]);
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

/// Layers go to files that hold them, and radiances stay what they are; where nothing holds them they are refused or not rendered.
#[test]
#[cfg(feature = "study")]
fn layers_are_rendered_for_who_holds_them() {
    let desk = Desk::new();
    desk.renders(&["-o", "plain.npy"]);
    desk.renders(&["--layers", "all", "-o", "a.exr", "-o", "a.fits", "-o", "a.npy"]);
    for layered in ["a.exr", "a.fits", "a.npy"] {
        assert!(desk.run(&["compare", layered, "plain.npy", "--tolerance", "1e-5"]).status.success(), "{layered}");
    }
    let holds = |name: &str, word: &str| String::from_utf8_lossy(&std::fs::read(desk.path(name)).unwrap()).contains(word);
    assert!(holds("a.exr", "scattered.R") && holds("a.exr", "depth.Z") && holds("a.fits", "EXTNAME = 'opacity"));
    desk.renders(&["--layers", "depth, tau", "-o", "a.exr"]);
    assert!(!holds("a.exr", "scattered.R") && holds("a.exr", "tau.V\0"));
    desk.with(
        "[[star]]",
        r#"[output]
layers = ["light"]
channels = "bands"
compression = "none"

[[star]]"#,
    );
    desk.renders(&["-o", "a.exr", "-o", "a.png"]);
    assert!(holds("a.exr", "scattered.johnson-V") && !holds("a.exr", "tau.V\0"));
    desk.renders(&["-o", "a.png"]);
    desk.refuses(&["render", "scene.toml", "-o", "a.png", "--layers", "all"], &["--layers", ".exr"]);
    desk.refuses(
        &["render", "scene.toml", "-o", "a.exr", "--layers", "all", "--size", "2000x2000", "--memory", "0.3"],
        &["with its layers"],
    );
    desk.refuses(&["render", "scene.toml", "-o", "a.exr", "--layers", "depht"], &["depht", "light, depth, tau, all"]);
    desk.with(
        "[[star]]",
        r#"[output]
layers = ["lihgt"]

[[star]]"#,
    );
    desk.refuses(&["render", "scene.toml", "-o", "a.exr"], &["lihgt", "light, depth, tau, all"]);
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
    assert!(!refused.status.success() && String::from_utf8_lossy(&refused.stderr).contains("broken link"));
    let script = format!("umask 077; exec {} render scene.toml -o private.npy", env!("CARGO_BIN_EXE_barnard"));
    assert!(
        Command::new("sh").env("BARNARD_CACHE", "off").args(["-c", &script]).current_dir(desk.folder.path()).status().unwrap().success()
    );
    assert_eq!(std::fs::metadata(desk.path("private.npy")).unwrap().permissions().mode() & 0o777, 0o600);
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
    desk.write("scene.toml", scene().as_bytes());
    assert!(desk.run(&["render", "scene.toml", "-o", "now.npy", "--method", "midpoint"]).status.success());
    let read = |name: &str| std::fs::read(desk.path(name)).unwrap();
    assert!(read("before.npy") == read("now.npy") && read("inside.npy") == read("now.npy"));
    let shown = |name: &str| desk.run(&["check", "--builtin", name, "--size", "8x8"]).stdout;
    assert!(!shown("deck").is_empty() && shown("deck") == shown("barres_neyret"));
}
