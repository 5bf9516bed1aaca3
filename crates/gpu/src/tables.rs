//! Lists of numbers as shaders read them: four at a time.

use std::ops::Range;

use barnard::plan::Plan;
use barnard::volume::{Bricks, Channel, Volume};
use glam::DVec3;

use crate::atlas::atlas;
use crate::frame::four;

/// Four channels of a volume.
#[derive(Debug, Clone, Copy)]
pub struct Quad {
    /// The number of the volume.
    pub volume: usize,
    /// The first of the volume's channels that stand here.
    pub first: usize,
    /// The factor of each channel by which stored numbers are multiplied.
    pub unit: [f32; 4],
}

/// The quad that holds a channel, and which of its four it is.
pub fn slot_of(quads: &[Quad], volumes: &[&Volume], channel: Channel) -> Option<(usize, usize)> {
    let lane = |quad: &Quad| volumes[quad.volume].channels.iter().skip(quad.first).take(4).position(|c| *c == channel);
    quads.iter().enumerate().find_map(|(q, quad)| lane(quad).map(|lane| (q, lane)))
}

/// Room for a given number of terms: a power of two, so that an edit seldom leaves it.
pub fn room(terms: usize) -> usize {
    terms.next_power_of_two().max(32)
}

/// Numbers, four at a time.
#[derive(Debug, Default)]
pub struct QuadList(pub Vec<[f32; 4]>);

impl QuadList {
    /// Numbers in a row, padded with zeros to at least a number of quads.
    pub fn numbers(&mut self, numbers: &[f32], least: usize) {
        let quads = numbers.len().div_ceil(4).max(least);
        let at = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
        self.0.extend((0..quads).map(|q| std::array::from_fn(|i| at(4 * q + i))));
    }
}

/// The quad at which each section starts, by the names of the constants that tell shaders.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offsets(Vec<(&'static str, usize)>);

impl Offsets {
    /// The quad at which one section starts.
    pub fn of(&self, section: &str) -> usize {
        self.iter().find(|(known, _)| *known == section).map_or(0, |(_, start)| start)
    }

    /// Names and places of all.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, usize)> + '_ {
        self.0.iter().copied()
    }
}

/// The table that a shader reads, while it is made section by section.
pub struct Tables {
    pub list: QuadList,
    pub middle: DVec3,
    starts: Vec<(&'static str, usize)>,
}

impl Tables {
    /// An empty table whose places are seen from `middle` \[pc\].
    pub fn new(middle: DVec3) -> Self {
        Self { list: QuadList::default(), middle, starts: Vec::new() }
    }

    /// Begins a section where the one before has ended.
    pub fn begin(&mut self, section: &'static str) {
        self.starts.push((section, self.list.0.len()));
    }

    /// A section of a given number of quads that are [put](Self::put) later.
    pub fn reserve(&mut self, section: &'static str, quads: usize) -> Range<usize> {
        self.begin(section);
        let start = self.list.0.len();
        self.list.0.resize(start + quads, [0.0; 4]);
        start..start + quads
    }

    /// Writes what a section was reserved for.
    pub fn put(&mut self, reserved: Range<usize>, quads: &[[f32; 4]]) {
        self.list.0[reserved].copy_from_slice(quads);
    }

    /// The quads at which the sections have come to stand.
    pub fn offsets(&self) -> Offsets {
        Offsets(self.starts.clone())
    }

    /// A place, and one number more.
    pub fn place(&mut self, p: DVec3, fourth: f32) {
        self.list.0.push(four(p - self.middle, fourth));
    }

    /// The noise that dust is.
    pub fn cloud(&mut self, plan: &Plan) {
        self.begin("CLOUD");
        let Some((cloud, sigma)) = &plan.space().cloud else { return self.list.0.extend([[0.0; 4]; 3]) };
        self.place(cloud.centre, cloud.radius as f32);
        self.list.0.push([1.0 / cloud.scale, f64::from(cloud.octaves), cloud.lacunarity, cloud.gain].map(|v| v as f32));
        self.list.0.push([cloud.offset, f64::from(u8::from(cloud.ridged)), cloud.warp, *sigma].map(|v| v as f32));
    }

    /// Displacement below the voxels: how wide pixels are, then for each octave the rows that turn a place into one of its noise, its
    /// length and seed, and its displacements by both components.
    pub fn detail(&mut self, plan: &Plan) {
        self.begin("DETAIL");
        let footprint = plan.camera().footprint();
        self.list.0.push([footprint.per_pc as f32, footprint.least_pc as f32, 0.0, 0.0]);
        for octave in plan.detail().iter().flat_map(|detail| &detail.octaves) {
            let shift = octave.turn * self.middle + octave.shift;
            self.list.0.extend((0..3).map(|axis| four(octave.turn.row(axis), shift[axis] as f32)));
            self.list.0.push([octave.wavelength_pc as f32, octave.seed as f32, 0.0, 0.0]);
            self.list.0.extend(octave.displacements.map(|displacement| four(displacement, 0.0)));
        }
    }

    pub fn lattice(&mut self, volume: &Volume, quad: &Quad) {
        let size = volume.lattice.bounds.size();
        self.list.0.push(four(size.recip(), 0.0));
        self.list.0.push(four((self.middle - volume.lattice.bounds.low) / size, 0.0));
        self.list.0.push(quad.unit);
        self.place(volume.inner.bounds.low, 0.0);
        self.place(volume.inner.bounds.high, 0.0);
    }

    /// Positions of the pages of volumes in their atlases, whose numbers follow in `lists`.
    pub fn paging(&mut self, quads: &[Quad], volumes: &[&Volume], lists: &mut Vec<u32>) {
        self.begin("PAGING");
        for volume in quads.iter().map(|quad| volumes[quad.volume]).filter(|volume| !volume.pages().is_whole()) {
            let start = lists.len() as f32;
            lists.extend(volume.pages().slots());
            let numbers = |[x, y, z]: [usize; 3], fourth| [x as f32, y as f32, z as f32, fourth];
            self.list.0.extend([numbers(volume.lattice.dims, start), numbers(atlas(volume.pages()), 0.0)]);
        }
    }

    /// The grids of bricks, whose values stand one behind the other.
    pub fn bricks(&mut self, plan: &Plan) {
        self.begin("BRICK_TABLE");
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

    /// The number of brick edges around each brick that stay empty of dust and gas.
    pub fn distances(plan: &Plan) -> Vec<u32> {
        let clear = |bricks: &Bricks| {
            let margin = plan.displaced_bricks(bricks);
            let of_brick = |i: usize| bricks.clear(bricks.lattice.place(i)).saturating_sub(margin) as u32;
            (0..bricks.lattice.cells()).map(of_brick).collect::<Vec<_>>()
        };
        let mut distances: Vec<u32> = plan.space().bricks.iter().flat_map(clear).collect();
        distances.resize(distances.len().max(1), 0);
        distances
    }
}
