//! Input of the ionising-light shader, in its layout.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use ionisation::cloud::{Cloud, PARSEC_CM};
use ionisation::light::NODES;
use ionisation::patch::Patch;
use ionisation::tracer::Task;
use ionisation::voxel::Voxel;
use spectra::constants::SPHERE;

/// Quads of numbers by node.
pub const QUADS: usize = NODES.div_ceil(4);
/// Quads of a voxel: opacities, and three behind them.
pub const VOXEL: usize = QUADS + 3;
/// Generations of rays at most, and levels of patches.
pub const GENERATIONS: usize = 24;

/// The fields are those of `ray_tracer.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct StarNumbers {
    pub place: [f32; 4],
    pub edges: [f32; 4],
    pub scales: [f32; 4],
    pub dims: [u32; 4],
    pub counts: [u32; 4],
}

/// The fields are those of `ray_tracer.wgsl`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct GenerationNumbers {
    pub number: u32,
}

/// A ray as the shader has it.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct RayNumbers {
    pub photons: [[f32; 4]; QUADS],
    pub way: [f32; 4],
    pub patch_of: [u32; 4],
}

/// Four and four of numbers by node.
fn quads(values: impl Fn(usize) -> f64) -> [[f32; 4]; QUADS] {
    std::array::from_fn(|quad| std::array::from_fn(|i| if 4 * quad + i < NODES { values(4 * quad + i) as f32 } else { 0.0 }))
}

impl StarNumbers {
    /// Those of a star's rays, of which there is room for some.
    pub fn new(task: &Task, number: usize, room: usize, is_known: bool) -> Self {
        let (cloud, star) = (task.cloud, &task.stars[number]);
        let edge = cloud.voxel.min_element();
        let edge_cm = edge * PARSEC_CM;
        let (place, edges) = ((star.place - cloud.low) / edge, cloud.voxel / edge);
        let rays = task.rays(number);
        let face = edges.element_product().cbrt().powi(2);
        let widest = rays.widest_cross_section();
        let undimmed = star.light.photons.iter().sum::<f64>() / SPHERE / (edge_cm * edge_cm);
        let four = |v: DVec3, w: f64| [v.x, v.y, v.z, w].map(|v| v as f32);
        let ionising = star.light.ionising_of(&star.light.parts());
        let [x, y, z] = cloud.dims.map(|n| n as u32);
        let next = (number + 1) % task.stars.len();
        Self {
            place: four(place, undimmed),
            edges: four(edges, edge_cm),
            scales: [1.0 / (face * widest), widest, task.used_up, ionising].map(|v| v as f32),
            dims: [x, y, z, task.kind().energies_ev.len() as u32],
            counts: [room as u32, is_known.into(), number as u32, next as u32],
        }
    }
}

/// The rays that a star sends out.
pub fn sent(task: &Task, number: usize) -> Vec<RayNumbers> {
    let light = task.stars[number].light;
    let parts = light.parts();
    let (photons, left) = (quads(|node| parts[node]), light.ionising_of(&parts) as f32);
    let ray = |patch: Patch| {
        let [u, v] = patch.tangents().map(|v| v as f32);
        RayNumbers { photons, way: [0.0, u, v, left], patch_of: [patch.face(), patch.level(), u32::MAX, 0] }
    };
    task.rays(number).sent_out().into_iter().map(ray).collect()
}

/// Generations of the rays that a star sends out: as many as patches part before they reach the farthest corner.
pub fn generations(task: &Task, number: usize, sent: &[RayNumbers]) -> usize {
    let rays = task.rays(number);
    let least = sent.iter().map(|ray| ray.patch_of[1]).min().unwrap_or(0);
    // The widest patch of a level is in the middle of a face.
    let parts = |level: &u32| {
        let half = std::f64::consts::FRAC_PI_4 / (1u64 << level) as f64;
        rays.widest(4.0 * half * half) < rays.farthest()
    };
    (least..GENERATIONS as u32).take_while(parts).count() + 1
}

/// Starlight per node and patches per level, as seen by the shader.
pub fn spectrum(task: &Task, number: usize) -> Vec<[f32; 4]> {
    let light = task.stars[number].light;
    let ionises = light.ionises();
    let mut all: Vec<[f32; 4]> = [&light.weakening[0], &ionises, &task.dark].iter().flat_map(|values| quads(|node| values[node])).collect();
    all.extend((0..GENERATIONS).map(|level| {
        let half = std::f64::consts::FRAC_PI_4 / (1u64 << level) as f64;
        [(0.5 * half).tan(), (half / 3f64.sqrt()).tan(), half, 0.0].map(|v| v as f32)
    }));
    all
}

/// Some voxels as the shader reads them; where nothing is known of them, their density alone.
pub fn voxel_quads(cloud: &Cloud, voxels: Option<&[Voxel]>, which: Range<usize>) -> Vec<[[f32; 4]; VOXEL]> {
    let node = |i: usize| {
        let mut quads = [[0.0; 4]; VOXEL];
        if let Some(voxel) = voxels.map(|voxels| &voxels[i]) {
            quads[..QUADS].as_flattened_mut().copy_from_slice(&voxel.opacity[..4 * QUADS]);
            let [first_nodes @ .., fifth, sixth] = voxel.emitted;
            quads[QUADS] = first_nodes;
            quads[QUADS + 1] = [fifth, voxel.dust, voxel.rate, voxel.absorbed];
            quads[QUADS + 2] = [voxel.depth, voxel.ionised, 0.0, sixth];
        }
        quads[QUADS + 2][2] = cloud.hydrogen[i];
        quads
    };
    which.map(node).collect()
}

/// The rays of a generation at most: four for each of a voxel's faces on a sphere that is in the cloud, which is less than twice
/// its surface.
pub fn rays_at_most(cloud: &Cloud) -> usize {
    let edges = cloud.voxel / cloud.voxel.min_element() * DVec3::from(cloud.dims.map(|n| n as f64));
    let surface = 2.0 * (edges.x * edges.y + edges.y * edges.z + edges.z * edges.x);
    (8.0 * surface) as usize + 4096
}
