//! Every method beside the reference: it keeps to what it states of itself.

use crate::common::rendered::{on_reference, parse};
use barnard::backend::{Renderer, cpu};
use barnard::control::Control;
use barnard::plan::{Options, Plan, Planner, Quality};
use barnard::scene::Scene;
use spectra::passband::{Counting, Passband, Window, window};
use spectra::units::Wavelength;

/// A cloud with stars around it, rendered by `propagation`.
fn cloud_with_stars(stars: usize, phase: &str) -> Scene {
    let place = |i: usize| {
        let turn = 2.4 * i as f64;
        format!("{:.3} {:.3} {:.3} pc", 1.3 * turn.cos(), 1.3 * turn.sin(), 0.4 * turn.sin())
    };
    let star = |i: usize| {
        let temperature = 3000 + 4000 * i;
        format!(
            r#"[[star]]
kind = "blackbody"
position = "{}"
temperature = "{temperature} K"
luminosity = "100 Lsun"
visible = false
"#,
            place(i)
        )
    };
    parse(&format!(
        r#"bands = ["johnson-V"]
[camera]
kind = "perspective"
position = "0 0 4 pc"
field_of_view = "16 deg"
size = [8, 8]
[field.cloud]
kind = "fbm"
seed = 4
scale = "0.4 pc"
offset = 0.2
[dust]
density = "cloud"
scale = "3 /pc"
law = "ccm89"
albedo = 0.6
{phase}
[method]
name = "propagation"
bake = 48
accuracy = 5e-3
{}"#,
        (0..stars).map(star).collect::<String>()
    ))
}

/// Gathered light of any number of stars is that of the reference within the stated error; a star less is noticed.
#[test]
fn gathered_light_is_that_of_all_stars() {
    for stars in [1, 5] {
        let scene = cloud_with_stars(stars, "");
        let options = Options::default();
        let scene = barnard::plan::sample_functions(&scene, &options).unwrap();
        let plan = Planner::new(&options).plan(&scene, None, &Control::default()).unwrap();
        let image = Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap().0;
        let error = image.relative_rmse(0, &on_reference(&scene), 0);
        let stated = plan.space().spatial.unwrap().error;
        assert!(error < 1.1 * stated + 1e-5 && stated < 1e-2, "{stars} stars: {error:e}, stated {stated:e}");
        // A star less would be seen.
        if stars > 1 {
            let fewer = scene.edited(|spec| spec.stars.truncate(stars - 1)).unwrap();
            assert!(image.relative_rmse(0, &on_reference(&fewer), 0) > 5.0 * stated);
        }
    }
}

/// `propagation` scatters isotropically: a plan with another phase function misses its accuracy and says so.
#[test]
fn forward_scattering_misses_the_accuracy_of_propagation() {
    let forward = cloud_with_stars(2, "phase = { kind = \"henyey_greenstein\", g = 0.6 }");
    let plan = Planner::new(&Options::default()).plan(&forward, None, &Control::default()).unwrap();
    assert!(plan.expected_report().words().iter().any(|(_, words)| words.contains("isotropic")));
    assert!(plan.expected_report().misses_accuracy(), "the phase function is a part of the error");
}

/// One basis cannot be made for each of two passbands.
#[test]
fn a_basis_per_filter_is_refused_for_two_passbands() {
    let two = cloud_with_stars(2, "").edited(|spec| spec.method.settings.criterion = spectra::basis::Criterion::Filter).unwrap();
    assert!(Planner::new(&Options::default()).with_quality(Quality::Fixed(20)).plan(&two, None, &Control::default()).is_ok());
    let bands: Vec<Passband> = two.bands.iter().cloned().chain(Passband::by_name("johnson-B")).collect();
    let refused = Planner::new(&Options::default())
        .with_quality(Quality::Fixed(20))
        .plan(two.edited(|spec| *spec = spec.clone().with_bands(bands)).unwrap(), None, &Control::default())
        .unwrap_err()
        .to_string();
    assert!(refused.contains("one basis") && refused.contains("largest"), "{refused}");
}

/// Bands without colours in the palette are refused before planning.
#[test]
fn bands_without_colours_are_refused() {
    let two = cloud_with_stars(2, "");
    let bands: Vec<Passband> = two.bands.iter().cloned().chain(Passband::by_name("johnson-B")).collect();
    let refused = two.edited(|spec| spec.bands = bands).unwrap_err().to_string();
    assert!(refused.contains("palette has colours for 1 bands, the scene has 2"), "{refused}");
}

