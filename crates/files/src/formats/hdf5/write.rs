//! A grid as a dataset of an HDF5 file, by x, y and z, with the attributes that are read again: unit and edges.

use std::io::Write;

use barnard::error::{Error, Result};
use barnard::memory;
use hdf5_pure::{AttrValue, FileBuilder};

use crate::formats::GridFile;

/// The array, and what the library makes of it, are in memory together.
const COPIES: u64 = 3;

pub fn write(file: &GridFile, out: &mut dyn Write) -> Result<()> {
    let lattice = file.grid.lattice();
    let [nx, ny, nz] = lattice.dims;
    memory::check("the grid as HDF5", COPIES * 4 * lattice.cells() as u64, file.memory_limit)?;
    let mut values = vec![0.0f32; lattice.cells()];
    let mut row = vec![0.0; nx];
    for (y, z) in (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))) {
        file.grid.row(0..nx, y, z, &mut row);
        row.iter().enumerate().for_each(|(x, value)| values[(x * ny + y) * nz + z] = *value);
    }
    let mut builder = FileBuilder::new();
    builder.set_attr("creator", AttrValue::AsciiString(concat!("Barnard ", env!("CARGO_PKG_VERSION")).into()));
    let text = |text: &str| AttrValue::String(text.to_owned());
    let dataset = builder.create_dataset(file.name).with_f32_data(&values).with_shape(&[nx, ny, nz].map(|n| n as u64));
    drop(values);
    for (name, corner) in [("left_edge", lattice.bounds.low), ("right_edge", lattice.bounds.high)] {
        dataset.set_attr(name, AttrValue::F64Array(corner.to_array().to_vec()));
        dataset.set_attr(&format!("{name}_units"), text("pc"));
    }
    if let Some(unit) = file.unit {
        dataset.set_attr("units", text(unit));
    }
    builder.finish_to(out).map_err(|e| Error::Encoding { format: "HDF5", reason: e.to_string() })
}
