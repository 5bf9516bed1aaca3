//! Images of all around as files: what FITS calls their projections, and EXR an environment map.

use std::path::PathBuf;

use barnard::backend::{Renderer, cpu};
use barnard::control::Control;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planner};
use barnard_files::{SaveImage, in_folder, parse};
use exr::meta::MetaData;
use exr::meta::attribute::EnvironmentMap;

/// A picture of a ball of dust around the eye, saved as a file of its own.
fn saved(name: &str, camera: &str) -> PathBuf {
    let text = format!(
        r#"bands = ["bessell-V"]
[camera]
position = "0 0 0 pc"
target = "0 0 -1 pc"
{camera}
[field.n]
kind = "sphere"
radius = "1 pc"
[dust]
density = "n"
scale = "0.4 /pc"
law = "ccm89"
albedo = 0.6
[[star]]
kind = "blackbody"
position = "0.3 0.2 0.4 pc"
temperature = "12000 K"
luminosity = "1000 Lsun"
"#
    );
    let scene = parse("all.toml", "all", text, &in_folder(".", DEFAULT_LIMIT)).unwrap();
    let plan = Planner::new(&Options::within(DEFAULT_LIMIT)).plan(&scene, None, &Control::default()).unwrap();
    let (image, _) = Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap();
    let path = std::env::temp_dir().join(format!("barnard-{}-{name}", std::process::id()));
    image.save(&path, &scene.save_options()).unwrap();
    path
}

/// The cards of a FITS file, those of all its headers.
fn cards(camera: &str) -> Vec<String> {
    let path = saved("all.fits", camera);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    bytes.chunks_exact(80).map(|card| String::from_utf8_lossy(card).trim().to_owned()).collect()
}

fn environment_map(camera: &str) -> Option<EnvironmentMap> {
    let path = saved("all.exr", camera);
    let meta = MetaData::read_from_file(&path, false).unwrap();
    std::fs::remove_file(&path).unwrap();
    meta.headers[0].own_attributes.environment_map
}

#[test]
fn fits_names_projections() {
    for (camera, projection, step) in [
        ("kind = \"fisheye\"\nsize = [20, 20]", "ARC", 9.0),
        (
            r#"kind = "fisheye"
aperture = "360 deg"
tilt = "90 deg"
size = [40, 40]"#,
            "ARC",
            9.0,
        ),
        ("kind = \"equirectangular\"\nsize = [40, 20]", "CAR", 9.0),
    ] {
        let cards = cards(camera);
        let value = |key: &str| cards.iter().find_map(|card| card.strip_prefix(&format!("{key:8}= ")).map(str::to_owned)).unwrap();
        assert!(
            value("CTYPE1").contains(&format!("XLON-{projection}")) && value("CTYPE2").contains(&format!("XLAT-{projection}")),
            "{camera}"
        );
        let number = |key: &str| value(key).split('/').next().unwrap().trim().parse::<f64>().unwrap();
        assert!((number("CDELT1") - step).abs() < 1e-9 && (number("CDELT2") - step).abs() < 1e-9, "{camera}");
    }
    let cards = cards("kind = \"cubemap\"\nsize = [6, 36]");
    assert!(cards.iter().all(|card| !card.starts_with("CTYPE1")) && cards.iter().any(|card| card.contains("cubemap")));
}

#[test]
fn exr_marks_environment_maps() {
    assert_eq!(environment_map("kind = \"equirectangular\"\nsize = [40, 20]"), Some(EnvironmentMap::LatitudeLongitude));
    assert_eq!(environment_map("kind = \"cubemap\"\nsize = [6, 36]"), Some(EnvironmentMap::Cube));
    for other in [
        "kind = \"equirectangular\"\nsize = [40, 30]",
        "kind = \"equirectangular\"\nsize = [40, 20]\ncrop = [3, 2, 20, 10]",
        "kind = \"fisheye\"\nsize = [20, 20]",
    ] {
        assert_eq!(environment_map(other), None, "{other}");
    }
}
