//! Star depths on the device: one star's channel anew, all others as they are.

use barnard::field::Lattice;
use barnard::plan::star_depths::OPAQUE;
use barnard::plan::star_depths::frustum::{Frustum, TierOf, frustums};
use barnard::plan::star_depths::frustum_sweep::{BEYOND, GAUSS};
use barnard::volume::Volume;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use wgpu::BufferUsages as Use;

use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::textures::usable;

/// The fields are those of `sweep.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct SweepNumbers {
    pub apex: [f32; 4],
    pub along_u: [f32; 4],
    pub along_v: [f32; 4],
    pub along_w: [f32; 4],
    pub star: [f32; 4],
    pub slopes: [f32; 4],
    pub edge: [f32; 4],
    pub sides: [f32; 4],
    pub counts: [u32; 4],
    pub dims: [u32; 4],
    pub strides: [i32; 4],
}

/// The fields are those of `pack.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct PackNumbers {
    pub dims: [u32; 4],
    pub scale: [f32; 4],
}

/// The source of the sweep.
pub fn sweep_source() -> String {
    format!(
        "const GAUSS_LOW: f32 = {:e};\nconst GAUSS_HIGH: f32 = {:e};\nconst BEYOND: f32 = {BEYOND:e};\nconst OPAQUE: f32 = {OPAQUE:e};\nconst FAR: f32 = 1e30;\n\n{}",
        GAUSS[0] as f32, GAUSS[1] as f32, SWEEP
    )
}

/// The text of the shader.
pub const SWEEP: &str = include_str!("shaders/sweep.wgsl");
pub const PACK: &str = include_str!("shaders/pack.wgsl");

/// Numbers that the rays of a dispatch keep at most.
const KEPT: usize = 1 << 24;

/// A channel of a texture: the volume that it shows, which of the four, and what a stored one stands for.
pub struct Slot<'a> {
    pub view: &'a wgpu::TextureView,
    pub volume: &'a Volume,
    pub lane: usize,
    pub unit: f32,
}

/// Voxels between the box and a star that is swept on the device at most.
const FURTHEST: f64 = 1e5;

/// Refuses places and sizes that a sweep cannot do.
fn check(gpu: &Gpu, inner: &Lattice, star: DVec3) -> Result<()> {
    if !star.is_finite() {
        return Err(GpuError::Place(star.into(), "its coordinates must be finite"));
    }
    let middle = 0.5 * (inner.bounds.low + inner.bounds.high);
    if ((star - middle) / inner.voxel_pc()).abs().max_element() > FURTHEST {
        return Err(GpuError::Place(star.into(), "it is too far for single precision; make a new plan"));
    }
    let most = gpu.device.limits().max_storage_buffer_binding_size;
    let instead = "make a new plan, which uses the processor";
    GpuError::too_large("the depths of a star in bytes", 4 * inner.cells() as u64, most, instead)
}

/// The shaders of a sweep.
pub struct StarSweeper {
    follow: wgpu::ComputePipeline,
    collect: wgpu::ComputePipeline,
    settle: wgpu::ComputePipeline,
    carry_on: wgpu::ComputePipeline,
}

impl StarSweeper {
    /// A sweep on `gpu`.
    pub fn new(gpu: &Gpu) -> Self {
        let sweep = sweep_source();
        Self {
            follow: gpu.pipeline(&sweep, "follow"),
            collect: gpu.pipeline(&sweep, "collect"),
            settle: gpu.pipeline(PACK, "settle"),
            carry_on: gpu.pipeline(PACK, "carry_on"),
        }
    }

