//! Files in and out. A format is one file and one row of [`READERS`] or [`WRITERS`], chosen by the name's extension.

mod avm;
mod clock;
mod colours;
mod exr;
mod fits;
mod gather;
mod gzip;
mod hdf5;
mod jpeg;
mod npy;
mod npz;
mod numbered;
mod numbers;
mod png;
mod tiff;
mod vdb;
mod write;

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

pub use fits::{ImagePlane, MASK_PREFIX, Observed, Sky, columns as fits_columns, observed, sky_of};
pub use gather::part_of;
pub(crate) use npz::{Written, archive, doubles, put, values};
pub use numbered::numbered;
pub use png::encode_png;
pub(crate) use write::replace_by;
pub use write::{SaveImage, check_folder, check_replaceable, check_writable, replace, save_frame, save_grid};

use barnard::data::{Array, Axis, Choose, Numbers};
use barnard::error::{Error, Result};
use barnard::field::Grid;
use barnard::image::{Image, SaveOptions};
use barnard::memory;
use spectra::error::nearest;

/// A precision in which numbers of a file are kept.
pub(crate) trait FileFloat: Copy + Send {
    /// The number that is nearest.
    fn of(value: f64) -> Self;
    /// The number itself.
    fn number(self) -> f64;
    /// Many of them.
    fn numbers(all: Vec<Self>) -> Numbers;
}

impl FileFloat for f32 {
    fn of(value: f64) -> Self {
        value as f32
    }
    fn number(self) -> f64 {
        f64::from(self)
    }
    fn numbers(all: Vec<Self>) -> Numbers {
        Numbers::Single(all.into())
    }
}

impl FileFloat for f64 {
    fn of(value: f64) -> Self {
        value
    }
    fn number(self) -> f64 {
        self
    }
    fn numbers(all: Vec<Self>) -> Numbers {
        Numbers::Double(all.into())
    }
}

/// A source of bytes that can be read from any place.
pub trait Seekable: Read + Seek + Send {}

impl<T: Read + Seek + Send> Seekable for T {}

/// A request to read a file: where its bytes are, how many there are, and which part is meant.
pub struct Request<'a> {
    /// The bytes of the file.
    pub source: Box<dyn Seekable>,
    /// The number of bytes.
    pub length: u64,
    /// The path of the file, for messages.
    pub path: &'a Path,
    /// The array or HDU that is meant.
    pub part: Option<&'a str>,
    /// Most bytes that may be allocated.
    pub memory_limit: u64,
}

impl<'a> Request<'a> {
    /// A request for all of `source`.
    ///
    /// # Errors
    /// If its length is unknown.
    pub fn new(mut source: impl Seekable + 'static, path: &'a Path, part: Option<&'a str>, memory_limit: u64) -> Result<Self> {
        let length = source.seek(SeekFrom::End(0)).map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
        Ok(Self { source: Box::new(source), length, path, part, memory_limit })
    }

    /// So many bytes from a place on; none where the file ends before.
    fn bytes(&mut self, from: u64, count: usize) -> Result<Option<Vec<u8>>> {
        if from.checked_add(count as u64).is_none_or(|end| end > self.length) {
            return Ok(None);
        }
        let mut bytes = vec![0; count];
        let read = self.source.seek(SeekFrom::Start(from)).and_then(|_| self.source.read_exact(&mut bytes));
        read.map_err(|e| Error::file(self.path, format!("cannot be read: {e}")))?;
        Ok(Some(bytes))
    }

    /// The file from its beginning, buffered.
    fn rewound(&mut self) -> Result<BufReader<&mut dyn Seekable>> {
        self.source.rewind().map_err(|e| Error::file(self.path, format!("cannot be read: {e}")))?;
        Ok(BufReader::with_capacity(1 << 16, &mut *self.source))
    }
}

