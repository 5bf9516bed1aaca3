//! FITS: images with units, pixel scale and certificate; cubes as input.
//!
//! Own code, small on purpose: input is not trusted, so sizes are checked before anything is allocated, and output
//! needs one cube, its keywords and nothing else. Source: FITS standard 4.0 (2018, doi 10.5281/zenodo.3660299 text),
//! §3.3, §4.4, §8.

mod cards;
mod header;
mod observed;
mod table;
mod tiles;
mod write;

use std::io::{BufReader, Read, SeekFrom};

use self::header::{Header, headers};
pub use self::observed::{ImagePlane, MASK_PREFIX, Observed, Sky, observed, sky_of};
use self::write::encode;
pub(super) use self::write::encode_frame;

use super::gather::Gather;
use super::gzip;
use super::numbers::{Number, Stored};
use super::{Contents, FileFloat, GridWriter, Member, Reader, Request, UNIT_NOTE, Writer, checked_shape, three_axes};
use barnard::data::{Array, ArrayHeader, ArrayPart, Choose, Numbers};
use barnard::error::{Error, Result};
use barnard::image::{Image, Samples};
use spectra::curve::Columns;

pub(super) const READER: Reader = Reader {
    extensions: &["fits", "fit", "fts", "fits.gz", "fit.gz", "fts.gz", "fz"],
    summary: "FITS image HDUs, also tiled or gzipped",
    array: Some(array),
    members: Some(members),
    image: Some(image),
};
pub(super) const WRITER: Writer = Writer {
    extension: "fits",
    is_picture: false,
    has_layers: true,
    summary: "one image HDU per band and layer: BUNIT, pixel scale, passband, certificate",
    encode,
};

pub(super) const GRID_WRITER: GridWriter = GridWriter {
    extension: "fits",
    summary: "cube of singles along x, y and z: CRPIX, CRVAL and CDELT in pc, BUNIT",
    write: write::write_grid,
};

/// The keyword of an HDU that holds a layer of the picture, by the layer's name.
const LAYER: &str = "LAYER";

/// The type of an image's numbers by its BITPIX.
fn stored_of(bitpix: Option<i64>) -> std::result::Result<Stored, String> {
    let kind = match bitpix {
        Some(8) => Number::Uint(1),
        Some(16) => Number::Int(2),
        Some(32) => Number::Int(4),
        Some(64) => Number::Int(8),
        Some(-32) => Number::Float(4),
        Some(-64) => Number::Float(8),
        other => return Err(format!("BITPIX = {} is invalid; it must be 8, 16, 32, 64, -32 or -64", other.unwrap_or(0))),
    };
    Ok(Stored { kind, big_endian: true })
}

/// True if an image has unsigned 64-bit integers, which FITS stores less 2⁶³: double precision would lose their last
/// eleven bits if it added that.
fn is_unsigned_64(header: &Header) -> bool {
    header.bitpix() == Some(64) && header.number("BZERO") == Some(2f64.powi(63)) && header.number("BSCALE").is_none_or(|scale| scale == 1.0)
}

/// Physical value of an image number: scaled by BSCALE and BZERO; blank integers are NaN.
fn value_of<T: FileFloat>(header: &Header) -> impl Fn(f64) -> T + Sync + use<T> {
    let scaled = (header.number("BSCALE").unwrap_or(1.0), header.number("BZERO").unwrap_or(0.0));
    let is_unsigned = is_unsigned_64(header) && !header.is_packed();
    let (scale, zero) = if is_unsigned { (1.0, 0.0) } else { scaled };
    let blank = header.integer("BLANK").filter(|_| header.bitpix() > Some(0)).map(|blank| blank as f64);
    move |v| T::of(if Some(v) == blank { f64::NAN } else { zero + scale * v })
}

/// Selected part of an HDU of this shape, the slowest axis first, whose axes have these numbers in the
/// file.
fn values<T: FileFloat>(
    request: &mut Request,
    header: &Header,
    numbers: [Option<usize>; 3],
    shape: [usize; 3],
    part: &ArrayPart,
) -> Result<Numbers> {
    let path = request.path;
    header.check(path)?;
    let mut stored = stored_of(header.bitpix()).map_err(|reason| Error::file(path, reason))?;
    if is_unsigned_64(header) {
        stored.kind = Number::Biased;
    }
    let mut gather = Gather::new(part, false, path, request.memory_limit)?;
    if header.is_packed() {
        return tiles::gathered(request, header, numbers, gather);
    }
    let (there, cells) = (request.length.saturating_sub(header.data), shape.iter().product::<usize>());
    if cells.checked_mul(stored.size()).is_none_or(|announced| announced as u64 > there) {
        let announced = format!("{cells} values of {} bytes announced", stored.size());
        return Err(Error::file(path, format!("is truncated: {announced}, {there} bytes found")));
    }
    let value = value_of(header);
    let failed = |e| Error::file(path, format!("cannot be read: {e}"));
    request.source.seek(SeekFrom::Start(header.data)).map_err(failed)?;
    let mut reader = BufReader::with_capacity(1 << 16, &mut *request.source);
    let mut at = 0;
    gather.rows(
        shape,
        stored,
        |v: T| value(v.number()),
        |from, bytes| {
            reader.seek_relative((from - at) as i64).and_then(|()| reader.read_exact(bytes)).map_err(failed)?;
            at = from + bytes.len() as u64;
            Ok(())
        },
    )?;
    gather.finish()
}

