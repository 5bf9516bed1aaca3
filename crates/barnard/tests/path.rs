//! The referee against what is known: `reference` for one bounce, energy, Chandrasekhar's half space.

use barnard::backend::path;
use barnard::control::Control;
use barnard::image::Image;
use barnard::memory::DEFAULT_LIMIT;
use barnard::scene::{MANY_BOUNCES, Scene};
use spectra::constants::PARSEC;
use spectra::quadrature::gauss_legendre;

fn parse(text: &str) -> Scene {
    barnard_files::parse("path.toml", "path", text.to_owned(), &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap()
}

/// Copy of the scene with the given number of bounces.
fn bouncing(scene: &Scene, bounces: usize) -> Scene {
    scene.edited(|spec| spec.method.bounces = bounces).unwrap()
}

fn film(scene: &Scene, bounces: usize, samples: u64) -> path::Film {
    let scene = &bouncing(scene, bounces);
    let options = path::Options::default().with_samples(samples);
    let mut film = path::Film::default();
    path::trace(scene, &options, &mut film, &Control::default(), &mut |_| ()).unwrap();
    assert_eq!(film.bad, 0);
    film
}

/// ((mean − truth)/standard error)² of all pixels of one band.
fn squares<'a>(film: &'a path::Film, truth: &'a Image, band: usize) -> impl Iterator<Item = f64> + 'a {
    let size = truth.width * truth.height;
    let estimates = film.estimates[band * size..(band + 1) * size].iter();
    estimates.zip(truth.band(band)).map(|(e, t)| if e.mean == t { 0.0 } else { ((e.mean - t) / e.error()).powi(2) })
}

/// Deviation of a χ² with `freedom` degrees of freedom from its mean, in standard deviations (Wilson & Hilferty 1931).
fn deviations(chi_squared: f64, freedom: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom);
    ((chi_squared / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
}

/// A cloud with a star in it and one beside it, gas with lines and a continuum, and a background.
fn everything(g: f64) -> String {
    format!(
        r#"
bands = "johnson"
[camera]
kind = "perspective"
position = "0 0 5 pc"
field_of_view = "24 deg"
size = [9, 7]
[field.cloud]
kind = "shell"
radius = "0.6 pc"
thickness = "0.12 pc"
[field.gas]
kind = "plummer"
core = "0.4 pc"
cut = "1 pc"
centre = "0.3 0 0 pc"
[dust]
density = "cloud"
scale = "3 mag/pc"
law = "ccm89"
albedo = 0.7
phase = {{ kind = "henyey_greenstein", g = {g} }}
[[star]]
kind = "blackbody"
position = "0.43 0.21 0.2 pc"
temperature = "20000 K"
luminosity = "1000 Lsun"
visible = false
[[star]]
kind = "blackbody"
position = "-0.8 0.9 0.6 pc"
temperature = "4000 K"
luminosity = "3000 Lsun"
visible = false
[[emission]]
kind = "lines"
density = "gas"
scale = "2e-24 W/m3/sr"
lines = [{{ wavelength = "656.28 nm", strength = 1 }}, {{ wavelength = "500.7 nm", strength = 0.6 }}]
[background]
kind = "power_law"
exponent = 1
radiance = "2e-9 W/m2/sr/nm"
[method]
bake = 32
"#
    )
}

/// With one bounce the referee's picture is that of `reference`: no pixel further off than chance brings it, nor the
/// mean of a band; and the other sign of the phase function is seen.
#[test]
fn one_bounce_is_the_reference() {
    let scene = parse(&everything(0.5));
    let truth = barnard::render_reference(&scene, 1e-3, &Control::default()).unwrap();
    let wrong = barnard::render_reference(&parse(&everything(-0.5)), 1e-3, &Control::default()).unwrap();
    let film = film(&scene, 1, 1500);
    let pixels = (truth.width * truth.height) as f64;
    for band in 0..3 {
        let chi: f64 = squares(&film, &truth, band).sum();
        let worst = squares(&film, &truth, band).fold(0.0, f64::max).sqrt();
        println!(
            "band {band}: {:.2} deviations, worst pixel {worst:.2}, error {:.4}",
            deviations(chi, pixels),
            film.relative_error(band, 3)
        );
        assert!(deviations(chi, pixels) < 3.0 && worst < 5.0, "band {band}: {} deviations, worst pixel {worst}", deviations(chi, pixels));
        // Errors that are twice too large would be seen as well.
        assert!(deviations(chi, pixels) > -3.0, "band {band}: {}", deviations(chi, pixels));
        assert!(film.relative_error(band, 3) < 0.04);
        let backward: f64 = squares(&film, &wrong, band).sum();
        assert!(deviations(backward, pixels) > 20.0, "band {band}: {}", deviations(backward, pixels));
    }
}

/// A band of 300 nm, over which extinction, albedo and phase function all change, brings through several scatterings
/// what twelve of 25 nm bring together: the weights of wavelengths that are carried together are right. Dust of one
/// albedo and phase function is seen to be other dust.
#[test]
fn wide_bands_are_the_sum_of_narrow_ones() {
    let top_hat = |centre: f64, width: f64| {
        format!(
            r#"[[band]]
name = "{centre}"
kind = "top_hat"
centre = "{centre} nm"
width = "{width} nm"
counting = "energy"
"#
        )
    };
    let scene = |bands: &str, optics: &str| {
        parse(&format!(
            r#"[camera]
kind = "perspective"
position = "0 0 5 pc"
field_of_view = "20 deg"
size = [4, 4]
[field.ball]
kind = "sphere"
radius = "1 pc"
[dust]
density = "ball"
scale = "2 /pc"
law = "draine03_rv31"
{optics}
[[star]]
kind = "blackbody"
position = "0.4 0.5 1.2 pc"
temperature = "9000 K"
luminosity = "10 Lsun"
visible = false
{bands}"#
        ))
    };
    // Light of all pixels, and its standard error, of bands from `first` on.
    let light = |film: &path::Film, bands: std::ops::Range<usize>| {
        let estimates = bands.flat_map(|b| &film.estimates[16 * b..16 * (b + 1)]);
        estimates.fold((0.0, 0.0), |(sum, error), e| (sum + e.mean, f64::hypot(error, e.error())))
    };
    let spectral = "phase = { kind = \"henyey_greenstein\" }";
    let narrow: String = (0..12).map(|i| top_hat(412.5 + 25.0 * f64::from(i), 25.0)).collect();
    let narrow = light(&film(&scene(&narrow, spectral), MANY_BOUNCES, 1000), 0..12);
    let wide = |optics: &str| light(&film(&scene(&top_hat(550.0, 300.0), optics), MANY_BOUNCES, 6000), 0..1);
    let deviations = |(sum, error): (f64, f64)| (sum - narrow.0) / error.hypot(narrow.1);
    let dispersed = deviations(wide(spectral));
    assert!(dispersed.abs() < 3.5 && narrow.1 < 0.01 * narrow.0, "{dispersed} deviations, error {}", narrow.1 / narrow.0);
    let grey = deviations(wide("albedo = 0.55\nphase = { kind = \"henyey_greenstein\", g = 0.3 }"));
    assert!(grey.abs() > 5.0, "{grey}");
}

/// In a furnace nothing is seen: with an albedo of one and the same light from everywhere, every ray brings that light,
/// whatever stands in its way.
#[test]
fn white_dust_cannot_be_seen_in_a_furnace() {
    let scene = parse(
        r#"
bands = ["johnson-V"]
[camera]
kind = "perspective"
position = "0 0 5 pc"
field_of_view = "20 deg"
size = [4, 4]
[field.cloud]
kind = "fbm"
radius = "1 pc"
[dust]
density = "cloud"
scale = "20 mag/pc"
law = "ccm89"
albedo = 1
phase = { kind = "draine", g = 0.6, alpha = 1 }
[background]
kind = "power_law"
exponent = 0
radiance = "1e-9 W/m2/sr/nm"
"#,
    );
    let expected = 1e-6 * scene.bands[0].integrate(|_| 1.0);
    let film = film(&scene, MANY_BOUNCES, 200);
    for estimate in &film.estimates {
        assert!((estimate.mean / expected - 1.0).abs() < 5.0 * estimate.error() / expected + 1e-3, "{} {expected}", estimate.mean);
        assert!(estimate.error() < 0.02 * expected, "{}", estimate.error() / expected);
    }
    // One bounce brings less: what scatters more often is missing.
    let once = self::film(&scene, 1, 200);
    assert!(once.estimates[5].mean < 0.9 * expected);
}

/// A white shell around a star sends out what the star puts in: over the whole disc, I = L/4π (1 − e^(−τ)) is what is
/// left beside the star itself.
#[test]
fn white_dust_keeps_no_light() {
    let text = |albedo: f64| {
        format!(
            r#"
[[band]]
name = "b"
kind = "top_hat"
centre = "550 nm"
width = "2 nm"
[camera]
kind = "orthographic"
position = "0 0 5 pc"
width = "2 pc"
size = [10, 10]
supersampling = 4
[field.ball]
kind = "shell"
radius = "0.65 pc"
thickness = "0.07 pc"
[dust]
density = "ball"
scale = "17.0975 /pc"
law = "inverse_wavelength"
albedo = {albedo}
phase = {{ kind = "henyey_greenstein", g = 0.4 }}
[[star]]
kind = "power_law"
exponent = 0
position = "0 0 0 pc"
spectral_luminosity = "1e30 W/nm"
visible = false
"#
        )
    };
    let intensity = |scene: &Scene| {
        let film = film(scene, MANY_BOUNCES, 1600);
        let area = (0.2 * PARSEC).powi(2);
        let error = film.estimates.iter().map(|e| e.error().powi(2)).sum::<f64>().sqrt();
        (area * film.estimates.iter().map(|e| e.mean).sum::<f64>(), area * error)
    };
    // τ = 17.0975 · 0.07 √(2π) = 3.
    let expected = 2.0 * 1e30 / (4.0 * std::f64::consts::PI) * -(-3.0f64).exp_m1();
    let (white, error) = intensity(&parse(&text(1.0)));
    // The rays of a pixel stand in rows of four; the disc's rim is cut by them to half a percent.
    assert!((white - expected).abs() < 3.0 * error + 0.005 * expected && error < 0.01 * expected, "{white:e} ± {error:e}, {expected:e}");
    let (grey, _) = intensity(&parse(&text(0.9)));
    assert!(grey < 0.9 * expected, "{grey:e}");
}

/// H(μ) of isotropic scattering with albedo ω: 1/H = √(1 − ω) + ω/2 ∫₀¹ μ' H(μ')/(μ + μ') dμ' (Chandrasekhar 1960,
/// Radiative Transfer, §39).
fn chandrasekhar_h(albedo: f64) -> impl Fn(f64) -> f64 {
    let nodes: Vec<(f64, f64)> = gauss_legendre(40).iter().map(|(x, w)| (0.5 * (x + 1.0), 0.5 * w)).collect();
    let mut h = vec![1.0; nodes.len()];
    let at = move |mu: f64, nodes: &[(f64, f64)], h: &[f64]| {
        let sum: f64 = nodes.iter().zip(h).map(|((x, w), h)| w * x * h / (mu + x)).sum();
        1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * sum)
    };
    for _ in 0..400 {
        // By halves: without absorption it swings.
        h = nodes.iter().zip(&h).map(|((mu, _), old)| 0.5 * (old + at(*mu, &nodes, &h))).collect();
    }
    move |mu| at(mu, &nodes, &h)
}

/// Diffuse reflection of a half space: I = ω/4π · E μ₀/(μ + μ₀) H(μ) H(μ₀) with E the irradiance across the
/// beam.
#[test]
fn a_half_space_reflects_as_chandrasekhar_says() {
    // His table XI: H(1) = 2.9078 without absorption.
    assert!((chandrasekhar_h(1.0)(1.0) - 2.9078).abs() < 2e-3, "{}", chandrasekhar_h(1.0)(1.0));
    let (albedo, sun) = (0.9, 0.6f64);
    let h = chandrasekhar_h(albedo);
    let distance = 4e4;
    let far = (sun * distance, (1.0 - sun * sun).sqrt() * distance);
    for view in [0.9f64, 0.3] {
        let (z, y) = (100.0 * view, 100.0 * (1.0 - view * view).sqrt());
        let scene = parse(&format!(
            r#"
[[band]]
name = "b"
kind = "top_hat"
centre = "550 nm"
width = "2 nm"
[camera]
kind = "orthographic"
position = "0 {y} {z} pc"
up = [1, 0, 0]
width = "0.001 pc"
size = [1, 1]
[field.ground]
kind = "box"
low = "-60 -60 -40 pc"
high = "60 60 0 pc"
[dust]
density = "ground"
scale = "1 /pc"
law = "inverse_wavelength"
albedo = {albedo}
[[star]]
kind = "power_law"
exponent = 0
position = "{x} 0 {up} pc"
spectral_luminosity = "1e36 W/nm"
visible = false
"#,
            x = far.1,
            up = far.0,
        ));
        let irradiance = 2.0 * 1e36 / (4.0 * std::f64::consts::PI * (distance * PARSEC).powi(2));
        let expected = albedo / (4.0 * std::f64::consts::PI) * irradiance * sun / (view + sun) * h(view) * h(sun);
        let estimate = film(&scene, MANY_BOUNCES, 100_000).estimates[0];
        println!("{view}: {} ± {} of the table", estimate.mean / expected, estimate.error() / expected);
        assert!((estimate.mean - expected).abs() < 3.0 * estimate.error() + 2e-3 * expected, "{view}: {estimate:?} {expected:e}");
        assert!(estimate.error() < 0.004 * expected);
        // Without H, which is single scattering, it would be less than half.
        assert!(estimate.mean > 1.5 * expected / (h(view) * h(sun)));
    }
}

/// Numbers do not depend on the number of threads, in one go and in two; another seed brings others.
#[test]
fn pictures_depend_on_their_seed_alone() {
    let scene = bouncing(&parse(&everything(0.5)), 3);
    let run = |threads: usize, samples: &[u64], seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut film = path::Film::default();
        for samples in samples {
            let options = path::Options::default().with_samples(*samples).with_seed(seed);
            pool.install(|| path::trace(&scene, &options, &mut film, &Control::default(), &mut |_| ()).unwrap());
        }
        film
    };
    let one = run(1, &[16], 1);
    assert!(one == run(3, &[16], 1) && one == run(2, &[8, 16], 1));
    assert!(one.estimates != run(1, &[16], 2).estimates);
}

/// Interrupted work keeps the passes that were finished; a target ends it early.
#[test]
fn work_is_kept_and_ended() {
    let scene = parse(&everything(0.5));
    let control = Control::default();
    let mut film = path::Film::default();
    let options = path::Options::default().with_samples(64);
    let stopped = path::trace(&scene, &options, &mut film, &control, &mut |f| {
        if f.samples >= 16 {
            control.interrupt();
        }
    });
    assert!(matches!(stopped, Err(barnard::Error::Interrupted)) && film.samples == 16);
    let options = path::Options::default().with_samples(100_000).with_target_error(Some(0.2));
    path::trace(&scene, &options, &mut film, &Control::default(), &mut |_| ()).unwrap();
    let worst = (0..3).map(|b| film.relative_error(b, 3)).fold(0.0, f64::max);
    assert!(worst <= 0.2 && film.samples < 100_000, "{worst} {}", film.samples);
}
