//! Functions of the shaders beside their twins in Rust, one by one, on the numbers of a real plan.

use barnard::camera::{Camera, Stereo};
use barnard::control::Control;
use barnard::geometry::Bounds;
use barnard::packet::{self, LANES, scaled_exp_integrals};
use barnard::plan::{PhaseEntry, PhaseTable, Planned, near, segment};
use glam::DVec3;
use spectra::quadrature::integrate;
use spectra::rule::DepthSpan;

use crate::Gpu;
use crate::fixtures::{parsed, plan_of, scene, text};
use crate::forms::FORMS;
use crate::frame::{Pass, Patience, Rows, Strip};
use crate::layout::{Layout, quads};
use crate::resources::{Volumes, constants};
use crate::shader::source;
use crate::shader_constants::Pauses;
use crate::test_device::device;

/// Numbers in and out of a function.
const ARGUMENTS: usize = 8;
type Numbers = [f32; ARGUMENTS];

/// A cloud of dust with two stars, and gas at its border, by `method`.
fn plan(method: &str) -> Planned {
    plan_of(&scene(24, method))
}

/// Copy of the plan seen by another camera.
fn seen_from(plan: &Planned, camera: Camera) -> Planned {
    let mut plan = plan.clone();
    plan.look_from(camera, &Control::default()).unwrap();
    plan
}

/// The layouts of the march's own bindings with those of what is asked and told behind, and of so many textures.
fn bind_group_layouts(gpu: &Gpu, quads: usize) -> [wgpu::BindGroupLayout; 2] {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let bound = |(i, ty): (usize, wgpu::BindingType)| wgpu::BindGroupLayoutEntry {
        binding: i as u32,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let storage = |read_only| buffer(wgpu::BufferBindingType::Storage { read_only });
    let uniform = || [buffer(wgpu::BufferBindingType::Uniform)];
    let kinds = uniform().into_iter().chain([true, true, true, false, false, false].map(storage)).chain(uniform());
    let kinds = kinds.chain([true, false].map(storage));
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D3,
        multisampled: false,
    };
    let of_textures = vec![texture; quads].into_iter().chain([wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)]);
    let group_layout = |kinds: Vec<wgpu::BindingType>| {
        let entries: Vec<_> = kinds.into_iter().enumerate().map(bound).collect();
        gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
    };
    [group_layout(kinds.collect()), group_layout(of_textures.collect())]
}

