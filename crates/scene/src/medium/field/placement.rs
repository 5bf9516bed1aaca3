//! Placement of a file's array in a scene, and the part that is read.

use glam::DVec3;
use spectra::units::{Length, MemorySize, Quantity};

use super::Lattice;
use super::dust_map::DustMap;
use crate::blocks::{Blocking, Storage};
use crate::data::{AXIS_ORDERS, Array, ArrayFrame, ArrayHeader, ArrayPart, Axis};
use crate::error::Result;
use crate::geometry::Bounds;
use crate::properties::{Choice, Choices, Flag, Integer, Key, KeyRow, OrDefault, Path, Position, Required, Section};

/// Tolerance between voxels of the scene and of the file's own frame, relative to a voxel.
const FRAME_TOLERANCE: f64 = 0.01;
/// Tolerance of corners on the face of a box \[voxels\].
const ON_A_FACE: f64 = 1e-3;
/// Voxels along an edge of a block at most.
pub(super) const AXES: Key<Choice<AxisOrder>> =
    Key::choice("axes", "order of the array's axes, slowest first").otherwise("xyz (npy, npz), zyx (FITS), the file's own (HDF5, vdb)");
pub(super) const LOW: Key<Position> = Key::position(
    "low",
    "lowest corner of the box of the voxels; if the file or voxel defines the box, of the part to read, in whole voxels",
)
.otherwise("from the file, or from voxel");
pub(super) const HIGH: Key<Position> = Key::position("high", "highest corner").otherwise("from the file, or from voxel");
pub(super) const VOXEL: Key<Length> =
    Key::quantity::<Length>("voxel", "edge of a cubic voxel, which defines the box of the whole array").otherwise("from low and high");
pub(super) const SCALE: Key<Length> = Key::quantity::<Length>("scale", "unit of length of files without one, such as .vdb");
pub(super) const CENTRE: Key<Position> =
    Key::position("centre", "centre of the box of the whole array").otherwise("0 0 0 pc with voxel, otherwise from the file");
pub(super) const EVERY: Key<Integer<usize>, OrDefault> =
    Key::integer("every", "number of voxels per axis to average into one; the whole file is never in memory")
        .range(1..=LARGEST_BLOCK)
        .default(1);
pub(super) const MEMORY: Key<MemorySize> =
    Key::quantity::<MemorySize>("memory", "memory limit of the array, met by the smallest sufficient `every`").positive().excludes("every");
pub(super) const WCS: Key<Flag, OrDefault> = Key::flag(
    "wcs",
    "read the file's coordinates (CDELT or CD, CRPIX, CRVAL, CUNIT of FITS, coordinates or edges of HDF5, the transform of .vdb); false to use low and high, or voxel",
)
.default(true);
pub(super) const FILE: Key<Path, Required> = Key::path("file", "the file, relative to the scene").required();
pub(super) const PRESET: Key<Choice<&'static DustMap>> = Key::choice(
    "preset",
    "published dust map of the Galaxy, converted to extinction at V in mag/pc (use with scale = \"1 mag/pc\"); it defines array, unit and box, and clips",
);

/// Order of the axes of an array, slowest first.
#[derive(Clone, Copy)]
pub(super) struct AxisOrder(&'static str);

impl Choices for AxisOrder {
    const ROWS: &'static [(&'static str, Self)] = &[
        (AXIS_ORDERS[0], Self(AXIS_ORDERS[0])),
        (AXIS_ORDERS[1], Self(AXIS_ORDERS[1])),
        (AXIS_ORDERS[2], Self(AXIS_ORDERS[2])),
        (AXIS_ORDERS[3], Self(AXIS_ORDERS[3])),
        (AXIS_ORDERS[4], Self(AXIS_ORDERS[4])),
        (AXIS_ORDERS[5], Self(AXIS_ORDERS[5])),
    ];
}

const LARGEST_BLOCK: i64 = 1024;

/// Which axis of an array is which of the scene's, the part of it that is read, and the voxels that come of it.
#[derive(Debug)]
pub struct Placement {
    /// The axis of the array that x, y and z are.
    axes: [usize; 3],
    /// True if x, y and z run against its indices.
    backwards: [bool; 3],
    /// Part of the array that is read.
    pub part: ArrayPart,
    /// The voxels of the scene.
    pub lattice: Lattice,
}

