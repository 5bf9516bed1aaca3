//! What the command tells: catalogues, checks, costs, comparisons.

use std::process::Output;

use super::desk::{Desk, barnard};

/// A reader that stops listening does not stop the render.
#[cfg(unix)]
#[test]
fn a_closed_pipe_loses_nothing() {
    let desk = Desk::new();
    let mut child = barnard()
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
        let loaded =
            barnard_files::builtin::load_by(scene.name, barnard::memory::DEFAULT_LIMIT, barnard::scene::Loader::roughly).map(|_| ());
        match (loaded, scene.needs) {
            (Ok(()), None) => {}
            // What has to be fetched first is named, with where it is.
            (Err(e), Some(file)) => assert!(e.to_string().contains(file) && e.to_string().contains("https://doi.org/"), "{e}"),
            (loaded, _) => panic!("{}: {loaded:?}", scene.name),
        }
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

/// Multiple scattering is estimated in coarse cells before a picture, which has its error as well.
#[test]
fn check_estimates_multiple_scattering() {
    let desk = Desk::new();
    let words = |arguments: &[&str]| {
        let output = desk.run(arguments);
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat()
    };
    let checked = words(&["check", "scene.toml", "--bounces", "20"]);
    let rendered = words(&["render", "scene.toml", "--bounces", "20", "-o", "out.npy", "--verbose"]);
    for text in [&checked, &rendered] {
        assert!(text.contains("scattering orders") && text.contains("spatial about"), "{text}");
    }
    assert!(checked.contains("an estimate") && !rendered.contains("an estimate"), "{rendered}");
}

/// JSON on standard output has the numbers of the report, those of the headers too; words go to standard error.
#[test]
fn reports_are_json_on_request() {
    let desk = Desk::new();
    let json = |arguments: &[&str]| -> serde_json::Value {
        let output = desk.run(arguments);
        assert!(output.status.success() && !output.stderr.is_empty(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let rendered = json(&["render", "scene.toml", "-o", "out.fits", "--json"]);
    let report = &rendered["report"];
    assert_eq!((&rendered["files"][0], &report["backend"]), (&"out.fits".into(), &"cpu".into()));
    let worst = |report: &serde_json::Value| {
        let bands = report["certificates"].as_object().unwrap();
        let errors = bands.values().flat_map(|lights| lights.as_array().unwrap()).map(|light| light["absolute"].as_f64().unwrap());
        errors.fold(0.0, f64::max)
    };
    assert!(worst(report) > 0.0 && report["spectral_error"] == worst(report), "{report}");
    let header = std::fs::read(desk.path("out.fits")).unwrap();
    let card = header.chunks(80).find(|card| card.starts_with(b"SPATERR")).unwrap();
    let card = String::from_utf8_lossy(&card[9..]);
    let stated: f64 = card.split('/').next().unwrap().trim().parse().unwrap();
    assert!((report["spatial_error"]["error"].as_f64().unwrap() / stated - 1.0).abs() < 1e-9, "{report}");
    let expected = &json(&["check", "scene.toml", "--json"])["report"];
    assert_eq!((&expected["method"], &expected["steps"]), (&report["method"], &report["steps"]));
    let exact = json(&["render", "scene.toml", "-o", "exact.npy", "--json", "--backend", "reference", "--size", "2x2"]);
    assert!(exact["report"]["spatial_error"].is_null() && exact["report"]["accuracy"].is_number(), "{exact}");
    desk.refuses(&["render", "scene.toml", "-o", "png:-", "--json"], &["standard output", "--json"]);
}

#[test]
fn completions_end_quietly_in_a_closed_pipe() {
    let mut child =
        barnard().args(["completions", "bash"]).stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(!String::from_utf8_lossy(&output.stderr).contains("panicked"));
    assert!(Desk::new().run(&["completions", "zsh"]).stdout.len() > 1000);
}

#[test]
fn comparisons_are_of_like_with_like() {
    let desk = Desk::new();
    for (set, file) in [("johnson", "a.fits"), ("2mass", "b.fits")] {
        desk.with("\"johnson\"", &format!("\"{set}\""));
        assert!(desk.run(&["render", "scene.toml", "-o", file]).status.success(), "{set}");
    }
    desk.refuses(&["compare", "a.fits", "b.fits"], &["differ in bands", "johnson-V", "twomass-J"]);
    desk.refuses(&["compare", "a.fits", "a.fits", "--tolerance", "nan"], &["--tolerance"]);
    assert!(desk.run(&["compare", "a.fits", "a.fits", "--tolerance", "0"]).status.success());
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
    assert!(words.contains("isotropic") && words.contains("polynomial fits: worst of degree 5"), "{words}");
    assert!(words.contains("numbers per voxel"), "{words}");
    desk.with("fitzpatrick99", "inverse_wavelength");
    let words = text(desk.run(&["check", "scene.toml", "--method", "analytic"]));
    assert!(words.contains("polynomial fits: worst of degree 5"), "{words}");
    assert!(!text(desk.run(&["check", "scene.toml"])).contains("polynomial fits"));
}

/// What the values of a file are, where they are asked for.
#[test]
fn values_of_files_are_summed_up() {
    let desk = Desk::new();
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2, 2), }\n";
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes().chain([3.0, f64::NAN, -1.0, 4.0].into_iter().flat_map(f64::to_le_bytes)));
    desk.write("four.npy", &bytes);
    let words = |arguments: &[&str]| String::from_utf8_lossy(&desk.run(arguments).stdout).into_owned();
    let known = words(&["info", "four.npy", "--values"]);
    for fact in ["range       -1e0 to 4e0", "mean        2.000000e0", "blank       1 of 4"] {
        assert!(known.contains(fact), "{fact}: {known}");
    }
    assert!(!words(&["info", "four.npy"]).contains("range"));
    let refused = words(&["info", "four.npy", "--values", "--memory", "1e-9"]);
    assert!(refused.contains("no grid") && refused.contains("limit"), "{refused}");
    desk.run(&["render", "scene.toml", "-o", "picture.fits"]);
    let picture = words(&["info", "picture.fits", "--values"]);
    assert!(picture.matches("range       ").count() == 3 && !picture.contains("no grid"), "{picture}");
    desk.refuses(&["info", "four.png"], &["four.png", "does not exist", "did you mean \"four.npy\""]);
}

/// What this machine renders on, and a picture by whatever it has; where there is no adapter, words that say what to
/// do.
#[test]
#[cfg(all(feature = "gpu", feature = "study"))]
fn machines_say_what_they_render_on() {
    let desk = Desk::new();
    let out = desk.command(&["info", "--json"]).env_remove("XDG_RUNTIME_DIR").output().unwrap();
    assert!(out.status.success());
    assert_eq!(String::from_utf8_lossy(&out.stderr), "", "outside of a desktop session");
    let info: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!(info["threads"].as_u64().unwrap() > 0);
    let adapters = info["adapters"].as_array().unwrap().len();
    assert!(String::from_utf8_lossy(&desk.run(&["info"]).stdout).contains("--backend auto selects"));
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
