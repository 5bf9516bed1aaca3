//! Datasets of three axes.
//!
//! The file's structure is read by the crate `hdf5-reader`; what is meant of a dataset is read by blocks of whole chunks,
//! so that no more of it is ever in memory.

mod filters;
mod frame;
mod slabs;
mod source;

use std::collections::BTreeSet;

use barnard::data::{Array, ArrayHeader, Choose};
use barnard::error::{Error, Result};
use barnard::memory;
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions};
use spectra::error::nearest;

use self::frame::DatasetPlace;
use self::slabs::Slabs;
use self::source::SharedFile;
use crate::formats::gather::Gather;
use crate::formats::numbers::{Number, Stored};
use crate::formats::{Contents, Member, Request, edges, steps, three_axes};

/// Elements that may be there without a byte for them, and others for each byte of the file.
const NEVER_WRITTEN: u64 = 1 << 32;
const MOST_PACKED: u64 = 1 << 12;
/// Groups within groups at most.
const DEEPEST: usize = 32;
/// Datasets that are listed at most.
const MOST: usize = 10_000;

pub fn array(request: &mut Request, choose: Choose) -> Result<Array> {
    let (path, limit) = (request.path, request.memory_limit);
    let file = opened(request)?;
    let found = match request.part {
        Some(name) => named(&file, name).map_err(|reason| Error::file(path, reason))?,
        None => only(&file).map_err(|reason| Error::file(path, reason))?,
    };
    let wrong = |reason: String| Error::file(path, format!("dataset \"{}\": {reason}", found.path));
    let stored = stored(&found.dataset).map_err(wrong)?;
    let long = long_axes(found.dataset.shape());
    let [a, b, c] = long[..] else {
        return Err(wrong(format!("it has the axes {}; a grid requires three that are longer than one", edges(found.dataset.shape()))));
    };
    let shape = [a, b, c].map(|axis| found.dataset.shape()[axis]);
    let (_, cells) = three_axes(path, &shape).map_err(|e| wrong(e.to_string()))?;
    // Chunks that were never written take nothing in the file, and time to read all the same.
    if cells > NEVER_WRITTEN.saturating_add(request.length.saturating_mul(MOST_PACKED)) {
        return Err(wrong(format!("it has {cells} elements in a file of {} bytes: almost none were written", request.length)));
    }
    let shape = shape.map(|n| n as usize);
    let place = DatasetPlace::of(&found);
    let part = choose(&ArrayHeader { shape, frame: Some(place.frame([a, b, c], shape)) })?;
    // A chunk is inflated as a whole.
    if let Some(chunk) = found.dataset.chunks() {
        let bytes = chunk.iter().fold(stored.size() as u64, |bytes, edge| bytes.saturating_mul(u64::from(*edge)));
        memory::check(&format!("a chunk of {}", path.display()), bytes, limit)?;
    }
    let packing = place.packing();
    let is_single = stored.is_single() && packing.is_plain();
    let slabs = Slabs::new(&found.dataset, stored, [a, b, c], packing);
    let data = if is_single {
        slabs.gathered::<f32>(Gather::new(&part, false, path, limit)?, limit).map_err(wrong)?.finish()?
    } else {
        slabs.gathered::<f64>(Gather::new(&part, false, path, limit)?, limit).map_err(wrong)?.finish()?
    };
    Ok(Array { shape: part.shape(), data, fortran: false })
}

