//! Orders of scattering that are swept on the device, beside those of the processor.

#[path = "common/device.rs"]
mod test_device;

use std::sync::Arc;

use barnard::control::Control;
use barnard::field::{Grid, Lattice};
use barnard::fixtures::small_cloud;
use barnard::geometry::Bounds;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::ordinates::{EightLanes, Moments, Powers, Processor, SweepCells, Sweeper, Transfer, WIDTH, faces};
use barnard::plan::{Options, Planned, Planner, Quality};
use barnard_gpu::{Gpu, Ordinates};
use glam::DVec3;
use test_device::device;

/// Three orders in dust with a hole, their powers, and the sum with half of the last once more.
fn swept(by: &dyn Sweeper, (harmonics, edges): (usize, [usize; 2]), k: &EightLanes, glows: bool) -> (Vec<(Powers, Powers)>, Moments) {
    let size = DVec3::new(1.0, 2.0, 1.5);
    let lattice = Lattice { dims: [21, 34, 27], bounds: Bounds { low: -0.5 * size, high: 0.5 * size } };
    let dust = Grid::sampled(lattice, |p| if p.length() < 0.3 { 0.0 } else { 3.0 + 40.0 * (7.0 * p.x).sin().max(0.0) + 5.0 * p.y * p.y });
    let cells = SweepCells::new(&dust, &[], 17);
    let count = cells.lattice.cells();
    // Numbers without order that any machine makes.
    let number = |i: usize, scale: f32| scale * ((i * 7919 % 1009) as f32 / 1009.0 - 0.3);
    let first = Moments {
        count: harmonics,
        data: (0..count * harmonics)
            .map(|i| std::array::from_fn(|t| number(i + 31 * t, if i % harmonics == 0 { 2.0 } else { 0.5 })))
            .collect(),
    };
    let scattering: Vec<EightLanes> =
        (0..harmonics).map(|h| std::array::from_fn(|t| 0.8 * (0.3 + 0.08 * t as f32).powi(h.isqrt() as i32))).collect();
    let glow: Vec<EightLanes> = (0..count).map(|i| [number(i, 1.0).max(0.0); WIDTH]).collect();
    let around = std::array::from_fn(|t| if glows { 0.1 * t as f32 } else { 0.0 });
    let faces = edges.map(faces);
    let transfer = Transfer {
        terms: WIDTH,
        cells: &cells,
        k,
        faces: faces.each_ref().map(|f| &f[..]),
        scattering: &scattering,
        glow: glows.then_some(&glow[..]),
        around: &around,
    };
    let mut orders = by.start(transfer, first).unwrap();
    let powers = (0..3).map(|_| orders.next(&Control::default()).unwrap()).collect();
    (powers, orders.sum(&[0.5; WIDTH]).unwrap())
}

/// The largest difference, in parts of the largest number of each term.
fn difference(ours: &Moments, theirs: &Moments) -> f32 {
    let largest = |t: usize| theirs.data.iter().fold(0.0f32, |most, m| most.max(m[t].abs()));
    let worst = |t: usize| ours.data.iter().zip(&theirs.data).fold(0.0f32, |most, (a, b)| most.max((a[t] - b[t]).abs())) / largest(t);
    (0..WIDTH).map(worst).fold(0.0, f32::max)
}

/// All degrees and numbers of directions, with gas and light from around and without: moments and powers agree to
/// single precision, and do not where the dust is another.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn orders_are_those_of_the_processor() {
    let gpu = device();
    let device = Ordinates::new(gpu);
    let k = [0.2, 0.5, 0.7, 1.0, 1.5, 2.0, 4.0, 9.0];
    for (kind, glows) in [((36, [6, 3]), true), ((9, [4, 2]), false), ((1, [3, 3]), true), ((4, [4, 3]), false)] {
        let ((powers, ours), (expected, theirs)) = (swept(&device, kind, &k, glows), swept(&Processor, kind, &k, glows));
        let wrong = difference(&ours, &theirs);
        assert!(wrong < 1e-5, "{kind:?}: {wrong:e}");
        for (first_moment, sum) in powers.iter().zip(&expected).map(|(ours, theirs)| ((ours.0, theirs.0), (ours.1, theirs.1))) {
            for t in 0..WIDTH {
                let close = |(a, b): (Powers, Powers)| (a[t] / b[t] - 1.0).abs() < 1e-5;
                assert!(close(first_moment) && close(sum), "{kind:?} {t}: {first_moment:?} {sum:?}");
            }
        }
        let denser = k.map(|k| 1.001 * k);
        assert!(difference(&swept(&device, kind, &denser, glows).1, &theirs) > 1e-5);
    }
}

/// Dense dust with a star and glowing gas in it, before light: 30 bounces.
fn text(albedo: &str) -> String {
    let around = r#"visible = false
[field.knot]
kind = "sphere"
radius = "0.3 pc"
[[emission]]
name = "line"
kind = "lines"
density = "knot"
scale = "4e-25 W/m3/sr"
lines = [{ wavelength = "540 nm", strength = 1 }]
[background]
kind = "blackbody"
temperature = "4000 K"
radiance = "5e-11 W/m2/sr/nm"
[method]
accuracy = 0.003
bake = 14
bounces = 30
"#;
    let dust = format!("albedo = {albedo}\nphase = {{ kind = \"henyey_greenstein\", g = 0.5 }}");
    small_cloud(&[("2 mag/pc", "4 /pc"), ("albedo = 0.6", &dust)]) + around
}

fn plan(text: String, sweeper: Option<Arc<dyn Sweeper>>) -> Planned {
    let scene = barnard_files::parse("test.toml", "test", text, &barnard_files::in_folder(".", DEFAULT_LIMIT)).unwrap();
    Planner::new(&Options::within(DEFAULT_LIMIT).with_sweeper(sweeper))
        .with_quality(Quality::Preview)
        .plan(&scene, None, &Control::default())
        .unwrap()
}

fn words(plan: &Planned) -> String {
    plan.expected_report().words().into_iter().find(|note| note.0 == "multiple scattering").unwrap().1
}

/// The source functions of two plans: the largest difference in parts of the largest.
fn apart(ours: &Planned, theirs: &Planned) -> f32 {
    let volumes = |plan: &Planned| {
        plan.scattered_field().as_ref().unwrap().volumes.iter().flat_map(|v| v.rows().collect::<Vec<_>>().concat()).collect::<Vec<f32>>()
    };
    let (ours, theirs) = (volumes(ours), volumes(theirs));
    assert_eq!(ours.len(), theirs.len());
    let largest = theirs.iter().fold(0.0f32, |most, x| most.max(*x));
    ours.iter().zip(&theirs).fold(0.0f32, |most, (a, b)| most.max((a - b).abs())) / largest
}

/// A plan whose light was swept on the device is that of the processor, and says where it was. It is that of a preview: its
/// few directions are swept on the device as many are, which [`orders_are_those_of_the_processor`] compares.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn plans_are_those_of_the_processor() {
    let gpu = device();
    let theirs = plan(text("0.8"), None);
    assert!(words(&theirs).contains("computed on cpu in"), "{}", words(&theirs));
    let ours = plan(text("0.8"), Some(Arc::new(Ordinates::new(gpu.clone()))));
    assert!(words(&ours).contains(&format!("computed on {} in", gpu.name())), "{}", words(&ours));
    let wrong = apart(&ours, &theirs);
    assert!(wrong > 0.0 && wrong < 1e-4, "{wrong:e}");
    assert!(apart(&ours, &plan(text("0.801"), None)) > 1e-4);
}
