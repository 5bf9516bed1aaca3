//! Layers: their sum is the picture, each is the light of its own source, and distances and depths are those of geometry.

use std::sync::Arc;

use barnard::backend::{Backend, Job, Renderer, cpu::Cpu, path::PathTracer, reference::Reference};
use barnard::camera::{Arrangement, Stereo};
use barnard::composite::{mean, parted};
use barnard::field::{Plummer, Shell, Slab};
use barnard::glam::{DVec3, dvec3};
use barnard::image::{FAR_AWAY, Image, Layer, LayerChoice, LayerContent, relative_rms};
use barnard::phase::HenyeyGreenstein;
use barnard::scene::{Background, Dust, Emission, Scale, Scene, SceneSpec, Star, StarField};
use barnard::spectra::extinction::Extinction;
use barnard::spectra::sed::PowerLaw;
use barnard::spectra::spectrum::{Line, Spectrum};
use barnard::spectra::units::{Luminosity, Temperature, Wavelength};
use barnard::{Camera, Control, Options};

const ALL: LayerChoice = LayerChoice { light: true, depth: true, tau: true };

/// Dust around a star, two kinds of gas, a background and field stars: every part of light.
fn scene() -> Scene {
    let cloud = Plummer::new(dvec3(-0.1, 0.2, 0.0), 0.5).unwrap();
    let dust = Dust::new(cloud, Extinction::by_name("gordon23").unwrap(), Scale::mag_per_pc(1.5)).with_albedo(0.6);
    let star = Star::blackbody(Temperature(12_000.0), Luminosity::suns(900.0)).with_position(dvec3(0.2, 0.1, 0.3));
    let camera = Camera::look_at(dvec3(0.0, 0.5, 5.0), DVec3::ZERO).with_field_of_view_deg(30.0).with_size(24, 18);
    let glow = |lambda_um, strength| Spectrum::of_lines(vec![Line { lambda_um, strength }]);
    let ball = Plummer::new(DVec3::ZERO, 0.3).unwrap();
    let field = StarField { density_per_sr: 3e4, ..StarField::default() };
    let sky = even_light(1e-7);
    let scene = SceneSpec::new(camera)
        .with_dust(dust.with_phase(HenyeyGreenstein::new(0.5).unwrap()))
        .with_star(star)
        .with_emission(Emission::new(ball.clone(), glow(0.6563, 1e-22)).with_name("H alpha"))
        .with_emission(Emission::new(ball, glow(0.5007, 2e-23)).with_name("[O III]"))
        .with_background(Background { star_field: Some(field), spectrum: Some(sky), ..Background::default() });
    scene.build().unwrap().with_layers(ALL)
}

/// Constant over all wavelengths [W m⁻² sr⁻¹ µm⁻¹].
fn even_light(level: f64) -> Spectrum {
    Spectrum::continuous(level, Arc::new(PowerLaw { reference: Wavelength(0.55), exponent: 0.0 }))
}

fn render(backend: &mut dyn Backend, scene: &Scene) -> Image {
    Renderer::new(backend).render(Job::new(scene, &Options::default()).unwrap(), &Control::default()).unwrap().0
}

fn layer<'a>(image: &'a Image, name: &str) -> &'a Layer {
    image.layers.iter().find(|layer| layer.name == name).unwrap_or_else(|| panic!("no layer {name}"))
}

fn values(layer: &Layer) -> impl Iterator<Item = f64> + '_ {
    (0..layer.samples.len()).map(|i| layer.samples.at(i))
}

/// The layers of light add up to the picture, and that to what is rendered without layers; each of them matters.
fn add_up(backend: &mut dyn Backend, scene: &Scene, tolerance: f64) -> Image {
    let (layered, plain) = (render(backend, scene), render(backend, &scene.clone().with_layers(LayerChoice::default())));
    assert!(plain.layers.is_empty());
    let light: Vec<&Layer> = layered.layers.iter().filter(|layer| layer.content == LayerContent::Light).collect();
    let names: Vec<&str> = light.iter().map(|layer| layer.name.as_str()).collect();
    assert_eq!(names, ["scattered", "emission.H_alpha", "emission._O_III_", "background", "stars"]);
    let count = layered.samples.len();
    let sum = |without: Option<usize>| -> Vec<f64> {
        let counted = || light.iter().enumerate().filter(|(i, _)| Some(*i) != without);
        (0..count).map(|i| counted().map(|(_, layer)| layer.samples.at(i)).sum()).collect()
    };
    let off = |sum: Vec<f64>, image: &Image| relative_rms(sum.into_iter().zip((0..count).map(|i| image.samples.at(i))));
    assert!(off(sum(None), &layered) < 1e-6, "{}", off(sum(None), &layered));
    assert!(off(sum(None), &plain) < tolerance, "{}", off(sum(None), &plain));
    for (i, name) in names.iter().enumerate() {
        assert!(off(sum(Some(i)), &plain) > 10.0 * tolerance, "{name} sends nothing");
    }
    layered
}

#[test]
fn layers_add_up_to_the_picture() {
    let layered = add_up(&mut Cpu, &scene(), 1e-5);
    // The same part by the reference, which renders a scene that has no other light.
    let truth = render(&mut Reference { accuracy: 1e-4 }, &scene().with_layers(LayerChoice { light: true, ..LayerChoice::default() }));
    for name in ["scattered", "emission.H_alpha", "background", "stars"] {
        let off = relative_rms(values(layer(&layered, name)).zip(values(layer(&truth, name))));
        assert!(off < 5e-3, "{name}: {off}");
    }
}

