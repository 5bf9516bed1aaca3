//! Analytic truths: what a renderer must give where the answer is known in closed form.

mod hard_places;

use crate::common::rendered::{on_reference, parse};
use barnard::backend::{self, Renderer, cpu};
use barnard::control::Control;
use barnard::image::Image;
use barnard::plan::{Options, Planned, Planner, Quality};
use barnard::points::Sources;
use barnard::scene::Scene;
use spectra::constants::PARSEC;

fn on_cpu(scene: &Scene) -> Image {
    let plan = Planner::new(&Options::default()).plan(scene, None, &Control::default()).unwrap();
    Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap().0
}

const VIEW: &str = r#"[camera]
kind = "orthographic"
position = "0 0 5 pc"
width = "0.01 pc"
size = [1, 1]
"#;
const LINE_BAND: &str = r#"[[band]]
name = "b"
kind = "top_hat"
centre = "550 nm"
width = "2 nm"
"#;

/// A slab of thickness 1 pc that glows in one line at V and absorbs: I = j/σ (1 − e^(−τ)).
fn glowing_slab(tau: f64) -> Scene {
    parse(&format!(
        r#"{VIEW}{LINE_BAND}[field.slab]
kind = "box"
low = "-1 -1 -0.5 pc"
high = "1 1 0.5 pc"
[dust]
density = "slab"
scale = "{tau} /pc"
law = "inverse_wavelength"
albedo = 0
[[emission]]
kind = "lines"
density = "slab"
scale = "2 W/m2/sr/pc"
lines = [{{ wavelength = "550 nm", strength = 1 }}]
[method]
bake = 32
"#
    ))
}

#[test]
fn a_homogeneous_slab_is_its_source_function() {
    for tau in [1e-4f64, 0.1, 1.0, 10.0, 50.0] {
        let expected = 2.0 / tau * -(-tau).exp_m1();
        let scene = glowing_slab(tau);
        let truth = on_reference(&scene).at(0, 0, 0);
        assert!((truth / expected - 1.0).abs() < 1e-6, "reference, tau {tau}: {truth} {expected}");
        let fast = on_cpu(&scene).at(0, 0, 0);
        assert!((fast / expected - 1.0).abs() < 1e-3, "cpu, tau {tau}: {fast} {expected}");
    }
}

/// A uniform background behind a sphere of dust, through its middle and beside it: B e^(−2 σ R) and B.
#[test]
fn a_sphere_dims_what_lies_behind() {
    let text = |x: f64| {
        format!(
            r#"[camera]
kind = "orthographic"
position = "{x} 0 5 pc"
target = "{x} 0 0 pc"
width = "0.001 pc"
size = [1, 1]
{LINE_BAND}[field.ball]
kind = "sphere"
radius = "0.5 pc"
[dust]
density = "ball"
scale = "3 /pc"
law = "inverse_wavelength"
albedo = 0
[background]
kind = "power_law"
exponent = 0
radiance = "1 W/m2/sr/nm"
"#
        )
    };
    // ∫ e^(−3·2·0.5·0.55/λ) dλ over 549…551 nm; the exponent is linear to 1e-6 there.
    let behind = 2.0 * (-3.0f64).exp();
    let middle = on_reference(&parse(&text(0.0))).at(0, 0, 0);
    assert!((middle / behind - 1.0).abs() < 1e-5, "{middle} {behind}");
    let chord = 2.0 * (0.25f64 - 0.09).sqrt();
    let off_centre = on_reference(&parse(&text(0.3))).at(0, 0, 0);
    assert!((off_centre / (2.0 * (-3.0 * chord).exp()) - 1.0).abs() < 1e-4, "{off_centre}");
    for render in [on_reference, on_cpu] {
        let beside = render(&parse(&text(2.0))).at(0, 0, 0);
        assert!((beside - 2.0).abs() < 1e-6, "{beside}");
    }
}

fn lit_ball(tau: f64, phase: &str, rest: &str) -> String {
    format!(
        r#"{LINE_BAND}[field.ball]
kind = "box"
low = "-0.05 -0.05 -0.05 pc"
high = "0.05 0.05 0.05 pc"
[dust]
density = "ball"
scale = "{tau} /pc"
law = "inverse_wavelength"
albedo = 1
phase = {phase}
[[star]]
kind = "power_law"
exponent = 0
position = "0 100 0 pc"
spectral_luminosity = "1e30 W/nm"
visible = false
[method]
bake = 16
{rest}"#
    )
}

