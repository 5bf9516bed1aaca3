//! Ionising light of stars on the device: what [`ionisation::processor::Processor`] does, one invocation for each ray.

mod numbers;

use std::sync::{Arc, OnceLock};

use ionisation::cloud::PARSEC_CM;
use ionisation::lit::{BEHIND, UNITS};
use ionisation::rays::{BEYOND, WIDEST};
use ionisation::tracer::{Failure, Light, Listener, RayTracer, Task, Turns};
use ionisation::voxel::{ALL, CHANGE, MOST_MADE, NONE, Voxel};
use spectra::constants::SPHERE;
use wgpu::BufferUsages as Use;

use self::numbers::{GENERATIONS, QUADS, VOXEL, generations, rays_at_most, sent, spectrum, voxel_quads};
pub use self::numbers::{GenerationNumbers, RayNumbers, StarNumbers};
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::written_out::{Limits, MOST_TURNS, written_out};

/// The invocations of a workgroup.
const WORKGROUP: usize = 64;
/// Most workgroups along an axis of a dispatch.
const MAX_GROUPS: usize = 65535;
/// Units of the part of a star's photons that stays, as the shader has them.
const KEPT_UNITS: f64 = (1u64 << 30) as f64;
/// Bytes of a ray.
const RAY: u64 = size_of::<RayNumbers>() as u64;
/// Storage buffers that an entry binds.
const BUFFERS: u64 = 7;
/// Edges of a voxel from a star to the farthest corner that single precision resolves.
const FARTHEST: u64 = 20_000;
/// Voxels that are written to the device at once.
const WRITTEN: usize = 1 << 16;
/// Placeholder on a full device.
const INSTEAD: &str = "use the processor";
/// Bindings of the shader's entries.
const FOLLOWS: [u32; 9] = [0, 1, 2, 3, 4, 5, 6, 7, 8];
const SUMS_UP: [u32; 7] = [0, 2, 4, 5, 9, 10, 11];

/// The text of the shader.
pub const RAY_TRACER: &str = include_str!("../shaders/ray_tracer.wgsl");

/// The source of the shader.
pub fn source() -> String {
    let whole = [("QUADS", QUADS), ("VOXEL", VOXEL), ("BEHIND", BEHIND), ("GENERATIONS", GENERATIONS)];
    let singles = [("UNITS", UNITS), ("ALL", ALL), ("CHANGE", CHANGE), ("NONE", NONE)];
    let doubles = [("BEYOND", BEYOND), ("WIDEST", WIDEST), ("SPHERE", SPHERE), ("PARSEC_CM", PARSEC_CM), ("MOST_MADE", MOST_MADE)];
    let constants = whole.map(|(name, value)| format!("const {name} = {value}u;\n")).concat()
        + &singles.map(|(name, value)| format!("const {name}: f32 = {value:e};\n")).concat()
        + &doubles.map(|(name, value)| format!("const {name}: f32 = {:e};\n", value as f32)).concat();
    constants + &written_out(RAY_TRACER, &Limits { most: MOST_TURNS, numbers: vec![("QUADS", QUADS)], lists: Vec::new() })
}

/// The entries of the shader.
#[derive(Debug)]
struct TracerPipelines {
    follow: wgpu::ComputePipeline,
    sum_up: wgpu::ComputePipeline,
}

/// Rays of ionising light on a device.
#[derive(Debug, Default)]
pub struct IonisingRays {
    /// The device, once it is open, and why there is none.
    gpu: OnceLock<std::result::Result<Gpu, Failing>>,
    pipelines: OnceLock<Arc<TracerPipelines>>,
}

/// Why there is no device to trace on.
#[derive(Debug, Clone)]
enum Failing {
    /// It does not open, and why.
    Closed(String),
    /// It is software, which is slower than the processor that it runs on.
    Software,
}

impl IonisingRays {
    /// Traces on `gpu`.
    pub fn new(gpu: Gpu) -> Self {
        Self { gpu: OnceLock::from(Ok(gpu)), pipelines: OnceLock::new() }
    }

    /// Traces on the best device of this machine, which is opened once there is something to trace; not where that is software.
    pub fn once_asked() -> Self {
        Self::default()
    }

    /// The device, which is opened where it is not yet.
    fn gpu(&self) -> &std::result::Result<Gpu, Failing> {
        self.gpu.get_or_init(|| match Gpu::open() {
            Ok(gpu) if gpu.adapter.real => Ok(gpu),
            Ok(_) => Err(Failing::Software),
            Err(error) => Err(Failing::Closed(error.to_string())),
        })
    }
}

fn unable(error: GpuError) -> Failure {
    Failure::Unable(error.to_string())
}

impl RayTracer for IonisingRays {
    fn name(&self) -> String {
        self.gpu.get().and_then(|gpu| gpu.as_ref().ok()).map_or("gpu".into(), Gpu::name)
    }

