//! Time for a cube of the given number of voxels per edge, with starlight traced on the device, and on the processor.
//!
//! `cargo run --release -p barnard-gpu --example ionising_rays -- 64 8`

use std::time::Instant;

use barnard_gpu::{Gpu, IonisingRays};
use glam::DVec3;
use ionisation::balance::{Gas, GasState};
use ionisation::benchmarks::BENCHMARKS;
use ionisation::cloud::{Cloud, Quantity, Settings, Star};
use ionisation::light::IonisingLight;
use ionisation::processor::Processor;
use ionisation::tracer::{Light, RayTracer, Task};

fn main() {
    let number = |place: usize, default: usize| std::env::args().nth(place).and_then(|text| text.parse().ok()).unwrap_or(default);
    let (edge, count) = (number(1, 64), number(2, 8));
    let half = 5.2;
    let voxel = 2.0 * half / edge as f64;
    let density = |i: usize| {
        let p = DVec3::new((i % edge) as f64, (i / edge % edge) as f64, (i / edge / edge) as f64) * voxel;
        (100.0 * (1.0 + 0.8 * (2.1 * p.x).sin() * (1.7 * p.y).cos() * (1.3 * p.z + 0.4).sin())) as f32
    };
    let hydrogen: Vec<f32> = (0..edge.pow(3)).map(density).collect();
    let abundances = BENCHMARKS[0].gas.abundances;
    let (low, voxel) = (DVec3::splat(-half), DVec3::splat(voxel));
    let cloud = Cloud { dims: [edge; 3], low, voxel, hydrogen: &hydrogen, abundances, dust_cm2: 0.0 };
    let light = IonisingLight::blackbody(40_000.0, 4.26e49 / count as f64);
    // Along a spiral, the first of them in the middle.
    let place = |i: usize| DVec3::new((2.4 * i as f64).cos(), (2.4 * i as f64).sin(), 0.3) * 0.8 * (i as f64).sqrt();
    let stars: Vec<Star> = (0..count).map(|i| Star { place: place(i), light: &light }).collect();
    let gpu = Gpu::open().expect("a graphics adapter");
    let device = IonisingRays::new(gpu);
    let task = Task { cloud: &cloud, stars: &stars, used_up: 1e-5, dark: [0.0; ionisation::light::NODES] };
    for tracer in [&device as &dyn RayTracer, &Processor] {
        let mut turns = tracer.start(task).expect("room");
        let mut all = Light::none(&task);
        let mut seconds = Vec::new();
        for _ in 0..3 {
            let since = Instant::now();
            turns.next(None, &mut all, &|_| true).expect("a turn");
            seconds.push(since.elapsed().as_secs_f64());
        }
        println!("{}: a turn of {count} stars through {edge}^3 clear voxels {seconds:.3?} s", tracer.name());
        let electrons = |_: &Gas, state: &GasState| state.electrons;
        let since = Instant::now();
        let quantities = [Quantity { most: 300.0, value: &electrons }];
        let found = cloud.ionised_by(Some(tracer), &stars, &Settings::default(), &quantities, &|_, _| true).expect("a cloud");
        let sum: f64 = found.quantities[0].iter().map(|n| f64::from(*n)).sum();
        println!("{}: {edge}^3, {count} stars in {:.2?}, {} passes, electrons {sum:.4e}", found.by, since.elapsed(), found.passes);
    }
}
