//! Analytic truths: what a renderer must give where the answer is known in closed form.

#[path = "common/rendered.rs"]
mod rendered;

use barnard::backend::{self, cpu};
use barnard::control::Control;
use barnard::image::Image;
use barnard::plan::{Options, Plan};
use barnard::points::Sources;
use barnard::scene::Scene;
use rendered::{on_reference, parse};
use spectra::constants::PARSEC;

fn on_cpu(scene: &Scene) -> Image {
    let plan = Plan::new(scene, &Options::default(), &Control::default()).unwrap();
    cpu::render(scene, &plan, &Control::default()).unwrap().0
}

const VIEW: &str = "[camera]\nkind = \"orthographic\"\nposition = \"0 0 5 pc\"\nwidth = \"0.01 pc\"\nsize = [1, 1]\n";
const LINE_BAND: &str = "[[band]]\nname = \"b\"\nkind = \"top_hat\"\ncentre = \"550 nm\"\nwidth = \"2 nm\"\n";

/// A slab of thickness 1 pc that glows in one line at V and absorbs: I = j/σ (1 − e^(−τ)).
fn glowing_slab(tau: f64) -> Scene {
    parse(&format!(
        "{VIEW}{LINE_BAND}[field.slab]\nkind = \"box\"\nlow = \"-1 -1 -0.5 pc\"\nhigh = \"1 1 0.5 pc\"\n\
         [dust]\ndensity = \"slab\"\nscale = \"{tau} /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0\n\
         [[emission]]\nkind = \"lines\"\ndensity = \"slab\"\nscale = \"2 W/m2/sr/pc\"\nlines = [{{ wavelength = \"550 nm\", strength = 1 }}]\n[method]\nbake = 32\n"
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
            "[camera]\nkind = \"orthographic\"\nposition = \"{x} 0 5 pc\"\ntarget = \"{x} 0 0 pc\"\nwidth = \"0.001 pc\"\nsize = [1, 1]\n{LINE_BAND}\
             [field.ball]\nkind = \"sphere\"\nradius = \"0.5 pc\"\n[dust]\ndensity = \"ball\"\nscale = \"3 /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0\n\
             [background]\nkind = \"power_law\"\nexponent = 0\nradiance = \"1 W/m2/sr/nm\"\n"
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
        "{LINE_BAND}[field.ball]\nkind = \"box\"\nlow = \"-0.05 -0.05 -0.05 pc\"\nhigh = \"0.05 0.05 0.05 pc\"\n\
         [dust]\ndensity = \"ball\"\nscale = \"{tau} /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 1\nphase = {phase}\n\
         [[star]]\nkind = \"power_law\"\nexponent = 0\nposition = \"0 100 0 pc\"\nspectral_luminosity = \"1e30 W/nm\"\nvisible = false\n[method]\nbake = 16\n{rest}"
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
            "[camera]\nkind = \"orthographic\"\nposition = \"0 {z} 0.001 pc\"\nup = [0, 0, 1]\nwidth = \"0.01 pc\"\nsize = [1, 1]\n"
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
                "[camera]\nkind = \"orthographic\"\nposition = \"{x} {y} 0 pc\"\nup = [0, 0, 1]\nwidth = \"0.4 pc\"\nsize = [40, 40]\n"
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
        "{VIEW}{LINE_BAND}[[star]]\nkind = \"blackbody\"\ntemperature = \"9000 K\"\nluminosity = \"1 Lsun\"\nposition = \"3 3 0 pc\"\n"
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
            "[camera]\nkind = \"perspective\"\nposition = \"0 0 10 pc\"\nfield_of_view = \"4 deg\"\nsize = [40, 40]\n{LINE_BAND}{dust}\
             [[star]]\nkind = \"power_law\"\nexponent = 0\nposition = \"0.01 0.02 0 pc\"\nspectral_luminosity = \"1e30 W/nm\"\n"
        )
    };
    let veil = "[field.veil]\nkind = \"box\"\nlow = \"-1 -1 1 pc\"\nhigh = \"1 1 2 pc\"\n[dust]\ndensity = \"veil\"\nscale = \"2 /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0\n";
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
    let mut scene = parse(&format!(
        "{VIEW}{LINE_BAND}[field.cloud]\nkind = \"plummer\"\ncore = \"0.3 pc\"\ncut = \"1 pc\"\n\
         [dust]\ndensity = \"cloud\"\nscale = \"4 /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0\n\
         [[emission]]\nkind = \"lines\"\ndensity = \"cloud\"\nscale = \"1 W/m2/sr/pc\"\nlines = [{{ wavelength = \"550 nm\", strength = 1 }}]\n[method]\nbake = 256\n"
    ));
    // ∫ e^(−τ) dτ/σ·j with j = σ/4: (1 − e^(−τ))/4, τ the column of the cut Plummer sphere: 4·2∫₀¹(1 + r²/0.09)^(−5/2)
    // dr.
    let column = 8.0 * spectra::quadrature::integrate(|r: f64| (1.0 + r * r / 0.09).powf(-2.5), 0.0, 1.0, 1e-13);
    let truth = 0.25 * -(-column).exp_m1();
    let mut error = |steps: usize| {
        scene.method.steps = Some(steps);
        (on_cpu(&scene).at(0, 0, 0) / truth - 1.0).abs()
    };
    let (coarse, fine) = (error(8), error(16));
    assert!(fine < 0.35 * coarse && coarse < 0.2, "{coarse:e} {fine:e}");
    // What remains is the sampling of the cloud itself: (voxel/core)² f''/24 with a voxel of 1/128 pc and a core of 0.3
    // pc.
    let sampling = (1.0f64 / 128.0 / 0.3).powi(2);
    assert!(error(512) < sampling, "{:e}", error(512));
}