pub fn members(request: &mut Request) -> Result<Vec<Member>> {
    let path = request.path;
    let file = opened(request)?;
    let Listing { found: all, unreadable } = datasets(&file).map_err(|reason| Error::file(path, reason))?;
    let dataset = |found: &FoundDataset| {
        let dataset = &found.dataset;
        let kind =
            stored(dataset).map_or_else(|_| format!("{}, which are unsupported", name_of(dataset.dtype())), |stored| stored.to_string());
        let shape = if dataset.shape().is_empty() { "a single value".into() } else { edges(dataset.shape()) };
        let mut facts = vec![("shape", shape), ("type", kind)];
        facts.extend(dataset.chunks().map(|chunk| ("chunks", edges(&chunk))));
        let place = DatasetPlace::of(found);
        facts.extend(place.unit().map(|unit| ("unit", unit)));
        if let [a, b, c] = long_axes(dataset.shape())[..] {
            let frame = place.frame([a, b, c], [a, b, c].map(|axis| dataset.shape()[axis] as usize));
            facts.push(("axes", format!("{}, the slowest first", frame.order)));
            for (letter, axis) in frame.order.chars().zip(&frame.axes) {
                let letter = ["x", "y", "z"][(letter as usize - 'x' as usize).min(2)];
                facts.extend(axis.as_ref().map(|axis| (letter, steps(axis))));
            }
        }
        Member { name: found.path.clone(), contents: Contents::Numbers, facts }
    };
    let unread =
        unreadable.into_iter().map(|(name, reason)| Member { name, contents: Contents::Nothing, facts: vec![("unreadable", reason)] });
    let mut members: Vec<Member> = all.iter().map(dataset).chain(unread).collect();
    members.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(members)
}

/// Versions of classic netCDF: the byte behind "CDF".
const CLASSIC_NETCDF: [(u8, &str); 3] = [(1, "classic"), (2, "64-bit offset"), (5, "64-bit data")];

/// The beginning of MAT-files that are not HDF5.
const OLD_MATLAB: &[u8] = b"MATLAB 5.0 MAT-file";

/// Refuses netCDF files and MAT-files that are not HDF5.
fn refuse_classic(request: &mut Request) -> Result<()> {
    if request.bytes(0, OLD_MATLAB.len())?.is_some_and(|bytes| bytes == OLD_MATLAB) {
        return Err(Error::file(request.path, "is a MATLAB 5 file, which is unsupported; save it with \"-v7.3\""));
    }
    let Some(magic) = request.bytes(0, 4)?.filter(|bytes| bytes.starts_with(b"CDF")) else { return Ok(()) };
    let variant = CLASSIC_NETCDF.iter().find(|(version, _)| *version == magic[3]).map_or("unknown variant", |(_, name)| name);
    let reason = format!(
        "is a netCDF 3 file ({variant}), which is unsupported; convert it with \"nccopy -k nc4 IN OUT\", or write it with format=\"NETCDF4\""
    );
    Err(Error::file(request.path, reason))
}

/// The file of a request, which owns its bytes from then on.
fn opened(request: &mut Request) -> Result<Hdf5File> {
    refuse_classic(request)?;
    let most = usize::try_from(request.memory_limit).unwrap_or(usize::MAX);
    // Blocks are read once, so nothing is worth keeping.
    let options = OpenOptions::default()
        .with_chunk_cache_bytes(0)
        .with_max_chunk_bytes(most)
        .with_max_read_bytes(most)
        .with_filter_registry(filters::registry(most));
    let source = std::mem::replace(&mut request.source, Box::new(std::io::empty()));
    let file = Hdf5File::from_storage_with_options(SharedFile::shared(source, request.length), options);
    let file = file.map_err(|e| Error::file(request.path, format!("is not a readable HDF5 file: {e}")))?;
    let stated = file.superblock().eof_address;
    if stated > request.length {
        return Err(Error::file(request.path, format!("is truncated: its superblock states {stated} bytes, {} found", request.length)));
    }
    Ok(file)
}

/// A dataset, where it is, and the groups that it is in, the outermost first.
struct FoundDataset {
    path: String,
    dataset: Dataset,
    groups: Vec<Group>,
}

/// The datasets of a file.
#[derive(Default)]
struct Listing {
    found: Vec<FoundDataset>,
    /// Paths of those that cannot be read, and why.
    unreadable: Vec<(String, String)>,
}

/// The reason why a dataset cannot be opened, in the words of the HDF5 manual.
fn unreadable(error: &hdf5_reader::error::Error) -> String {
    match cause(error) {
        hdf5_reader::error::Error::UnsupportedLayoutClass(3) => {
            "is a virtual dataset, which is unsupported; read its source files, or copy it with \"h5repack -l CONTI\"".into()
        }
        other => other.to_string(),
    }
}

