//! NumPy's `.npz`: archives of `.npy` arrays.

use std::io::{BufReader, Cursor, Read, Seek, Write};
use std::path::Path;

use npyz::WriterBuilder;

use super::npy::{self, NpyRequest, Stream};
use super::{FileFloat, Member, Reader, Request, Seekable};
use barnard::data::{Array, Choose};
use barnard::error::{Error, Result};
use barnard::memory;

pub(super) const READER: Reader =
    Reader { extensions: &["npz"], summary: "archive of NumPy arrays", array: Some(read), members: Some(members), image: None };

fn read(request: &mut Request, choose: Choose) -> Result<Array> {
    of_member(request, |stream| npy::array(stream, choose))
}

fn members(request: &mut Request) -> Result<Vec<Member>> {
    let (path, memory_limit) = (request.path, request.memory_limit);
    let mut archive = opened(request)?;
    let names = names(&archive);
    let member = |name: String| {
        let entry = entry(&mut archive, &name, path)?;
        let asked = NpyRequest { path, memory_limit, length: entry.size() };
        let open = Stream { asked, reader: Box::new(entry) }.open()?;
        Ok(npy::member(name, &open))
    };
    names.into_iter().map(member).collect()
}

/// An archive in the bytes of a request.
type Archive<'r> = zip::ZipArchive<BufReader<&'r mut dyn Seekable>>;

fn opened<'r>(request: &'r mut Request) -> Result<Archive<'r>> {
    let path = request.path;
    zip::ZipArchive::new(request.rewound()?).map_err(|e| Error::file(path, format!("is not an .npz archive: {e}")))
}

/// The arrays of an archive.
fn names(archive: &Archive) -> Vec<String> {
    archive.file_names().filter_map(|n| Some(n.ok()?.strip_suffix(".npy")?.to_owned())).collect()
}

fn entry<'a, 'r>(archive: &'a mut Archive<'r>, name: &str, path: &Path) -> Result<zip::read::ZipFile<'a, BufReader<&'r mut dyn Seekable>>> {
    archive.by_name(&format!("{name}.npy")).map_err(|e| Error::file(path, format!("array {name}: {e}")))
}

/// Result of `read` for the selected array of an archive, which is inflated as it is read.
fn of_member<T>(request: &mut Request, read: impl FnOnce(Stream) -> Result<T>) -> Result<T> {
    let (path, part, memory_limit) = (request.path, request.part, request.memory_limit);
    let mut archive = opened(request)?;
    let names = names(&archive);
    let name = match part {
        Some(part) => names.iter().find(|n| *n == part).cloned().ok_or_else(|| {
            let message = format!("has no array \"{part}\"; it has {}", names.join(", "));
            Error::file(path, message)
        })?,
        None if names.len() == 1 => names[0].clone(),
        None => {
            return Err(Error::file(path, format!("has {} arrays ({}); select one with array = \"...\"", names.len(), names.join(", "))));
        }
    };
    let mut entry = entry(&mut archive, &name, path)?;
    // The stated size may lie: no more is ever inflated.
    let stated = entry.size();
    let corrupt = |reason: String| Error::file(path, format!("array {name} is corrupt: {reason}"));
    let mut member = entry.by_ref().take(stated);
    let asked = NpyRequest { path, memory_limit, length: stated };
    let made = read(Stream { asked, reader: Box::new(&mut member) })?;
    // The archive's checksum is looked at where an entry ends, and not before.
    std::io::copy(&mut member, &mut std::io::sink()).map_err(|e| corrupt(e.to_string()))?;
    match entry.read(&mut [0]) {
        Ok(0) => Ok(made),
        Ok(_) => Err(corrupt(format!("it exceeds the {stated} bytes stated by the archive"))),
        Err(e) => Err(corrupt(e.to_string())),
    }
}

