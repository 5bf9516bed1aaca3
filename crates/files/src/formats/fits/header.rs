//! Headers of FITS files, as they are read.

use barnard::data::{Axis, Frame};
use barnard::error::{Error, Result};

use super::cards::{BLOCK, CARD};
use crate::formats::Request;

/// More header blocks than any real file has, of all its HDUs.
const MAX_HEADER_BLOCKS: usize = 16_384;
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
pub struct Header {
    cards: Vec<(String, String)>,
    /// The position at which the data begin.
    pub data: u64,
}

impl Header {
    /// Reads a header of at most so many blocks, of which it takes some away.
    fn read(request: &mut Request, start: u64, blocks: &mut usize) -> Result<Self> {
        let path = request.path;
        let broken = |reason: &str| Error::file(path, format!("is no valid FITS file: {reason}"));
        let mut cards = Vec::new();
        for block in 0..*blocks {
            let from = start + (block * BLOCK) as u64;
            let bytes = request.bytes(from, BLOCK)?.ok_or_else(|| broken("the header is truncated, no END card"))?;
            for card in bytes.chunks_exact(CARD) {
                let text = String::from_utf8_lossy(card).into_owned();
                let keyword: String = text.chars().take(8).collect::<String>().trim().to_owned();
                if keyword == "END" {
                    *blocks -= block + 1;
                    return Ok(Self { cards, data: from + BLOCK as u64 });
                }
                if text.chars().nth(8) == Some('=') {
                    cards.push((keyword, value_of(&text.chars().skip(10).collect::<String>())));
                }
            }
        }
        Err(broken(&format!("its headers have more than {MAX_HEADER_BLOCKS} blocks")))
    }

    pub fn text(&self, keyword: &str) -> Option<&str> {
        self.cards.iter().find(|(k, _)| k == keyword).map(|(_, v)| v.as_str())
    }

    pub fn number(&self, keyword: &str) -> Option<f64> {
        self.text(keyword)?.replace(['D', 'd'], "E").parse().ok()
    }

    pub fn integer(&self, keyword: &str) -> Option<i64> {
        self.text(keyword)?.parse().ok()
    }

    /// Whether it is a table that holds an image in tiles.
    pub fn is_packed(&self) -> bool {
        self.text("XTENSION") == Some("BINTABLE") && self.text("ZIMAGE") == Some("T")
    }

    /// Lengths of the axes of its image, the fastest first.
    pub fn axes(&self) -> Option<Vec<u64>> {
        self.lengths(if self.is_packed() { "ZNAXIS" } else { "NAXIS" })
    }

    /// What its image's numbers are: their bits, below zero for floating point.
    pub fn bitpix(&self) -> Option<i64> {
        self.integer(if self.is_packed() { "ZBITPIX" } else { "BITPIX" })
    }

    fn lengths(&self, keyword: &str) -> Option<Vec<u64>> {
        let count = self.integer(keyword).filter(|n| (0..=9).contains(n))?;
        (1..=count).map(|i| self.integer(&format!("{keyword}{i}")).and_then(|n| u64::try_from(n).ok())).collect()
    }

    /// Numbers, from one on, and lengths of the axes that are longer than one, the fastest first.
    pub fn squeezed(&self) -> Vec<(usize, u64)> {
        self.axes().unwrap_or_default().into_iter().enumerate().map(|(i, n)| (i + 1, n)).filter(|(_, n)| *n != 1).collect()
    }

    /// The sort of table that people take for an image, in words; none for an image.
    pub fn table(&self) -> Option<String> {
        if self.text("XTENSION") != Some("BINTABLE") || self.is_packed() {
            return None;
        }
        let name = self.text("EXTNAME").map_or(String::new(), |n| format!(" \"{n}\""));
        Some(match self.text("PIXTYPE") {
            Some("HEALPIX") => format!(
                "HDU{name} is a HEALPix map of the sky (NSIDE {}), which has no depth: make a grid of it first",
                self.text("NSIDE").unwrap_or("unknown")
            ),
            _ => format!("HDU{name} is a table"),
        })
    }

    /// What the header says of the values and, where they are linear and along the array's own axes, of the axes.
    pub fn frame(&self) -> Frame {
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
        // Maps of the Galaxy's dust say their unit elsewhere, and the Sun's place in steps from the lower corner.
        let unit = ["BUNIT", "UNIT", "CUNIT"].into_iter().find_map(written);
        let around_the_sun = |i: usize| {
            let step = self.number("STEP").filter(|step| step.is_finite() && *step > 0.0)?;
            let sun = self.number(["SUN_POSX", "SUN_POSY", "SUN_POSZ"].get(i - 1)?)?;
            Some(Axis { unit: "pc".into(), step, first: (0.5 - sun) * step })
        };
        let mut frame = Frame { order: "zyx", unit, ..Frame::default() };
        // Indices run the other way.
        for (slot, (i, _)) in self.squeezed().into_iter().take(3).enumerate() {
            frame.axes[2 - slot] = axis(i).or_else(|| around_the_sun(i));
            let kind = self.text(&format!("CTYPE{i}")).unwrap_or("");
            let other = OTHER_AXES.iter().find(|(_, kinds)| kinds.iter().any(|own| kind.split('-').next() == Some(*own)));
            frame.others[2 - slot] = other.map(|(what, _)| format!("{what} (CTYPE{i} {kind})"));
        }
        frame
    }

    /// The bytes of the data, padded to blocks.
    fn data_bytes(&self) -> Option<u64> {
        let axes = self.lengths("NAXIS")?;
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
pub fn headers(request: &mut Request) -> Result<Vec<Header>> {
    let magic = b"SIMPLE  =";
    if request.bytes(0, magic.len())?.is_none_or(|own| own != magic) {
        return Err(Error::file(request.path, "is no FITS file: it does not begin with SIMPLE"));
    }
    let mut headers = Vec::new();
    let (mut start, mut blocks) = (0u64, MAX_HEADER_BLOCKS);
    while start.saturating_add(BLOCK as u64) <= request.length && headers.len() < MAX_HDUS {
        let header = Header::read(request, start, &mut blocks)?;
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