/// Optically thin: I = σ ℓ ω p(θ) L/(4π d²), here at θ = 90° for three phase functions.
#[test]
fn thin_dust_scatters_in_proportion() {
    let irradiance = 2.0 * 1e30 / (4.0 * std::f64::consts::PI * (100.0 * PARSEC).powi(2));
    let quarter = 1.0 / (4.0 * std::f64::consts::PI);
    let hg = quarter * 0.75 / 1.25f64.powf(1.5);
    for (phase, p) in [
        ("{ kind = \"isotropic\" }", quarter),
        ("{ kind = \"rayleigh\" }", 0.75 * quarter),
        ("{ kind = \"henyey_greenstein\", g = 0.5 }", hg),
    ] {
        let tau = 1e-3;
        let scene = parse(&format!("{VIEW}{}", lit_ball(tau, phase, "")));
        let expected = tau * 0.1 * p * irradiance;
        for (name, image) in [("reference", on_reference(&scene)), ("cpu", on_cpu(&scene))] {
            let value = image.at(0, 0, 0);
            assert!((value / expected - 1.0).abs() < 1e-3, "{name} {phase}: {value:e} {expected:e}");
        }
    }
}

/// Forward-peaked dust is brighter when the star is behind it than when it is behind the observer.
#[test]
fn forward_scattering_is_forward() {
    let seen_from = |z: f64| {
        let view = format!(
            r#"[camera]
kind = "orthographic"
position = "0 {z} 0.001 pc"
up = [0, 0, 1]
width = "0.01 pc"
size = [1, 1]
"#
        );
        let scene = parse(&format!("{view}{}", lit_ball(1e-3, "{ kind = \"henyey_greenstein\", g = 0.6 }", "")));
        (on_reference(&scene).at(0, 0, 0), on_cpu(&scene).at(0, 0, 0))
    };
    // (1 − g²)/(1 ∓ 2g + g²)^1.5: forward to backward is ((1 + g)/(1 − g))³ = 64.
    let (forward, backward) = (seen_from(-5.0), seen_from(5.0));
    assert!((forward.0 / backward.0 / 64.0 - 1.0).abs() < 1e-3, "{}", forward.0 / backward.0);
    assert!((forward.1 / backward.1 / 64.0 - 1.0).abs() < 1e-2, "{}", forward.1 / backward.1);
}

/// Energy balance at albedo 1: what a thin cloud scatters into all directions is what it takes from the star. The mean
/// over directions of the radiance, times the sphere, over the cloud's area, is τ times the irradiance; by reciprocity
/// it does not depend on the phase function.
#[test]
fn scattered_light_is_the_light_taken_away() {
    let total = |phase: &str| -> f64 {
        let nodes = spectra::quadrature::gauss_legendre(12);
        let radiance = |mu: f64| {
            // The star shines along −y; the observer looks from an angle with cos θ = μ between −y and their own place.
            let (x, y) = ((1.0 - mu * mu).sqrt() * 5.0, -5.0 * mu);
            let view = format!(
                r#"[camera]
kind = "orthographic"
position = "{x} {y} 0 pc"
up = [0, 0, 1]
width = "0.4 pc"
size = [40, 40]
"#
            );
            let image = on_cpu(&parse(&format!("{view}{}", lit_ball(1e-3, phase, ""))));
            image.band(0).sum::<f64>() * (0.4f64 / 40.0).powi(2)
        };
        nodes.iter().map(|(mu, w)| 2.0 * std::f64::consts::PI * w * radiance(*mu)).sum()
    };
    let irradiance = 2.0 * 1e30 / (4.0 * std::f64::consts::PI * (100.0 * PARSEC).powi(2));
    let taken = irradiance * 1e-3 * 0.1f64.powi(3);
    for phase in ["{ kind = \"isotropic\" }", "{ kind = \"henyey_greenstein\", g = 0.5 }"] {
        let scattered = total(phase);
        assert!((scattered / taken - 1.0).abs() < 0.02, "{phase}: {scattered:e} of {taken:e}");
    }
}

#[test]
fn empty_space_is_black() {
    let scene = parse(&format!(
        r#"{VIEW}{LINE_BAND}[[star]]
kind = "blackbody"
temperature = "9000 K"
luminosity = "1 Lsun"
position = "3 3 0 pc"
"#
    ));
    for render in [on_reference, on_cpu] {
        assert_eq!(render(&scene).at(0, 0, 0), 0.0);
    }
}

/// The flux of a drawn star is L/(4π d²) through the band, dimmed by the dust before it.
#[test]
fn a_visible_star_has_its_flux() {
    let text = |dust: &str| {
        format!(
            r#"[camera]
kind = "perspective"
position = "0 0 10 pc"
field_of_view = "4 deg"
size = [40, 40]
{LINE_BAND}{dust}[[star]]
kind = "power_law"
exponent = 0
position = "0.01 0.02 0 pc"
spectral_luminosity = "1e30 W/nm"
"#
        )
    };
    let veil = r#"[field.veil]
kind = "box"
low = "-1 -1 1 pc"
high = "1 1 2 pc"
[dust]
density = "veil"
scale = "2 /pc"
law = "inverse_wavelength"
albedo = 0
"#;
    let flux = |image: &Image, scene: &Scene| -> f64 {
        let pixel = |i: usize| image.samples.at(i) * scene.camera.pixel_measure((i % 40) as f64 + 0.5, (i / 40) as f64 + 0.5);
        (0..1600).map(pixel).sum()
    };
    let expected = 2.0 * 1e30 / (4.0 * std::f64::consts::PI * (100.0005f64.sqrt() * PARSEC).powi(2));
    for render in [on_reference, on_cpu] {
        let bare = parse(&text(""));
        let value = flux(&render(&bare), &bare);
        assert!((value / expected - 1.0).abs() < 1e-4, "{value:e} {expected:e}");
        let veiled = parse(&text(veil));
        let value = flux(&render(&veiled), &veiled);
        assert!((value / (expected * (-2.0f64).exp()) - 1.0).abs() < 2e-3, "{value:e}");
    }
}

