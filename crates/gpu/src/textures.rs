//! Volumes as 3-D textures of 16-bit floats; those in pages as atlases of them.

use barnard::volume::Volume;
use half::f16;
use wgpu::util::DeviceExt;

use crate::atlas::{atlas, size};
use crate::device::Gpu;
use crate::tables::Quad;

/// Depths go on behind the borders of the box, where they may pass what f16 holds: opaque all the same.
const LARGEST_F16: f32 = 65504.0;

/// Four channels of a volume, each in parts of its largest value, page by page.
pub fn texture(gpu: &Gpu, volume: &Volume, quad: &Quad) -> wgpu::TextureView {
    let (channels, size) = (volume.channels.len(), size(volume));
    let ([nx, ny, nz], [across, down, _]) = (volume.pages().side(), atlas(volume.pages()));
    let mut texels = vec![f16::ZERO; 4 * size.iter().product::<usize>()];
    for page in 0..volume.pages().count() {
        let [x, y, z] = [page % across * nx, page / across % down * ny, page / (across * down) * nz];
        let mut values = volume.page(page);
        for (j, k) in (0..nz).flat_map(|k| (0..ny).map(move |j| (j, k))) {
            let row = ((z + k) * size[1] + y + j) * size[0] + x;
            for texel in texels[4 * row..4 * (row + nx)].chunks_exact_mut(4) {
                for slot in 0..channels {
                    let value = values.next().unwrap_or(0.0);
                    let lane = slot.wrapping_sub(quad.first);
                    if lane < 4 && quad.unit[lane] > 0.0 {
                        texel[lane] = f16::from_f32((value / quad.unit[lane]).clamp(-LARGEST_F16, LARGEST_F16));
                    }
                }
            }
        }
    }
    uploaded(gpu, size, &texels)
}

/// Nothing, where there is nothing to read.
pub fn dark(gpu: &Gpu) -> wgpu::TextureView {
    uploaded(gpu, [1; 3], &[f16::ZERO; 4])
}

/// A texture of a given number of voxels that shaders write and read.
pub fn usable(gpu: &Gpu, dims: [usize; 3]) -> wgpu::TextureView {
    gpu.device.create_texture(&descriptor(dims, wgpu::TextureUsages::STORAGE_BINDING)).create_view(&Default::default())
}

fn uploaded(gpu: &Gpu, dims: [usize; 3], texels: &[f16]) -> wgpu::TextureView {
    let order = wgpu::util::TextureDataOrder::LayerMajor;
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &descriptor(dims, wgpu::TextureUsages::COPY_DST),
        order,
        bytemuck::cast_slice(texels),
    );
    texture.create_view(&Default::default())
}

fn descriptor([x, y, z]: [usize; 3], filled_by: wgpu::TextureUsages) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: x as u32, height: y as u32, depth_or_array_layers: z as u32 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | filled_by,
        view_formats: &[],
    }
}