impl Placement {
    /// The place of an array that its file lays out so, by the keys of a section.
    pub fn of(section: &Section, layout: &ArrayHeader) -> Result<Self> {
        let usual = layout.frame.as_ref().map_or("xyz", |frame| frame.order);
        let stated = section.read(&AXES)?.map(|AxisOrder(order)| order);
        let file = section.stated(&FILE)?.unwrap_or("the file");
        if let Some(names) = layout.frame.as_ref().and_then(|frame| frame.unnamed.as_ref()).filter(|_| stated.is_none()) {
            let message = format!("{file}: the axes are {names}, slowest first, not x, y and z; write axes = \"zyx\" or another order");
            return Err(section.error(&FILE, message));
        }
        let order = stated.unwrap_or(usual);
        let axes = by_letter(order);
        let dims = axes.map(|axis| layout.shape[axis]);
        let file_box = OwnBox::of(section, layout.frame.as_ref(), axes, dims)?;
        let backwards = file_box.backwards;
        let (whole, wanted) = boxes(section, dims, file_box)?;
        let every = section.stated(&EVERY)?;
        let placed = |every: usize| {
            let part = ArrayPart { every, ..layout.whole() };
            let mut placement = Self { axes, backwards, part, lattice: Lattice { dims, bounds: whole } };
            (0..3).for_each(|axis| placement.cut(axis, &whole, wanted.as_ref(), dims[axis]));
            placement
        };
        let Some(memory) = section.read(&MEMORY)? else { return Ok(placed(every.unwrap_or(1))) };
        let fits = |placement: &Self| placement.bytes() as f64 <= memory.0;
        (1..=LARGEST_BLOCK as usize).map(placed).find(fits).ok_or_else(|| {
            let message = format!("no array fits into {memory}, not even with blocks of {LARGEST_BLOCK} voxels; increase memory");
            section.error(&MEMORY, message)
        })
    }

    /// Bytes that the numbers of its voxels take at most while they are read: as doubles, as a grid holds them, and their
    /// sums.
    fn bytes(&self) -> u64 {
        let each = if self.part.every > 1 { 16 } else { 12 };
        self.part.shape().iter().fold(each, |bytes, edge| bytes.saturating_mul(*edge as u64))
    }

    /// Cuts one axis of the whole box to the voxels that the wanted one touches, and joins them to blocks.
    fn cut(&mut self, axis: usize, whole: &Bounds, wanted: Option<&Bounds>, count: usize) {
        let step = whole.size()[axis] / count as f64;
        let place = |at: f64| (at - whole.low[axis]) / step;
        let range = wanted.map_or(0..count, |wanted| {
            let first = ((place(wanted.low[axis]) + ON_A_FACE).floor().max(0.0) as usize).min(count - 1);
            first..((place(wanted.high[axis]) - ON_A_FACE).ceil() as usize).clamp(first + 1, count)
        });
        let every = self.part.every;
        let cells = range.len().div_ceil(every);
        let bounds = &mut self.lattice.bounds;
        if range.len() < count || every > 1 {
            let size = (cells * every) as f64 * step;
            if self.backwards[axis] {
                bounds.high[axis] = whole.low[axis] + range.end as f64 * step;
                bounds.low[axis] = bounds.high[axis] - size;
            } else {
                bounds.low[axis] = whole.low[axis] + range.start as f64 * step;
                bounds.high[axis] = bounds.low[axis] + size;
            }
        }
        self.lattice.dims[axis] = cells;
        self.part.ranges[self.axes[axis]] = if self.backwards[axis] { count - range.end..count - range.start } else { range };
    }

    /// Conversion of the array to blocks.
    pub fn blocking(&self, factor: f64, clip: bool, storage: Storage) -> Blocking {
        Blocking { axes: self.axes, backwards: self.backwards, factor, clip, storage }
    }

    /// Where the voxel 0, 0, 0 is in an array that was read so, and how far its neighbours along x, y and z are from it.
    pub fn strides(&self, array: &Array) -> (usize, [isize; 3]) {
        let [n0, n1, n2] = array.shape;
        let strides = if array.fortran { [1, n0, n0 * n1] } else { [n1 * n2, n2, 1] };
        let mut first = 0;
        let signed = std::array::from_fn(|axis| {
            let stride = strides[self.axes[axis]];
            if self.backwards[axis] {
                first += (self.lattice.dims[axis] - 1) * stride;
                -(stride as isize)
            } else {
                stride as isize
            }
        });
        (first, signed)
    }
}

