//! A grid as an OpenVDB file of version 224: a fog volume of floats whose active voxels are those above zero, plain.
//!
//! Source: OpenVDB, io/Archive.cc, io/GridDescriptor.cc, math/Maps.h, tree/RootNode.h, tree/InternalNode.h,
//! tree/LeafNode.h, io/Compression.h (`writeCompressedValues`).

use std::io::Write;

use barnard::error::{Error, Result};
use barnard::field::Grid;
use barnard::memory;
use rayon::prelude::*;

use super::codec::ACTIVE_MASK;
use super::codec::inactive::BACKGROUND;
use super::header::{FLOAT, MAGIC};
use crate::formats::{GridFile, failed};

const VERSION: u32 = 224;
/// Voxels along the edge of a leaf, of a node of leaves, and of a node of those.
const EDGES: [usize; 3] = [8, 128, 4096];

/// Bytes that a leaf takes in memory, and what is written of it before its values.
const BYTES_OF_LEAF: u64 = 300;

/// The active voxels of a leaf, and where it begins.
struct WrittenLeaf {
    low: [usize; 3],
    active: Vec<u8>,
}

pub fn write(file: &GridFile, out: &mut dyn Write) -> Result<()> {
    let grid = file.grid;
    let leaves = leaves(grid, file.memory_limit)?;
    if leaves.is_empty() {
        let reason = "no value is above zero, so the OpenVDB file would be empty".to_owned();
        return Err(Error::Encoding { format: "OpenVDB", reason });
    }
    let topology = topology(&leaves);
    let head = head(file);
    // The grid stands behind the head, its last three numbers, and those say where its parts are.
    let start = head.len() as u64 + 24;
    let count = |leaf: &WrittenLeaf| leaf.active.iter().map(|byte| byte.count_ones() as usize).sum::<usize>();
    let values: u64 = leaves.iter().map(|leaf| (leaf.active.len() + 1 + 4 * count(leaf)) as u64).sum();
    let body = [about(file), topology].concat();
    let blocks = start + body.len() as u64;
    let mut write = |bytes: &[u8]| out.write_all(bytes).map_err(failed);
    write(&head)?;
    write(&[start, blocks, blocks + values].map(|place| (place as i64).to_le_bytes()).concat())?;
    write(&body)?;
    for leaf in &leaves {
        write(&leaf.active)?;
        write(&[BACKGROUND])?;
        let values = values_of(grid, leaf.low);
        let active = values.iter().enumerate().filter(|(i, _)| leaf.active[i / 8] >> (i % 8) & 1 == 1);
        write(&active.flat_map(|(_, value)| value.to_le_bytes()).collect::<Vec<u8>>())?;
    }
    Ok(())
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

/// Header in front of the only grid of a file.
fn head(file: &GridFile) -> Vec<u8> {
    // The version of the library whose format this is, then that there is a table of grids.
    let numbers = [VERSION, 10, 0].map(u32::to_le_bytes).concat();
    // Nothing distinguishes files by it.
    let unique = b"00000000-0000-0000-0000-000000000000";
    let none = 0u32.to_le_bytes();
    let one = 1u32.to_le_bytes();
    [&MAGIC.to_le_bytes(), &numbers[..], &[1], unique, &none, &one, &text(file.name), &text(FLOAT), &text("")].concat()
}

/// Header of the tree: compression, metadata and the transform.
fn about(file: &GridFile) -> Vec<u8> {
    let entry = |name: &str, value: &str| [text(name), text("string"), text(value)].concat();
    let mut entries =
        vec![entry("class", "fog volume"), entry("name", file.name), entry("creator", concat!("Barnard ", env!("CARGO_PKG_VERSION")))];
    entries.extend(file.unit.map(|unit| entry("unit", unit)));
    let (lattice, step) = (file.grid.lattice(), file.grid.lattice().voxel_pc());
    // Values stand at the corners of voxels there: voxel 0 is where the first centre is.
    let first = lattice.centre(0, 0, 0);
    let [a, b, c] = [step.recip(), step.recip() * step.recip(), 0.5 * step.recip()];
    let map = [first, step, step, a, b, c].iter().flat_map(|v| v.to_array()).flat_map(f64::to_le_bytes).collect::<Vec<u8>>();
    let count = (entries.len() as u32).to_le_bytes().to_vec();
    [ACTIVE_MASK.to_le_bytes().to_vec(), count, entries.concat(), text("ScaleTranslateMap"), map].concat()
}

/// The values of a leaf, z fastest; zero beyond the grid.
fn values_of(grid: &Grid, low: [usize; 3]) -> [f32; 512] {
    let dims = grid.lattice().dims;
    let range = |axis: usize| low[axis]..(low[axis] + EDGES[0]).min(dims[axis]);
    let mut values = [0.0; 512];
    let mut row = [0.0; 8];
    for (y, z) in range(2).flat_map(|z| range(1).map(move |y| (y, z))) {
        let row = &mut row[..range(0).len()];
        grid.row(range(0), y, z, row);
        row.iter().enumerate().for_each(|(x, value)| values[(x * 8 + y - low[1]) * 8 + z - low[2]] = *value);
    }
    values
}

/// The leaves that have something, in the order of the tree: node by node, z fastest in each; they may take `limit` bytes
/// with what is written of them.
fn leaves(grid: &Grid, limit: u64) -> Result<Vec<WrittenLeaf>> {
    let dims = grid.lattice().dims;
    let corners = |low: [usize; 3], edge: usize, within: usize| {
        let along = move |axis: usize| (low[axis]..(low[axis] + within).min(dims[axis])).step_by(edge);
        along(0).flat_map(move |x| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z])))
    };
    let nodes = corners([0; 3], EDGES[2], usize::MAX / 2).flat_map(|low| corners(low, EDGES[1], EDGES[2]));
    let filled =
        |low: [usize; 3], edge: usize| grid.largest(std::array::from_fn(|axis| low[axis]..(low[axis] + edge).min(dims[axis]))) > 0.0;
    let nodes: Vec<[usize; 3]> = nodes.filter(|low| filled(*low, EDGES[1])).collect();
    let in_node = |low: &[usize; 3]| corners(*low, EDGES[0], EDGES[1]).filter(|low| filled(*low, EDGES[0]));
    let count = nodes.par_iter().map(|low| in_node(low).count() as u64).sum::<u64>();
    memory::check("the leaves of an OpenVDB file", BYTES_OF_LEAF * count, limit)?;
    let of_node = |low: &[usize; 3]| {
        let leaf = |low: [usize; 3]| {
            let mut active = vec![0u8; 64];
            let values = values_of(grid, low);
            values.iter().enumerate().filter(|(_, value)| **value > 0.0).for_each(|(i, _)| active[i / 8] |= 1 << (i % 8));
            WrittenLeaf { low, active }
        };
        in_node(low).map(leaf).collect::<Vec<_>>()
    };
    Ok(nodes.par_iter().flat_map_iter(of_node).collect())
}

