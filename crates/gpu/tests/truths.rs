//! Pictures of the graphics processor beside truths that know nothing of plans: reference answers of another program,
//! and our own adaptive reference.

#[path = "../../barnard/tests/common/cases.rs"]
mod reference_cases;
#[path = "common/device.rs"]
mod test_device;

use barnard::backend::Renderer;
use barnard::control::Control;
use barnard::image::{Image, relative_rms};
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planned, Planner, sample_functions};
use barnard::scene::{Loader, Scene};
use barnard_gpu::{Gpu, OnDevice, Tuning};
use reference_cases::{compare, folders, load};
use test_device::device;

fn picture(gpu: &Gpu, scene: &Scene, options: &Options) -> (Image, Planned) {
    let plan = Planner::new(options).plan(scene, None, &Control::default()).unwrap();
    let mut backend = OnDevice::new(gpu.clone(), Tuning::default());
    (Renderer::new(&mut backend).render(&plan, &Control::default()).unwrap().0, plan)
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn gpu_is_within_3e_3_of_every_case() {
    let gpu = device();
    let options = Options::default();
    for folder in folders() {
        let image = picture(&gpu, &load(&folder), &options).0;
        assert!(compare(&folder, &image, 3e-3) < 3e-3, "{}", folder.display());
        // Three percent more dust would be noticed.
        let denser = load(&folder).edited(|spec| spec.dust.as_mut().unwrap().sigma_v_per_pc *= 1.03).unwrap();
        assert!(compare(&folder, &picture(&gpu, &denser, &options).0, 3e-3) > 3e-3, "{}", folder.display());
    }
}

/// A part of an image is the whole's, by a plan of the whole, whatever the projection is.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn parts_of_an_image_make_the_whole() {
    let (gpu, control, options) = (device(), Control::default(), Options::default());
    let scene = barnard_files::builtin::load("barres_neyret", DEFAULT_LIMIT).unwrap();
    for camera in [scene.camera.clone(), scene.camera.clone().with_orthographic_pc(3.0)] {
        let scene = scene.clone().with_camera(camera.with_size(40, 30));
        let (whole, mut plan) = picture(&gpu, &scene, &options);
        let part = scene.camera.clone().crop(13, 4, 20, 11).unwrap();
        plan.look_from(part.clone(), &control).unwrap();
        let mut backend = OnDevice::new(gpu.clone(), Tuning::default());
        let part_image = Renderer::new(&mut backend).render(&plan, &control).unwrap().0;
        let light = (0..11).flat_map(|i| (0..20).map(move |j| (i, j))).map(|(i, j)| (part_image.at(0, i, j), whole.at(0, i + 4, j + 13)));
        assert!(light.clone().any(|(_, theirs)| theirs > 0.0));
        assert!(relative_rms(light) < 1e-4);
    }
}

/// Every built-in scene, its clouds on few voxels, against the reference on the same samples, to the error that the plan states: spectral and
/// spatial.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn gpu_is_within_its_stated_accuracy_of_the_reference() {
    let gpu = device();
    for builtin in barnard_files::builtin::SCENES.iter().filter(|scene| scene.needs.is_none()) {
        let scene = barnard_files::builtin::load_by(builtin.name, DEFAULT_LIMIT, Loader::roughly).unwrap();
        let options = Options::within(DEFAULT_LIMIT);
        // Stars without number state an error of their own, and are held to stars one by one in tests of their own.
        if scene.stars.len() > MANY_STARS {
            continue;
        }
        let scene = sample_functions(&scene, &options).unwrap();
        let scene = scene.clone().with_camera(scene.camera.clone().with_supersampling(1).with_size(EDGE, EDGE));
        let (image, plan) = picture(&gpu, &scene, &options);
        let truth = barnard::render_reference(&scene, 3e-4, &Control::default()).unwrap();
        let spatial = plan.space().spatial.map_or(0.0, |s| s.error);
        // Steps that the scene fixes can miss the accuracy, and the plan says by how much: beside that there is the
        // spectral part.
        let asked = plan.spectral().accuracy;
        let stated = if spatial > asked { asked + spatial } else { asked };
        for (b, band) in image.bands.iter().enumerate() {
            let wrong = image.relative_rmse(b, &truth, b);
            println!("{} {}: {wrong:.2e} of {stated:.1e}", builtin.name, band.name);
            assert!(wrong < stated, "{} {}: {wrong:e} of {stated:e}", builtin.name, band.name);
        }
    }
}

/// More stars than are marched one by one.
const MANY_STARS: usize = 8;
/// Pixels along an edge: the reference takes its time.
const EDGE: usize = 4;
