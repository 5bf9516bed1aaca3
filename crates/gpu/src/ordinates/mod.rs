//! Orders of scattering on the device: what [`barnard::plan::ordinates::Processor`] does, plane after plane, one
//! invocation for each cell and term.

mod numbers;

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use barnard::control::Control;
use barnard::plan::ordinates::{EightLanes, Failure, Moments, Orders, Powers, Sweeper, THIN_CELL, Transfer, WIDTH};
use wgpu::BufferUsages as Use;

use self::numbers::{HEAD, SweepNumbers, beams, beams_of, faces, planes};
pub use self::numbers::{PlaneNumbers, TermNumbers};
use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::written_out::{Limits, written_out};

/// The invocations of a workgroup.
const WORKGROUP: usize = 64;
/// Chunks of cells whose power is summed in single precision.
const CHUNKS: usize = 1024;
/// Most workgroups of a dispatch.
const MAX_GROUPS: usize = 65535;
/// The bytes of two numbers for each term.
const PAIRS: u64 = 2 * size_of::<EightLanes>() as u64;
/// Binding of the numbers of a plane.
const PLANE: u32 = 1;

/// The text of the shader.
pub const ORDINATES: &str = include_str!("../shaders/ordinates.wgsl");

/// The source for a number of harmonics of a cell and directions of a face.
pub fn source(harmonics: usize, beams: usize) -> String {
    let constants = [("WIDTH", WIDTH), ("HARMONICS", harmonics), ("BEAMS", beams), ("HEAD", HEAD), ("CHUNKS", CHUNKS)];
    let line = |(name, value): (&str, usize)| format!("const {name} = {value}u;\n");
    let written = written_out(ORDINATES, &Limits { most: beams, numbers: vec![("BEAMS", beams)], lists: Vec::new() });
    constants.into_iter().map(line).collect::<String>() + &format!("const THIN_CELL: f32 = {THIN_CELL:e};\n\n") + &written
}

/// The entries of the shader.
#[derive(Debug)]
struct SweepPipelines {
    scatter: wgpu::ComputePipeline,
    sweep: wgpu::ComputePipeline,
    add: wgpu::ComputePipeline,
    power: wgpu::ComputePipeline,
}

/// The sweeps of discrete ordinates on a device.
#[derive(Debug)]
pub struct Ordinates {
    gpu: Gpu,
    /// The pipelines that were made, by harmonics and directions.
    made: Mutex<HashMap<(usize, usize), Arc<SweepPipelines>>>,
}

impl Ordinates {
    /// Sweeps on `gpu`.
    pub fn new(gpu: Gpu) -> Self {
        Self { gpu, made: Mutex::default() }
    }

    /// The sweeper of a device, where that is faster: software is slower than the processor that it runs on.
    pub fn if_faster(gpu: &Gpu) -> Option<Arc<dyn Sweeper>> {
        gpu.adapter.real.then(|| Arc::new(Self::new(gpu.clone())) as Arc<dyn Sweeper>)
    }

    fn pipelines(&self, harmonics: usize, beams: usize) -> Arc<SweepPipelines> {
        let make = || {
            let source = source(harmonics, beams);
            let entry = |entry: &str| self.gpu.pipeline(&source, entry);
            Arc::new(SweepPipelines { scatter: entry("scatter"), sweep: entry("sweep"), add: entry("add"), power: entry("power") })
        };
        match self.made.lock() {
            Ok(mut made) => made.entry((harmonics, beams)).or_insert_with(make).clone(),
            Err(_) => make(),
        }
    }
}

fn unable(error: GpuError) -> Failure {
    match error {
        GpuError::Render(error) => Failure::Stopped(error),
        error => Failure::Unable(error.to_string()),
    }
}

impl Sweeper for Ordinates {
    fn name(&self) -> String {
        self.gpu.name()
    }

    fn start<'a>(&self, transfer: Transfer<'a>, first: Moments) -> std::result::Result<Box<dyn Orders + 'a>, Failure> {
        let pipelines = self.pipelines(first.count, beams_of(&transfer));
        let on_device = SweepOnDevice::new(self.gpu.clone(), pipelines, &transfer, &first);
        Ok(Box::new(on_device.map_err(unable)?))
    }
}

/// The work of one plane of a face.
struct FacePlane {
    group: wgpu::BindGroup,
    groups: u32,
}

/// The buffers that the shader reads and writes, in the order of its bindings.
struct SweepBuffers {
    terms: wgpu::Buffer,
    planes: wgpu::Buffer,
    sigma: wgpu::Buffer,
    scattering: wgpu::Buffer,
    beams: wgpu::Buffer,
    glow: wgpu::Buffer,
    source: wgpu::Buffer,
    order: wgpu::Buffer,
    sum: wgpu::Buffer,
    memory: wgpu::Buffer,
    powers: wgpu::Buffer,
    /// The bytes from the numbers of one plane to those of the next.
    apart: usize,
}