/// The same bits on one thread and on many.
#[test]
fn threads_do_not_matter() {
    let scene = parse(&format!(
        "[camera]\nkind = \"perspective\"\nposition = \"0 0 4 pc\"\nfield_of_view = \"30 deg\"\nsize = [37, 29]\nsupersampling = 2\n\
         {LINE_BAND}[field.cloud]\nkind = \"fbm\"\n[dust]\ndensity = \"cloud\"\nscale = \"3 /pc\"\n\
         [[star]]\nkind = \"blackbody\"\ntemperature = \"9000 K\"\nluminosity = \"100 Lsun\"\nposition = \"0.1 0.2 0.3 pc\"\n\
         [background.stars]\ndensity = \"2000 /deg2\"\n[method]\nbake = 32\n"
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
        "[camera]\nkind = \"perspective\"\nposition = \"0 0 4 pc\"\nfield_of_view = \"30 deg\"\nsize = [64, 48]\n{LINE_BAND}\
         [field.ball]\nkind = \"sphere\"\nradius = \"0.5 pc\"\n[dust]\ndensity = \"ball\"\nscale = \"3 /pc\"\n\
         [[star]]\nkind = \"blackbody\"\ntemperature = \"9000 K\"\nluminosity = \"100 Lsun\"\nposition = \"0.1 0.2 0.8 pc\"\n\
         [background.stars]\ndensity = \"2000 /deg2\"\n[method]\nbake = 32\n"
    ));
    let options = Options::default();
    let drawn = |plan: &Plan, sources: Sources| {
        let mut light = 0.0;
        backend::draw(sources, &scene, plan, &Control::default(), |_, value| light += value).unwrap();
        light
    };
    let preview = Plan::preview(None, &scene, &options, &Control::default()).unwrap();
    let plan = Plan::new(&scene, &options, &Control::default()).unwrap();
    let (quick, whole) = (drawn(&preview, Sources::All), drawn(&plan, Sources::All));
    assert!((quick / whole - 1.0).abs() < 0.02, "{quick} {whole}");
    let some = drawn(&preview, Sources::Brightest(100));
    assert!(some > drawn(&preview, Sources::Brightest(0)) && some < quick, "{some} {quick}");
}

/// A lit wall before something bright: a ray may end early only where nothing behind asks for its depth.
fn lit_wall(behind: &str) -> Scene {
    parse(&format!(
        "{VIEW}{LINE_BAND}[field.wall]\nkind = \"box\"\nlow = \"-1 -1 0 pc\"\nhigh = \"1 1 1 pc\"\n\
         [field.lamp]\nkind = \"box\"\nlow = \"-1 -1 -2 pc\"\nhigh = \"1 1 -1 pc\"\n\
         [dust]\ndensity = \"wall\"\nscale = \"20 /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0.6\n\
         [[star]]\nkind = \"blackbody\"\nposition = \"0.4 0.3 1.5 pc\"\ntemperature = \"10000 K\"\nspectral_luminosity = \"1e26 W/nm\"\nvisible = false\n\
         {behind}[method]\nbake = 64\n"
    ))
}

