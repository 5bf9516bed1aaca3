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
#[derive(Debug)]
pub struct Array {
    /// Lengths of the axes, in the file's order of indices.
    pub shape: [usize; 3],
    /// The values, in the file's order.
    pub data: Vec<f64>,
    /// Whether the first index runs fastest.
    pub fortran: bool,
    /// What the file itself says of its values and axes, where it was FITS, whose customs for axes differ.
    pub frame: Option<Frame>,
}

/// What a file says of an array's values and axes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Frame {
    /// Unit of the values, as it is written.
    pub unit: Option<String>,
    /// The axes in the order of the array's indices, where their steps are known.
    pub axes: [Option<Axis>; 3],
}

/// One linear axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Unit of its coordinate, as it is written; empty where nothing is.
    pub unit: String,
    /// From one element to the next, in that unit.
    pub step: f64,
    /// Coordinate of the middle of the first element.
    pub first: f64,
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
    pub array: Option<fn(&Request) -> Result<Array>>,
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

/// The reader of a path among those that can `serve`, by its extension.
fn reader(path: &Path, serve: fn(&Reader) -> bool) -> Result<&'static Reader> {
    let wanted = extension(path);
    let able = || READERS.iter().filter(|r| serve(r));
    able().find(|r| r.extensions.contains(&wanted.as_str())).ok_or_else(|| {
        let known: Vec<&str> = able().flat_map(|r| r.extensions.iter().copied()).collect();
        Error::file(path, format!("cannot read \".{wanted}\" here; known: .{}", known.join(", .")))
    })
}

/// Reads a three-dimensional array; `part` names the array or HDU, `memory_limit` is in bytes.
pub fn read_array(bytes: &[u8], path: &Path, part: Option<&str>, memory_limit: u64) -> Result<Array> {
    let read = reader(path, |r| r.array.is_some())?.array;
    read.map_or_else(|| Err(Error::file(path, "holds no grid")), |read| read(&Request { bytes, path, part, memory_limit }))
}

/// Reads an image that was written before.
pub fn read_image(path: &Path, memory_limit: u64) -> Result<Image> {
    let read = reader(path, |r| r.image.is_some())?;
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

/// Text in the characters that FITS cards and EXR attributes have: Greek letters by their names, anything else that is not ASCII as a question mark.
pub(crate) fn ascii(text: &str) -> String {
    const GREEK: [&str; 25] = [
        "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu", "xi", "omicron", "pi",
        "rho", "sigma", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega",
    ];
    let letter = |c: char| match c {
        ' '..='~' => c.to_string(),
        'α'..='ω' => GREEK[c as usize - 'α' as usize].to_owned(),
        'Α'..='Ω' => {
            let name = GREEK[c as usize - 'Α' as usize];
            name[..1].to_uppercase() + &name[1..]
        }
        'µ' => "u".into(),
        'Å' => "Angstrom".into(),
        '−' | '–' | '—' => "-".into(),
        '×' => "x".into(),
        c if c.is_whitespace() => " ".into(),
        _ => "?".into(),
    };
    text.chars().map(letter).collect()
}

/// The names of an image's bands in ASCII, no two the same: a number follows where two would be.
pub(crate) fn distinct_names(image: &Image) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for band in &image.bands {
        let name = ascii(&band.name);
        let numbered = std::iter::once(name.clone()).chain((2..).map(|i| format!("{name}_{i}")));
        names.extend(numbered.into_iter().find(|n| !names.contains(n)));
    }
    names
}

/// The time now as ISO 8601 has it, in UTC: 2026-11-22T21:09:33.
pub(crate) fn now() -> String {
    jiff::Timestamp::now().strftime("%Y-%m-%dT%H:%M:%S").to_string()
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
