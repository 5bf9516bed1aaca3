//! From band radiances on the device to a texture of display colours.

use barnard::image::Tone;
use bytemuck::{Pod, Zeroable};
use wgpu::BufferUsages as Use;

use crate::device::Gpu;
use crate::error::Result;

/// The fields are those of `resolve.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct DisplayLevels {
    pub levels: [f32; 4],
    pub size: [u32; 4],
}

/// The source of the shader.
pub const SOURCE: &str = include_str!("shaders/resolve.wgsl");

/// A texture of sRGB values, rgba8unorm, and what fills it.
pub struct Resolver {
    pipeline: wgpu::ComputePipeline,
    texture: wgpu::Texture,
}

impl Resolver {
    /// A resolver of pictures of a given number of pixels along a row, and rows.
    pub fn new(gpu: &Gpu, width: u32, height: u32) -> Self {
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage,
            view_formats: &[],
        });
        Self { pipeline: gpu.pipeline(SOURCE, "main"), texture }
    }

    /// Pixels along a row, and rows.
    pub fn size(&self) -> (u32, u32) {
        (self.texture.width(), self.texture.height())
    }

    /// Fills the texture from `light`, bands × height × width.
    pub fn resolve(&self, gpu: &Gpu, light: &wgpu::Buffer, tone: &Tone) -> &wgpu::Texture {
        let (width, height) = self.size();
        let (bands, range) = (tone.palette.columns.len(), (tone.white - tone.black).max(f64::from(f32::MIN_POSITIVE)));
        let stretch = tone.stretch_table();
        let gaps = (stretch.len() - 1) as f32;
        let display =
            DisplayLevels { levels: [tone.black as f32, (1.0 / range) as f32, gaps, 0.0], size: [width, height, bands as u32, 0] };
        let column = |c: &[f64; 3]| [c[0] as f32, c[1] as f32, c[2] as f32, 0.0];
        let gaps = stretch.windows(2).map(|ends| [ends[0] as f32, ends[1] as f32, 0.0, 0.0]);
        let table: Vec<[f32; 4]> = tone.palette.columns.iter().map(column).chain(gaps).collect();
        let display = gpu.filled(bytemuck::bytes_of(&display), Use::UNIFORM);
        let table = gpu.filled(bytemuck::cast_slice(&table), Use::STORAGE);
        let view = self.texture.create_view(&Default::default());
        let buffers = [&display, &table, light].map(|b| b.as_entire_binding());
        let resources = buffers.into_iter().chain([wgpu::BindingResource::TextureView(&view)]);
        let group = gpu.group(&self.pipeline.get_bind_group_layout(0), (0..).zip(resources));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
        }
        gpu.queue.submit([encoder.finish()]);
        &self.texture
    }

    /// The pixels in the texture, height × width × RGBA.
    pub fn pixels(&self, gpu: &Gpu) -> Result<Vec<u8>> {
        let (width, height) = self.size();
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.buffer(u64::from(row) * u64::from(height), Use::COPY_DST | Use::COPY_SRC);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            self.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            self.texture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let values = gpu.read(&buffer, buffer.size(), &mut None)?;
        Ok(values.chunks_exact(row as usize).flat_map(|r| r[..4 * width as usize].iter().copied()).collect())
    }
}
