//! Volumes of which empty pages are left out: the pictures are those of whole ones.

use barnard::backend::{Renderer, cpu};
use barnard::control::Control;
use barnard::glam::DVec3;
use barnard::image::Image;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planned, Planner, Stepping, sample_functions};
use barnard::scene::{Scene, Sparsity};

/// A few lumps in an empty box, stars among them and outside.
fn scene(scale: f64, method: &str) -> Scene {
    sampled(scale, 90, method)
}

/// Variant with the given number of voxels per edge.
fn sampled(scale: f64, voxels: usize, method: &str) -> Scene {
    let lump = |place: &str, size: f64| format!("max(0, 1 - {size} * ({place}))");
    let lumps = format!(
        "cube * ({} + {})",
        lump("(x - 0.5)^2 + (y - 0.4)^2 + (z + 0.3)^2", 30.0),
        lump("(x + 0.4)^2 + (y + 0.5)^2 + (z - 0.35)^2", 14.0)
    );
    let starlit = format!(
        r#"[dust]
density = "{lumps}"
scale = "{scale} /pc"
law = "gordon23"
albedo = 0.6
[dust.phase]
kind = "henyey_greenstein"
g = 0.5
[[star]]
name = "inside"
kind = "blackbody"
position = "0 0.02 0 pc"
temperature = "12000 K"
luminosity = "1000 Lsun"
[[star]]
name = "outside"
kind = "blackbody"
position = "-1.5 0.9 2 pc"
temperature = "6000 K"
luminosity = "3000 Lsun"
visible = false
"#
    );
    let text = format!(
        r#"bands = "johnson"
[camera]
kind = "perspective"
position = "0.4 0.3 4 pc"
field_of_view = "34 deg"
size = [60, 52]
[field.cube]
kind = "box"
low = "-1 -1 -1 pc"
high = "1 1 1 pc"
{}[[emission]]
kind = "lines"
density = "{lumps} * (1.5 + x)"
scale = "1e-9 W/m2/sr/pc"
lines = [{{ wavelength = "550 nm", strength = 1 }}]
[method]
bake = {voxels}
{method}
"#,
        if scale > 0.0 { &starlit } else { "" }
    );
    let scene = barnard_files::parse("sparse.toml", "sparse", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap();
    sample_functions(&scene, &Options::default()).unwrap()
}

fn planned(scene: &Scene, sparse: Sparsity) -> Planned {
    // Where less is held, star depths may become finer than a whole volume's would.
    planned_with(scene, sparse, 2)
}

fn planned_with(scene: &Scene, sparse: Sparsity, star_depth_voxels: usize) -> Planned {
    let scene = scene.edited(|spec| spec.method.sparse = sparse).unwrap();
    let options = Options::default().with_star_depth_voxels(star_depth_voxels);
    Planner::new(&options).plan(&scene, None, &Control::default()).unwrap()
}

/// The largest difference in a band, in parts of the band's largest value.
fn difference(a: &Image, b: &Image) -> f64 {
    let of_band = |band: usize| {
        let peak = b.band(band).fold(0.0, f64::max);
        a.band(band).zip(b.band(band)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / peak
    };
    (0..b.bands.len()).map(of_band).filter(|difference| difference.is_finite()).fold(0.0, f64::max)
}

#[test]
#[ignore = "long"]
fn sparse_volumes_make_the_same_picture() {
    for (scale, method) in [
        (0.0, ""),
        (12.0, ""),
        // Depths of thousands from a star, next to places from which nothing is held.
        (9000.0, ""),
        (12.0, "name = \"common_nodes\""),
        (12.0, "steps = 60\nvolumes = \"half\""),
        (12.0, "name = \"projection\""),
        (12.0, "name = \"propagation\""),
        (12.0, "name = \"double_integration\"\ncount = 4"),
    ] {
        let scene = scene(scale, method);
        let [whole, sparse] = [Sparsity::Never, Sparsity::Always].map(|sparsity| planned(&scene, sparsity));
        let [a, b] = [&whole, &sparse].map(|plan| Renderer::new(&mut cpu::Cpu).render(plan, &Control::default()).unwrap().0);
        let worst = difference(&b, &a);
        // Single precision rounds a cell's place in memory, and no value.
        assert!(worst < 1e-8, "{scale} {method}: {worst:e}");
        let (stored_share, of_pages, of_whole) = (sparse.space().volumes[0].stored_share(), sparse.space().bytes(), whole.space().bytes());
        assert!(
            stored_share < 0.25 && of_pages < of_whole,
            "{scale} {method}: {stored_share} of the voxels, {of_pages} and {of_whole} bytes"
        );
        // A step more would be seen.
        let other = sparse.with_stepping(Stepping::Fixed(70));
        assert!(difference(&Renderer::new(&mut cpu::Cpu).render(&other, &Control::default()).unwrap().0, &a) > 1e-6);
    }
}

/// A star that moves through pages has the depths of a plan that was made with it there, and its picture bit by bit.
#[test]
fn stars_move_through_pages() {
    let scene = scene(12.0, "");
    let first = planned(&scene, Sparsity::Always);
    let rendered = |plan: &Planned| Renderer::new(&mut cpu::Cpu).render(plan, &Control::default()).unwrap().0;
    let before = rendered(&first);
    let place = DVec3::new(1.3, -0.2, 0.8);
    let mut moved = first.clone();
    moved.move_star(1, place, &Control::default()).unwrap();
    let scene = scene.edited(|spec| spec.stars[1].position = place).unwrap();
    // Rules stay those of the place before.
    let there = first.clone().with_space(planned(&scene, Sparsity::Always).space().clone());
    assert!(there.space().volumes.iter().any(|volume| !volume.pages().is_whole()));
    let [moved, there] = [&moved, &there].map(rendered);
    let (same, other) = (difference(&moved, &there), difference(&before, &there));
    assert!(same == 0.0 && other > 1e-5, "{same:e} {other:e}");
}

/// Empty pages are left out by themselves where volumes are large, and only there.
#[test]
#[ignore = "long"]
fn large_volumes_are_sparse() {
    for (voxels, is_sparse) in [(150, false), (210, true)] {
        let scene = sampled(12.0, voxels, "").edited(|spec| spec.stars.truncate(1)).unwrap();
        let plan = planned_with(&scene, Sparsity::Auto, 1);
        assert!(plan.space().volumes.iter().all(|volume| volume.pages().is_whole() != is_sparse), "{voxels}");
    }
}
