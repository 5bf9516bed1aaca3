//! Adapters and devices.

use std::sync::{Arc, Mutex};

use crate::error::{GpuError, Result};
use crate::signal::Signal;

/// An adapter, as `barnard info` shows it.
#[derive(Debug, Clone)]
pub struct Adapter {
    /// The name of the adapter.
    pub name: String,
    /// The interface by which it is reached: Vulkan, Metal or Dx12.
    pub api: String,
    /// True if it is a graphics processor, and not software on the processor.
    pub real: bool,
    /// The driver and its version.
    pub driver: String,
    /// Most voxels along an edge of a volume.
    pub volume_edge: u32,
    /// Most textures, of four channels each.
    pub textures: u32,
    /// Largest buffer that a shader reads \[bytes\].
    pub buffer: u64,
}

/// A device with its queue; a copy is the same device.
#[derive(Debug, Clone)]
pub struct Gpu {
    /// The adapter that the device is of.
    pub adapter: Adapter,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// The times at which a pass begins and ends, if the device measures them.
    pub(crate) timer: Option<wgpu::QuerySet>,
    /// Errors of the device, which wgpu reports asynchronously.
    complaints: Arc<Mutex<Complaints>>,
}

/// The first complaint is the reason of all others; a device that is gone stays so.
#[derive(Debug, Default)]
struct Complaints {
    gone: Option<String>,
    first: Option<Complaint>,
}

/// A complaint of a device.
#[derive(Debug)]
enum Complaint {
    /// The device has no room.
    Memory,
    /// The device was asked for something wrong.
    Fault(String),
}

/// The APIs that compute right. GL does not: 3-D textures lose all slices but the first.
const APIS: wgpu::Backends = wgpu::Backends::PRIMARY;

/// All adapters of this machine, real ones first.
pub fn adapters() -> Vec<Adapter> {
    found().iter().map(described).collect()
}

fn found() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = APIS;
    let instance = wgpu::Instance::new(descriptor);
    let mut found = pollster::block_on(instance.enumerate_adapters(APIS));
    let rank = |a: &wgpu::Adapter| match a.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    found.sort_by_key(rank);
    found
}

fn described(adapter: &wgpu::Adapter) -> Adapter {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    Adapter {
        // Browsers hide names.
        name: if info.name.is_empty() { "unnamed adapter".into() } else { info.name.clone() },
        api: info.backend.to_string(),
        real: !matches!(info.device_type, wgpu::DeviceType::Cpu),
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        volume_edge: limits.max_texture_dimension_3d,
        textures: limits.max_sampled_textures_per_shader_stage,
        buffer: limits.max_storage_buffer_binding_size,
    }
}

/// A descriptor that asks for all that `adapter` can do, its clock among it.
pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let required_features = adapter.features() & wgpu::Features::TIMESTAMP_QUERY;
    wgpu::DeviceDescriptor { required_limits: adapter.limits(), required_features, ..Default::default() }
}

impl Gpu {
    /// The best adapter of this machine: a real one if there is one, software otherwise.
    ///
    /// # Errors
    /// If there is none, or it does not open.
    pub fn open() -> Result<Self> {
        Self::opened(|adapter| adapter.limits())
    }

    /// Opens the best adapter as if it held no more than `limits`.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    #[cfg(test)]
    pub fn limited(limits: wgpu::Limits) -> Result<Self> {
        Self::opened(|_| limits)
    }

    fn opened(limits: impl FnOnce(&wgpu::Adapter) -> wgpu::Limits) -> Result<Self> {
        let adapter = found().into_iter().next().ok_or(GpuError::NoAdapter)?;
        pollster::block_on(Self::of_adapter(&adapter, limits(&adapter)))
    }

