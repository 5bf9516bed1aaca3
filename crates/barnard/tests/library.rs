//! Scenes that a program makes: the bits of the same scene from a file, and refusals that say the place and what would
//! be right.

use std::sync::Arc;

use barnard::backend::{Backend, Job, Registry, Renderer, cpu};
use barnard::field::{Fbm, Field, Grid, Plummer, Shell, Slab};
use barnard::geometry::Bounds;
use barnard::glam::{DVec3, dvec3};
use barnard::image::Level;
use barnard::phase::HenyeyGreenstein;
use barnard::plan::{Planner, Quality};
use barnard::properties::{Property, Table, Value};
use barnard::scene::{Albedo, Background, Dust, Loader, Method, Scale, Scene, SceneSpec, Star, StarField};
use barnard::spectra::extinction::{Extinction, ExtinctionLaw};
use barnard::spectra::passband::{self, Counting, Curve, Passband};
use barnard::spectra::spectrum::{Shape, Spectrum};
use barnard::spectra::units::{Luminosity, Temperature};
use barnard::{Camera, Control, Options};

fn made() -> Scene {
    let cloud = Fbm { scale: 0.5, ..Fbm::new(7) }.checked().unwrap();
    let law = Extinction::by_name("gordon23").unwrap();
    let dust = Dust::new(cloud, law, Scale::mag_per_pc(3.0)).with_albedo(0.6).with_phase(HenyeyGreenstein::new(0.5).unwrap());
    let star = Star::blackbody(Temperature(12_000.0), Luminosity::suns(900.0)).with_position(dvec3(0.2, 0.1, 0.3)).with_name("star 1");
    let camera = Camera::look_at(dvec3(0.0, 0.5, 5.0), DVec3::ZERO).with_field_of_view_deg(30.0).with_size(24, 18);
    let method = Method { bake: Some(32), ..Method::default() };
    let spec = SceneSpec::new(camera).with_bands(passband::set("johnson").unwrap()).with_dust(dust).with_star(star);
    spec.with_method(method).build().unwrap()
}

/// Parts of an image by the plan of the whole are the whole: dust, stars of the scene and of the field across the seams.
#[test]
#[ignore = "long"]
fn parts_of_an_image_make_the_whole() {
    let field = StarField { density_per_sr: 3e4, ..StarField::default() };
    let scene = made().edited(|spec| {
        spec.background = Background::stars(field);
        spec.camera = spec.camera.clone().with_size(50, 37);
    });
    let scene = scene.unwrap();
    let control = Control::default();
    let mut plan = Planner::new(&Options::default()).plan(&scene, None, &control).unwrap();
    let whole = Renderer::new(&mut cpu::Cpu).render(&plan, &control).unwrap().0;
    let brightest = (0..3 * 50 * 37).map(|i| whole.samples.at(i)).fold(0.0, f64::max);
    for (column, row, width, height) in [(0, 0, 20, 20), (20, 0, 30, 20), (0, 20, 20, 17), (20, 20, 30, 17), (49, 36, 1, 1)] {
        let camera = scene.camera.clone().crop(column, row, width, height).unwrap();
        plan.look_from(camera.clone(), &control).unwrap();
        let part = Renderer::new(&mut cpu::Cpu).render(&plan, &control).unwrap().0;
        for band in 0..3 {
            for (i, j) in (0..height).flat_map(|i| (0..width).map(move |j| (i, j))) {
                let (ours, theirs) = (part.at(band, i, j), whole.at(band, row + i, column + j));
                assert!((ours - theirs).abs() < 1e-6 * theirs + 1e-9 * brightest, "{i} {j}: {ours} {theirs}");
            }
        }
        // The axis of view is where it was.
        let (right, down) = (25.0 - (column as f64 + 0.5 * width as f64), 18.5 - (row as f64 + 0.5 * height as f64));
        assert!((part.axis.0 - right).abs() < 1e-12 && (part.axis.1 + down).abs() < 1e-12, "{:?}", part.axis);
    }
}

const TEXT: &str = r#"
bands = "johnson"
[camera]
kind = "perspective"
position = "0 0.5 5 pc"
field_of_view = "30 deg"
size = [24, 18]
[field.cloud]
kind = "fbm"
seed = 7
scale = "0.5 pc"
[dust]
density = "cloud"
scale = "3 mag/pc"
law = "gordon23"
albedo = 0.6
phase = { kind = "henyey_greenstein", g = 0.5 }
[[star]]
kind = "blackbody"
position = "0.2 0.1 0.3 pc"
temperature = "12000 K"
luminosity = "900 Lsun"
[method]
bake = 32
"#;

