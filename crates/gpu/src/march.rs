//! The march on a device: volumes up, strips of rows, radiance down.
//!
//! A [`DeviceMarch`] keeps what a change leaves as it was: textures as long as the space is the same, and the pipelines of
//! the last shapes.

use std::sync::Arc;

use barnard::backend::RenderStats;
use barnard::control::{Control, Stage};
use barnard::image::Tone;
use barnard::plan::Plan;
use barnard::volume::{Channel, Volume};
use glam::DVec3;
use web_time::Instant;

use crate::device::Gpu;
use crate::error::{GpuError, Result};
use crate::frame::{FrameRows, Pass, Patience, Strip};
use crate::layout::{ShaderLayout, quads};
use crate::pipelines::Pipelines;
use crate::resolve::Resolver;
use crate::resources::{Buffers, REPORT_BYTES, TIMED, TIMES, Volumes, check_limits, groups, pauses, tuned};
use crate::shader_constants::Pauses;
use crate::sweep::{Slot, StarSweeper};
use crate::tables::{Quad, slot_of};
use crate::tuning::Tuning;

/// Rays of the first dispatch at most; what follows takes as many rows as are done in [`SLICE`].
const FIRST_RAYS: usize = 1 << 17;
/// The time that one dispatch may take before somebody may wish to stop [s]; drivers give up on what takes seconds.
const SLICE: f64 = 0.1;

/// Rows of the first dispatch.
fn first_pace(layout: &ShaderLayout) -> usize {
    let [width, height, ..] = layout.frame.size.map(|n| n as usize);
    (FIRST_RAYS / width).clamp(1, height)
}

/// A plan on a device.
pub struct DeviceMarch {
    gpu: Gpu,
    tuning: Tuning,
    layout: ShaderLayout,
    volumes: Volumes,
    pipelines: Pipelines,
    pipeline: wgpu::ComputePipeline,
    buffers: Buffers,
    groups: [wgpu::BindGroup; 2],
    /// Rows that are done in about [`SLICE`].
    pace: usize,
    /// Turns of loops before rays pause, in software.
    patience: Patience,
    /// Passes that the picture on the device is the mean of.
    passes: u32,
    resolver: Option<Resolver>,
    sweeper: Option<StarSweeper>,
    /// Dispatches of the last picture.
    dispatches: usize,
    /// Time of the device for the last picture [s].
    seconds: Option<f64>,
}

impl DeviceMarch {
    /// Puts a plan onto a device.
    ///
    /// # Errors
    /// For methods that no shader has, and for grids beyond the device's limits.
    pub fn new(gpu: &Gpu, plan: &Plan, tuning: Tuning) -> Result<Self> {
        let layout = tuned(ShaderLayout::new(plan, quads(plan, 0), tuning.on_the_fly)?, tuning);
        check_limits(gpu, plan, &layout)?;
        let volumes = Volumes::new(gpu, plan, &layout, &[]);
        let mut pipelines = Pipelines::new(tuning);
        let pipeline = pipelines.of(gpu, &layout);
        let buffers = Buffers::new(gpu, &layout, pauses(gpu, tuning))?;
        let groups = groups(gpu, &pipeline, &layout, &volumes, &buffers);
        let pace = first_pace(&layout);
        let renderer = Self {
            gpu: gpu.clone(),
            tuning,
            layout,
            volumes,
            pipelines,
            pipeline,
            buffers,
            groups,
            pace,
            patience: Patience::FULL,
            passes: 0,
            resolver: None,
            sweeper: None,
            dispatches: 0,
            seconds: None,
        };
        renderer.check()?;
        Ok(renderer)
    }