/// One row of the readers.
pub struct Reader {
    /// The extensions of its files, in lower case.
    pub extensions: &'static [&'static str],
    /// Summary in one line.
    pub summary: &'static str,
    /// Reads what is chosen of a three-dimensional array, where the format holds one.
    pub array: Option<fn(&mut Request, Choose) -> Result<Array>>,
    /// Lists what a file holds, where the format holds arrays.
    pub members: Option<ListMembers>,
    /// Reads an image, where the format holds them.
    pub image: Option<fn(&mut Request) -> Result<Image>>,
}

impl Reader {
    /// True if the reader is for files named like `path`.
    pub fn is_for(&self, path: &Path) -> bool {
        self.extensions.contains(&extension(path).as_str())
    }
}

/// Lists what a file holds.
type ListMembers = fn(&mut Request) -> Result<Vec<Member>>;

/// One array of a file, and what the file says of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// The name by which `array` means it; empty where it has none.
    pub name: String,
    /// Sort of its contents.
    pub contents: Contents,
    /// Description: voxels, type, transform.
    pub facts: Vec<(&'static str, String)>,
}

/// Sort of the contents of a member.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contents {
    /// An array of numbers.
    Numbers,
    /// Columns of a table.
    Columns,
    /// Nothing, or what cannot be read.
    Nothing,
}

/// The note of a picture that was read that says what its values are in: BUNIT of FITS, and the zero point of magnitudes.
pub const UNIT_NOTE: &str = "unit";

/// All formats that can be read.
pub const READERS: &[Reader] = &[npy::READER, npz::READER, fits::READER, hdf5::READER, vdb::READER, exr::READER];

/// One row of the writers.
pub struct Writer {
    /// The extension of its files, in lower case.
    pub extension: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// True if it is what a display shows, and no radiance.
    pub is_picture: bool,
    /// True if it holds the layers of an image.
    pub has_layers: bool,
    /// The image as the bytes of a file.
    pub encode: fn(&Image, &SaveOptions) -> Result<Vec<u8>>,
}

/// All formats that can be written.
pub const WRITERS: &[Writer] = &[
    exr::WRITER,
    fits::WRITER,
    npy::WRITER,
    png::WRITER,
    tiff::writer("tif"),
    tiff::writer("tiff"),
    jpeg::writer("jpg"),
    jpeg::writer("jpeg"),
];

/// A grid as it is written to a file: what it is called, and what its values are in, where that is known.
pub struct GridFile<'a> {
    /// Values, and where they are \[pc\].
    pub grid: &'a Grid,
    /// The unit of the values.
    pub unit: Option<&'a str>,
    /// The name of the grid, for formats that have names.
    pub name: &'a str,
    /// Most bytes that writing may take.
    pub memory_limit: u64,
}

/// One row of the writers of grids.
pub struct GridWriter {
    /// The extension of its files, in lower case.
    pub extension: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// Writes the bytes of a file, a part at a time.
    pub write: fn(&GridFile, &mut dyn Write) -> Result<()>,
}

/// All formats that grids can be written in.
pub const GRID_WRITERS: &[GridWriter] = &[vdb::GRID_WRITER, fits::GRID_WRITER, hdf5::GRID_WRITER, npy::GRID_WRITER];

/// The writer of grids for a path, by its extension.
///
/// # Errors
/// If the extension is none of [`GRID_WRITERS`].
pub fn grid_writer(path: &Path) -> Result<&'static GridWriter> {
    let wanted = extension(path);
    let known: Vec<&str> = GRID_WRITERS.iter().map(|w| w.extension).collect();
    GRID_WRITERS.iter().find(|w| w.extension == wanted).ok_or_else(|| no_writer(path, &wanted, &known))
}