/// The numbers that `body` makes of each x on the device: it reads `x` and writes `y`.
fn evaluated(gpu: &Gpu, plan: &Planned, body: &str, asked: &[Numbers]) -> Vec<Numbers> {
    use wgpu::BufferUsages as Use;
    let mut layout = Layout::new(plan, quads(plan, 0), false).unwrap();
    // Functions that ask for a sample in the middle of a segment are given one.
    layout.shape.middles = true;
    let volumes = Volumes::new(gpu, plan, &layout, &[]);
    let entry = format!(
        "@group(0) @binding(8) var<storage, read> asked: array<array<f32, {ARGUMENTS}>>;\n@group(0) @binding(9) var<storage, read_write> told: array<array<f32, {ARGUMENTS}>>;\n\
         @compute @workgroup_size(1) fn twin(@builtin(global_invocation_id) id: vec3u) {{\n    let x = asked[id.x];\n    var y: array<f32, {ARGUMENTS}>;\n{body}\n    told[id.x] = y;\n}}\n"
    );
    let text = source(&layout.shape, &layout.offsets, (8, 8), Pauses::Never) + &entry;
    let module =
        gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source: wgpu::ShaderSource::Wgsl(text.into()) });
    let layouts = bind_group_layouts(gpu, layout.shape.quads);
    let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: &[Some(&layouts[0]), Some(&layouts[1])],
        ..Default::default()
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some("twin"),
        compilation_options: Default::default(),
        cache: None,
    });
    let whole = Strip { first: 0, count: 32 };
    let rows = Rows { strip: whole, held: whole };
    let frame = gpu.filled(bytemuck::bytes_of(&layout.frame.of(rows, &Pass::WHOLE, Patience::FULL, false)), Use::UNIFORM);
    let tables = gpu.filled(bytemuck::cast_slice(&layout.tables), Use::STORAGE);
    let constants = constants(gpu, &layout);
    let scratch = [0, 1, 2].map(|_| gpu.buffer(64, Use::STORAGE));
    let (asked_buffer, bytes) = (gpu.filled(bytemuck::cast_slice(asked), Use::STORAGE), size_of_val(asked) as u64);
    let told = gpu.buffer(bytes, Use::STORAGE | Use::COPY_SRC);
    let buffers = [&frame, &tables, &tables, &volumes.bricks, &scratch[0], &scratch[1], &scratch[2], &constants, &asked_buffer, &told];
    let sampler = gpu.sampler();
    let textures = volumes.views.iter().map(wgpu::BindingResource::TextureView).chain([wgpu::BindingResource::Sampler(&sampler)]);
    let buffers = buffers.map(|b| b.as_entire_binding());
    let groups = [gpu.group(&layouts[0], (0..).zip(buffers)), gpu.group(&layouts[1], (0..).zip(textures))];
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        groups.iter().enumerate().for_each(|(i, group)| pass.set_bind_group(i as u32, group, &[]));
        pass.dispatch_workgroups(asked.len() as u32, 1, 1);
    }
    gpu.queue.submit([encoder.finish()]);
    gpu.wait().unwrap();
    gpu.check(0).unwrap();
    bytemuck::pod_collect_to_vec(&gpu.read(&told, bytes, &mut None).unwrap())
}

/// Arguments that fill their ranges evenly.
fn arguments(ranges: &[(f64, f64)]) -> Vec<Numbers> {
    // Powers of the inverse of a number between 1 and 2 that no polynomial of low degree has as its root.
    let part = |i: usize, axis: usize| (0.5 + (i + 1) as f64 * 1.17f64.powi(-(axis as i32) - 1)).fract();
    let of = |i: usize| {
        let mut x = [0.0; ARGUMENTS];
        for (axis, (low, high)) in ranges.iter().enumerate() {
            x[axis] = (low + (high - low) * part(i, axis)) as f32;
        }
        x
    };
    (0..256).map(of).collect()
}