    /// Takes another plan: what has changed is uploaded, what has not stays.
    ///
    /// # Errors
    /// As [`new`](Self::new); the plan before stays in place then.
    pub fn update(&mut self, plan: &Plan) -> Result<()> {
        let field = plan.light_field().is_some() || self.layout.shape.field.is_some();
        let same_space = Arc::ptr_eq(plan.space(), &self.volumes.space) && !self.volumes.moved && !field;
        let same_volumes = same_space
            && match (&plan.scattered_field(), &self.volumes.scattered_field) {
                (Some(new_part), Some(before)) => Arc::ptr_eq(new_part, before),
                (new_part, before) => new_part.is_none() && before.is_none(),
            };
        // What the space holds comes first, and stays; light that was scattered may have changed, or be seen from
        // elsewhere.
        let of_space = plan.space().volumes.len();
        let reused = if same_space { self.layout.quads.iter().filter(|q| q.volume < of_space).count() } else { 0 };
        let quads = match (same_volumes, same_space) {
            (true, _) => self.layout.quads.clone(),
            (false, true) => self.layout.quads[..reused].iter().copied().chain(quads(plan, of_space)).collect(),
            (false, false) => quads(plan, 0),
        };
        let layout = tuned(ShaderLayout::new(plan, quads, self.tuning.on_the_fly)?, self.tuning);
        check_limits(&self.gpu, plan, &layout)?;
        let carried = |layout: &ShaderLayout| (layout.frame.size, layout.shape.bands(), layout.shape.sums(), layout.shape.field_channels());
        let same_size = carried(&layout) == carried(&self.layout);
        let buffers = if same_size { None } else { Some(Buffers::new(&self.gpu, &layout, self.pauses())?) };
        let views = if same_volumes { &self.volumes.views[..] } else { &self.volumes.views[..reused] };
        let same_volumes = same_volumes && layout.bricks == self.layout.bricks;
        let volumes = (!same_volumes).then(|| Volumes::new(&self.gpu, plan, &layout, views));
        let same_shape = layout.shape == self.layout.shape && layout.offsets == self.layout.offsets;
        let pipeline = self.pipelines.of(&self.gpu, &layout);
        let groups =
            groups(&self.gpu, &pipeline, &layout, volumes.as_ref().unwrap_or(&self.volumes), buffers.as_ref().unwrap_or(&self.buffers));
        // Nothing is taken that the device has complained of.
        self.gpu.check(volumes.as_ref().unwrap_or(&self.volumes).bytes + buffers.as_ref().map_or(0, |b| b.picture.size()))?;
        let work = |layout: &ShaderLayout| (layout.frame.steps, layout.frame.counts);
        if !(same_volumes && same_size && same_shape && work(&layout) == work(&self.layout)) {
            self.pace = first_pace(&layout);
        }
        self.groups = groups;
        if let Some(buffers) = buffers {
            self.buffers = buffers;
        }
        if let Some(volumes) = volumes {
            self.volumes = volumes;
        }
        self.pipeline = pipeline;
        self.layout = layout;
        self.passes = 0;
        Ok(())
    }

    /// True if the depths of a star can be swept on the device: where neither they nor the dust stand in pages.
    pub fn can_move(&self, star: usize) -> bool {
        let space = &self.volumes.space;
        let is_whole = |channel: &Channel| space.volumes.iter().filter(|v| v.channels.contains(channel)).all(|v| v.pages().is_whole());
        [Channel::StarDepth(star), Channel::Dust].iter().all(is_whole)
    }

    /// Puts star `star` to `place` \[pc\]: its depths are swept anew on the device, all others stay. Light that was
    /// scattered before stays that of the place before. A plan that is taken later has its own places again. Returns
    /// the device's seconds for it, if it measures them.
    ///
    /// # Errors
    /// If the plan has no such star, or no star depths, and if the device gives up; the star stays where it was
    /// then.
    pub fn move_star(&mut self, star: usize, place: DVec3) -> Result<Option<f64>> {
        let space = self.volumes.space.clone();
        let volumes: Vec<&Volume> = space.volumes.iter().map(|volume| &**volume).collect();
        let target = slot_of(&self.layout.quads, &volumes, Channel::StarDepth(star));
        let (Some(target), Some(dust)) = (target, self.layout.shape.dust) else {
            return Err(GpuError::NoStar(star, space.stars.len()));
        };
        if !self.can_move(star) {
            return Err(GpuError::InPages(star));
        }
        let slot = |(quad, lane): (usize, usize)| {
            let Quad { volume, unit, .. } = self.layout.quads[quad];
            Slot { view: &self.volumes.views[quad], volume: volumes[volume], lane, unit: unit[lane] }
        };
        let sweeper = self.sweeper.get_or_insert_with(|| StarSweeper::new(&self.gpu));
        let (view, seconds) = sweeper.swept(&self.gpu, &slot(dust), &slot(target), place)?;
        self.volumes.views[target.0] = view;
        self.volumes.moved = true;
        self.layout.place_star(star, place);
        self.groups = groups(&self.gpu, &self.pipeline, &self.layout, &self.volumes, &self.buffers);
        self.passes = 0;
        self.check()?;
        Ok(seconds)
    }

    /// Adds one more pass to the picture on the device, which stays there: a first look with a quarter of the samples,
    /// then passes with the plan's own, each at other places in its pixels and steps, whose mean settles. Returns how
    /// many passes there are.
    ///
    /// # Errors
    /// If the picture is larger than the device holds at once, the device gives up, or on interruption by the user.
    pub fn refine(&mut self, control: &Control) -> Result<u32> {
        self.whole()?;
        // Whatever stops it, rows of two kinds do not mix: the next one starts anew.
        let number = std::mem::take(&mut self.passes);
        let pass = Pass::refining(number);
        let height = self.buffers.rows;
        self.gpu.queue.write_buffer(&self.buffers.report, 0, &[0; REPORT_BYTES as usize]);
        let (mut dispatches, mut done) = (0, 0);
        let dispatched = self.dispatch(Strip { first: 0, count: height }, &pass, &mut dispatches, control, |rows| {
            done += rows;
            control.report(Stage::Rays, done as u64, height as u64);
        });
        pollster::block_on(dispatched)?;
        self.passes = number + 1;
        Ok(number)
    }

