//! Fits of scenes to images that another code path made: those of the path tracer, recorded by an instrument.

use std::path::Path;
use std::sync::Arc;

use barnard::image::SaveOptions;
use barnard::instrument::{Exposures, Instrument};
use barnard::properties::Table;
use barnard::scene::Scene;
use barnard::{Control, Image, Options, Result};
use barnard_files::{SaveImage, SceneFile};
use barnard_fit::{Fitted, Images, Observation, fit, free_parameters};
use rayon::prelude::*;

const FREE: &str =
    "star.0.luminosity, star.0.temperature=4000..30000, star.1.luminosity, emission.0.scale, background.radiance, dust.scale=0.3..10";
const TRUTH: [f64; 6] = [1000.0, 9000.0, 600.0, 1e-24, 2e-7, 2.0];
const BEGIN: [f64; 6] = [700.0, 10500.0, 800.0, 2e-24, 1e-7, 2.3];

/// A lopsided cloud with two stars, glowing gas and light behind, seen from afar.
fn text(values: [f64; 6], instrument: &str) -> String {
    let [first, temperature, second, gas, behind, dust] = values;
    format!(
        r#"
bands = ["johnson-B", "johnson-V", "cousins-R"]
{instrument}
[camera]
kind = "perspective"
position = "0 0 1000 pc"
field_of_view = "0.115 deg"
size = [20, 16]
[field.cloud]
kind = "grid"
file = "cloud.npy"
low = "-1 -1 -1 pc"
high = "1 1 1 pc"
[dust]
density = "cloud"
scale = "{dust:?} /pc"
law = "gordon23"
albedo = 0.6
[[star]]
kind = "blackbody"
position = "0.3 0.2 0.4 pc"
temperature = "{temperature:?} K"
luminosity = "{first:?} Lsun"
visible = false
[[star]]
kind = "blackbody"
position = "-0.4 -0.3 0.5 pc"
temperature = "20000 K"
luminosity = "{second:?} Lsun"
visible = false
[[emission]]
density = "cloud"
kind = "lines"
scale = "{gas:?} W/m3/sr"
lines = [{{ wavelength = "500.7 nm", strength = 1 }}, {{ wavelength = "656.3 nm", strength = 0.4 }}]
[background]
kind = "blackbody"
temperature = "5000 K"
radiance = "{behind:?} W/m2/sr/um"
[method]
accuracy = 5e-4
steps_per_voxel = 4
star_depth_voxels = 2
"#
    )
}

const INSTRUMENT: &str = r#"
[instrument]
aperture = "0.5 m"
read_noise = "4 e"
sky = "21.5 mag"
exposure = "0.4 s"
frames = 3
dark_current = "0.05 e/s"
[[instrument.psf]]
kind = "gaussian"
fwhm = "20 arcsec"
"#;

/// Writes the cloud's grid, 20 × 20 × 20 of single precision, x running slowest.
fn write_cloud(folder: &Path) {
    const EDGE: usize = 20;
    let at = |i: usize| 2.0 * (i as f64 + 0.5) / EDGE as f64 - 1.0;
    let value = |x: f64, y: f64, z: f64| (-3.0 * (x * x + 2.0 * y * y + z * z)).exp() * (1.2 + (3.0 * x + y).sin() * (4.0 * z).cos());
    let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({EDGE}, {EDGE}, {EDGE}), }}");
    header += &" ".repeat(117 - header.len());
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    for (x, y, z) in (0..EDGE).flat_map(|x| (0..EDGE).flat_map(move |y| (0..EDGE).map(move |z| (x, y, z)))) {
        bytes.extend((value(at(x), at(y), at(z)) as f32).to_le_bytes());
    }
    std::fs::write(folder.join("cloud.npy"), bytes).unwrap();
}

