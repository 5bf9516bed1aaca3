//! Frames of the scene of the README's table: `cargo bench -p barnard`. Names are noun/method/size.

use barnard::backend::cpu;
use barnard::control::Control;
use barnard::glam::DVec3;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planned, Planner, Quality};
use barnard::scene::{Method, Scene};
use divan::counter::BytesCount;
use rayon::prelude::*;
use spectra::passband::{Counting, Passband, Window, window};
use spectra::units::Wavelength;

const METHODS: [&str; 3] = ["fixed_wavelength", "band_quadrature", "lookup"];
const SIZES: [usize; 3] = [64, 128, 256];
const EDGES: [usize; 3] = [128, 256, 512];

fn main() {
    divan::main();
}

fn scene(bake: usize) -> Scene {
    let text = format!(
        "bands = \"johnson\"\n[camera]\nkind = \"perspective\"\nposition = \"0 0 4 pc\"\nfield_of_view = \"30 deg\"\nsize = [256, 256]\n\
         [field.cloud]\nkind = \"fbm\"\nseed = 2\nscale = \"0.6 pc\"\noffset = 0.15\n\
         [dust]\ndensity = \"cloud\"\nscale = \"4 /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0.7\n\
         [[star]]\nkind = \"blackbody\"\nposition = \"0.3 0.35 0.4 pc\"\ntemperature = \"10000 K\"\nluminosity = \"1000 Lsun\"\nvisible = false\n\
         [method]\nbake = {bake}\nsteps = {bake}\n"
    );
    barnard_files::parse("bench.toml", "bench", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).expect("the bench's scene is valid")
}

fn plan(scene: &Scene, method: &str) -> Planned {
    let method: Method = scene.method.clone().with_name(method).expect("a known method");
    Planner::new(&Options::default())
        .plan(scene.clone().with_method(method), None, &Control::default())
        .expect("the bench's scene can be planned")
}

/// One frame with warm star depths, by method, 256 × 256 pixels, 128³ voxels.
#[divan::bench(args = METHODS)]
fn frame_by_method(bencher: divan::Bencher, method: &str) {
    let plan = plan(&scene(128), method);
    bencher.bench(|| {
        let (radiance, _) = cpu::radiance(&plan, &Control::default()).expect("a frame");
        assert!(radiance.iter().all(|v| v.is_finite()) && radiance.iter().any(|v| *v > 0.0));
        radiance
    });
}

/// One frame by grid, a sample for each voxel crossed: linear in the edge.
#[divan::bench(args = SIZES)]
fn frame_by_voxels(bencher: divan::Bencher, bake: usize) {
    let plan = plan(&scene(bake), "band_quadrature");
    bencher.bench(|| cpu::radiance(&plan, &Control::default()).expect("a frame"));
}

/// One frame by passbands that share 400 to 900 nm among them: reads and geometry are those of one.
#[divan::bench(args = [3, 200])]
fn frame_by_bands(bencher: divan::Bencher, bands: usize) {
    let width_um = 0.5 / bands as f64;
    let band = |i: usize| -> Passband {
        let centre = Wavelength(0.4 + width_um * (i as f64 + 0.5));
        window(&format!("band {i}"), Counting::Energy, Window::TopHat { centre, width: Wavelength(width_um) }).expect("a passband")
    };
    let plan = plan(
        &scene(128).edited(|spec| *spec = spec.clone().with_bands((0..bands).map(band).collect())).expect("a scene"),
        "band_quadrature",
    );
    bencher.bench(|| cpu::radiance(&plan, &Control::default()).expect("a frame"));
}

/// Depths of a star that moved, by grid; bytes are those of a float read and one written for each voxel.
#[divan::bench(args = EDGES, sample_count = 5)]
fn star_depths(bencher: divan::Bencher, edge: usize) {
    let mut plan = Planner::new(&Options::default())
        .with_quality(Quality::Fixed(10))
        .plan(scene(edge), None, &Control::default())
        .expect("the bench's scene can be planned");
    let mut x = 0.0;
    bencher.counter(BytesCount::new(8 * edge.pow(3))).bench_local(|| {
        x = 0.3 - x;
        plan.move_star(0, DVec3::new(x, 0.35, 0.4), &Control::default()).expect("the star is there");
        assert!(plan.space().star_depth > 0.0);
    });
}

/// The floor of that: the same bytes copied by all cores.
#[divan::bench(args = EDGES, sample_count = 5)]
fn star_depths_floor(bencher: divan::Bencher, edge: usize) {
    let from = vec![1.0f32; edge.pow(3)];
    let mut to = vec![0.0f32; from.len()];
    bencher.counter(BytesCount::new(8 * edge.pow(3))).bench_local(|| {
        let parts = to.par_chunks_mut(1 << 16).zip(from.par_chunks(1 << 16));
        parts.for_each(|(to, from)| to.copy_from_slice(from));
        assert_eq!(to.last(), from.last());
    });
}

/// A picture of plates, 1920 × 1080 pixels in three bands, of a star, gas and background: what each step of a slider costs.
#[divan::bench]
fn plates_exposed(bencher: divan::Bencher) {
    let gas = barnard::field::Sphere::new(DVec3::ZERO, 0.7).expect("a ball");
    let glow = spectra::spectrum::Spectrum::of_lines(vec![spectra::spectrum::Line { lambda_um: 0.5007, strength: 1e-24 }]);
    let sky =
        spectra::spectrum::Spectrum::continuous(1e-9, std::sync::Arc::new(spectra::sed::BlackBody(spectra::units::Temperature(5000.0))));
    let scene = scene(64).edited(|spec| {
        spec.camera = spec.camera.clone().with_size(1920, 1080);
        spec.emission.push(barnard::scene::Emission::new(gas, glow));
        spec.background = barnard::scene::Background::even(sky);
    });
    let scene = scene.expect("a scene");
    let plates = barnard::Plates::new(&scene, Default::default(), None, &Options::default(), &Control::default()).expect("plates");
    let mut picture = vec![0.0; 3 * 1920 * 1080];
    bencher.counter(BytesCount::new(plates.bytes() + 4 * picture.len() as u64)).bench_local(|| {
        let mixture = plates.mixture(&scene).expect("a mixture");
        picture.fill(0.0);
        plates.add(&mixture, &mut picture).expect("a picture");
    });
}
