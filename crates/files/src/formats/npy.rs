//! NumPy's `.npy`.
//!
//! Reading checks the header against the bytes that are there before anything is allocated. Images are bands × height ×
//! width.

use std::io::{Cursor, Read, Write};
use std::ops::Range;
use std::path::Path;

use npyz::{DType, Endianness, NpyFile, Order, TypeChar, WriterBuilder};

use super::gather::Gather;
use super::numbers::{Number, Stored};
use super::{Contents, FileFloat, GridFile, GridWriter, Member, Reader, Request, Writer, checked_shape, failed, three_axes};
use barnard::data::{Array, ArrayHeader, ArrayPart, Choose, Numbers};
use barnard::error::{Error, Result};
use barnard::image::{Image, Samples, SaveOptions};

pub(super) const READER: Reader = Reader {
    extensions: &["npy"],
    summary: "NumPy array of floats or integers",
    array: Some(read),
    members: Some(members),
    image: Some(image),
};
pub(super) const WRITER: Writer = Writer {
    extension: "npy",
    is_picture: false,
    has_layers: false,
    summary: "NumPy array, bands x height x width, first row on top, radiance in W m-2 sr-1",
    encode,
};

pub(super) const GRID_WRITER: GridWriter = GridWriter {
    extension: "npy",
    summary: "NumPy array of singles along x, y and z (Fortran order: x runs fastest), without box and unit",
    write: write_grid,
};

/// By x, y and z, as arrays are read that say nothing else.
fn write_grid(file: &GridFile, out: &mut dyn Write) -> Result<()> {
    let [nx, ny, nz] = file.grid.lattice().dims;
    let options = npyz::WriteOptions::<f32>::new().default_dtype().shape(&[nx, ny, nz].map(|n| n as u64)).order(npyz::Order::Fortran);
    let mut writer = options.writer(out).begin_nd().map_err(failed)?;
    let mut row = vec![0.0; nx];
    for (y, z) in (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))) {
        file.grid.row(0..nx, y, z, &mut row);
        writer.extend(row.iter().copied()).map_err(failed)?;
    }
    writer.finish().map_err(failed)
}

fn read(request: &mut Request, choose: Choose) -> Result<Array> {
    if let Some(part) = request.part {
        return Err(Error::file(request.path, format!("has one array without a name; remove array = \"{part}\"")));
    }
    array(Stream::of(request)?, choose)
}

pub(super) fn array(stream: Stream, choose: Choose) -> Result<Array> {
    let array = stream.open()?;
    let (shape, _) = three_axes(array.asked.path, &array.shape)?;
    let part = choose(&ArrayHeader { shape, frame: None })?;
    let fortran = array.fortran;
    let data = if array.stored.is_single() { array.part::<f32>(&part)? } else { array.part::<f64>(&part)? };
    Ok(Array { shape: part.shape(), data, fortran })
}

fn members(request: &mut Request) -> Result<Vec<Member>> {
    Ok(vec![member(String::new(), &Stream::of(request)?.open()?)])
}

pub(super) fn member(name: String, array: &Open) -> Member {
    let order = if array.fortran { "Fortran: the first index runs fastest" } else { "C: the last index runs fastest" };
    Member {
        name,
        contents: Contents::Numbers,
        facts: vec![("shape", super::edges(&array.shape)), ("type", array.stored.to_string()), ("order", order.into())],
    }
}

const MAGIC: &[u8] = b"\x93NUMPY";
/// The bytes of a header at most, as NumPy itself has it (`max_header_size`).
const LONGEST_HEADER: usize = 10_000;
/// The depth to which brackets of a header may nest: a dictionary, the list of a record's fields, a field, its shape.
const DEEPEST_HEADER: usize = 6;

/// Where the dictionary begins, and the length that it claims: it stands behind magic, version and length, two bytes of
/// it in version 1, four later.
fn placed(bytes: &[u8]) -> (usize, usize) {
    let little_endian = |range: Range<usize>| {
        let stored = bytes.get(range).unwrap_or(&[]);
        stored.iter().rev().fold(0usize, |n, byte| n << 8 | usize::from(*byte))
    };
    if bytes.get(6) == Some(&1) { (10, little_endian(8..10)) } else { (12, little_endian(8..12)) }
}

/// Refuses what no array of numbers needs before it is parsed: a parser that tries again at every bracket takes for
/// ever.
fn check_header(bytes: &[u8]) -> Result<(), String> {
    let (start, length) = placed(bytes);
    let rest = bytes.get(start..).unwrap_or(&[]);
    let header = &rest[..length.min(rest.len())];
    if length > LONGEST_HEADER {
        return Err(format!("the .npy header has {length} bytes; at most {LONGEST_HEADER} are supported"));
    }
    let mut depth = 0usize;
    for byte in header {
        match byte {
            b'[' | b'{' | b'(' => depth += 1,
            b']' | b'}' | b')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > DEEPEST_HEADER {
            return Err(format!("the .npy header nests more than {DEEPEST_HEADER} brackets"));
        }
    }
    Ok(())
}

