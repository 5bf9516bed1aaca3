//! Clouds in three dimensions beside the spherical one.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use ionisation::atoms::{Atoms, BOLTZMANN_EV, LineTable};
use ionisation::balance::{Accuracy, Diffuse, Gas, GasState};
use ionisation::benchmarks::BENCHMARKS;
use ionisation::cloud::{Cloud, Ionised, Quantity, Settings, Star};
use ionisation::error::IonisationError;
use ionisation::light::IonisingLight;
use ionisation::sphere::Sphere;

const PARSEC_CM: f64 = 3.085_677_581e18;

fn line(label: &'static str) -> impl Fn(&Gas, &GasState) -> f64 + Sync {
    let atoms = Atoms::get();
    let found = |table: &'static LineTable| table.lines.iter().find(|line| line.label == label).map(|line| (table, line));
    let (table, line) = found(&atoms.collisional).or_else(|| found(&atoms.recombination)).unwrap();
    move |gas, state| state.emission(gas, table, line)
}

/// A cube of so many voxels along its edge around the origin, of these densities and half an edge \[pc\].
fn cube(hydrogen: &[f32], edge: usize, half: f64) -> Cloud<'_> {
    Cloud {
        dims: [edge; 3],
        low: DVec3::splat(-half),
        voxel: DVec3::splat(2.0 * half / edge as f64),
        hydrogen,
        abundances: BENCHMARKS[0].gas.abundances,
        dust_cm2: 0.0,
    }
}

/// HII40 as a cube: lines and the front are those of the sphere, though a photon goes a quarter of a hundredth of a voxel in
/// neutral gas: a front below a voxel moves no line by more than two hundredths.
#[test]
fn hii40() {
    let light = IonisingLight::blackbody(40_000.0, 4.26e49);
    let sphere = Sphere::new(BENCHMARKS[0].gas, &light, Diffuse::Outward, [3e18, 3e19]);
    let (edge, half) = (64, 5.2);
    let (voxel, inner) = (2.0 * half / edge as f64, 3e18 / PARSEC_CM);
    let density = |x: usize, y: usize, z: usize| {
        // The hole's edge runs through voxels.
        let sub = |i: usize, at: usize| (at as f64 + ((i % 4) as f64 + 0.5) / 4.0) * voxel - half;
        let filled = (0..64).filter(|i| DVec3::new(sub(*i, x), sub(i / 4, y), sub(i / 16, z)).length() > inner).count();
        100.0 * filled as f32 / 64.0
    };
    let hydrogen: Vec<f32> = (0..edge).flat_map(|z| (0..edge).flat_map(move |y| (0..edge).map(move |x| density(x, y, z)))).collect();
    let cloud = cube(&hydrogen, edge, half);
    let labels = ["Ba4-2", "[OIII]5007", "[NII]6584", "[OII]3726", "[SII]6716", "[OI]6300"];
    let lines = labels.map(line);
    let electrons = |_: &Gas, state: &GasState| state.electrons;
    let mut quantities: Vec<Quantity> = lines.iter().map(|value| Quantity { most: 1e-18, value }).collect();
    quantities.push(Quantity { most: 130.0, value: &electrons });
    let found =
        cloud.ionised(&[Star { place: DVec3::ZERO, light: &light }], &Settings::default(), &quantities, &|_, _| true).unwrap().quantities;
    let all = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>() * (voxel * PARSEC_CM).powi(3);
    for (label, values) in labels.iter().zip(&found) {
        let truth = sphere.line(label);
        let part = all(values) / truth;
        println!("{label}: {part:.4}");
        assert!((part - 1.0).abs() < if *label == "[OI]6300" { 0.02 } else { 0.01 }, "{label}: {part}");
    }
    // No voxel is left out: beside the star's hole all are ionised that lie well within.
    let inside = |i: usize| {
        let p = DVec3::new((i % edge) as f64, (i / edge % edge) as f64, (i / edge / edge) as f64) * voxel + 0.5 * voxel - half;
        (inner + voxel..4.3).contains(&p.length())
    };
    let dark = (0..edge.pow(3)).filter(|i| inside(*i) && found[6][*i] < 90.0).count();
    assert!(dark == 0, "{dark}");
    // The ionised volume, as a radius: within a tenth of a voxel.
    let radius = (all(&found[6]) / sphere.sum(|s| s.electrons)).cbrt();
    println!("R {radius:.5}, a voxel is {:.3} of it", voxel / 4.73);
    assert!((radius - 1.0).abs() < 0.1 * voxel / 4.73, "{radius}");
}