/// An error without the paths around it.
fn cause(error: &hdf5_reader::error::Error) -> &hdf5_reader::error::Error {
    match error {
        hdf5_reader::error::Error::Context { source, .. } => cause(source),
        other => other,
    }
}

/// All datasets of a file, by their paths.
fn datasets(file: &Hdf5File) -> std::result::Result<Listing, String> {
    fn within(groups: &[Group], path: &str, seen: &mut BTreeSet<u64>, listing: &mut Listing) -> std::result::Result<(), String> {
        let Some(group) = groups.last() else { return Ok(()) };
        // Links may lead back to a group that holds them.
        if !seen.insert(group.address()) || groups.len() > DEEPEST {
            return Ok(());
        }
        let unlisted = |e| format!("group \"{path}/\" cannot be listed; select a dataset with array = \"...\": {e}");
        let (inner, names) = group.member_names().map_err(unlisted)?;
        for name in names {
            if listing.found.len() + listing.unreadable.len() == MOST {
                return Err(format!("has more than {MOST} datasets; select one with array = \"...\""));
            }
            let path = format!("{path}/{name}");
            match group.dataset(&name) {
                Ok(dataset) => listing.found.push(FoundDataset { path, dataset, groups: groups.to_vec() }),
                Err(error) => listing.unreadable.push((path, unreadable(&error))),
            }
        }
        for name in inner {
            let path = format!("{path}/{name}");
            match group.group(&name) {
                Ok(group) => within(&[groups, &[group]].concat(), &path, seen, listing)?,
                Err(error) => listing.unreadable.push((path, unreadable(&error))),
            }
        }
        Ok(())
    }
    let root = file.root_group().map_err(|e| format!("has no readable root group: {e}"))?;
    let mut listing = Listing::default();
    within(&[root], "", &mut BTreeSet::new(), &mut listing)?;
    listing.found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(listing)
}

/// The dataset at a path such as "/gas/density".
fn named(file: &Hdf5File, name: &str) -> std::result::Result<FoundDataset, String> {
    let parts: Vec<&str> = name.split('/').filter(|part| !part.is_empty()).collect();
    let mut groups = vec![file.root_group().map_err(|e| format!("has no readable root group: {e}"))?];
    let missing = |reason: String| match datasets(file) {
        Ok(Listing { found: all, .. }) => {
            let near = nearest(name, all.iter().map(|found| found.path.as_str())).map(|near| format!("did you mean \"{near}\"? "));
            format!("has no dataset \"{name}\" ({reason}): {}it has {}", near.unwrap_or_default(), listed(&all))
        }
        Err(_) => format!("has no dataset \"{name}\": {reason}"),
    };
    let Some((last, outer)) = parts.split_last() else { return Err(missing("the path is empty".into())) };
    for part in outer {
        let next = groups[groups.len() - 1].group(part).map_err(|e| missing(e.to_string()))?;
        groups.push(next);
    }
    let dataset = groups[groups.len() - 1].dataset(last).map_err(|e| match cause(&e) {
        hdf5_reader::error::Error::UnsupportedLayoutClass(_) => format!("dataset \"{name}\" {}", unreadable(&e)),
        _ => missing(e.to_string()),
    })?;
    Ok(FoundDataset { path: format!("/{}", parts.join("/")), dataset, groups })
}

/// The only dataset that can be a grid.
fn only(file: &Hdf5File) -> std::result::Result<FoundDataset, String> {
    let Listing { found: mut all, unreadable } = datasets(file)?;
    let able: Vec<usize> =
        (0..all.len()).filter(|i| stored(&all[*i].dataset).is_ok() && long_axes(all[*i].dataset.shape()).len() == 3).collect();
    match able[..] {
        [index] => Ok(all.swap_remove(index)),
        [] if all.is_empty() && unreadable.is_empty() => Err("holds no datasets".into()),
        [] => {
            let broken = unreadable.iter().map(|(path, reason)| format!("; \"{path}\" {reason}")).collect::<String>();
            Err(format!("has no dataset of real numbers with three axes; it has {}{broken}", listed(&all)))
        }
        _ => {
            let able: Vec<String> = able.iter().map(|i| format!("\"{}\"", all[*i].path)).collect();
            Err(format!("has {} datasets of three axes ({}); select one with array = \"...\"", able.len(), few(&able)))
        }
    }
}

