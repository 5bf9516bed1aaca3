//! Plates against fresh renders.

use std::sync::Arc;

use barnard::backend::{Renderer, cpu};
use barnard::field::{Fbm, Field, Sphere};
use barnard::glam::{DVec3, dvec3};
use barnard::light::Route;
use barnard::phase::{Draine, HenyeyGreenstein, IntoPhase};
use barnard::plan::{Options, Planned, Planner};
use barnard::plates::Reach;
use barnard::random::Counter;
use barnard::scene::{Background, Dust, Emission, Method, Scale, Scene, SceneSpec, Star, StarField};
use barnard::spectra::extinction::Extinction;
use barnard::spectra::passband::{Counting, Passband, Window, window};
use barnard::spectra::rule::Certificate;
use barnard::spectra::sed::BlackBody;
use barnard::spectra::spectrum::{Line, Spectrum};
use barnard::spectra::units::{Luminosity, Temperature, Wavelength};
use barnard::{Camera, Control, Image, Plates};

const RANGE_UM: (f64, f64) = (0.36, 1.0);
/// Plates of that range, and of the scene's own dust.
const REACH: Reach = Reach { range_um: Some(RANGE_UM), dust: (1.0, 1.0) };

/// Differences between scenes.
struct Spectra {
    temperatures: [f64; 2],
    suns: [f64; 2],
    lines: [f64; 2],
    background: f64,
    albedo: f64,
    bands: Vec<(f64, f64, bool)>,
}

impl Spectra {
    const FIRST: fn() -> Self = || Self {
        temperatures: [9000.0, 4000.0],
        suns: [100.0, 30.0],
        lines: [1e-7, 3e-8],
        background: 1e-7,
        albedo: 0.6,
        bands: vec![(0.45, 0.08, true), (0.65, 0.06, false)],
    };

    /// The number `change` of many.
    fn random(change: u64) -> Self {
        let mut random = Counter::new(77, change);
        let mut uniform = |low: f64, high: f64| low + (high - low) * random.uniform();
        let mut band = || {
            let width = 10f64.powf(uniform(-2.5, -1.0));
            // A Gaussian reaches four widths to each side.
            let is_top_hat = uniform(0.0, 1.0) < 0.5;
            let room = if is_top_hat { 0.51 * width } else { 3.0 * width };
            (uniform(RANGE_UM.0 + room, RANGE_UM.1 - room), width, is_top_hat)
        };
        let bands = vec![band(), band()];
        let mut power = |low: f64, high: f64| 10f64.powf(uniform(low, high));
        Self {
            temperatures: [power(3.5, 4.6), power(3.5, 4.6)],
            suns: [power(0.0, 3.0), power(0.0, 3.0)],
            lines: [power(-9.0, -6.0), power(-9.0, -6.0)],
            background: power(-9.0, -6.0),
            albedo: uniform(0.05, 0.95),
            bands,
        }
    }
}

/// A cloud with two stars, one of which is seen, two species of gas, and light and stars behind.
#[derive(Clone)]
struct Cloud {
    dust: Arc<dyn Field>,
    gas: Arc<dyn Field>,
    /// Optical depth at V across a density of one in a parsec.
    per_pc: f64,
    phase: Arc<dyn barnard::phase::Phase>,
    bounces: usize,
}

impl Cloud {
    fn new(per_pc: f64, phase: impl IntoPhase, bounces: usize) -> Self {
        Self {
            dust: Arc::new(Fbm::new(3)),
            gas: Arc::new(Sphere::new(dvec3(0.2, -0.1, 0.1), 0.5).unwrap()),
            per_pc,
            phase: phase.into_phase(),
            bounces,
        }
    }

