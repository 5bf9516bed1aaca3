//! Detail below voxels: the back ends agree on it, pixels that do not see it are left alone, and it keeps what a cloud sends.

use barnard::backend::{Job, Renderer, cpu, cpu::Cpu, path};
use barnard::detail::Detail;
use barnard::field::{Grid, Lattice, Turbulence};
use barnard::geometry::Bounds;
use barnard::glam::{DVec3, dvec3};
use barnard::image::{Image, relative_rms};
use barnard::phase::HenyeyGreenstein;
use barnard::plan::{Planner, Stepping};
use barnard::scene::{Dust, Emission, Scale, Scene, SceneSpec, Star};
use barnard::spectra::extinction::Extinction;
use barnard::spectra::spectrum::{Line, Spectrum};
use barnard::spectra::units::{Luminosity, Temperature};
use barnard::{Camera, Control, Options};

fn detail() -> Detail {
    Detail { strength: 0.08, ..Detail::default() }
}

/// A turbulent cloud of 16 voxels and gas of 20, lit by a star beside it, from so near that a pixel sees a tenth of a voxel.
fn scene(depth: f64) -> Scene {
    lit_from(depth, dvec3(0.4, 1.6, 1.9))
}

/// Variant with the star elsewhere.
fn lit_from(depth: f64, star: DVec3) -> Scene {
    let cloud = Turbulence { voxels: 16, ..Turbulence::new(3, Bounds::cube(DVec3::ZERO, 1.0), 3.0).unwrap() };
    let gas = Grid::sampled(Lattice { dims: [20; 3], bounds: Bounds::cube(DVec3::ZERO, 0.9) }, |p| (-3.0 * p.length_squared()).exp());
    let dust = Dust::new(cloud.grid(1 << 30).unwrap(), Extinction::by_name("gordon23").unwrap(), Scale::per_pc(depth)).with_albedo(0.6);
    let star = Star::blackbody(Temperature(12_000.0), Luminosity::suns(900.0)).with_position(star).hidden();
    let glow = Spectrum::of_lines(vec![Line { lambda_um: 0.6563, strength: 3e-22 }]);
    let camera = Camera::look_at(dvec3(0.2, 0.3, 3.0), dvec3(0.2, 0.1, 0.0)).with_field_of_view_deg(4.0).with_size(16, 12);
    SceneSpec::new(camera)
        .with_dust(dust.with_phase(HenyeyGreenstein::new(0.5).unwrap()))
        .with_star(star)
        .with_emission(Emission::new(gas, glow).with_name("H alpha"))
        .build()
        .unwrap()
}

