//! Ionising light that is traced on the device, beside that of the processor.

#[path = "common/device.rs"]
mod test_device;

use barnard_gpu::{Gpu, IonisingRays};
use glam::DVec3;
use ionisation::atoms::BOLTZMANN_EV;
use ionisation::balance::{Gas, GasState};
use ionisation::benchmarks::BENCHMARKS;
use ionisation::cloud::{Cloud, Quantity, Settings, Star};
use ionisation::light::{IonisingLight, NODES, OWN_NODES, Photons};
use ionisation::processor::Processor;
use ionisation::tracer::{Light, RayTracer, Task};
use ionisation::voxel::{Voxel, absorbing};
use test_device::device;

const DIMS: [usize; 3] = [25, 22, 18];

/// A number between 0 and 1 without order, that any machine makes.
fn number(i: usize) -> f32 {
    (i * 7919 % 10_007) as f32 / 10_007.0
}

/// Nuclei of hydrogen of a cloud with a hole.
fn density() -> Vec<f32> {
    (0..DIMS.iter().product()).map(|i| if (300..700).contains(&(i % 2000)) { 0.0 } else { 40.0 + 100.0 * number(i) }).collect()
}

fn cloud(hydrogen: &[f32]) -> Cloud<'_> {
    let voxel = DVec3::new(0.1, 0.13, 0.08);
    let low = -0.5 * voxel * DVec3::from(DIMS.map(|n| n as f64));
    Cloud { dims: DIMS, low, voxel, hydrogen, abundances: BENCHMARKS[0].gas.abundances, dust_cm2: 5e-22 }
}

/// Light of black bodies with so many photons.
fn lights(stars: &[(f64, f64)]) -> Vec<IonisingLight> {
    let body = |temperature: f64, factor: f64| move |e: f64| factor * e * e / (e / (BOLTZMANN_EV * temperature)).exp_m1();
    let scaled = |(temperature, photons): &(f64, f64)| photons / IonisingLight::new(body(*temperature, 1.0)).ionising();
    let bodies: Vec<_> = stars.iter().map(|star| body(star.0, scaled(star))).collect();
    IonisingLight::several(&bodies.iter().map(|body| body as Photons).collect::<Vec<_>>())
}

/// Gas of all depths, lit and dark, more and less opaque than `factor` says.
fn voxels(hydrogen: &[f32], factor: f32) -> Vec<Voxel> {
    let difference = |(i, n): (usize, &f32)| {
        let (lit, absorbed) = (number(3 * i) > 0.2, (number(5 * i + 1) * 0.3).powi(2) + 1e-5);
        let opacity = std::array::from_fn(|node| if node < NODES { n * factor * 1e-19 * (1.0 + node as f32).recip() + 1e-20 } else { 0.0 });
        let (coefficients, rate, depth) =
            ([1e-13 * n * n; OWN_NODES], if lit { 3e-6 * (0.5 + number(i)) } else { 0.0 }, absorbing(absorbed));
        Voxel { opacity, dust: 5e-22 * n, emitted: coefficients, rate, absorbed, depth, ionised: 0.5 + 0.5 * number(2 * i) }
    };
    hydrogen.iter().enumerate().map(difference).collect()
}

/// Two turns of the light of three stars, one of them outside of the cloud: through clear space, and through gas.
fn turned(by: &dyn RayTracer, factor: f32) -> (Light, Light, Vec<f64>) {
    let hydrogen = density();
    let (cloud, lights) = (cloud(&hydrogen), lights(&[(40_000.0, 3e48), (35_000.0, 1e48), (50_000.0, 4e48)]));
    let places = [DVec3::new(0.02, 0.03, -0.01), DVec3::new(-0.9, 0.8, 0.4), DVec3::new(0.3, -0.2, 2.3)];
    let stars: Vec<Star> = places.into_iter().zip(&lights).map(|(place, light)| Star { place, light }).collect();
    let dark = std::array::from_fn(|node| if node < lights[0].energies_ev.len() { 5e-18 / (1.0 + node as f64) } else { 0.0 });
    let task = Task { cloud: &cloud, stars: &stars, used_up: 1e-5, dark };
    let (mut turns, mut light) = (by.start(task).unwrap(), Light::none(&task));
    turns.next(None, &mut light, &|_| true).unwrap();
    let clear = light.clone();
    let escaped = turns.next(Some(&voxels(&hydrogen, factor)), &mut light, &|_| true).unwrap();
    (clear, light, escaped)
}