/// Spectra are fitted wherever light passes, even if the basis was made for a narrower range.
#[test]
fn spectra_are_fitted_beyond_a_narrow_basis() {
    let narrow = cloud_with_stars(2, "").edited(|spec| {
        (spec.method.settings.domain_um, spec.method.settings.degree) = (Some((0.54, 0.56)), 12);
    });
    let narrow = narrow.unwrap();
    let plan = Planner::new(&Options::default()).with_quality(Quality::Fixed(20)).plan(&narrow, None, &Control::default()).unwrap();
    let field = plan.light_field().unwrap();
    let worst = field.certify(0, &plan.spectral().bands[0].sources, 1.0).iter().map(|(_, c)| c.absolute).fold(0.0, f64::max);
    assert!(worst < 0.02, "{worst:e}");
}

/// Every method of the catalogue on random clouds, to what it states of itself: the spatial error, and the spectral one
/// as a part of the light without dust, of which these thin clouds leave an eighth or more.
#[test]
fn every_method_keeps_to_what_it_states() {
    for seed in [3, 11] {
        let text = |temperature: u32| {
            format!(
                r#"bands = ["johnson-V"]
[camera]
kind = "perspective"
position = "0 0 4 pc"
field_of_view = "16 deg"
size = [6, 6]
[field.cloud]
kind = "fbm"
seed = {seed}
scale = "0.5 pc"
offset = 0.2
[dust]
density = "cloud"
scale = "0.8 /pc"
law = "inverse_wavelength"
albedo = 0.6
[[star]]
kind = "blackbody"
position = "0.9 1.1 {} pc"
temperature = "{temperature} K"
radius = "5 Rsun"
visible = false
[method]
bake = 24
"#,
                0.1 * f64::from(seed)
            )
        };
        let scene = parse(&text(9000));
        let scene = barnard::plan::sample_functions(&scene, &Options::default()).unwrap();
        let hotter = barnard::plan::sample_functions(&parse(&text(9900)), &Options::default()).unwrap();
        let (truth, other) = (on_reference(&scene), on_reference(&hotter));
        for entry in barnard::scene::methods() {
            let scene = scene.clone().with_method(scene.method.clone().with_name(entry.name).unwrap());
            let options = Options::default();
            let plan = Planner::new(&options).plan(&scene, None, &Control::default()).unwrap();
            let image = Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap().0;
            assert!(plan.spectral().depth < 3.0, "a thin cloud: {}", plan.spectral().depth);
            let certificates = plan.spectral().certify(0, plan.spectral().depth);
            let spectral = certificates.iter().map(|c| c.absolute).fold(0.0, f64::max);
            // Barrès & Neyret's double integration says nothing of its steps: 100 in 2 pc.
            let spatial = plan.space().spatial.map_or(5e-3, |s| s.error);
            let (error, wrong) = (image.relative_rmse(0, &truth, 0), image.relative_rmse(0, &other, 0));
            assert!(error <= 1.1 * spatial + 8.0 * spectral, "{} {seed}: {error:e} > {spatial:e}, {spectral:e}", entry.name);
            assert!(wrong > 0.05, "{}: {wrong}", entry.name);
        }
    }
}

/// Volumes in half precision take half of the memory and show the same picture to a part of the accuracy, with star
/// depths from nothing to deep and gas beside dust, whatever the units of both.
#[test]
fn halves_show_the_same() {
    let plan = |scale: f64, volumes: &str| {
        let scene = parse(&format!(
            r#"bands = ["johnson-B", "johnson-V"]
[camera]
kind = "perspective"
position = "0 0 4 pc"
field_of_view = "26 deg"
size = [24, 24]
[field.cloud]
kind = "fbm"
seed = 4
scale = "0.4 pc"
offset = 0.2
[dust]
density = "{scale} * cloud"
scale = "{} /pc"
law = "ccm89"
albedo = 0.6
[[emission]]
kind = "lines"
lines = [{{ wavelength = "550 nm", strength = 1 }}]
density = "{scale} * cloud^2"
scale = "{} W/m2/sr/pc"
[[star]]
kind = "blackbody"
position = "0.2 0.3 0.4 pc"
temperature = "20000 K"
luminosity = "900 Lsun"
visible = false
[method]
bake = 48
steps = 60
{volumes}"#,
            9.0 / scale,
            1e-6 / scale
        ));
        let plan = Planner::new(&Options::default()).plan(&scene, None, &Control::default()).unwrap();
        (Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap().0, plan)
    };
    let (single, whole) = plan(1.0, "");
    let bytes = |plan: &Plan| plan.volumes().map(|volume| volume.bytes()).sum::<u64>();
    for scale in [1e-12, 1.0, 1e12] {
        let (half, plan) = plan(scale, "volumes = \"half\"\n");
        assert_eq!(2 * bytes(&plan), bytes(&whole));
        for band in 0..2 {
            let moved = half.relative_rmse(band, &single, band);
            assert!((1e-7..2e-4).contains(&moved), "{scale:e}, band {band}: {moved:e}");
            // What the certificate adds is more than what the picture moved by.
            let absolute = |plan: &Plan| plan.certificates(band, &plan.expected()).iter().map(|(_, c)| c.absolute).fold(0.0, f64::max);
            assert!(absolute(&plan) > absolute(&whole) + moved, "{} {}", absolute(&plan), absolute(&whole));
        }
        assert!(plan.expected_report().words().iter().any(|(_, words)| words.contains("half precision")));
    }
}

