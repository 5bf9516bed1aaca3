//! A field from a file: `.npy`, `.npz` (one named array) or a FITS cube.

use std::sync::Arc;

use glam::DVec3;
use spectra::units::Length;

use super::{Field, Grid, Lattice};
use crate::error::Result;
use crate::formats::{Array, read_array};
use crate::geometry::Bounds;
use crate::scene::{Key, Kind, Loader, Section};

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
        Key::optional("factor", "number", "1", "every value is multiplied by it"),
        Key::optional("clip", "boolean", "false", "blank, NaN and negative cells become zero instead of an error"),
    ],
    build,
};

fn build(section: &Section, loader: &Loader) -> Result<Arc<dyn Field>> {
    let file = section.need_text("file")?;
    let path = loader.path(file);
    let array =
        section.wrap("file", read_array(&section.wrap("file", loader.read(file))?, &path, section.text("array")?, loader.memory_limit))?;
    let default_axes = if array.fits { "zyx" } else { "xyz" };
    let axes = section.choice("axes", &["xyz", "xzy", "yxz", "yzx", "zxy", "zyx"])?.unwrap_or(default_axes);
    let dims = dims(&array, axes);
    let lattice = Lattice { dims, bounds: bounds(section, dims)? };
    let factor = section.number("factor", f64::MIN..=f64::MAX)?.unwrap_or(1.0) as f32;
    let mut grid = Grid { data: arranged(array, axes, &lattice), lattice };
    if factor != 1.0 {
        grid.data.iter_mut().for_each(|v| *v *= factor);
    }
    if section.flag("clip")?.unwrap_or(false) {
        grid.data.iter_mut().filter(|v| !(v.is_finite() && **v > 0.0)).for_each(|v| *v = 0.0);
    }
    grid.check(section.name())?;
    Ok(Arc::new(grid))
}

/// Voxels along x, y, z.
fn dims(array: &Array, axes: &str) -> [usize; 3] {
    ['x', 'y', 'z'].map(|c| array.shape[axes.find(c).unwrap_or(0)])
}

fn bounds(section: &Section, dims: [usize; 3]) -> Result<Bounds> {
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

/// The values with x running fastest.
fn arranged(array: Array, axes: &str, lattice: &Lattice) -> Vec<f32> {
    let [n0, n1, n2] = array.shape;
    let strides = if array.fortran { [1, n0, n0 * n1] } else { [n1 * n2, n2, 1] };
    let [sx, sy, sz] = ['x', 'y', 'z'].map(|c| strides[axes.find(c).unwrap_or(0)]);
    if (sx, sy, sz) == (1, lattice.dims[0], lattice.dims[0] * lattice.dims[1]) {
        return array.data;
    }
    let [nx, ny, nz] = lattice.dims;
    let mut data = Vec::with_capacity(array.data.len());
    for z in 0..nz {
        for y in 0..ny {
            data.extend((0..nx).map(|x| array.data[x * sx + y * sy + z * sz]));
        }
    }
    data
}