#[test]
fn a_wall_hides_no_more_than_it_swallows() {
    let behind = [
        "[background]\nkind = \"power_law\"\nexponent = 0\nradiance = \"RADIANCE W/m2/sr/nm\"\n",
        "[[emission]]\nkind = \"lines\"\ndensity = \"lamp\"\nscale = \"RADIANCE W/m2/sr/pc\"\nlines = [{ wavelength = \"550 nm\", strength = 2 }]\n",
    ];
    let dark = on_reference(&lit_wall("")).at(0, 0, 0);
    for behind in behind {
        // As bright behind the wall as the wall itself: half of the pixel.
        let radiance = 0.5 * dark * 20f64.exp();
        let scene = lit_wall(&behind.replace("RADIANCE", &format!("{radiance:e}")));
        let (cpu, truth) = (on_cpu(&scene).at(0, 0, 0), on_reference(&scene).at(0, 0, 0));
        assert!((truth / dark - 2.0).abs() < 0.02, "{truth} {dark}");
        // A depth of 20 that is right to 1e-3 leaves 2 % of doubt; a ray that ended early here was measured 900 times
        // too bright.
        assert!((cpu / truth - 1.0).abs() < 20.0 * 1e-3, "{behind}: {cpu} {truth}");
    }
}

/// A box of dust, uniform, so that the back ends differ by nothing but their own errors.
fn lit_box(camera: &str, dust: &str, star: &str, method: &str) -> Scene {
    parse(&format!(
        "[camera]\nkind = \"perspective\"\n{camera}\nup = [0, 1, 0]\nsize = [9, 9]\n\
         [field.rho]\nkind = \"box\"\nlow = \"-1 -1 -1 pc\"\nhigh = \"1 1 1 pc\"\n\
         [dust]\ndensity = \"rho\"\nlaw = \"inverse_wavelength\"\nalbedo = 0.5\n{dust}\n\
         [[star]]\nkind = \"blackbody\"\nposition = \"{star}\"\ntemperature = \"6000 K\"\nspectral_luminosity = \"1e30 W/nm\"\nvisible = false\n\
         [[band]]\nname = \"v\"\nkind = \"cos2\"\ncentre = \"550 nm\"\nhalf_width = \"70 nm\"\n[method]\nbake = 16\n{method}\n"
    ))
}

/// What once was wrong by a percent and more, beside the reference: light that comes in obliquely through a face
/// (1.3e-2), a star so deep that little is left of its light (6.7e-3), phase functions with a peak, backwards (1.7e-2)
/// and from beside the star (8e-2), and all of it with a fixed number of samples.
#[test]
fn hard_places_are_as_true_as_others() {
    let outside = "position = \"-3 -1.5 -2 pc\"\ntarget = \"0.1 -0.2 0.1 pc\"\nfield_of_view = \"45 deg\"";
    let inside = "position = \"0.3 0.1 0.25 pc\"\ntarget = \"-0.3 0.2 -1 pc\"\nfield_of_view = \"120 deg\"";
    let dust = |scale: f64, g: f64| format!("scale = \"{scale} /pc\"\nphase = {{ kind = \"henyey_greenstein\", g = {g} }}");
    let scenes = [
        ("a lit face", lit_box(outside, &dust(5.0, 0.3), "4 2 -3 pc", "")),
        ("a deep star", lit_box(outside, &dust(20.0, 0.0), "0.3 0.2 -0.4 pc", "")),
        ("a peak backwards", lit_box(outside, &dust(1.0, -0.95), "0.3 0.2 -0.4 pc", "")),
        ("beside a star", lit_box(inside, &dust(4.0, 0.85), "0.31 0.1 0.2 pc", "")),
        ("fixed samples", lit_box(outside, &dust(5.0, 0.3), "4 2 -3 pc", "steps = 200")),
    ];
    for (name, scene) in &scenes {
        let error = on_cpu(scene).relative_rmse(0, &on_reference(scene), 0);
        assert!(error < 3e-3, "{name}: {error:e}");
    }
    // Another phase function is another picture: the comparison can fail.
    let other = lit_box(outside, &dust(5.0, 0.4), "4 2 -3 pc", "");
    assert!(on_cpu(&scenes[0].1).relative_rmse(0, &on_reference(&other), 0) > 1e-2);
}
