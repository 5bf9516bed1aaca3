//! The march on a device: volumes up, strips of rows, radiance down.

use barnard::backend::cpu::{Findings, finished};
use barnard::control::{Control, Stage};
use barnard::image::Image;
use barnard::plan::{Plan, Volume};
use barnard::scene::Scene;
use half::f16;
use wgpu::util::DeviceExt;

use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::layout::{Layout, Quad};
use crate::shader::source;

/// Numbers of radiance that a strip of rows holds at most: what one dispatch may do before somebody may wish to stop.
const STRIP: usize = 1 << 20;
/// Rays of a strip at most.
const STRIP_RAYS: usize = 1 << 17;

/// What may change without the picture changing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tuning {
    /// Rays of a workgroup, across and down.
    pub workgroup: (u32, u32),
    /// Whether rays jump over empty bricks.
    pub skip_empty: bool,
}

impl Default for Tuning {
    fn default() -> Self {
        Self { workgroup: (8, 8), skip_empty: true }
    }
}

/// Band radiances of the extended light alone, bands × height × width [W m⁻² sr⁻¹], and what was found.
///
/// # Errors
/// For methods that no shader has, grids beyond the device's limits, and devices that give up.
pub fn radiance(gpu: &Gpu, plan: &Plan, control: &Control) -> Result<(Vec<f32>, Findings)> {
    radiance_with(gpu, plan, control, &Tuning::default())
}

/// The same by a device that is used in another way.
pub fn radiance_with(gpu: &Gpu, plan: &Plan, control: &Control, tuning: &Tuning) -> Result<(Vec<f32>, Findings)> {
    let mut layout = Layout::new(plan)?;
    if !tuning.skip_empty {
        layout.bricks.fill(0);
    }
    let volumes: Vec<&Volume> = plan.volumes().collect();
    check_limits(gpu, &volumes, &layout)?;
    let mut pass = Pass::new(gpu, &layout, &volumes, tuning.workgroup);
    gpu.check()?;
    let (width, height, bands, s) = (plan.camera.width, plan.camera.height, layout.shape.bands, plan.camera.supersampling);
    let rows = pass.rows;
    let mut data = vec![0.0; bands * width * height];
    let mut deepest = 0.0f32;
    for (i, first) in (0..height).step_by(rows).enumerate() {
        control.check()?;
        let count = rows.min(height - first);
        let (strip, depth) = pass.strip(&layout, first, count)?;
        deepest = deepest.max(depth);
        for band in 0..bands {
            data[band * width * height + first * width..][..count * width].copy_from_slice(&strip[band * count * width..][..count * width]);
        }
        control.report(Stage::Rays, i as u64 + 1, height.div_ceil(rows) as u64);
    }
    let negative = data.iter().filter(|v| **v < 0.0).count() as u64;
    Ok((data, Findings { depth: f64::from(deepest), rays: (width * height * s * s) as u64, negative }))
}

/// Renders the plan of `scene`; stars are drawn by the processor.
pub fn render(gpu: &Gpu, scene: &Scene, plan: &Plan, control: &Control) -> Result<(Image, Findings)> {
    let (data, findings) = radiance(gpu, plan, control)?;
    let image = finished(scene, plan, data, findings, &format!("gpu: {} ({})", gpu.adapter.name, gpu.adapter.api))?;
    Ok((image, findings))
}

/// Why no device can render this plan; none where one can, as far as its limits go.
pub fn unable(plan: &Plan) -> Option<GpuError> {
    Layout::new(plan).err()
}

fn check_limits(gpu: &Gpu, volumes: &[&Volume], layout: &Layout) -> Result<()> {
    let limits = gpu.device.limits();
    for volume in volumes {
        let edge = volume.lattice.dims.into_iter().max().unwrap_or(0) as u64;
        let most = u64::from(limits.max_texture_dimension_3d);
        if edge > most {
            let instead = format!("take a grid of at most {} voxels along each axis, or --backend cpu", most - 2);
            return Err(GpuError::TooLarge { what: "the edge of a volume in voxels".into(), size: edge, most, instead });
        }
    }
    let most = u64::from(limits.max_sampled_textures_per_shader_stage);
    if layout.quads.len() as u64 > most {
        let instead = format!("dust, star depths and gas are four to a texture: at most {} stars, or --backend cpu", 4 * most - 1);
        return Err(GpuError::TooLarge { what: "the number of textures".into(), size: layout.quads.len() as u64, most, instead });
    }
    let bytes = 16 * layout.tables.len() as u64;
    let most = limits.max_storage_buffer_binding_size;
    if bytes > most {
        let instead = "take a smoother phase function or fewer stars, or --backend cpu".into();
        return Err(GpuError::TooLarge { what: "the tables in bytes".into(), size: bytes, most, instead });
    }
    Ok(())
}

/// A pipeline with what it reads and writes.
struct Pass<'a> {
    gpu: &'a Gpu,
    pipeline: wgpu::ComputePipeline,
    frame: wgpu::Buffer,
    radiance: wgpu::Buffer,
    found: wgpu::Buffer,
    back: wgpu::Buffer,
    groups: [wgpu::BindGroup; 2],
    workgroup: (u32, u32),
    /// Rows of a full strip.
    rows: usize,
}

