//! Files in and out. A format is one file and one row of [`READERS`] or [`WRITERS`], chosen by the name's extension.

mod exr;
mod fits;
mod npy;
mod png;
mod write;

use std::path::Path;

pub(crate) use npy::{archive, doubles};
pub use png::encode_png;
pub use write::{check_replaceable, check_writable, replace, save};

use crate::error::{Error, Result};
use crate::image::{Display, Image};
use spectra::error::nearest;

/// A three-dimensional array as it stands in a file.
pub struct Array {
    /// Lengths of the axes, in the file's order of indices.
    pub shape: [usize; 3],
    /// The values, in the file's order.
    pub data: Vec<f32>,
    /// Whether the first index runs fastest.
    pub fortran: bool,
    /// Whether the file was FITS, whose customs for axes differ.
    pub fits: bool,
}

/// What was read of a file: bytes, where they are from, which part is meant.
pub struct Request<'a> {
    /// The file's bytes.
    pub bytes: &'a [u8],
    /// Its name, for messages.
    pub path: &'a Path,
    /// The array or HDU that is meant.
    pub part: Option<&'a str>,
    /// Most bytes that may be allocated.
    pub memory_limit: u64,
}

/// One row of the readers.
pub struct Reader {
    /// Extensions, lower case.
    pub extensions: &'static [&'static str],
    /// One line.
    pub summary: &'static str,
    /// Reads a three-dimensional array.
    pub array: fn(&Request) -> Result<Array>,
    /// Reads an image, where the format holds them.
    pub image: Option<fn(&Request) -> Result<Image>>,
}

/// Formats that can be read.
pub const READERS: &[Reader] = &[npy::NPY_READER, npy::NPZ_READER, fits::READER, exr::READER];

/// One row of the writers.
pub struct Writer {
    /// Extension, lower case.
    pub extension: &'static str,
    /// One line.
    pub summary: &'static str,
    /// The image as the bytes of a file.
    pub encode: fn(&Image, &Display) -> Result<Vec<u8>>,
}

/// Formats that can be written.
pub const WRITERS: &[Writer] = &[exr::WRITER, fits::WRITER, npy::WRITER, png::WRITER];

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// The writer for a path, by its extension.
pub fn writer(path: &Path) -> Result<&'static Writer> {
    let wanted = extension(path);
    let known: Vec<&str> = WRITERS.iter().map(|w| w.extension).collect();
    WRITERS.iter().find(|w| w.extension == wanted).ok_or_else(|| {
        let hint = nearest(&wanted, known.iter().copied()).map(|n| format!(", did you mean .{n}?")).unwrap_or_default();
        Error::file(path, format!("cannot write \".{wanted}\"{hint}; known: .{}", known.join(", .")))
    })
}

fn reader(path: &Path) -> Result<&'static Reader> {
    let wanted = extension(path);
    let known: Vec<&str> = READERS.iter().flat_map(|r| r.extensions.iter().copied()).collect();
    READERS
        .iter()
        .find(|r| r.extensions.contains(&wanted.as_str()))
        .ok_or_else(|| Error::file(path, format!("cannot read \".{wanted}\"; known: .{}", known.join(", ."))))
}

/// Reads a three-dimensional array; `part` names the array or HDU, `memory_limit` is in bytes.
pub fn read_array(bytes: &[u8], path: &Path, part: Option<&str>, memory_limit: u64) -> Result<Array> {
    (reader(path)?.array)(&Request { bytes, path, part, memory_limit })
}

/// Reads an image that was written before.
pub fn read_image(path: &Path, memory_limit: u64) -> Result<Image> {
    let read = reader(path)?;
    let image = read.image.ok_or_else(|| Error::file(path, "holds no image; compare .npy, .fits or .exr"))?;
    let bytes = std::fs::read(path).map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
    image(&Request { bytes: &bytes, path, part: None, memory_limit })
}

/// The shape as three axes and its number of values, after checks of rank, emptiness and memory.
fn checked_shape(request: &Request, shape: &[u64]) -> Result<([usize; 3], usize)> {
    let path = request.path;
    let &[a, b, c] = shape else {
        return Err(Error::file(path, format!("the array has {} axes ({shape:?}), a grid has three", shape.len())));
    };
    let cells = a.checked_mul(b).and_then(|n| n.checked_mul(c)).filter(|n| *n > 0);
    let cells = cells.ok_or_else(|| Error::file(path, format!("the array's shape {shape:?} is empty or impossible")))?;
    check_memory(&format!("the array of {}", path.display()), cells.saturating_mul(4), request.memory_limit)?;
    Ok(([a as usize, b as usize, c as usize], cells as usize))
}

/// The name of band `index` in a file that knows no names.
pub fn nameless(index: usize) -> String {
    format!("band{index}")
}

/// Refuses what would not fit before it is allocated.
pub fn check_memory(what: &str, bytes: u64, limit: u64) -> Result<()> {
    if bytes > limit {
        return Err(Error::Memory {
            what: what.to_owned(),
            needed_mib: bytes.div_ceil(1 << 20),
            limit_mib: limit >> 20,
            advice: "use a smaller grid or image, or raise the limit with --memory".into(),
        });
    }
    Ok(())
}
