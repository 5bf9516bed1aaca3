//! Volumes of which empty pages are left out: the pictures are those of whole ones.

use barnard::backend::cpu;
use barnard::control::Control;
use barnard::image::Image;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Plan, Stepping, sample_functions};
use barnard::scene::Scene;
use barnard::volume::Sparsity;

/// A few lumps in an empty box of 90 voxels along its edge, stars among them and outside.
fn scene(stars: bool, method: &str) -> Scene {
    let lump = |place: &str, size: f64| format!("max(0, 1 - {size} * ({place}))");
    let lumps = format!(
        "cube * ({} + {})",
        lump("(x - 0.5)^2 + (y - 0.4)^2 + (z + 0.3)^2", 30.0),
        lump("(x + 0.4)^2 + (y + 0.5)^2 + (z - 0.35)^2", 14.0)
    );
    let starlit = format!(
        "[dust]\ndensity = \"{lumps}\"\nscale = \"12 /pc\"\nlaw = \"gordon23\"\nalbedo = 0.6\n[dust.phase]\nkind = \"henyey_greenstein\"\ng = 0.5\n\
         [[star]]\nname = \"inside\"\nkind = \"blackbody\"\nposition = \"-0.4 -0.45 0.3 pc\"\ntemperature = \"12000 K\"\nluminosity = \"1000 Lsun\"\n\
         [[star]]\nname = \"outside\"\nkind = \"blackbody\"\nposition = \"-1.5 0.9 2 pc\"\ntemperature = \"6000 K\"\nluminosity = \"3000 Lsun\"\nvisible = false\n"
    );
    let text = format!(
        "bands = \"johnson\"\n[camera]\nkind = \"perspective\"\nposition = \"0.4 0.3 4 pc\"\nfield_of_view = \"34 deg\"\nsize = [60, 52]\n\
         [field.cube]\nkind = \"box\"\nlow = \"-1 -1 -1 pc\"\nhigh = \"1 1 1 pc\"\n{}\
         [[emission]]\nkind = \"lines\"\ndensity = \"{lumps} * (1.5 + x)\"\nscale = \"1e-9 W/m2/sr/pc\"\nlines = [{{ wavelength = \"550 nm\", strength = 1 }}]\n\
         [method]\nbake = 90\n{method}\n",
        if stars { &starlit } else { "" }
    );
    let mut scene = barnard_files::parse("sparse.toml", "sparse", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap();
    sample_functions(&mut scene, &Options::default()).unwrap();
    scene
}

fn planned(scene: &Scene, sparse: Sparsity) -> Plan {
    let mut scene = scene.clone();
    scene.method.sparse = sparse;
    Plan::new(&scene, &Options::default(), &Control::default()).unwrap()
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
fn sparse_volumes_make_the_same_picture() {
    for (stars, method) in [
        (false, ""),
        (true, ""),
        (true, "name = \"common_nodes\""),
        (true, "steps = 60\nvolumes = \"half\""),
        (true, "name = \"projection\""),
        (true, "name = \"double_integration\"\ncount = 4"),
    ] {
        let scene = scene(stars, method);
        let [whole, sparse] = [Sparsity::Never, Sparsity::Always].map(|sparsity| planned(&scene, sparsity));
        let [a, b] = [&whole, &sparse].map(|plan| cpu::render(&scene, plan, &Control::default()).unwrap().0);
        let worst = difference(&b, &a);
        // Depths at the rim of a page are moved to their means along fewer axes; gas has none.
        assert!(worst < if stars { 1e-8 } else { f64::MIN_POSITIVE }, "{stars} {method}: {worst:e}");
        let (held, of_pages, of_whole) = (sparse.space().volumes[0].held(), sparse.space().bytes(), whole.space().bytes());
        assert!(held < 0.2 && of_pages < of_whole, "{stars} {method}: {held} of the voxels, {of_pages} and {of_whole} bytes");
        // A step more would be seen.
        let other = sparse.with_stepping(Stepping::Fixed(70));
        assert!(difference(&cpu::render(&scene, &other, &Control::default()).unwrap().0, &a) > 1e-6);
    }
}
