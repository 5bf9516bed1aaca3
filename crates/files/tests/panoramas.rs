//! Images of all around as files: what FITS calls their projections, and EXR an environment map.

use std::path::PathBuf;

use barnard::backend::cpu;
use barnard::control::Control;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Plan};
use barnard_files::{SaveImage, in_folder, parse};
use exr::meta::MetaData;
use exr::meta::attribute::EnvironmentMap;

/// A picture of a ball of dust around the eye, saved as a file of its own.
fn saved(name: &str, camera: &str) -> PathBuf {
    let text = format!(
        "bands = [\"bessell-V\"]\n[camera]\nposition = \"0 0 0 pc\"\ntarget = \"0 0 -1 pc\"\n{camera}\n[field.n]\nkind = \"sphere\"\nradius = \"1 pc\"\n\
         [dust]\ndensity = \"n\"\nscale = \"0.4 /pc\"\nlaw = \"ccm89\"\nalbedo = 0.6\n[[star]]\nkind = \"blackbody\"\nposition = \"0.3 0.2 0.4 pc\"\n\
         temperature = \"12000 K\"\nluminosity = \"1000 Lsun\"\n"
    );
    let scene = parse("all.toml", "all", text, &in_folder(".", DEFAULT_LIMIT)).unwrap();
    let plan = Plan::new(&scene, &Options::within(DEFAULT_LIMIT), &Control::default()).unwrap();
    let (image, _) = cpu::render(&scene, &plan, &Control::default()).unwrap();
    let path = std::env::temp_dir().join(format!("barnard-{}-{name}", std::process::id()));
    image.save(&path).unwrap();
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
        ("kind = \"fisheye\"\naperture = \"360 deg\"\ntilt = \"90 deg\"\nsize = [40, 40]", "ARC", 9.0),
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
