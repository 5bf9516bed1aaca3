//! OpenVDB: trees of floats, doubles and halves, as Houdini, Blender and EmberGen write them.
//!
//! A grid's values stand at whole numbers of its index space, so a voxel reaches half a step to either side. The array is
//! the box of the active voxels; inactive voxels between them have the values that they have. Lengths and values have no
//! unit.

mod bytes;
mod codec;
mod header;
mod tree;
mod window;
mod write;

use barnard::data::{AXIS_ORDERS, Array, ArrayFrame, ArrayHeader, Axis, Choose};
use barnard::error::{Error, Result};

use self::bytes::Bytes;
use self::codec::Coding;
use self::header::{Descriptor, Metadata, Transform, descriptors, head};
use self::tree::Tree;
use self::window::Window;
use super::gather::Gather;
use super::{Contents, GridWriter, Member, Reader, Request};

pub(super) const GRID_WRITER: GridWriter =
    GridWriter { extension: "vdb", summary: "OpenVDB fog volume of floats, in pc; nonzero voxels are active", write: write::write };

pub(super) const READER: Reader = Reader {
    extensions: &["vdb"],
    summary: "OpenVDB grid of float, double or half, file versions 222 to 225",
    array: Some(array),
    members: Some(members),
    image: None,
};

/// The class of a grid that holds distances.
const LEVEL_SET: &str = "level set";
/// Tolerance of a zero component of a step, relative to the step: angles are written in single
/// precision.
const NONE: f64 = 1e-6;

fn array(request: &mut Request, choose: Choose) -> Result<Array> {
    let (path, member, limit) = (request.path, request.part, request.memory_limit);
    let mut bytes = Bytes::new(request)?;
    let grids = descriptors(&mut bytes)?;
    let grid = chosen(&grids, member).map_err(|reason| Error::file(path, reason))?;
    bytes.grid.clone_from(&grid.name);
    let (topology, metadata, transform) = head(&mut bytes, grid)?;
    check_class(&metadata).map_err(|reason| bytes.wrong(reason))?;
    let coding = coding_of(&mut bytes, &grids, grid, topology)?;
    let tree = Tree::read(&mut bytes, coding, limit)?;
    let window = tree.bounds().ok_or_else(|| bytes.wrong("it is empty: no voxel is active"))?;
    if tree.background() != 0.0 {
        return Err(bytes.wrong(format!("its background is {}; it must be zero", tree.background())));
    }
    let frame = frame(&transform, &window).map_err(|reason| bytes.wrong(reason))?;
    let part = choose(&ArrayHeader { shape: window.dims.map(|n| n as usize), frame: Some(frame) })?;
    let data = if coding.is_double() {
        tree.values(&mut bytes, &window, Gather::<f64>::new(&part, true, path, limit)?)?
    } else {
        tree.values(&mut bytes, &window, Gather::<f32>::new(&part, true, path, limit)?)?
    };
    Ok(Array { shape: part.shape(), data, fortran: true })
}

/// Storage of the tree of a grid, which comes next. A grid that shares another's has a transform of its own and nothing
/// else.
fn coding_of(bytes: &mut Bytes, grids: &[Descriptor], grid: &Descriptor, coding: Coding) -> Result<Coding> {
    let Some(parent) = &grid.parent else { return Ok(coding) };
    let holder = grids.iter().find(|g| g.name == *parent && g.parent.is_none());
    let holder = holder.ok_or_else(|| bytes.wrong(format!("it shares the tree of \"{parent}\", which is not in the file")))?;
    Ok(head(bytes, holder)?.0)
}

fn members(request: &mut Request) -> Result<Vec<Member>> {
    let limit = request.memory_limit;
    let mut bytes = Bytes::new(request)?;
    let grids = descriptors(&mut bytes)?;
    let mut members = Vec::new();
    for grid in &grids {
        bytes.grid.clone_from(&grid.name);
        let mut facts = vec![("type", grid.tree.clone() + if grid.is_half { ", stored as half" } else { "" })];
        if grid.is_density() {
            // What cannot be read is listed all the same, with why.
            facts.extend(facts_of(&mut bytes, &grids, grid, limit).unwrap_or_else(|error| vec![("refused", error.to_string())]));
        }
        members.push(Member { name: grid.name.clone(), contents: Contents::Numbers, facts });
    }
    Ok(members)
}

