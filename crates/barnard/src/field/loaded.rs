//! A field from a file: `.npy`, `.npz` (one named array) or a FITS cube.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use spectra::units::{Length, NumberDensity, Quantity};

use super::{Field, Grid, Lattice};
use crate::data::{Array, Frame, Inputs, Numbers};
use crate::error::Result;
use crate::geometry::Bounds;
use crate::properties::{Key, Kind, Section};

pub(super) const KIND: Kind<Arc<dyn Field>> = Kind {
    name: "grid",
    summary: "a three-dimensional array from .npy, .npz or FITS, trilinear between voxel centres",
    keys: &[
        Key::required("file", "path", "the file, relative to the scene"),
        Key::optional("array", "text", "the only one", "name of the array in an .npz, number of the HDU in a FITS file"),
        Key::optional("axes", "text", "xyz (npy, npz), zyx (FITS)", "what the array's axes are, slowest first"),
        Key::optional("low", "position", "from voxel", "lowest corner of the box that the voxels fill"),
        Key::optional("high", "position", "from voxel", "highest corner"),
        Key::optional("voxel", "length", "from low and high", "edge of a cubic voxel, instead of low and high"),
        Key::optional("centre", "position", "0 0 0 pc", "middle of the box, with voxel"),
        Key::optional(
            "unit",
            "text",
            "BUNIT of a FITS file",
            "what the values are in: number densities are turned into cm-3, which dust and gas are scaled by; anything else is taken as it is",
        ),
        Key::optional(
            "wcs",
            "boolean",
            "true",
            "whether a FITS file's own frame is read: CDELT or CD, CRPIX, CRVAL, CUNIT; false where low and high, or voxel, say better",
        ),
        Key::optional("factor", "number", "1", "every value is multiplied by it"),
        Key::optional("clip", "boolean", "false", "blank, NaN and negative cells become zero instead of an error"),
    ],
    build,
};

fn build(section: &Section, inputs: &Inputs) -> Result<Arc<dyn Field>> {
    let file = section.need_text("file")?;
    let array = section.wrap("file", inputs.array(file, section.text("array")?))?;
    let default_axes = if array.frame.is_some() { "zyx" } else { "xyz" };
    let axes = section.choice("axes", &["xyz", "xzy", "yxz", "yzx", "zxy", "zyx"])?.unwrap_or(default_axes);
    let dims = dims(&array, axes);
    let frame = array.frame.clone().unwrap_or_default();
    let own = own_bounds(section, &frame, axes, dims)?;
    let lattice = Lattice { dims, bounds: bounds(section, dims, own)? };
    let factor = section.number("factor", f64::MIN..=f64::MAX)?.unwrap_or(1.0) * unit(section, &frame)?;
    let clip = section.flag("clip")?.unwrap_or(false);
    let largest = match &array.data {
        Numbers::Single(data) => largest(data, factor),
        Numbers::Double(data) => largest(data, factor),
    };
    if largest > 0.0 && largest < f64::from(f32::MIN_POSITIVE) {
        let key = if section.has("factor") { "factor" } else { "file" };
        let message = format!(
            "its values are at most {largest:e} by unit and factor, which single precision does not hold: choose another unit, and the scale of dust or gas for it"
        );
        return Err(section.error(key, message));
    }
    // Numbers that are as a grid has them stay in the memory in which they are.
    let as_it_is = factor == 1.0 && !clip && strides(&array, axes) == [1, dims[0], dims[0] * dims[1]];
    let mut values = match &array.data {
        Numbers::Single(data) if as_it_is => return checked(Grid::sharing(lattice, data.clone()), section),
        Numbers::Single(data) => arranged(data, &array, factor, axes, &lattice),
        Numbers::Double(data) => arranged(data, &array, factor, axes, &lattice),
    };
    if clip {
        values.iter_mut().filter(|v| v.is_nan() || **v < 0.0).for_each(|v| *v = 0.0);
    }
    checked(Grid::of(lattice, values), section)
}

/// A grid whose values can be densities.
fn checked(grid: Grid, section: &Section) -> Result<Arc<dyn Field>> {
    grid.check(section.name())?;
    Ok(Arc::new(grid))
}

/// Voxels along x, y, z.
fn dims(array: &Array, axes: &str) -> [usize; 3] {
    ['x', 'y', 'z'].map(|c| array.shape[axes.find(c).unwrap_or(0)])
}