fn listed(all: &[FoundDataset]) -> String {
    let dataset = |found: &FoundDataset| {
        let why = stored(&found.dataset).err().map_or_else(String::new, |why| format!(", {why}"));
        format!("\"{}\" ({}{why})", found.path, edges(found.dataset.shape()))
    };
    let names: Vec<String> = all.iter().map(dataset).collect();
    if names.is_empty() { "none".into() } else { few(&names) }
}

/// Names as a list that is no longer than people read.
fn few(names: &[String]) -> String {
    const READ: usize = 12;
    let more = if names.len() > READ { format!(" and {} more", names.len() - READ) } else { String::new() };
    names.iter().take(READ).cloned().collect::<Vec<_>>().join(", ") + &more
}

/// The axes of an array: those that are longer than one where there are more than three.
fn long_axes(shape: &[u64]) -> Vec<usize> {
    (0..shape.len()).filter(|axis| shape.len() == 3 || shape[*axis] != 1).collect()
}

/// The type of a dataset's numbers, or what is wrong with it.
fn stored(dataset: &Dataset) -> std::result::Result<Stored, String> {
    let stored = slabs::stored(dataset.dtype());
    let stored = stored.ok_or_else(|| format!("has {}, which are unsupported; write floats of 4 or 8 bytes", name_of(dataset.dtype())))?;
    // Numbers may be laid out in any way within their bytes; those of IEEE 754, and whole ones that fill them, are read.
    let message = dataset.raw_datatype().map_err(|e| e.to_string())?;
    let bits = 8 * stored.size() as u8;
    let (expected, others) = match stored.kind {
        Number::Float(size) => (ieee_754(size).to_vec(), "floats other than IEEE 754"),
        _ => (vec![0, 0, bits, 0], "integers with padding bits"),
    };
    if message.get(LAYOUT..).is_none_or(|found| !found.starts_with(&expected)) {
        return Err(format!("has {others} ({} bytes), which are unsupported; write floats of 4 or 8 bytes", stored.size()));
    }
    Ok(stored)
}

/// Where the layout of a number stands in the message of its type.
const LAYOUT: usize = 8;

/// Bit offset, precision, place and size of the exponent, place and size of the mantissa, and bias. Source: HDF5 File
/// Format Specification 3.0, §IV.A.2.d.
fn ieee_754(size: usize) -> [u8; 12] {
    let (mantissa, exponent, bias): (u8, u8, u32) = match size {
        2 => (10, 5, 15),
        4 => (23, 8, 127),
        _ => (52, 11, 1023),
    };
    let [b0, b1, b2, b3] = bias.to_le_bytes();
    [0, 0, 8 * size as u8, 0, mantissa, exponent, 0, mantissa, b0, b1, b2, b3]
}

/// A type in words.
fn name_of(kind: &Datatype) -> String {
    match kind {
        Datatype::FixedPoint { size, .. } => format!("integers of {size} bytes"),
        Datatype::FloatingPoint { size, .. } if *size > 8 => format!("floats of {size} bytes (long double)"),
        Datatype::FloatingPoint { size, .. } => format!("floats of {size} bytes"),
        Datatype::String { .. } => "texts".into(),
        Datatype::Compound { .. } => "records (a compound type)".into(),
        Datatype::Array { .. } => "arrays".into(),
        Datatype::Enum { .. } => "enumerated values (such as bool of h5py)".into(),
        Datatype::VarLen { .. } => "lists of variable length".into(),
        Datatype::Opaque { .. } => "opaque bytes".into(),
        Datatype::Reference { .. } => "references".into(),
        Datatype::Bitfield { .. } => "bit fields".into(),
    }
}
