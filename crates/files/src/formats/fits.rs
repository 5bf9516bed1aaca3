//! FITS: images with units, pixel scale and certificate; cubes as input.
//!
//! Own code, small on purpose: input is not trusted, so sizes are checked before anything is allocated, and output
//! needs one cube, its keywords and nothing else. Source: FITS standard 4.0 (2018, doi 10.5281/zenodo.3660299 text),
//! §3.3, §4.4, §8.

use std::io::{BufReader, Read, SeekFrom};

use super::fits_cards::{BLOCK, CARD, Cards};
use super::gather::Gather;
use super::numbers::{Number, Stored};
use super::{Kept, Member, Reader, Request, Writer, checked_shape, three_axes};
use barnard::data::{Array, Axis, Choose, Frame, Layout, Numbers, Part};
use barnard::error::{Error, Result};
use barnard::image::{Image, PixelScale, Samples};

pub(super) const READER: Reader = Reader {
    extensions: &["fits", "fit", "fts"],
    summary: "FITS image HDU, three axes",
    array: Some(array),
    members: Some(members),
    image: Some(image),
};
pub(super) const WRITER: Writer =
    Writer { extension: "fits", summary: "one image HDU a band: BUNIT, pixel scale, passband, certificate", encode };

/// More header blocks than any real file has.
const MAX_HEADER_BLOCKS: usize = 4096;
/// HDUs that are looked at.
const MAX_HDUS: usize = 1000;

/// What axes are that are no lengths, and the first part of their CTYPE. Source: FITS standard 4.0, tables 23, 25 and 28.
const OTHER_AXES: [(&str, &[&str]); 6] = [
    ("place on the sky", &["RA", "DEC", "GLON", "GLAT", "ELON", "ELAT", "SLON", "SLAT", "HLON", "HLAT"]),
    ("velocity", &["VRAD", "VOPT", "VELO", "FELO", "BETA", "ZOPT"]),
    ("frequency", &["FREQ"]),
    ("wavelength", &["WAVE", "AWAV", "WAVN"]),
    ("photon energy", &["ENER"]),
    ("state of polarisation", &["STOKES"]),
];

/// Header cards as text, keyword first.
struct Header {
    cards: Vec<(String, String)>,
    /// The position at which the data begin.
    data: u64,
}

impl Header {
    fn read(request: &mut Request, start: u64) -> Result<Self> {
        let path = request.path;
        let broken = |reason: &str| Error::file(path, format!("is no valid FITS file: {reason}"));
        let mut cards = Vec::new();
        for block in 0..MAX_HEADER_BLOCKS {
            let from = start + (block * BLOCK) as u64;
            let bytes = request.bytes(from, BLOCK)?.ok_or_else(|| broken("the header is truncated, no END card"))?;
            for card in bytes.chunks_exact(CARD) {
                let text = String::from_utf8_lossy(card).into_owned();
                let keyword: String = text.chars().take(8).collect::<String>().trim().to_owned();
                if keyword == "END" {
                    return Ok(Self { cards, data: from + BLOCK as u64 });
                }
                if text.chars().nth(8) == Some('=') {
                    cards.push((keyword, value_of(&text.chars().skip(10).collect::<String>())));
                }
            }
        }
        Err(broken("the header has no end"))
    }

    fn text(&self, keyword: &str) -> Option<&str> {
        self.cards.iter().find(|(k, _)| k == keyword).map(|(_, v)| v.as_str())
    }

    fn number(&self, keyword: &str) -> Option<f64> {
        self.text(keyword)?.replace(['D', 'd'], "E").parse().ok()
    }

    fn integer(&self, keyword: &str) -> Option<i64> {
        self.text(keyword)?.parse().ok()
    }

    /// Lengths of the axes, the fastest first.
    fn axes(&self) -> Option<Vec<u64>> {
        let count = self.integer("NAXIS").filter(|n| (0..=9).contains(n))?;
        (1..=count).map(|i| self.integer(&format!("NAXIS{i}")).and_then(|n| u64::try_from(n).ok())).collect()
    }