/// The reference adds up too; light that scatters again is scattered light; wavelengths that bands share are no matter.
#[test]
#[ignore = "long"]
fn every_way_adds_up() {
    let small = scene();
    let small = small.clone().with_camera(small.camera.clone().with_size(3, 2));
    add_up(&mut Reference { accuracy: 1e-4 }, &small, 1e-4);
    let many = scene().edited(|spec| spec.method.bounces = 1000).unwrap();
    add_up(&mut Cpu, &many, 1e-5);
    for name in ["propagation", "preintegrated"] {
        let other = scene();
        let other = other.clone().with_method(other.method.clone().with_name(name).unwrap());
        add_up(&mut Cpu, &other, 1e-4);
    }
}

/// A sheet of gas in even dust: how far it is, and τ up to the end of the dust.
#[test]
fn distances_are_those_of_geometry() {
    let sheet = |z: f64, thickness: f64| Slab::new(dvec3(0.0, 0.0, z), DVec3::Z, thickness, 2.0).unwrap();
    let (dust, gas) = (sheet(0.0, 2.0), sheet(-0.25, 0.25));
    let camera = Camera::look_at(dvec3(0.0, 0.0, 10.0), DVec3::ZERO).with_field_of_view_deg(5.0).with_size(16, 12);
    let glow = Spectrum::of_lines(vec![Line { lambda_um: 0.55, strength: 1e-23 }]);
    let scene = SceneSpec::new(camera)
        .with_dust(Dust::new(dust, Extinction::by_name("gordon23").unwrap(), Scale::mag_per_pc(2.0)).with_albedo(0.0))
        .with_emission(Emission::new(gas, glow))
        .with_background(Background::even(even_light(1e-5)));
    let image = render(&mut Cpu, &scene.build().unwrap().with_layers(LayerChoice { depth: true, tau: true, light: false }));
    let pixels = 16 * 12;
    let (depth, tau) = (layer(&image, "depth"), layer(&image, "tau"));
    // From z = 10 to the middle of the gas, less the little that its own dust does; 4 mag through all of the dust.
    let wanted = 4.0 * std::f64::consts::LN_10 / 2.5;
    for (i, (depth, tau)) in depth.channel(0, pixels).zip(tau.channel(0, pixels)).enumerate() {
        let slant = 1.0 / image_cosine(i);
        assert!((depth / (10.25 * slant) - 1.0).abs() < 2e-3, "{depth}");
        assert!((tau / (wanted * slant) - 1.0).abs() < 2e-3, "{tau}");
    }
    let opacity: Vec<f64> = tau.channel(1, pixels).collect();
    assert!(opacity.iter().all(|v| (v - (1.0 - (-wanted).exp())).abs() < 1e-3));
    // Depths are of the light itself: what is dark has none.
    let dark = render(&mut Cpu, &scene_without_gas().with_layers(LayerChoice { depth: true, ..LayerChoice::default() }));
    assert!(layer(&dark, "depth").channel(0, pixels).all(|v| v == FAR_AWAY));
}

/// The cosine between the axis and the ray of a pixel of 16 × 12, 5° wide.
fn image_cosine(i: usize) -> f64 {
    let half = 2.5f64.to_radians().tan();
    let place = |at: usize, count: f64| (2.0 * (at as f64 + 0.5) - count) / 16.0 * half;
    let (x, y) = (place(i % 16, 16.0), place(i / 16, 12.0));
    1.0 / (1.0 + x * x + y * y).sqrt()
}

fn scene_without_gas() -> Scene {
    let camera = Camera::look_at(dvec3(0.0, 0.0, 10.0), DVec3::ZERO).with_field_of_view_deg(5.0).with_size(16, 12);
    let shell = Shell::new(DVec3::ZERO, 0.8, 0.1).unwrap();
    SceneSpec::new(camera)
        .with_dust(Dust::new(shell, Extinction::by_name("gordon23").unwrap(), Scale::mag_per_pc(2.0)).with_albedo(0.0))
        .build()
        .unwrap()
}

/// Both eyes and moments have layers of their own; a path tracer has none of light, and says so.
#[test]
#[ignore = "long"]
fn layers_go_where_pictures_go() {
    let camera = scene().camera.clone().with_size(20, 14);
    let mono = render(&mut Cpu, &scene().with_camera(camera.clone()));
    let stereo = scene().with_camera(camera.with_stereo(Stereo { arrangement: Arrangement::SideBySide, ..Stereo::new(0.05, 5.0) }));
    let both = render(&mut Cpu, &stereo);
    let [left, right] = parted(Arrangement::SideBySide, &both, &stereo.camera);
    for (whole, part) in both.layers.iter().zip(&left.layers) {
        assert_eq!((whole.samples.len(), &whole.name), (2 * part.samples.len(), &part.name));
    }
    let off = |a: &Image, b: &Image| relative_rms(values(layer(a, "scattered")).zip(values(layer(b, "scattered"))));
    assert!(off(&left, &right) > 1e-3 && off(&left, &mono) < 0.3, "{} {}", off(&left, &right), off(&left, &mono));
    let moments = mean([Ok::<_, barnard::Error>(left.clone()), Ok(right.clone())]).unwrap().unwrap();
    let between = layer(&moments, "depth").samples.at(5);
    assert!((between / (0.5 * (layer(&left, "depth").samples.at(5) + layer(&right, "depth").samples.at(5))) - 1.0).abs() < 1e-6);
    let options = Options::default();
    let job = Job::new(scene(), &options).unwrap();
    let refused = Renderer::new(&mut PathTracer::default()).render(job, &Control::default()).unwrap_err();
    assert!(refused.to_string().contains("cpu, gpu or reference"), "{refused}");
}