    /// The picture on the device as display colours: a texture of sRGB values, rgba8unorm.
    ///
    /// # Errors
    /// If the picture is larger than the device holds at once, or the device gives up.
    pub fn resolve(&mut self, tone: &Tone) -> Result<&wgpu::Texture> {
        self.whole()?;
        let [width, height, ..] = self.layout.frame.size;
        if tone.palette.columns.len() != self.layout.shape.bands() {
            return Err(GpuError::Bands(tone.palette.columns.len(), self.layout.shape.bands()));
        }
        let most = self.gpu.device.limits().max_texture_dimension_2d;
        GpuError::too_large("the edge of a picture in pixels", width.max(height).into(), most.into(), "take fewer pixels")?;
        self.resolver.take_if(|r| r.size() != (width, height));
        let resolver = self.resolver.get_or_insert_with(|| Resolver::new(&self.gpu, width, height));
        let texture = resolver.resolve(&self.gpu, &self.buffers.picture, tone);
        self.gpu.check(self.volumes.bytes)?;
        Ok(texture)
    }

    /// The pixels that [`resolve`](Self::resolve) made last, height × width × RGBA; nothing before that.
    ///
    /// # Errors
    /// If the device gives up.
    pub fn pixels(&self) -> Result<Vec<u8>> {
        self.resolver.as_ref().map_or(Ok(Vec::new()), |r| r.pixels(&self.gpu))
    }

    /// Refuses pictures that the device does not hold at once.
    fn whole(&self) -> Result<()> {
        let (height, rows) = (u64::from(self.layout.frame.size[1]), self.buffers.rows as u64);
        GpuError::too_large("the number of rows of a picture that stays", height, rows, "use fewer pixels, or render in one pass")
    }

    /// Band radiances of the extended light alone, bands × height × width [W m⁻² sr⁻¹], and what was found.
    ///
    /// # Errors
    /// If the device gives up, or on interruption by the user.
    pub fn radiance(&mut self, control: &Control) -> Result<(Vec<f32>, RenderStats)> {
        pollster::block_on(self.radiance_async(control))
    }

    /// Variant of [`radiance`](Self::radiance) for callers that must not block.
    ///
    /// # Errors
    /// Errors of [`radiance`](Self::radiance).
    pub async fn radiance_async(&mut self, control: &Control) -> Result<(Vec<f32>, RenderStats)> {
        let [width, height, ..] = self.layout.frame.size.map(|n| n as usize);
        let (bands, rays) = (self.layout.shape.bands(), self.layout.supersampling.pow(2));
        let mut data = vec![0.0; bands * width * height];
        self.passes = 0;
        self.gpu.queue.write_buffer(&self.buffers.report, 0, &[0; REPORT_BYTES as usize]);
        let (mut dispatches, mut done) = (0, 0);
        for first in (0..height).step_by(self.buffers.rows) {
            let stored = Strip { first, count: self.buffers.rows.min(height - first) };
            for n in 0..rays {
                let pass = Pass::supersampling(self.layout.supersampling, n);
                let visit = |rows| {
                    done += rows;
                    control.report(Stage::Rays, done as u64, (rays * height) as u64);
                };
                self.dispatch(stored, &pass, &mut dispatches, control, visit).await?;
            }
            let bytes = 4 * (bands * stored.count * width) as u64;
            let copy = |values: &[u8]| {
                for (band, values) in values.chunks_exact(4 * stored.count * width).enumerate() {
                    let out = &mut data[band * width * height + first * width..][..stored.count * width];
                    bytemuck::cast_slice_mut(out).copy_from_slice(values);
                }
            };
            self.gpu.read_async(&self.buffers.picture, bytes, &mut self.buffers.back, copy).await?;
        }
        let [deepest, ..] = self.report().await?;
        self.dispatches = dispatches;
        self.seconds = self.device_seconds(dispatches).await?;
        let negative = data.iter().filter(|v| **v < 0.0).count() as u64;
        Ok((
            data,
            RenderStats {
                depth: f64::from(f32::from_bits(deepest)),
                rays: (width * height * rays) as u64,
                storage: self.layout.storage,
                negative,
            },
        ))
    }