/// Asserts that `body` computes what `twin` does, to `tolerance` of 1 + |value|; and that it would not, were any
/// argument a quarter larger.
fn agree(gpu: &Gpu, plan: &Planned, body: &str, ranges: &[(f64, f64)], tolerance: f64, twin: impl Fn([f64; ARGUMENTS]) -> Vec<f64>) {
    let asked = arguments(ranges);
    let told = evaluated(gpu, plan, body, &asked);
    let worst = |argument: Option<usize>| {
        let of = |(x, y): (&Numbers, &Numbers)| {
            let mut x = x.map(f64::from);
            if let Some(i) = argument {
                x[i] *= 1.25;
            }
            let truth = twin(x);
            assert!(!truth.is_empty() && truth.len() <= ARGUMENTS);
            let wrong = truth.iter().zip(y).map(|(t, y)| (f64::from(*y) - t).abs() / (1.0 + t.abs()));
            wrong.fold(0.0, |m: f64, v| if v.is_nan() { f64::INFINITY } else { m.max(v) })
        };
        asked.iter().zip(&told).map(of).fold(0.0, f64::max)
    };
    let wrong = worst(None);
    assert!(wrong < tolerance, "{body}: {wrong:e} of {tolerance:e}");
    for i in 0..ranges.len() {
        assert!(worst(Some(i)) > tolerance, "{body} does not see its argument {i}");
    }
}

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
        let packet::Place { cell, fraction } = packet::place(x[0] as f32, 7);
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
fn rays_and_boxes() {
    let gpu = device();
    let plan = &plan("");
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    let body = "let r = camera_ray(x[0], x[1]); let p = r.origin + r.first * r.direction; y[0] = p.x; y[1] = p.y; y[2] = p.z; y[3] = r.direction.x; y[4] = r.direction.y; y[5] = r.direction.z;";
    agree(&gpu, plan, body, &[(1.0, 48.0), (1.0, 32.0)], 1e-6, |x| {
        let ray = plan.camera().ray(x[0], x[1]);
        let origin = ray.origin - middle;
        [origin.to_array(), ray.direction.to_array()].concat()
    });
    let own = plan.camera();
    let part = own.clone().equirectangular(48).crop(3, 2, 40, 20).unwrap();
    let two = |camera: Camera| camera.stereo(Stereo::new(0.4, 3.0)).eyes().unwrap();
    let [left, _] = two(own.clone().equirectangular(48));
    let [_, right] = two(own.clone().fisheye_deg(180.0, 30.0));
    // Of no shape that a sphere has: above and below is nothing.
    let square = own.clone().equirectangular(48).size(48, 48);
    for camera in [
        square,
        left,
        right,
        own.clone().fisheye_deg(180.0, 30.0),
        own.clone().fisheye_deg(340.0, 90.0),
        own.clone().equirectangular(48),
        part,
    ] {
        let plan = &seen_from(plan, camera);
        let (w, h) = (plan.camera().width as f64, plan.camera().height as f64);
        agree(&gpu, plan, body, &[(0.0, w), (0.0, h)], 5e-6, |x| {
            let ray = plan.camera().ray(x[0], x[1]);
            [(ray.origin - middle).to_array(), ray.direction.to_array()].concat()
        });
        agree(&gpu, plan, "y[0] = f32(sees(x[0], x[1]));", &[(0.0, w), (0.0, h)], 1e-6, |x| {
            vec![f64::from(u8::from(plan.camera().sees(x[0], x[1])))]
        });
    }
    // Directions jump from one face of a cube to the next.
    for face in 0..6 {
        let plan = &seen_from(plan, own.clone().cubemap(16));
        let rows = (16.0 * f64::from(face) + 0.01, 16.0 * f64::from(face) + 15.99);
        agree(&gpu, plan, body, &[(0.0, 16.0), rows], 2e-6, |x| {
            let ray = plan.camera().ray(x[0], x[1]);
            [(ray.origin - middle).to_array(), ray.direction.to_array()].concat()
        });
    }
    let body = "let d = normalize(vec3f(x[3], x[4], x[5])); let c = clip(Ray(vec3f(x[0], x[1], x[2]), d, 0.0), vec3f(-1.0), vec3f(1.0, 2.0, 3.0), 0.0); y[0] = c.x; y[1] = c.y; if c.y <= c.x { y[0] = -1.0; y[1] = -1.0; }";
    let coordinates = [(-2.0, 2.0); 6];
    agree(&gpu, plan, body, &coordinates, 1e-5, |x| {
        let bounds = Bounds { low: DVec3::splat(-1.0), high: DVec3::new(1.0, 2.0, 3.0) };
        let ray = barnard::geometry::Ray { origin: DVec3::new(x[0], x[1], x[2]), direction: DVec3::new(x[3], x[4], x[5]).normalize() };
        bounds.clip(&ray).map_or(vec![-1.0; 2], |(near, far)| vec![near, far])
    });
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn volumes_and_bricks() {
    let gpu = device();
    let plan = &plan("");
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    let place = |x: &[f64; ARGUMENTS]| middle + DVec3::new(x[0], x[1], x[2]);
    let volumes: Vec<_> = plan.volumes().collect();
    let within = [(-0.9, 0.9); 3];
    // Real devices weigh voxels in 256ths: they read what stands up to half of that beside a place, on each axis.
    let beside = volumes[0].lattice.voxel_pc() / 512.0;
    let rounded = |x: &Numbers| {
        let p = place(&x.map(f64::from));
        let moved =
            |channel: usize, axis: DVec3| [axis, -axis].map(|d| (volumes[0].at(channel, p + d * beside) - volumes[0].at(channel, p)).abs());
        let of = |channel: usize| DVec3::AXES.into_iter().map(|axis| moved(channel, axis).into_iter().fold(0.0, f64::max)).sum::<f64>();
        (0..3).map(of).fold(0.0, f64::max)
    };
    let weights = if gpu.adapter.real { arguments(&within).iter().map(rounded).fold(0.0, f64::max) } else { 0.0 };
    // Dust and two star depths stand in the first quad, gas in the second; f16 keeps three digits.
    agree(
        &gpu,
        plan,
        "let v = read_all(vec3f(x[0], x[1], x[2])); y[0] = v[0].x; y[1] = v[0].y; y[2] = v[0].z; y[3] = read_dust(vec3f(x[0], x[1], x[2]));",
        &within,
        1e-3 + weights,
        |x| {
            let at = |channel: usize| volumes[0].at(channel, place(&x));
            vec![at(0), at(1), at(2), at(0)]
        },
    );
    agree(&gpu, plan, "let m = masks(vec3f(x[0], x[1], x[2])); y[0] = m[0]; y[1] = m[1];", &[(-1.2, 1.2); 3], 1e-6, |x| {
        volumes.iter().map(|v| f64::from(u8::from(v.inner.bounds.contains(place(&x))))).collect()
    });
    let body = "y[0] = depth_between(vec3f(x[0], x[1], x[2]), vec3f(x[0] + x[3], x[1] + x[4], x[2] + x[5]));";
    let ranges = [within[0], within[1], within[2], (-0.2, 0.2), (-0.2, 0.2), (-0.2, 0.2)];
    agree(&gpu, plan, body, &ranges, 1e-3, |x| vec![plan.space().depth(place(&x), place(&x) + DVec3::new(x[3], x[4], x[5]))]);
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn empty_bricks() {
    let gpu = device();
    let plan = &plan_of(&scene(128, ""));
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    agree(&gpu, plan, "y[0] = clear_pc(Ray(vec3f(x[0], x[1], x[2]), vec3f(1.0, 0.0, 0.0), 0.0), 0.0).x;", &[(-1.1, 1.1); 3], 1e-6, |x| {
        let place = middle + DVec3::new(x[0], x[1], x[2]);
        let of = |b: &barnard::volume::Bricks| b.clear(b.brick_of(place)) as f64 * b.lattice.voxel_pc().min_element();
        vec![plan.space().bricks.iter().map(of).fold(f64::INFINITY, f64::min)]
    });
}

/// Voxels that are longer one way than another: a ray takes as many steps as those along its direction ask for.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn voxels_along_a_ray() {
    let gpu = device();
    let plate = "[field.plate]\nkind = \"box\"\nlow = \"-1 -0.3 -0.5 pc\"\nhigh = \"1 0.4 0.1 pc\"\n[dust]\ndensity = \"plate\"";
    let text = text(8, "").replace("[dust]\ndensity = \"ball\"", plate).replace("knot\"\ntemp", "plate\"\ntemp");
    let plan = &plan_of(&parsed(text));
    let longest = |d: DVec3| 1.0 / plan.space().voxel_along(d);
    assert!(longest(DVec3::Z) < 0.9 * longest(DVec3::X), "{} {}", longest(DVec3::X), longest(DVec3::Z));
    let body = "y[0] = 0.1 * voxels_along(normalize(vec3f(x[0], x[1], x[2])));";
    agree(&gpu, plan, body, &[(-1.0, 1.0); 3], 1e-6, |x| vec![0.1 * longest(DVec3::new(x[0], x[1], x[2]).normalize())]);
}

#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn noise() {
    let gpu = device();
    let plan = &plan("");
    let (cloud, sigma) = plan.space().cloud.as_ref().unwrap();
    agree(&gpu, plan, "y[0] = simplex(vec3f(x[0], x[1], x[2]), frame.seeds.x);", &[(-20.0, 20.0); 3], 2e-5, |x| {
        vec![cloud.noise.at(DVec3::new(x[0], x[1], x[2]))]
    });
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    agree(&gpu, plan, "y[0] = cloud(vec3f(x[0], x[1], x[2]));", &[(-0.7, 0.7); 3], 2e-5, |x| {
        vec![sigma * barnard::field::Field::at(cloud, middle + DVec3::new(x[0], x[1], x[2]))]
    });
}