    /// A texture like that of `target`, with the depths from `star` through `dust` in its channel, and the seconds of
    /// the device if it measures it.
    ///
    /// # Errors
    /// For places that are none or too far, volumes beyond the device's limits, and devices that give up.
    pub fn swept(&self, gpu: &Gpu, dust: &Slot, target: &Slot, star: DVec3) -> Result<(wgpu::TextureView, Option<f64>)> {
        let Self { follow, collect, settle, carry_on } = self;
        let inner = &target.volume.inner;
        check(gpu, inner, star)?;
        // Buffers start as zero, which is the star's own voxel.
        let depths = gpu.buffer(4 * inner.cells() as u64, Use::STORAGE);
        let settled = gpu.buffer(4 * inner.cells() as u64, Use::STORAGE);
        let parts: Vec<SweepNumbers> = frustums(inner, star).iter().flat_map(|frustum| parts(frustum, dust, inner)).collect();
        let most = parts.iter().map(depths_of).max().unwrap_or(1);
        let rays = gpu.buffer(4 * most.max(1) as u64, Use::STORAGE);
        let sampler = gpu.sampler();
        let group = |pipeline: &wgpu::ComputePipeline, resources: Vec<(u32, wgpu::BindingResource)>| {
            gpu.group(&pipeline.get_bind_group_layout(0), resources)
        };
        let view = usable(gpu, target.volume.lattice.dims);
        let times = gpu.timer.as_ref().map(|_| gpu.buffer(16, Use::QUERY_RESOLVE | Use::COPY_SRC));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let timestamp_writes = gpu.timestamps();
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("sweep"), timestamp_writes });
            for part in &parts {
                let numbers = gpu.filled(bytemuck::bytes_of(part), Use::UNIFORM);
                let [numbers, rays, depths] = [&numbers, &rays, &depths].map(|b| b.as_entire_binding());
                let reading = [(1, wgpu::BindingResource::TextureView(dust.view)), (2, wgpu::BindingResource::Sampler(&sampler))];
                let both: Vec<_> = [(0, numbers), (3, rays)].into_iter().chain(reading).collect();
                pass.set_pipeline(follow);
                pass.set_bind_group(0, &group(follow, both.clone()), &[]);
                pass.dispatch_workgroups(part.counts[0].div_ceil(8), part.counts[1].div_ceil(8), 1);
                pass.set_pipeline(collect);
                pass.set_bind_group(0, &group(collect, both.into_iter().chain([(4, depths)]).collect()), &[]);
                pass.dispatch_workgroups(part.dims[0].div_ceil(8), part.dims[1].div_ceil(8), part.counts[3] - part.counts[2]);
            }
            let [x, y, z] = inner.dims.map(|n| n as u32);
            let numbers = PackNumbers { dims: [x, y, z, target.lane as u32], scale: [1.0 / target.unit, 0.0, 0.0, 0.0] };
            let numbers = gpu.filled(bytemuck::bytes_of(&numbers), Use::UNIFORM);
            let [numbers, depths, settled] = [&numbers, &depths, &settled].map(|b| b.as_entire_binding());
            pass.set_pipeline(settle);
            pass.set_bind_group(0, &group(settle, vec![(0, numbers.clone()), (1, depths), (4, settled.clone())]), &[]);
            let [i, j, k] = [x, y, z].map(|n| n.div_ceil(4));
            pass.dispatch_workgroups(i, j, k);
            let textures = [(2, target.view), (3, &view)].map(|(i, view)| (i, wgpu::BindingResource::TextureView(view)));
            pass.set_pipeline(carry_on);
            pass.set_bind_group(0, &group(carry_on, [(0, numbers), (4, settled)].into_iter().chain(textures).collect()), &[]);
            let [i, j, k] = [x, y, z].map(|n| (n + 2).div_ceil(4));
            pass.dispatch_workgroups(i, j, k);
        }
        if let (Some(timer), Some(times)) = (&gpu.timer, &times) {
            encoder.resolve_query_set(timer, 0..2, times, 0);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        gpu.check(8 * target.volume.lattice.cells() as u64 + 4 * (inner.cells() + most) as u64)?;
        let seconds = times.map(|times| gpu.read(&times, 16, &mut None).map(|values| gpu.seconds(&values, 16)));
        Ok((view, seconds.transpose()?))
    }
}