    /// Numbers, from one on, and lengths of the axes that are longer than one, the fastest first.
    fn squeezed(&self) -> Vec<(usize, u64)> {
        self.axes().unwrap_or_default().into_iter().enumerate().map(|(i, n)| (i + 1, n)).filter(|(_, n)| *n != 1).collect()
    }

    /// The sort of table that people take for an image, in words; none for an image.
    fn table(&self) -> Option<String> {
        if self.text("XTENSION") != Some("BINTABLE") {
            return None;
        }
        let name = self.text("EXTNAME").map_or(String::new(), |n| format!(" \"{n}\""));
        Some(match (self.text("ZIMAGE"), self.text("PIXTYPE")) {
            (Some("T"), _) => format!(
                "HDU{name} is a tile-compressed image (ZCMPTYPE {}): unpack the file with funpack first",
                self.text("ZCMPTYPE").unwrap_or("unknown")
            ),
            (_, Some("HEALPIX")) => format!(
                "HDU{name} is a HEALPix map of the sky (NSIDE {}), which has no depth: make a grid of it first",
                self.text("NSIDE").unwrap_or("unknown")
            ),
            _ => format!("HDU{name} is a table"),
        })
    }

    /// What the header says of the values and, where they are linear and along the array's own axes, of the axes.
    fn frame(&self) -> Frame {
        let written = |keyword: &str| self.text(keyword).map(str::trim).filter(|t| !t.is_empty()).map(str::to_owned);
        let matrix = |i: usize, j: usize| self.number(&format!("CD{i}_{j}")).or_else(|| self.number(&format!("PC{i}_{j}")));
        let count = self.axes().map_or(0, |a| a.len());
        let rotated = (1..=count).any(|i| self.number(&format!("CROTA{i}")).is_some_and(|v| v != 0.0));
        let turned = |i: usize| rotated || (1..=count).filter(|j| *j != i).any(|j| matrix(i, j).is_some_and(|v| v != 0.0));
        let axis = |i: usize| {
            let scale = self.number(&format!("PC{i}_{i}")).unwrap_or(1.0);
            let step = self.number(&format!("CD{i}_{i}")).or_else(|| Some(scale * self.number(&format!("CDELT{i}"))?))?;
            let reference = self.number(&format!("CRPIX{i}")).unwrap_or(0.0);
            let first = self.number(&format!("CRVAL{i}")).unwrap_or(0.0) + (1.0 - reference) * step;
            let usable = step.is_finite() && step != 0.0 && first.is_finite() && !turned(i);
            usable.then(|| Axis { unit: written(&format!("CUNIT{i}")).unwrap_or_default(), step, first })
        };
        let mut frame = Frame { order: "zyx", unit: written("BUNIT"), ..Frame::default() };
        // Indices run the other way.
        for (slot, (i, _)) in self.squeezed().into_iter().take(3).enumerate() {
            frame.axes[2 - slot] = axis(i);
            let kind = self.text(&format!("CTYPE{i}")).unwrap_or("");
            let other = OTHER_AXES.iter().find(|(_, kinds)| kinds.iter().any(|own| kind.split('-').next() == Some(*own)));
            frame.others[2 - slot] = other.map(|(what, _)| format!("{what} (CTYPE{i} {kind})"));
        }
        frame
    }

    /// The bytes of the data, padded to blocks.
    fn data_bytes(&self) -> Option<u64> {
        let axes = self.axes()?;
        let size = self.integer("BITPIX")?.unsigned_abs() / 8;
        let (parameters, groups) = (self.integer("PCOUNT").unwrap_or(0).max(0) as u64, self.integer("GCOUNT").unwrap_or(1).max(0) as u64);
        let cells = if axes.is_empty() { Some(0) } else { axes.iter().try_fold(1u64, |n, a| n.checked_mul(*a)) }?;
        let bytes = cells.checked_add(parameters)?.checked_mul(groups)?.checked_mul(size)?;
        bytes.checked_next_multiple_of(BLOCK as u64)
    }
}