/// The error for a path that nothing is written to.
fn no_writer(path: &Path, wanted: &str, known: &[&str]) -> Error {
    let known = known.iter().map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(", ");
    if wanted.is_empty() {
        return Error::file(path, format!("has no extension; use one of {known}"));
    }
    let hint =
        nearest(wanted, known.split(", ").map(|extension| &extension[1..])).map(|n| format!(", did you mean .{n}?")).unwrap_or_default();
    Error::file(path, format!("cannot write \".{wanted}\"{hint}; known: {known}"))
}

/// The error of a writer whose bytes find no place.
fn failed(error: std::io::Error) -> Error {
    Error::Encoding { format: "grid", reason: error.to_string() }
}

/// File extension, or behind the one before where that is how a file was packed.
fn extension(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let mut parts = name.rsplit('.');
    match (parts.next(), parts.next()) {
        (Some("gz"), Some(inner)) => format!("{inner}.gz"),
        (Some(last), Some(_)) => last.to_owned(),
        _ => String::new(),
    }
}

/// The writer for a path, by its extension.
///
/// # Errors
/// If the extension is none of [`WRITERS`].
pub fn writer(path: &Path) -> Result<&'static Writer> {
    let wanted = extension(path);
    let known: Vec<&str> = WRITERS.iter().map(|w| w.extension).collect();
    WRITERS.iter().find(|w| w.extension == wanted).ok_or_else(|| no_writer(path, &wanted, &known))
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

/// Reads what `choose` chooses of a three-dimensional array; `part` names the array or HDU, `memory_limit` is in bytes.
///
/// # Errors
/// If the extension is none of [`READERS`], the file is broken, or it does not fit, and those of `choose`.
pub fn read_array(source: impl Seekable + 'static, path: &Path, part: Option<&str>, choose: Choose, memory_limit: u64) -> Result<Array> {
    let read = reader(path, |r| r.array.is_some())?.array;
    read.map_or_else(|| Err(Error::file(path, "holds no grid")), |read| read(&mut Request::new(source, path, part, memory_limit)?, choose))
}

/// Variant of a file.
///
/// # Errors
/// If it cannot be opened, and those of [`read_array`].
pub fn read_file(path: &Path, part: Option<&str>, choose: Choose, memory_limit: u64) -> Result<Array> {
    read_array(open(path)?, path, part, choose, memory_limit)
}

/// Contents of a file of arrays, and a line about its format; values are not read.
///
/// # Errors
/// If its extension is that of no format of arrays, it cannot be opened, or it is broken.
pub fn members(path: &Path, memory_limit: u64) -> Result<(&'static str, Vec<Member>)> {
    let read = reader(path, |r| r.members.is_some())?;
    let list = read.members.ok_or_else(|| Error::file(path, "holds no arrays"))?;
    Ok((read.summary, list(&mut Request::new(open(path)?, path, None, memory_limit)?)?))
}

/// Lengths of axes as people write them.
fn edges(shape: impl IntoIterator<Item = impl std::fmt::Display>) -> String {
    shape.into_iter().map(|n| n.to_string()).collect::<Vec<_>>().join(" x ")
}

/// The steps of an axis as people read them.
fn steps(axis: &Axis) -> String {
    format!("step {} {unit}, the first at {} {unit}", axis.step, axis.first, unit = axis.unit)
}