/// Variant whose dust ends within its box: at a border, densities go on beyond it, star depths from half of their voxel inside.
fn round(depth: f64) -> Scene {
    let lattice = Lattice { dims: [16; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
    let ball = Grid::sampled(lattice, |p| 6.0 * (1.0 - p.length()).max(0.0) * (1.3 + (5.0 * p.x).sin() * (4.0 * p.z).cos()));
    let dust = Dust::new(ball, Extinction::by_name("gordon23").unwrap(), Scale::per_pc(depth)).with_albedo(0.6);
    scene(depth).edited(|spec| spec.dust = Some(dust)).unwrap()
}

/// Variant with detail below its voxels.
fn detailed(scene: &Scene, detail: Detail) -> Scene {
    scene.edited(|spec| spec.detail = Some(detail)).unwrap()
}

fn values(image: &Image) -> Vec<f64> {
    (0..image.samples.len()).map(|i| image.samples.at(i)).collect()
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    let pixels = a.len() / 3;
    a.chunks(pixels).zip(b.chunks(pixels)).map(|(a, b)| relative_rms(a.iter().copied().zip(b.iter().copied()))).fold(0.0, f64::max)
}

fn on_cpu(scene: &Scene, stepping: Option<Stepping>) -> Vec<f64> {
    let plan = Planner::new(&Options::default()).plan(scene, None, &Control::default()).unwrap();
    let plan = stepping.map_or_else(|| plan.clone(), |stepping| plan.clone().with_stepping(stepping));
    cpu::radiance(&plan, &Control::default()).unwrap().0.into_iter().map(f64::from).collect()
}

/// Lit from beside and from within, the processor differs from the adaptive reference by less than a hundredth of what detail changes,
/// by half of that with fine steps; seeds matter.
#[test]
#[ignore = "long"]
fn detail_is_that_of_the_reference() {
    let inside = dvec3(0.2, 0.12, 0.1);
    for (depth, plain) in [(0.3, scene(0.3)), (3.0, round(3.0)), (1.0, lit_from(1.0, inside))] {
        // Rules of few nodes are certified relative to undimmed light: ten nodes and fine star depths leave the error of detail alone.
        let fine_method = |spec: &mut SceneSpec| {
            (spec.method.star_depth_voxels, spec.method.accuracy, spec.method.settings.count) = (Some(8), 1e-4, Some(10));
        };
        let plain = plain.edited(fine_method).unwrap();
        let noisy = detailed(&plain, detail());
        let truth = values(&barnard::render_reference(&noisy, 1e-4, &Control::default()).unwrap());
        let without = values(&barnard::render_reference(&plain, 1e-4, &Control::default()).unwrap());
        let changed = difference(&truth, &without);
        let default_steps = difference(&on_cpu(&noisy, None), &truth);
        let fine = difference(&on_cpu(&noisy, Some(Stepping::PerVoxel(24.0))), &truth);
        println!("depth {depth}: detail changes {changed:.2e}; own steps {default_steps:.2e}, fine ones {fine:.2e} off");
        assert!(changed > 0.02 && default_steps < 0.01 * changed && fine < 0.005 * changed, "{depth}: {changed} {default_steps} {fine}");
        let other = on_cpu(&detailed(&plain, Detail { seed: 2, ..detail() }), None);
        assert!(difference(&other, &truth) > 0.5 * changed);
    }
}

/// The path tracer, which takes chances of its own, finds the same within them.
#[test]
#[ignore = "long"]
fn detail_is_that_of_paths() {
    let scene = detailed(&scene(1.5), detail());
    let scene = scene.clone().with_camera(scene.camera.clone().with_size(6, 4));
    let truth = values(&barnard::render_reference(&scene, 1e-4, &Control::default()).unwrap());
    let options = path::Options::default().with_samples(16_000);
    let job_options = Options::default();
    let (image, _) =
        Renderer::new(&mut path::PathTracer::new(options)).render(Job::new(&scene, &job_options).unwrap(), &Control::default()).unwrap();
    let found = difference(&values(&image), &truth);
    let plain = scene.edited(|spec| spec.detail = None).unwrap();
    let without = difference(&values(&barnard::render_reference(&plain, 1e-4, &Control::default()).unwrap()), &truth);
    println!("paths {found:.2e} off, without detail {without:.2e}");
    assert!(found < 0.02 && without > 4.0 * found, "{found} {without}");
}

/// From afar a pixel sees no voxels, and the picture has the bits that it had; so it has where the strength is zero.
#[test]
fn pixels_that_see_no_voxels_are_left_alone() {
    let camera = Camera::look_at(dvec3(0.2, 0.3, 3.0), DVec3::ZERO).with_field_of_view_deg(40.0).with_size(8, 6);
    let far = scene(1.0).with_camera(camera);
    let coarse = on_cpu(&detailed(&far, detail()), None);
    assert!(coarse == on_cpu(&far, None));
    let near = scene(1.0);
    assert!(on_cpu(&detailed(&near, Detail { strength: 0.0, ..detail() }), None) == on_cpu(&near, None));
    assert!(on_cpu(&detailed(&near, detail()), None) != on_cpu(&near, None));
}

/// Thin clouds send as much as before, all pixels of six seeds together; a part of a picture is that of the whole.
#[test]
fn detail_keeps_the_mean() {
    let camera = Camera::look_at(dvec3(0.0, 0.0, 40.0), DVec3::ZERO).with_field_of_view_deg(2.0).with_size(120, 100);
    let thin = scene(1e-3).with_camera(camera);
    let before = on_cpu(&thin, None);
    let of_seed = |seed: u32| on_cpu(&detailed(&thin, Detail { seed, ..detail() }), None);
    let pictures: Vec<Vec<f64>> = (1..7).map(of_seed).collect();
    let pixels = 120 * 100;
    for (band, before) in before.chunks(pixels).enumerate() {
        let sum = |picture: &[f64]| picture[band * pixels..][..pixels].iter().sum::<f64>();
        let ratio = pictures.iter().map(|picture| sum(picture)).sum::<f64>() / 6.0 / before.iter().sum::<f64>();
        assert!((ratio - 1.0).abs() < 0.012, "{band}: {ratio}");
    }
    assert!(difference(&pictures[0], &before) > 0.03);
    let part = thin.camera.clone().crop(40, 32, 16, 12).unwrap();
    let part = on_cpu(&detailed(&thin, detail()).with_camera(part), None);
    let inside = (0..3).flat_map(|b| (32..44).flat_map(move |y| (40..56).map(move |x| (b * 100 + y) * 120 + x)));
    let whole: Vec<f64> = inside.map(|i| pictures[0][i]).collect();
    assert!(difference(&part, &whole) < 1e-3, "{}", difference(&part, &whole));
}

/// Notes of a picture: how many octaves, and how strong.
#[test]
fn pictures_tell_of_detail() {
    let notes = |scene: &Scene| {
        let (image, _) = Renderer::new(&mut Cpu).render(Job::new(scene, &Options::default()).unwrap(), &Control::default()).unwrap();
        (
            image.statements().iter().any(|(about, words)| about == "detail" && words.contains("0.08 of each wavelength")),
            image.cards().iter().any(|k| k.name == "DETAIL"),
        )
    };
    assert_eq!(notes(&detailed(&scene(1.0), detail())), (true, true));
    assert_eq!(notes(&scene(1.0)), (false, false));
}
