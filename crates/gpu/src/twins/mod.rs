//! Functions of the shaders beside their twins in Rust, one by one, on the numbers of a real plan.

mod arithmetic;
mod space;

use barnard::camera::Camera;
use barnard::control::Control;
use barnard::plan::Planned;

use crate::Gpu;
use crate::fixtures::{plan_of, scene};
use crate::frame::{FrameRows, Pass, Patience, Strip};
use crate::layout::{ShaderLayout, quads};
use crate::resources::{Volumes, constants};
use crate::shader::source;
use crate::shader_constants::Pauses;

/// Numbers in and out of a function.
const ARGUMENTS: usize = 8;
type Arguments = [f32; ARGUMENTS];

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

/// The layouts of the march's own bindings with those of queries and answers behind, and of a number of textures.
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
fn evaluated(gpu: &Gpu, plan: &Planned, body: &str, asked: &[Arguments]) -> Vec<Arguments> {
    use wgpu::BufferUsages as Use;
    let mut layout = ShaderLayout::new(plan, quads(plan, 0), false).unwrap();
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
    let rows = FrameRows { strip: whole, stored: whole };
    let frame = gpu.filled(bytemuck::bytes_of(&layout.frame.of(rows, &Pass::WHOLE, Patience::FULL, false)), Use::UNIFORM);
    let tables = gpu.filled(bytemuck::cast_slice(&layout.tables), Use::STORAGE);
    let constants = constants(gpu, &layout);
    let scratch = [0, 1, 2].map(|_| gpu.buffer(64, Use::STORAGE));
    let (asked_buffer, bytes) = (gpu.filled(bytemuck::cast_slice(asked), Use::STORAGE), size_of_val(asked) as u64);
    let output = gpu.buffer(bytes, Use::STORAGE | Use::COPY_SRC);
    let buffers = [&frame, &tables, &tables, &volumes.bricks, &scratch[0], &scratch[1], &scratch[2], &constants, &asked_buffer, &output];
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
    bytemuck::pod_collect_to_vec(&gpu.read(&output, bytes, &mut None).unwrap())
}

/// Arguments that fill their ranges evenly.
fn arguments(ranges: &[(f64, f64)]) -> Vec<Arguments> {
    // Powers of the inverse of a number between 1 and 2 that no polynomial of low degree has as its root.
    let part = |i: usize, axis: usize| (0.5 + (i + 1) as f64 * 1.17f64.powi(-(axis as i32) - 1)).fract();
    let sample = |i: usize| {
        let mut x = [0.0; ARGUMENTS];
        for (axis, (low, high)) in ranges.iter().enumerate() {
            x[axis] = (low + (high - low) * part(i, axis)) as f32;
        }
        x
    };
    (0..256).map(sample).collect()
}

/// Asserts that `body` computes what `twin` does, to `tolerance` of 1 + |value|; and that it would not, were any
/// argument a quarter larger.
fn agree(gpu: &Gpu, plan: &Planned, body: &str, ranges: &[(f64, f64)], tolerance: f64, twin: impl Fn([f64; ARGUMENTS]) -> Vec<f64>) {
    let asked = arguments(ranges);
    let values = evaluated(gpu, plan, body, &asked);
    let worst = |argument: Option<usize>| {
        let difference = |(x, y): (&Arguments, &Arguments)| {
            let mut x = x.map(f64::from);
            if let Some(i) = argument {
                x[i] *= 1.25;
            }
            let truth = twin(x);
            assert!(!truth.is_empty() && truth.len() <= ARGUMENTS);
            let wrong = truth.iter().zip(y).map(|(t, y)| (f64::from(*y) - t).abs() / (1.0 + t.abs()));
            wrong.fold(0.0, |m: f64, v| if v.is_nan() { f64::INFINITY } else { m.max(v) })
        };
        asked.iter().zip(&values).map(difference).fold(0.0, f64::max)
    };
    let wrong = worst(None);
    assert!(wrong < tolerance, "{body}: {wrong:e} of {tolerance:e}");
    for i in 0..ranges.len() {
        assert!(worst(Some(i)) > tolerance, "{body} does not see its argument {i}");
    }
}