/// The noise of detail, and what it makes of dust and gas of a sample.
#[test]
#[ignore = "needs a graphics adapter: --include-ignored"]
fn detail() {
    let gpu = device();
    let detailed = barnard::detail::Detail { deviation: Some(0.4), ..Default::default() };
    let plan = &plan_of(&scene(24, "").edited(|spec| spec.detail = Some(detailed)).unwrap());
    let noise = plan.detail().unwrap();
    agree(&gpu, plan, "y[0] = detail_noise(vec3f(x[0], x[1], x[2]), 77u);", &[(-20.0, 20.0); 3], 1e-4, |x| {
        vec![barnard::detail::double([x[0], x[1], x[2]], 77)]
    });
    let middle = plan.space().occupied.map(|b| 0.5 * (b.low + b.high)).unwrap();
    let (per_pc, ahead) = (plan.camera().footprint().per_pc, 0.03);
    // Along a ray on which the observer stands behind; a stretch so short that it is asked once.
    let body = "var ray: Ray; ray.origin = vec3f(x[0], x[1], x[2]); ray.direction = vec3f(0.6, 0.0, 0.8); ray.first = -x[3];\n\
                var v = read_all(ray.origin); v[DUST_QUAD][DUST_LANE] = 1.0; add_detail(&v, ray, 0.03, 1e-6); y[0] = log(v[DUST_QUAD][DUST_LANE]);";
    agree(&gpu, plan, body, &[(-0.7, 0.7), (-0.7, 0.7), (-0.7, 0.7), (0.3, 1.2)], 2e-3, |x| {
        let place = middle + DVec3::new(x[0], x[1], x[2]) + ahead * DVec3::new(0.6, 0.0, 0.8);
        vec![noise.factor(0, place, per_pc * (ahead + x[3])).ln()]
    });
    let body = "var ray: Ray; ray.origin = vec3f(x[0], x[1], x[2]); ray.direction = vec3f(0.6, 0.0, 0.8); ray.first = -x[3]; y[0] = log(dust_detail(ray, 0.03));";
    agree(&gpu, plan, body, &[(-0.7, 0.7), (-0.7, 0.7), (-0.7, 0.7), (0.3, 1.2)], 2e-3, |x| {
        let place = middle + DVec3::new(x[0], x[1], x[2]) + ahead * DVec3::new(0.6, 0.0, 0.8);
        vec![noise.factor(0, place, per_pc * (ahead + x[3])).ln()]
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
        compared.push(Layout::new(plan, quads(plan, 0), false).unwrap().shape.form.name);
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
                let of = |band: usize| {
                    plan.spectral().bands[band].rule.mean(light, DepthSpan { from: x[0] - x[1], to: x[0] + x[1] }) / totals[band]
                };
                vec![of(0), of(1)]
            });
            // Thick segments, which begin at x[0].
            let body = body.replace("1.0, x[0], x[1]", "1.0, x[0] + x[1], x[1]");
            agree(&gpu, plan, &body, &[(0.01, 2.0), (0.1, 2.9)], tolerance, |x| {
                let of = |band: usize| {
                    plan.spectral().bands[band].rule.mean(light, DepthSpan { from: x[0], to: x[0] + 2.0 * x[1] }) / totals[band]
                };
                vec![of(0), of(1)]
            });
        }
    }
    assert!(FORMS.iter().all(|form| compared.contains(&form.name)), "{compared:?}");
}