/// Thin gas solved in blocks, compared with a solution in voxels: densities that vary by a factor of four, and a clump with its front
/// and its shadow.
#[test]
fn blocks_are_as_voxels() {
    let light = IonisingLight::blackbody(40_000.0, 3e49);
    let (edge, half) = (64, 1.0);
    let hydrogen: Vec<f32> = (0..edge * edge * edge)
        .map(|i| {
            let p = DVec3::new((i % edge) as f64, (i / edge % edge) as f64, (i / edge / edge) as f64) * (2.0 / edge as f64) - 1.0;
            let clump = 2e3 * (-((p - DVec3::new(0.2, 0.1, -0.1)).length_squared() / 0.02)).exp();
            (30.0 * (0.7 * ((9.0 * p.x).sin() * (7.0 * p.y).cos() + (11.0 * p.z).sin()) * 0.5).exp() + clump) as f32
        })
        .collect();
    let cloud = Cloud { dust_cm2: 5e-22, ..cube(&hydrogen, edge, half) };
    let lines = ["Ba4-2", "[OIII]5007", "[NII]6584", "[OII]3726", "[SII]6716"].map(line);
    let quantities: Vec<Quantity> = lines.iter().map(|value| Quantity { most: 1e-16, value }).collect();
    let star = Star { place: DVec3::new(0.3, -0.2, -3.5), light: &light };
    let solved = |settings: &Settings| cloud.ionised(&[star], settings, &quantities, &|_, _| true).unwrap();
    let blocks = solved(&Settings::default());
    // Blocks are longer than these steps may be.
    let accuracy = Accuracy { thickness: 0.015, ..Accuracy::FAST };
    let voxels = solved(&Settings { accuracy, ..Settings::default() });
    println!("{} steps, {} in voxels", blocks.steps, voxels.steps);
    assert!(blocks.steps < voxels.steps / 2);
    assert!((blocks.escaped[0] - voxels.escaped[0]).abs() < 3e-3 * (1.0 - voxels.escaped[0]), "{:?} {:?}", blocks.escaped, voxels.escaped);
    for (number, (found, truth)) in blocks.quantities.iter().zip(&voxels.quantities).enumerate() {
        let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
        let mean = sum(truth) / truth.len() as f64;
        let differences: Vec<f64> = found.iter().zip(truth).map(|(a, b)| f64::from(a - b)).collect();
        let deviation = (differences.iter().map(|d| d * d).sum::<f64>() / truth.iter().map(|v| f64::from(v * v)).sum::<f64>()).sqrt();
        let mut relative: Vec<f64> =
            differences.iter().zip(truth).filter(|(_, v)| f64::from(**v) > 0.1 * mean).map(|(d, v)| (d / f64::from(*v)).abs()).collect();
        relative.sort_by(f64::total_cmp);
        let (total, most) = (sum(found) / sum(truth) - 1.0, relative[relative.len() * 99 / 100]);
        println!("{number}: total {total:.2e}, root mean square {deviation:.2e}, 99 % of voxels {most:.2e}");
        // Voxels with a front differ by a tenth, as they do beside voxels of half the size.
        assert!(total.abs() < 0.01 && deviation < 0.06, "{number}: {total} {deviation}");
        assert!(number > 0 || most < 0.04, "{most}");
    }
}