/// Depths that the rays of a part keep.
fn depths_of(part: &SweepNumbers) -> usize {
    part.counts[0] as usize * part.counts[1] as usize * (part.counts[3] - part.counts[2]) as usize
}

/// A frustum in parts: tiers, and planes of them that fit.
fn parts(frustum: &Frustum, dust: &Slot, inner: &Lattice) -> Vec<SweepNumbers> {
    let planes = frustum.planes();
    let Some(first) = planes.first() else { return Vec::new() };
    let swept = SweptFrustum { frustum, dust, inner, first: *first };
    frustum.tiers().iter().flat_map(|tier| pieces(tier).map(|part| swept.numbers(&part, tier.end))).collect()
}

/// Runs of a tier's planes whose depths fit into what is kept.
fn pieces(tier: &TierOf) -> impl Iterator<Item = TierOf> + use<'_> {
    let together = (KEPT / (tier.rays.counts[0] * tier.rays.counts[1])).max(1);
    let begins = (tier.begin..tier.end).step_by(together);
    begins.map(move |begin| TierOf { rays: tier.rays.clone(), begin, end: tier.end.min(begin + together) })
}

/// A frustum that is swept through the texture of a dust, with the voxels in which depths are settled.
struct SweptFrustum<'a> {
    frustum: &'a Frustum,
    dust: &'a Slot<'a>,
    inner: &'a Lattice,
    /// The first plane of the frustum.
    first: usize,
}

impl SweptFrustum<'_> {
    /// Texture coordinates from voxel to voxel.
    fn step(&self) -> DVec3 {
        self.inner.voxel_pc() / self.dust.volume.lattice.bounds.size()
    }

    /// Texture coordinates from voxel to voxel along an axis of the frustum.
    fn along(&self, axis: usize) -> DVec3 {
        let mut along = DVec3::ZERO;
        along[self.frustum.axes[axis]] = self.step()[self.frustum.axes[axis]];
        along
    }

    /// Texture coordinates of the star.
    fn apex(&self) -> DVec3 {
        let outer = &self.dust.volume.lattice.bounds;
        let origin = (self.inner.bounds.low - outer.low) / outer.size() + 0.5 * self.step();
        origin + (0..3).map(|i| self.frustum.star[i] * self.along(i)).sum::<DVec3>()
    }

    /// Voxels from one to the next along an axis of the frustum.
    fn stride(&self, axis: usize) -> i32 {
        [1, self.inner.dims[0], self.inner.dims[0] * self.inner.dims[1]][self.frustum.axes[axis]] as i32
    }

    /// The numbers of a part of a tier that goes on up to plane `last`.
    fn numbers(&self, part: &TierOf, last: usize) -> SweepNumbers {
        let (frustum, dust) = (self.frustum, self.dust);
        let four = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32, 0.0];
        let side = |i: usize| frustum.side(i).map_or(0.0, |border| (border - frustum.star[i]) as f32);
        SweepNumbers {
            apex: four(self.apex()),
            along_u: four(self.along(0)),
            along_v: four(self.along(1)),
            along_w: four(frustum.sign * self.along(2)),
            star: [frustum.star[0] as f32, frustum.star[1] as f32, dust.unit, 0.0],
            slopes: [part.rays.first[0] as f32, part.rays.first[1] as f32, part.rays.spacing as f32, frustum.entry() as f32],
            edge: [frustum.edge[0] as f32, frustum.edge[1] as f32, frustum.edge[2] as f32, frustum.distance(self.first) as f32],
            sides: [side(0), side(1), last as f32, 0.0],
            counts: [part.rays.counts[0], part.rays.counts[1], part.begin, part.end].map(|n| n as u32),
            dims: [frustum.dims[0], frustum.dims[1], self.first, dust.lane].map(|n| n as u32),
            strides: [self.stride(0), self.stride(1), self.stride(2), frustum.sign as i32],
        }
    }
}