fn array(request: &mut Request, choose: Choose) -> Result<Array> {
    gzip::unpacked(request)?;
    let headers = headers(request)?;
    let squeezed = |h: &Header| h.squeezed().into_iter().map(|(_, n)| n).collect::<Vec<u64>>();
    let header = match request.part {
        Some(part) => &headers[hdu(request.path, &headers, part)?],
        None => {
            let cubes: Vec<usize> = (0..headers.len()).filter(|i| squeezed(&headers[*i]).len() == 3).collect();
            if cubes.len() > 1 {
                let reason = format!("has {} cubes (HDUs {cubes:?}); select one with array = \"{}\"", cubes.len(), cubes[0]);
                return Err(Error::file(request.path, reason));
            }
            &headers[cubes.first().copied().unwrap_or(0)]
        }
    };
    let tables = if squeezed(header).is_empty() { headers.iter().find_map(Header::table) } else { header.table() };
    if let Some(what) = tables {
        return Err(Error::file(request.path, format!("{what}; a grid requires an image HDU of three axes")));
    }
    // FITS lists the fastest axis first; indices in C order run the other way.
    let mut axes = header.squeezed();
    axes.reverse();
    let (shape, _) = three_axes(request.path, &axes.iter().map(|(_, length)| *length).collect::<Vec<_>>())?;
    header.check(request.path)?;
    let numbers = std::array::from_fn(|i| Some(axes[i].0));
    let part = choose(&ArrayHeader { shape, frame: Some(header.frame()) })?;
    // What is scaled may need more digits than are stored.
    let is_scaled = ["BSCALE", "BZERO"].iter().any(|key| header.number(key).is_some());
    let data = match header.bitpix() {
        Some(8 | 16 | -32) if !is_scaled => values::<f32>(request, header, numbers, shape, &part)?,
        _ => values::<f64>(request, header, numbers, shape, &part)?,
    };
    Ok(Array { shape: part.shape(), data, fortran: false })
}

/// The HDU of a name, in any case, or of a number.
fn hdu(path: &std::path::Path, headers: &[Header], wanted: &str) -> Result<usize> {
    let number = wanted.parse::<usize>().ok().filter(|number| *number < headers.len());
    let by_name =
        || headers.iter().position(|header| header.text("EXTNAME").is_some_and(|name| name.trim().eq_ignore_ascii_case(wanted.trim())));
    number
        .or_else(by_name)
        .ok_or_else(|| Error::file(path, format!("has no HDU \"{wanted}\"; it has {} (0 to {})", headers.len(), headers.len() - 1)))
}

/// The image of the HDU that the request names, or of the first that has one: columns and rows, and its values, the
/// first row on top.
pub(super) fn picture(request: &mut Request) -> Result<([usize; 2], Vec<f64>)> {
    gzip::unpacked(request)?;
    let headers = headers(request)?;
    let is_image = |header: &Header| header.axes().is_some_and(|axes| axes.len() == 2) && header.table().is_none();
    let number = match request.part {
        Some(wanted) => Some(hdu(request.path, &headers, wanted)?).filter(|number| is_image(&headers[*number])),
        None => headers.iter().position(is_image),
    };
    let number = number.ok_or_else(|| Error::file(request.path, "has no 2-D image there"))?;
    let mut values = Vec::new();
    let (width, height) = planes(request, &headers[number..=number], |_| true, |_, plane| values = plane)?;
    Ok(([width, height], values))
}

/// The columns of the first table of a file, or of the HDU that the request names.
///
/// # Errors
/// If the file has no such table, or its cells are no single numbers.
pub fn columns(request: &mut Request) -> Result<Columns> {
    gzip::unpacked(request)?;
    let path = request.path;
    let headers = headers(request)?;
    let is_table = |header: &Header| header.text("XTENSION") == Some("BINTABLE") && !header.is_packed();
    let number = match request.part {
        Some(wanted) => Some(hdu(path, &headers, wanted)?).filter(|number| is_table(&headers[*number])),
        None => headers.iter().position(is_table),
    };
    let number = number.ok_or_else(|| Error::file(path, "has no binary table; add one with a column of wavelengths"))?;
    let header = &headers[number];
    header.check(path)?;
    let table = table::FitsTable::of(header).map_err(|reason| Error::file(path, reason))?;
    let cells = table.read(request, header)?;
    table.columns(header, &cells).map_err(|reason| Error::file(path, format!("HDU {number}: {reason}")))
}

