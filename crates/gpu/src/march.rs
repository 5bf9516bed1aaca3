//! The march on a device: volumes up, strips of rows, radiance down.
//!
//! A [`Renderer`] keeps what a change leaves as it was: textures as long as the space is the same, the pipeline as long as the shape is.

use std::sync::Arc;

use barnard::backend::cpu::{Findings, finished};
use barnard::control::{Control, Stage};
use barnard::image::Image;
use barnard::plan::{Plan, Space, Volume};
use barnard::scene::Scene;
use wgpu::BufferUsages as Use;

use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::layout::{Layout, Quad, exponents, quads};
use crate::shader::source;
use crate::textures::{dark, texture};

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

/// Renders the plan of `scene`; stars are drawn by the processor.
///
/// # Errors
/// For methods that no shader has, grids beyond the device's limits, and devices that give up.
pub fn render(gpu: &Gpu, scene: &Scene, plan: &Plan, control: &Control) -> Result<(Image, Findings)> {
    let (data, findings) = Renderer::new(gpu, plan, Tuning::default())?.radiance(control)?;
    let image = finished(scene, plan, data, findings, &format!("gpu: {} ({})", gpu.adapter.name, gpu.adapter.api))?;
    Ok((image, findings))
}

/// Why no device can render this plan; none where one can, as far as its limits go.
pub fn unable(plan: &Plan) -> Option<GpuError> {
    exponents(plan).err()
}

/// A plan on a device.
pub struct Renderer<'a> {
    gpu: &'a Gpu,
    tuning: Tuning,
    layout: Layout,
    volumes: Volumes,
    pipeline: wgpu::ComputePipeline,
    strips: Strips,
    groups: [wgpu::BindGroup; 2],
    /// Time of the device for the last picture [s].
    seconds: Option<f64>,
}

/// What places decide, on the device.
struct Volumes {
    space: Arc<Space>,
    views: Vec<wgpu::TextureView>,
    bricks: wgpu::Buffer,
}

/// Buffers of a strip of rows.
struct Strips {
    frame: wgpu::Buffer,
    radiance: wgpu::Buffer,
    found: wgpu::Buffer,
    back: wgpu::Buffer,
    rows: usize,
}

impl<'a> Renderer<'a> {
    /// For one plan.
    ///
    /// # Errors
    /// For methods that no shader has, and for grids beyond the device's limits.
    pub fn new(gpu: &'a Gpu, plan: &Plan, tuning: Tuning) -> Result<Self> {
        let layout = Layout::new(plan, quads(plan))?;
        check_limits(gpu, plan, &layout)?;
        let volumes = Volumes::new(gpu, plan, &layout, tuning);
        let pipeline = pipeline(gpu, &layout, tuning);
        let strips = Strips::new(gpu, &layout);
        let groups = groups(gpu, &pipeline, &layout, &volumes, &strips);
        gpu.check()?;
        Ok(Self { gpu, tuning, layout, volumes, pipeline, strips, groups, seconds: None })
    }

    /// Takes another plan: what has changed is uploaded, what has not stays.
    ///
    /// # Errors
    /// As [`new`](Self::new); the plan before stays in place then.
    pub fn update(&mut self, plan: &Plan) -> Result<()> {
        let same_space = Arc::ptr_eq(&plan.space, &self.volumes.space);
        let quads = if same_space { self.layout.quads.clone() } else { quads(plan) };
        let layout = Layout::new(plan, quads)?;
        check_limits(self.gpu, plan, &layout)?;
        if !same_space {
            self.volumes = Volumes::new(self.gpu, plan, &layout, self.tuning);
        }
        if layout.shape != self.layout.shape {
            self.pipeline = pipeline(self.gpu, &layout, self.tuning);
        }
        if layout.frame.size != self.layout.frame.size || layout.shape.bands != self.layout.shape.bands {
            self.strips = Strips::new(self.gpu, &layout);
        }
        self.groups = groups(self.gpu, &self.pipeline, &layout, &self.volumes, &self.strips);
        self.layout = layout;
        self.gpu.check()
    }