impl SweepBuffers {
    /// The buffers of a transfer that starts with `first`, and the bytes of what is large.
    fn new(gpu: &Gpu, transfer: &Transfer, first: &Moments, numbers: &SweepNumbers) -> Result<(Self, u64)> {
        let SweepNumbers { terms, planes } = numbers;
        let Transfer { cells, scattering, glow, .. } = *transfer;
        let moments = Moments::bytes(cells.lattice.cells(), first.count);
        let widest = cells.lattice.dims.map(|n| cells.lattice.cells() / n).into_iter().max().unwrap_or(0);
        let memory = (2 * widest * beams_of(transfer)) as u64 * PAIRS;
        let limits = gpu.device.limits();
        let room = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let instead = "use the processor";
        GpuError::too_large("the size of light in cells in bytes", moments.max(memory), room, instead)?;
        GpuError::too_large("the number of cells", cells.lattice.cells() as u64, (MAX_GROUPS * WORKGROUP / WIDTH) as u64, instead)?;
        // Every plane's numbers stand where a device may begin to read.
        let apart = (limits.min_uniform_buffer_offset_alignment as usize).max(size_of::<PlaneNumbers>());
        let mut placed = vec![0; apart * planes.len()];
        placed.chunks_exact_mut(apart).zip(planes).for_each(|(to, plane)| {
            to[..size_of::<PlaneNumbers>()].copy_from_slice(bytemuck::bytes_of(plane));
        });
        let beams: Vec<f32> = faces(transfer).flat_map(|face| beams(cells, face, beams_of(transfer), first.count)).collect();
        // Buffers start as zero.
        let buffers = Self {
            terms: gpu.filled(bytemuck::bytes_of(terms), Use::UNIFORM),
            planes: gpu.filled(&placed, Use::UNIFORM),
            sigma: gpu.filled(bytemuck::cast_slice(&cells.sigma), Use::STORAGE),
            scattering: gpu.filled(bytemuck::cast_slice(scattering), Use::STORAGE),
            beams: gpu.filled(bytemuck::cast_slice(&beams), Use::STORAGE),
            glow: gpu.filled(bytemuck::cast_slice(glow.unwrap_or(&[[0.0; WIDTH]])), Use::STORAGE),
            source: gpu.buffer(moments, Use::STORAGE | Use::COPY_DST),
            order: gpu.filled(bytemuck::cast_slice(&first.data), Use::STORAGE),
            sum: gpu.buffer(moments, Use::STORAGE | Use::COPY_SRC),
            memory: gpu.buffer(memory, Use::STORAGE),
            powers: gpu.buffer(CHUNKS as u64 * PAIRS, Use::STORAGE | Use::COPY_SRC),
            apart,
        };
        Ok((buffers, 3 * moments + memory))
    }

    /// The bind group of an entry, with the numbers of one plane if it reads them.
    fn group(&self, gpu: &Gpu, pipeline: &wgpu::ComputePipeline, used: &[u32], plane: usize) -> wgpu::BindGroup {
        let Self { terms, planes, sigma, scattering, beams, glow, source, order, sum, memory, powers, apart } = self;
        let all = [terms, planes, sigma, scattering, beams, glow, source, order, sum, memory, powers];
        let bound = |binding: u32| match binding {
            PLANE => {
                let size = std::num::NonZeroU64::new(size_of::<PlaneNumbers>() as u64);
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: planes, offset: (plane * apart) as u64, size })
            }
            other => all[other as usize].as_entire_binding(),
        };
        gpu.group(&pipeline.get_bind_group_layout(0), used.iter().map(|binding| (*binding, bound(*binding))))
    }
}

struct SweepOnDevice {
    gpu: Gpu,
    pipelines: Arc<SweepPipelines>,
    harmonics: usize,
    /// The numbers of the first order, in which alone gas and light from around shine.
    shining: TermNumbers,
    buffers: SweepBuffers,
    back: Option<wgpu::Buffer>,
    scatter: wgpu::BindGroup,
    add: wgpu::BindGroup,
    power: wgpu::BindGroup,
    /// The planes of each face of the first order, and of all others, in the order of the sweep.
    planes: [Vec<Vec<FacePlane>>; 2],
    is_first: bool,
    bytes: u64,
}

impl SweepOnDevice {
    fn new(gpu: Gpu, pipelines: Arc<SweepPipelines>, transfer: &Transfer, first: &Moments) -> Result<Self> {
        let Transfer { cells, k, glow, around, .. } = *transfer;
        let shining = TermNumbers {
            k: *k,
            around: *around,
            factor: [1.0; WIDTH],
            cells: cells.lattice.cells() as u32,
            glows: u32::from(glow.is_some()),
            least: cells.least,
            nothing: 0,
        };
        let dark = TermNumbers { glows: 0, around: [0.0; WIDTH], ..shining };
        let of_face = beams_of(transfer) * (HEAD + 2 * first.count);
        let numbered: Vec<Vec<PlaneNumbers>> = faces(transfer).enumerate().map(|(f, face)| planes(cells, face, f * of_face)).collect();
        let (buffers, bytes) = SweepBuffers::new(&gpu, transfer, first, &SweepNumbers { terms: dark, planes: numbered.concat() })?;
        let mut number = 0..;
        let mut plane = |plane: &PlaneNumbers| FacePlane {
            group: buffers.group(&gpu, &pipelines.sweep, &[0, PLANE, 2, 4, 5, 6, 7, 9], number.next().unwrap_or(0)),
            groups: groups((plane.columns * plane.rows) as usize * WIDTH),
        };
        let mut planes: Vec<Vec<FacePlane>> = numbered.iter().map(|face| face.iter().map(&mut plane).collect()).collect();
        let others = planes.split_off(transfer.faces[0].len());
        let whole = |pipeline, used| buffers.group(&gpu, pipeline, used, 0);
        let scatter = whole(&pipelines.scatter, &[0, 3, 6, 7]);
        let add = whole(&pipelines.add, &[0, 7, 8]);
        let power = whole(&pipelines.power, &[0, 2, 7, 8, 10]);
        gpu.wait()?;
        gpu.check(bytes)?;
        Ok(Self {
            gpu,
            pipelines,
            harmonics: first.count,
            shining,
            buffers,
            back: None,
            scatter,
            add,
            power,
            planes: [planes, others],
            is_first: true,
            bytes,
        })
    }