    fn scene(&self, spectra: &Spectra) -> Scene {
        let camera = Camera::look_at(dvec3(0.0, 0.3, 4.0), DVec3::ZERO).with_field_of_view_deg(30.0).with_size(12, 9);
        let law = Extinction::by_name("gordon23").unwrap();
        let dust = Dust::new(self.dust.clone(), law, Scale::per_pc(self.per_pc)).with_albedo(spectra.albedo).with_phase(self.phase.clone());
        let star = |i: usize, place: DVec3| {
            Star::blackbody(Temperature(spectra.temperatures[i]), Luminosity::suns(spectra.suns[i])).with_position(place)
        };
        let line = |lambda_um: f64, strength: f64| Line { lambda_um, strength };
        let gas =
            |i: usize, at: [f64; 2]| Emission::new(self.gas.clone(), Spectrum::of_lines(at.map(|um| line(um, spectra.lines[i])).to_vec()));
        let even = Spectrum::continuous(spectra.background, Arc::new(BlackBody(Temperature(5000.0))));
        let band = |(number, &(centre, width, is_top_hat)): (usize, &(f64, f64, bool))| {
            let (centre, width) = (Wavelength(centre), Wavelength(width));
            let shape = if is_top_hat { Window::TopHat { centre, width } } else { Window::Gaussian { centre, fwhm: width } };
            window(&format!("band {number}"), Counting::Photon, shape).unwrap()
        };
        let bands: Vec<Passband> = spectra.bands.iter().enumerate().map(band).collect();
        // Steps, samples and depths are those of the plates: what is compared is spectra.
        let method = Method {
            accuracy: 1e-4,
            bake: Some(16),
            steps_per_voxel: Some(1.5),
            star_depth_voxels: Some(1),
            bounces: self.bounces,
            ..Method::default()
        };
        let field = StarField { density_per_sr: 400.0, magnitudes: (6.0, 12.0), seed: 5 };
        SceneSpec::new(camera)
            .with_bands(bands)
            .with_dust(dust)
            .with_star(star(0, dvec3(0.1, 0.2, 0.3)))
            .with_star(star(1, dvec3(-0.4, 0.3, -0.2)).hidden())
            .with_emission(gas(0, [0.5007, 0.6563]))
            .with_emission(gas(1, [0.4861, 0.9069]))
            .with_background(Background::even(even).with_stars(field))
            .with_method(method)
            .build()
            .unwrap()
    }

    fn plates(&self) -> Plates {
        let scene = self.scene(&Spectra::FIRST());
        Plates::new(&scene, REACH, None, &Options::default(), &Control::default()).unwrap()
    }
}

/// The largest error of any pixel in parts of what both state, of the band and of the pixel itself, and the largest error in parts of the pixel.
fn compare(plates: &Plates, scene: &Scene, before: &mut Option<Planned>) -> (f64, f64) {
    let control = Control::default();
    let plan = Planner::new(&Options::default()).plan(scene, before.as_ref(), &control).unwrap();
    let (fresh, stats) = Renderer::new(&mut cpu::Cpu).render(&plan, &control).unwrap();
    let exposed = plates.expose(scene, &control).unwrap();
    let mixture = plates.mixture(scene).unwrap();
    let worst = |certificates: &[(usize, Certificate)]| certificates.iter().map(|(_, c)| c.relative).fold(0.0, f64::max);
    let lights = barnard::light::lights(scene).unwrap();
    let is_point = |(light, _): &&(usize, Certificate)| matches!(lights[*light].route, Route::Direct { .. } | Route::FieldStar { .. });
    let errors = plates.errors(&mixture);
    let (mut beyond, mut largest) = (0.0f64, 0.0f64);
    for (band, errors) in errors.chunks_exact(errors.len() / scene.bands.len()).enumerate() {
        // Where each light's error is a part of the light, that of a sum is no larger a part.
        let (of_plates, theirs) = (plates.certificates(&mixture, band), worst(&plan.certificates(band, &stats)));
        let of_points = worst(&of_plates.iter().filter(is_point).copied().collect::<Vec<_>>());
        for ((exposed, wanted), of_pixel) in exposed.band(band).zip(fresh.band(band)).zip(errors) {
            let error = (exposed - wanted).abs();
            let stated = (worst(&of_plates) + theirs) * wanted;
            // Pictures are in single precision.
            let of_pixel = f64::from(*of_pixel) + (of_points + theirs + 2e-7) * wanted;
            let either = |stated: f64| if error > 0.0 { error / stated.max(1e-300) } else { 0.0 };
            (beyond, largest) = (beyond.max(either(stated)).max(either(of_pixel)), largest.max(error / wanted.max(1e-300)));
        }
    }
    *before = Some(plan);
    (beyond, largest)
}