impl<'a> Pass<'a> {
    fn new(gpu: &'a Gpu, layout: &Layout, volumes: &[&Volume], workgroup: (u32, u32)) -> Self {
        let device = &gpu.device;
        let text = source(&layout.shape, workgroup);
        let module = device
            .create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("march"), source: wgpu::ShaderSource::Wgsl(text.into()) });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("march"),
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        let [width, height, s, _] = layout.frame.size.map(|n| n as usize);
        let rows = (STRIP / (width * layout.shape.bands)).min(STRIP_RAYS / (width * s * s)).clamp(1, height);
        let bytes = 4 * (rows * width * layout.shape.bands) as u64;
        let buffer =
            |size: u64, usage| device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
        let filled = |contents: &[u8], usage| device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage });
        use wgpu::BufferUsages as Use;
        let frame = buffer(size_of_val(&layout.frame) as u64, Use::UNIFORM | Use::COPY_DST);
        let tables = filled(bytemuck::cast_slice(&layout.tables), Use::STORAGE);
        let bricks = filled(bytemuck::cast_slice(&layout.bricks), Use::STORAGE);
        let radiance = buffer(bytes, Use::STORAGE | Use::COPY_SRC);
        let found = filled(&[0; 4], Use::STORAGE | Use::COPY_SRC);
        let back = buffer(bytes + 4, Use::MAP_READ | Use::COPY_DST);
        let entries = [&frame, &tables, &bricks, &radiance, &found];
        let entries: Vec<_> =
            entries.iter().enumerate().map(|(i, b)| wgpu::BindGroupEntry { binding: i as u32, resource: b.as_entire_binding() }).collect();
        let buffers = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut views: Vec<wgpu::TextureView> = layout.quads.iter().map(|quad| texture(gpu, volumes[quad.volume], quad)).collect();
        if views.is_empty() {
            views.push(dark(gpu));
        }
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let mut entries: Vec<_> = views
            .iter()
            .enumerate()
            .map(|(i, view)| wgpu::BindGroupEntry { binding: i as u32, resource: wgpu::BindingResource::TextureView(view) })
            .collect();
        entries.push(wgpu::BindGroupEntry { binding: views.len() as u32, resource: wgpu::BindingResource::Sampler(&sampler) });
        let textures = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(1),
            entries: &entries,
        });
        Self { gpu, pipeline, frame, radiance, found, back, groups: [buffers, textures], workgroup, rows }
    }

    /// Radiance of some rows, bands × rows × width, and the largest depth so far.
    fn strip(&mut self, layout: &Layout, first: usize, rows: usize) -> Result<(Vec<f32>, f32)> {
        let width = layout.frame.size[0];
        self.gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&layout.strip(first, rows)));
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.pipeline);
            for (i, group) in self.groups.iter().enumerate() {
                pass.set_bind_group(i as u32, group, &[]);
            }
            pass.dispatch_workgroups(width.div_ceil(self.workgroup.0), (rows as u32).div_ceil(self.workgroup.1), 1);
        }
        let bytes = 4 * (rows * width as usize * layout.shape.bands) as u64;
        encoder.copy_buffer_to_buffer(&self.found, 0, &self.back, 0, 4);
        encoder.copy_buffer_to_buffer(&self.radiance, 0, &self.back, 4, bytes);
        self.gpu.queue.submit([encoder.finish()]);
        let slice = self.back.slice(..4 + bytes);
        let (sender, receiver) = std::sync::mpsc::channel();
        slice.map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result)));
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| GpuError::Lost(e.to_string()))?;
        self.gpu.check()?;
        receiver.recv().map_err(|e| GpuError::Lost(e.to_string()))?.map_err(|e| GpuError::Lost(e.to_string()))?;
        let values: Vec<f32> = {
            let view = slice.get_mapped_range().map_err(|e| GpuError::Lost(e.to_string()))?;
            bytemuck::pod_collect_to_vec(&view)
        };
        self.back.unmap();
        Ok((values[1..].to_vec(), values[0]))
    }
}

/// Four channels of a volume in f16, each in parts of its largest value.
fn texture(gpu: &Gpu, volume: &Volume, quad: &Quad) -> wgpu::TextureView {
    let count = volume.channels.len();
    let mut texels = vec![f16::ZERO; 4 * volume.lattice.cells()];
    for (row, texel) in volume.data.chunks_exact(count).zip(texels.chunks_exact_mut(4)) {
        for ((value, unit), out) in row.iter().skip(quad.first).zip(&quad.unit).zip(texel) {
            *out = f16::from_f32(if *unit > 0.0 { value / unit } else { 0.0 });
        }
    }
    uploaded(gpu, volume.lattice.dims, &texels)
}

/// Nothing, where there is nothing to read.
fn dark(gpu: &Gpu) -> wgpu::TextureView {
    uploaded(gpu, [1; 3], &[f16::ZERO; 4])
}

fn uploaded(gpu: &Gpu, [x, y, z]: [usize; 3], texels: &[f16]) -> wgpu::TextureView {
    let descriptor = wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: x as u32, height: y as u32, depth_or_array_layers: z as u32 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, order, bytemuck::cast_slice(texels));
    texture.create_view(&Default::default())
}