/// The value of a card: text without quotes, anything else up to the comment.
fn value_of(field: &str) -> String {
    let field = field.trim();
    if let Some(quoted) = field.strip_prefix('\'') {
        return quoted.split('\'').next().unwrap_or("").trim_end().to_owned();
    }
    field.split('/').next().unwrap_or("").trim().to_owned()
}

/// Reads the headers of all HDUs of the file.
fn headers(request: &mut Request) -> Result<Vec<Header>> {
    let magic = b"SIMPLE  =";
    if request.bytes(0, magic.len())?.is_none_or(|own| own != magic) {
        return Err(Error::file(request.path, "is no FITS file: it does not begin with SIMPLE"));
    }
    let mut headers = Vec::new();
    let mut start = 0u64;
    while start.saturating_add(BLOCK as u64) <= request.length && headers.len() < MAX_HDUS {
        let header = Header::read(request, start)?;
        let next = header.data_bytes().and_then(|n| header.data.checked_add(n));
        let next = next.ok_or_else(|| Error::file(request.path, "BITPIX or NAXIS are missing or impossible"))?;
        headers.push(header);
        start = next;
    }
    if headers.is_empty() {
        return Err(Error::file(request.path, "is truncated: its first header does not end"));
    }
    Ok(headers)
}

/// What is meant of the pixel values of an HDU of this shape, scaled by BSCALE and BZERO; blank integers are NaN.
fn values<T: Kept>(request: &mut Request, header: &Header, shape: [usize; 3], part: &Part) -> Result<Vec<T>> {
    let (path, bitpix) = (request.path, header.integer("BITPIX").unwrap_or(0));
    let size = (bitpix.unsigned_abs() / 8) as usize;
    let kind = match bitpix {
        8 => Number::Uint(size),
        16 | 32 | 64 => Number::Int(size),
        -32 | -64 => Number::Float(size),
        _ => return Err(Error::file(path, format!("BITPIX = {bitpix} is none of 8, 16, 32, 64, -32, -64"))),
    };
    let stored = Stored { kind, big_endian: true };
    let (there, cells) = (request.length.saturating_sub(header.data), shape.iter().product::<usize>());
    if cells.checked_mul(size).is_none_or(|announced| announced as u64 > there) {
        return Err(Error::file(path, format!("is truncated: {cells} values of {size} bytes announced, {there} bytes there")));
    }
    let (scale, zero) = (header.number("BSCALE").unwrap_or(1.0), header.number("BZERO").unwrap_or(0.0));
    let blank = header.integer("BLANK").filter(|_| bitpix > 0).map(|blank| blank as f64);
    let value = |v: T| T::of(if Some(v.number()) == blank { f64::NAN } else { zero + scale * v.number() });
    let mut gather = Gather::new(part, false, path, request.memory_limit)?;
    let failed = |e| Error::file(path, format!("cannot be read: {e}"));
    request.source.seek(SeekFrom::Start(header.data)).map_err(failed)?;
    let mut reader = BufReader::with_capacity(1 << 16, &mut *request.source);
    let mut at = 0;
    gather.rows(shape, stored, value, |from, bytes| {
        reader.seek_relative((from - at) as i64).and_then(|()| reader.read_exact(bytes)).map_err(failed)?;
        at = from + bytes.len() as u64;
        Ok(())
    })?;
    Ok(gather.finish())
}