/// Four hundred changes of all spectra, luminosities, albedo and passbands together are within the error that is stated, which is small;
/// with a plate of another light they are not.
#[test]
#[ignore = "long"]
fn pictures_are_fresh_renders() {
    let cloud = Cloud::new(1.2, HenyeyGreenstein::new(0.6).unwrap(), 1);
    let (plates, mut plan) = (cloud.plates(), None);
    let mut worst = (0.0f64, 0.0f64);
    for change in 0..400 {
        let (beyond, largest) = compare(&plates, &cloud.scene(&Spectra::random(change)), &mut plan);
        worst = (worst.0.max(beyond), worst.1.max(largest));
        assert!(beyond <= 1.0, "change {change}: {beyond} of what is stated, {largest:e} of a pixel");
    }
    assert!(worst.1 < 2e-3 && worst.0 > 1e-3, "{worst:?}");
    let mut record = plates.record().clone();
    record.plates.iter_mut().for_each(|plate| plate.level.iter_mut().for_each(|level| *level *= 1.0 + 3e-4));
    let (beyond, _) = compare(&Plates::of(record).unwrap(), &cloud.scene(&Spectra::FIRST()), &mut plan);
    assert!(beyond > 1.0, "{beyond}");
}

/// Less dust and more, by random parts, with all spectra others too; an amount that is off by a thousandth is seen.
#[test]
fn dust_becomes_more_and_less() {
    let cloud = Cloud::new(1.2, HenyeyGreenstein::new(0.6).unwrap(), 1);
    let scene = cloud.scene(&Spectra::FIRST());
    let reach = Reach { dust: (0.4, 2.5), ..REACH };
    let plates = Plates::new(&scene, reach, None, &Options::default(), &Control::default()).unwrap();
    let mut most = 0.0f64;
    for change in 0..20 {
        let amount = 0.4 * (2.5f64 / 0.4).powf(Counter::new(78, change).uniform());
        let changed = Cloud { per_pc: 1.2 * amount, ..cloud.clone() }.scene(&Spectra::random(change));
        let (beyond, largest) = compare(&plates, &changed, &mut None);
        assert!(beyond <= 1.0, "{amount} times: {beyond} of what is stated, {largest:e} of a pixel");
        assert!(largest < 5e-3, "{amount} times: {largest:e} of a pixel");
        most = most.max(beyond);
    }
    assert!(most > 1e-3, "{most}");
    // What is exposed hangs on the amount that is said.
    let mut record = plates.record().clone();
    record.dust_per_pc *= 1.001;
    let (beyond, _) = compare(&Plates::of(record).unwrap(), &scene, &mut None);
    assert!(beyond > 1.0, "{beyond}");
}

/// Behind deep dust a band's relative error is large, where nothing is left; that of pixels, which see light before the dust too, is not.
#[test]
fn errors_of_pixels_are_small() {
    let cloud = Cloud::new(25.0, HenyeyGreenstein::new(0.6).unwrap(), 1);
    let scene = cloud.scene(&Spectra::FIRST());
    let plates = Plates::new(&scene, Reach { dust: (0.6, 1.7), ..REACH }, None, &Options::default(), &Control::default()).unwrap();
    let (beyond, _) = compare(&plates, &scene, &mut None);
    assert!(beyond <= 1.0, "{beyond}");
    let mixture = plates.mixture(&scene).unwrap();
    let relative = plates.certificates(&mixture, 0).iter().map(|(_, certificate)| certificate.relative).fold(0.0, f64::max);
    let image = plates.expose(&scene, &Control::default()).unwrap();
    let (light, error) = (image.band(0).sum::<f64>(), plates.errors(&mixture)[..image.width * image.height].iter().sum::<f32>());
    println!("{relative:e} of all depths, {:e} of pixels", f64::from(error) / light);
    assert!(relative > 1e-2 && f64::from(error) < 1e-3 * light, "{relative:e} of all depths, {:e} of pixels", f64::from(error) / light);
}

/// Grains whose phase function changes with wavelength.
#[test]
#[ignore = "long"]
fn phase_functions_may_have_colours() {
    let grains = Extinction::by_name("draine03_rv31").unwrap().grains().unwrap();
    let cloud = Cloud::new(1.2, Draine::new(grains.mean_cosine, 1.0).unwrap(), 1);
    let (plates, mut plan) = (cloud.plates(), None);
    for change in 2000..2060 {
        let (beyond, largest) = compare(&plates, &cloud.scene(&Spectra::random(change)), &mut plan);
        assert!(beyond <= 1.0, "change {change}: {beyond} of what is stated, {largest:e} of a pixel");
    }
}