/// The tree without the values of its leaves.
fn topology(leaves: &[WrittenLeaf]) -> Vec<u8> {
    let roots: Vec<&[WrittenLeaf]> = leaves.chunk_by(|a, b| node_of(a, 2) == node_of(b, 2)).collect();
    let (buffers, background, tiles) = (1u32.to_le_bytes(), 0f32.to_le_bytes(), 0u32.to_le_bytes());
    let mut bytes = [buffers, background, tiles, (roots.len() as u32).to_le_bytes()].concat();
    for root in roots {
        bytes.extend(node_of(&root[0], 2).iter().flat_map(|i| (*i as i32).to_le_bytes()));
        let nodes: Vec<&[WrittenLeaf]> = root.chunk_by(|a, b| node_of(a, 1) == node_of(b, 1)).collect();
        bytes.extend(masks(nodes.iter().map(|node| node_of(&node[0], 1)), EDGES[2], EDGES[1]));
        for node in nodes {
            bytes.extend(masks(node.iter().map(|leaf| leaf.low), EDGES[1], EDGES[0]));
            node.iter().for_each(|leaf| bytes.extend(&leaf.active));
        }
    }
    bytes
}

/// Origin of the node that contains a leaf.
fn node_of(leaf: &WrittenLeaf, level: usize) -> [usize; 3] {
    leaf.low.map(|i| i / EDGES[level] * EDGES[level])
}

/// The masks of a node: its children, none of its own values; and that all these are the background.
fn masks(children: impl Iterator<Item = [usize; 3]>, edge: usize, child: usize) -> Vec<u8> {
    let across = edge / child;
    let places = across * across * across;
    let mut mask = vec![0u8; places / 8];
    for low in children {
        let [x, y, z] = low.map(|i| i % edge / child);
        let place = (x * across + y) * across + z;
        mask[place / 8] |= 1 << (place % 8);
    }
    [mask, vec![0; places / 8], vec![BACKGROUND]].concat()
}
