//! A tree of voxels: nodes of 32³ children, of 16³ and leaves of 8³ voxels, below a root that lists those that there are.
//!
//! The topology comes first, with the values of all that has no children; then, leaf by leaf, the voxels. Source: OpenVDB,
//! tree/RootNode.h, tree/InternalNode.h, tree/LeafNode.h.

use std::collections::HashSet;

use barnard::data::Numbers;
use barnard::error::Result;
use barnard::memory;
use rayon::prelude::*;

use super::bytes::{Bytes, Mask};
use super::codec::{Coding, StoredBlock};
use super::window::Window;
use crate::formats::FileFloat;
use crate::formats::gather::Gather;

/// Voxels along an edge of a leaf.
const LEAF: i32 = 8;
/// Voxels of a leaf.
const VOXELS: usize = 512;
/// Voxels along an edge of what a node of each level has as its children, and how many these are along an edge.
const LEVELS: [(i32, i32); 2] = [(128, 32), (8, 16)];
/// Leaves whose values are read, and unpacked by all threads, together.
const TOGETHER: usize = 2048;
/// Bytes that a leaf or a tile takes in a tree.
const BYTES: u64 = 128;

/// A cube of voxels that have one value.
#[derive(Debug, Clone, PartialEq)]
struct Tile {
    low: [i32; 3],
    edge: i32,
    value: f64,
}

/// A leaf, and which of its voxels are active.
#[derive(Debug)]
struct Leaf {
    low: [i32; 3],
    active: Mask,
}

/// A tree without the values of its leaves.
#[derive(Debug)]
pub struct Tree {
    coding: Coding,
    tiles: Vec<Tile>,
    leaves: Vec<Leaf>,
    /// Active voxels.
    pub active: u64,
    bounds: Option<Window>,
}

impl Tree {
    /// Reads the topology of a tree, which may take `memory_limit` bytes.
    pub fn read(bytes: &mut Bytes, coding: Coding, memory_limit: u64) -> Result<Self> {
        let buffers = bytes.u32()?;
        if buffers != 1 {
            return Err(bytes.wrong(format!("{buffers} buffers per leaf are announced, expected one")));
        }
        let background = coding.number(bytes)?;
        let mut tree = Self { coding: Coding { background, ..coding }, tiles: Vec::new(), leaves: Vec::new(), active: 0, bounds: None };
        let (tiles, children) = (bytes.u32()?, bytes.u32()?);
        let mut seen = HashSet::new();
        for _ in 0..tiles {
            let low = tree.root_place(bytes, &mut seen)?;
            let value = tree.coding.number(bytes)?;
            let is_active = bytes.u8()? != 0;
            tree.tile(bytes, low, 4096, value, is_active, memory_limit)?;
        }
        // Nodes of the root are kept sorted by place, and their leaves' values come in that order.
        let mut ends = Vec::new();
        for _ in 0..children {
            let low = tree.root_place(bytes, &mut seen)?;
            let first = tree.leaves.len();
            tree.node(bytes, low, 0, memory_limit)?;
            ends.push((low, first..tree.leaves.len()));
        }
        if !ends.is_sorted_by_key(|(low, _)| *low) {
            return Err(bytes.wrong("the nodes of its root are out of order: the file is corrupt"));
        }
        Ok(tree)
    }

    /// The place of a child of the root, which no other has.
    fn root_place(&self, bytes: &mut Bytes, seen: &mut HashSet<[i32; 3]>) -> Result<[i32; 3]> {
        const EDGE: i32 = 4096;
        let low = bytes.place()?;
        let is_place = low.iter().all(|i| i % EDGE == 0 && *i <= i32::MAX - EDGE + 1);
        if !is_place || !seen.insert(low) {
            return Err(bytes.wrong(format!("its root has a misplaced or duplicate node at {low:?}")));
        }
        Ok(low)
    }

    fn tile(&mut self, bytes: &Bytes, low: [i32; 3], edge: i32, value: f64, is_active: bool, limit: u64) -> Result<()> {
        if !value.is_finite() {
            return Err(bytes.wrong(format!("a tile at {low:?} is {value}")));
        }
        if is_active {
            self.active = self.active.saturating_add((edge as u64).pow(3));
        }
        if is_active || value != self.coding.background {
            self.widen(low, low.map(|i| i + (edge - 1)));
            self.tiles.push(Tile { low, edge, value });
            self.check_memory(limit)?;
        }
        Ok(())
    }

    fn check_memory(&self, limit: u64) -> Result<()> {
        memory::check("the nodes of a VDB grid", BYTES * (self.tiles.len() + self.leaves.len()) as u64, limit)
    }