/// Error against the exact slab falls with the square of the step (a Plummer cloud: smooth, no kinks but the voxels').
#[test]
fn the_march_converges_with_the_square_of_its_step() {
    let scene = parse(&format!(
        r#"{VIEW}{LINE_BAND}[field.cloud]
kind = "plummer"
core = "0.3 pc"
cut = "1 pc"
[dust]
density = "cloud"
scale = "4 /pc"
law = "inverse_wavelength"
albedo = 0
[[emission]]
kind = "lines"
density = "cloud"
scale = "1 W/m2/sr/pc"
lines = [{{ wavelength = "550 nm", strength = 1 }}]
[method]
bake = 256
"#
    ));
    // ∫ e^(−τ) dτ/σ·j with j = σ/4: (1 − e^(−τ))/4, τ the column of the cut Plummer sphere: 4·2∫₀¹(1 + r²/0.09)^(−5/2)
    // dr.
    let column = 8.0 * spectra::quadrature::integrate(|r: f64| (1.0 + r * r / 0.09).powf(-2.5), 0.0, 1.0, 1e-13);
    let truth = 0.25 * -(-column).exp_m1();
    let error = |steps: usize| {
        let scene = scene.edited(|spec| spec.method.steps = Some(steps)).unwrap();
        (on_cpu(&scene).at(0, 0, 0) / truth - 1.0).abs()
    };
    let (coarse, fine) = (error(8), error(16));
    assert!(fine < 0.35 * coarse && coarse < 0.2, "{coarse:e} {fine:e}");
    // What remains is the sampling of the cloud itself: (voxel/core)² f''/24 with a voxel of 1/128 pc and a core of 0.3
    // pc.
    let sampling = (1.0f64 / 128.0 / 0.3).powi(2);
    assert!(error(512) < sampling, "{:e}", error(512));
}

/// Bits do not depend on the number of threads.
#[test]
fn threads_do_not_matter() {
    let scene = parse(&format!(
        r#"[camera]
kind = "perspective"
position = "0 0 4 pc"
field_of_view = "30 deg"
size = [19, 15]
supersampling = 2
{LINE_BAND}[field.cloud]
kind = "fbm"
[dust]
density = "cloud"
scale = "3 /pc"
[[star]]
kind = "blackbody"
temperature = "9000 K"
luminosity = "100 Lsun"
position = "0.1 0.2 0.3 pc"
[background.stars]
density = "2000 /deg2"
[method]
accuracy = 0.05
bake = 32
"#
    ));
    let with = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| on_cpu(&scene));
    let (one, many) = (with(1), with(7));
    assert!(one.samples == many.samples, "the picture depends on the number of threads");
    let steeper = parse(&format!("{VIEW}{LINE_BAND}"));
    assert!(on_cpu(&steeper).samples != one.samples);
}

/// A preview has the stars of the star field, as many and as bright as the plan's own picture has them.
#[test]
fn a_preview_has_the_star_field() {
    let scene = parse(&format!(
        r#"[camera]
kind = "perspective"
position = "0 0 4 pc"
field_of_view = "30 deg"
size = [64, 48]
{LINE_BAND}[field.ball]
kind = "sphere"
radius = "0.5 pc"
[dust]
density = "ball"
scale = "3 /pc"
[[star]]
kind = "blackbody"
temperature = "9000 K"
luminosity = "100 Lsun"
position = "0.1 0.2 0.8 pc"
[background.stars]
density = "2000 /deg2"
[method]
bake = 32
"#
    ));
    let options = Options::default();
    let drawn = |plan: &Planned, sources: Sources| {
        let mut light = 0.0;
        backend::draw(sources, plan, &Control::default(), |_, value| light += value).unwrap();
        light
    };
    let preview = Planner::new(&options).with_quality(Quality::Preview).plan(&scene, None, &Control::default()).unwrap();
    let plan = Planner::new(&options).plan(&scene, None, &Control::default()).unwrap();
    let (quick, whole) = (drawn(&preview, Sources::All), drawn(&plan, Sources::All));
    assert!((quick / whole - 1.0).abs() < 0.02, "{quick} {whole}");
    let some = drawn(&preview, Sources::Brightest(100));
    assert!(some > drawn(&preview, Sources::Brightest(0)) && some < quick, "{some} {quick}");
}