fn array(request: &mut Request, choose: Choose) -> Result<Array> {
    let headers = headers(request)?;
    let squeezed = |h: &Header| h.squeezed().into_iter().map(|(_, n)| n).collect::<Vec<u64>>();
    let header = match request.part {
        Some(part) => {
            let number: Option<usize> = part.parse().ok();
            let by_name = |h: &&Header| h.text("EXTNAME") == Some(part);
            number.and_then(|n| headers.get(n)).or_else(|| headers.iter().find(by_name)).ok_or_else(|| {
                Error::file(request.path, format!("has no HDU \"{part}\"; it has {} (0 to {})", headers.len(), headers.len() - 1))
            })?
        }
        None => {
            let cubes: Vec<usize> = (0..headers.len()).filter(|i| squeezed(&headers[*i]).len() == 3).collect();
            if cubes.len() > 1 {
                let reason = format!("holds {} cubes (HDUs {cubes:?}); choose one with array = \"{}\"", cubes.len(), cubes[0]);
                return Err(Error::file(request.path, reason));
            }
            &headers[cubes.first().copied().unwrap_or(0)]
        }
    };
    let tables = if squeezed(header).is_empty() { headers.iter().find_map(Header::table) } else { header.table() };
    if let Some(what) = tables {
        return Err(Error::file(request.path, format!("{what}; a grid is an image HDU of three axes")));
    }
    // FITS lists the fastest axis first; indices in C order run the other way.
    let mut shape = squeezed(header);
    shape.reverse();
    let (shape, _) = three_axes(request.path, &shape)?;
    let part = choose(&Layout { shape, frame: Some(header.frame()) })?;
    // What is scaled may need more digits than are stored.
    let is_scaled = ["BSCALE", "BZERO"].iter().any(|key| header.number(key).is_some());
    let data = match header.integer("BITPIX") {
        Some(8 | 16 | -32) if !is_scaled => Numbers::Single(values::<f32>(request, header, shape, &part)?.into()),
        _ => Numbers::Double(values::<f64>(request, header, shape, &part)?.into()),
    };
    Ok(Array { shape: part.shape(), data, fortran: false })
}

fn members(request: &mut Request) -> Result<Vec<Member>> {
    let headers = headers(request)?;
    let of = |(number, header): (usize, &Header)| {
        let kind = header.table().unwrap_or_else(|| match header.squeezed().len() {
            0 => "no data".into(),
            axes => format!("image of {axes} axes longer than one"),
        });
        let mut facts = vec![("kind", kind)];
        let fact = |what, key: &str| header.text(key).filter(|text| !text.trim().is_empty()).map(|text| (what, text.trim().to_owned()));
        facts.extend(fact("name", "EXTNAME"));
        if header.table().is_none() && !header.squeezed().is_empty() {
            facts.push(("axes", super::edges(header.axes().unwrap_or_default()) + ", the fastest first"));
            facts.extend(fact("type", "BITPIX").map(|(what, bits)| (what, format!("BITPIX {bits}"))));
            facts.extend(fact("unit", "BUNIT"));
            for (axis, letter) in
                header.frame().axes.iter().rev().zip(["x", "y", "z"]).filter_map(|(axis, letter)| Some((axis.as_ref()?, letter)))
            {
                facts.push((letter, super::steps(axis)));
            }
        }
        Member { name: number.to_string(), facts }
    };
    Ok(headers.iter().enumerate().map(of).collect())
}

fn image(request: &mut Request) -> Result<Image> {
    let headers = headers(request)?;
    let mut bands = Vec::new();
    let (mut size, mut data, mut double) = (None, Vec::new(), false);
    for header in headers.iter().filter(|h| h.axes().is_some_and(|a| a.len() == 2)) {
        let axes = header.axes().unwrap_or_default();
        let (shape, _) = checked_shape(request.path, request.memory_limit, &[1, axes[1], axes[0]])?;
        if *size.get_or_insert((axes[0], axes[1])) != (axes[0], axes[1]) {
            return Err(Error::file(request.path, "holds images of different sizes"));
        }
        double |= header.integer("BITPIX") == Some(-64);
        bands.push(header.text("EXTNAME").map_or_else(|| super::nameless(bands.len()), str::to_owned));
        // The first row of FITS is the lowest.
        let values: Vec<f64> = values(request, header, shape, &Layout { shape, frame: None }.whole())?;
        data.extend(values.chunks(axes[0] as usize).rev().flatten().copied());
    }
    let (width, height) = size.ok_or_else(|| Error::file(request.path, "holds no two-dimensional image"))?;
    let samples = if double { Samples::Double(data) } else { Samples::Single(data.iter().map(|v| *v as f32).collect()) };
    Ok(Image::bare(width as usize, height as usize, bands, samples))
}

