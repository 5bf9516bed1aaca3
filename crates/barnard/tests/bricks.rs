//! Pictures brick by brick: any number of bricks makes the picture of one, and one that of the fast back end.

use std::ops::Range;

use barnard::backend::cpu::bricks::{Partial, Whole};
use barnard::backend::{Renderer, cpu};
use barnard::control::Control;
use barnard::field::Grid;
use barnard::glam::DVec3;
use barnard::image::Image;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::star_depths::frustum_sweep::sweep;
use barnard::plan::{BrickFields, Options, Planned, Planner, densities, sample_functions};
use barnard::scene::Scene;
use barnard::volume::{Channel, ChannelMut, Volume};

/// Dust and gas of one box, a star inside on a border between bricks, one outside, a star field and an even background.
fn scene(camera: &str, method: &str) -> Scene {
    let stars = if camera.contains("perspective") { "[background.stars]\ndensity = \"50 /deg2\"" } else { "" };
    let text = format!(
        r#"bands = "johnson"
[camera]
{camera}
[field.cloud]
kind = "fbm"
seed = 3
octaves = 4
radius = "1 pc"
[dust]
density = "cloud"
scale = "6 /pc"
law = "gordon23"
albedo = 0.6
[dust.phase]
kind = "henyey_greenstein"
g = 0.5
[[emission]]
kind = "lines"
density = "cloud * (1 + x)"
scale = "1e-9 W/m2/sr/pc"
lines = [{{ wavelength = "550 nm", strength = 1 }}]
[[star]]
name = "inside"
kind = "blackbody"
position = "0 0.02 0.3 pc"
temperature = "12000 K"
luminosity = "1000 Lsun"
[[star]]
name = "outside"
kind = "blackbody"
position = "-1.5 0.9 2 pc"
temperature = "6000 K"
luminosity = "3000 Lsun"
visible = false
[background]
kind = "power_law"
exponent = 0
radiance = "1e-12 W/m2/sr/nm"
{stars}
[method]
bake = 40
{method}
"#
    );
    let scene = barnard_files::parse("bricks.toml", "bricks", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap();
    sample_functions(&scene, &Options::default()).unwrap()
}

/// The plan of a scene whose star depths stand at the voxels of its dust, as those of bricks do.
fn planned(scene: &Scene) -> Planned {
    Planner::new(&Options::default().with_star_depth_voxels(1)).plan(scene, None, &Control::default()).unwrap()
}

/// The values of some voxels of a grid.
fn part(grid: &Grid, [x, y, z]: &[Range<usize>; 3]) -> Vec<f32> {
    let (values, lattice) = (grid.values(), grid.lattice());
    let rows = z.clone().flat_map(|z| y.clone().map(move |y| lattice.index(0, y, z)));
    rows.flat_map(|row| values[row + x.start..row + x.end].to_vec()).collect()
}

/// The depths of a star at voxel centres, as one sweep makes them.
fn depths(dust: &Grid, star: DVec3) -> Grid {
    let lattice = dust.lattice();
    let mut volume = Volume::zeroed(lattice, vec![Channel::StarDepth(0)]);
    sweep(dust, star, &mut ChannelMut { volume: &mut volume, slot: 0 }, &Control::default(), |_| ()).unwrap();
    let values = (0..lattice.cells()).map(|i| volume.value(volume.index(lattice.place(i)), 0)).collect();
    Grid::new(lattice.dims, lattice.bounds, values).unwrap()
}

/// The densities of a scene at the voxels of its dust.
fn sampled(scene: &Scene) -> Vec<Grid> {
    let dust = scene.dust.as_ref().unwrap().density.grid().unwrap().lattice().clone();
    densities(scene, &dust, &Options::default(), &Control::default()).unwrap()
}

/// A scene's volume in bricks, and what each does to the rays of the picture, front to back.
fn bricks(scene: &Scene, cuts: impl Fn([usize; 3]) -> [Vec<usize>; 3]) -> (Whole, Vec<Partial>) {
    let grids = sampled(scene);
    let dims = grids[0].lattice().dims;
    let whole = Whole::new(scene, dims, cuts(dims), &Options::default(), &Control::default()).unwrap();
    let stars: Vec<Grid> = whole.stars().into_iter().map(|star| depths(&grids[0], star)).collect();
    let partial = |place: [usize; 3]| {
        let stored = whole.stored(place);
        let parts = |grids: &[Grid]| grids.iter().map(|grid| part(grid, &stored)).collect();
        let fields = BrickFields { dust: Some(part(&grids[0], &stored)), star_depths: parts(&stars), gas: parts(&grids[1..]) };
        whole.march(place, fields, &Control::default()).unwrap()
    };
    let partials = whole.front_to_back().into_iter().map(partial).collect();
    (whole, partials)
}

/// The picture of a scene by bricks, and the largest depth that was met.
fn by_bricks(scene: &Scene, cuts: impl Fn([usize; 3]) -> [Vec<usize>; 3]) -> (Image, f64) {
    let (whole, partials) = bricks(scene, cuts);
    let all = partials.into_iter().reduce(|front, back| whole.over(front, back).unwrap()).unwrap();
    let (image, stats) = whole.picture(&all, &Control::default()).unwrap();
    (image, stats.depth)
}

/// The largest difference in a band, in parts of the band's largest value.
fn difference(a: &Image, b: &Image) -> f64 {
    let of_band = |band: usize| {
        let peak = b.band(band).fold(0.0, f64::max);
        assert!(peak > 0.0);
        a.band(band).zip(b.band(band)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / peak
    };
    (0..b.bands.len()).map(of_band).fold(0.0, f64::max)
}

const CAMERAS: [&str; 4] = [
    r#"kind = "perspective"
position = "0.4 0.3 4 pc"
field_of_view = "34 deg"
size = [50, 39]"#,
    // From inside, through a corner between bricks.
    r#"kind = "perspective"
position = "0 0.02 -0.4 pc"
target = "0.2 0.5 0.1 pc"
field_of_view = "80 deg"
size = [40, 40]"#,
    // Along an axis: rays that run on borders between bricks.
    r#"kind = "orthographic"
position = "0 0 5 pc"
width = "2.2 pc"
size = [40, 40]
supersampling = 2"#,
    r#"kind = "orthographic"
position = "-4 3 -2 pc"
width = "2.6 pc"
size = [37, 30]"#,
];

/// Four kinds of view, and all rules whose terms are exponentials: N bricks are one, and the fast back end's picture, to
/// 1e-6 of the peak.
#[test]
#[ignore = "long"]
fn bricks_make_the_picture_of_one() {
    for (camera, method) in
        CAMERAS.into_iter().zip(["", "name = \"common_nodes\"", "name = \"band_quadrature\"", "steps = 60\nvolumes = \"half\""])
    {
        let scene = scene(camera, method);
        let (one, depth) = by_bricks(&scene, |dims| dims.map(|n| vec![0, n]));
        let twelve = by_bricks(&scene, |[x, y, z]| [vec![0, x / 2, x], vec![0, 7, y], vec![0, z / 3, z / 2 + 6, z]]);
        let four = by_bricks(&scene, |[x, y, z]| [vec![0, x], vec![0, 1, y], vec![0, z / 2, z]]);
        for (many, deepest) in [twelve, four] {
            assert!((deepest / depth - 1.0).abs() < 1e-5, "{camera} {method}: depths of {deepest} and {depth}");
            let worst = difference(&many, &one);
            assert!(worst < 1e-6, "{camera} {method}: {worst:.1e}");
        }
        // The fast back end ends rays early, and takes boxes that are occupied as the densities themselves have them.
        let fast = Renderer::new(&mut cpu::Cpu).render(&planned(&scene), &Control::default()).unwrap().0;
        let worst = difference(&one, &fast);
        assert!(worst < 1e-6, "{camera} {method}, beside the fast back end: {worst:.1e}");
    }
}

/// A brick's light that is left out, or put before what it stands behind, is seen.
#[test]
fn a_brick_that_is_missing_is_seen() {
    let scene = scene(CAMERAS[0], "");
    let (whole, parts) = bricks(&scene, |[x, y, z]| [vec![0, x], vec![0, y], vec![0, z / 2, z]]);
    let picture = |all: &Partial| whole.picture(all, &Control::default()).unwrap().0;
    let [front, back] = [0, 1].map(|i| parts[i].clone());
    let right = picture(&whole.over(front.clone(), back.clone()).unwrap());
    for wrong in [whole.over(back, front.clone()).unwrap(), front] {
        assert!(difference(&picture(&wrong), &right) > 1e-4);
    }
}

/// What bricks cannot do is refused by name, and so are fields of other sizes.
#[test]
fn what_bricks_cannot_do_is_refused() {
    let whole = |scene: &Scene| {
        let dims = sampled(scene)[0].lattice().dims;
        Whole::new(scene, dims, dims.map(|n| vec![0, n]), &Options::default(), &Control::default())
    };
    let refused = |method: &str| whole(&scene(CAMERAS[0], method)).unwrap_err().to_string();
    assert!(refused("bounces = 2").contains("multiple scattering"));
    assert!(refused("exact_stars = 1").contains("exact_stars"));
    assert!(refused("name = \"lookup\"").contains("spectral method"));
    let whole = whole(&scene(CAMERAS[0], "")).unwrap();
    let dims = whole.partition().lattice().dims;
    let fields =
        |dust: usize| BrickFields { dust: Some(vec![0.0; dust]), star_depths: vec![vec![0.0; dust]; 2], gas: vec![vec![0.0; dust]] };
    let cells = dims.iter().product();
    assert!(whole.march([0; 3], fields(cells), &Control::default()).is_ok());
    let wrong = |fields: BrickFields| whole.march([0; 3], fields, &Control::default()).unwrap_err().to_string();
    assert!(wrong(fields(cells - 1)).contains("one per voxel"));
    assert!(wrong(BrickFields { gas: Vec::new(), ..fields(cells) }).contains("0 of gas"));
}