#[test]
fn objects_make_the_scene_that_a_file_makes() {
    let read = barnard_files::parse("test.toml", "scene", TEXT.to_owned(), &Loader::default()).unwrap();
    let options = Options::default();
    let (ours, theirs) = (barnard::render(&made(), &options).unwrap(), barnard::render(&read, &options).unwrap());
    assert_eq!(ours.samples, theirs.samples);
    assert_eq!(made().save_options(), read.save_options());
    let other = made().edited(|spec| spec.stars[0].position.x += 0.01).unwrap();
    assert!(barnard::render(&other, &options).unwrap().samples != theirs.samples);
}

/// A law that stops short of the red.
#[derive(Debug)]
struct Short;

impl ExtinctionLaw for Short {
    fn k(&self, _: f64) -> f64 {
        1.0
    }
    fn range_um(&self) -> (f64, f64) {
        (0.1, 0.6)
    }
}

/// A change of a scene that makes it wrong, and words of the refusal.
type Fault = (fn(&mut SceneSpec), &'static [&'static str]);

#[test]
fn what_cannot_be_rendered_is_refused_with_its_place() {
    let faults: [Fault; 21] = [
        (|s| s.camera = Camera::look_at(DVec3::ONE, DVec3::ONE), &["camera", "same position"]),
        (|s| s.camera = Camera::look_at(DVec3::Y, DVec3::ZERO), &["camera", "up"]),
        (|s| s.camera = s.camera.clone().with_size(0, 9), &["camera", "0 x 9 pixels"]),
        (|s| s.camera = s.camera.clone().with_field_of_view_deg(190.0), &["camera", "field of view"]),
        (|s| s.camera = s.camera.clone().with_supersampling(17), &["supersampling", "17"]),
        (|s| s.bands.clear(), &["bands", "no passbands"]),
        (|s| s.bands.truncate(1), &["display.palette", "3 bands, the scene has 1"]),
        (|s| s.stars.push(Star::blackbody(Temperature(0.0), Luminosity::suns(1.0))), &["star[1]", "finite"]),
        (|s| s.stars[0].position.y = f64::NAN, &["star[0].position", "must be finite"]),
        (|s| s.dust = s.dust.take().map(|d| d.with_albedo(1.2)), &["dust", "albedo is 1.2", "between 0 and 1"]),
        (
            |s| {
                s.dust = s.dust.take().map(|d| Dust::new(d.density, Extinction::by_name("inverse_wavelength").unwrap(), Scale::per_pc(1.0)))
            },
            &["albedo", "inverse_wavelength"],
        ),
        (
            |s| s.dust = s.dust.take().map(|d| Dust::new(d.density, Extinction::new("short", Short), Scale::per_pc(1.0)).with_albedo(0.5)),
            &["bands", "short"],
        ),
        (|s| s.method.steps = Some(0), &["method", "steps is 0", "between 1"]),
        (|s| s.method.accuracy = f64::NAN, &["method", "accuracy is NaN"]),
        (|s| s.method.bounces = 0, &["method", "bounces is 0"]),
        (|s| s.dust = s.dust.take().map(|d| Dust { density: Arc::new(Fbm { octaves: 0, ..Fbm::new(1) }), ..d }), &["dust", "octaves"]),
        (|s| s.dust = s.dust.take().map(|d| d.with_albedo(Albedo::Linear { value: 0.5, slope: f64::NAN, at_um: 0.5 })), &["slope"]),
        (|s| s.camera.up = DVec3::X, &["camera", "orthonormal"]),
        (|s| s.display.white = Level::Radiance(f64::NAN), &["display", "white level is NaN"]),
        (|s| (s.display.black, s.display.white) = (Level::Radiance(2.0), Level::Radiance(1.0)), &["display", "above the black"]),
        (|s| s.background = Background::stars(StarField { magnitudes: (9.0, 8.0), ..StarField::default() }), &["background", "9 to 8"]),
    ];
    assert!(made().check().is_ok());
    let plan = Planner::new(&Options::default()).plan(made(), None, &Control::default()).unwrap();
    for (spoil, words) in faults {
        let error = made().edited(spoil).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{words:?}: {error}");
    }
    // Cameras, methods and displays are exchanged without a check: whatever renders the scene checks it.
    let blind = made().with_camera(made().camera.clone().with_size(0, 9));
    let endless = made().with_method(Method { accuracy: f64::NAN, ..made().method.clone() });
    for scene in [blind, endless] {
        let (options, control) = (Options::default(), Control::default());
        let preview = Planner::new(&options).with_quality(Quality::Preview).plan(&scene, None, &control);
        assert!(barnard::render(&scene, &options).is_err() && Job::new(&scene, &options).is_err());
        assert!(preview.is_err() && plan.for_scene(&scene, &control).is_err());
    }
    let fewer = made().edited(|spec| *spec = spec.clone().with_bands(spec.bands[..1].to_vec())).unwrap();
    let refused = plan.for_scene(&fewer, &Control::default()).unwrap_err().to_string();
    assert!(refused.contains("differs from that of its plan (spectra)"), "{refused}");
    let brighter = made().with_camera(made().camera.clone().with_size(5, 4));
    let brighter = brighter.edited(|spec| spec.display.white = Level::Radiance(1.0)).unwrap();
    let planned = plan.for_scene(&brighter, &Control::default()).unwrap();
    assert_eq!((planned.camera().width, planned.scene().display.white), (5, Level::Radiance(1.0)));
}