/// Sums do not depend on how many threads there are; a wall throws a shadow whose edge is sharp, and light beside it is as
/// before, be it that of one star or of two at one place.
#[test]
fn shadows_are_sharp() {
    let light = IonisingLight::blackbody(40_000.0, 1e50);
    let half_light = light.clone().scaled(0.5);
    let (edge, half) = (40, 2.0);
    let hydrogen: Vec<f32> = (0..edge * edge * edge)
        .map(|i| {
            let (x, z) = (i % edge, i / (edge * edge));
            // A wall right of the middle, between the star and most of the cloud.
            if (12..14).contains(&z) && x >= edge / 2 { 3e4 } else { 10.0 }
        })
        .collect();
    let cloud = cube(&hydrogen, edge, half);
    let electrons = |_: &Gas, state: &GasState| state.electrons;
    let place = DVec3::new(0.0, 0.0, -3.0);
    let (whole, part) = (Star { place, light: &light }, Star { place, light: &half_light });
    for stars in [&[whole][..], &[part, part]] {
        let found = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let asked = [Quantity { most: 4e4, value: &electrons }];
            pool.install(|| cloud.ionised(stars, &Settings::default(), &asked, &|_, _| true).unwrap().quantities)
        };
        let one = found(1);
        assert!(one == found(3));
        let at = |x: usize, z: usize| one[0][(z * edge + edge / 2) * edge + x];
        for z in 16..edge {
            // The wall's edge is at x = 0, above the star: so is the shadow's.
            let row: Vec<f32> = [0, 1, 2, 3].map(|i| at(edge / 2 - 2 + i, z)).into();
            assert!(row[0] > 9.0 && row[1] > 9.0 && row[2] < 1.0 && row[3] < 1e-2, "{} stars, {z}: {row:?}", stars.len());
        }
        // Where the star is beside the middle of the face, and far away, as much light comes to all of it.
        let face: Vec<f32> =
            (1..edge / 2 - 2).flat_map(|x| (1..edge - 1).map(move |y| (x, y))).map(|(x, y)| one[0][y * edge + x]).collect();
        assert!(
            face.iter().all(|electrons| *electrons > 9.0),
            "{} stars: {:?}",
            stars.len(),
            face.iter().copied().fold(f32::MAX, f32::min)
        );
    }
}

/// A star without light, a cloud without gas, and one that light leaves.
#[test]
fn clouds_of_all_kinds() {
    let solved = |hydrogen: f32, light: &IonisingLight, star: DVec3| {
        let hydrogen = vec![hydrogen; 512];
        let cloud = Cloud { dust_cm2: 1e-21, ..cube(&hydrogen, 8, 1.0) };
        let part = |_: &Gas, state: &GasState| state.fractions[0][1];
        let star = Star { place: star, light };
        let found = cloud.ionised(&[star], &Settings::default(), &[Quantity { most: 1.0, value: &part }], &|_, _| true).unwrap().quantities;
        assert!(found[0].iter().all(|v| (0.0..=1.0001).contains(v)), "{hydrogen:?}");
        found[0].iter().sum::<f32>() / 512.0
    };
    let light = IonisingLight::blackbody(40_000.0, 1e49);
    for star in [DVec3::ZERO, DVec3::splat(0.25), DVec3::new(1.0, 1.0, 1.0), DVec3::new(9.0, 0.1, 0.0)] {
        assert_eq!(solved(0.0, &light, star), 0.0);
        assert!(solved(1.0, &light, star) > 0.99, "{star}");
        assert!(solved(1e6, &light, star) < 0.05, "{star}");
        assert_eq!(solved(1.0, &light.clone().scaled(0.0), star), 0.0);
    }
    // A cool star ionises what its few photons can: recombinations, 2.5e-12 cm3/s and more below 600 K, are not more than they.
    let faint = f64::from(solved(1.0, &IonisingLight::blackbody(3000.0, 1e40), DVec3::ZERO));
    assert!(faint > 0.0 && faint < (1e40 / 2.5e-12 / (2.0 * PARSEC_CM).powi(3)).sqrt(), "{faint:e}");
    // Light that has no ionising photon at all.
    assert!(solved(1.0, &IonisingLight::new(|_| 0.0), DVec3::ZERO) == 0.0);
}