/// Blanks the `L` behind whole numbers, as Python 2 wrote shapes: `(4L, 6L)`.
fn without_long_suffixes(head: &mut [u8], start: usize, length: usize) {
    let end = (start + length).min(head.len());
    for i in start + 1..end {
        if head[i] == b'L' && head[i - 1].is_ascii_digit() {
            head[i] = b' ';
        }
    }
}

/// Request without its bytes.
pub(super) struct NpyRequest<'a> {
    /// The path of the file.
    pub path: &'a Path,
    /// Most bytes that may be allocated.
    pub memory_limit: u64,
    /// Bytes of the array, its header among them.
    pub length: u64,
}

/// An array as it is read from its beginning: a file, or a member of an archive.
pub(super) struct Stream<'r> {
    pub asked: NpyRequest<'r>,
    pub reader: Box<dyn Read + 'r>,
}

/// An array whose header was read; its values are what the reader gives next.
pub(super) struct Open<'r> {
    pub asked: NpyRequest<'r>,
    reader: Box<dyn Read + 'r>,
    pub shape: Vec<u64>,
    pub fortran: bool,
    stored: Stored,
}

impl<'r> Stream<'r> {
    fn of(request: &'r mut Request<'_>) -> Result<Self> {
        let asked = NpyRequest { path: request.path, memory_limit: request.memory_limit, length: request.length };
        Ok(Self { asked, reader: Box::new(request.rewound()?) })
    }

    /// The header; a panic-free description of what is wrong with it otherwise.
    pub fn open(self) -> Result<Open<'r>> {
        let Self { asked, mut reader } = self;
        let wrong = |reason: String| Error::file(asked.path, reason);
        let mut head = Vec::new();
        let read = reader.by_ref().take(LONGEST_HEADER as u64 + 16).read_to_end(&mut head);
        read.map_err(|e| wrong(format!("cannot be read: {e}")))?;
        if !head.starts_with(MAGIC) {
            return Err(wrong("is not an .npy array: it does not begin with \\x93NUMPY".into()));
        }
        check_header(&head).map_err(wrong)?;
        let (start, length) = placed(&head);
        without_long_suffixes(&mut head, start, length);
        let file = NpyFile::new(&head[..]).map_err(|e| wrong(format!("the .npy header is corrupt: {e}")))?;
        let (shape, fortran, stored) = (file.shape().to_vec(), file.order() == Order::Fortran, stored(&file.dtype()).map_err(wrong)?);
        let cells = shape.iter().try_fold(1u64, |n, edge| n.checked_mul(*edge)).unwrap_or(u64::MAX);
        let (bytes, there) = (cells.saturating_mul(stored.size() as u64), asked.length.saturating_sub((start + length) as u64));
        if bytes > there {
            return Err(wrong(format!("is truncated: {cells} values of {} bytes announced, {there} bytes found", stored.size())));
        }
        if bytes < there {
            return Err(wrong(format!("has {there} bytes after its header, which announces {cells} values of {} bytes", stored.size())));
        }
        // What was read beyond the header are values.
        let values = head.split_off(start + length);
        Ok(Open { asked, reader: Box::new(Cursor::new(values).chain(reader)), shape, fortran, stored })
    }
}

/// The type of an array's numbers, or what is wrong with it.
fn stored(dtype: &DType) -> Result<Stored, String> {
    let DType::Plain(plain) = dtype else {
        return Err("has records; write a plain array of numbers".into());
    };
    let size = plain.num_bytes().unwrap_or(0);
    let kind = match plain.type_char() {
        TypeChar::Float => Some(Number::Float(size)),
        TypeChar::Int => Some(Number::Int(size)),
        TypeChar::Uint => Some(Number::Uint(size)),
        _ => None,
    };
    let stored = kind.and_then(|kind| Stored::new(kind, plain.endianness() == Endianness::Big));
    stored.ok_or_else(|| format!("has the unsupported type {}; write real numbers", dtype.descr()))
}

