//! Scenes that are refused, by what is wrong in them.

use super::desk::{Desk, scene};

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
    desk.with("12000 K", "-5 K").refuses_scene(&["-5 K", "between 1 and 1e9 K"]);
    desk.with("albedo = 0.6", "albedo = 1.5").refuses_scene(&["albedo"]);
    desk.with("[16, 12]", "[0, 12]").refuses_scene(&["0 x 12", "size"]);
    desk.with("\"0 0 5 pc\"", "\"0 0 pc\"").refuses_scene(&["position"]);
    desk.with("bands = \"johnson\"", "bands = 'johnson").refuses_scene(&["scene.toml:2"]);
}

#[test]
fn keys_that_would_be_ignored_are_refused() {
    let desk = Desk::new();
    let magnitude = "luminosity = \"500 Lsun\"\ndistance = \"100 pc\"";
    desk.with("luminosity = \"500 Lsun\"", magnitude).refuses_scene(&["\"distance\" requires magnitude"]);
    let wavelength = "luminosity = \"500 Lsun\"\nwavelength = \"500 nm\"";
    desk.with("luminosity = \"500 Lsun\"", wavelength).refuses_scene(&["\"wavelength\" requires spectral_luminosity"]);
    desk.with("\"cloud.npy\"", "\"cloud.npy\"\narray = \"density\"").refuses_scene(&["without a name", "cloud.npy"]);
    let phase = "albedo = 0.6\nphase = { kind = \"henyey_greenstein\", g = 0.5, g_file = \"g.csv\" }";
    desk.with("albedo = 0.6", phase).refuses_scene(&["g_file", "exclude each other"]);
}

#[test]
fn laws_and_passbands_must_meet() {
    let desk = Desk::new();
    desk.with("\"johnson\"", "\"jwst-miri\"").refuses_scene(&["fitzpatrick99", "valid only from", "jwst-miri"]);
    desk.write("band.csv", b"wavelength_nm,t\n500,0\n600,0\n");
    let band_table = r#"[[band]]
name = "mine"
kind = "file"
file = "band.csv"
[camera]"#;
    desk.with("bands = \"johnson\"\n[camera]", band_table).refuses_scene(&["empty", "band.csv"]);
    desk.write("band.csv", b"wavelength_nm,t\n500,0.1\n400,x\n");
    desk.refuses_scene(&["line 3", "band.csv"]);
    desk.write("band.csv", b"wavelength_nm,t\n500,0.1\n520,0.9\n600,0.3\n");
    assert!(desk.run(&["render", "scene.toml", "-o", "own.npy"]).status.success());
}

#[test]
fn a_buried_star_is_noticed() {
    Desk::new().with("2 mag/pc", "5000 mag/pc").refuses_scene(&["star[0]", "optical depth"]);
    let desk = Desk::new();
    desk.with("2 mag/pc", "5000 mag/pc")
        .refuses(&["render", "scene.toml", "-o", "out.npy", "--steps", "20"], &["star[0]", "optical depth"]);
}

#[test]
fn numbers_past_single_precision_are_refused() {
    let desk = Desk::new();
    desk.with("\"2 mag/pc\"", "\"1e60 mag/pc\"").refuses_scene(&["dust"]);
    desk.with(
        "[[star]]",
        r#"[background]
kind = "power_law"
exponent = 0
radiance = "1e60 W/m2/sr/nm"
[[star]]"#,
    )
    .refuses_scene(&["background", "single precision", "unit of its brightness"]);
    desk.with("low = \"-1 -1 -1 pc\"\nhigh = \"1 1 1 pc\"", "voxel = \"1e50 pc\"").refuses_scene(&["voxel", "exceeds"]);
}

#[test]
fn names_that_mean_something_else_are_refused() {
    let desk = Desk::new();
    for name in ["x", "exp", "pi", "a-b"] {
        desk.write("scene.toml", scene().replace("field.cloud", &format!("field.{name}")).as_bytes());
        desk.refuses_scene(&[name, "scene.toml", "expression"]);
    }
}

#[test]
fn filters_are_checked() {
    let desk = Desk::new();
    let band_table = r#"[[band]]
name = "own"
kind = "file"
file = "own.csv"
[camera]"#;
    desk.write("scene.toml", scene().replace("bands = \"johnson\"", "").replace("[camera]", band_table).as_bytes());
    desk.write("own.csv", b"wavelength_nm,throughput\n500,50\n600,80\n");
    desk.refuses_scene(&["own.csv", "percent"]);
    desk.write("own.csv", b"frequency_Hz,throughput\n500,0.5\n600,0.8\n");
    desk.refuses_scene(&["own.csv", "frequency"]);
    desk.write("own.csv", b"a,b\n5,100;1,500\n5,200;1,800\n");
    desk.refuses_scene(&["own.csv", "decimal point"]);
    desk.write("own.csv", "Wavelength (Å),T\n5000,0.5\n6000,0.8\n".as_bytes());
    assert!(desk.run(&["render", "scene.toml", "-o", "out.npy"]).status.success());
}