/// The axes of an array that x, y and z are, in an order by name.
fn by_letter(order: &str) -> [usize; 3] {
    ['x', 'y', 'z'].map(|letter| order.find(letter).unwrap_or(0))
}

/// The box that a file's own frame says.
struct OwnBox {
    /// The box, or why there is none; nothing where the file is silent.
    bounds: std::result::Result<Bounds, String>,
    /// True if x, y and z run against the indices.
    backwards: [bool; 3],
    /// True if its voxels are cubes, as far as it says.
    is_cubic: bool,
    /// True if there is nothing beyond it.
    is_sparse: bool,
    /// True if the scene may place all of it elsewhere by its corners: what is measured or sparse is where it is.
    is_movable: bool,
}

impl OwnBox {
    fn of(section: &Section, frame: Option<&ArrayFrame>, axes: [usize; 3], dims: [usize; 3]) -> Result<Self> {
        let scale = section.read(&SCALE)?;
        let is_sparse = frame.is_some_and(|frame| frame.is_sparse);
        let silent = |reason: String| Self { bounds: Err(reason), backwards: [false; 3], is_cubic: true, is_sparse, is_movable: true };
        let is_read = section.read(&WCS)?;
        let file = section.stated(&FILE)?.unwrap_or("the file");
        let frame = frame.filter(|_| is_read);
        if let Some(frame) = frame {
            Self::check(section, file, frame, axes)?;
        }
        let axes_stated: Option<Vec<&Axis>> = frame.and_then(|frame| axes.iter().map(|axis| frame.axes[*axis].as_ref()).collect());
        let Some(axes_stated) = axes_stated else {
            if scale.is_some() {
                return Err(section.error(&SCALE, "the file has no lengths to scale; write voxel, or low and high"));
            }
            return Ok(silent(String::new()));
        };
        if let (Some(_), Some(axis)) = (scale, axes_stated.iter().find(|axis| !axis.unit.is_empty())) {
            return Err(section.error(&SCALE, format!("the file's axes are in \"{}\"; remove scale", axis.unit)));
        }
        let mut bounds = Ok(Bounds { low: DVec3::ZERO, high: DVec3::ZERO });
        for (i, axis) in axes_stated.iter().enumerate() {
            let unit = if axis.unit.is_empty() { scale.map(|scale| scale.0) } else { Length::unit_size(&axis.unit) };
            match (unit, &mut bounds) {
                (Some(pc), Ok(bounds)) => {
                    let ends = [axis.first - 0.5 * axis.step, axis.first + (dims[i] as f64 - 0.5) * axis.step].map(|end| end * pc);
                    (bounds.low[i], bounds.high[i]) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                }
                (None, _) if axis.unit.is_empty() => {
                    bounds = Err("the file's lengths have no unit; write scale, its unit of length, ".into())
                }
                (None, _) => {
                    let letter = ['x', 'y', 'z'][i];
                    return Ok(silent(format!("the file's axis {letter} has the unknown length unit \"{}\"; write ", axis.unit)));
                }
                (Some(_), Err(_)) => {}
            }
        }
        let steps = DVec3::from(std::array::from_fn(|i| axes_stated[i].step.abs()));
        let is_cubic = axes_stated.iter().any(|axis| axis.unit != axes_stated[0].unit)
            || steps.max_element() <= (1.0 + FRAME_TOLERANCE) * steps.min_element();
        let backwards = std::array::from_fn(|i| axes_stated[i].step < 0.0);
        Ok(Self { bounds, backwards, is_cubic, is_sparse, is_movable: !is_sparse && !section.has(&PRESET) })
    }

    /// Rejects a frame that is no box of three lengths, or whose axes are ambiguous.
    fn check(section: &Section, file: &str, frame: &ArrayFrame, axes: [usize; 3]) -> Result<()> {
        if let Some((i, other)) = (0..3).find_map(|i| Some((i, frame.others[axes[i]].as_ref()?))) {
            let message = format!(
                "{file}: axis {} is a {other}, so the cube is not a volume; convert it to a density along three lengths, or write wcs = false with low and high to read it as one",
                ['x', 'y', 'z'][i]
            );
            return Err(section.error(&FILE, message));
        }
        if let Some(problem) = &frame.problem {
            let message = format!("{file}: {problem}; resample the cube along its own axes, or place it with wcs = false, low and high");
            return Err(section.error(&FILE, message));
        }
        if frame.is_by_letter && axes != by_letter(frame.order) {
            let message = format!(
                "the file defines its box along x, y and z but does not name its axes, which were read as {}; write low and high, and wcs = false",
                frame.order
            );
            return Err(section.error(&AXES, message));
        }
        Ok(())
    }
}

