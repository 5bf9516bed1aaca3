//! HDF5: datasets of three axes, as simulations, yt, h5py and netCDF write them.

#[cfg(not(feature = "hdf5"))]
mod missing;
#[cfg(feature = "hdf5")]
mod read;
#[cfg(feature = "hdf5")]
mod write;

#[cfg(not(feature = "hdf5"))]
use missing::{array, members, write};
#[cfg(feature = "hdf5")]
use read::{array, members};
#[cfg(feature = "hdf5")]
use write::write;

use super::{GridWriter, Reader};

pub(super) const GRID_WRITER: GridWriter =
    GridWriter { extension: "h5", summary: "HDF5 dataset of singles along x, y and z, with units and edges in pc", write };

pub(super) const READER: Reader = Reader {
    extensions: &["h5", "hdf5", "hdf", "he5", "nc", "nc4", "mat"],
    summary: "HDF5 datasets, also of netCDF 4 and MATLAB 7.3",
    array: Some(array),
    members: Some(members),
    image: None,
};
