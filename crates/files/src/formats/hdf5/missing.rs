//! Errors of a build without HDF5.

use std::io::Write;

use barnard::data::{Array, Choose};
use barnard::error::{Error, Result};

use crate::formats::{GridFile, Member, Request};
use crate::missing_feature;

pub fn array(request: &mut Request, _: Choose) -> Result<Array> {
    Err(Error::file(request.path, missing_feature("HDF5", "hdf5")))
}

pub fn members(request: &mut Request) -> Result<Vec<Member>> {
    Err(Error::file(request.path, missing_feature("HDF5", "hdf5")))
}

pub fn write(_: &GridFile, _: &mut dyn Write) -> Result<()> {
    Err(Error::Encoding { format: "HDF5", reason: missing_feature("HDF5", "hdf5") })
}