/// Light that scatters many times: fields of single lights are solved apart, and their sum is that of all within what is stated of it.
#[test]
#[ignore = "long"]
fn many_bounces_are_kept() {
    let cloud = Cloud::new(3.0, HenyeyGreenstein::new(0.3).unwrap(), 20);
    let (plates, mut plan) = (cloud.plates(), None);
    let once = Cloud { bounces: 1, ..cloud.clone() };
    let single = once.plates();
    for change in [3000, 3002] {
        let spectra = Spectra { albedo: Spectra::FIRST().albedo, ..Spectra::random(change) };
        let scene = cloud.scene(&spectra);
        let (_, largest) = compare(&plates, &scene, &mut plan);
        let estimate = plan.as_ref().unwrap().scattered_field().unwrap().report.error_estimate.unwrap();
        assert!(largest < 1e-2, "change {change}: {largest:e}");
        let many = plates.expose(&scene, &Control::default()).unwrap();
        let (fresh, _) = Renderer::new(&mut cpu::Cpu).render(plan.as_ref().unwrap(), &Control::default()).unwrap();
        let apart = barnard::image::relative_rms(many.band(0).zip(fresh.band(0)));
        // Both have an error.
        assert!(apart < 2.0 * (estimate.spatial + estimate.angular), "change {change}: {apart:e} {estimate:?}");

        let single = single.expose(&once.scene(&spectra), &Control::default()).unwrap();
        let mean = |image: &Image| image.band(0).sum::<f64>();
        assert!(mean(&many) > 1.001 * mean(&single), "{} {}", mean(&many), mean(&single));
    }
    let other = cloud.scene(&Spectra { albedo: 0.5, ..Spectra::FIRST() });
    let error = plates.expose(&other, &Control::default()).unwrap_err().to_string();
    assert!(error.contains("albedo"), "{error}");
}

/// What plates cannot show is refused, and why is said.
#[test]
fn other_scenes_are_refused() {
    let cloud = Cloud::new(1.2, HenyeyGreenstein::new(0.6).unwrap(), 1);
    let plates = cloud.plates();
    let scene = || cloud.scene(&Spectra::FIRST());
    plates.expose(&scene(), &Control::default()).unwrap();
    let refused = |scene: Scene, words: &str| {
        let error = plates.expose(&scene, &Control::default()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let infrared = Spectra { bands: vec![(1.65, 0.3, true)], ..Spectra::FIRST() };
    refused(cloud.scene(&infrared), "extinctions outside");
    let edited = |edit: fn(&mut SceneSpec)| scene().edited(edit).unwrap();
    let moved = edited(|spec| spec.stars[0].position.x += 1e-3);
    refused(moved, "positions of stars");
    let turned = edited(|spec| spec.camera = spec.camera.clone().with_size(12, 8));
    refused(turned, "camera");
    refused(Cloud { per_pc: 4.0, ..cloud.clone() }.scene(&Spectra::FIRST()), "3.3333 times their amount of dust");
    refused(Cloud::new(1.2, HenyeyGreenstein::new(0.5).unwrap(), 1).scene(&Spectra::FIRST()), "phase function");
    let other = edited(|spec| spec.dust.as_mut().unwrap().density = Arc::new(Fbm::new(4)));
    refused(other, "density of dust");
    let dark = edited(|spec| spec.background.spectrum = None);
    plates.expose(&dark, &Control::default()).unwrap();
    let without = Plates::new(&dark, REACH, None, &Options::default(), &Control::default()).unwrap();
    let error = without.expose(&scene(), &Control::default()).unwrap_err().to_string();
    assert!(error.contains("no background"), "{error}");
    let new =
        |scene: &Scene, reach: Reach| Plates::new(scene, reach, None, &Options::default(), &Control::default()).unwrap_err().to_string();
    let error = Plates::new(&scene(), Reach::default(), None, &Options::within(1 << 10), &Control::default()).unwrap_err().to_string();
    assert!(error.contains("memory") || error.contains("MiB"), "{error}");
    let error = new(&scene(), Reach { range_um: Some((0.5, 0.4)), ..Reach::default() });
    assert!(error.contains("range of plates"), "{error}");
    for dust in [(0.0, 1.0), (1.1, 2.0), (0.5, 0.9), (0.5, f64::NAN), (1.0, 1e9)] {
        let error = new(&scene(), Reach { dust, ..REACH });
        assert!(error.contains("dust range of plates"), "{dust:?}: {error}");
    }
    let twice = edited(|spec| spec.method.bounces = 3);
    let error = new(&twice, Reach { dust: (0.5, 2.0), ..REACH });
    assert!(error.contains("multiple scattering"), "{error}");
    let mut record = plates.record().clone();
    record.plates[0].level.pop();
    assert!(Plates::of(record).is_err());
}