/// The error of a file that cannot be opened; of a missing one it names the nearest file in its folder.
pub fn unreadable(path: &Path, error: &std::io::Error) -> Error {
    if error.kind() != std::io::ErrorKind::NotFound {
        return Error::file(path, format!("cannot be read: {error}"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Error::file(path, format!("does not exist, nor does its folder {}", folder.display()));
    };
    let names: Vec<String> = entries.flatten().take(MOST_ENTRIES).map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let hint = nearest(&name, names.iter().map(String::as_str)).map(|near| format!("; did you mean \"{near}\"?")).unwrap_or_default();
    Error::file(path, format!("does not exist{hint}"))
}

/// Entries of a folder that a missing file's name is compared with.
const MOST_ENTRIES: usize = 10_000;

/// Opens a file that is one.
pub(crate) fn open(path: &Path) -> Result<File> {
    let failed = |e: std::io::Error| unreadable(path, &e);
    // Asked before it is opened: a pipe waits for whoever writes.
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        let reason = "is not seekable; copy a pipe into a file first (scenes and tables may be pipes)";
        return Err(Error::file(path, reason));
    }
    File::open(path).map_err(failed)
}

/// Reads an image that was written before.
///
/// # Errors
/// If it cannot be opened, is no image, or does not fit.
pub fn read_image(path: &Path, memory_limit: u64) -> Result<Image> {
    let read = reader(path, |r| r.image.is_some())?;
    let image = read.image.ok_or_else(|| Error::file(path, "has no image; compare .npy, .fits or .exr"))?;
    image(&mut Request::new(open(path)?, path, None, memory_limit)?)
}

/// The picture of one band that a file holds: columns and rows, and values from the upper left corner. Of a FITS file
/// that is the image `hdu` by name or number, the first one without it; of any other file the first band.
///
/// # Errors
/// Errors of [`read_image`], and if the file has no such HDU.
pub fn read_picture(path: &Path, hdu: Option<&str>, memory_limit: u64) -> Result<([usize; 2], Vec<f64>)> {
    if reader(path, |r| r.image.is_some())?.extensions == fits::READER.extensions {
        return fits::picture(&mut Request::new(open(path)?, path, hdu, memory_limit)?);
    }
    if let Some(hdu) = hdu {
        return Err(Error::file(path, format!("is not a FITS file; remove hdu = \"{hdu}\"")));
    }
    let image = read_image(path, memory_limit)?;
    Ok(([image.width, image.height], image.band(0).collect()))
}

/// The shape as three axes and its number of values, after checks of rank and emptiness.
fn three_axes(path: &Path, shape: &[u64]) -> Result<([usize; 3], u64)> {
    let &[a, b, c] = shape else {
        return Err(Error::file(path, format!("the array has {} axes ({shape:?}); a grid requires three", shape.len())));
    };
    let cells = a.checked_mul(b).and_then(|n| n.checked_mul(c)).filter(|n| *n > 0);
    let cells = cells.ok_or_else(|| Error::file(path, format!("the array's shape {shape:?} is empty or invalid")))?;
    Ok(([a as usize, b as usize, c as usize], cells))
}

/// Variant that checks the required memory first.
fn checked_shape(path: &Path, memory_limit: u64, shape: &[u64]) -> Result<([usize; 3], usize)> {
    let (shape, cells) = three_axes(path, shape)?;
    memory::check(&format!("the array of {}", path.display()), cells.saturating_mul(4), memory_limit)?;
    Ok((shape, cells as usize))
}

/// Bytes of a compressed stream of known length; `kind` names the compression.
fn exactly(stream: impl Read, size: usize, kind: &str) -> std::result::Result<Vec<u8>, String> {
    let mut bytes = Vec::with_capacity(size);
    // One byte too many reveals a stream that is too long.
    stream.take(size as u64 + 1).read_to_end(&mut bytes).map_err(|e| format!("its {kind} stream is corrupt: {e}"))?;
    if bytes.len() != size {
        let more = if bytes.len() > size { "more than " } else { "" };
        return Err(format!("its {kind} stream has {more}{} bytes, expected {size}", bytes.len().min(size)));
    }
    Ok(bytes)
}

/// The name of band `index` in a file that knows no names.
pub fn nameless(index: usize) -> String {
    format!("band{index}")
}

/// Text in the characters that FITS cards and EXR attributes have: Greek letters by their names, anything else that is
/// not ASCII as a question mark.
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
        let name = ascii(&band.label());
        let numbered = std::iter::once(name.clone()).chain((2..).map(|i| format!("{name}_{i}")));
        names.extend(numbered.into_iter().find(|n| !names.contains(n)));
    }
    names
}