    /// Adds the order to the sum, by the factor that the shader received.
    fn add(&self, pass: &mut wgpu::ComputePass) {
        pass.set_pipeline(&self.pipelines.add);
        pass.set_bind_group(0, &self.add, &[]);
        pass.dispatch_workgroups(self.cells(), 1, 1);
    }

    /// Submits `work` in one pass.
    fn submit(&self, work: impl FnOnce(&mut wgpu::ComputePass)) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        work(&mut encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("ordinates"), timestamp_writes: None }));
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Dispatches for each cell and term.
    fn cells(&self) -> u32 {
        groups(self.shining.cells as usize * WIDTH)
    }

    fn tell(&self, numbers: TermNumbers) {
        self.gpu.queue.write_buffer(&self.buffers.terms, 0, bytemuck::bytes_of(&numbers));
    }

    /// Sweeps along the directions of the first order, or of all others; a submission for each face, so that displays
    /// that share the device wait no longer for it.
    fn sweep(&self, set: usize) {
        for face in &self.planes[set] {
            self.submit(|pass| {
                pass.set_pipeline(&self.pipelines.sweep);
                for plane in face {
                    pass.set_bind_group(0, &plane.group, &[]);
                    pass.dispatch_workgroups(plane.groups, 1, 1);
                }
            });
        }
    }

    fn order(&mut self) -> Result<(Powers, Powers)> {
        self.submit(|pass| {
            pass.set_pipeline(&self.pipelines.scatter);
            pass.set_bind_group(0, &self.scatter, &[]);
            pass.dispatch_workgroups(self.cells(), 1, 1);
        });
        self.sweep(usize::from(!self.is_first));
        if std::mem::take(&mut self.is_first) && (self.shining.glows != 0 || self.shining.around != [0.0; WIDTH]) {
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            encoder.clear_buffer(&self.buffers.source, 0, None);
            self.gpu.queue.submit([encoder.finish()]);
            self.tell(self.shining);
            self.sweep(1);
            self.tell(TermNumbers { glows: 0, around: [0.0; WIDTH], ..self.shining });
        }
        self.submit(|pass| {
            self.add(pass);
            pass.set_pipeline(&self.pipelines.power);
            pass.set_bind_group(0, &self.power, &[]);
            pass.dispatch_workgroups(groups(CHUNKS * WIDTH), 1, 1);
        });
        let found = self.gpu.read(&self.buffers.powers, CHUNKS as u64 * PAIRS, &mut self.back)?;
        let (mut order, mut sum) = ([0.0; WIDTH], [0.0; WIDTH]);
        for chunk in found.chunks_exact(PAIRS as usize) {
            let powers: [[f32; 2]; WIDTH] = bytemuck::pod_read_unaligned(chunk);
            for (t, [o, s]) in powers.into_iter().enumerate() {
                order[t] += f64::from(o);
                sum[t] += f64::from(s);
            }
        }
        Ok((order, sum))
    }

    fn total(self, last: &EightLanes) -> Result<Moments> {
        self.tell(TermNumbers { factor: *last, glows: 0, ..self.shining });
        self.submit(|pass| self.add(pass));
        let count = self.harmonics;
        let size = Moments::bytes(self.shining.cells as usize, count);
        let data = self.gpu.read_as(&self.buffers.sum, size, &mut None, |bytes| {
            bytes.chunks_exact(size_of::<EightLanes>()).map(bytemuck::pod_read_unaligned).collect()
        })?;
        self.gpu.check(self.bytes)?;
        Ok(Moments { count, data })
    }
}

impl Orders for SweepOnDevice {
    fn next(&mut self, control: &Control) -> std::result::Result<(Powers, Powers), Failure> {
        control.check()?;
        self.order().map_err(unable)
    }

    fn sum(self: Box<Self>, last: &EightLanes) -> std::result::Result<Moments, Failure> {
        self.total(last).map_err(unable)
    }
}

/// Workgroups for a given number of invocations.
fn groups(invocations: usize) -> u32 {
    invocations.div_ceil(WORKGROUP) as u32
}