/// Two stars at one place are one of twice the light; two that are far apart have each its own sphere; and where both shine
/// the order in which they are told is none. One star's beams solve the gas within voxels, several stars' light goes through
/// voxels as a whole: on spheres of 16 voxels in radius both agree to half a percent, on those of nine to one and a half.
#[test]
#[ignore = "long"]
fn several_stars() {
    let edge = 64;
    let hydrogen = vec![200.0; edge * edge * edge];
    let cloud = cube(&hydrogen, edge, 2.0);
    let photons = |temperature: f64, factor: f64| move |e: f64| factor * e * e / (e / (BOLTZMANN_EV * temperature)).exp_m1();
    let ions = |gas: &Gas, state: &GasState| gas.hydrogen * state.fractions[0][1];
    let solved =
        |stars: &[Star]| cloud.ionised(stars, &Settings::default(), &[Quantity { most: 250.0, value: &ions }], &|_, _| true).unwrap();
    let all = |found: &Ionised| found.quantities[0].iter().map(|n| f64::from(*n)).sum::<f64>();
    // As many photons as fill a third of the cloud.
    let unit = 6e47 / IonisingLight::new(photons(40_000.0, 1.0)).ionising();
    let one = IonisingLight::new(photons(40_000.0, 2.0 * unit));
    let halves = IonisingLight::several(&[&photons(40_000.0, unit), &photons(40_000.0, unit)]);
    let place = DVec3::new(0.1, 0.05, -0.2);
    let alone = solved(&[Star { place, light: &one }]);
    let both = solved(&[Star { place, light: &halves[0] }, Star { place, light: &halves[1] }]);
    println!("{} passes, {:.1e}, {}", both.passes, both.change, all(&both) / all(&alone));
    assert!(both.passes > 1 && both.change <= Settings::default().change && (all(&both) / all(&alone) - 1.0).abs() < 5e-3);
    let places = [DVec3::splat(-1.2), DVec3::splat(1.2)];
    let light = IonisingLight::several(&[&photons(40_000.0, 0.2 * unit), &photons(30_000.0, 0.3 * unit)]);
    let stars: [Star; 2] = std::array::from_fn(|i| Star { place: places[i], light: &light[i] });
    let apart = solved(&stars);
    let sum: f64 = stars.iter().map(|star| all(&solved(&[*star]))).sum();
    println!("apart {} passes, {}", apart.passes, all(&apart) / sum);
    assert!((all(&apart) / sum - 1.0).abs() < 1.5e-2, "{}", all(&apart) / sum);
    // Near each other both fill one cavity that either alone could not.
    let near: [Star; 2] = std::array::from_fn(|i| Star { place: 0.3 * places[i], light: &halves[i] });
    let (found, turned) = (solved(&near), solved(&[near[1], near[0]]));
    println!("{} passes, {:.1e}, {} {}", found.passes, found.change, all(&found) / all(&turned), all(&found) / all(&alone));
    assert!((all(&found) / all(&turned) - 1.0).abs() < 2e-3);
    assert!((all(&found) / all(&alone) - 1.0).abs() < 2e-2, "{}", all(&found) / all(&alone));
}

