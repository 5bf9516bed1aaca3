//! Device resources of a plan: textures, buffers, the pipeline, and whether they fit.

use std::sync::Arc;

use barnard::plan::near::SHORTEST_PART;
use barnard::plan::{MultipleScattering, Plan, SpatialPlan};
use barnard::volume::Volume;
use wgpu::BufferUsages as Use;

use crate::atlas::size;
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::layout::ShaderLayout;
use crate::shader_constants::Pauses;
use crate::tables::Quad;
use crate::textures::{dark, texture};
use crate::tuning::Tuning;

/// The most bytes of a picture that the device holds at once.
const PICTURE: u64 = 1 << 28;
/// Dispatches of a picture whose times are taken.
pub const TIMED: usize = 2048;
/// The bytes of what is found beside a picture.
pub const REPORT_BYTES: u64 = 12;
/// The bytes from the times of one dispatch to those of the next, as wgpu aligns them.
pub const TIMES: u64 = wgpu::QUERY_RESOLVE_BUFFER_ALIGNMENT;

/// The volumes on the device: what places decide, and the light that was scattered before.
pub struct Volumes {
    pub space: Arc<SpatialPlan>,
    pub scattered_field: Option<Arc<MultipleScattering>>,
    pub views: Vec<wgpu::TextureView>,
    pub bricks: wgpu::Buffer,
    pub bytes: u64,
    /// True if a star is no longer where the space has it.
    pub moved: bool,
}

/// The buffers that a picture needs.
pub struct Buffers {
    pub frame: wgpu::Buffer,
    /// The buffer of the picture, bands × rows × width.
    pub picture: wgpu::Buffer,
    /// The buffer of what is found beside the picture.
    pub report: wgpu::Buffer,
    /// The buffer of the states of rays that pause.
    pub paused: wgpu::Buffer,
    pub times: Option<wgpu::Buffer>,
    /// The buffer by which results are read back.
    pub back: Option<wgpu::Buffer>,
    /// Rows of the picture that are held.
    pub rows: usize,
}

pub fn pauses(gpu: &Gpu, tuning: Tuning) -> Pauses {
    if tuning.pauses.unwrap_or(!gpu.adapter.real) { Pauses::Software } else { Pauses::Never }
}

/// The layout without what the tuning leaves out.
pub fn tuned(mut layout: ShaderLayout, tuning: Tuning) -> ShaderLayout {
    if !tuning.end_early {
        // Nothing is so deep.
        layout.frame.limits[0] = 0.0;
    }
    if !tuning.skip_empty {
        layout.bricks[..layout.distances].fill(0);
    }
    layout
}

impl Volumes {
    /// Uploads the volumes of a plan; the first textures may be `kept`.
    pub fn new(gpu: &Gpu, plan: &Plan, layout: &ShaderLayout, reused_views: &[wgpu::TextureView]) -> Self {
        let volumes: Vec<&Volume> = plan.volumes().collect();
        let view = |quad: &Quad| texture(gpu, volumes[quad.volume], quad);
        let mut views: Vec<wgpu::TextureView> =
            reused_views.iter().cloned().chain(layout.quads.iter().skip(reused_views.len()).map(view)).collect();
        if views.is_empty() {
            views.push(dark(gpu));
        }
        let texels = |quad: &Quad| size(volumes[quad.volume]).iter().product::<usize>();
        let bytes = layout.quads.iter().map(|quad| 8 * texels(quad) as u64).sum();
        let bricks = gpu.filled(bytemuck::cast_slice(&layout.bricks), Use::STORAGE);
        Self { space: plan.space().clone(), scattered_field: plan.scattered_field().cloned(), views, bricks, bytes, moved: false }
    }
}