/// Passbands that are many share their nodes, and show what each of them shows alone: through dust that rays end in,
/// next to a star, with gas, a background and one phase function for each wavelength, to what the certificates say.
#[test]
fn bands_that_share_nodes_are_those_alone() {
    let gas = r#"[[emission]]
kind = "lines"
lines = [{ wavelength = "502 nm", strength = 3 }, { wavelength = "655 nm", strength = 1 }]
density = "cloud^2"
scale = "1e-7 W/m2/sr/pc"
"#;
    let behind = r#"[background]
kind = "blackbody"
temperature = "4000 K"
radiance = "2.5e-8 W/m2/sr/um"
"#;
    let narrow = |i: usize| {
        let (centre, width) = (Wavelength(0.4025 + 0.005 * i as f64), Wavelength(0.005));
        window(&format!("band {i}"), Counting::Energy, Window::TopHat { centre, width }).unwrap()
    };
    let options = Options::default();
    for (name, density, beside, phase, star) in
        [("deep", 4.0, gas, "", -0.7), ("a background", 2.0, behind, "", 0.4), ("spectral", 2.0, gas, "henyey_greenstein", 0.4)]
    {
        let phase = if phase.is_empty() { String::new() } else { format!("phase = {{ kind = \"{phase}\" }}\n") };
        let scene = parse(&format!(
            r#"bands = ["johnson-V"]
[camera]
kind = "perspective"
position = "0 0 4 pc"
field_of_view = "26 deg"
size = [12, 12]
[field.cloud]
kind = "sphere"
radius = "1 pc"
[dust]
density = "cloud"
scale = "{density} /pc"
law = "draine03_rv31"
albedo = 0.6
{phase}{beside}[[star]]
kind = "blackbody"
position = "0.2 0.1 {star} pc"
temperature = "20000 K"
luminosity = "900 Lsun"
visible = false
[method]
bake = 32
"#
        ));
        let rendered = |bands: Vec<Passband>| {
            let scene = scene.edited(|spec| *spec = spec.clone().with_bands(bands)).unwrap();
            let plan = Planner::new(&options).with_quality(Quality::Fixed(60)).plan(&scene, None, &Control::default()).unwrap();
            (Renderer::new(&mut cpu::Cpu).render(&plan, &Control::default()).unwrap(), plan)
        };
        let ((many, stats), plan) = rendered((0..96).map(narrow).collect());
        assert_eq!(plan.spectral().method, "common_nodes");
        let nodes = plan.spectral().common_nodes().unwrap().len();
        assert!(nodes < 48 && plan.spectral().terms() == nodes, "{name}: {nodes}");
        for band in [0, 1, 10, 25, 60, 95] {
            let ((alone, _), single) = rendered(vec![narrow(band)]);
            assert!(single.spectral().common_nodes().is_none());
            let relative = |plan: &Plan, band: usize| plan.certificates(band, &stats).iter().map(|(_, c)| c.relative).fold(0.0, f64::max);
            let (moved, stated) = (many.relative_rmse(band, &alone, 0), relative(&plan, band));
            assert!(moved > 0.0 && moved <= stated + relative(&single, 0) && stated < 2e-3, "{name}, {band}: {moved:e}, stated {stated:e}");
            assert!(many.relative_rmse((band + 1) % 96, &alone, 0) > 2.0 * stated, "{name}: another band would be seen");
        }
    }
}