/// Whoever waits hears how much is done, never less than before and all of it at the end, and can stop it; edges that are odd
/// are no matter to stars that begin on half as many voxels.
#[test]
fn work_is_heard_of_and_stopped() {
    let dims = [25, 27, 31];
    let hydrogen = vec![200.0; dims.iter().product()];
    let cloud = Cloud { dims, ..cube(&hydrogen, 1, 1.0) };
    let cloud = Cloud { voxel: DVec3::splat(0.13), low: DVec3::splat(-1.7), ..cloud };
    let photons = |e: f64| 2e46 * e * e / (e / (BOLTZMANN_EV * 40_000.0)).exp_m1();
    let scale = 3e47 / IonisingLight::new(photons).ionising();
    let halves: Vec<IonisingLight> =
        IonisingLight::several(&[&photons, &photons]).into_iter().map(|light| light.scaled(0.5 * scale)).collect();
    let one = IonisingLight::new(photons).scaled(scale);
    let pair: Vec<Star> = halves.iter().map(|light| Star { place: DVec3::ZERO, light }).collect();
    let ions = |gas: &Gas, state: &GasState| gas.hydrogen * state.fractions[0][1];
    let solved = |stars: &[Star], heard: &(dyn Fn(u64, u64) -> bool + Sync)| {
        cloud.ionised(stars, &Settings::default(), &[Quantity { most: 250.0, value: &ions }], heard)
    };
    let heard = Mutex::new(Vec::new());
    let both = solved(&pair, &|done, all| heard.lock().map(|mut heard| heard.push((done, all))).is_ok()).unwrap();
    let heard = heard.into_inner().unwrap();
    assert!(heard.len() > 10 && heard.iter().all(|(done, all)| done <= all && *all == heard[0].1), "{heard:?}");
    assert_eq!(heard.last().map(|(done, all)| done == all), Some(true));
    let all = |found: &Ionised| found.quantities[0].iter().map(|n| f64::from(*n)).sum::<f64>();
    let alone = solved(&[Star { place: DVec3::ZERO, light: &one }], &|_, _| true).unwrap();
    // On a sphere of so few voxels.
    assert!((all(&both) / all(&alone) - 1.0).abs() < 3e-2 && all(&alone) > 0.0, "{} {}", all(&both), all(&alone));
    for stars in [&pair[..], &pair[..1]] {
        let asked = AtomicU64::new(0);
        let stopped = solved(stars, &|_, _| asked.fetch_add(1, Ordering::Relaxed) < 3);
        assert!(matches!(stopped, Err(IonisationError::Stopped)));
    }
}

/// A change to what can be solved.
type Change<'a> = &'a dyn Fn(&mut Cloud, &mut Vec<Star>, &mut Settings);

/// What cannot be solved is refused with words; what leaves the cloud is told.
#[test]
fn bad_clouds_are_refused() {
    let light = IonisingLight::blackbody(40_000.0, 1e49);
    // Whatever lives as long as any star.
    let other: &'static IonisingLight = Box::leak(Box::new(IonisingLight::blackbody(30_000.0, 1e48)));
    let hydrogen = vec![10.0; 64];
    let changed = |change: Change| {
        let mut cloud = cube(&hydrogen, 4, 1.0);
        let (mut stars, mut settings) = (vec![Star { place: DVec3::ZERO, light: &light }], Settings::default());
        change(&mut cloud, &mut stars, &mut settings);
        cloud.ionised(&stars, &settings, &[], &|_, _| true).map_err(|e| e.to_string())
    };
    // A thin cloud that most of the light leaves, and a star outside that sends next to nothing into it.
    let thin = changed(&|_, _, _| ()).unwrap();
    assert!(thin.escaped[0] > 0.9 && thin.escaped[0] < 1.0 && thin.unsettled == 0 && thin.steps > 0, "{thin:?}");
    let far = changed(&|_, stars, _| stars[0].place.x = 30.0).unwrap();
    assert!(far.escaped[0] > 0.99);
    assert!(changed(&|_, stars, _| stars.clear()).unwrap().escaped.is_empty());
    let nan = [f32::NAN; 64];
    let changes: [(Change, &str); 8] = [
        (&|cloud, _, _| cloud.dims = [4, 4, 5], "64 densities for 4 x 4 x 5"),
        (&|cloud, _, _| cloud.voxel.y = 0.0, "above zero"),
        (&|cloud, _, _| cloud.abundances[4] = 3.0, "abundance of O"),
        (&|cloud, _, _| cloud.abundances[0] = 0.7, "1 for hydrogen"),
        (&|cloud, _, _| cloud.dust_cm2 = -1.0, "dust is -1 cm2"),
        (&|_, stars, _| stars[0].place.z = f64::NAN, "position of star 0"),
        (&|_, stars, _| stars.push(Star { place: DVec3::ZERO, light: other }), "different energy nodes"),
        (&|_, _, settings| settings.memory_limit = 100, "limit is 100"),
    ];
    for (change, word) in changes {
        let message = changed(change).unwrap_err();
        assert!(message.contains(word), "{message}");
    }
    let cloud = cube(&nan, 4, 1.0);
    assert!(cloud.ionised(&[], &Settings::default(), &[], &|_, _| true).unwrap_err().to_string().contains("voxel [0, 0, 0] is NaN"));
}