fn members(request: &mut Request) -> Result<Vec<Member>> {
    gzip::unpacked(request)?;
    let headers = headers(request)?;
    let plane = |(number, header): (usize, &Header)| {
        let (contents, kind) = match (header.table(), header.squeezed().len()) {
            // Pixels of a map are no columns of a curve or catalogue.
            (Some(kind), _) if header.text("PIXTYPE") == Some("HEALPIX") => (Contents::Nothing, kind),
            (Some(kind), _) => (Contents::Columns, kind),
            (None, 0) => (Contents::Nothing, "no data".into()),
            (None, axes) => (Contents::Numbers, format!("image of {axes} axes longer than one")),
        };
        let mut facts = vec![("kind", kind)];
        let fact = |what, key: &str| header.text(key).filter(|text| !text.trim().is_empty()).map(|text| (what, text.trim().to_owned()));
        facts.extend(fact("name", "EXTNAME"));
        facts.extend(header.broken().map(|broken| ("broken", broken.to_owned())));
        if contents == Contents::Numbers {
            facts.push(("axes", super::edges(header.axes().unwrap_or_default()) + ", the fastest first"));
            facts.extend(header.bitpix().map(|bits| ("type", format!("BITPIX {bits}"))));
            facts.extend(fact("packed", "ZCMPTYPE").map(|(what, packing)| (what, format!("in tiles by {packing}"))));
            facts.extend(fact("unit", "BUNIT"));
            let frame = header.frame();
            for (letter, name) in [("x", 'x'), ("y", 'y'), ("z", 'z')] {
                let slot = frame.order.find(name).unwrap_or(0);
                facts.extend(frame.others[slot].as_ref().map(|other| (letter, format!("no length: {other}"))));
                facts.extend(frame.axes[slot].as_ref().filter(|_| frame.others[slot].is_none()).map(|axis| (letter, super::steps(axis))));
            }
            facts.extend(frame.problem.map(|problem| ("frame", problem)));
        }
        Member { name: number.to_string(), contents, facts }
    };
    Ok(headers.iter().enumerate().map(plane).collect())
}

fn image(request: &mut Request) -> Result<Image> {
    gzip::unpacked(request)?;
    let headers = headers(request)?;
    let (mut bands, mut data, mut double, mut unit) = (Vec::new(), Vec::new(), false, None);
    // What a picture is made of stands behind it.
    let (width, height) = planes(
        request,
        &headers,
        |header| header.text(LAYER).is_none(),
        |(_, header), values| {
            double |= header.bitpix() == Some(-64);
            let words = header.text("BUNIT").map(|words| [words, header.text("MAGSYS").unwrap_or_default()].join(" ").trim().to_owned());
            unit = unit.take().or(words.filter(|words| !words.is_empty()));
            bands.push(header.text("EXTNAME").map_or_else(|| super::nameless(bands.len()), str::to_owned));
            data.extend(values);
        },
    )?;
    let samples = if double { Samples::Double(data) } else { Samples::Single(data.iter().map(|v| *v as f32).collect()) };
    let notes = unit.map(|unit| (UNIT_NOTE.to_owned(), unit)).into_iter().collect();
    Ok(Image { notes, ..Image::bare(width, height, bands, samples) })
}

/// Reads the images of two axes whose headers are wanted: `take` gets the number of each HDU and its header with its values, the first row on top. All have one
/// size, which is given.
fn planes(
    request: &mut Request,
    headers: &[Header],
    is_wanted: impl Fn(&Header) -> bool,
    mut take: impl FnMut((usize, &Header), Vec<f64>),
) -> Result<(usize, usize)> {
    let mut size = None;
    let is_plane = |(_, header): &(usize, &Header)| header.axes().is_some_and(|axes| axes.len() == 2) && is_wanted(header);
    for (number, (hdu, header)) in headers.iter().enumerate().filter(is_plane).enumerate() {
        let axes = header.axes().unwrap_or_default();
        // All so far count.
        checked_shape(request.path, request.memory_limit, &[number as u64 + 1, axes[1], axes[0]])?;
        let (shape, _) = three_axes(request.path, &[1, axes[1], axes[0]])?;
        if *size.get_or_insert((axes[0], axes[1])) != (axes[0], axes[1]) {
            return Err(Error::file(request.path, "has images of different sizes"));
        }
        let whole = ArrayHeader { shape, frame: None }.whole();
        let values = values::<f64>(request, header, [None, Some(2), Some(1)], shape, &whole)?.doubles();
        let rows = values.chunks(axes[0] as usize);
        take((hdu, header), if header.is_top_down() { values } else { rows.rev().flatten().copied().collect() });
    }
    let (width, height) = size.ok_or_else(|| Error::file(request.path, "has no 2-D image"))?;
    Ok((width as usize, height as usize))
}