/// A back end that has rendered one scene renders the next as a new one does.
#[test]
#[ignore = "long"]
fn back_ends_begin_anew_with_another_scene() {
    let (options, control) = (Options::default(), Control::default());
    let one = made().with_camera(made().camera.clone().with_size(6, 4));
    let second = Star::blackbody(Temperature(5000.0), Luminosity::suns(300.0)).with_position(dvec3(-0.4, 0.2, 0.1));
    let other = one.edited(|spec| spec.stars.push(second)).unwrap();
    for entry in Registry::default().entries().iter().filter(|entry| entry.name != "reference") {
        let light =
            |backend: &mut dyn Backend, scene: &Scene| backend.radiance(&Job::new(scene, &options).unwrap(), &control).unwrap().samples;
        let mut backend = (entry.open)(&one).unwrap();
        let first = light(&mut *backend, &one);
        let second = light(&mut *backend, &other);
        assert!(second == light(&mut *(entry.open)(&other).unwrap(), &other) && second != first, "{}", entry.name);
    }
}

/// A field, a passband's curve and a spectral shape of one's own.
#[derive(Debug)]
struct Ramp;

impl Field for Ramp {
    fn at(&self, p: DVec3) -> f64 {
        if self.bounds().contains(p) { 1.0 + p.x } else { 0.0 }
    }
    fn bounds(&self) -> Bounds {
        Bounds::cube(DVec3::ZERO, 1.0)
    }
}

impl Curve for Ramp {
    fn throughput(&self, lambda_um: f64) -> f64 {
        (lambda_um - 0.5).clamp(0.0, 0.1)
    }
    fn support_um(&self) -> (f64, f64) {
        (0.5, 0.7)
    }
    fn breakpoints_um(&self) -> Vec<f64> {
        vec![0.5, 0.6, 0.7]
    }
}

impl Shape for Ramp {
    fn at(&self, lambda_um: f64) -> f64 {
        lambda_um
    }
}

/// Such objects are rendered as those of the crates: by the plan and by the reference to what the plan states.
#[test]
fn objects_of_ones_own_are_rendered() {
    let band = Passband::new("ramp", Counting::Photon, Ramp).unwrap();
    let dust = Dust::new(Ramp, Extinction::by_name("ccm89").unwrap(), Scale::per_pc(0.7)).with_albedo(0.5);
    let star = Star::new(Spectrum::continuous(1e26, Arc::new(Ramp))).with_position(dvec3(0.3, 1.6, 0.2)).hidden();
    let camera = Camera::look_at(dvec3(0.0, 0.0, 6.0), DVec3::ZERO).with_field_of_view_deg(30.0).with_size(8, 8);
    let scene = SceneSpec::new(camera).with_bands(vec![band]).with_dust(dust).with_star(star).build().unwrap();
    let image = barnard::render(&scene, &Options::default()).unwrap();
    let truth = barnard::render_reference(&scene, 1e-4, &Control::default()).unwrap();
    let wrong = image.relative_rmse(0, &truth, 0);
    assert!(wrong < 3e-3 && truth.band(0).any(|v| v > 0.0), "{wrong:e}");
}

