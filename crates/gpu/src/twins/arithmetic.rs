//! Arithmetic, phases and forms of both.

use super::agree;
use super::plan;
use crate::forms::FORMS;
use crate::layout::ShaderLayout;
use crate::layout::quads;
use crate::test_device::device;
use barnard::field::mean_share;
use barnard::packet;
use barnard::packet::LANES;
use barnard::packet::scaled_exp_integrals;
use barnard::plan::PhaseEntry;
use barnard::plan::PhaseTable;
use barnard::plan::near;
use barnard::plan::segment;
use glam::DVec3;
use spectra::quadrature::integrate;
use spectra::rule::DepthSpan;

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn arithmetic() {
    let gpu = device();
    let plan = &plan("");
    agree(&gpu, plan, "y[0] = sinhc(x[0]);", &[(0.0, 1.0)], 1e-6, |x| vec![packet::sinhc(x[0] as f32).into()]);
    agree(&gpu, plan, "y[0] = mean_transmittance(x[0], x[1]);", &[(0.0, 6.0), (-5.0, 5.0)], 2e-6, |x| {
        // The half difference is no larger than the middle where depths are not negative; the arithmetic does not mind.
        let (from, to) = (x[0] - x[1], x[0] + x[1]);
        vec![spectra::rule::mean_transmittance(from, to)]
    });
    agree(&gpu, plan, "let c = cell(x[0], 7.0); y[0] = c.x + c.y; y[1] = c.x;", &[(-2.0, 9.0)], 1e-6, |x| {
        let packet::RowPlace { cell, fraction } = packet::place(x[0] as f32, 7);
        vec![f64::from(cell as f32 + fraction), f64::from(cell)]
    });
    agree(&gpu, plan, "y[0] = ln(x[0]) / 10.0;", &[(1e-6, 90.0)], 1e-6, |x| vec![x[0].ln() / 10.0]);
    agree(
        &gpu,
        plan,
        "let p = x[0] * x[0] + x[2] * (x[2] + x[1]); y[0] = 0.01 * mean_inverse_square(pow(x[0] * x[1] / p, 2.0), 1.0 / p);",
        &[(0.4, 2.0), (0.01, 0.1), (0.1, 2.0)],
        2e-7,
        |x| vec![0.01 * segment::mean_inverse_square(x[0], x[2], x[2] + x[1])],
    );
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn exponential_integrals() {
    let gpu = device();
    let plan = &plan("name = \"analytic\"\ndegree = 2\naccuracy = 0.02");
    let body = "let e = scaled_exp_integrals(x[0], 7u); for (var n = 0u; n < 7u; n++) { y[n] = e[n]; }";
    for range in [(1e-4, 1.0), (0.9, 4.0), (3.0, 60.0)] {
        agree(&gpu, plan, body, &[range], 1e-5, |x| {
            let mut out = [[0.0; LANES]; 7];
            scaled_exp_integrals(&[x[0] as f32; LANES], &mut out);
            out.iter().map(|e| f64::from(e[0])).collect()
        });
    }
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn phases_and_parts() {
    let gpu = device();
    let plan = &plan("");
    let entries = plan.spectral().phase.as_ref().unwrap().entries;
    let body = "let e = phase_entry(cos(x[0]), sin(x[0]) * sin(x[0])); y[0] = (e.x + e.y) / 1000.0;";
    agree(&gpu, plan, body, &[(0.0, std::f64::consts::PI)], 1e-6, |x| {
        let PhaseEntry { entry, fraction } = PhaseTable::entry(entries, x[0].cos() as f32, x[0].sin().powi(2) as f32);
        vec![f64::from(entry as f32 + fraction) / 1000.0]
    });
    let angle = plan.spectral().phase_angle;
    agree(&gpu, plan, "y[0] = f32(phases(x[0])) / 10.0;", &[(0.0, 1.0)], 1e-6, |x| vec![near::phases(x[0], angle) as f64 / 10.0]);
    let voxel = plan.space().voxel_pc();
    agree(&gpu, plan, "y[0] = parts(x[0], x[1], x[2], frame.steps.z);", &[(0.0, 1.0), (-1.0, 1.0), (0.1, 3.0)], 1e-6, |x| {
        vec![near::parts(x[0], x[1], x[2], voxel) as f64]
    });
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn star_depths_marched_again() {
    let gpu = device();
    let plan = &plan("name = \"double_integration\"");
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    let star = plan.space().stars[1];
    let body = "y[0] = depth_again(constants[STARS + 1u].xyz, vec3f(x[0], x[1], x[2]));";
    agree(&gpu, plan, body, &[(-1.0, 1.0); 3], 5e-3, |x| vec![plan.space().depth(star, middle + DVec3::new(x[0], x[1], x[2]))]);
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn segments_of_two_samples() {
    let gpu = device();
    let plan = &plan("");
    let positive = [(0.1, 2.0); 6];
    agree(&gpu, plan, "y[0] = twice_the_mean(x[0], x[1], x[2]);", &positive[..3], 1e-6, |x| vec![0.5 * (x[0] + x[2]) + x[1]]);
    agree(&gpu, plan, "y[0] = mean_share(x[0], x[1]);", &[(-2.0, 3.0); 2], 2e-6, |x| vec![mean_share(x[0], x[1])]);
    agree(&gpu, plan, "y[0] = mean_share(x[0], x[0] + 0.005);", &[(-0.2, 1.2)], 2e-3, |x| vec![mean_share(x[0], x[0] + 0.005)]);
    let body = "let glow = twice_the_glow(vec3f(x[0], x[1], x[2]), vec2f(x[3], x[4])); y[0] = glow.x; y[1] = glow.y;";
    agree(&gpu, plan, body, &positive[..5], 1e-6, |x| {
        let early = 0.5 * x[3] * (x[0] + x[1]);
        vec![early + 0.5 * x[4] * (x[1] + x[2]), early]
    });
    // Linear between three values at 0, 1 and 2.
    let linear = |[a, b, c]: [f64; 3], t: f64| if t < 1.0 { a + t * (b - a) } else { b + (t - 1.0) * (c - b) };
    let integral = |f: &dyn Fn(f64) -> f64| integrate(f, 0.0, 1.0, 1e-12) + integrate(f, 1.0, 2.0, 1e-12);
    let body = "y[0] = mean_over_dust(vec3f(x[0], x[1], x[2]), vec3f(x[3], x[4], x[5]));";
    agree(&gpu, plan, body, &positive, 1e-6, |x| {
        let (sigma, value) = ([x[0], x[1], x[2]], [x[3], x[4], x[5]]);
        vec![integral(&|t| linear(sigma, t) * linear(value, t)) / integral(&|t| linear(sigma, t))]
    });
    let sample = |name: &str, dust: usize, gas: usize| {
        format!(
            "var {name}: array<vec4f, QUADS>; {name}[DUST_QUAD][DUST_LANE] = x[{dust}]; {name}[EMITTER_SLOTS[0] / 4u][EMITTER_SLOTS[0] % 4u] = x[{gas}];"
        )
    };
    let body = format!(
        "{} {} {} y[0] = mean_depth_of_gas(StepSpan(0.0, x[6]), 0.25 * x[6] * (x[0] + 2.0 * x[1] + x[2]), &before, &middle, &after);",
        sample("before", 0, 3),
        sample("middle", 1, 4),
        sample("after", 2, 5)
    );
    let ranges = [positive[0], positive[1], positive[2], positive[3], positive[4], positive[5], (0.5, 1.5)];
    agree(&gpu, plan, &body, &ranges, 1e-6, |x| {
        // What each half sends stands behind half of its own depth.
        let (first, second) = (0.25 * x[6] * (x[0] + x[1]), 0.25 * x[6] * (x[1] + x[2]));
        let (early, late) = (x[3] + x[4], x[4] + x[5]);
        vec![(early * 0.5 * first + late * (first + 0.5 * second)) / (early + late)]
    });
}

/// ⟨F⟩ of every form as its rule has it in f64, for a star and for gas, which stand behind each other in all tables.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn forms() {
    let gpu = device();
    let mut compared = Vec::new();
    for (method, tolerance) in [
        ("name = \"band_quadrature\"", 3e-6),
        ("name = \"common_nodes\"", 1e-5),
        ("name = \"midpoint\"\ncount = 30", 3e-6),
        // Between the entries of a table that is read to 1e-4 of F, the middle and the whole of a segment are not quite
        // the same.
        ("name = \"lookup\"", 1e-5),
        ("name = \"projection\"", 2e-4),
        ("name = \"preintegrated\"", 1e-5),
        ("name = \"analytic\"\ndegree = 2\naccuracy = 0.02", 2e-3),
    ] {
        let plan = &plan(method);
        compared.push(ShaderLayout::new(plan, quads(plan, 0), false).unwrap().shape.form.name);
        let weights = barnard::plan::Weights::new(plan);
        for (row, light) in [(1, weights.scattered[1].light), (2, weights.emitted[0].light)] {
            // Weights are tiny numbers in their own units: each band in parts of its F(0).
            let total = |band: usize| plan.spectral().bands[band].rule.evaluate(light, 0.0);
            let totals = [total(0), total(1)];
            let body = format!(
                "var state: State; accumulate(&state, {row}u, vec2f(0.0), 1.0, x[0], x[1]); y[0] = band_of(&state, 0u) / {:e}; y[1] = band_of(&state, 1u) / {:e};",
                totals[0] as f32, totals[1] as f32
            );
            agree(&gpu, plan, &body, &[(0.5, plan.spectral().depth.min(8.0) - 0.5), (-0.45, 0.45)], tolerance, |x| {
                let band_sum = |band: usize| {
                    plan.spectral().bands[band].rule.mean(light, DepthSpan { from: x[0] - x[1], to: x[0] + x[1] }) / totals[band]
                };
                vec![band_sum(0), band_sum(1)]
            });
            // Thick segments, which begin at x[0].
            let body = body.replace("1.0, x[0], x[1]", "1.0, x[0] + x[1], x[1]");
            agree(&gpu, plan, &body, &[(0.01, 2.0), (0.1, 2.9)], tolerance, |x| {
                let band_sum = |band: usize| {
                    plan.spectral().bands[band].rule.mean(light, DepthSpan { from: x[0], to: x[0] + 2.0 * x[1] }) / totals[band]
                };
                vec![band_sum(0), band_sum(1)]
            });
        }
    }
    assert!(FORMS.iter().all(|form| compared.contains(&form.name)), "{compared:?}");
}