impl Buffers {
    pub fn new(gpu: &Gpu, layout: &ShaderLayout, pauses: Pauses) -> Result<Self> {
        let [width, height, ..] = layout.frame.size.map(|n| n as usize);
        let row = 4 * (width * layout.shape.bands()) as u64;
        // Span, step, part, depth and deepest beside the light.
        let carried = 4 * (width * (5 + layout.shape.sums() + layout.shape.field_channels().max(1))) as u64;
        let largest = if pauses == Pauses::Software { carried } else { row };
        let limits = gpu.device.limits();
        let most = PICTURE.min(limits.max_storage_buffer_binding_size).min(limits.max_buffer_size);
        GpuError::too_large(
            "a row of the picture in bytes",
            largest,
            most,
            "use fewer pixels per row, fewer bands, or render on the processor",
        )?;
        let rows = ((most / largest) as usize).clamp(1, height);
        Ok(Self {
            frame: gpu.buffer(size_of_val(&layout.frame) as u64, Use::UNIFORM | Use::COPY_DST),
            picture: gpu.buffer(rows as u64 * row, Use::STORAGE | Use::COPY_SRC),
            report: gpu.buffer(REPORT_BYTES, Use::STORAGE | Use::COPY_SRC | Use::COPY_DST),
            paused: gpu.buffer(if pauses == Pauses::Software { rows as u64 * carried } else { 4 }, Use::STORAGE),
            times: gpu.timer.as_ref().map(|_| gpu.buffer(TIMED as u64 * TIMES, Use::QUERY_RESOLVE | Use::COPY_SRC)),
            back: None,
            rows,
        })
    }
}

/// The head of the tables, which a device keeps at hand where it is small.
pub fn constants(gpu: &Gpu, layout: &ShaderLayout) -> wgpu::Buffer {
    let space = if layout.shape.constants_are_uniform() { Use::UNIFORM } else { Use::STORAGE };
    gpu.filled(bytemuck::cast_slice(&layout.tables[..layout.shape.constants]), space)
}

/// The bindings of a pipeline: buffers, then textures and their sampler.
pub fn groups(
    gpu: &Gpu,
    pipeline: &wgpu::ComputePipeline,
    layout: &ShaderLayout,
    volumes: &Volumes,
    buffers: &Buffers,
) -> [wgpu::BindGroup; 2] {
    let tables = gpu.filled(bytemuck::cast_slice(&layout.tables), Use::STORAGE);
    let constants = constants(gpu, layout);
    let buffers = [&buffers.frame, &tables, &tables, &volumes.bricks, &buffers.picture, &buffers.report, &buffers.paused, &constants]
        .map(|b| b.as_entire_binding());
    let sampler = gpu.sampler();
    let textures = volumes.views.iter().map(wgpu::BindingResource::TextureView).chain([wgpu::BindingResource::Sampler(&sampler)]);
    let layout = |number: u32| pipeline.get_bind_group_layout(number);
    [gpu.group(&layout(0), (0..).zip(buffers)), gpu.group(&layout(1), (0..).zip(textures))]
}

/// Storage buffers that a shader binds.
const BUFFERS: u64 = 7;
/// Positions in tables are written as f32, which counts so far.
const COUNTABLE: u64 = 1 << 24;

pub fn check_limits(gpu: &Gpu, plan: &Plan, layout: &ShaderLayout) -> Result<()> {
    let limits = gpu.device.limits();
    let most = u64::from(limits.max_storage_buffers_per_shader_stage);
    GpuError::too_large("the number of buffers of the shader", BUFFERS, most, "render on the processor")?;
    let edge = plan.volumes().flat_map(size).max().unwrap_or(0) as u64;
    let most = u64::from(limits.max_texture_dimension_3d);
    let instead = format!(
        "use a grid of at most {} voxels per axis, sparse = \"always\" in [method], or render on the processor",
        most.saturating_sub(2)
    );
    GpuError::too_large("the edge of a volume in voxels", edge, most, instead)?;
    let most = u64::from(limits.max_sampled_textures_per_shader_stage);
    let instead =
        format!("use at most {} volumes of dust, star depths, gas and multiple scattering together, or render on the processor", 4 * most);
    GpuError::too_large("the number of textures", layout.quads.len() as u64, most, instead)?;
    // A step next to a star is marched in parts of half a voxel, or longer ones.
    let longest_pc = plan.space().occupied.map_or(0.0, |b| b.size().length());
    let parts = (longest_pc / (SHORTEST_PART * plan.space().voxel_pc())).ceil() as usize;
    let steps = plan.stepping().steps(longest_pc, plan.space().voxel_pc()).max(parts) as u64;
    let instead = "use coarser grids, fewer steps, or render on the processor";
    GpuError::too_large("the number of steps along a ray", steps, COUNTABLE, instead)?;
    let most = limits.max_storage_buffer_binding_size.min(16 * COUNTABLE);
    let instead = "use a smoother phase function or fewer stars, or render on the processor";
    GpuError::too_large("the tables in bytes", 16 * layout.tables.len() as u64, most, instead)?;
    let instead = "use a coarser grid, or render on the processor";
    GpuError::too_large("the bricks in bytes", 4 * layout.bricks.len() as u64, most, instead)
}
