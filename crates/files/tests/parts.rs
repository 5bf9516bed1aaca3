//! Parts of a scene: a change of a value changes the parts that its key declares, and no others.

use std::collections::BTreeSet;

use barnard::properties::places::set;
use barnard::properties::{Form, Table, Type, Value};
use barnard::scene::{Loader, Parameter, Part, Scene, parameters};

const SCENE: &str = r#"
[camera]
kind = "perspective"
position = "0 0.5 6 pc"
target = "0.1 0.2 0.3 pc"
field_of_view = "24 deg"
size = [16, 12]
crop = [2, 2, 8, 8]

[camera.stereo]
eye_distance = "0.1 pc"
convergence = "5 pc"

[bookmark.1]
kind = "perspective"
position = "0 4 0 pc"
up = [0, 0.1, 1]
field_of_view = "20 deg"

[field.cloud]
kind = "fbm"
warp = "0.1 pc"
centre = "0.1 0.2 0.3 pc"

[field.ball]
kind = "sphere"
radius = "1 pc"

[field.wall]
kind = "shell"
radius = "1 pc"
thickness = "0.1 pc"

[field.plate]
kind = "slab"
thickness = "0.1 pc"
extent = "1 pc"
normal = [0.1, 0.2, 1]

[field.crowd]
kind = "plummer"
core = "0.2 pc"
cut = "1 pc"

[field.block]
kind = "box"
low = "-1 -1 -1 pc"
high = "1 1.5 1 pc"

[field.storm]
kind = "turbulence"
voxels = 16
outer_scale = "0.5 pc"
plasma_beta = 2.0

[dust]
density = "cloud + ball + wall + plate + crowd + block"
scale = "4 mag/pc"
law = "fitzpatrick99"
r_v = 3.5
albedo = { kind = "linear", value = 0.5, slope = 0.1, at = "500 nm" }
phase = { kind = "draine", g = 0.5, alpha = 0.5 }

[detail]
seed = 1
strength = 0.04

[[star]]
kind = "blackbody"
position = "0.3 0.2 0.9 pc"
temperature = "20000 K"
luminosity = "3000 Lsun"

[[star]]
kind = "atmosphere"
position = "0.3 -0.2 0.9 pc"
temperature = "21000 K"
log_g = 4.0
magnitude = "5 mag"
distance = "100 pc"
extinction = "0.5 mag"

[[star]]
kind = "power_law"
position = "0.3 -0.2 -0.9 pc"
exponent = -2.0
reference = "500 nm"
spectral_luminosity = "1e29 W/nm"
wavelength = "600 nm"

[[emission]]
kind = "recombination"
density = "storm"
temperature = "10000 K"
electron_density = "1000 cm-3"

[[emission]]
kind = "ion"
ion = "H1"
density = "cloud"
temperature = "10000 K"
electron_density = "1000 cm-3"
abundance = 0.5
doppler_fwhm = "20 km/s"

[[emission]]
kind = "lines"
density = "ball"
scale = "1e-25 W/m3/sr"
lines = [{ wavelength = "656.46 nm", strength = 3 }]
continuum = 0.1
continuum_at = "500 nm"
continuum_exponent = -1.0

[background]
kind = "blackbody"
temperature = "15000 K"
radiance = "1e-7 W/m2/sr/um"
wavelength = "500 nm"

[background.stars]
seed = 2

[[band]]
name = "hat"
kind = "top_hat"
centre = "550 nm"
width = "50 nm"

[[band]]
name = "bell"
kind = "gaussian"
centre = "550 nm"
fwhm = "50 nm"

[display]
black = 0.1
white = 2.0
stretch = "asinh"
strength = 20.0

[display.glare]
seeing = 1.0

[observation]
target = "18h18m48s -13d49m"
distance = "1.7 kpc"

[instrument]
aperture = "1 m"
collecting_area = "0.5 m2"
sky = ["21 mag"]
pixel_scale = "1 arcsec"
bias = "500 ADU"
full_well = "50000 e"

[[instrument.psf]]
kind = "gaussian"
fwhm = "1 arcsec"

[[instrument.psf]]
kind = "moffat"
fwhm = "1 arcsec"

[[instrument.psf]]
kind = "airy"
vanes = 4

[method]
count = 3
range = 5.0
steps = 50
star_depth_voxels = 2
bake = 24
exact_stars = 2

[method.path]
target_error = 0.1
"#;

/// Keys without effect on this scene: a continuum has no lines to broaden.
const SILENT: [&str; 1] = ["emission[0].doppler_fwhm"];

fn read(tree: &Table) -> barnard::Result<Scene> {
    Scene::from_properties(tree, "parts", &Loader::default())
}

/// Other values near that of a parameter.
fn neighbours(parameter: &Parameter) -> Vec<Value> {
    match (&parameter.value, Form::of(&parameter.value)) {
        (Value::Flag(flag), _) => vec![Value::Flag(!flag)],
        (Value::Integer(number), _) => vec![Value::Integer(number + 1), Value::Integer(number - 1)],
        (Value::Text(text), _) if matches!(parameter.key.value, Type::Choice(_)) => {
            parameter.key.value.choices().into_iter().filter(|choice| choice != text).map(|choice| Value::Text(choice.into())).collect()
        }
        (_, Some((form, numbers))) => {
            let moved = |part: f64| {
                let size = numbers.iter().fold(0.0f64, |most, number| most.max(number.abs()));
                let step = part * if size > 0.0 { size } else { 1.0 };
                let whole = matches!(parameter.key.value, Type::Size);
                let step = if whole { step.signum() } else { step };
                let values: Vec<f64> = numbers.iter().enumerate().map(|(i, n)| if i == 0 { n + step } else { *n }).collect();
                form.value(&values)
            };
            vec![moved(1e-3), moved(-1e-3)]
        }
        _ => Vec::new(),
    }
}

/// Each declared parameter changes exactly the parts that it declares.
#[test]
fn values_change_the_parts_that_they_declare() {
    let tree = barnard_files::toml::properties("parts.toml", SCENE).unwrap();
    let base = read(&tree).unwrap_or_else(|error| panic!("{error}")).parts();
    let (mut wrong, mut checked, mut tables) = (Vec::new(), 0, BTreeSet::new());
    for parameter in parameters(&tree).iter().filter(|parameter| !SILENT.contains(&parameter.path.as_str())) {
        let scenes = neighbours(parameter).into_iter().filter(|value| parameter.check(value).is_ok()).filter_map(|value| {
            let mut changed = tree.clone();
            set(&mut changed, &parameter.path, value.into()).ok()?;
            read(&changed).ok()
        });
        let Some(scene) = { scenes }.next() else { continue };
        let (found, declared) = (base.differing(&scene.parts()), parameter.parts.to_vec());
        if found != declared {
            wrong.push(format!("{}: changed {found:?}, declared {declared:?}", parameter.path));
        }
        checked += 1;
        tables.insert(parameter.path.split(['.', '[']).next().unwrap().to_owned());
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(checked > 120 && tables.len() >= 11, "{checked} parameters of {tables:?}");
}

/// A key that is declared to change another part is noticed.
#[test]
fn another_declaration_is_noticed() {
    let tree = barnard_files::toml::properties("parts.toml", SCENE).unwrap();
    let mut changed = tree.clone();
    set(&mut changed, "star[0].temperature", Value::Quantity(vec![20001.0], "K".into()).into()).unwrap();
    let differing = read(&tree).unwrap().parts().differing(&read(&changed).unwrap().parts());
    assert_eq!(differing, [Part::Spectra]);
    assert_ne!(differing, [Part::Space]);
}