/// The scene, read in a folder.
fn open(folder: &Path, text: &str) -> SceneFile {
    let path = folder.join("scene.toml");
    std::fs::write(&path, text).unwrap();
    SceneFile::open(&path, 1 << 30, Clone::clone).unwrap()
}

/// The picture of a scene by the path tracer, so many paths a pixel.
fn traced(scene: &Scene, samples: u64) -> Image {
    let options = barnard::backend::path::Options::default().with_samples(samples);
    let mut film = barnard::backend::path::Film::default();
    let control = Control::default();
    barnard::backend::path::trace(scene, &options, &mut film, &control, &mut |_| ()).unwrap();
    let image = barnard::backend::path::image(scene, &film, &options, &control).unwrap();
    let radiances: Vec<usize> = image.radiances().collect();
    let samples = radiances.iter().flat_map(|band| image.band(*band).collect::<Vec<f64>>()).collect();
    let bands = radiances.iter().map(|band| image.bands[*band].clone()).collect();
    Image { bands, samples: barnard::image::Samples::Double(samples), ..image }
}

/// Writes what the scene's instrument records of a picture, with a number of the noise.
fn record(exposures: &Exposures, seed: u64, path: &Path) {
    let instrument = Instrument { seed, ..exposures.instrument().clone() };
    exposures.recorded_by(Arc::new(instrument)).master(&Control::default()).unwrap().save(path, &SaveOptions::grey(1)).unwrap();
}

fn fitted(file: &SceneFile, observations: &[Observation], free: &str) -> Result<(Fitted, Images)> {
    let (free, control) = (free_parameters(free, file.tree())?, Control::default());
    let (mut images, data, start) =
        Images::new(file.tree().clone(), file.loader().clone(), observations, &free, Options::default(), &control)?;
    let found = fit(&mut images, &data, &free, &start, &control)?;
    Ok((found, images))
}

/// From noisy images of the path tracer, truth lies within two standard errors as often as it should, whatever the fit begins with; χ² is
/// that of the noise, and noise that is larger than the instrument's is seen.
#[test]
#[ignore = "long"]
fn truth_is_found() {
    let folder = tempfile::tempdir().unwrap();
    write_cloud(folder.path());
    let truth = open(folder.path(), &text(TRUTH, INSTRUMENT)).scene;
    let image = traced(&truth, 4000);
    let exposures = Exposures::new(truth.instrument.clone().unwrap(), &image, &truth.bands, &Control::default()).unwrap();
    let begin = open(folder.path(), &text(BEGIN, INSTRUMENT));
    const DRAWS: usize = 100;
    let draw = |seed: u64| {
        let path = folder.path().join(format!("{seed}.fits"));
        record(&exposures, seed, &path);
        let (found, _) = fitted(&begin, &[Observation::from(&*path)], FREE).unwrap();
        assert!(found.converged && found.degenerate.is_empty() && found.bounded.is_empty());
        assert_eq!(found.linear, [true, false, true, true, true, false]);
        found
    };
    let all: Vec<Fitted> = (1..=DRAWS as u64).into_par_iter().map(draw).collect();
    let pull = |found: &Fitted, i: usize| (found.values[i] - TRUTH[i]) / found.sigma_of(i);
    let within: [usize; 6] = std::array::from_fn(|i| all.iter().filter(|found| pull(found, i).abs() < 2.0).count());
    let pulls: [f64; 6] = std::array::from_fn(|i| all.iter().map(|found| pull(found, i)).sum::<f64>() / DRAWS as f64);
    println!("within two standard errors {within:?} of {DRAWS}, mean pulls {pulls:.2?}");
    assert!(within.iter().all(|count| *count >= 93), "{within:?}");
    let reduced = all.iter().map(|found| found.chi2.0 / (found.chi2.1 as f64 - 6.0)).sum::<f64>() / DRAWS as f64;
    println!("chi2 {reduced:.4} a degree of freedom");
    assert!((0.97..1.05).contains(&reduced), "{reduced}");
    // More noise of reading than the scene says.
    let path = folder.path().join("louder.fits");
    let louder = Instrument { seed: 1, ..(**truth.instrument.as_ref().unwrap()).clone() };
    let louder = Instrument { detector: barnard::instrument::Detector { read_noise: 25.0, ..louder.detector.clone() }, ..louder };
    exposures.recorded_by(Arc::new(louder)).master(&Control::default()).unwrap().save(&path, &SaveOptions::grey(1)).unwrap();
    let (found, _) = fitted(&begin, &[Observation::from(&*path)], FREE).unwrap();
    assert!(found.chi2.0 > (found.chi2.1 as f64 - 6.0) * 1.25, "{:?}", found.chi2);
}

