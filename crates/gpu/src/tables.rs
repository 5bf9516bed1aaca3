//! Lists of numbers as shaders read them: four at a time.

use barnard::plan::Plan;
use barnard::volume::{Bricks, Volume};
use glam::DVec3;

use crate::frame::four;
use crate::layout::Quad;

/// Numbers, four at a time.
#[derive(Debug, Default)]
pub struct QuadList(pub Vec<[f32; 4]>);

impl QuadList {
    /// Numbers in a row, filled up with zeros to at least so many quads.
    pub fn numbers(&mut self, numbers: &[f32], least: usize) {
        let quads = numbers.len().div_ceil(4).max(least);
        let at = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
        self.0.extend((0..quads).map(|q| std::array::from_fn(|i| at(4 * q + i))));
    }
}

/// Quads of numbers in the order of [`Offsets`](crate::layout::Offsets).
pub struct Tables {
    pub list: QuadList,
    pub middle: DVec3,
}

impl Tables {
    /// A place, and one number more.
    pub fn place(&mut self, p: DVec3, fourth: f32) {
        self.list.0.push(four(p - self.middle, fourth));
    }

    /// The noise that dust is.
    pub fn cloud(&mut self, plan: &Plan) {
        let Some((cloud, sigma)) = &plan.space().cloud else { return self.list.0.extend([[0.0; 4]; 3]) };
        self.place(cloud.centre, cloud.radius as f32);
        self.list.0.push([1.0 / cloud.scale, f64::from(cloud.octaves), cloud.lacunarity, cloud.gain].map(|v| v as f32));
        self.list.0.push([cloud.offset, f64::from(u8::from(cloud.ridged)), cloud.warp, *sigma].map(|v| v as f32));
    }

    pub fn lattice(&mut self, volume: &Volume, quad: &Quad) {
        let size = volume.lattice.bounds.size();
        self.list.0.push(four(size.recip(), 0.0));
        self.list.0.push(four((self.middle - volume.lattice.bounds.low) / size, 0.0));
        self.list.0.push(quad.unit);
        self.place(volume.inner.bounds.low, 0.0);
        self.place(volume.inner.bounds.high, 0.0);
    }

    /// The grids of bricks, whose values stand one behind the other.
    pub fn bricks(&mut self, plan: &Plan) {
        let mut start = 0;
        for bricks in &plan.space().bricks {
            let lattice = &bricks.lattice;
            let edge = lattice.voxel_pc();
            self.place(lattice.bounds.low, edge.min_element() as f32);
            self.list.0.push(four(edge.recip(), 0.0));
            let [x, y, z] = lattice.dims.map(|n| n as f32);
            self.list.0.push([x, y, z, start as f32]);
            start += lattice.cells();
        }
    }

    /// How far from each brick the next light is.
    pub fn distances(plan: &Plan) -> Vec<u32> {
        let of = |bricks: &Bricks| (0..bricks.lattice.cells()).map(|i| bricks.clear(bricks.lattice.place(i)) as u32).collect::<Vec<_>>();
        let mut distances: Vec<u32> = plan.space().bricks.iter().flat_map(of).collect();
        distances.resize(distances.len().max(1), 0);
        distances
    }
}