fn encode(image: &Image) -> Result<Vec<u8>> {
    let mut primary = Cards::default();
    primary.value("SIMPLE", "T", "conforms to FITS standard");
    primary.value("BITPIX", 8, "no data in this HDU");
    primary.value("NAXIS", 0, "the bands follow as IMAGE extensions");
    primary.value("EXTEND", "T", "");
    primary.text("CREATOR", &format!("Barnard {}", env!("CARGO_PKG_VERSION")), "spectral renderer of nebulae");
    primary.text("DATE", &super::now(), "UTC, when the file was written");
    image.keywords.iter().for_each(|keyword| primary.keyword(keyword));
    for (key, value) in &image.notes {
        primary.history(&format!("{key}: {value}"));
    }
    let mut bytes = primary.finish();
    for band in 0..image.bands.len() {
        bytes.extend(header_of(image, band));
        // The first row of FITS is the lowest.
        for row in (0..image.height).rev() {
            for column in 0..image.width {
                match &image.samples {
                    Samples::Single(_) => bytes.extend((image.at(band, row, column) as f32).to_be_bytes()),
                    Samples::Double(_) => bytes.extend(image.at(band, row, column).to_be_bytes()),
                }
            }
        }
        bytes.resize(bytes.len().next_multiple_of(BLOCK), 0);
    }
    Ok(bytes)
}

fn header_of(image: &Image, index: usize) -> Vec<u8> {
    let band = &image.bands[index];
    let mut cards = Cards::default();
    cards.text("XTENSION", "IMAGE", "image extension");
    cards.value("BITPIX", if matches!(image.samples, Samples::Double(_)) { -64 } else { -32 }, "IEEE floating point");
    cards.value("NAXIS", 2, "");
    cards.value("NAXIS1", image.width, "");
    cards.value("NAXIS2", image.height, "");
    cards.value("PCOUNT", 0, "");
    cards.value("GCOUNT", 1, "");
    cards.text("EXTNAME", &super::distinct_names(image)[index], "passband");
    if image.is_error(index) {
        cards.text("BUNIT", "W m-2 sr-1", "standard error of the band radiance");
        cards.text("HDUCLAS2", "ERROR", "standard errors of another HDU");
    } else {
        cards.text("BUNIT", "W m-2 sr-1", "band radiance, integral of R I_lambda");
        cards.text("FILTER", &band.name, "passband");
    }
    if let Some(pivot) = band.pivot_um {
        cards.number("PIVOT", pivot * 1e3, "[nm] pivot wavelength");
    }
    if let Some(width) = band.width_um {
        cards.number("BANDWID", width * 1e3, "[nm] integral of the response R");
    }
    if let Some(counting) = band.counting {
        cards.text("COUNTING", counting, "what the detector counts");
    }
    band.keywords.iter().for_each(|keyword| cards.keyword(keyword));
    wcs(&mut cards, image);
    for line in &band.certificate {
        cards.history(&format!("certificate: {line}"));
    }
    cards.finish()
}

/// A linear frame centred on the axis of view: tangent plane in degrees, or lengths.
fn wcs(cards: &mut Cards, image: &Image) {
    let (kinds, unit, step) = match image.pixel {
        Some(PixelScale::Angle(degrees)) => (["XLON-TAN", "XLAT-TAN"], "deg", degrees),
        Some(PixelScale::Length(pc)) => (["X", "Y"], "pc", pc),
        None => return,
    };
    let middles = [0.5 * (image.width as f64 + 1.0) + image.axis.0, 0.5 * (image.height as f64 + 1.0) + image.axis.1];
    for (i, (kind, middle)) in kinds.iter().zip(middles).enumerate() {
        let axis = i + 1;
        cards.text(&format!("CTYPE{axis}"), kind, "camera frame");
        cards.text(&format!("CUNIT{axis}"), unit, "");
        cards.number(&format!("CRPIX{axis}"), middle, "where the axis of view meets the image");
        cards.number(&format!("CRVAL{axis}"), 0.0, "");
        cards.number(&format!("CDELT{axis}"), step, "pixel scale");
    }
}