/// Fits that begin far away, with hardly any dust or a million times the light, end where others do.
#[test]
#[ignore = "long"]
fn fits_may_begin_far_away() {
    let folder = tempfile::tempdir().unwrap();
    write_cloud(folder.path());
    let truth = open(folder.path(), &text(TRUTH, INSTRUMENT)).scene;
    let path = folder.path().join("far.fits");
    let exposures = Exposures::new(truth.instrument.clone().unwrap(), &traced(&truth, 1000), &truth.bands, &Control::default()).unwrap();
    record(&exposures, 3, &path);
    let run = |begin: [f64; 6], free: &str| {
        let (found, _) = fitted(&open(folder.path(), &text(begin, INSTRUMENT)), &[Observation::from(&*path)], free).unwrap();
        assert!(found.converged, "{begin:?}");
        found
    };
    let free = "dust.scale=0..20, star.0.luminosity, star.0.temperature=0..1e8";
    let near = run(TRUTH, free);
    for (at, value) in [(5, 0.01), (5, 12.0), (0, 1e9), (0, 1e-4), (1, 25000.0)] {
        let mut begin = TRUTH;
        begin[at] = value;
        let found = run(begin, free);
        assert_eq!(found.linear, [false, true, false]);
        for i in 0..3 {
            assert!(
                (found.values[i] - near.values[i]).abs() < 0.1 * near.sigma_of(i),
                "{at} {value}: {:?} {:?}",
                found.values,
                near.values
            );
        }
    }
}

/// Images of several instruments are fitted together, each by tables of its own: errors become smaller, and what is left is written.
#[test]
fn images_are_fitted_together() {
    let folder = tempfile::tempdir().unwrap();
    write_cloud(folder.path());
    let overlays = [
        r#"bands = ["johnson-B", "johnson-V"]
[instrument]
aperture = "0.5 m"
read_noise = "4 e"
sky = "21.5 mag"
exposure = "0.3 s"
frames = 4
"#,
        r#"bands = ["cousins-R"]
[instrument]
aperture = "1 m"
read_noise = "6 e"
sky = "21 mag"
exposure = "0.2 s"
frames = 2
"#,
    ];
    let overlays = overlays.map(|text| barnard_files::toml::properties("with.toml", text).unwrap());
    let base = |values| open(folder.path(), &text(values, ""));
    let with = |table: &Table| {
        let mut tree = base(TRUTH).tree().clone();
        table.iter().for_each(|(key, property)| tree.insert(key, property.clone()));
        tree
    };
    let mut observations = Vec::new();
    for (number, overlay) in overlays.iter().enumerate() {
        let file = base(TRUTH);
        let scene = Scene::from_properties(&with(overlay), "seen", file.loader()).unwrap();
        let image = traced(&scene, 4000);
        let exposures = Exposures::new(scene.instrument.clone().unwrap(), &image, &scene.bands, &Control::default()).unwrap();
        let path = folder.path().join(format!("{number}.fits"));
        record(&exposures, 5, &path);
        observations.push(Observation { with: overlay.clone(), ..Observation::from(&*path) });
    }
    let begin = base(BEGIN);
    let free =
        "star.0.luminosity, emission.0.scale, dust.scale~2+-0.2, background.radiance, star.0.temperature=4000..30000, star.1.luminosity";
    let (found, images) = fitted(&begin, &observations, free).unwrap();
    let truth = [TRUTH[0], TRUTH[3], TRUTH[5], TRUTH[4], TRUTH[1], TRUTH[2]];
    for (i, truth) in truth.iter().enumerate() {
        let pull = (found.values[i] - truth) / found.sigma_of(i);
        assert!(pull.abs() < 4.0, "{i}: {} +- {}, in truth {truth}", found.values[i], found.sigma_of(i));
        assert!(found.floor[i] > 0.0);
    }
    assert_eq!(images.units()[4], "K");
    let (alone, _) = fitted(&begin, &observations[..1], free).unwrap();
    assert!(found.sigma_of(0) < alone.sigma_of(0));
    let tree = images.tree(&found.values).unwrap().to_string();
    assert!(tree.contains("K") && tree.contains("Lsun"));
}