/// Metadata of a grid.
fn facts_of(bytes: &mut Bytes, grids: &[Descriptor], grid: &Descriptor, limit: u64) -> Result<Vec<(&'static str, String)>> {
    let (topology, metadata, transform) = head(bytes, grid)?;
    let coding = coding_of(bytes, grids, grid, topology)?;
    let tree = Tree::read(bytes, coding, limit)?;
    let mut facts = Vec::new();
    facts.extend(metadata.get("class").map(|class| ("class", class.clone())));
    facts.push(("stored", coding.packing()));
    facts.extend(grid.parent.as_ref().map(|parent| ("tree", format!("that of \"{parent}\""))));
    facts.push(("active", format!("{} voxels", tree.active)));
    facts.extend(tree.bounds().map(|window| {
        let [x, y, z] = window.low;
        ("box", format!("{} voxels from {x} {y} {z} on", super::edges(window.dims)))
    }));
    facts.push(("background", tree.background().to_string()));
    facts.push(("transform", transform.to_string()));
    Ok(facts)
}

/// The grid that is meant: the one of a name, or the only one that can be a density.
fn chosen<'a>(grids: &'a [Descriptor], member: Option<&str>) -> std::result::Result<&'a Descriptor, String> {
    let list = |grids: &[&Descriptor]| grids.iter().map(|grid| format!("\"{}\"", grid.name)).collect::<Vec<_>>().join(", ");
    let all: Vec<&Descriptor> = grids.iter().collect();
    if let Some(member) = member {
        let found: Vec<&&Descriptor> = all.iter().filter(|grid| grid.name == member).collect();
        return match found[..] {
            [grid] => Ok(grid),
            [] => Err(format!("has no grid \"{member}\"; it has {}", list(&all))),
            _ => Err(format!("has {} indistinguishable grids \"{member}\"", found.len())),
        };
    }
    let able: Vec<&Descriptor> = all.iter().copied().filter(|grid| grid.is_density()).collect();
    match (&able[..], &all[..]) {
        // Of a single grid its own error says what it is.
        ([grid], _) | ([], [grid]) => Ok(grid),
        (_, []) => Err("holds no grids".into()),
        ([], _) => Err(format!("has {} grids, none of float, double or half: {}", all.len(), list(&all))),
        _ => Err(format!("has {} numeric grids ({}); select one with array = \"...\"", able.len(), list(&able))),
    }
}

/// Refuses grids whose values are no densities.
fn check_class(metadata: &Metadata) -> std::result::Result<(), String> {
    if metadata.get("class").is_some_and(|class| class == LEVEL_SET) {
        return Err("it is a level set, not a density; convert it to a fog volume first (Houdini: \"Convert VDB\")".into());
    }
    Ok(())
}

/// The axes of the voxels of a window, where each is an axis of the file's space.
fn frame(transform: &Transform, window: &Window) -> std::result::Result<ArrayFrame, String> {
    let main = transform.matrix.map(|step| (0..3).max_by(|a, b| step[*a].abs().total_cmp(&step[*b].abs())).unwrap_or(0));
    let straight =
        (0..3).all(|i| (0..3).all(|j| j == main[i] || transform.matrix[i][j].abs() <= NONE * transform.matrix[i][main[i]].abs()));
    let order = AXIS_ORDERS.into_iter().find(|order| order.chars().eq(main.map(|axis| ['x', 'y', 'z'][axis])));
    let (true, Some(order)) = (straight, order) else {
        return Err(format!("{}; resample it to voxels along x, y and z first", transform.turning()));
    };
    let mut frame = ArrayFrame { order, is_sparse: true, ..ArrayFrame::default() };
    for (i, axis) in frame.axes.iter_mut().enumerate() {
        let step = transform.matrix[i][main[i]];
        let first = transform.origin[main[i]] + window.low[i] as f64 * step;
        if step == 0.0 || !first.is_finite() {
            return Err("its transform has voxels without volume".into());
        }
        *axis = Some(Axis { unit: String::new(), step, first });
    }
    Ok(frame)
}