    /// Band radiances of the extended light alone, bands × height × width [W m⁻² sr⁻¹], and what was found.
    ///
    /// # Errors
    /// Where the device gives up, or the user wishes to stop.
    pub fn radiance(&mut self, control: &Control) -> Result<(Vec<f32>, Findings)> {
        let [width, height, s, _] = self.layout.frame.size.map(|n| n as usize);
        let (bands, rows) = (self.layout.shape.bands, self.strips.rows);
        let mut data = vec![0.0; bands * width * height];
        let (mut deepest, mut seconds) = (0.0f32, self.gpu.timer.as_ref().map(|_| 0.0));
        self.gpu.queue.write_buffer(&self.strips.found, 0, &[0; 4]);
        for (i, first) in (0..height).step_by(rows).enumerate() {
            control.check()?;
            let count = rows.min(height - first);
            let strip = self.strip(first, count)?;
            deepest = deepest.max(strip.deepest);
            seconds = seconds.zip(strip.seconds).map(|(all, own)| all + own);
            for (band, values) in strip.radiance.chunks_exact(count * width).enumerate() {
                data[band * width * height + first * width..][..count * width].copy_from_slice(values);
            }
            control.report(Stage::Rays, i as u64 + 1, height.div_ceil(rows) as u64);
        }
        self.seconds = seconds;
        let negative = data.iter().filter(|v| **v < 0.0).count() as u64;
        Ok((data, Findings { depth: f64::from(deepest), rays: (width * height * s * s) as u64, negative }))
    }

    /// The device's own time for the last picture [s]; none where it does not tell.
    pub fn seconds(&self) -> Option<f64> {
        self.seconds
    }

    fn strip(&self, first: usize, rows: usize) -> Result<Strip> {
        let (gpu, strips) = (self.gpu, &self.strips);
        let width = self.layout.frame.size[0];
        let workgroup = self.tuning.workgroup;
        gpu.queue.write_buffer(&strips.frame, 0, bytemuck::bytes_of(&self.layout.strip(first, rows)));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let timestamp_writes = gpu.timer.as_ref().map(|timer| wgpu::ComputePassTimestampWrites {
                query_set: timer,
                beginning_of_pass_write_index: Some(0),
                end_of_pass_write_index: Some(1),
            });
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("march"), timestamp_writes });
            pass.set_pipeline(&self.pipeline);
            for (i, group) in self.groups.iter().enumerate() {
                pass.set_bind_group(i as u32, group, &[]);
            }
            pass.dispatch_workgroups(width.div_ceil(workgroup.0), (rows as u32).div_ceil(workgroup.1), 1);
        }
        let bytes = 4 * (rows * width as usize * self.layout.shape.bands) as u64;
        if let Some(timer) = &gpu.timer {
            encoder.resolve_query_set(timer, 0..2, &gpu.times, 0);
            encoder.copy_buffer_to_buffer(&gpu.times, 0, &strips.back, 0, 16);
        }
        encoder.copy_buffer_to_buffer(&strips.found, 0, &strips.back, 16, 4);
        encoder.copy_buffer_to_buffer(&strips.radiance, 0, &strips.back, HEAD, bytes);
        gpu.queue.submit([encoder.finish()]);
        let values = self.read(HEAD + bytes)?;
        let ticks: [u64; 2] = bytemuck::pod_read_unaligned(&values[..16]);
        let seconds =
            gpu.timer.as_ref().map(|_| ticks[1].saturating_sub(ticks[0]) as f64 * f64::from(gpu.queue.get_timestamp_period()) * 1e-9);
        let deepest = bytemuck::pod_read_unaligned(&values[16..20]);
        Ok(Strip { radiance: bytemuck::pod_collect_to_vec(&values[HEAD as usize..]), deepest, seconds })
    }

    /// The first bytes of what came back.
    fn read(&self, bytes: u64) -> Result<Vec<u8>> {
        fn lost(e: impl std::fmt::Display) -> GpuError {
            GpuError::Lost(e.to_string())
        }
        let slice = self.strips.back.slice(..bytes);
        let (sender, receiver) = std::sync::mpsc::channel();
        slice.map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result)));
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(lost)?;
        self.gpu.check()?;
        receiver.recv().map_err(lost)?.map_err(lost)?;
        let values = slice.get_mapped_range().map_err(lost)?.to_vec();
        self.strips.back.unmap();
        Ok(values)
    }
}

/// Bytes in front of the radiance that comes back: two times, the largest depth, and room to the next aligned place.
const HEAD: u64 = 32;

/// What one dispatch found.
struct Strip {
    /// Bands × rows × width.
    radiance: Vec<f32>,
    deepest: f32,
    seconds: Option<f64>,
}