static OPTIONS: std::sync::LazyLock<Options> = std::sync::LazyLock::new(Options::default);

/// Images of other pixels, places, passbands and units are refused, as are images without errors, and pixels that are no numbers or masked
/// do not count.
#[test]
fn what_cannot_be_fitted_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    write_cloud(folder.path());
    let sky = |place: &str| format!("[observation]\ntarget = \"{place}\"\n");
    let images = open(folder.path(), &(text(TRUTH, INSTRUMENT) + &sky("83.82 -5.39")));
    let path = folder.path().join("own.fits");
    let plan = barnard::Planner::new(&OPTIONS).plan(&images.scene, None, &Control::default()).unwrap();
    let image = barnard::backend::Renderer::new(&mut barnard::backend::cpu::Cpu).render(&plan, &Control::default()).unwrap().0;
    let exposures = Exposures::new(images.scene.instrument.clone().unwrap(), &image, &images.scene.bands, &Control::default()).unwrap();
    record(&exposures, 1, &path);
    let refused = |text: String, free: &str, words: &str| {
        let error = fitted(&open(folder.path(), &text), &[Observation::from(&*path)], free).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    };
    let scene = text(TRUTH, INSTRUMENT);
    let free = "background.radiance";
    fitted(&images, &[Observation::from(&*path)], free).unwrap();
    refused(scene.replace("20, 16", "20, 15") + &sky("83.82 -5.39"), free, "20 x 16 pixels");
    refused(scene.clone() + &sky("83.83 -5.39"), free, "another sky position");
    refused(scene.clone() + &sky("83.82 -5.39") + "position_angle = \"20 deg\"\n", free, "another sky position");
    refused(scene.clone() + &sky("83.82 -5.39") + "unit = \"MJy/sr\"\n", free, "MJy/sr");
    refused(scene.clone() + &sky("83.82 -5.39") + "unit = \"mag/arcsec2 AB\"\n", free, "linear");
    refused(scene.replace("cousins-R", "cousins-I") + &sky("83.82 -5.39"), free, "no image of passband cousins-I");
    let scaled = scene.replace("[instrument]", "[instrument]\npixel_scale = \"20.7 arcsec\"");
    refused(scaled + &sky("83.82 -5.39"), "instrument.pixel_scale", "pixel scale");
    refused(scene.clone(), "star.0.position", "one number");
    refused(scene.clone(), "star.0.radius", "write the key in the scene");
    refused(scene.clone(), "star.0.luminosity=1..5", "the start value of star.0.luminosity, 1000, is outside of its bounds, 1 to 5");
    refused(scene.clone(), "display.exposure", "write the key in the scene");
    // A picture without errors needs an instrument.
    image.save(&path, &SaveOptions::grey(1)).unwrap();
    refused(text(TRUTH, "") + &sky("83.82 -5.39"), free, "no standard errors");
    std::fs::write(&path, b"SIMPLE").unwrap();
    refused(scene, free, "FITS");
}
