//! Header of a grid's values: the file's head, a grid's name and type, metadata, and its transform.
//!
//! Source: OpenVDB, io/Archive.cc, io/GridDescriptor.cc, math/Maps.h, math/Transform.cc.

use std::collections::HashMap;

use barnard::error::{Error, Result};

use super::bytes::Bytes;
use super::codec::{COMPRESSIONS, Coding};

pub const MAGIC: i64 = 0x5644_4220;
/// File versions that are read: from the one that says what inactive values are, to that of OpenVDB 13.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=225;
/// Grids of a file at most.
const MOST_GRIDS: u32 = 4096;
/// Entries of metadata at most.
const MOST_METADATA: u32 = 1 << 16;
/// Metadata that are longer are left out \[bytes\].
const LONGEST_METADATA: usize = 1 << 12;
/// The end of the type of a grid whose values are stored as half.
const HALF: &str = "_HalfFloat";
/// Separator of a grid's name and number for duplicate names.
const NUMBER: char = '\u{1e}';

/// One grid of a file, as its header states it.
#[derive(Debug, Clone)]
pub struct Descriptor {
    /// The name, with its number where it is not the only one of it.
    pub name: String,
    /// The type of its tree, such as `Tree_float_5_4_3`.
    pub tree: String,
    /// True if values are stored as half.
    pub is_half: bool,
    /// The grid whose tree it shares, where it has none of its own.
    pub parent: Option<String>,
    /// The place of its metadata.
    pub start: u64,
}

/// Values that say what a grid is; of those that are no text, none.
pub type Metadata = HashMap<String, String>;

/// A map from places among voxels to the file's own lengths: x = M i + t.
#[derive(Debug, Clone, PartialEq)]
pub struct Transform {
    /// Columns are where a step along each axis of the voxels goes.
    pub matrix: [[f64; 3]; 3],
    /// Index of voxel (0, 0, 0).
    pub origin: [f64; 3],
}

impl Transform {
    /// Transform other than translation and axis-aligned scaling, in words.
    pub fn turning(&self) -> &'static str {
        let m = &self.matrix;
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
        let is_square = |a: usize, b: usize| dot(m[a], m[b]).powi(2) <= 1e-10 * dot(m[a], m[a]) * dot(m[b], m[b]);
        let square = is_square(0, 1) && is_square(1, 2) && is_square(2, 0);
        if square { "its transform rotates its voxels" } else { "its transform shears its voxels" }
    }
}

impl std::fmt::Display for Transform {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let vector = |v: [f64; 3]| v.map(|x| x.to_string()).join(" ");
        let [x, y, z] = self.matrix.map(vector);
        write!(f, "steps of a voxel along x: {x}; y: {y}; z: {z}; the voxel 0 0 0 at {}", vector(self.origin))
    }
}

/// The types of trees that hold numbers.
pub const FLOAT: &str = "Tree_float_5_4_3";
const DOUBLE: &str = "Tree_double_5_4_3";
const OF_HALF: &str = "Tree_half_5_4_3";

impl Descriptor {
    /// True if its values are numbers that a density can have.
    pub fn is_density(&self) -> bool {
        [FLOAT, DOUBLE, OF_HALF].contains(&&*self.tree)
    }
}

/// The grids of a file.
pub fn descriptors(bytes: &mut Bytes) -> Result<Vec<Descriptor>> {
    if bytes.left() < 8 || bytes.i64()? != MAGIC {
        return Err(bytes.wrong_at(0, "is not an OpenVDB file: it does not begin with \" BDV\""));
    }
    let version = bytes.u32()?;
    if !VERSIONS.contains(&version) {
        let message = format!(
            "file version {version} is unsupported; {} to {} are supported: save it with OpenVDB 3 to 13",
            VERSIONS.start(),
            VERSIONS.end()
        );
        return Err(bytes.wrong(message));
    }
    // The library's version, of which nothing depends.
    bytes.skip(8)?;
    let has_offsets = bytes.u8()? != 0;
    // Its universal number.
    bytes.skip(36)?;
    metadata(bytes)?;
    let count = bytes.u32()?;
    if count > MOST_GRIDS {
        return Err(bytes.wrong(format!("{count} grids are announced; at most {MOST_GRIDS} are supported")));
    }
    if !has_offsets && count > 1 {
        return Err(
            bytes.wrong(format!("the file is a stream of {count} grids without offsets; save it as a seekable file, or with one grid"))
        );
    }
    let mut grids: Vec<Descriptor> = Vec::new();
    for _ in 0..count {
        bytes.grid = String::new();
        let unique = bytes.text()?;
        let (name, number) = unique.split_once(NUMBER).unwrap_or((&unique, ""));
        let name = if number.is_empty() { name.to_owned() } else { format!("{name}[{number}]") };
        bytes.grid.clone_from(&name);
        let tree = bytes.text()?;
        let parent = Some(bytes.text()?).filter(|parent| !parent.is_empty());
        let parent = parent.map(|p| p.split_once(NUMBER).map_or(p.clone(), |(name, number)| format!("{name}[{number}]")));
        // The second is where the values of the leaves begin, right behind the tree; some writers leave it out.
        let [start, _, end] = [bytes.i64()?, bytes.i64()?, bytes.i64()?].map(|place| place.max(0) as u64);
        let (start, end) = if has_offsets { (start, end) } else { (bytes.at(), bytes.at()) };
        // Grids stand one behind another: whoever points back would be read for ever.
        if start < bytes.at() || end < start {
            return Err(bytes.wrong(format!("its range of bytes, {start} to {end}, is invalid")));
        }
        let (tree, is_half) = tree.strip_suffix(HALF).map_or((tree.clone(), false), |tree| (tree.to_owned(), true));
        grids.push(Descriptor { name, tree, is_half, parent, start });
        bytes.go(end)?;
    }
    bytes.grid = String::new();
    Ok(grids)
}