impl Open<'_> {
    fn fill(&mut self, bytes: &mut [u8]) -> Result<()> {
        self.reader.read_exact(bytes).map_err(|e| Error::file(self.asked.path, format!("cannot be read: {e}")))
    }

    /// A part of three axes, in the order of the file.
    fn part<T: FileFloat>(mut self, part: &ArrayPart) -> Result<Numbers> {
        let mut shape = three_axes(self.asked.path, &self.shape)?.0;
        if self.fortran {
            shape.reverse();
        }
        let mut gather = Gather::<T>::new(part, self.fortran, self.asked.path, self.asked.memory_limit)?;
        let mut at = 0;
        gather.rows(
            shape,
            self.stored,
            |v| v,
            |from, bytes| {
                self.skip(from - at)?;
                self.fill(bytes)?;
                at = from + bytes.len() as u64;
                Ok(())
            },
        )?;
        gather.finish()
    }

    /// Leaves out some bytes; an archive inflates them for its checksum.
    fn skip(&mut self, count: u64) -> Result<()> {
        let passed = std::io::copy(&mut self.reader.by_ref().take(count), &mut std::io::sink());
        match passed.map_err(|e| Error::file(self.asked.path, format!("cannot be read: {e}")))? {
            passed if passed < count => Err(Error::file(self.asked.path, "was truncated while it was read")),
            _ => Ok(()),
        }
    }

    /// All values, of however many axes.
    pub fn all<T: FileFloat>(&mut self, cells: usize) -> Result<Vec<T>> {
        let mut values = Vec::with_capacity(cells);
        let mut bytes = vec![0; PIECE * self.stored.size()];
        while values.len() < cells {
            let piece = (cells - values.len()).min(PIECE) * self.stored.size();
            self.fill(&mut bytes[..piece])?;
            self.stored.decode(&bytes[..piece], |v| values.push(v));
        }
        Ok(values)
    }
}

/// Values that are read at once.
const PIECE: usize = 1 << 16;

fn image(request: &mut Request) -> Result<Image> {
    let mut array = Stream::of(request)?.open()?;
    let (path, limit) = (array.asked.path, array.asked.memory_limit);
    if array.fortran {
        return Err(Error::file(path, "is in Fortran order; an image of Barnard is bands x height x width in C order"));
    }
    let double = array.stored.size() == 8;
    let mut shape = array.shape.clone();
    if shape.len() == 2 {
        shape.insert(0, 1);
    }
    let ([bands, height, width], cells) = checked_shape(path, limit, &shape)?;
    let data: Vec<f64> = array.all(cells)?;
    let samples = if double { Samples::Double(data) } else { Samples::Single(data.iter().map(|v| *v as f32).collect()) };
    Ok(Image::bare(width, height, (0..bands).map(super::nameless).collect(), samples))
}

fn encode(image: &Image, _: &SaveOptions) -> Result<Vec<u8>> {
    let shape = [image.bands.len() as u64, image.height as u64, image.width as u64];
    let mut bytes = Vec::new();
    macro_rules! write {
        ($data:expr, $type:ty) => {{
            let options = npyz::WriteOptions::<$type>::new().default_dtype().shape(&shape).writer(&mut bytes).begin_nd();
            options.and_then(|mut w| w.extend($data.iter().copied()).and_then(|()| w.finish()))
        }};
    }
    let written = match &image.samples {
        Samples::Single(data) => write!(data, f32),
        Samples::Double(data) => write!(data, f64),
    };
    written.map_err(|e| Error::Encoding { format: "npy", reason: e.to_string() })?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Result<Array> {
        super::read(&mut Request::new(Cursor::new(bytes.to_vec()), Path::new("test.npy"), None, 1 << 30)?, &mut |layout| Ok(layout.whole()))
    }

    /// A version 1 file whose header is `text`.
    fn with_header(text: &str) -> Vec<u8> {
        [MAGIC, &[1, 0], &(text.len() as u16).to_le_bytes(), text.as_bytes()].concat()
    }

    /// Numbers are kept in single precision where that holds them all, whatever type they have in the file.
    #[test]
    fn numbers_keep_their_precision() {
        let parsed = |kind: &str, value: &[u8]| {
            let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (1, 1, 1), }}\n");
            read(&[with_header(&header), value.to_vec()].concat()).unwrap().data
        };
        let largest = i32::MAX - 1;
        assert_eq!(parsed("<f2", &[0x00, 0x3e]), Numbers::Single(vec![1.5].into()));
        assert_eq!(parsed("<f4", &0.1f32.to_le_bytes()), Numbers::Single(vec![0.1].into()));
        assert_eq!(parsed(">i2", &(-300i16).to_be_bytes()), Numbers::Single(vec![-300.0].into()));
        assert_eq!(parsed("<i4", &largest.to_le_bytes()), Numbers::Double(vec![f64::from(largest)].into()));
        assert_eq!(parsed("<f8", &0.1f64.to_le_bytes()), Numbers::Double(vec![0.1].into()));
    }

    /// Headers that a parser would work at for ever are refused; NumPy's own are read.
    #[test]
    fn headers_are_bounded() {
        for bracket in ["[", "{", "("] {
            let deep = read(&with_header(&bracket.repeat(6000))).unwrap_err().to_string();
            assert!(deep.contains("brackets"), "{deep}");
        }
        let long = read(&with_header(&" ".repeat(20_000))).unwrap_err().to_string();
        assert!(long.contains("at most 10000"), "{long}");
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1, 2), }\n";
        let bytes = [with_header(header), 2f64.to_le_bytes().to_vec(), 3f64.to_le_bytes().to_vec()].concat();
        assert_eq!(read(&bytes).unwrap().data, Numbers::Double(vec![2.0, 3.0].into()));
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
    }
}