    /// The device of a browser.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub async fn of_browser() -> Result<Self> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::BROWSER_WEBGPU;
        let options = wgpu::RequestAdapterOptions { power_preference: wgpu::PowerPreference::HighPerformance, ..Default::default() };
        let adapter = wgpu::Instance::new(descriptor).request_adapter(&options).await.map_err(|_| GpuError::NoAdapter)?;
        Self::of_adapter(&adapter, adapter.limits()).await
    }

    async fn of_adapter(adapter: &wgpu::Adapter, limits: wgpu::Limits) -> Result<Self> {
        let described = described(adapter);
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..device_descriptor(adapter) };
        let opened = adapter.request_device(&descriptor).await;
        let (device, queue) = opened.map_err(|e| GpuError::Device(described.name.clone(), e.to_string()))?;
        Ok(Self::on(described, device, queue))
    }

    /// A device that somebody else opened by [`device_descriptor`], to draw with; none where its API computes wrong.
    pub fn shared(adapter: &wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Option<Self> {
        APIS.contains(adapter.get_info().backend.into()).then(|| Self::on(described(adapter), device, queue))
    }

    fn on(described: Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let query = wgpu::QuerySetDescriptor { label: None, ty: wgpu::QueryType::Timestamp, count: 2 };
        let timer = device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| device.create_query_set(&query));
        let complaints = Arc::<Mutex<Complaints>>::default();
        let (of_errors, of_loss) = (complaints.clone(), complaints.clone());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let complaint = match error {
                wgpu::Error::OutOfMemory { .. } => Complaint::Memory,
                error => Complaint::Fault(error.to_string()),
            };
            if let Ok(mut complaints) = of_errors.lock() {
                complaints.first.get_or_insert(complaint);
            }
        }));
        device.set_device_lost_callback(move |reason, words| {
            if let Ok(mut complaints) = of_loss.lock() {
                complaints.gone.get_or_insert(format!("{reason:?}: {words}"));
            }
        });
        Self { adapter: described, device, queue, timer, complaints }
    }

    /// The name that outputs state.
    pub fn name(&self) -> String {
        format!("gpu: {} ({})", self.adapter.name, self.adapter.api)
    }

    /// Room for a given number of bytes.
    pub(crate) fn buffer(&self, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    }

    /// A buffer that holds these bytes, a multiple of four.
    pub(crate) fn filled(&self, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        // A device that is gone refuses it in silence; one that maps it at its creation would panic.
        let buffer = self.buffer(contents.len() as u64, usage | wgpu::BufferUsages::COPY_DST);
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    /// Compiles one entry of a shader; its bindings are those that it uses.
    pub(crate) fn pipeline(&self, source: &str, entry: &str) -> wgpu::ComputePipeline {
        let source = wgpu::ShaderSource::Wgsl(source.into());
        self.pipeline_of(&self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(entry), source }), entry)
    }

    /// Compiles one entry of a shader whose loops end by themselves: nothing counts their turns, which would take a seventh
    /// of the registers. All else is checked as ever.
    ///
    /// # Safety
    /// Every loop must end, whatever the buffers hold.
    pub(crate) unsafe fn pipeline_that_ends(&self, source: &str, entry: &str) -> wgpu::ComputePipeline {
        let source = wgpu::ShaderSource::Wgsl(source.into());
        let checks = wgpu::ShaderRuntimeChecks { force_loop_bounding: false, ..wgpu::ShaderRuntimeChecks::checked() };
        let descriptor = wgpu::ShaderModuleDescriptor { label: Some(entry), source };
        // SAFETY: the caller's word is that loops end; all other checks are on.
        self.pipeline_of(&unsafe { self.device.create_shader_module_trusted(descriptor, checks) }, entry)
    }

    fn pipeline_of(&self, module: &wgpu::ShaderModule, entry: &str) -> wgpu::ComputePipeline {
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: None,
            module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        })
    }

    /// Binds resources of a shader by their numbers.
    pub(crate) fn group<'a>(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: impl IntoIterator<Item = (u32, wgpu::BindingResource<'a>)>,
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = resources.into_iter().map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }

    /// The places to which a pass writes the times at which it begins and ends; none where the device does not tell.
    pub(crate) fn timestamps(&self) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        self.timer.as_ref().map(|timer| wgpu::ComputePassTimestampWrites {
            query_set: timer,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        })
    }

    /// Seconds between the two timestamps of each pass; `times` holds them every `stride` bytes.
    pub(crate) fn seconds(&self, times: &[u8], stride: usize) -> f64 {
        let ticks = times.chunks_exact(stride).map(|v| {
            let [begin, end]: [u64; 2] = bytemuck::pod_read_unaligned(&v[..16]);
            end.saturating_sub(begin)
        });
        ticks.sum::<u64>() as f64 * f64::from(self.queue.get_timestamp_period()) * 1e-9
    }

    /// Linear between voxels, held at the borders.
    pub(crate) fn sampler(&self) -> wgpu::Sampler {
        self.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        })
    }

    /// An error where the device has complained; `needed` is what a plan takes there [bytes].
    pub(crate) fn check(&self, needed: u64) -> Result<()> {
        let Ok(mut complaints) = self.complaints.lock() else { return Err(GpuError::Lost("a listener panicked".into())) };
        if let Some(words) = &complaints.gone {
            return Err(GpuError::Lost(words.clone()));
        }
        match complaints.first.take() {
            None => Ok(()),
            Some(Complaint::Memory) => Err(GpuError::Memory(needed)),
            Some(Complaint::Fault(words)) => Err(GpuError::Fault(words)),
        }
    }

    /// Waits until what was submitted last is done.
    pub(crate) fn wait(&self) -> Result<()> {
        pollster::block_on(self.done())
    }

    /// Completes once what was submitted last is done.
    #[cfg(not(target_family = "wasm"))]
    #[expect(clippy::unused_async, reason = "a browser has to await what other machines wait for")]
    pub(crate) async fn done(&self) -> Result<()> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map(drop).map_err(|e| GpuError::Lost(e.to_string()))
    }

    /// Completes once what was submitted last is done.
    #[cfg(target_family = "wasm")]
    pub(crate) async fn done(&self) -> Result<()> {
        let done = Signal::new();
        let set = done.clone();
        self.queue.on_submitted_work_done(move || set.set(()));
        done.await;
        Ok(())
    }

    /// The first bytes of a buffer, by way of `back`, which grows as it must.
    pub(crate) fn read(&self, from: &wgpu::Buffer, bytes: u64, back: &mut Option<wgpu::Buffer>) -> Result<Vec<u8>> {
        self.read_as(from, bytes, back, <[u8]>::to_vec)
    }

    /// Reads the first bytes of a buffer by way of `back`, which grows as it must; returns what `made` makes of them.
    pub(crate) fn read_as<T>(
        &self,
        from: &wgpu::Buffer,
        bytes: u64,
        back: &mut Option<wgpu::Buffer>,
        made: impl FnOnce(&[u8]) -> T,
    ) -> Result<T> {
        pollster::block_on(self.read_async(from, bytes, back, made))
    }

    /// Variant for callers that must not block.
    pub(crate) async fn read_async<T>(
        &self,
        from: &wgpu::Buffer,
        bytes: u64,
        back: &mut Option<wgpu::Buffer>,
        made: impl FnOnce(&[u8]) -> T,
    ) -> Result<T> {
        fn lost(e: impl std::fmt::Display) -> GpuError {
            GpuError::Lost(e.to_string())
        }
        if back.as_ref().is_none_or(|b| b.size() < bytes) {
            *back = Some(self.buffer(bytes, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST));
        }
        let Some(staging) = back else { return Err(lost("no memory to read back")) };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(from, 0, staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let slice = staging.slice(..bytes);
        let mapped = Signal::new();
        let set = mapped.clone();
        slice.map_async(wgpu::MapMode::Read, move |result| set.set(result));
        self.done().await?;
        self.check(bytes)?;
        mapped.await.map_err(lost)?;
        let values = made(&slice.get_mapped_range().map_err(lost)?);
        staging.unmap();
        Ok(values)
    }
}