/// Light of several stars in voxels that are no cubes, with a star near a face of its own: as many ions as one star's beams make.
/// Light beyond all reason and voxels of all sizes give numbers, whatever they are.
#[test]
fn several_stars_in_voxels_of_all_shapes() {
    let photons = |factor: f64| move |e: f64| factor * e * e / (e / (BOLTZMANN_EV * 40_000.0)).exp_m1();
    let ions = |gas: &Gas, state: &GasState| gas.hydrogen * state.fractions[0][1];
    let solved = |cloud: &Cloud, place: DVec3, all: f64| {
        let unit = all / IonisingLight::new(photons(1.0)).ionising();
        let one = IonisingLight::new(photons(unit));
        let halves = IonisingLight::several(&[&photons(0.5 * unit), &photons(0.5 * unit)]);
        let solved = |lights: &[&IonisingLight]| {
            let stars: Vec<Star> = lights.iter().map(|light| Star { place, light }).collect();
            let found = cloud.ionised(&stars, &Settings::default(), &[Quantity { most: 250.0, value: &ions }], &|_, _| true).unwrap();
            found.quantities[0].iter().map(|n| f64::from(*n)).sum::<f64>()
        };
        (solved(&[&halves[0], &halves[1]]), solved(&[&one]))
    };
    for (voxel, place) in [
        (DVec3::new(0.05, 0.05, 0.2), DVec3::new(0.012, 0.013, 0.09)),
        (DVec3::new(0.2, 0.05, 0.05), DVec3::new(0.198, 0.02, 0.021)),
        (DVec3::splat(0.07), DVec3::new(0.001, 0.03, 0.036)),
    ] {
        let dims = <[f64; 3]>::from(3.2 / voxel).map(|n| n.ceil() as usize);
        let hydrogen = vec![200.0; dims.iter().product()];
        let low = -0.5 * voxel * DVec3::from(dims.map(|n| (n - n % 2) as f64));
        let cloud = Cloud { dims, low, voxel, ..cube(&hydrogen, 1, 1.0) };
        let (several, one) = solved(&cloud, place, 4e47);
        println!("{voxel}: {}", several / one);
        // As on a sphere of so few voxels in radius: three to ten.
        assert!((several / one - 1.0).abs() < 5e-2 && one > 0.0, "{voxel}: {}", several / one);
    }
    let hydrogen = vec![200.0; 16 * 16 * 16];
    for (edge, all) in [(0.1, 1e58), (1e-8, 1e49), (1e6, 1e32), (1e6, 1e60)] {
        let cloud = Cloud { dims: [16; 3], low: DVec3::splat(-8.0 * edge), voxel: DVec3::splat(edge), ..cube(&hydrogen, 1, 1.0) };
        let (several, one) = solved(&cloud, DVec3::splat(0.3 * edge), all);
        assert!(several.is_finite() && one.is_finite(), "{edge} {all:e}: {several} {one}");
        // A star that is farther away than anybody could follow.
        let (several, _) = solved(&cloud, DVec3::new(3e10 * edge, 0.0, 0.0), all);
        assert!(several == 0.0, "{several}");
    }
}
