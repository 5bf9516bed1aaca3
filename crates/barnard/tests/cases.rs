//! Images beside reference answers that no renderer of ours made.

#[path = "common/cases.rs"]
mod reference_cases;

use barnard::control::Control;
use barnard::image::Image;
use barnard::plan::{Options, Plan};
use barnard::scene::{DEFAULT_MEMORY, Method, Scene};
use reference_cases::{compare, folders, load};

fn cpu(scene: &Scene, method: Method) -> Image {
    let options = Options { method, memory_limit: DEFAULT_MEMORY };
    let plan = Plan::new(scene, &options, &Control::default()).unwrap();
    println!("{:?} {:?}, terms {}", plan.space.spatial, plan.space.star_factor, plan.spectral.terms());
    barnard::backend::cpu::render(scene, &plan, &Control::default()).unwrap().0
}

#[test]
fn cpu_is_within_3e_3_of_every_case() {
    for folder in folders() {
        let image = cpu(&load(&folder), Method::default());
        assert!(compare(&folder, &image, 3e-3) < 3e-3, "{}", folder.display());
    }
}

#[test]
fn reference_is_within_1e_4_of_every_case() {
    for folder in folders() {
        let image = barnard::backend::reference::render(&load(&folder), barnard::backend::reference::DEFAULT_ACCURACY, &Control::default())
            .unwrap();
        assert!(compare(&folder, &image, 1e-4) < 1e-4, "{}", folder.display());
    }
}

/// The comparison can fail: three percent more dust moves every image by far more than is allowed.
#[test]
fn a_denser_cloud_is_noticed() {
    for folder in folders() {
        let mut scene = load(&folder);
        scene.dust.as_mut().unwrap().sigma_v_per_pc *= 1.03;
        let image = cpu(&scene, Method::default());
        assert!(compare(&folder, &image, 3e-3) > 3e-3, "{}", folder.display());
    }
}
