//! Reference answers of an independent double-precision program: where they are, as scenes of ours, and how far an
//! image is from them.
//!
//! Three cases are kept in `tests/cases`; each sub-folder with a `scene.json` of the folder that BARNARD_CASES names is
//! compared as well. The measure is relative RMSE per band, units taken from the definitions.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use barnard::image::Image;
use barnard::memory::DEFAULT_LIMIT;
use barnard::scene::Scene;
use serde_json::Value;
use spectra::constants::{PARSEC, SPHERE};

/// Folders with a case each.
pub fn folders() -> Vec<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("../barnard");
    let mut cases: Vec<PathBuf> = Vec::new();
    for root in [here.join("tests/cases")].into_iter().chain(std::env::var("BARNARD_CASES").map(PathBuf::from)) {
        let entries = std::fs::read_dir(&root).unwrap_or_else(|e| panic!("{}: {e}", root.display()));
        let found = entries.flatten().map(|e| e.path()).filter(|p| p.join("scene.json").is_file());
        let new: Vec<PathBuf> = found.filter(|p| cases.iter().all(|c| c.file_name() != p.file_name())).collect();
        cases.extend(new);
    }
    cases.sort();
    assert!(cases.len() >= 3, "reference cases are missing");
    cases
}

fn number(v: &Value) -> f64 {
    v.as_f64().expect("a number")
}

fn triple(v: &Value) -> String {
    v.as_array().expect("three numbers").iter().map(|x| format!("{:?}", number(x))).collect::<Vec<_>>().join(" ")
}

/// Copy of the scene in our own format: one length is 1 pc, spectra per nm.
fn toml(case: &Value) -> String {
    let mut t = String::new();
    let camera = &case["camera"];
    let size = format!("[{}, {}]", camera["width"], camera["height"]);
    let _ = write!(
        t,
        r#"[camera]
position = "{} pc"
target = "{} pc"
up = [{}]
size = {size}
"#,
        triple(&camera["origin"]),
        triple(&camera["target"]),
        triple(&camera["up"]).replace(' ', ", ")
    );
    let _ = match camera["fov_x_deg"].as_f64() {
        Some(fov) => writeln!(t, "kind = \"perspective\"\nfield_of_view = \"{fov:?} deg\""),
        None => writeln!(t, "kind = \"orthographic\"\nwidth = \"{:?} pc\"", number(&camera["width_world"])),
    };
    let bounds = case["bounds"].as_array().expect("bounds");
    let corner = |i: usize| format!("{0:?} {0:?} {0:?} pc", number(&bounds[i]));
    let grid = |name: &str, file: &str| {
        format!(
            r#"[field.{name}]
kind = "grid"
file = "{file}"
axes = "zyx"
low = "{}"
high = "{}"
"#,
            corner(0),
            corner(1)
        )
    };
    t += &grid("dust", case["grid"].as_str().unwrap_or("../density.npy"));
    let albedo = &case["albedo"];
    let _ = write!(
        t,
        r#"[dust]
density = "dust"
scale = "{:?} /pc"
law = "inverse_wavelength"
"#,
        number(&case["kappa"])
    );
    let _ = writeln!(t, "albedo = {{ kind = \"linear\", value = {:?}, slope = {:?} }}", number(&albedo["a550"]), number(&albedo["slope"]));
    if let Some(g) = case["g"].as_f64().filter(|g| *g != 0.0) {
        let _ = writeln!(t, "phase = {{ kind = \"henyey_greenstein\", g = {g:?} }}");
    }
    for star in case["stars"].as_array().into_iter().flatten() {
        // I per steradian and nm over distances in pc: L = 4π I pc² [W/nm].
        let luminosity = SPHERE * number(&star["I550"]) * PARSEC * PARSEC;
        let _ = write!(
            t,
            r#"[[star]]
kind = "blackbody"
visible = false
position = "{} pc"
temperature = "{:?} K"
spectral_luminosity = "{luminosity:e} W/nm"
"#,
            triple(&star["position"]),
            number(&star["T"])
        );
    }
    if let Some(emission) = case.get("emission").filter(|e| !e.is_null()) {
        t += &grid("gas", case["emission_grid"].as_str().unwrap_or("emission.npy"));
        let line = |l: &Value| format!("{{ wavelength = \"{:?} nm\", strength = {:?} }}", number(&l["lambda"]), number(&l["strength"]));
        let lines: Vec<String> = emission["lines"].as_array().into_iter().flatten().map(line).collect();
        let _ = write!(
            t,
            r#"[[emission]]
kind = "lines"
density = "gas"
scale = "1 W/m2/sr/pc"
lines = [{}]
continuum = {:?}
continuum_exponent = {:?}
"#,
            lines.join(", "),
            number(&emission["continuum550"]),
            number(&emission["continuum_slope"])
        );
    }
    for (name, kernel) in case["filters"].as_object().expect("filters") {
        let _ = write!(
            t,
            r#"[[band]]
name = "{name}"
kind = "cos2"
centre = "{:?} nm"
half_width = "{:?} nm"
"#,
            number(&kernel[0]),
            number(&kernel[1])
        );
    }
    t
}

/// The independent program's image of one band.
pub fn answer(folder: &Path, band: &str) -> Image {
    barnard_files::formats::read_image(&folder.join(format!("ref_{band}.npy")), DEFAULT_LIMIT).unwrap()
}

/// Our radiance is per µm inside and W m⁻² sr⁻¹ outside, theirs counts λ in nm: a band value ∫ I_λ R dλ is the same
/// number.
pub fn compare(folder: &Path, image: &Image, tolerance: f64) -> f64 {
    let mut worst = 0.0f64;
    for (b, band) in image.bands.iter().enumerate() {
        let reference = answer(folder, &band.name);
        let difference: f64 = image.band(b).zip(reference.band(0)).map(|(a, r)| (a - r).powi(2)).sum();
        let size: f64 = reference.band(0).map(|r| r * r).sum();
        let error = (difference / size).sqrt();
        println!("{} {} relative RMSE {error:.2e} (allowed {tolerance:.0e})", folder.file_name().unwrap().to_string_lossy(), band.name);
        worst = worst.max(error);
    }
    worst
}

/// A case as a scene.
pub fn load(folder: &Path) -> Scene {
    let case: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("scene.json")).unwrap()).unwrap();
    barnard_files::parse("case.toml", "case", toml(&case), &barnard_files::in_folder(folder, DEFAULT_LIMIT)).unwrap()
}