/// A list of names, types and values.
fn metadata(bytes: &mut Bytes) -> Result<Metadata> {
    let count = bytes.u32()?;
    if count > MOST_METADATA {
        return Err(bytes.wrong(format!("{count} metadata entries are announced; at most {MOST_METADATA} are supported")));
    }
    let mut known = Metadata::new();
    for _ in 0..count {
        let (name, kind) = (bytes.text()?, bytes.text()?);
        let size = bytes.u32()? as usize;
        if kind == "string" && size <= LONGEST_METADATA {
            known.insert(name, String::from_utf8_lossy(&bytes.take(size)?).into_owned());
        } else {
            bytes.skip(size as u64)?;
        }
    }
    Ok(known)
}

/// Header of a grid's tree: how it is stored, what it is, and where it is.
pub fn head(bytes: &mut Bytes, grid: &Descriptor) -> Result<(Coding, Metadata, Transform)> {
    let (full, packed) = match (&*grid.tree, grid.is_half) {
        (FLOAT, false) => (4, 4),
        (FLOAT, true) => (4, 2),
        (DOUBLE, false) => (8, 8),
        (DOUBLE, true) => (8, 2),
        (OF_HALF, _) => (2, 2),
        (tree, _) => return Err(refused(bytes, tree)),
    };
    bytes.go(grid.start)?;
    let compression = bytes.u32()?;
    if compression & !COMPRESSIONS != 0 {
        return Err(bytes.wrong(format!("compression {compression:#x} is unknown")));
    }
    let metadata = metadata(bytes)?;
    let transform = transform(bytes)?;
    Ok((Coding { compression, full, packed, background: 0.0 }, metadata, transform))
}

/// The error for a tree that is no density.
fn refused(bytes: &Bytes, tree: &str) -> Error {
    let what = match tree {
        _ if tree.starts_with("Tree_vec") => "it has vectors; a density requires one number per voxel",
        _ if tree.starts_with("Tree_ptdata") || tree.starts_with("Tree_ptindex") => {
            "it has points; convert them to a density first (Houdini: \"VDB from Particles\")"
        }
        _ if tree.starts_with("Tree_int") || tree.starts_with("Tree_bool") || tree.starts_with("Tree_mask") => {
            "it has integers or a mask; a density requires float, double or half"
        }
        _ => "its tree is unsupported; use float, double or half with nodes of 32, 16 and 8 voxels",
    };
    bytes.wrong(format!("{what} (type {tree})"))
}

fn transform(bytes: &mut Bytes) -> Result<Transform> {
    let kind = bytes.text()?;
    let scaled = |scale: [f64; 3], origin: [f64; 3]| {
        let column = |axis: usize| std::array::from_fn(|i| if i == axis { scale[axis] } else { 0.0 });
        Transform { matrix: std::array::from_fn(column), origin }
    };
    let transform = match &*kind {
        "UniformScaleMap" | "ScaleMap" => {
            let [x, y, z, ..] = bytes.doubles::<15>()?;
            scaled([x, y, z], [0.0; 3])
        }
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let [a, b, c, x, y, z, ..] = bytes.doubles::<18>()?;
            scaled([x, y, z], [a, b, c])
        }
        "TranslationMap" => scaled([1.0; 3], bytes.doubles::<3>()?),
        "AffineMap" | "UnitaryMap" => {
            // Rows are where the axes go, the fourth where the origin does.
            let m = bytes.doubles::<16>()?;
            let row = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
            Transform { matrix: [row(0), row(1), row(2)], origin: row(3) }
        }
        "NonlinearFrustumMap" => {
            return Err(bytes.wrong("it has a frustum transform (NonlinearFrustumMap); resample it to a uniform box first"));
        }
        other => return Err(bytes.wrong(format!("its transform \"{other}\" is unknown"))),
    };
    let numbers = transform.matrix.iter().flatten().chain(&transform.origin);
    if !numbers.copied().all(f64::is_finite) {
        return Err(bytes.wrong("its transform is not finite"));
    }
    Ok(transform)
}