    /// Reads a node of a level and all below it.
    fn node(&mut self, bytes: &mut Bytes, low: [i32; 3], level: usize, limit: u64) -> Result<()> {
        let (edge, across) = LEVELS[level];
        let places = (across * across * across) as usize;
        let (children, active) = (bytes.mask(places)?, bytes.mask(places)?);
        let block = self.coding.block(bytes, &active, places)?;
        let mut values = vec![0.0f64; places];
        self.coding.values(&block, &active, &mut values).map_err(|reason| bytes.wrong_at(block.at, reason))?;
        let place = |i: usize| {
            let (i, n) = (i as i32, across);
            [low[0] + i / (n * n) * edge, low[1] + i / n % n * edge, low[2] + i % n * edge]
        };
        for (i, value) in values.into_iter().enumerate().filter(|(i, _)| !children.holds(*i)) {
            self.tile(bytes, place(i), edge, value, active.holds(i), limit)?;
        }
        for child in children.set() {
            if level + 1 < LEVELS.len() {
                self.node(bytes, place(child), level + 1, limit)?;
            } else {
                self.leaf(bytes, place(child), limit)?;
            }
        }
        Ok(())
    }

    fn leaf(&mut self, bytes: &mut Bytes, low: [i32; 3], limit: u64) -> Result<()> {
        let active = bytes.mask(VOXELS)?;
        let mut ends: Option<([i32; 3], [i32; 3])> = None;
        for voxel in active.set() {
            let corner = voxel_of(low, voxel);
            let (least, most) = ends.get_or_insert((corner, corner));
            (0..3).for_each(|i| (least[i], most[i]) = (least[i].min(corner[i]), most[i].max(corner[i])));
        }
        if let Some((least, most)) = ends {
            self.widen(least, most);
        }
        self.active += active.count() as u64;
        self.leaves.push(Leaf { low, active });
        self.check_memory(limit)
    }

    fn widen(&mut self, low: [i32; 3], last: [i32; 3]) {
        let window = Window::between(low, last);
        self.bounds = Some(self.bounds.map_or(window, |bounds| bounds.union(&window)));
    }

    /// The box of all voxels that are active, and of all tiles that are or hold something else than the background.
    pub fn bounds(&self) -> Option<Window> {
        self.bounds
    }

    /// The value of all that is nowhere else.
    pub fn background(&self) -> f64 {
        self.coding.background
    }

    /// Gathers values, x running fastest; the file stands where the values of the leaves begin.
    pub fn values<T: FileFloat + Send + Sync>(&self, bytes: &mut Bytes, window: &Window, mut gather: Gather<T>) -> Result<Numbers> {
        for tile in &self.tiles {
            window.tile(&mut gather, tile.low, tile.edge, T::of(tile.value));
        }
        for leaves in self.leaves.chunks(TOGETHER) {
            let mut blocks = Vec::new();
            for leaf in leaves {
                let block = self.leaf_block(bytes, leaf)?;
                if window.touches(&gather, leaf.low, LEAF) {
                    blocks.push((leaf, block));
                }
            }
            let unpacked = blocks.par_iter().map(|(leaf, block)| {
                let mut values = vec![T::of(0.0); VOXELS];
                self.coding.values(block, &leaf.active, &mut values).map_err(|reason| (block.at, reason))?;
                Ok((leaf.low, values))
            });
            // The first that is wrong in the file's order, whichever thread saw it.
            for unpacked in unpacked.collect::<Vec<std::result::Result<_, (u64, String)>>>() {
                let (low, leaf) = unpacked.map_err(|(at, reason)| bytes.wrong_at(at, reason))?;
                window.voxels(&mut gather, low, LEAF, &leaf);
            }
        }
        gather.finish()
    }

    /// The block of a leaf; its mask stands before it once more.
    fn leaf_block(&self, bytes: &mut Bytes, leaf: &Leaf) -> Result<StoredBlock> {
        let again = bytes.mask(VOXELS)?;
        if again != leaf.active {
            return Err(bytes.wrong(format!("the leaf at {:?} has two different masks: the file is corrupt", leaf.low)));
        }
        self.coding.block(bytes, &leaf.active, VOXELS)
    }
}

/// The place of a voxel of a leaf by its number: z runs fastest.
fn voxel_of(low: [i32; 3], voxel: usize) -> [i32; 3] {
    let voxel = voxel as i32;
    [low[0] + voxel / (LEAF * LEAF), low[1] + voxel / LEAF % LEAF, low[2] + voxel % LEAF]
}
