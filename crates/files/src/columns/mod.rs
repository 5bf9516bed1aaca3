//! Columns of numbers out of files of any format: text, ECSV, VOTable and FITS tables, recognised by what they begin with.

pub(crate) mod ecsv;
mod votable;

use std::io::Cursor;
use std::path::Path;

use barnard::error::{Error, Result};
use spectra::curve::Columns;

use crate::formats::{Request, fits_columns};

/// Reads the columns of a file of these bytes; `label` is its name in messages.
///
/// # Errors
/// If it holds no columns of numbers.
pub fn read(label: &str, bytes: &[u8], memory_limit: u64) -> Result<Columns> {
    let path = Path::new(label);
    if bytes.starts_with(b"SIMPLE  =") {
        let mut request = Request::new(Cursor::new(bytes.to_vec()), path, None, memory_limit)?;
        return fits_columns(&mut request);
    }
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(Error::file(path, "is UTF-16 text; save it as UTF-8"));
    }
    let text = std::str::from_utf8(bytes)
        .map_err(|_| Error::file(path, "is neither UTF-8 text nor a FITS table; save it as UTF-8 text, ECSV, VOTable or FITS"))?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim_start().starts_with("<?xml") || text.trim_start().starts_with("<VOTABLE") {
        return Ok(votable::parse(label, text)?);
    }
    if text.starts_with(ecsv::MAGIC) {
        return Ok(ecsv::parse(label, text)?);
    }
    Ok(Columns::parse(label, text)?)
}