    /// The picture on the device, bands × height × width [W m⁻² sr⁻¹].
    ///
    /// # Errors
    /// As [`resolve`](Self::resolve).
    pub fn picture(&mut self) -> Result<Vec<f32>> {
        self.whole()?;
        Ok(bytemuck::pod_collect_to_vec(&self.gpu.read(&self.buffers.picture, self.buffers.picture.size(), &mut self.buffers.back)?))
    }

    /// The number of dispatches that the last picture was cut into, those after pauses included.
    pub fn dispatches(&self) -> usize {
        self.dispatches
    }

    /// The device's own time for the last picture \[s\]; none where it does not tell.
    pub fn seconds(&self) -> Option<f64> {
        self.seconds
    }

    /// The largest depth, whether a ray paused, whether one did so too late.
    async fn report(&mut self) -> Result<[u32; 3]> {
        self.gpu.read_async(&self.buffers.report, REPORT_BYTES, &mut self.buffers.back, bytemuck::pod_read_unaligned).await
    }

    /// Renders the rows of `held`, some at a time; `visit` receives how many.
    async fn dispatch(
        &mut self,
        stored: Strip,
        pass: &Pass,
        dispatches: &mut usize,
        control: &Control,
        mut visit: impl FnMut(usize),
    ) -> Result<()> {
        let (gpu, height) = (self.gpu.clone(), self.layout.frame.size[1] as usize);
        let (mut first, end) = (stored.first, stored.first + stored.count);
        while first < end {
            let start = Instant::now();
            let rows = self.pace.min(end - first);
            let (mut resumed, mut rounds) = (false, 0);
            while resumed || rounds == 0 {
                control.check()?;
                let frame = self.layout.frame.of(FrameRows { strip: Strip { first, count: rows }, stored }, pass, self.patience, resumed);
                gpu.queue.write_buffer(&self.buffers.frame, 0, bytemuck::bytes_of(&frame));
                self.submit(rows as u32, *dispatches);
                *dispatches += 1;
                gpu.done().await?;
                self.check()?;
                rounds += 1;
                resumed = self.pauses() == Pauses::Software && self.paused().await?;
            }
            first += rows;
            visit(rows);
            let fitting = rows as f64 * SLICE * f64::from(rounds) / start.elapsed().as_secs_f64();
            // A short last strip says little.
            if rows == self.pace || fitting < self.pace as f64 {
                self.pace = (fitting as usize).clamp(self.pace.div_ceil(4), 4 * self.pace).clamp(1, height);
            }
        }
        Ok(())
    }

    /// True if any ray must go on.
    async fn paused(&mut self) -> Result<bool> {
        let [_, paused, late] = self.report().await?;
        self.gpu.queue.write_buffer(&self.buffers.report, 4, &[0; 8]);
        if late > 0 {
            if self.patience == Patience::NONE {
                let words = "a part of a step exceeds the loop limit".into();
                return Err(GpuError::Device(self.gpu.adapter.name.clone(), words));
            }
            self.patience = self.patience.less();
        }
        Ok(paused + late > 0)
    }

    fn pauses(&self) -> Pauses {
        pauses(&self.gpu, self.tuning)
    }

    fn submit(&self, rows: u32, number: usize) {
        let (gpu, workgroup) = (&self.gpu, self.tuning.workgroup);
        let timer = gpu.timer.as_ref().zip(self.buffers.times.as_ref()).filter(|_| number < TIMED);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let timestamp_writes = timer.and_then(|_| gpu.timestamps());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("march"), timestamp_writes });
            pass.set_pipeline(&self.pipeline);
            for (i, group) in self.groups.iter().enumerate() {
                pass.set_bind_group(i as u32, group, &[]);
            }
            pass.dispatch_workgroups(self.layout.frame.size[0].div_ceil(workgroup.0), rows.div_ceil(workgroup.1), 1);
        }
        if let Some((timer, times)) = timer {
            encoder.resolve_query_set(timer, 0..2, times, number as u64 * TIMES);
        }
        gpu.queue.submit([encoder.finish()]);
    }

    /// The time between the timestamps of a given number of dispatches [s].
    async fn device_seconds(&mut self, dispatches: usize) -> Result<Option<f64>> {
        let Some(times) = self.buffers.times.as_ref().filter(|_| dispatches <= TIMED) else { return Ok(None) };
        let values = self.gpu.read_async(times, dispatches as u64 * TIMES, &mut self.buffers.back, <[u8]>::to_vec).await?;
        Ok(Some(self.gpu.seconds(&values, TIMES as usize)))
    }

    fn check(&self) -> Result<()> {
        self.gpu.check(self.volumes.bytes + self.buffers.picture.size() + 16 * self.layout.tables.len() as u64)
    }
}