    fn start<'a>(&self, task: Task<'a>) -> std::result::Result<Box<dyn Turns + 'a>, Failure> {
        let gpu = self.gpu().as_ref().map_err(|failing| match failing {
            Failing::Closed(why) => Failure::Unable(why.clone()),
            Failing::Software => Failure::NotFaster,
        })?;
        // Before anything is compiled that the device would complain of.
        let most = gpu.device.limits().max_storage_buffers_per_shader_stage.into();
        GpuError::too_large("the number of buffers of the shader", BUFFERS, most, INSTEAD).map_err(unable)?;
        let pipelines = self.pipelines.get_or_init(|| {
            let source = source();
            Arc::new(TracerPipelines { follow: gpu.pipeline(&source, "follow"), sum_up: gpu.pipeline(&source, "sum_up") })
        });
        Ok(Box::new(TurnsOnDevice::new(gpu.clone(), pipelines.clone(), task).map_err(unable)?))
    }
}

/// The buffers that do not change from star to star.
struct TracerBuffers {
    voxels: wgpu::Buffer,
    others: wgpu::Buffer,
    sums: wgpu::Buffer,
    /// Rays that come and that go, in turn.
    rays: [wgpu::Buffer; 2],
    counters: wgpu::Buffer,
    flux: wgpu::Buffer,
    rates: wgpu::Buffer,
    all_rates: wgpu::Buffer,
    generations: Vec<wgpu::Buffer>,
    /// By which results are read back.
    back: Option<wgpu::Buffer>,
}

/// A star on the device.
struct OfStar {
    numbers: wgpu::Buffer,
    spectrum: wgpu::Buffer,
    sent: Vec<RayNumbers>,
    generations: usize,
}

/// Turns of light on a device.
struct TurnsOnDevice<'a> {
    gpu: Gpu,
    pipelines: Arc<TracerPipelines>,
    task: Task<'a>,
    buffers: TracerBuffers,
    /// Rays that there is room for.
    room: usize,
    /// Bytes of all buffers.
    bytes: u64,
}

impl<'a> TurnsOnDevice<'a> {
    fn new(gpu: Gpu, pipelines: Arc<TracerPipelines>, task: Task<'a>) -> Result<Self> {
        let (cells, stars, row) = (task.cloud.hydrogen.len() as u64, task.stars.len() as u64, task.row() as u64);
        let room = rays_at_most(task.cloud);
        let sizes = [16 * VOXEL as u64 * cells, 4 * cells, 4 * (row + 1) * cells, RAY * room as u64, 4 * row * cells, 4 * stars * cells];
        let limits = gpu.device.limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        for bytes in sizes {
            GpuError::too_large("the size of a voxel's gas and light in bytes", bytes, most, INSTEAD)?;
        }
        for star in 0..task.stars.len() {
            let edges = task.rays(star).farthest() / task.cloud.voxel.min_element();
            GpuError::too_large("the distance from a star to the farthest corner of the cloud in voxels", edges as u64, FARTHEST, INSTEAD)?;
        }
        GpuError::too_large("the number of rays", room as u64, (MAX_GROUPS * WORKGROUP) as u64, INSTEAD)?;
        let [voxels, others, sums, rays, flux, rates] = sizes;
        let storage = |bytes: u64| gpu.buffer(bytes, Use::STORAGE | Use::COPY_DST | Use::COPY_SRC);
        let generation = |number: usize| gpu.filled(bytemuck::bytes_of(&GenerationNumbers { number: number as u32 }), Use::UNIFORM);
        let buffers = TracerBuffers {
            voxels: storage(voxels),
            others: storage(others),
            sums: storage(sums),
            rays: [storage(rays), storage(rays)],
            counters: storage(4 * (GENERATIONS as u64 + 2)),
            flux: storage(flux),
            rates: storage(rates),
            all_rates: storage(others),
            generations: (0..GENERATIONS - 1).map(generation).collect(),
            back: None,
        };
        let bytes = voxels + 2 * others + sums + 2 * rays + flux + rates;
        gpu.check(bytes)?;
        Ok(Self { gpu, pipelines, task, buffers, room, bytes })
    }

    /// The bind group of an entry.
    fn group(&self, pipeline: &wgpu::ComputePipeline, used: &[u32], star: &OfStar, generation: usize) -> wgpu::BindGroup {
        let TracerBuffers { voxels, others, sums, rays, counters, flux, rates, all_rates, generations, .. } = &self.buffers;
        let (coming, going) = (&rays[generation % 2], &rays[(generation + 1) % 2]);
        let number = &generations[generation];
        let all = [&star.numbers, number, &star.spectrum, voxels, others, sums, coming, going, counters, flux, rates, all_rates];
        self.gpu.group(&pipeline.get_bind_group_layout(0), used.iter().map(|i| (*i, all[*i as usize].as_entire_binding())))
    }