/// What a value of one is, in cm-3 where it is a number density.
fn unit(section: &Section, frame: &Frame) -> Result<f64> {
    let size = |unit: &str| NumberDensity::unit_size(unit);
    match (section.text("unit")?, frame.unit.as_deref()) {
        (None, None) => Ok(1.0),
        (None, Some(own)) => size(own).ok_or_else(|| {
            let message = format!(
                "the file's BUNIT is \"{own}\", which is no number density: write unit = \"{own}\" to take the values as they are, and choose the scale of dust or gas for it"
            );
            section.error("file", message)
        }),
        (Some(said), None) => size(said).ok_or_else(|| {
            let known: Vec<&str> = NumberDensity::UNITS.iter().map(|(name, _)| *name).collect();
            let message = format!("\"{said}\" is no number density that is known ({}): leave `unit` out to take the values as they are", known.join(", "));
            section.error("unit", message)
        }),
        (Some(said), Some(own)) if said.trim() == own.trim() => Ok(size(said).unwrap_or(1.0)),
        (Some(said), Some(own)) => match (size(said), size(own)) {
            (Some(a), Some(b)) if a == b => Ok(a),
            _ => Err(section.error("unit", format!("the scene says \"{said}\", the file's BUNIT is \"{own}\": one of both is wrong"))),
        },
    }
}

/// The box that a FITS file's own frame says, or why it says none.
fn own_bounds(section: &Section, frame: &Frame, axes: &str, dims: [usize; 3]) -> Result<std::result::Result<Bounds, String>> {
    if !section.flag("wcs")?.unwrap_or(true) {
        return Ok(Err(String::new()));
    }
    let mut bounds = Bounds { low: DVec3::ZERO, high: DVec3::ZERO };
    for (i, letter) in ['x', 'y', 'z'].into_iter().enumerate() {
        let Some(axis) = &frame.axes[axes.find(letter).unwrap_or(0)] else {
            return Ok(Err(String::new()));
        };
        let Some(pc) = Length::unit_size(&axis.unit) else {
            return Ok(Err(match axis.unit.as_str() {
                "" => String::new(),
                unit => format!("the file's axis {letter} is in \"{unit}\", which is no length that is known: "),
            }));
        };
        if axis.step < 0.0 {
            let message = format!(
                "the file's axis {letter} runs backwards (step {} {}): flip the array, or say wcs = false with low and high",
                axis.step, axis.unit
            );
            return Err(section.error("file", message));
        }
        bounds.low[i] = (axis.first - 0.5 * axis.step) * pc;
        bounds.high[i] = bounds.low[i] + dims[i] as f64 * axis.step * pc;
    }
    Ok(Ok(bounds))
}

/// How far voxels of the scene may be from those of the file's own frame, in parts of them.
const FRAME_TOLERANCE: f64 = 0.01;

/// The box: the scene's, or the file's own, `frame`; both must say the same size.
fn bounds(section: &Section, dims: [usize; 3], frame: std::result::Result<Bounds, String>) -> Result<Bounds> {
    let said = ["voxel", "low", "high", "centre"].iter().any(|key| section.has(key));
    let frame = match frame {
        Ok(frame) => frame,
        Err(reason) if !said && !reason.is_empty() => return Err(section.error("file", format!("{reason}say low and high, or voxel"))),
        Err(_) => return said_bounds(section, dims),
    };
    if !said {
        return Ok(frame);
    }
    let own = said_bounds(section, dims)?;
    let (size, other) = (own.size(), frame.size());
    if !((size - other) / other).abs().cmple(DVec3::splat(FRAME_TOLERANCE)).all() {
        let key = if section.has("voxel") { "voxel" } else { "low" };
        let message = format!(
            "the scene's box is {:.4} x {:.4} x {:.4} pc, the file's own frame {:.4} x {:.4} x {:.4} pc: leave out low and high to take the file's, or say wcs = false",
            size.x, size.y, size.z, other.x, other.y, other.z
        );
        return Err(section.error(key, message));
    }
    Ok(own)
}

/// The box that the scene says.
fn said_bounds(section: &Section, dims: [usize; 3]) -> Result<Bounds> {
    if let Some(voxel) = section.positive::<Length>("voxel")? {
        if section.has("low") || section.has("high") {
            return Err(section.error("voxel", "give either voxel (with centre), or low and high, not both"));
        }
        let half = 0.5 * voxel.0 * DVec3::from(dims.map(|n| n as f64));
        let centre = section.position("centre")?.unwrap_or(DVec3::ZERO);
        return Ok(Bounds { low: centre - half, high: centre + half });
    }
    section.bounds("low", "high")
}