/// The box that all of an array fills, and that which is wanted of it where it is not all.
fn boxes(section: &Section, dims: [usize; 3], file_box: OwnBox) -> Result<(Bounds, Option<Bounds>)> {
    let corners = (section.has(&LOW) || section.has(&HIGH)).then(|| section.bounds(&LOW, &HIGH)).transpose()?;
    let centre = section.read(&CENTRE)?;
    if let (Some(_), Some(_), None) = (centre, corners, section.read(&VOXEL)?) {
        return Err(section.error(&CENTRE, "low and high already define the box; remove one"));
    }
    if let Some(voxel) = section.read(&VOXEL)? {
        if !file_box.is_cubic {
            return Err(section.error(&VOXEL, "the file's voxels are not cubes; write scale, or low and high"));
        }
        let half = 0.5 * voxel.0 * DVec3::from(dims.map(|n| n as f64));
        let centre = centre.unwrap_or(DVec3::ZERO);
        let whole = Bounds { low: centre - half, high: centre + half };
        if let Ok(frame) = file_box.bounds.as_ref() {
            has_same_size(&whole, frame).then_some(()).ok_or_else(|| other_size(section, &VOXEL.row, &whole, frame))?;
        }
        return within(section, whole, corners, file_box.is_sparse);
    }
    match (file_box.bounds, corners) {
        // A box of the same size elsewhere is all of the array, moved there.
        (Ok(frame), Some(corners)) if file_box.is_movable && has_same_size(&corners, &frame) && !lies_within(&corners, &frame) => {
            Ok((corners, None))
        }
        (Ok(frame), corners) => {
            let moved = centre.map_or(DVec3::ZERO, |centre| centre - 0.5 * (frame.low + frame.high));
            within(section, Bounds { low: frame.low + moved, high: frame.high + moved }, corners, file_box.is_sparse)
        }
        (Err(_), Some(corners)) => Ok((corners, None)),
        (Err(reason), None) if reason.is_empty() => {
            let message = "the array does not define a box; write low = \"-1 -1 -1 pc\" and high = \"1 1 1 pc\", or voxel = \"0.1 pc\"";
            Err(section.error(&LOW, message))
        }
        (Err(reason), None) => Err(section.error(&FILE, format!("{reason}voxel, or low and high"))),
    }
}

fn has_same_size(one: &Bounds, other: &Bounds) -> bool {
    ((one.size() - other.size()) / other.size()).abs().cmple(DVec3::splat(FRAME_TOLERANCE)).all()
}

fn lies_within(inner: &Bounds, outer: &Bounds) -> bool {
    let room = outer.size() * 1e-6;
    inner.low.cmpge(outer.low - room).all() && inner.high.cmple(outer.high + room).all()
}

/// The whole box, and the corners of what is wanted, which lie within it; where there is nothing beyond it they are cut.
fn within(section: &Section, whole: Bounds, corners: Option<Bounds>, is_sparse: bool) -> Result<(Bounds, Option<Bounds>)> {
    let corners = corners.map(|corners| {
        let cut = Bounds { low: corners.low.max(whole.low), high: corners.high.min(whole.high) };
        if is_sparse && cut.low.cmplt(cut.high).all() { cut } else { corners }
    });
    match corners {
        Some(corners) if !lies_within(&corners, &whole) => Err(other_size(section, &LOW.row, &corners, &whole)),
        corners => Ok((whole, corners)),
    }
}

fn other_size(section: &Section, key: &KeyRow, stated: &Bounds, frame_box: &Bounds) -> crate::error::Error {
    let words = |size: DVec3| format!("{:.4} x {:.4} x {:.4} pc", size.x, size.y, size.z);
    let corner = |at: DVec3| format!("{:.4} {:.4} {:.4}", at.x, at.y, at.z);
    let message = format!(
        "the scene's box is {}, that of the array {} (from {} to {} pc); remove the scene's box, choose a box within the array, or write wcs = false",
        words(stated.size()),
        words(frame_box.size()),
        corner(frame_box.low),
        corner(frame_box.high)
    );
    section.error(key, message)
}