/// The shape and the values of an array of an archive, in C order, in a precision that holds them.
pub(crate) fn values<T: FileFloat>(request: &mut Request) -> Result<(Vec<u64>, Vec<T>)> {
    of_member(request, |stream| {
        let mut array = stream.open()?;
        let shape = array.shape.clone();
        let cells = shape.iter().try_fold(1u64, |n, edge| n.checked_mul(*edge)).unwrap_or(u64::MAX);
        memory::check(
            &format!("an array of {}", array.asked.path.display()),
            cells.saturating_mul(size_of::<T>() as u64),
            array.asked.memory_limit,
        )?;
        if array.fortran {
            return Err(Error::file(array.asked.path, "is in Fortran order; write it in C order"));
        }
        Ok((shape, array.all(cells as usize)?))
    })
}

/// Variant as doubles.
pub(crate) fn doubles(request: &mut Request) -> Result<(Vec<u64>, Vec<f64>)> {
    values(request)
}

/// Numbers of an array that is written.
pub(crate) enum Written<'a> {
    Doubles(&'a [f64]),
    Singles(&'a [f32]),
    Halves(&'a [half::f16]),
    Words(&'a [u16]),
    Bytes(&'a [u8]),
}

/// Writes an array of an archive under its name, which is not compressed where `compressed` is false.
pub(crate) fn put(
    zip: &mut zip::ZipWriter<impl Write + Seek>,
    name: &str,
    shape: &[u64],
    values: &Written,
    compressed: bool,
) -> std::io::Result<()> {
    let method = if compressed { zip::CompressionMethod::Deflated } else { zip::CompressionMethod::Stored };
    let options = zip::write::SimpleFileOptions::default().compression_method(method).large_file(!compressed);
    zip.start_file(format!("{name}.npy"), options).map_err(std::io::Error::other)?;
    macro_rules! write {
        ($values:expr, $type:ty) => {{
            let mut writer = npyz::WriteOptions::<$type>::new().default_dtype().shape(shape).writer(zip).begin_nd()?;
            writer.extend($values.iter().copied())?;
            writer.finish()
        }};
    }
    match values {
        Written::Doubles(values) => write!(values, f64),
        Written::Singles(values) => write!(values, f32),
        Written::Halves(values) => write!(values, half::f16),
        Written::Words(values) => write!(values, u16),
        Written::Bytes(values) => write!(values, u8),
    }
}

/// An archive of arrays of doubles, each with its name and shape.
pub(crate) fn archive(arrays: &[(&str, &[u64], Vec<f64>)]) -> Result<Vec<u8>> {
    let failed = |e: &dyn std::fmt::Display| Error::Encoding { format: "npz", reason: e.to_string() };
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, shape, data) in arrays {
        put(&mut zip, name, shape, &Written::Doubles(data), true).map_err(|e| failed(&e))?;
    }
    Ok(zip.finish().map_err(|e| failed(&e))?.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A single bit of the values that is flipped is seen, whichever it is.
    #[test]
    fn archives_are_held_to_their_checksums() {
        let values: Vec<f64> = (0..16).map(f64::from).collect();
        let whole = archive(&[("sums", &[16], values.clone())]).unwrap();
        let doubles =
            |bytes: &[u8]| super::doubles(&mut Request::new(Cursor::new(bytes.to_vec()), Path::new("a.npz"), Some("sums"), 1 << 30)?);
        assert_eq!(doubles(&whole).unwrap().1, values);
        // Behind the local header, its name and its extra field, up to the archive's directory.
        let first = 30 + "sums.npy".len() + usize::from(whole[28]);
        let directory = whole.windows(4).rposition(|w| w == b"PK\x01\x02").unwrap();
        assert!(directory > first + 100);
        let mut seen = 0;
        for byte in first..directory {
            let mut damaged = whole.clone();
            damaged[byte] ^= 4;
            // Some bits mean nothing, such as those of a length that the directory has as well; then the values are
            // those that were written.
            match doubles(&damaged) {
                Ok(read) => assert_eq!(read.1, values, "{byte}"),
                Err(_) => seen += 1,
            }
        }
        assert!(seen > (directory - first) / 2, "{seen} of {}", directory - first);
    }
}