#[test]
fn objects_refuse_what_they_cannot_be() {
    let cube = Bounds::cube(DVec3::ZERO, 1.0);
    let words = |error: barnard::Error| error.to_string();
    let short = words(Grid::new([2, 2, 2], cube, vec![0.0; 7]).unwrap_err());
    assert!(short.contains("found 7") && short.contains("2 x 2 x 2"), "{short}");
    let negative = words(Grid::new([2, 1, 1], cube, vec![0.0, -1.0]).unwrap_err());
    assert!(negative.contains("[1, 0, 0]") && negative.contains("negative"), "{negative}");
    let nan = words(Grid::new([1, 1, 2], cube, vec![f32::NAN, 0.0]).unwrap_err());
    assert!(nan.contains("NaN") && nan.contains("[0, 0, 0]"), "{nan}");
    assert!(Grid::new([usize::MAX, 2, 2], cube, Vec::new()).is_err() && Grid::new([0, 1, 1], cube, Vec::new()).is_err());
    assert!(words(Grid::new([1; 3], Bounds::cube(DVec3::ZERO, 0.0), vec![1.0]).unwrap_err()).contains("box"));
    assert!(words(Plummer::new(DVec3::ZERO, -1.0).unwrap_err()).contains("core"));
    assert!(words(Shell::new(DVec3::ZERO, 1.0, 1e-6).unwrap_err()).contains("thickness"));
    assert!(words(Slab::new(DVec3::ZERO, DVec3::ZERO, 1.0, 1.0).unwrap_err()).contains("normal"));
    assert!(words(Fbm { octaves: 40, ..Fbm::new(1) }.checked().unwrap_err()).contains("octaves"));
}

/// A tree that no file made is read as a file is, and its errors name the path.
#[test]
fn trees_need_no_text() {
    let text = |words: &str| Property::from(Value::Text(words.into()));
    let table = |entries: &[(&str, &str)]| {
        let mut table = Table::default();
        entries.iter().for_each(|(key, value)| table.insert(*key, text(value)));
        table
    };
    let scene = |temperature: &str| {
        let mut root = Table::default();
        let camera = table(&[("kind", "perspective"), ("position", "0 0 5 pc"), ("field_of_view", "30 deg")]);
        let star = table(&[("kind", "blackbody"), ("position", "0 0 0 pc"), ("temperature", temperature), ("luminosity", "1 Lsun")]);
        root.insert("camera", Value::Table(camera));
        root.insert("star", Value::List(vec![Value::Table(star).into()]));
        Scene::from_properties(&root, "tree", &Loader::default())
    };
    assert_eq!(scene("6000 K").unwrap().stars.len(), 1);
    let error = scene("6000 m").unwrap_err().to_string();
    assert!(error.contains("star[0].temperature") && error.contains("unknown unit"), "{error}");
}

/// Each row of the registry opens a back end that renders or says why not.
#[test]
fn every_back_end_serves_a_job() {
    let scene = made().with_camera(made().camera.clone().with_size(4, 3));
    let (options, control) = (Options::default(), Control::default());
    for entry in Registry::default().entries() {
        let mut backend = (entry.open)(&scene).unwrap();
        let job = Job::new(&scene, &options).unwrap();
        assert_eq!(backend.unsupported(&job, &control).unwrap(), None, "{}", entry.name);
        let (image, stats) = Renderer::new(&mut *backend).render(job, &control).unwrap();
        assert!((image.width, image.height) == (4, 3) && image.band(1).any(|v| v > 0.0) && stats.rays > 0, "{}", entry.name);
        assert!(image.report.backend.as_deref() == Some(entry.name), "{}", entry.name);
    }
    let many = scene.clone().with_method(Method { bounces: 5, ..Default::default() });
    let reference = (Registry::default().by_name("reference").unwrap().open)(&many).unwrap();
    assert!(reference.unsupported(&Job::new(&many, &options).unwrap(), &control).unwrap().unwrap().contains("bounces = 1"));
    assert!(Registry::default().by_name("gpux").unwrap_err().to_string().contains("reference"));
}
