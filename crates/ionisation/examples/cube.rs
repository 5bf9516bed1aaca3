//! Time for a cube of the given numbers of voxels per edge and of stars: a clumpy cloud.
//!
//! `cargo run --release -p barnard-ionisation --example cube -- 128 8`

use glam::DVec3;
use ionisation::balance::{Gas, GasState};
use ionisation::benchmarks::BENCHMARKS;
use ionisation::cloud::{Cloud, Quantity, Settings, Star};
use ionisation::light::IonisingLight;

fn main() {
    let number = |place: usize, default: usize| std::env::args().nth(place).and_then(|text| text.parse().ok()).unwrap_or(default);
    let (edge, count) = (number(1, 64), number(2, 1));
    let half = 5.2;
    let voxel = 2.0 * half / edge as f64;
    let hydrogen: Vec<f32> = (0..edge * edge * edge)
        .map(|i| {
            let p = DVec3::new((i % edge) as f64, (i / edge % edge) as f64, (i / edge / edge) as f64) * voxel;
            (100.0 * (1.0 + 0.8 * (2.1 * p.x).sin() * (1.7 * p.y).cos() * (1.3 * p.z + 0.4).sin())) as f32
        })
        .collect();
    let abundances = BENCHMARKS[0].gas.abundances;
    let cloud =
        Cloud { dims: [edge; 3], low: DVec3::splat(-half), voxel: DVec3::splat(voxel), hydrogen: &hydrogen, abundances, dust_cm2: 0.0 };
    let light = IonisingLight::blackbody(40_000.0, 4.26e49 / count as f64);
    // Along a spiral, the first of them in the middle.
    let place = |i: usize| DVec3::new((2.4 * i as f64).cos(), (2.4 * i as f64).sin(), 0.3) * 0.8 * (i as f64).sqrt();
    let stars: Vec<Star> = (0..count).map(|i| Star { place: place(i), light: &light }).collect();
    let electrons = |_: &Gas, state: &GasState| state.electrons;
    let warm = |_: &Gas, state: &GasState| state.temperature;
    for _ in 0..2 {
        let since = std::time::Instant::now();
        let quantities = [Quantity { most: 300.0, value: &electrons }, Quantity { most: 1e5, value: &warm }];
        let found = cloud.ionised(&stars, &Settings::default(), &quantities, &|_, _| true).expect("a cloud");
        let ionised = found.quantities[0].iter().filter(|v| **v > 1.0).count();
        println!("{edge}^3, {count} stars: {:.2?}, {} passes, {ionised} voxels ionised", since.elapsed(), found.passes);
    }
}