impl Volumes {
    fn new(gpu: &Gpu, plan: &Plan, layout: &Layout, tuning: Tuning) -> Self {
        let volumes: Vec<&Volume> = plan.volumes().collect();
        let view = |quad: &Quad| texture(gpu, volumes[quad.volume], quad);
        let mut views: Vec<wgpu::TextureView> = layout.quads.iter().map(view).collect();
        if views.is_empty() {
            views.push(dark(gpu));
        }
        let still = vec![0; layout.bricks.len()];
        let bricks = gpu.filled(bytemuck::cast_slice(if tuning.skip_empty { &layout.bricks } else { &still }), Use::STORAGE);
        Self { space: plan.space.clone(), views, bricks }
    }
}

impl Strips {
    fn new(gpu: &Gpu, layout: &Layout) -> Self {
        let [width, height, s, _] = layout.frame.size.map(|n| n as usize);
        let rows = (STRIP / (width * layout.shape.bands)).min(STRIP_RAYS / (width * s * s)).clamp(1, height);
        let bytes = 4 * (rows * width * layout.shape.bands) as u64;
        Self {
            frame: gpu.buffer(size_of_val(&layout.frame) as u64, Use::UNIFORM | Use::COPY_DST),
            radiance: gpu.buffer(bytes, Use::STORAGE | Use::COPY_SRC),
            found: gpu.buffer(4, Use::STORAGE | Use::COPY_SRC | Use::COPY_DST),
            back: gpu.buffer(HEAD + bytes, Use::MAP_READ | Use::COPY_DST),
            rows,
        }
    }
}

fn pipeline(gpu: &Gpu, layout: &Layout, tuning: Tuning) -> wgpu::ComputePipeline {
    let source = wgpu::ShaderSource::Wgsl(source(&layout.shape, tuning.workgroup).into());
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("march"), source });
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("march"),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    })
}

/// The bindings of a pipeline: buffers, then textures and their sampler.
fn groups(gpu: &Gpu, pipeline: &wgpu::ComputePipeline, layout: &Layout, volumes: &Volumes, strips: &Strips) -> [wgpu::BindGroup; 2] {
    let tables = gpu.filled(bytemuck::cast_slice(&layout.tables), Use::STORAGE);
    let buffers = [&strips.frame, &tables, &volumes.bricks, &strips.radiance, &strips.found].map(|b| b.as_entire_binding());
    let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let textures = volumes.views.iter().map(wgpu::BindingResource::TextureView).chain([wgpu::BindingResource::Sampler(&sampler)]);
    let group = |number: u32, resources: Vec<wgpu::BindingResource>| {
        let entry = |(i, resource)| wgpu::BindGroupEntry { binding: i as u32, resource };
        let entries: Vec<_> = resources.into_iter().enumerate().map(entry).collect();
        let layout = &pipeline.get_bind_group_layout(number);
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    };
    [group(0, buffers.to_vec()), group(1, textures.collect())]
}

fn check_limits(gpu: &Gpu, plan: &Plan, layout: &Layout) -> Result<()> {
    let limits = gpu.device.limits();
    let too_large = |what: &str, size: u64, most: u64, instead: String| {
        if size > most { Err(GpuError::TooLarge { what: what.into(), size, most, instead }) } else { Ok(()) }
    };
    let edge = plan.volumes().flat_map(|v| v.lattice.dims).max().unwrap_or(0) as u64;
    let most = u64::from(limits.max_texture_dimension_3d);
    let instead = format!("take a grid of at most {} voxels along each axis, or --backend cpu", most.saturating_sub(2));
    too_large("the edge of a volume in voxels", edge, most, instead)?;
    let most = u64::from(limits.max_sampled_textures_per_shader_stage);
    let instead = format!("dust, star depths and gas are four to a texture: at most {} stars, or --backend cpu", 4 * most - 1);
    too_large("the number of textures", layout.quads.len() as u64, most, instead)?;
    let most = limits.max_storage_buffer_binding_size;
    let instead = "take a smoother phase function or fewer stars, or --backend cpu".into();
    too_large("the tables in bytes", 16 * layout.tables.len() as u64, most, instead)?;
    let instead = "take a coarser grid, or --backend cpu".into();
    too_large("the bricks in bytes", 4 * layout.bricks.len() as u64, most, instead)
}