/// Difference of numbers relative to their sum.
fn apart(a: &[f32], b: &[f32]) -> f64 {
    let sum = |value: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(a, b)| value(f64::from(*a), f64::from(*b))).sum::<f64>();
    sum(&|a, b| (a - b).abs()) / sum(&|a, _| a)
}

/// By star, how far ionisations are apart.
fn rates_apart(a: &Light, b: &Light) -> Vec<f64> {
    a.rates.iter().zip(&b.rates).map(|(a, b)| apart(a, b)).collect()
}

/// Light in voxels is unchanged, node by node and star by star, with the same behind it; gas that is two hundredths more opaque
/// would be seen.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn turns_are_those_of_the_processor() {
    let device = IonisingRays::new(device());
    let (ours, theirs, other) = (turned(&device, 1.0), turned(&Processor, 1.0), turned(&Processor, 1.02));
    let row = ours.0.flux.len() / ours.0.rates[0].len();
    for place in 0..row {
        let rates = |light: &Light| light.flux.iter().skip(place).step_by(row).copied().collect::<Vec<f32>>();
        for (ours, theirs) in [(&ours.0, &theirs.0), (&ours.1, &theirs.1)] {
            let apart = apart(&rates(theirs), &rates(ours));
            assert!(apart.is_nan() && rates(ours).iter().all(|v| *v == 0.0) || apart < 5e-5, "{place}: {apart:e}");
        }
    }
    let (clear, through) = (rates_apart(&theirs.0, &ours.0), rates_apart(&theirs.1, &ours.1));
    println!(
        "clear {clear:?}, through gas {through:?}, more opaque {:?}, escaped {:?} {:?}",
        rates_apart(&theirs.1, &other.1),
        ours.2,
        theirs.2
    );
    assert!(clear.iter().chain(&through).all(|apart| *apart < 1e-5));
    assert!(rates_apart(&theirs.1, &other.1).iter().all(|apart| *apart > 1e-3));
    assert!(ours.2.iter().zip(&theirs.2).all(|(ours, theirs)| (ours - theirs).abs() < 2e-5 && *theirs < 0.99));
}

/// A cloud that is solved with a device is that of the processor, and says who has traced.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn clouds_are_those_of_the_processor() {
    let gpu: Gpu = device();
    let device = IonisingRays::new(gpu.clone());
    let (hydrogen, lights) = (density(), lights(&[(40_000.0, 3e47), (35_000.0, 3e47)]));
    let cloud = cloud(&hydrogen);
    let places = [DVec3::new(0.3, 0.3, 0.1), DVec3::new(-0.5, -0.4, -0.2)];
    let stars: Vec<Star> = places.into_iter().zip(&lights).map(|(place, light)| Star { place, light }).collect();
    let ions = |gas: &Gas, state: &GasState| gas.hydrogen * state.fractions[0][1];
    let solved = |tracer: Option<&dyn RayTracer>| {
        cloud.ionised_by(tracer, &stars, &Settings::default(), &[Quantity { most: 200.0, value: &ions }], &|_, _| true).unwrap()
    };
    let (ours, theirs) = (solved(Some(&device)), solved(None));
    let apart = apart(&theirs.quantities[0], &ours.quantities[0]);
    println!("{}: {apart:.1e}, {} and {} passes", ours.by, ours.passes, theirs.passes);
    assert!(apart < 2e-3 && ours.by == gpu.name() && theirs.by == "cpu", "{apart:e} {}", ours.by);
}