/// Planes of a grid that are arranged together.
const PLANES: usize = 16;

/// The largest of some numbers times `factor`, without its sign.
fn largest(data: &[impl Copy + Into<f64> + Sync], factor: f64) -> f64 {
    let of = |part: &[_]| part.iter().fold(0.0, |most: f64, v| most.max((Into::<f64>::into(*v) * factor).abs()));
    data.par_chunks(1 << 16).map(of).reduce(|| 0.0, f64::max)
}

/// How far apart neighbours along x, y and z are in an array.
fn strides(array: &Array, axes: &str) -> [usize; 3] {
    let [n0, n1, n2] = array.shape;
    let strides = if array.fortran { [1, n0, n0 * n1] } else { [n1 * n2, n2, 1] };
    ['x', 'y', 'z'].map(|c| strides[axes.find(c).unwrap_or(0)])
}

/// An array's numbers times `factor`, with x running fastest.
fn arranged(data: &[impl Copy + Into<f64> + Sync], array: &Array, factor: f64, axes: &str, lattice: &Lattice) -> Vec<f32> {
    let [sx, sy, sz] = strides(array, axes);
    let [nx, ny, _] = lattice.dims;
    let mut values = vec![0.0; lattice.cells()];
    // Some planes together: where z runs fastest in the array, a line of memory is read once for all of them.
    values.par_chunks_mut(nx * ny * PLANES).enumerate().for_each(|(block, out)| {
        let planes = out.len() / (nx * ny);
        for y in 0..ny {
            for x in 0..nx {
                let line = &data[x * sx + y * sy + block * PLANES * sz..];
                (0..planes).for_each(|z| out[(z * ny + y) * nx + x] = (factor * line[z * sz].into()) as f32);
            }
        }
    });
    values
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;
    use crate::data::{DataSource, Shared, TextTable};
    use crate::error::Error;
    use crate::properties::{Table, Value};

    /// One array in memory, and nothing else.
    #[derive(Debug)]
    struct One {
        numbers: Shared<f32>,
        fortran: bool,
    }

    impl DataSource for One {
        fn label(&self, name: &str) -> String {
            name.to_owned()
        }
        fn text(&self, name: &str, _: u64) -> Result<Cow<'static, str>> {
            Err(Error::file(name, "is not there"))
        }
        fn table(&self, name: &str, _: usize, _: u64) -> Result<TextTable> {
            Err(Error::file(name, "is not there"))
        }
        fn array(&self, _: &str, _: Option<&str>, _: u64) -> Result<Array> {
            Ok(Array { shape: [2, 3, 4], data: Numbers::Single(self.numbers.clone()), fortran: self.fortran, frame: None })
        }
    }

    /// An array whose x runs fastest is the grid's own memory; in another order, scaled or clipped it is not, and what
    /// is read is the same.
    #[test]
    fn arrays_are_shared_where_they_lie_as_a_grid_has_them() {
        let numbers: Shared<f32> = (0..24).map(|i| i as f32).collect::<Vec<_>>().into();
        let grid = |fortran: bool, more: &[(&str, Value)]| {
            let mut table = Table::default();
            let said = [("file", "a"), ("low", "0 0 0 pc"), ("high", "2 3 4 pc")];
            said.iter().for_each(|(key, text)| table.insert(*key, Value::Text((*text).into())));
            more.iter().for_each(|(key, value)| table.insert(*key, value.clone()));
            let inputs = Inputs::new(Arc::new(One { numbers: numbers.clone(), fortran }), 1 << 20);
            build(&Section::new(&table, "field.a"), &inputs).unwrap()
        };
        let shares = |field: &Arc<dyn Field>| std::ptr::eq(field.grid().unwrap().values().as_ptr(), numbers.as_ptr());
        let own = grid(true, &[]);
        assert!(shares(&own));
        assert_eq!(own.at(DVec3::new(1.5, 0.5, 2.5)), 1.0 + 2.0 * 6.0);
        for (fortran, more) in [(false, vec![]), (true, vec![("factor", Value::Number(2.0))]), (true, vec![("clip", Value::Flag(true))])] {
            assert!(!shares(&grid(fortran, &more)), "{fortran} {more:?}");
        }
        assert_eq!(grid(false, &[]).at(DVec3::new(1.5, 0.5, 2.5)), 12.0 + 2.0);
    }
}