    /// Rays of a star on the device.
    fn of_star(&self, number: usize, is_known: bool) -> Result<OfStar> {
        let numbers = StarNumbers::new(&self.task, number, self.room, is_known);
        let sent = sent(&self.task, number);
        GpuError::too_large("the number of rays", sent.len() as u64, self.room as u64, INSTEAD)?;
        Ok(OfStar {
            numbers: self.gpu.filled(bytemuck::bytes_of(&numbers), Use::UNIFORM),
            spectrum: self.gpu.filled(bytemuck::cast_slice(&spectrum(&self.task, number)), Use::STORAGE),
            generations: generations(&self.task, number, &sent).min(self.buffers.generations.len()),
            sent,
        })
    }

    /// Has the light of a star go its way, and adds where it comes; gives the part of it that leaves the cloud.
    fn trace(&mut self, number: usize, is_known: bool) -> Result<f64> {
        let star = self.of_star(number, is_known)?;
        let cells = self.task.cloud.hydrogen.len();
        let mut counts = [0u32; GENERATIONS + 2];
        counts[0] = star.sent.len() as u32;
        self.gpu.queue.write_buffer(&self.buffers.counters, 0, bytemuck::cast_slice(&counts));
        self.gpu.queue.write_buffer(&self.buffers.rays[0], 0, bytemuck::cast_slice(&star.sent));
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("ionising light"), ..Default::default() });
            let TracerPipelines { follow, sum_up } = &*self.pipelines;
            pass.set_pipeline(follow);
            for generation in 0..star.generations {
                pass.set_bind_group(0, &self.group(follow, &FOLLOWS, &star, generation), &[]);
                pass.dispatch_workgroups(self.room.div_ceil(WORKGROUP) as u32, 1, 1);
            }
            pass.set_pipeline(sum_up);
            pass.set_bind_group(0, &self.group(sum_up, &SUMS_UP, &star, 0), &[]);
            let groups = cells.div_ceil(WORKGROUP);
            pass.dispatch_workgroups(groups.min(MAX_GROUPS) as u32, groups.div_ceil(MAX_GROUPS) as u32, 1);
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()?;
        self.gpu.check(self.bytes)?;
        let counted = self.gpu.read(&self.buffers.counters, 4 * (GENERATIONS as u64 + 2), &mut None)?;
        let counted: Vec<u32> = bytemuck::pod_collect_to_vec(&counted);
        let most = counted[..GENERATIONS].iter().max().map_or(0, |most| *most);
        GpuError::too_large("the number of rays", most.into(), self.room as u64, INSTEAD)?;
        GpuError::too_large("the number of rays with too many splits", counted[star.generations].into(), 0, INSTEAD)?;
        Ok((1.0 - f64::from(counted[GENERATIONS + 1]) / KEPT_UNITS).clamp(0.0, 1.0))
    }

    fn turn(&mut self, voxels: Option<&[Voxel]>, light: &mut Light, listener: Listener) -> Result<Option<Vec<f64>>> {
        let cells = self.task.cloud.hydrogen.len();
        let queue = &self.gpu.queue;
        for first in (0..cells).step_by(WRITTEN) {
            let quads = voxel_quads(self.task.cloud, voxels, first..cells.min(first + WRITTEN));
            queue.write_buffer(&self.buffers.voxels, (VOXEL * 16 * first) as u64, bytemuck::cast_slice(&quads));
            // What waits to be written takes memory.
            queue.submit([]);
        }
        let all: Vec<f32> = (0..cells).map(|voxel| light.rates.iter().map(|rates| rates[voxel]).sum()).collect();
        let others: Vec<f32> = all.iter().zip(&light.rates[0]).map(|(all, rate)| (all - rate).max(0.0)).collect();
        queue.write_buffer(&self.buffers.all_rates, 0, bytemuck::cast_slice(&all));
        queue.write_buffer(&self.buffers.others, 0, bytemuck::cast_slice(&others));
        for (number, rates) in light.rates.iter().enumerate() {
            queue.write_buffer(&self.buffers.rates, (4 * cells * number) as u64, bytemuck::cast_slice(rates));
        }
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.buffers.flux, 0, None);
        encoder.clear_buffer(&self.buffers.sums, 0, None);
        self.gpu.queue.submit([encoder.finish()]);
        let mut escaped = Vec::new();
        for number in 0..self.task.stars.len() {
            escaped.push(self.trace(number, voxels.is_some())?);
            if !listener(cells as u64) {
                return Ok(None);
            }
        }
        let TracerBuffers { flux, rates, back, .. } = &mut self.buffers;
        self.gpu.read_as(flux, flux.size(), back, |bytes| light.flux.copy_from_slice(bytemuck::cast_slice(bytes)))?;
        self.gpu.read_as(rates, rates.size(), back, |bytes| {
            let all: &[f32] = bytemuck::cast_slice(bytes);
            light.rates.iter_mut().zip(all.chunks_exact(cells)).for_each(|(to, from)| to.copy_from_slice(from));
        })?;
        Ok(Some(escaped))
    }
}

impl Turns for TurnsOnDevice<'_> {
    fn next(&mut self, voxels: Option<&[Voxel]>, light: &mut Light, listener: Listener) -> std::result::Result<Vec<f64>, Failure> {
        self.turn(voxels, light, listener).map_err(unable)?.ok_or(Failure::Stopped)
    }
}
